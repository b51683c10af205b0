//! The unrolled edge of a wood while it is drawn: lobes of leaves where nothing stands before them, wood by the share of a
//! texel that it covers.

use super::distant_tree::{Lobe, Stroke};
use super::foliage_relief::{Relief, Tuft};
use crate::base::maths::{floor_to_i32, mix};
use crate::base::random::hash;
use rayon::prelude::*;
use std::ops::Range;

/// Rows that are drawn at once.
const BAND: usize = 64;
/// How far tufts carry the rim of a lobe out and in, shares of its radius for a height of 1.
const FRAYED: f32 = 0.90;
/// Mean height of the relief: a lobe of its mean reaches as far as its radius.
const MEAN_HEIGHT: f32 = 0.52;
/// Greatest height that carries a rim on.
const TALLEST: f32 = 0.86;
/// Coverage that counts as closed.
const CLOSED: f32 = 0.995;

/// What a texel shows: leaves, and the wood behind them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Texel {
    /// Of the leaves, towards the meadow, metres.
    pub depth: f32,
    pub normal: [f32; 2],
    pub kind: f32,
    pub light: f32,
    /// Share that leaves cover.
    pub leaves: f32,
    /// Share that wood covers, whatever leaves are before it.
    pub wood: f32,
}

/// A texel that shows what is behind the wood.
pub(super) const EMPTY: Texel =
    Texel { depth: -1e3, normal: [0.0, 0.1], kind: 0.5, light: 0.3, leaves: 0.0, wood: 0.0 };

/// Texels along and up, and the metres that each covers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Grid {
    pub width: usize,
    pub height: usize,
    pub texel: f32,
}

/// What is drawn on the edge.
#[derive(Clone, Copy, Debug)]
pub(super) enum Mark {
    Leaves(Lobe),
    /// Wood before the leaves that lie deeper.
    Trunk(Stroke),
    /// Wood that stands behind whatever leaves there are.
    Twig(Stroke),
}

/// The edge while it is drawn; rows from the tops to the ground.
pub(super) struct Canvas {
    pub grid: Grid,
    pub texels: Vec<Texel>,
}

/// Some rows of the edge, drawn by themselves.
struct Band<'a> {
    grid: Grid,
    texels: &'a mut [Texel],
    /// From the ground.
    rows: Range<i32>,
    /// Texels to a metre.
    per_metre: f32,
    relief: &'a Relief,
}

impl Canvas {
    pub(super) fn new(grid: Grid) -> Self {
        Self { grid, texels: vec![EMPTY; grid.width * grid.height] }
    }

    /// Changes each row by its height, metres.
    pub(super) fn fill(&mut self, change: impl Fn(f32, &mut [Texel]) + Sync) {
        let Grid { width, height, texel } = self.grid;
        self.texels.par_chunks_mut(width).enumerate().for_each(|(row, own)| {
            change(((height - 1 - row) as f32 + 0.5) * texel, own);
        });
    }

    /// Draws marks, the nearest first, in bands of rows at once: a texel depends on no other.
    pub(super) fn paint(&mut self, marks: &[Mark], relief: &Relief) {
        let grid = self.grid;
        self.texels.par_chunks_mut(grid.width * BAND).enumerate().for_each(|(number, texels)| {
            let above = (grid.height - number * BAND) as i32;
            let low = above - (texels.len() / grid.width) as i32;
            let mut band = Band { grid, texels, rows: low..above, per_metre: 1.0 / grid.texel, relief };
            for mark in marks {
                match mark {
                    Mark::Leaves(lobe) => band.lobe(lobe),
                    Mark::Trunk(stroke) => band.stroke(stroke, true),
                    Mark::Twig(stroke) => band.stroke(stroke, false),
                }
            }
        });
    }

    /// Gives texels without leaves the looks of the leaves below them, so that no other colour shows at the rims of crowns.
    pub(super) fn continue_upwards(&mut self) {
        let width = self.grid.width;
        for place in (0..self.texels.len() - width).rev() {
            if self.texels[place].leaves <= 0.0 {
                let Texel { normal, kind, light, .. } = self.texels[place + width];
                let own = &mut self.texels[place];
                (own.normal, own.kind, own.light) = (normal, kind, light);
            }
        }
    }
}

impl Texel {
    /// Lays leaves with a share of coverage before or behind what there is.
    #[inline]
    fn add(&mut self, leaves: &Self) {
        let is_before = leaves.depth > self.depth;
        let total = self.leaves + leaves.leaves * (1.0 - self.leaves);
        // The share of what is seen that is the new.
        let shown = if is_before { leaves.leaves } else { leaves.leaves * (1.0 - self.leaves) } / total.max(1e-6);
        self.normal = [0, 1].map(|k| mix(self.normal[k], leaves.normal[k], shown));
        self.kind = mix(self.kind, leaves.kind, shown);
        self.light = mix(self.light, leaves.light, shown);
        self.leaves = total;
        if shown > 0.5 {
            self.depth = leaves.depth;
        }
    }
}

impl Band<'_> {
    /// The texel on a coordinate, metres.
    #[inline]
    fn place(&self, metres: f32) -> i32 {
        floor_to_i32(metres * self.per_metre)
    }

    fn rows(&self, low: f32, high: f32) -> Range<i32> {
        self.place(low).max(self.rows.start)..(self.place(high) + 1).min(self.rows.end)
    }

    #[inline]
    fn texel(&mut self, column: i32, row: i32) -> &mut Texel {
        // The width is a power of two.
        let column = column as usize & (self.grid.width - 1);
        &mut self.texels[(self.rows.end - 1 - row) as usize * self.grid.width + column]
    }

    /// Draws a lobe where nothing stands before it; tufts of leaves fray its rim.
    fn lobe(&mut self, lobe: &Lobe) {
        let ([x, y, _], [wide, tall]) = (lobe.middle, lobe.radii);
        let reach = 1.0 + FRAYED * (TALLEST - MEAN_HEIGHT);
        let rows = self.rows(y - reach * tall, y + reach * tall);
        if rows.is_empty() {
            return;
        }
        // Each lobe has the relief from a place of its own, or they would all fray alike.
        let bits = hash(x.to_bits().into(), y.to_bits().into()) as usize;
        let (texel, [per_wide, per_tall]) = (self.grid.texel, lobe.radii.map(|radius| 1.0 / radius));
        let hidden = lobe.middle[2] + wide + 0.4;
        for row in rows {
            let up = ((row as f32 + 0.5) * texel - y) * per_tall;
            let half = wide * (reach * reach - up * up).max(0.0).sqrt();
            for column in self.place(x - half)..self.place(x + half) + 1 {
                let own = *self.texel(column, row);
                if own.leaves > CLOSED && own.depth >= hidden {
                    continue;
                }
                let across = ((column as f32 + 0.5) * texel - x) * per_wide;
                let tuft =
                    self.relief.at((column as usize).wrapping_add(bits), (row as usize).wrapping_add(bits >> 16));
                self.leaves(lobe, [column, row], [across, up], tuft);
            }
        }
    }

    #[inline]
    fn leaves(&mut self, lobe: &Lobe, [column, row]: [i32; 2], [across, up]: [f32; 2], tuft: Tuft) {
        let ([wide, tall], depth, per_metre) = (lobe.radii, lobe.middle[2], self.per_metre);
        let reach = 1.0 + FRAYED * (tuft.height.min(TALLEST) - MEAN_HEIGHT);
        let squared = across * across + up * up;
        let covered = ((reach - squared.sqrt()) * wide.min(tall) * per_metre + 0.5).clamp(0.0, 1.0);
        if covered <= 0.0 {
            return;
        }
        let own = self.texel(column, row);
        let dome = (1.0 - squared / (reach * reach)).max(0.0).sqrt();
        let depth = depth + wide * dome + 0.8 * (tuft.height - 0.5);
        if own.leaves > CLOSED && own.depth >= depth {
            return;
        }
        let normal = |k: usize, place: f32| lobe.normal[k] + 0.50 * place + 0.85 * tuft.slope[k];
        own.add(&Texel {
            depth,
            normal: [normal(0, across), normal(1, up)],
            kind: lobe.kind,
            // Under a lobe and between tufts one looks into the shade.
            light: lobe.light * (0.40 + 0.85 * tuft.height).min(1.1),
            leaves: covered,
            wood: 0.0,
        });
    }

    /// Draws a piece of wood by the share of a texel that it covers: steps along its longer way, and across that as far as it is
    /// wide there. The area is kept.
    fn stroke(&mut self, stroke: &Stroke, is_trunk: bool) {
        let Stroke { from, to, widths, depth, .. } = *stroke;
        let way = [to[0] - from[0], to[1] - from[1]];
        let wide = widths[0].max(widths[1]);
        if self.rows(from[1].min(to[1]) - wide, from[1].max(to[1]) + wide).is_empty() {
            return;
        }
        let is_steep = way[1].abs() > way[0].abs();
        let (main, other) = if is_steep { (1, 0) } else { (0, 1) };
        let along = way[main].abs().max(1e-4);
        let slant = (way[0] * way[0] + way[1] * way[1]).sqrt() / along;
        let [low, high] = [from[main].min(to[main]), from[main].max(to[main])];
        let steps = if is_steep { self.rows(low, high) } else { self.place(low)..self.place(high) + 1 };
        let (texel, per_metre) = (self.grid.texel, self.per_metre);
        for step in steps {
            let [start, end] = [(step as f32 * texel).max(low), ((step + 1) as f32 * texel).min(high)];
            let part = (0.5 * (start + end) - from[main]).abs() / along;
            let middle = from[other] + way[other] * part;
            let half = 0.5 * mix(widths[0], widths[1], part) * slant;
            let share = (end - start).max(0.0) * per_metre * per_metre;
            let [left, right] = [middle - half, middle + half];
            let across = if is_steep { self.place(left)..self.place(right) + 1 } else { self.rows(left, right) };
            for aside in across {
                let met = ((aside + 1) as f32 * texel).min(right) - (aside as f32 * texel).max(left);
                let place = if is_steep { [aside, step] } else { [step, aside] };
                self.wood(depth, place, (met * share).clamp(0.0, 1.0), is_trunk);
            }
        }
    }

    #[inline]
    fn wood(&mut self, depth: f32, [column, row]: [i32; 2], share: f32, is_trunk: bool) {
        let own = self.texel(column, row);
        own.wood += share * (1.0 - own.wood);
        if is_trunk && own.depth < depth {
            own.leaves *= 1.0 - share;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: Grid = Grid { width: 512, height: 64, texel: 0.106 };

    fn area(canvas: &Canvas, of: impl Fn(&Texel) -> f32) -> f32 {
        canvas.texels.iter().map(of).sum::<f32>() * canvas.grid.texel * canvas.grid.texel
    }

    fn painted(grid: Grid, mark: Mark) -> Canvas {
        let relief = Relief::new(1, 128, 0.106, (512 / grid.width).ilog2());
        let mut canvas = Canvas::new(grid);
        canvas.paint(&[mark], &relief);
        canvas
    }

    #[test]
    fn what_reaches_over_the_rim_comes_in_on_the_other_side() {
        let length = GRID.width as f32 * GRID.texel;
        for x in [0.5 * length, 0.0, length] {
            let lobe = Lobe { middle: [x, 3.4, 0.0], radii: [1.2, 0.9], normal: [0.0; 2], kind: 0.5, light: 1.0 };
            let expected = std::f32::consts::PI * 1.2 * 0.9;
            let leaves = area(&painted(GRID, Mark::Leaves(lobe)), |texel| texel.leaves);
            assert!((leaves / expected - 1.0).abs() < 0.25, "{x}: {leaves} {expected}");
            // A bar thinner than a texel covers its own area.
            let (from, to) = ([x - 2.0, 3.0], [x + 2.0, 4.5]);
            let bar = Stroke { from, to, widths: [0.04; 2], depth: 0.0 };
            let wood = area(&painted(GRID, Mark::Twig(bar)), |texel| texel.wood);
            let expected = 0.04 * libm::hypotf(4.0, 1.5);
            assert!((wood / expected - 1.0).abs() < 0.02, "{x}: {wood} {expected}");
        }
    }

    #[test]
    fn the_area_of_a_lobe_does_not_depend_on_the_texels() {
        let lobe = Lobe { middle: [20.0, 3.4, 0.0], radii: [1.6, 1.2], normal: [0.0; 2], kind: 0.5, light: 1.0 };
        let areas = [1, 2, 4].map(|times| {
            let grid = Grid { width: 512 / times, height: 64 / times, texel: 0.106 * times as f32 };
            area(&painted(grid, Mark::Leaves(lobe)), |texel| texel.leaves)
        });
        assert!(areas.iter().all(|area| (area / areas[0] - 1.0).abs() < 0.15), "{areas:?}");
    }

    #[test]
    fn a_trunk_hides_the_leaves_behind_it_only() {
        let lobe = Lobe { middle: [10.0, 3.0, 0.0], radii: [1.5, 1.5], normal: [0.0; 2], kind: 0.5, light: 1.0 };
        let trunk = |depth: f32| Stroke { from: [10.0, 0.0], to: [10.0, 5.0], widths: [0.5; 2], depth };
        let relief = Relief::new(1, 128, GRID.texel, 0);
        let leaves = |depth: f32| {
            let mut canvas = Canvas::new(GRID);
            canvas.paint(&[Mark::Leaves(lobe), Mark::Trunk(trunk(depth))], &relief);
            area(&canvas, |texel| texel.leaves)
        };
        assert!(leaves(5.0) < leaves(-5.0) - 1.0);
    }
}
