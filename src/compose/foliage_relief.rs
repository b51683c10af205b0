//! The relief of foliage seen from far: tufts of leaves as heights and slopes on a square that wraps at its rim.

use crate::base::random::{Purpose, Stream};

/// Radii of tufts, metres, the share of the height that each size makes up, and how often they cover the square.
const TUFTS: [(f32, f32, f32); 2] = [(0.40, 0.52, 1.5), (0.15, 0.48, 1.9)];

/// Heights and slopes of foliage.
pub(super) struct Relief {
    /// Texels along one side, a power of two.
    side: usize,
    texels: Vec<Tuft>,
}

/// A place of the relief.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tuft {
    /// 0 in the dark between leaves to 1.
    pub height: f32,
    /// Parts of the normal along and up.
    pub slope: [f32; 2],
}

impl Relief {
    /// The relief of a square with this side, texels, and texels of a width in metres, halved so often: coarse texels are the
    /// means of fine ones.
    pub(super) fn new(seed: u64, side: usize, texel: f32, halvings: u32) -> Self {
        let mut heights = vec![0.0f32; side * side];
        for (number, (radius, share, times)) in TUFTS.into_iter().enumerate() {
            let layer = tufts(seed, number as u64, (side, texel), radius, times);
            heights.iter_mut().zip(layer).for_each(|(height, tuft)| *height += share * tuft);
        }
        let heights = averaged(&heights, side, 1 << halvings);
        let (side, texel) = (side >> halvings, texel * (1u32 << halvings) as f32);
        let at = |column: usize, row: usize| heights[row % side * side + column % side];
        let texels = (0..side * side).map(|place| {
            let (column, row) = (place % side, place / side);
            // Heights are of the order of a tuft's radius.
            let slope = |ahead: f32, behind: f32| ((behind - ahead) * 0.45 * 0.5 / texel.max(0.1)).clamp(-0.9, 0.9);
            let along = slope(at(column + 1, row), at(column + side - 1, row));
            let up = slope(at(column, row + 1), at(column, row + side - 1));
            Tuft { height: heights[place], slope: [along, up] }
        });
        Self { side, texels: texels.collect() }
    }

    /// The place at a column and a row, from the foot up; it repeats.
    #[inline]
    pub(super) fn at(&self, column: usize, row: usize) -> Tuft {
        self.texels[(row & (self.side - 1)) * self.side + (column & (self.side - 1))]
    }
}

/// The means of squares of texels.
fn averaged(heights: &[f32], side: usize, block: usize) -> Vec<f32> {
    let coarse = side / block;
    let mean = |place: usize| {
        let (column, row) = (place % coarse * block, place / coarse * block);
        let rows = (row..row + block).map(|row| heights[row * side + column..][..block].iter().sum::<f32>());
        rows.sum::<f32>() / (block * block) as f32
    };
    (0..coarse * coarse).map(mean).collect()
}

/// Domes of one size, 0..1, the highest at each texel.
fn tufts(seed: u64, layer: u64, (side, texel): (usize, f32), radius: f32, times: f32) -> Vec<f32> {
    let mut heights = vec![0.0f32; side * side];
    let span = side as f32 * texel;
    let count = (times * span * span / (std::f32::consts::PI * radius * radius)) as u64;
    for number in 0..count {
        let mut random = Stream::new(seed, Purpose::Surroundings, number, 60 + layer);
        let [x, y] = [0, 1].map(|_| random.uniform() as f32 * side as f32);
        let top = random.range(0.6, 1.0) as f32;
        let reach = (radius / texel * random.range(0.7, 1.3) as f32).max(0.5);
        let range = |middle: f32| (middle - reach).floor() as i64..=(middle + reach) as i64;
        for (row, column) in range(y).flat_map(|row| range(x).map(move |column| (row, column))) {
            let (across, up) = ((column as f32 + 0.5 - x) / reach, (row as f32 + 0.5 - y) / reach);
            let dome = top * (1.0 - across * across - up * up).max(0.0).sqrt();
            let wrapped = |place: i64| place.rem_euclid(side as i64) as usize;
            let height = &mut heights[wrapped(row) * side + wrapped(column)];
            *height = height.max(dome);
        }
    }
    heights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_relief_wraps_and_its_mean_does_not_depend_on_the_texels() {
        let [fine, coarse] = [0, 2].map(|halvings| Relief::new(1, 128, 0.1, halvings));
        let mean =
            |relief: &Relief| relief.texels.iter().map(|tuft| tuft.height).sum::<f32>() / relief.texels.len() as f32;
        assert!((mean(&fine) - mean(&coarse)).abs() < 1e-4, "{} {}", mean(&fine), mean(&coarse));
        assert_eq!(fine.at(3, 5).height, fine.at(131, 133).height);
        let slopes = fine.texels.iter().map(|tuft| tuft.slope[0]).sum::<f32>() / fine.texels.len() as f32;
        assert!(slopes.abs() < 1e-3, "as much rises as falls: {slopes}");
        assert!(fine.texels.iter().all(|tuft| (0.0..=1.0).contains(&tuft.height)));
    }
}
