//! Rectangles in place of leaves: sheets whose natural curvature and lengths are given by a formula, for tests and studies.

use super::alignment;
use super::energy::{Rest, energy};
use super::newton::{Plan, Solver};
use super::settings::Settings;
use super::sheet::{Rib, Sheet, Spring};
use crate::base::flat_mesh::FlatMesh;
use crate::base::vector::{DVec2, DVec3};

/// Tolerance of the shapes, and the most iterations towards one.
const TOLERANCE: f64 = 1e-9;
const ITERATIONS: u32 = 300;

/// A rectangle that has settled.
#[derive(Clone, Debug, PartialEq)]
pub struct Settled {
    /// Its vertices when flat: 0 to 1 along x, about 0 across.
    pub places: Vec<DVec2>,
    /// Where they are now, laid onto the flat rectangle.
    pub positions: Vec<DVec3>,
    /// Iterations of all loads.
    pub iterations: u64,
    /// Saddles of the energy that were left by a push, since the matrix was not positive definite there.
    pub saddles: u64,
    /// Energy over that of the flat rectangle under the last load.
    pub energy_share: f64,
}

/// A rectangle of length 1 under one natural curvature (xx, xy, yy) after another, from flat, that nothing holds. Its springs
/// are shorter by the share `rim_shrink` times their distance from the middle.
#[must_use]
pub fn settled(
    settings: &Settings,
    (columns, width): (u32, f64),
    curvatures: &[[f64; 3]],
    rim_shrink: f64,
) -> Option<Settled> {
    let mesh = rectangle(columns.max(1), width);
    let sheet = Sheet::new(settings, &mesh, 1.0, &vec![Rib::default(); mesh.triangles.len()]);
    let middle = DVec2::new(0.5, 0.0);
    let length = |spring: &Spring| {
        let place = spring.ends.iter().map(|&v| sheet.places[v as usize]).sum::<DVec2>() * 0.5;
        spring.length * (1.0 - rim_shrink * (place - middle).norm())
    };
    let rest = |curvature: &[f64; 3]| Rest {
        lengths: sheet.springs.iter().map(length).collect(),
        folds: (0..sheet.plates.len()).map(|plate| sheet.folds(plate, *curvature)).collect(),
        weight: 0.0,
    };
    let rests: Vec<Rest> = curvatures.iter().map(rest).collect();
    let flat: Vec<DVec3> = sheet.places.iter().map(|p| DVec3::new(p.x, p.y, 0.0)).collect();
    let mut solver = Solver::new(&sheet, &Plan::new(&sheet));
    let (mut positions, mut before) = (flat.clone(), rests.first()?);
    let (mut iterations, mut saddles) = (0, 0);
    for rest in &rests {
        let outcome = solver.settle((before, rest), &mut positions, TOLERANCE, ITERATIONS).ok()?;
        iterations += outcome.iterations;
        saddles += outcome.saddles;
        before = rest;
    }
    let energy_share = energy(&sheet, before, &positions) / energy(&sheet, before, &flat);
    alignment::laid_onto(&sheet.places, &sheet.areas, &mut positions);
    Some(Settled { places: sheet.places.clone(), positions, iterations, saddles, energy_share })
}

/// A rectangle of nearly equilateral triangles, `columns` of them along its length 1 and of the given width.
#[must_use]
pub fn rectangle(columns: u32, width: f64) -> FlatMesh {
    let pitch = 1.0 / f64::from(columns);
    let rows = ((width / (pitch * 0.75f64.sqrt())).round() as u32).max(1);
    let mut mesh = FlatMesh::default();
    // Odd rows are shifted by half a pitch and have their ends cut off, with a vertex at each end.
    let row_length = |row: u32| if row.is_multiple_of(2) { columns + 1 } else { columns + 2 };
    let place = |row: u32, i: u32| {
        let x = if row.is_multiple_of(2) { f64::from(i) } else { (f64::from(i) - 0.5).clamp(0.0, f64::from(columns)) };
        DVec2::new(x * pitch, f64::from(row) / f64::from(rows) * width - 0.5 * width)
    };
    let mut starts = Vec::new();
    for row in 0..=rows {
        starts.push(mesh.positions.len() as u32);
        mesh.positions.extend((0..row_length(row)).map(|i| place(row, i)));
    }
    for row in 0..rows {
        let (low, high) = (starts[row as usize], starts[row as usize + 1]);
        if row.is_multiple_of(2) {
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
