//! The drying shell as a whole: accurate, quick in steps, and the same shape whatever the mesh.

mod deform_meshes;

use deform_meshes::{distance, flat, ovate, shapes};
use leafseason::base::flat_mesh::FlatMesh;
use leafseason::base::mesh::Mesh;
use leafseason::deform::shell;
use leafseason::deform::{Model, Settings};

const RUNGS: [f64; 8] = [0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0];

fn with(shell: shell::Settings) -> Settings {
    Settings { model: Model::Shell, shell, ..Settings::default() }
}

/// The problem on which the solver is measured: a blade a hundred times as long as thick, curled to a tenth of its length.
fn measured() -> shell::Settings {
    shell::Settings { curl: 10.0, thickness: 0.01, ..shell::Settings::default() }
}

#[test]
fn few_steps_reach_a_thousandth_of_the_deformation() {
    // 631 and 2,107 vertices.
    let iterations = [14, 26].map(|rings| {
        let mesh = ovate(rings);
        let (found, figure) = shapes(&with(measured()), &mesh, &RUNGS);
        if rings == 14 {
            let exact = with(shell::Settings { tolerance: 1e-7, ..measured() });
            let (exact, _) = shapes(&exact, &mesh, &RUNGS);
            let error =
                |(a, b): (&Mesh, &Mesh)| distance(&a.positions, &b.positions) / distance(&b.positions, &flat(&mesh));
            let worst = found.iter().zip(&exact).map(error).fold(0.0, f64::max);
            assert!(worst < 1e-3, "{worst}");
        }
        figure("iterations") / RUNGS.len() as f64
    });
    assert!(iterations[0] <= 12.0, "{iterations:?}");
    assert!(iterations[1] <= 1.3 * iterations[0], "{iterations:?}");
}

#[test]
fn the_shape_does_not_depend_on_the_mesh() {
    // 631 and 2,437 vertices; each of the coarse mesh is one of the fine. Nothing holds them, so that shapes are compared and
    // not the patches that each mesh has for a petiole.
    let [coarse, fine] = [14, 28].map(|rings| FlatMesh { held: Vec::new(), ..ovate(rings) });
    let settings = with(measured());
    let [a, b] = [&coarse, &fine].map(|mesh| shapes(&settings, mesh, &[0.25]).0.remove(0).positions);
    let twin = |p: &leafseason::base::vector::DVec2| {
        fine.positions.iter().position(|q| (q - p).norm() < 1e-9).expect("a twin")
    };
    let twins: Vec<_> = coarse.positions.iter().map(|p| b[twin(p)]).collect();
    let difference = distance(&a, &twins) / distance(&twins, &flat(&coarse));
    assert!(difference < 0.02, "{difference}");
}

#[test]
fn drier_leaves_are_farther_from_flat_and_green_ones_nearly_flat() {
    let mesh = ovate(8);
    let (shapes, figure) = shapes(&Settings::default(), &mesh, &[0.0, 0.1, 0.3, 0.6, 1.0]);
    let away: Vec<f64> = shapes.iter().map(|shape| distance(&shape.positions, &flat(&mesh))).collect();
    assert_eq!(away[0], 0.0);
    assert!(away.windows(2).all(|pair| pair[0] < pair[1]), "{away:?}");
    assert!(away[1] < 0.004 && away[4] > 0.015, "{away:?}");
    assert!(figure("max_strain") < 0.1);
    let held = mesh.held.iter().all(|&v| shapes[4].positions[v as usize].z == 0.0);
    assert!(held, "the petiole holds its place");
}

#[test]
fn a_shape_is_the_same_in_any_company_and_on_any_number_of_threads() {
    let mesh = ovate(6);
    let settings = Settings::default();
    let job = |variant, dryness| leafseason::deform::Job { state: "x".to_owned(), variant, dryness };
    let all = [job(0, 0.33), job(2, 0.9), job(0, 0.7), job(1, 0.7)];
    let make = |jobs: &[leafseason::deform::Job], threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let limits = leafseason::base::limits::Limits::default();
        pool.install(|| leafseason::deform::deform(&settings, &mesh, jobs, 7, &limits).expect("shapes").0)
    };
    let (one, four) = (make(&all, 1), make(&all, 4));
    assert_eq!(one, four);
    assert_eq!(make(&all[2..3], 1)[0], one[2]);
    assert!(distance(&one[2].positions, &one[3].positions) > 1e-4, "variants differ");
}

#[test]
fn a_mirrored_blade_curls_to_the_mirrored_shape_and_one_with_other_numbers_to_the_same() {
    let settings = with(shell::Settings { variation: 0.0, reversed: 0.0, ..shell::Settings::default() });
    let mesh = ovate(6);
    let shape = shapes(&settings, &mesh, &[0.6]).0.remove(0).positions;
    let count = mesh.positions.len() as u32;
    let mut other = mesh.clone();
    other.positions.reverse();
    other.uvs.reverse();
    other.greys.reverse();
    other.positions.iter_mut().for_each(|p| p.x = -p.x);
    let renumbered = |v: u32| count - 1 - v;
    other.triangles.iter_mut().for_each(|t| *t = [renumbered(t[0]), renumbered(t[2]), renumbered(t[1])]);
    other.held.iter_mut().for_each(|v| *v = renumbered(*v));
    let mirrored = shapes(&settings, &other, &[0.6]).0.remove(0).positions;
    for (p, q) in shape.iter().zip(mirrored.iter().rev()) {
        assert!((p.x + q.x).abs() < 1e-6 && (p.y - q.y).abs() < 1e-6 && (p.z - q.z).abs() < 1e-6, "{p} {q}");
    }
}

#[test]
fn holes_in_the_blade_are_margins_and_no_trouble() {
    let mut mesh = ovate(10);
    let bitten = |t: &[u32; 3]| {
        let middle = t.iter().map(|&v| mesh.positions[v as usize]).sum::<leafseason::base::vector::DVec2>() / 3.0;
        (middle - leafseason::base::vector::DVec2::new(0.012, 0.05)).norm() < 0.006
    };
    mesh.triangles = mesh.triangles.iter().copied().filter(|t| !bitten(t)).collect();
    // Vertices that lost all their triangles are dropped, as a mesher does.
    let mut used: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let number = |v: u32| used.binary_search(&v).expect("used") as u32;
    let mut holed = mesh.clone();
    holed.positions = used.iter().map(|&v| mesh.positions[v as usize]).collect();
    holed.uvs = used.iter().map(|&v| mesh.uvs[v as usize]).collect();
    holed.greys = used.iter().map(|&v| mesh.greys[v as usize]).collect();
    holed.triangles.iter_mut().for_each(|t| *t = t.map(number));
    holed.held = mesh.held.iter().map(|&v| number(v)).collect();
    assert!(holed.positions.len() < mesh.positions.len());
    let (shapes, figure) = shapes(&Settings::default(), &holed, &[0.5, 1.0]);
    assert!(distance(&shapes[1].positions, &flat(&holed)) > 0.01 && figure("max_strain") < 0.1);
}
