//! Equation (1) on few vertices for very long, on very stiff springs, and with very unequal masses.

use super::system::State;
use super::tests::lattice;
use super::*;
use crate::base::random::{Purpose, Stream};

/// Nineteen vertices of an equilateral lattice, 4 mm apart, that nothing holds.
fn hexagon() -> FlatMesh {
    let is_inside = |row: i32, column: i32| row.abs() <= 2 && column.abs() <= 2 && (row + column).abs() <= 2;
    let mut mesh = lattice(|row, column, _| is_inside(row, column));
    mesh.greys = vec![0.0; mesh.positions.len()];
    mesh
}

/// Without drag or friction.
fn undamped(stiffness: f64) -> System {
    System::new(&Settings { stiffness, drag: 0.0, friction: 0.0, ..Settings::default() }, &hexagon())
}

/// At rest but for small velocities in the plane.
fn stirred(system: &System, speed: f64) -> State {
    let mut stream = Stream::new(3, Purpose::Deformation, 0, 0);
    let velocity = |_: &DVec3| DVec3::new(stream.range(-speed, speed), stream.range(-speed, speed), 0.0);
    let velocities = system.rest.iter().map(velocity).collect();
    State { velocities, ..system.at_rest() }
}

fn advance(system: &System, state: &mut State, force: &Force, step: f64) {
    let forces = system.forces(state, force);
    system.accelerate(state, &forces, step);
    system.displace(state, step);
}

fn energy(system: &System, state: &State) -> f64 {
    let kinetic: f64 = system.masses.iter().zip(&state.velocities).map(|(m, v)| 0.5 * m * v.norm_squared()).sum();
    let stretch = |(&[a, b], length): (&[u32; 2], &f64)| {
        let stretch = (state.positions[b as usize] - state.positions[a as usize]).norm() - length;
        0.5 * system.stiffness * stretch * stretch
    };
    kinetic + system.springs.iter().zip(&system.lengths).map(stretch).sum::<f64>()
}

fn none(system: &System) -> Force {
    Force::Constant(DVec3::zeros() * system.stiffness)
}

/// Largest energy over that at the start, and the means of the first and the last tenth of the steps.
fn energies(stiffness: f64, share: f64, steps: u32) -> (f64, f64, f64) {
    let system = undamped(stiffness);
    let step = share * stability::largest_step(&system);
    // Springs stretch by about a thousandth.
    let mut state = stirred(&system, 2e-6 / step);
    let start = energy(&system, &state);
    let (mut worst, mut early, mut late) = (0.0f64, 0.0, 0.0);
    for number in 0..steps {
        advance(&system, &mut state, &none(&system), step);
        let now = energy(&system, &state) / start;
        worst = worst.max(now);
        early += if number < steps / 10 { now } else { 0.0 };
        late += if number >= steps - steps / 10 { now } else { 0.0 };
    }
    let tenth = f64::from(steps / 10);
    (worst, early / tenth, late / tenth)
}

#[test]
fn the_stiffest_springs_keep_their_energy_within_its_bound() {
    // Of x^2 w^2 + v^2 - r w x v * 2, which is conserved, with r the step over the largest one.
    for share in [0.5, 0.9] {
        let (worst, early, late) = energies(1e8, share, 10_000);
        assert!(worst <= (1.0 + share) / (1.0 - share), "{share}: {worst}");
        assert!((late / early - 1.0).abs() < 0.1, "{share}: {early} {late}");
    }
}

#[test]
#[ignore = "takes some seconds"]
fn a_million_undamped_steps_do_not_drift() {
    let steps = 1_000_000;
    let (worst, early, late) = energies(40.0, 0.5, steps);
    assert!(worst <= 3.0, "{worst}");
    assert!((late / early - 1.0).abs() < 1e-9 * f64::from(steps) * 10.0, "{early} {late}");
}

#[test]
#[ignore = "takes a minute"]
fn ten_million_steps_stay_finite_and_within_the_bound() {
    let settings = Settings { model: crate::deform::Model::Paper, steps: 10_000_000, ..Settings::default() };
    let mesh = FlatMesh { held: vec![0, 1, 2], uvs: vec![crate::base::vector::Vec2::zeros(); 19], ..hexagon() };
    let jobs = [Job { state: "brown".to_owned(), variant: 0, dryness: 1.0 }];
    let mut limits = Limits::default();
    limits.set(Limit::Steps, 2e7);
    let (shapes, figures) = crate::deform::deform(&settings, &mesh, &jobs, 1, &limits).unwrap();
    assert!(shapes[0].check().is_ok());
    assert!(figures.values["max_strain"].as_f64().unwrap() <= 0.11);
}

#[test]
fn masses_of_a_ratio_of_ten_thousand_take_up_the_impulse() {
    let mut system = undamped(40.0);
    for v in 0..system.masses.len() {
        system.masses[v] = if v % 2 == 0 { 1e-6 } else { 1e-2 };
        system.mobility[v] = 1.0 / system.masses[v];
    }
    let step = 0.7 * stability::largest_step(&system);
    let force = Force::Constant(DVec3::new(1e-4, 0.0, 3e-4));
    let mut state = stirred(&system, 1e-3);
    let momentum = |state: &State| system.masses.iter().zip(&state.velocities).map(|(m, v)| v * *m).sum::<DVec3>();
    let before = momentum(&state);
    for _ in 0..2000 {
        advance(&system, &mut state, &force, step);
    }
    let impulse = DVec3::new(1e-4, 0.0, 3e-4) * (step * 2000.0 * system.masses.len() as f64);
    let gained = momentum(&state) - before;
    assert!((gained - impulse).norm() < 1e-10 * impulse.norm().max(momentum(&state).norm()), "{gained} {impulse}");
    assert!(system.strain(&state.positions).is_finite());
}

#[test]
fn a_turning_leaf_keeps_its_angular_momentum_and_hardly_stretches() {
    let system = undamped(40.0);
    let step = 0.2 * stability::largest_step(&system);
    let rate = 2.0 * std::f64::consts::PI / 2.0;
    let mut state = system.at_rest();
    state.velocities = system.rest.iter().map(|p| DVec3::z().cross(p) * rate).collect();
    let turning = |state: &State| {
        let one = |((m, p), v): ((&f64, &DVec3), &DVec3)| p.cross(v) * *m;
        system.masses.iter().zip(&state.positions).zip(&state.velocities).map(one).sum::<DVec3>()
    };
    let before = turning(&state);
    let steps = (2.0 / step) as u64;
    let mut strain = 0.0f64;
    for _ in 0..steps.min(200_000) {
        advance(&system, &mut state, &none(&system), step);
        strain = strain.max(system.strain(&state.positions));
    }
    assert!((turning(&state) - before).norm() < 1e-10 * before.norm());
    // The pull on the outermost spring over its stiffness: all masses within reach, at most.
    let pull: f64 = system.masses.iter().zip(&system.rest).map(|(m, p)| m * rate * rate * p.norm()).sum();
    assert!(strain < 2.0 * pull / (system.stiffness * 0.004), "{strain}");
}

#[test]
fn the_step_that_the_program_chooses_is_converged() {
    let mesh = FlatMesh { held: vec![0, 1, 2], uvs: vec![crate::base::vector::Vec2::zeros(); 19], ..hexagon() };
    let stiff = Settings { stiffness: 1e8, ..Settings::default() };
    let system = System::new(&stiff, &mesh);
    let force = Force::new(&stiff, &mesh, 1, 0);
    let step = stable_step(&stiff, &system).unwrap();
    let end = |parts: u64| {
        let run = run(&system, &force, step / parts as f64, 0.1, vec![4000 * parts]).unwrap();
        run.snapshots[&(4000 * parts)].clone()
    };
    let (chosen, fine) = (end(1), end(8));
    let apart: f64 = chosen.iter().zip(&fine).map(|(p, q)| (p - q).norm_squared()).sum();
    let moved: f64 = fine.iter().zip(&system.rest).map(|(p, q)| (p - q).norm_squared()).sum();
    assert!(moved > 0.0 && (apart / moved).sqrt() < 0.01, "{apart} {moved}");
    let bold = Settings { step: Step::Seconds(10.0 * step), ..stiff };
    let refusal = stable_step(&bold, &system).unwrap_err();
    assert!(matches!(refusal, DeformError::Unstable { .. }) && refusal.to_string().contains("at most"));
}
