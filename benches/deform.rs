//! What a state of the shell costs on one core, and what equation (1) costs for the same shape: `cargo bench --bench deform`.
//! Prints the median over rounds; compare within a run, since machines and their neighbours differ.

#[path = "../tests/deform_meshes/mod.rs"]
mod deform_meshes;

use deform_meshes::ovate;
use leafseason::base::flat_mesh::FlatMesh;
use leafseason::base::vector::DVec3;
use leafseason::deform::integrators::{Method, Run, run};
use leafseason::deform::shell::Settings;
use std::time::Instant;

const RUNGS: [f64; 8] = [0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0];

fn settings() -> Settings {
    Settings { curl: 10.0, thickness: 0.01, ..Settings::default() }
}

/// The run, and milliseconds a state.
fn timed(mesh: &FlatMesh, method: Method) -> (Run, f64) {
    let start = Instant::now();
    let run = run(&settings(), mesh, &RUNGS, 1, method).expect("a run");
    (run, start.elapsed().as_secs_f64() * 1e3 / RUNGS.len() as f64)
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Worst error of all states, as a share of their deformation.
fn error(exact: &Run, found: &Run, mesh: &FlatMesh) -> f64 {
    let square = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(p, q)| (p - q).norm_squared()).sum::<f64>();
    let flat: Vec<DVec3> = mesh.positions.iter().map(|p| DVec3::new(p.x, p.y, 0.0) / 0.08).collect();
    let one = |(a, b): (&Vec<DVec3>, &Vec<DVec3>)| (square(a, b) / square(a, &flat)).sqrt();
    exact.shapes.iter().zip(&found.shapes).map(one).fold(0.0, f64::max)
}

fn main() {
    for rings in [14, 26] {
        let mesh = ovate(rings);
        let rounds: Vec<(Run, f64)> = (0..9).map(|_| timed(&mesh, Method::Newton)).collect();
        let (steps, time) = (rounds[0].0.steps, median(rounds.iter().map(|round| round.1).collect()));
        let each = steps as f64 / RUNGS.len() as f64;
        println!("{} vertices, Newton: {each:.2} iterations and {time:.1} ms a state", mesh.positions.len());
    }
    let mesh = ovate(14);
    let (exact, newton) = timed(&mesh, Method::Newton);
    let ladder = [500, 2000, 8000, 32_000];
    let methods = ladder.map(|steps| Method::Explicit { steps });
    let methods = methods.into_iter().chain([8, 32].map(|steps| Method::Implicit { steps }));
    for method in methods.chain([800, 3200].map(|steps| Method::PositionBased { steps })) {
        let (found, time) = timed(&mesh, method);
        let error = error(&exact, &found, &mesh);
        println!("{method:?}: error {error:.2e}, {time:.1} ms a state, {:.0} times Newton's", time / newton);
    }
}
