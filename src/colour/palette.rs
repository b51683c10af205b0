//! The colours of one state tabulated over chlorophyll, anthocyanins and brown pigment: painting looks them up by the million.

use super::Pigments;
use super::spectra_table::SpectraTable;

/// Nodes along the three axes.
const NODES: [usize; 3] = [17, 13, 10];
/// Share of its anthocyanins and of its chlorophyll that light from below meets before it is sent back: anthocyanin lies
/// under the sunlit epidermis, chlorophyll mostly in the palisade below it (judged).
const BELOW: [f64; 2] = [0.45, 0.85];

/// Linear sRGB of one place of a leaf, clipped to 0 and above: light reflected by the upper side, without surface gloss if it is glossy;
/// light let through; light reflected by the lower side, likewise.
pub(super) type Look = [f32; 9];

/// A node: a look and padding, so that lookups run in whole vectors.
type Node = [f32; 12];

/// A table of colours; each axis is spaced by squares, since the first micrograms change a colour most.
#[derive(Clone, Debug)]
pub(super) struct Palette {
    /// The inverse of the largest content on each axis.
    scale: [f32; 3],
    nodes: Vec<Node>,
}

impl Palette {
    /// Tabulates contents up to `most` (chlorophyll, anthocyanins, brown) beside a state's other contents, whose structure the
    /// table has, below a colourless layer of reflectance `pallor` on the lower side.
    pub(super) fn new(table: &SpectraTable<'_>, pigments: &Pigments, most: [f32; 3], pallor: f32) -> Self {
        let content = |axis: usize, node: usize| {
            let part = node as f64 / (NODES[axis] - 1) as f64;
            f64::from(most[axis]) * part * part
        };
        let mut nodes = Vec::with_capacity(NODES.iter().product());
        for node in 0..NODES.iter().product() {
            let (chlorophyll, rest) = (node % NODES[0], node / NODES[0]);
            let contents = Pigments {
                chlorophyll: content(0, chlorophyll),
                anthocyanins: content(1, rest % NODES[1]),
                brown: content(2, rest / NODES[1]),
                ..pigments.clone()
            };
            let mut padded = [0.0; 12];
            padded[..9].copy_from_slice(&look_in(table, &contents, pallor));
            nodes.push(padded);
        }
        Self { scale: most.map(|m| 1.0 / m.max(1e-6)), nodes }
    }

    /// The look of contents (chlorophyll, anthocyanins, brown), trilinear; beyond the table its rim.
    #[inline]
    pub(super) fn at(&self, contents: [f32; 3]) -> Look {
        let (i, u) = place::<{ NODES[0] }>(contents[0] * self.scale[0]);
        let (j, v) = place::<{ NODES[1] }>(contents[1] * self.scale[1]);
        let (k, w) = place::<{ NODES[2] }>(contents[2] * self.scale[2]);
        let first = (k * NODES[1] + j) * NODES[0] + i;
        let (plane, row) = (NODES[0] * NODES[1], NODES[0]);
        // One bounds check for all eight corners.
        let nodes = &self.nodes[first..first + plane + row + 2];
        let rows = [(0, (1.0 - v) * (1.0 - w)), (row, v * (1.0 - w)), (plane, (1.0 - v) * w), (plane + row, v * w)];
        let mut sum: Node = [0.0; 12];
        for (at, weight) in rows {
            let (low, high) = (weight * (1.0 - u), weight * u);
            let (a, b) = (&nodes[at], &nodes[at + 1]);
            for c in 0..12 {
                sum[c] += low * a[c] + high * b[c];
            }
        }
        let mut look = [0.0; 9];
        look.copy_from_slice(&sum[..9]);
        look
    }
}

impl Palette {
    /// The contents of the node whose reflected colour is nearest to a colour; among equals the first, that with the least
    /// pigment.
    pub(super) fn nearest(&self, colour: [f32; 3]) -> [f32; 3] {
        let goal = colour.map(f32::sqrt);
        let far = |node: &Node| (0..3).map(|c| (node[c].sqrt() - goal[c]) * (node[c].sqrt() - goal[c])).sum::<f32>();
        let nearest = self.nodes.iter().map(far).enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
        let number = nearest.map_or(0, |(number, _)| number);
        let places = [number % NODES[0], number / NODES[0] % NODES[1], number / NODES[0] / NODES[1]];
        std::array::from_fn(|axis| {
            let part = places[axis] as f32 / (NODES[axis] - 1) as f32;
            part * part / self.scale[axis]
        })
    }
}

/// The node below a share of an axis and the way from it. Linear in the content within a cell, although nodes are spaced
/// by squares.
#[inline]
fn place<const COUNT: usize>(share: f32) -> (usize, f32) {
    let last = (COUNT - 1) as f32;
    let squared = share.clamp(0.0, 1.0) * (last * last);
    let node = below(squared.sqrt()).min(COUNT - 2);
    let low = node as f32;
    (node, (squared - low * low) / (2.0 * low + 1.0))
}

/// The whole number below a number of 0 to 4 million, or at a whole number that itself or the one before: between them a
/// table is continuous. Read off the digits of a float, which takes fewer steps than a conversion.
#[inline]
pub(super) fn below(x: f32) -> usize {
    // Half as much again as 2^23: sums stay where floats are whole numbers, also just below it.
    const WHOLE: f32 = (3u32 << 22) as f32;
    (x - 0.5 + WHOLE).to_bits() as usize & 0x003f_ffff
}

/// The look of one set of contents, as a texture holds it.
pub(super) fn look_in(table: &SpectraTable<'_>, pigments: &Pigments, pallor: f32) -> Look {
    let (upper, through) = table.colours(pigments);
    let below = Pigments {
        anthocyanins: pigments.anthocyanins * BELOW[0],
        chlorophyll: pigments.chlorophyll * BELOW[1],
        ..pigments.clone()
    };
    let (lower, _) = table.colours(&below);
    std::array::from_fn(|c| match c {
        0..3 => upper[c].max(0.0),
        3..6 => through[c - 3].max(0.0),
        _ => paled(lower[c - 6].max(0.0), pallor),
    })
}

/// Reflectance below a colourless layer that reflects `pallor` and lets the rest through (Stokes 1862): dark leaves are
/// lightened most, as measured lower sides are.
fn paled(reflected: f32, pallor: f32) -> f32 {
    let through = 1.0 - pallor;
    pallor + through * through * reflected / (1.0 - pallor * reflected)
}

/// What lies over the pigments.
#[cfg(test)]
#[derive(Clone, Copy, Debug)]
pub(super) struct Finish {
    /// Whether a gloss lobe stands for the reflection of the surface, which is left out then.
    pub glossy: bool,
    /// Reflectance of the colourless layer on the lower side, 0..1.
    pub pallor: f32,
}

#[cfg(test)]
impl Finish {
    pub(super) fn of(settings: &super::Settings) -> Self {
        Self { glossy: settings.gloss, pallor: settings.painting.pallor as f32 }
    }
}

/// The look of one set of contents without a table at hand.
#[cfg(test)]
pub(super) fn look(optics: &super::appearance::Optics, pigments: &Pigments, finish: Finish) -> Look {
    look_in(&SpectraTable::new(optics, pigments.structure, finish.glossy), pigments, finish.pallor)
}

#[cfg(test)]
mod tests {
    use super::super::appearance::Optics;
    use super::super::{Table, colour_difference};
    use super::*;
    use crate::base::random::hash_unit;

    const FINISH: Finish = Finish { glossy: true, pallor: 0.045 };

    #[test]
    fn below_is_the_whole_number_below() {
        for step in 0..40_000u16 {
            let x = f32::from(step) / 16.0;
            let found = below(x) as f32;
            assert!(found == x.floor() || (x.floor() == x && found == x - 1.0), "{x}: {found}");
        }
        assert_eq!(below(0.0), 0);
    }

    #[test]
    fn looked_up_colours_are_those_computed() {
        let optics = Optics::new(Table::Coarse);
        for (chlorophyll, anthocyanins, brown) in
            [(38.0, 3.6, 0.06), (5.0, 2.5, 0.1), (1.0, 11.0, 0.04), (0.5, 1.5, 1.3)]
        {
            let state = Pigments { chlorophyll, anthocyanins, brown, ..Pigments::default() };
            let table = SpectraTable::new(&optics, state.structure, FINISH.glossy);
            let most = [4.0 * chlorophyll as f32, 3.5 * anthocyanins as f32, 3.0];
            let palette = Palette::new(&table, &state, most, FINISH.pallor);
            let mut worst = 0.0f64;
            for draw in 0..60 {
                let factor = |axis| f64::from(hash_unit(draw, axis)) * 2.0;
                let contents = Pigments {
                    chlorophyll: chlorophyll * factor(0),
                    anthocyanins: anthocyanins * factor(1),
                    brown: brown * factor(2),
                    ..state.clone()
                };
                let exact = look(&optics, &contents, FINISH);
                let found = palette.at([contents.chlorophyll, contents.anthocyanins, contents.brown].map(|c| c as f32));
                for part in [0, 3, 6] {
                    let colour = |p: &Look| std::array::from_fn(|c| f64::from(p[part + c]));
                    worst = worst.max(colour_difference(colour(&exact), colour(&found)));
                }
            }
            assert!(worst < 1.5, "dE {worst} at chlorophyll {chlorophyll}");
        }
    }

    #[test]
    fn lower_sides_are_paler_by_what_was_measured() {
        // Measured: 1.2 to 2.4 times as much for green leaves, 0.02 to 0.09 more; 0 to 0.05 more for yellow ones.
        let optics = Optics::new(Table::Coarse);
        let gloss = optics.gloss();
        let more = |pigments: &Pigments| -> [f32; 3] {
            let look = look(&optics, pigments, FINISH);
            std::array::from_fn(|c| look[6 + c] - look[c])
        };
        let green = Pigments::default();
        let upper = optics.appearance(&green).reflected;
        for (c, more) in more(&green).into_iter().enumerate() {
            let ratio = f64::from(more) / upper[c] + 1.0;
            assert!((0.02..0.09).contains(&more) && (1.2..2.4).contains(&ratio), "{c}: {more} {ratio} {gloss:?}");
        }
        let yellow = Pigments { chlorophyll: 1.2, anthocyanins: 0.1, structure: 1.5, ..Pigments::default() };
        assert!(more(&yellow).iter().all(|more| (0.0..0.055).contains(more)), "{:?}", more(&yellow));
    }
}
