//! Closed forms, conservation and derivatives of the sheet.
use super::energy::{Bent, Places, Rest, couplings, energy, stretches};
use super::fold::Fold;
use super::newton::{Plan, Solver};
use super::plates::rectangle;
use super::settings::Settings;
use super::sheet::{Rib, Sheet, Spring, Tensor};
use crate::base::flat_mesh::FlatMesh;
use crate::base::random::{Purpose, Stream};
use crate::base::vector::{DVec2, DVec3};
use crate::deform::cholesky::Matrix;

fn sheet(settings: &Settings, mesh: &FlatMesh) -> Sheet {
    Sheet::new(settings, mesh, 1.0, &vec![Rib::default(); mesh.triangles.len()])
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

/// The shapes of a sheet under one load after another, from flat.
fn settled(sheet: &Sheet, rests: &[Rest]) -> Vec<DVec3> {
    settled_from(sheet, flat(sheet), rests)
}

fn settled_from(sheet: &Sheet, mut positions: Vec<DVec3>, rests: &[Rest]) -> Vec<DVec3> {
    let mut solver = Solver::new(sheet, &Plan::new(sheet));
    let mut before = &rests[0];
    for rest in rests {
        let outcome = solver.settle((before, rest), &mut positions, 1e-6, 300);
        assert!(outcome.is_ok(), "{outcome:?}");
        before = rest;
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
    let rib = Rib { stiffness: 5.0, along: [0.5, 0.2, 0.4], thickening: 2.0 };
    let sheet = Sheet::new(&settings, &mesh, 1.0, &vec![rib; mesh.triangles.len()]);
    let rest = Rest { weight: 3.0, ..bent_to(&sheet, [1.5, 0.4, -0.7]) };
    let positions = crumpled(&sheet, 0.03);
    let numbers: Vec<u32> =
        (0..mesh.positions.len() as u32).map(|v| if v == 2 { u32::MAX } else { v - u32::from(v > 2) }).collect();
    let pairs = couplings(&sheet).map(|pair| pair.map(|v| numbers[v as usize])).filter(|p| !p.contains(&u32::MAX));
    let mut matrix = Matrix::new(mesh.positions.len() - 1, pairs);
    let places = Places::new(&sheet, numbers.clone(), &matrix);
    let bent = Bent::new(&sheet, &rest, &positions);
    let gradient = bent.gradient();
    bent.hessian(&places, &mut matrix, &stretches(&sheet, &rest, &positions, &positions), false);
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

/// Curvature of the circle through three material points of a sheet of rectangles.
fn curvature_through(sheet: &Sheet, positions: &[DVec3], points: [[f64; 2]; 3]) -> f64 {
    let near = |point: [f64; 2]| {
        let distance = |v: &usize| (sheet.places[*v] - DVec2::from(point)).norm();
        (0..positions.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap()
    };
    let [a, b, c] = points.map(near).map(|v| positions[v]);
    let (u, v, w) = (b - a, c - b, c - a);
    2.0 * u.cross(&v).norm() / (u.norm() * v.norm() * w.norm())
}

/// Mean curvature tensor of the triangles with three hinges within a box of the flat sheet.
fn curvature_within(sheet: &Sheet, positions: &[DVec3], low: [f64; 2], high: [f64; 2]) -> Tensor {
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    for plate in &sheet.plates {
        let middle = plate.middle(&sheet.places);
        let inside = |k: usize| (low[k]..high[k]).contains(&middle[k]);
        if plate.hinges.contains(&u32::MAX) || !inside(0) || !inside(1) {
            continue;
        }
        let corners = plate.corners.map(|v| sheet.places[v as usize]);
        let doubled_area = (corners[1] - corners[0]).perp(&(corners[2] - corners[0]));
        for i in 0..3 {
            let side = corners[(i + 1) % 3] - corners[i];
            let fold = Fold::value(sheet.hinges[plate.hinges[i] as usize].map(|v| positions[v as usize]));
            let scale = fold / (doubled_area * side.norm());
            let normal = [side.y * side.y, -side.x * side.y, side.x * side.x];
            sum.iter_mut().zip(normal).for_each(|(s, n)| *s += n * scale);
        }
        count += 1.0;
    }
    sum.map(|s| s / count)
}

#[test]
fn a_bilayer_strip_curls_to_timoshenkos_curvature() {
    let error = |columns: u32| {
        let sheet = sheet(&Settings::default(), &rectangle(columns, 0.16));
        let rests = [1.0, 2.0].map(|k| bent_to(&sheet, [k, 0.0, 0.0]));
        let positions = settled(&sheet, &rests);
        (curvature_through(&sheet, &positions, [[0.2, 0.0], [0.5, 0.0], [0.8, 0.0]]) / 2.0 - 1.0).abs()
    };
    // 126, 234 and 851 vertices.
    let errors = [20, 32, 64].map(error);
    assert!(errors[0] < 0.02 && errors[1] < 0.01, "{errors:?}");
    assert!(errors[2] < 0.5 * errors[1], "{errors:?}");
}

#[test]
fn a_small_even_mismatch_makes_a_sphere() {
    let settings = Settings { thickness: 0.05, ..Settings::default() };
    let sheet = sheet(&settings, &rectangle(32, 0.16));
    let positions = settled(&sheet, &[bent_to(&sheet, [0.2, 0.0, 0.2])]);
    let [along, shear, across] = curvature_within(&sheet, &positions, [0.2, -0.08], [0.8, 0.08]);
    assert!((along / 0.2 - 1.0).abs() < 0.01 && (across / 0.2 - 1.0).abs() < 0.01, "{along} {across}");
    assert!(shear.abs() < 0.002, "{shear}");
}

#[test]
fn a_large_even_mismatch_makes_a_cylinder_of_one_plus_poissons_ratio() {
    for poisson_ratio in [0.0, 1.0 / 3.0] {
        let settings = Settings { thickness: 0.005, poisson_ratio, ..Settings::default() };
        let sheet = sheet(&settings, &rectangle(16, 1.0));
        // A push towards a cylinder about y, which is then taken away.
        let mut rests = vec![bent_to(&sheet, [1.0, 0.0, 0.0])];
        rests.extend([1.0, 2.0, 3.0].map(|k| bent_to(&sheet, [k, 0.0, k])));
        let positions = settled(&sheet, &rests);
        let [along, _, across] = curvature_within(&sheet, &positions, [0.25, -0.25], [0.75, 0.25]);
        let expected = (1.0 + poisson_ratio) * 3.0;
        assert!((along / expected - 1.0).abs() < 0.1 && across.abs() < 0.1, "{poisson_ratio}: {along} {across}");
    }
}

#[test]
fn a_heavy_strip_hangs_as_the_elastica() {
    // Place of the tip and drop over the length, by shooting to 1e-12.
    for (weight, reach, drop) in [(1.0, 0.991_246_4, 0.123_471_4), (10.0, 0.656_353_8, 0.700_199_7)] {
        let settings = Settings { poisson_ratio: 0.0, thickness: 2e-3, ..Settings::default() };
        let mut mesh = rectangle(21, 0.1);
        let pitch = 1.0 / 21.0;
        mesh.held = (0..mesh.positions.len() as u32).filter(|&v| mesh.positions[v as usize].x < 1.51 * pitch).collect();
        let sheet = sheet(&settings, &mesh);
        let length = 1.0 - pitch;
        let load = |share: f64| Rest {
            weight: share * weight / (length * length * length),
            ..bent_to(&sheet, [0.0, 0.0, 0.0])
        };
        let positions = settled(&sheet, &[0.25, 0.5, 1.0].map(load));
        let tips: Vec<DVec3> =
            (0..positions.len()).filter(|&v| sheet.places[v].x > 0.999).map(|v| positions[v]).collect();
        let tip = tips.iter().sum::<DVec3>() / tips.len() as f64;
        let found = ((tip.x - pitch) / length, -tip.z / length);
        assert!((found.0 - reach).abs() < 0.01 && (found.1 - drop).abs() < 0.01, "{weight}: {found:?}");
    }
}

#[test]
fn a_chain_hangs_as_the_catenary() {
    for (span, sag) in [(0.9, 0.190_709_0), (0.5, 0.398_194_2)] {
        let links = 40;
        let place = |i: u32| DVec2::new(f64::from(i) / f64::from(links), 0.0);
        let spring = |i: u32| Spring { ends: [i, i + 1], length: 1.0 / f64::from(links), stiffness: 1e6 };
        let sheet = Sheet {
            places: (0..=links).map(place).collect(),
            areas: vec![1.0 / f64::from(links); links as usize + 1],
            springs: (0..links).map(spring).collect(),
            hinges: Vec::new(),
            plates: Vec::new(),
            held: (0..=links).map(|i| i == 0 || i == links).collect(),
        };
        let rest = Rest { lengths: vec![1.0 / f64::from(links); links as usize], folds: Vec::new(), weight: 1.0 };
        let start = |p: &DVec2| DVec3::new(p.x * span, 0.0, -4.0 * sag * p.x * (1.0 - p.x));
        let start = sheet.places.iter().map(start).collect();
        let positions = settled_from(&sheet, start, &[rest]);
        let lowest = positions.iter().map(|p| -p.z).fold(0.0, f64::max);
        assert!((lowest / sag - 1.0).abs() < 0.005, "{span}: {lowest}");
    }
}

#[test]
fn a_flat_start_that_wants_to_buckle_is_left() {
    // The rim shrinks, the middle does not: flat, every force lies in the plane, and the energy is no minimum.
    let sheet = sheet(&Settings { thickness: 0.005, ..Settings::default() }, &rectangle(16, 1.0));
    let middle = DVec2::new(0.5, 0.0);
    let length = |spring: &Spring| {
        let place = spring.ends.iter().map(|&v| sheet.places[v as usize]).sum::<DVec2>() * 0.5;
        spring.length * (1.0 - 0.1 * (place - middle).norm())
    };
    let rest = Rest { lengths: sheet.springs.iter().map(length).collect(), ..bent_to(&sheet, [0.0; 3]) };
    let mut positions = flat(&sheet);
    let outcome = Solver::new(&sheet, &Plan::new(&sheet)).settle((&rest, &rest), &mut positions, 1e-5, 200).unwrap();
    assert!(outcome.saddles > 0, "{outcome:?}");
    assert!(positions.iter().map(|p| p.z.abs()).fold(0.0, f64::max) > 0.05);
    assert!(outcome.energy < 0.5 * energy(&sheet, &rest, &flat(&sheet)));
}

#[test]
fn a_saddle_curvature_gives_a_symmetric_shape() {
    let sheet = sheet(&Settings::default(), &rectangle(16, 0.6));
    let rests = [1.0, 3.0].map(|k| bent_to(&sheet, [k, 0.0, -k]));
    let mut positions = settled(&sheet, &rests);
    super::alignment::laid_onto(&sheet.places, &sheet.areas, &mut positions);
    assert!(positions.iter().map(|p| p.z.abs()).fold(0.0, f64::max) > 0.05);
    for (p, place) in positions.iter().zip(&sheet.places) {
        let mirrored = DVec2::new(1.0 - place.x, place.y);
        let twin = sheet.places.iter().position(|q| (q - mirrored).norm() < 1e-9).unwrap();
        let q = positions[twin];
        assert!((p - DVec3::new(1.0 - q.x, q.y, q.z)).norm() < 1e-4, "{p} {q}");
    }
}
