//! Closed forms, conservation and derivatives of the sheet.
use super::energy::{Bent, Places, Rest, couplings, energy};
use super::newton::{Plan, Solver};
use super::settings::Settings;
use super::sheet::{Rib, Sheet, Tensor};
use crate::base::flat_mesh::FlatMesh;
use crate::base::random::{Purpose, Stream};
use crate::base::vector::{DVec2, DVec3};
use crate::deform::cholesky::Matrix;

/// A rectangle of nearly equilateral triangles, `columns` of them along its length 1 and of the given width.
fn rectangle(columns: u32, width: f64) -> FlatMesh {
    let pitch = 1.0 / f64::from(columns);
    let rows = ((width / (pitch * 0.75f64.sqrt())).round() as u32).max(1);
    let mut mesh = FlatMesh::default();
    // Odd rows are shifted by half a pitch and have their ends cut off, with a vertex at each end.
    let row_length = |row: u32| if row % 2 == 0 { columns + 1 } else { columns + 2 };
    let place = |row: u32, i: u32| {
        let x = if row % 2 == 0 { f64::from(i) } else { (f64::from(i) - 0.5).clamp(0.0, f64::from(columns)) };
        DVec2::new(x * pitch, f64::from(row) / f64::from(rows) * width - 0.5 * width)
    };
    let mut starts = Vec::new();
    for row in 0..=rows {
        starts.push(mesh.positions.len() as u32);
        mesh.positions.extend((0..row_length(row)).map(|i| place(row, i)));
    }
    for row in 0..rows {
        let (low, high) = (starts[row as usize], starts[row as usize + 1]);
        if row % 2 == 0 {
            mesh.triangles.extend((0..=columns).map(|i| [low + i, high + i + 1, high + i]));
            mesh.triangles.extend((0..columns).map(|i| [low + i, low + i + 1, high + i + 1]));
        } else {
            mesh.triangles.extend((0..=columns).map(|i| [low + i, low + i + 1, high + i]));
            mesh.triangles.extend((0..columns).map(|i| [low + i + 1, high + i + 1, high + i]));
        }
    }
    mesh.greys = vec![0.0; mesh.positions.len()];
    mesh
}

fn sheet(settings: &Settings, mesh: &FlatMesh) -> Sheet {
    Sheet::new(settings, mesh, 1.0, &vec![Rib::default(); mesh.triangles.len()]).unwrap()
}

fn bent_to(sheet: &Sheet, curvature: Tensor) -> Rest {
    Rest {
        lengths: sheet.springs.iter().map(|spring| spring.length).collect(),
        folds: (0..sheet.plates.len()).map(|plate| sheet.folds(plate, curvature)).collect(),
        weight: 0.0,
    }
}

fn flat(sheet: &Sheet) -> Vec<DVec3> {
    sheet.places.iter().map(|p| DVec3::new(p.x, p.y, 0.0)).collect()
}

fn settled(sheet: &Sheet, rests: &[Rest]) -> Vec<DVec3> {
    let mut positions = flat(sheet);
    let mut solver = Solver::new(sheet, &Plan::new(sheet));
    for rest in rests {
        let outcome = solver.settle((rest, rest), &mut positions, 1e-5, 300);
        assert!(outcome.is_ok(), "{outcome:?}");
        println!("{outcome:?}");
    }
    positions
}

fn crumpled(sheet: &Sheet, by: f64) -> Vec<DVec3> {
    let mut stream = Stream::new(4, Purpose::Deformation, 1, 0);
    flat(sheet).into_iter().map(|p| p + DVec3::from_fn(|_, _| stream.range(-by, by))).collect()
}

#[test]
fn the_gradient_is_the_slope_of_the_energy_and_the_hessian_that_of_the_gradient() {
    let mesh = FlatMesh { held: vec![2], ..rectangle(5, 0.5) };
    let settings = Settings { thickness: 0.2, ..Settings::default() };
    let rib = Rib { stiffness: 5.0, along: [0.5, 0.2, 0.4] };
    let sheet = Sheet::new(&settings, &mesh, 1.0, &vec![rib; mesh.triangles.len()]).unwrap();
    let rest = Rest { weight: 3.0, ..bent_to(&sheet, [1.5, 0.4, -0.7]) };
    let positions = crumpled(&sheet, 0.03);
    let numbers: Vec<u32> =
        (0..mesh.positions.len() as u32).map(|v| if v == 2 { u32::MAX } else { v - u32::from(v > 2) }).collect();
    let pairs = couplings(&sheet).map(|pair| pair.map(|v| numbers[v as usize])).filter(|p| !p.contains(&u32::MAX));
    let mut matrix = Matrix::new(mesh.positions.len() - 1, pairs);
    let places = Places::new(&sheet, numbers.clone(), &matrix);
    let bent = Bent::new(&sheet, &rest, &positions);
    let gradient = bent.gradient();
    bent.hessian(&places, &mut matrix, None);
    let width = 1e-6;
    let mut stream = Stream::new(8, Purpose::Deformation, 0, 0);
    let direction: Vec<DVec3> = (0..positions.len())
        .map(|v| if v == 2 { DVec3::zeros() } else { DVec3::from_fn(|_, _| stream.range(-1.0, 1.0)) })
        .collect();
    let moved = |by: f64| positions.iter().zip(&direction).map(|(p, d)| p + d * by).collect::<Vec<_>>();
    let (above, below) = (moved(width), moved(-width));
    let slope = (energy(&sheet, &rest, &above) - energy(&sheet, &rest, &below)) / (2.0 * width);
    let promised: f64 = gradient.iter().zip(&direction).map(|(g, d)| g.dot(d)).sum();
    assert!((slope / promised - 1.0).abs() < 1e-6, "{slope} {promised}");
    let mut along = vec![[0.0; 3]; matrix.size()];
    for (v, d) in direction.iter().enumerate().filter(|(v, _)| *v != 2) {
        along[numbers[v] as usize] = (*d).into();
    }
    let product = matrix.times(&along);
    let gradients = [above, below].map(|positions| Bent::new(&sheet, &rest, &positions).gradient());
    let size = product.iter().flatten().fold(0.0, |a: f64, x| a.max(x.abs()));
    for v in (0..positions.len()).filter(|&v| v != 2) {
        let difference = (gradients[0][v] - gradients[1][v]) / (2.0 * width);
        let row = DVec3::from(product[numbers[v] as usize]);
        assert!((difference - row).norm() < 1e-6 * size, "{v} {difference} {row}");
    }
}

#[test]
fn forces_neither_push_nor_turn_and_energy_does_not_see_rigid_motion() {
    let sheet = sheet(&Settings::default(), &rectangle(8, 0.4));
    let rest = bent_to(&sheet, [3.0, 0.5, 1.0]);
    let positions = crumpled(&sheet, 0.01);
    let gradient = Bent::new(&sheet, &rest, &positions).gradient();
    let size = gradient.iter().map(|g| g.norm()).sum::<f64>();
    let (push, turn) = positions
        .iter()
        .zip(&gradient)
        .fold((DVec3::zeros(), DVec3::zeros()), |(push, turn), (p, g)| (push + g, turn + p.cross(g)));
    assert!(push.norm() < 1e-12 * size && turn.norm() < 1e-12 * size, "{push} {turn}");
    let axis = DVec3::new(1.0, 2.0, -0.5).normalize();
    let moved: Vec<DVec3> =
        positions.iter().map(|&p| crate::base::vector::rotated(p, axis, 1.1) + DVec3::new(3.0, -2.0, 5.0)).collect();
    assert!((energy(&sheet, &rest, &moved) / energy(&sheet, &rest, &positions) - 1.0).abs() < 1e-11);
}

/// Angle between the directions of the middle line near both ends of a strip, over the length between.
fn curvature_along(sheet: &Sheet, positions: &[DVec3]) -> f64 {
    let near = |x: f64| {
        let distance = |v: &usize| (sheet.places[*v] - DVec2::new(x, 0.0)).norm();
        (0..positions.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap()
    };
    // The circle through three points: 4 area / product of sides.
    let [a, b, c] = [0.2, 0.5, 0.8].map(near).map(|v| positions[v]);
    let (u, v, w) = (b - a, c - b, c - a);
    2.0 * u.cross(&v).norm() / (u.norm() * v.norm() * w.norm())
}

#[test]
fn a_bilayer_strip_curls_to_timoshenkos_curvature() {
    let settings = Settings { thickness: 0.01, ..Settings::default() };
    let error = |columns: u32| {
        let sheet = sheet(&settings, &rectangle(columns, 0.16));
        let rests = [1.0, 2.0].map(|k| bent_to(&sheet, [k, 0.0, 0.0]));
        let positions = settled(&sheet, &rests);
        println!("{} vertices: {}", positions.len(), curvature_along(&sheet, &positions) / 2.0 - 1.0);
        (curvature_along(&sheet, &positions) / 2.0 - 1.0).abs()
    };
    let (coarse, fine) = (error(32), error(64));
    assert!(coarse < 0.02 && fine < 0.5 * coarse + 1e-4, "{coarse} {fine}");
}
