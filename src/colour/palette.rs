//! The colours of one state tabulated over chlorophyll, anthocyanins and brown pigment: painting looks them up by the million.

use super::Pigments;
use super::appearance::Optics;

/// Nodes along the three axes.
const NODES: [usize; 3] = [17, 13, 10];

/// Gloss-free reflected colour, then transmitted colour, both clipped to 0 and above.
pub(super) type Pair = [f32; 6];

/// A table of colours; each axis is spaced by squares, since the first micrograms change a colour most.
#[derive(Clone, Debug)]
pub(super) struct Palette {
    /// The largest content on each axis.
    most: [f32; 3],
    colours: Vec<Pair>,
}

impl Palette {
    /// Tabulates the surroundings of a state's contents.
    pub(super) fn new(optics: &Optics, pigments: &Pigments) -> Self {
        let most = [
            (4.0 * pigments.chlorophyll).max(20.0),
            (3.5 * pigments.anthocyanins).max(6.0),
            (3.0 * pigments.brown).max(2.5),
        ];
        let content = |axis: usize, node: usize| {
            let part = node as f64 / (NODES[axis] - 1) as f64;
            most[axis] * part * part
        };
        let mut colours = Vec::with_capacity(NODES.iter().product());
        for node in 0..NODES.iter().product() {
            let (chlorophyll, rest) = (node % NODES[0], node / NODES[0]);
            colours.push(pair(
                optics,
                &Pigments {
                    chlorophyll: content(0, chlorophyll),
                    anthocyanins: content(1, rest % NODES[1]),
                    brown: content(2, rest / NODES[1]),
                    ..pigments.clone()
                },
            ));
        }
        Self { most: most.map(|m| m as f32), colours }
    }

    /// The colours of contents (chlorophyll, anthocyanins, brown), trilinear; beyond the table its rim.
    pub(super) fn at(&self, contents: [f32; 3]) -> Pair {
        let mut places = [(0usize, 0f32); 3];
        for axis in 0..3 {
            let last = NODES[axis] - 1;
            let place = (contents[axis] / self.most[axis]).clamp(0.0, 1.0).sqrt() * last as f32;
            let node = (place as usize).min(last - 1);
            // Linear in the content within a cell, although nodes are spaced by squares.
            let (low, high) = (node as f32 / last as f32, (node + 1) as f32 / last as f32);
            let content = (contents[axis] / self.most[axis]).clamp(0.0, 1.0);
            places[axis] = (node, (content - low * low) / (high * high - low * low));
        }
        let mut sum = [0.0; 6];
        for corner in 0..8usize {
            let (mut weight, mut node, mut stride) = (1.0, 0, 1);
            for (axis, &(first, part)) in places.iter().enumerate() {
                let upper = corner >> axis & 1;
                weight *= if upper == 1 { part } else { 1.0 - part };
                node += (first + upper) * stride;
                stride *= NODES[axis];
            }
            for (total, colour) in sum.iter_mut().zip(&self.colours[node]) {
                *total += weight * colour;
            }
        }
        sum
    }
}

/// The colours of one set of contents as a texture holds them.
pub(super) fn pair(optics: &Optics, pigments: &Pigments) -> Pair {
    let found = optics.appearance(pigments);
    let gloss = optics.gloss();
    let mut pair = [0.0; 6];
    for channel in 0..3 {
        pair[channel] = (found.reflected[channel] - gloss[channel]).max(0.0) as f32;
        pair[channel + 3] = found.transmitted[channel].max(0.0) as f32;
    }
    pair
}

#[cfg(test)]
mod tests {
    use super::super::{Table, colour_difference};
    use super::*;
    use crate::base::random::hash_unit;

    #[test]
    fn looked_up_colours_are_those_computed() {
        let optics = Optics::new(Table::Coarse);
        for (chlorophyll, anthocyanins, brown) in
            [(38.0, 3.6, 0.06), (5.0, 2.5, 0.1), (1.0, 11.0, 0.04), (0.5, 1.5, 1.3)]
        {
            let state = Pigments { chlorophyll, anthocyanins, brown, ..Pigments::default() };
            let palette = Palette::new(&optics, &state);
            let mut worst = 0.0f64;
            for draw in 0..60 {
                let factor = |axis| f64::from(hash_unit(draw, axis)) * 2.0;
                let contents = Pigments {
                    chlorophyll: chlorophyll * factor(0),
                    anthocyanins: anthocyanins * factor(1),
                    brown: brown * factor(2),
                    ..state.clone()
                };
                let exact = pair(&optics, &contents);
                let found = palette.at([contents.chlorophyll, contents.anthocyanins, contents.brown].map(|c| c as f32));
                for half in [0, 3] {
                    let colour = |p: &Pair| std::array::from_fn(|c| f64::from(p[half + c]));
                    worst = worst.max(colour_difference(colour(&exact), colour(&found)));
                }
            }
            assert!(worst < 1.5, "dE {worst} at chlorophyll {chlorophyll}");
        }
    }
}
