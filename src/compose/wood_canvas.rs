//! The unrolled edge of a wood while it is drawn: lobes of leaves where nothing stands before them, wood by the share of a
//! texel that it covers.

use super::distant_tree::{Lobe, Stroke};
use super::foliage_relief::{Relief, Tuft};
use crate::base::maths::mix;
use crate::base::random::hash;
use rayon::prelude::*;
use std::ops::Range;

/// Rows that are drawn at once.
const BAND: usize = 16;
/// How far tufts carry the rim of a lobe out and in, shares of its radius for a height of 1.
const FRAYED: f32 = 0.90;
/// Mean height of the relief: a lobe of its mean reaches as far as its radius.
const MEAN_HEIGHT: f32 = 0.52;
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
    rows: Range<i64>,
    relief: &'a Relief,
}

impl Canvas {
    pub(super) fn new(grid: Grid) -> Self {
        Self { grid, texels: vec![EMPTY; grid.width * grid.height] }
    }

    /// Changes each texel by its place, metres along and up.
    pub(super) fn fill(&mut self, change: impl Fn([f32; 2], &mut Texel) + Sync) {
        let Grid { width, height, texel } = self.grid;
        self.texels.par_iter_mut().enumerate().for_each(|(place, own)| {
            let (x, y) = (place % width, height - 1 - place / width);
            change([(x as f32 + 0.5) * texel, (y as f32 + 0.5) * texel], own);
        });
    }

    /// Draws marks, the nearest first, in bands of rows at once: a texel depends on no other.
    pub(super) fn paint(&mut self, marks: &[Mark], relief: &Relief) {
        let grid = self.grid;
        self.texels.par_chunks_mut(grid.width * BAND).enumerate().for_each(|(number, texels)| {
            let above = grid.height as i64 - (number * BAND) as i64;
            let low = above - (texels.len() / grid.width) as i64;
            let mut band = Band { grid, texels, rows: low..above, relief };
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
    fn columns(&self, left: f32, right: f32) -> Range<i64> {
        (left / self.grid.texel).floor() as i64..(right / self.grid.texel).floor() as i64 + 1
    }

    fn rows(&self, low: f32, high: f32) -> Range<i64> {
        let row = |y: f32| (y / self.grid.texel).floor() as i64;
        row(low).max(self.rows.start)..(row(high) + 1).min(self.rows.end)
    }

    fn texel(&mut self, column: i64, row: i64) -> &mut Texel {
        let width = self.grid.width;
        let column = column.rem_euclid(width as i64) as usize;
        &mut self.texels[(self.rows.end - 1 - row) as usize * width + column]
    }

    /// Draws a lobe where nothing stands before it; tufts of leaves fray its rim.
    fn lobe(&mut self, lobe: &Lobe) {
        let ([x, y, _], [wide, tall]) = (lobe.middle, lobe.radii);
        let reach = 1.0 + FRAYED * (1.0 - MEAN_HEIGHT);
        let rows = self.rows(y - reach * tall, y + reach * tall);
        if rows.is_empty() {
            return;
        }
        // Each lobe has the relief from a place of its own, or they would all fray alike.
        let bits = hash(x.to_bits().into(), y.to_bits().into()) as usize;
        let texel = self.grid.texel;
        for row in rows {
            let up = ((row as f32 + 0.5) * texel - y) / tall;
            let half = wide * (reach * reach - up * up).max(0.0).sqrt();
            for column in self.columns(x - half, x + half) {
                let across = ((column as f32 + 0.5) * texel - x) / wide;
                let tuft =
                    self.relief.at((column as usize).wrapping_add(bits), (row as usize).wrapping_add(bits >> 16));
                self.leaves(lobe, [column, row], [across, up], tuft);
            }
        }
    }

    #[inline]
    fn leaves(&mut self, lobe: &Lobe, [column, row]: [i64; 2], [across, up]: [f32; 2], tuft: Tuft) {
        let (texel, [wide, tall], depth) = (self.grid.texel, lobe.radii, lobe.middle[2]);
        let own = self.texel(column, row);
        if own.leaves > CLOSED && own.depth >= depth + wide + 0.15 {
            return;
        }
        let reach = 1.0 + FRAYED * (tuft.height - MEAN_HEIGHT);
        let off = (across * across + up * up).sqrt();
        let covered = ((reach - off) * wide.min(tall) / texel + 0.5).clamp(0.0, 1.0);
        if covered <= 0.0 {
            return;
        }
        let dome = (1.0 - off * off / (reach * reach)).max(0.0).sqrt();
        let depth = depth + wide * dome + 0.3 * (tuft.height - 0.5);
        if own.leaves > CLOSED && own.depth >= depth {
            return;
        }
        let normal = |k: usize, place: f32| lobe.normal[k] + 0.50 * place + 0.55 * tuft.slope[k];
        own.add(&Texel {
            depth,
            normal: [normal(0, across), normal(1, up)],
            kind: lobe.kind,
            // Under a lobe and between tufts one looks into the shade.
            light: lobe.light * (0.80 + 0.20 * up.clamp(-1.0, 1.0)) * (0.40 + 0.85 * tuft.height).min(1.1),
            leaves: covered,
            wood: 0.0,
        });
    }

    /// Draws a piece of wood by the share of a texel that it covers.
    fn stroke(&mut self, stroke: &Stroke, is_trunk: bool) {
        let texel = self.grid.texel;
        let [from, to] = [stroke.from, stroke.to].map(|end| end.map(|side| side as f32));
        let widths = stroke.widths.map(|width| width as f32);
        let way = [to[0] - from[0], to[1] - from[1]];
        let squared = (way[0] * way[0] + way[1] * way[1]).max(1e-6);
        let reach = 0.5 * (widths[0].max(widths[1]) + texel);
        if self.rows(from[1].min(to[1]) - reach, from[1].max(to[1]) + reach).is_empty() {
            return;
        }
        let is_steep = way[1].abs() > way[0].abs();
        // Steps along the longer way, and across it only as far as the stroke is wide.
        let (main, other) = if is_steep { (1, 0) } else { (0, 1) };
        let [low, high] = [from[main].min(to[main]) - reach, from[main].max(to[main]) + reach];
        let slope = way[other] / if way[main].abs() < 1e-6 { 1e-6 } else { way[main] };
        for step in if is_steep { self.rows(low, high) } else { self.columns(low, high) } {
            let at = ((step as f32 + 0.5) * texel - from[main]).clamp(way[main].min(0.0), way[main].max(0.0));
            let middle = from[other] + slope * at;
            let (low, high) = (middle - 1.42 * reach, middle + 1.42 * reach);
            for aside in if is_steep { self.columns(low, high) } else { self.rows(low, high) } {
                let [column, row] = if is_steep { [aside, step] } else { [step, aside] };
                let place = [(column as f32 + 0.5) * texel - from[0], (row as f32 + 0.5) * texel - from[1]];
                let along = ((place[0] * way[0] + place[1] * way[1]) / squared).clamp(0.0, 1.0);
                let off = [place[0] - along * way[0], place[1] - along * way[1]];
                let off = (off[0] * off[0] + off[1] * off[1]).sqrt();
                let width = mix(widths[0], widths[1], along);
                // A box of a texel's width over a bar.
                let share = ((0.5 * (width + texel) - off) / texel).clamp(0.0, 1.0).min(width / texel);
                if share > 0.0 {
                    self.wood(stroke.depth as f32, [column, row], share, is_trunk);
                }
            }
        }
    }

    fn wood(&mut self, depth: f32, [column, row]: [i64; 2], share: f32, is_trunk: bool) {
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
        let relief = Relief::new(1, grid.width.min(128), grid.texel);
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
            let (from, to) = ([f64::from(x) - 2.0, 3.0], [f64::from(x) + 2.0, 4.5]);
            let bar = Stroke { from, to, widths: [0.04; 2], depth: 0.0, kind: 0.5 };
            let wood = area(&painted(GRID, Mark::Twig(bar)), |texel| texel.wood);
            let expected = 0.04 * libm::hypotf(4.0, 1.5);
            assert!((wood / expected - 1.0).abs() < 0.4, "{x}: {wood} {expected}");
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
        let trunk = |depth: f64| Stroke { from: [10.0, 0.0], to: [10.0, 5.0], widths: [0.5; 2], depth, kind: 0.5 };
        let relief = Relief::new(1, 128, GRID.texel);
        let leaves = |depth: f64| {
            let mut canvas = Canvas::new(GRID);
            canvas.paint(&[Mark::Leaves(lobe), Mark::Trunk(trunk(depth))], &relief);
            area(&canvas, |texel| texel.leaves)
        };
        assert!(leaves(5.0) < leaves(-5.0) - 1.0);
    }
}
