//! The meshes on which a leaf is solved: its own, and for a fine one coarser ones, each the start of the next.

use super::coarse::{Return, coarsened};
use super::drying::{Drying, Irregularity};
use super::newton::Plan;
use super::settings::Settings;
use super::sheet::Sheet;
use super::tissue::Tissue;
use crate::base::flat_mesh::FlatMesh;
use crate::base::vector::DVec2;
use crate::deform::Flat;

/// Vertices from which on a coarser mesh is worth its while, and how many times fewer it has.
const FINE: usize = 6000;
const RATIO: usize = 6;

/// One of the meshes.
pub struct Level {
    /// Its sheet.
    pub sheet: Sheet,
    /// Its tissue.
    pub tissue: Tissue,
    /// Its solver's plan.
    pub plan: Plan,
    /// The way here from the next coarser level.
    pub way: Option<Return>,
}

impl Level {
    /// All levels of a leaf, the finest first.
    pub fn all(settings: &Settings, flat: &Flat) -> Vec<Self> {
        let tissue = Tissue::new(settings, flat);
        let sheet = Sheet::new(settings, flat.mesh, tissue.extent, &tissue.ribs);
        let plan = Plan::new(&sheet);
        let mut finest = Self { sheet, tissue, plan, way: None };
        let count = flat.mesh.positions.len();
        if count < FINE {
            return vec![finest];
        }
        let coarse = coarsened(flat.mesh, count / RATIO);
        // A mesh that can hardly be made coarser is solved as it is.
        if coarse.positions.len() * 2 > count || coarse.triangles.is_empty() {
            return vec![finest];
        }
        let rest = Self::all(settings, &Flat { mesh: &coarse, mask: flat.mask });
        let scaled: Vec<DVec2> = coarse.positions.iter().map(|p| p / finest.tissue.extent).collect();
        finest.way = Some(Return::new(FlatMesh { positions: scaled, ..coarse }, &finest.sheet.places));
        std::iter::once(finest).chain(rest).collect()
    }

    /// How a variant dries.
    pub fn drying<'a>(&'a self, settings: &'a Settings, irregularity: &Irregularity) -> Drying<'a> {
        Drying::new(settings, &self.sheet, &self.tissue, irregularity)
    }

    /// Bytes that a solver takes on this level.
    pub fn bytes(&self) -> f64 {
        self.plan.bytes() + BYTES_A_VERTEX * self.sheet.places.len() as f64
    }
}

/// Bytes for each vertex besides the factor: sheet, tissue, folds with their derivatives, the Hessian with its places, and
/// vectors. Measured.
const BYTES_A_VERTEX: f64 = 7000.0;

/// Bytes that a leaf of so many vertices takes at least, before anything of it is built: what is taken for each vertex, and a
/// factor of nested dissection, which grows with the vertices times their logarithm.
pub fn foreseen_bytes(vertices: usize) -> f64 {
    let count = vertices as f64;
    let doublings = f64::from(usize::BITS - vertices.leading_zeros());
    count * (BYTES_A_VERTEX + BYTES_A_DOUBLING * doublings)
}

/// Bytes of the factor for each vertex and each doubling of their number. Measured.
const BYTES_A_DOUBLING: f64 = 600.0;

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of so many vertices a side.
    fn square(side: u32) -> FlatMesh {
        let cell = |x: u32, y: u32| {
            let [a, b] = [y * side + x, (y + 1) * side + x];
            [[a, a + 1, b + 1], [a, b + 1, b]]
        };
        let place = |i: u32| DVec2::new(f64::from(i % side), f64::from(i / side));
        FlatMesh {
            positions: (0..side * side).map(place).collect(),
            triangles: (0..side - 1).flat_map(|y| (0..side - 1).flat_map(move |x| cell(x, y))).collect(),
            greys: vec![0.0; (side * side) as usize],
            held: vec![0, 1, side],
            ..FlatMesh::default()
        }
    }

    #[test]
    fn what_is_foreseen_is_what_the_levels_take() {
        for (side, meshes) in [(20, 1), (50, 1), (80, 2)] {
            let mesh = square(side);
            let levels = Level::all(&Settings::default(), &Flat::from(&mesh));
            assert_eq!(levels.len(), meshes);
            let bytes: f64 = levels.iter().map(Level::bytes).sum();
            let foreseen = foreseen_bytes(mesh.positions.len());
            assert!(foreseen > 0.8 * bytes && foreseen < 1.6 * bytes, "{side}: {foreseen} {bytes}");
        }
    }
}
