//! Cases of the mass-spring system of equations (1) to (3).

use super::bench::SMALL;
use super::{Bench, Case, Seen, case, slow};
use crate::base::flat_mesh::FlatMesh;
use crate::base::limits::{Limit, Limits};
use crate::base::mesh::Mesh;
use crate::base::random::{Purpose, Stream};
use crate::base::vector::DVec3;
use crate::deform::{self, DeformError, Field, Job, Model, Settings, Springs, Step};
use crate::study::numbers::shown;
use crate::study::problems::{hexagon, ovate};
use std::f64::consts::PI;

pub const CASES: &[Case] = &[
    case(
        "D01a",
        "springs of 1e8 N/m, half the critical step, 10,000 steps",
        "energy at most 3 times the start, no trend",
        |_| bounded_energy(1e8, 0.5, 10_000, 0.1),
    ),
    case(
        "D01b",
        "springs of 1e8 N/m, 0.9 of the critical step, 10,000 steps",
        "energy at most 19 times the start, no trend",
        |_| bounded_energy(1e8, 0.9, 10_000, 0.1),
    ),
    case("D02a", "a fixed step ten times too long for this mesh", "error that names the safe step", |bench| {
        let sets = ["deform={model=\"paper\", stiffness=1e8, step=3e-7, shapes=1}"];
        bench.render("d02a", SMALL, &sets).is_refusal(&["deform.step", "at most"])
    }),
    case("D02b", "a fixed step too long for any mesh", "error that names the safe step", |bench| {
        let sets = ["deform={model=\"paper\", stiffness=1e8, step=1e-3, shapes=1}"];
        bench.render("d02b", SMALL, &sets).is_refusal(&["step", "less than"])
    }),
    case(
        "D03",
        "the step left to the program, springs of 1e8 N/m",
        "finite, within 1 % of an eighth of the step",
        |_| converged(),
    ),
    case("D04a", "springs of 1 N/m under their weight", "finite, strain bound holds", |_| heavy(1.0)),
    case("D04b", "springs of 1e-6 N/m under their weight", "finite, strain bound holds", |_| heavy(1e-6)),
    case("D05", "masses of a ratio of 1e4 under a force, 2,000 steps", "momentum is the impulse to 1e-10", |_| {
        impulse()
    }),
    case("D06", "a black mask", "as masses of 0.5 everywhere", |_| black_mask()),
    case("D08", "greys 0, 1 and 255 side by side", "masses 0.5, 0.6931, 5.5452; finite", |_| greys()),
    case("D10", "no stretch allowed", "strain at most 0.01", |_| strain(0.0)),
    case("D11a", "a strain bound of 1e-6", "finite, held to 0.01", |_| strain(1e-6)),
    case("D11b", "a strain bound of 1", "finite, held to 0.01", |_| strain(1.0)),
    case("D11c", "a strain bound of 10", "finite, held to 0.01", |_| strain(10.0)),
    case("D11d", "a strain bound of 1e6: none", "finite, as without equation (2)", |_| strain(1e6)),
    case("D12a", "a strain bound below 0", "error that names the key", |bench| {
        refused(bench, "d12a", "strain_limit", "-0.1")
    }),
    case("D12b", "a strain bound that is no number", "error that names the key", |bench| {
        refused(bench, "d12b", "strain_limit", "nan")
    }),
    case("D14a", "no dryness", "the input, bit by bit", |_| unmoved(&Settings::default(), 0.0)),
    case("D14b", "no force", "the input, bit by bit", |_| unmoved(&Settings { force: 0.0, ..paper() }, 1.0)),
    case("D15a", "a step of 0", "error that names the key", |bench| refused(bench, "d15a", "step", "0.0")),
    case("D15b", "a step below 0", "error that names the key", |bench| refused(bench, "d15b", "step", "-1e-4")),
    case("D15c", "a step that is no number", "error that names the key", |bench| refused(bench, "d15c", "step", "nan")),
    case("D15d", "a step of 1e-300 s", "finite, or error that names the key", |bench| {
        refused(bench, "d15d", "step", "1e-300")
    }),
    case("D15e", "a step of 1e300 s", "error that names the key", |bench| refused(bench, "d15e", "step", "1e300")),
    case("D16a", "no steps", "the input", |_| unmoved(&Settings { steps: 0, ..paper() }, 1.0)),
    slow("D16b", "ten million steps", "finite, strain bound holds, constant memory", |_| many_steps()),
    case("D33", "a million undamped steps", "energy bounded, slope below 1e-9 a step", |_| {
        bounded_energy(40.0, 0.5, 1_000_000, 1e-3)
    }),
    case("D34", "a turning leaf, one turn", "angular momentum to 1e-10, strain as the centrifugal estimate", |_| {
        turning()
    }),
];

fn paper() -> Settings {
    Settings { model: Model::Paper, steps: 500, force: 6e-3, ..Settings::default() }
}

fn job(dryness: f64) -> Job {
    Job { state: "brown".to_owned(), variant: 0, dryness }
}

/// A shape, and its largest strain.
fn shape(settings: &Settings, mesh: &FlatMesh, limits: &Limits) -> Result<(Mesh, f64), DeformError> {
    let (mut shapes, figures) = deform::deform(settings, mesh, &[job(1.0)], 1, limits)?;
    let strain = figures.values.get("max_strain").and_then(serde_json::Value::as_f64).unwrap_or(f64::NAN);
    Ok((shapes.pop().unwrap_or_default(), strain))
}

/// Springs without drag or friction, stirred so that they stretch by about a thousandth.
fn undamped(stiffness: f64, share: f64) -> (Springs, f64) {
    let settings = Settings { stiffness, drag: 0.0, friction: 0.0, ..Settings::default() };
    let mut springs = Springs::new(&settings, &hexagon());
    let step = share * springs.critical_step();
    let speed = 2e-6 / step;
    let mut stream = Stream::new(3, Purpose::Deformation, 0, 0);
    let kicks: Vec<DVec3> = (0..springs.masses().len())
        .map(|_| DVec3::new(stream.range(-speed, speed), stream.range(-speed, speed), 0.0))
        .collect();
    springs.stir(|number, _| kicks[number]);
    (springs, step)
}

fn bounded_energy(stiffness: f64, share: f64, steps: u32, trend: f64) -> Seen {
    let (mut springs, step) = undamped(stiffness, share);
    let start = springs.energy();
    let (mut worst, mut early, mut late) = (0.0f64, 0.0, 0.0);
    for number in 0..steps {
        springs.advance(step, None);
        let now = springs.energy() / start;
        worst = worst.max(now);
        early += if number < steps / 10 { now } else { 0.0 };
        late += if number >= steps - steps / 10 { now } else { 0.0 };
    }
    let drift = (late / early - 1.0).abs();
    let bound = (1.0 + share) / (1.0 - share);
    let observed = format!("largest {worst:.3}, last tenth differs from the first by {}", shown(drift));
    (worst <= bound && drift < trend.max(1e-9 * f64::from(steps)), observed)
}

fn converged() -> Seen {
    let mesh = FlatMesh { held: vec![0, 1, 2], ..hexagon() };
    let auto = Settings { model: Model::Paper, stiffness: 1e8, steps: 4000, ..Settings::default() };
    let limits = Limits::default();
    let figure = |settings: &Settings| deform::deform(settings, &mesh, &[job(1.0)], 1, &limits);
    let Ok((chosen, figures)) = figure(&auto) else { return (false, "refused".to_owned()) };
    let step = figures.values.get("step_s").and_then(serde_json::Value::as_f64).unwrap_or(f64::NAN);
    let fine = Settings { step: Step::Seconds(step / 8.0), steps: 32_000, ..auto };
    let Ok((exact, _)) = figure(&fine) else { return (false, "the finer run was refused".to_owned()) };
    let error = apart(&chosen[0], &exact[0], &mesh);
    (error < 0.01, format!("{} of the deformation apart", shown(error)))
}

/// Difference of two shapes over the deformation of the second.
fn apart(found: &Mesh, exact: &Mesh, mesh: &FlatMesh) -> f64 {
    let square = |(p, q): (&crate::base::vector::Vec3, &crate::base::vector::Vec3)| f64::from((p - q).norm_squared());
    let apart: f64 = found.positions.iter().zip(&exact.positions).map(square).sum();
    let flat = |p: &crate::base::vector::DVec2| crate::base::vector::Vec3::new(p.x as f32, p.y as f32, 0.0);
    let moved: f64 =
        exact.positions.iter().zip(&mesh.positions).map(|(p, q)| f64::from((p - flat(q)).norm_squared())).sum();
    (apart / moved.max(f64::MIN_POSITIVE)).sqrt()
}

fn heavy(stiffness: f64) -> Seen {
    // Of a vertex of 3 mg.
    let settings =
        Settings { stiffness, field: Field::Constant, direction: [0.0, 0.0, -1.0], force: 3e-5, steps: 200, ..paper() };
    match shape(&settings, &ovate(5), &Limits::default()) {
        Ok((mesh, strain)) => {
            (mesh.check().is_ok() && strain <= settings.strain_limit + 0.011, format!("largest strain {strain:.4}"))
        }
        Err(error) => (false, error.to_string()),
    }
}

fn impulse() -> Seen {
    let (mut springs, _) = undamped(40.0, 0.5);
    springs.weigh(|number| if number % 2 == 0 { 1e-6 } else { 1e-2 });
    let (step, force) = (0.7 * springs.critical_step(), DVec3::new(1e-4, 0.0, 3e-4));
    springs.pull(force);
    let before = springs.momentum();
    (0..2000).for_each(|_| springs.advance(step, None));
    let asked = force * (step * 2000.0 * springs.masses().len() as f64);
    let error = (springs.momentum() - before - asked).norm() / asked.norm();
    (error < 1e-10 && springs.strain().is_finite(), format!("off by {} of the impulse", shown(error)))
}

fn black_mask() -> Seen {
    let mesh = FlatMesh { greys: vec![0.0; ovate(5).positions.len()], ..ovate(5) };
    let settings = Settings { field: Field::Constant, force: 1e-4, steps: 200, ..paper() };
    let Ok((found, _)) = shape(&settings, &mesh, &Limits::default()) else { return (false, "refused".to_owned()) };
    let (_, figures) = match deform::deform(&settings, &mesh, &[job(1.0)], 1, &Limits::default()) {
        Ok(made) => made,
        Err(error) => return (false, error.to_string()),
    };
    let step = figures.values.get("step_s").and_then(serde_json::Value::as_f64).unwrap_or(f64::NAN);
    let mut springs = Springs::new(&settings, &mesh);
    springs.weigh(|_| 0.5 * settings.mass_unit * 1e-6);
    springs.pull(DVec3::from(settings.direction) * settings.force);
    (0..settings.steps).for_each(|_| springs.advance(step, Some(settings.strain_limit)));
    let far = |(p, q): (&crate::base::vector::Vec3, &DVec3)| (p.cast::<f64>() - q).norm();
    let worst = found.positions.iter().zip(springs.positions()).map(far).fold(0.0, f64::max);
    (worst < 1e-8, format!("{} m from equal masses at most", shown(worst)))
}

fn greys() -> Seen {
    let masses = [0.0, 1.0, 255.0].map(deform::mass);
    let exact =
        masses.iter().zip([0.5, std::f64::consts::LN_2, 5.545_177]).all(|(found, asked)| (found - asked).abs() < 1e-4);
    let count = ovate(5).positions.len();
    let grey = |v: usize| [0.0, 1.0, 255.0][v % 3];
    let mesh = FlatMesh { greys: (0..count).map(grey).collect(), ..ovate(5) };
    match shape(&paper(), &mesh, &Limits::default()) {
        Ok((mesh, strain)) => (exact && mesh.check().is_ok() && strain <= 0.111, format!("masses {masses:.4?}")),
        Err(error) => (false, error.to_string()),
    }
}

fn strain(strain_limit: f64) -> Seen {
    let settings = Settings { strain_limit, force: 0.05, field: Field::Normal, steps: 60, ..paper() };
    match shape(&settings, &ovate(4), &Limits::default()) {
        Ok((mesh, strain)) => {
            (mesh.check().is_ok() && strain <= strain_limit + 0.011, format!("largest strain {}", shown(strain)))
        }
        Err(error) => (false, error.to_string()),
    }
}

fn refused(bench: &Bench, name: &str, key: &str, value: &str) -> Seen {
    let scene = format!("{SMALL}[deform]\nmodel = \"paper\"\nshapes = 1\n{key} = {value}\n");
    bench.render(name, &scene, &[]).is_refusal(&[&format!("{name}.toml"), key])
}

fn unmoved(settings: &Settings, dryness: f64) -> Seen {
    let mesh = ovate(5);
    let made = deform::deform(settings, &mesh, &[job(dryness)], 1, &Limits::default());
    let Ok((shapes, _)) = made else { return (false, "refused".to_owned()) };
    let bits = |p: &crate::base::vector::Vec3| [p.x, p.y, p.z].map(f32::to_bits);
    let same = |(p, q): (&crate::base::vector::Vec3, &crate::base::vector::DVec2)| {
        bits(p) == [(q.x as f32).to_bits(), (q.y as f32).to_bits(), 0]
    };
    let count = shapes[0].positions.iter().zip(&mesh.positions).filter(|pair| same(*pair)).count();
    (count == mesh.positions.len(), format!("{count} of {} vertices unmoved", mesh.positions.len()))
}

fn many_steps() -> Seen {
    let mesh = FlatMesh { held: vec![0, 1, 2], ..hexagon() };
    let settings = Settings { model: Model::Paper, steps: 10_000_000, ..Settings::default() };
    let mut limits = Limits::default();
    limits.set(Limit::Steps, 2e7);
    match shape(&settings, &mesh, &limits) {
        Ok((mesh, strain)) => (mesh.check().is_ok() && strain <= 0.11, format!("largest strain {strain:.4}")),
        Err(error) => (false, error.to_string()),
    }
}

fn turning() -> Seen {
    let (mut springs, step) = undamped(40.0, 0.2);
    // Half a turn a second.
    springs.stir(|_, p| DVec3::z().cross(&p) * PI);
    let before = springs.angular_momentum();
    let mut strain = 0.0f64;
    for _ in 0..((2.0 / step) as u64).min(200_000) {
        springs.advance(step, None);
        strain = strain.max(springs.strain());
    }
    let lost = (springs.angular_momentum() - before).norm() / before.norm();
    // The pull of all masses on one spring, at most.
    let pull: f64 = springs.masses().iter().zip(springs.positions()).map(|(m, p)| m * PI * PI * p.norm()).sum();
    let bound = 2.0 * pull / (40.0 * 0.004);
    (
        lost < 1e-10 && strain < bound,
        format!("lost {}; strain {} of at most {}", shown(lost), shown(strain), shown(bound)),
    )
}
