use super::*;
use crate::base::flat_mesh::FlatMesh;
use crate::base::vector::DVec2;

/// A small blade of right triangles, held at one side, black.
fn blade() -> FlatMesh {
    let mut mesh = FlatMesh::default();
    for y in 0..7 {
        for x in 0..5 {
            mesh.positions.push(DVec2::new(f64::from(x), f64::from(y)) * 0.01);
        }
    }
    for (x, y) in (0..6u32).flat_map(|y| (0..4).map(move |x| (x, y))) {
        let at = |x: u32, y: u32| y * 5 + x;
        let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
        mesh.triangles.extend(if (x + y) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
    }
    mesh.greys = vec![0.0; mesh.positions.len()];
    mesh.held = (0..10).collect();
    mesh
}

fn settings() -> shell::Settings {
    shell::Settings { thickness: 0.05, curl: 3.0, roll: 0.5, cupping: 0.15, shrink: 0.08, ..shell::Settings::default() }
}

fn error(method: Method) -> f64 {
    let run = |method| run(&settings(), &blade(), &[0.5, 1.0], 1, method).unwrap();
    let (exact, found) = (run(Method::Newton), run(method));
    let square = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(p, q)| (p - q).norm_squared()).sum::<f64>();
    let flat: Vec<DVec3> = blade().positions.iter().map(|p| DVec3::new(p.x, p.y, 0.0) / 0.06).collect();
    (square(&exact.shapes[1], &found.shapes[1]) / square(&exact.shapes[1], &flat)).sqrt()
}

#[test]
fn all_ways_lead_to_the_same_shape_and_longer_ones_nearer() {
    let ladders = [
        (Method::Implicit { steps: 2 }, Method::Implicit { steps: 60 }, 1e-3),
        (Method::Explicit { steps: 100 }, Method::Explicit { steps: 4000 }, 1e-2),
        // Its rest is not quite the sheet's, whatever the steps.
        (Method::PositionBased { steps: 50 }, Method::PositionBased { steps: 3000 }, 0.12),
    ];
    for (few, many, bound) in ladders {
        let (rough, fine) = (error(few), error(many));
        assert!(fine < bound && fine < rough, "{many:?}: {rough} {fine}");
    }
}
