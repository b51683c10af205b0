//! Reflectance and transmittance of a leaf of one structure, tabulated over optical depth: palettes ask for them a hundred
//! thousand times, and pigments enter the plate model by their depth alone.

use super::Pigments;
use super::appearance::Optics;
use super::plate::{self, Faces, Shares};

/// Depths tabulated for each wavelength.
const DEPTHS: usize = 128;
/// The largest optical depth of a whole leaf that is told apart; what is deeper is black.
const DEEPEST: f64 = 40.0;

/// Shares by wavelength and depth.
pub(super) struct SpectraTable<'a> {
    optics: &'a Optics,
    /// Share of the surface's reflection that is left out: 1 where a gloss lobe stands for it, else 0.
    surface: f32,
    /// For each wavelength, the reflected and the transmitted share at each depth.
    shares: Vec<[(f32, f32); DEPTHS]>,
}

impl<'a> SpectraTable<'a> {
    pub(super) fn new(optics: &'a Optics, structure: f64, glossy: bool) -> Self {
        let surface = if glossy { 1.0 } else { 0.0 };
        let line = |faces: &Faces| {
            std::array::from_fn(|node| {
                let part = node as f64 / (DEPTHS - 1) as f64;
                let Shares { reflected, transmitted } = plate::leaf_of_depth(faces, DEEPEST * part * part, structure);
                (reflected as f32, transmitted as f32)
            })
        };
        Self { optics, surface, shares: optics.samples().map(|sample| line(&sample.faces)).collect() }
    }

    /// Linear sRGB of the reflected light, without the gloss of a glossy surface, and of the transmitted light, unclipped.
    pub(super) fn colours(&self, pigments: &Pigments) -> ([f32; 3], [f32; 3]) {
        let (mut reflected, mut transmitted) = ([0.0f32; 3], [0.0f32; 3]);
        for (sample, line) in self.optics.samples().zip(&self.shares) {
            let depth = plate::depth(sample.wavelength, pigments);
            let place = ((depth / DEEPEST).min(1.0).sqrt() * (DEPTHS - 1) as f64) as f32;
            let node = (place as usize).min(DEPTHS - 2);
            let part = place - node as f32;
            let (low, high) = (line[node], line[node + 1]);
            let surface = (1.0 - sample.faces.entry) as f32 * self.surface;
            let r = low.0 + (high.0 - low.0) * part - surface;
            let t = low.1 + (high.1 - low.1) * part;
            for c in 0..3 {
                let weight = sample.weights[c] as f32;
                reflected[c] += weight * r;
                transmitted[c] += weight * t;
            }
        }
        (reflected, transmitted)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Table;
    use super::*;

    #[test]
    fn tabulated_colours_are_those_of_the_model() {
        let optics = Optics::new(Table::Coarse);
        let gloss = optics.gloss();
        for structure in [1.0, 1.5, 2.4] {
            let table = SpectraTable::new(&optics, structure, true);
            for (chlorophyll, anthocyanins, brown) in
                [(0.0, 0.0, 0.0), (38.0, 3.0, 0.1), (1.0, 24.0, 0.2), (0.3, 1.0, 3.0)]
            {
                let pigments = Pigments { structure, chlorophyll, anthocyanins, brown, ..Pigments::default() };
                let (reflected, transmitted) = table.colours(&pigments);
                let exact = optics.appearance(&pigments);
                for c in 0..3 {
                    let expected = exact.reflected[c] - gloss[c];
                    assert!((f64::from(reflected[c]) - expected).abs() < 8e-4, "{reflected:?} {exact:?}");
                    assert!(
                        (f64::from(transmitted[c]) - exact.transmitted[c]).abs() < 8e-4,
                        "{transmitted:?} {exact:?}"
                    );
                }
            }
        }
    }
}
