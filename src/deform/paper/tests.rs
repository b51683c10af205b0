use super::*;
use crate::base::mesh::Mesh;
use crate::base::random::{Purpose, Stream};
use crate::base::vector::{DVec2, Vec2, Vec3};
use crate::deform::deform;
use crate::deform::paper::projection::{SLACK, bound};
use crate::deform::paper::system::State;
use crate::deform::settings::Model;

/// The vertices of an equilateral lattice, 4 mm apart, at the rows, columns and places that `keeps` takes, and the triangles
/// between them.
pub(super) fn lattice(keeps: impl Fn(i32, i32, &DVec2) -> bool) -> FlatMesh {
    let pitch = 0.004;
    let mut numbers = BTreeMap::new();
    let mut mesh = FlatMesh::default();
    for row in -9i32..=9 {
        for column in -12i32..=12 {
            let place = DVec2::new(f64::from(column) + 0.5 * f64::from(row), f64::from(row) * 0.75f64.sqrt()) * pitch;
            if keeps(row, column, &place) {
                numbers.insert((row, column), mesh.positions.len() as u32);
                mesh.positions.push(place);
            }
        }
    }
    for (&(row, column), &a) in &numbers {
        let at = |row: i32, column: i32| numbers.get(&(row, column)).copied();
        if let (Some(b), Some(c)) = (at(row, column + 1), at(row + 1, column)) {
            mesh.triangles.push([a, b, c]);
        }
        if let (Some(b), Some(c)) = (at(row + 1, column), at(row + 1, column - 1)) {
            mesh.triangles.push([a, b, c]);
        }
    }
    mesh
}

/// A disc of the lattice, 60 mm across, light at the rim and heavy along x = 0, held at the bottom.
fn disc() -> FlatMesh {
    let mut mesh = lattice(|_, _, place| place.norm() < 0.0301);
    let grey = |p: &DVec2| if p.x.abs() < 0.002 { 255.0 } else { 255.0 * (1.0 - p.norm() / 0.031) };
    mesh.greys = mesh.positions.iter().map(grey).collect();
    mesh.uvs = mesh.positions.iter().map(|p| Vec2::new(p.x as f32, p.y as f32)).collect();
    mesh.held = (0..mesh.positions.len() as u32).filter(|&v| mesh.positions[v as usize].y < -0.027).collect();
    mesh
}

fn paper() -> Settings {
    Settings { model: Model::Paper, steps: 500, force: 6e-3, ..Settings::default() }
}

fn jobs(variants: u32, dryness: &[f64]) -> Vec<Job> {
    let job = |variant, &dryness: &f64| Job { state: "brown".to_owned(), variant, dryness };
    (0..variants).flat_map(|variant| dryness.iter().map(move |d| job(variant, d))).collect()
}

fn deformed(settings: &Settings, jobs: &[Job]) -> (Vec<Mesh>, Figures) {
    deform(settings, &disc(), jobs, 1, &Limits::default()).unwrap()
}

/// Places (relative to rest) and velocities of the oscillator over some steps of unit length.
fn oscillation(frequency: f64, steps: usize) -> Vec<(f64, f64)> {
    let system = System::oscillator(frequency);
    let field = Force::Normal(vec![0.0; 2]);
    let mut state = system.at_rest();
    state.positions[1].x += 0.01;
    let mut line = vec![(state.positions[1].x - 1.0, 0.0)];
    for _ in 0..steps {
        let forces = system.forces(&state, &field);
        system.accelerate(&mut state, &forces, 1.0);
        system.displace(&mut state, 1.0);
        line.push((state.positions[1].x - 1.0, state.velocities[1].x));
    }
    line
}

#[test]
fn equation_1_has_the_frequency_of_its_closed_form() {
    let table =
        [(0.1, 1.000_417_136_1), (0.5, 1.010_721_020_6), (1.0, std::f64::consts::FRAC_PI_3), (1.9, 1.319_195_681_6)];
    for (frequency, ratio) in table {
        // x(n+1) + x(n-1) = 2 cos(angle) x(n), summed over many steps so that rounding cancels.
        let line = oscillation(frequency, 400);
        let (mut above, mut below) = (0.0, 0.0);
        for w in line.windows(3) {
            above += (w[0].0 + w[2].0) * w[1].0;
            below += 2.0 * w[1].0 * w[1].0;
        }
        let angle = crate::base::maths::acos(above / below);
        assert!((angle / frequency - ratio).abs() < 1e-9, "{frequency}: {}", angle / frequency);
    }
}

#[test]
fn equation_1_conserves_its_shadow_energy() {
    let frequency = 0.5;
    let energy = |&(x, v): &(f64, f64)| {
        let squared = frequency * frequency;
        v * v / 2.0 + squared * x * x / 2.0 - squared * x * v / 2.0
    };
    let line = oscillation(frequency, 20_000);
    let start = energy(&line[0]);
    let drift = line.iter().map(|p| (energy(p) / start - 1.0).abs()).fold(0.0, f64::max);
    assert!(drift < 1e-9, "{drift}");
}

#[test]
fn the_largest_step_is_two_over_the_frequency() {
    let step = stability::largest_step(&System::oscillator(3.0));
    assert!(step <= 2.0 / 3.0 && step > 0.97 * 2.0 / 3.0, "{step}");
    let growth = |frequency: f64| oscillation(frequency, 2000).iter().map(|p| p.0.abs()).fold(0.0, f64::max);
    assert!(growth(1.99) < 0.2 && growth(2.01) > 100.0);
}

fn kicked(system: &System) -> State {
    let mut state = system.at_rest();
    let mut stream = Stream::new(3, Purpose::Deformation, 0, 0);
    for velocity in &mut state.velocities {
        *velocity = DVec3::new(stream.range(-1.0, 1.0), stream.range(-1.0, 1.0), stream.range(-1.0, 1.0));
    }
    state
}

fn momentum(system: &System, state: &State) -> DVec3 {
    system.masses.iter().zip(&state.velocities).map(|(m, v)| v * *m).sum()
}

fn free() -> System {
    System::new(&Settings { drag: 0.0, ..paper() }, &FlatMesh { held: Vec::new(), ..disc() })
}

#[test]
fn the_projection_holds_the_bound_and_keeps_momentum() {
    let system = free();
    let mut state = kicked(&system);
    let before = momentum(&system, &state);
    let step = 0.01;
    let mut unbounded = state.clone();
    system.displace(&mut unbounded, step);
    assert!(system.strain(&unbounded.positions) > 1.0, "the kick must break the bound");
    bound(&system, &mut state, step, 0.1);
    assert!((momentum(&system, &state) - before).norm() < 1e-12 * before.norm().max(1e-3));
    system.displace(&mut state, step);
    let strain = system.strain(&state.positions);
    assert!(strain <= 0.1 + SLACK, "{strain}");
}

#[test]
fn springs_and_friction_keep_momentum() {
    let system = free();
    let mut state = kicked(&system);
    let before = momentum(&system, &state);
    let field = Force::Normal(vec![0.0; system.rest.len()]);
    for _ in 0..50 {
        let forces = system.forces(&state, &field);
        system.accelerate(&mut state, &forces, 1e-5);
        system.displace(&mut state, 1e-5);
    }
    assert!((momentum(&system, &state) - before).norm() < 1e-12 * before.norm().max(1e-3));
}

#[test]
fn equal_forces_move_two_masses_inversely() {
    let mut system = System::oscillator(0.0);
    system.masses = vec![0.5, 5.5];
    system.mobility = vec![2.0, 1.0 / 5.5];
    let mut state = system.at_rest();
    let forces = system.forces(&state, &Force::Normal(vec![3.0, 3.0]));
    system.accelerate(&mut state, &forces, 0.25);
    system.displace(&mut state, 0.25);
    let rise = |v: usize| state.positions[v].z;
    assert!((rise(0) / rise(1) - 11.0).abs() < 1e-12);
    assert!((rise(0) - 0.25 * 0.25 * 3.0 / 0.5).abs() < 1e-15);
}

#[test]
fn no_force_gives_the_input_bits() {
    let (meshes, figures) = deformed(&Settings { force: 0.0, ..paper() }, &jobs(1, &[1.0]));
    for (p, flat) in meshes[0].positions.iter().zip(&disc().positions) {
        assert_eq!(
            [p.x.to_bits(), p.y.to_bits(), p.z.to_bits()],
            [(flat.x as f32).to_bits(), (flat.y as f32).to_bits(), 0]
        );
    }
    assert_eq!(figures.values["max_strain"], 0.0);
}

#[test]
fn the_bound_holds_under_a_force_that_would_tear_the_leaf() {
    let settings = Settings { force: 0.2, ..paper() };
    let (meshes, figures) = deformed(&settings, &jobs(2, &[0.5, 1.0]));
    let strain = figures.values["max_strain"].as_f64().unwrap();
    assert!(strain > 0.09 && strain <= settings.strain_limit + SLACK, "{strain}");
    assert_eq!(figures.values["iterations"], 1000);
    assert!(meshes.iter().all(|mesh| mesh.check().is_ok()));
}

#[test]
fn drier_leaves_are_farther_from_flat() {
    let (meshes, _) = deformed(&paper(), &jobs(1, &[0.0, 0.1, 0.3, 0.6]));
    let mesh = disc();
    let rise = |shape: &Mesh| shape.positions.iter().map(|p| f64::from(p.z.abs())).sum::<f64>();
    let rises: Vec<f64> = meshes.iter().map(rise).collect();
    assert_eq!(rises[0], 0.0);
    assert!(rises.windows(2).all(|w| w[0] < w[1]), "{rises:?}");
    assert!(mesh.held.iter().all(|&v| meshes[3].positions[v as usize].z == 0.0));
}

#[test]
fn dark_regions_lead_under_an_even_force() {
    // Masses alone: friction ties light vertices to heavy neighbours.
    let settings = Settings { drag: 0.0, friction: 0.0, ..paper() };
    let mesh = disc();
    let system = System::new(&settings, &mesh);
    let even = Force::Normal(vec![1e-3; mesh.positions.len()]);
    let shape = run(&system, &even, 1e-4, 0.1, vec![20]).unwrap().snapshots.remove(&20).unwrap();
    let mean = |wanted: &dyn Fn(f64) -> bool| {
        let rises: Vec<f64> = (0..shape.len()).filter(|&v| wanted(mesh.greys[v])).map(|v| shape[v].z).collect();
        rises.iter().sum::<f64>() / rises.len() as f64
    };
    let (dark, bright) = (mean(&|g| g < 20.0), mean(&|g| g > 200.0));
    assert!(dark > 1.5 * bright && bright > 0.0, "{dark} {bright}");
}

/// Cosine of the sharpest fold between neighbouring triangles.
fn sharpest(mesh: &Mesh) -> f32 {
    let mut by_edge: BTreeMap<[u32; 2], Vec<Vec3>> = BTreeMap::new();
    for &[a, b, c] in &mesh.triangles {
        let [p, q, r] = [a, b, c].map(|v| mesh.positions[v as usize]);
        let normal = (q - p).cross(&(r - p)).normalize();
        for (u, v) in [(a, b), (b, c), (c, a)] {
            by_edge.entry([u.min(v), u.max(v)]).or_default().push(normal);
        }
    }
    let pairs = by_edge.values().filter(|normals| normals.len() == 2);
    pairs.map(|normals| normals[0].dot(&normals[1])).fold(1.0, f32::min)
}

#[test]
fn nothing_folds_over() {
    let (meshes, _) = deformed(&paper(), &jobs(24, &[1.0]));
    let folds: Vec<f32> = meshes.iter().map(sharpest).collect();
    assert!(folds.iter().all(|&fold| fold > 0.0), "a fold of more than 90 degrees: {folds:?}");
}

#[test]
fn threads_and_company_do_not_matter() {
    let settings = paper();
    let all = jobs(3, &[0.2, 0.5]);
    let pool = |threads: usize| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let one = pool(1).install(|| deformed(&settings, &all));
    let four = pool(4).install(|| deformed(&settings, &all));
    assert_eq!(one, four);
    let alone = deformed(&settings, &all[3..4]).0;
    assert_eq!(alone[0], one.0[3]);
    assert_ne!(one.0[0], one.0[2], "variants differ");
}

#[test]
fn unstable_steps_and_limits_are_refused() {
    let settings = Settings { step: Step::Seconds(5e-4), ..paper() };
    assert!(check(&settings).is_empty());
    let refused = deform(&settings, &disc(), &jobs(1, &[1.0]), 1, &Limits::default()).unwrap_err();
    let DeformError::Unstable { safe, .. } = refused else { panic!("{refused:?}") };
    let stable = Settings { step: Step::Seconds(safe * 0.99), ..paper() };
    assert!(deformed(&stable, &jobs(1, &[1.0])).0[0].check().is_ok());
    assert_eq!(check(&Settings { step: Step::Seconds(0.5), ..paper() }).len(), 1);
    let mut limits = Limits::default();
    limits.set(Limit::Steps, 500.0);
    let refused = deform(&paper(), &disc(), &jobs(2, &[1.0]), 1, &limits);
    assert!(matches!(refused, Err(DeformError::Refused(_))));
}

#[test]
fn a_direction_of_no_length_is_refused() {
    let settings = Settings { field: Field::Constant, direction: [0.0; 3], ..paper() };
    assert_eq!(check(&settings)[0].key, "direction");
}

#[test]
fn an_even_force_lifts_every_vertex_of_a_free_leaf_by_its_own_mass() {
    // Without springs that pull, friction or drag: n steps of equation (1) from rest give n (n + 1) / 2 dt^2 F / m.
    let mesh = FlatMesh { held: Vec::new(), greys: vec![255.0; disc().greys.len()], ..disc() };
    for field in [Field::Constant, Field::Normal] {
        let settings = Settings { field, force: 1e-3, drag: 0.0, step: Step::Seconds(1e-5), steps: 8, ..paper() };
        let (shapes, _) = shapes(&settings, &mesh, &jobs(1, &[1.0]), 1, &Limits::default()).unwrap();
        let rise = 36.0 * 1e-10 * 1e-3 / (masses::mass(255.0) * 1e-6);
        assert!(shapes[0].iter().all(|p| (p.z / rise - 1.0).abs() < 1e-9), "{field:?}");
    }
}
