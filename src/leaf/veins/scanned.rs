//! Veins seen in a scan: ridges of its tone, joined to a tree that starts at the petiole's joint.

use super::branching::{Branch, branches};
use super::line::length;
use super::petiole;
use super::ridge::{self, Polarity};
use super::sheet::Sheet;
use super::tree::{self, Tree};
use super::width::widths;
use crate::base::blade::Vein;
use crate::base::picture::Picture;
use crate::base::vector::DVec2;
use crate::leaf::grid::Grid;
use crate::leaf::raster::{cell_of, middle_of};
use crate::leaf::trace::Trace;

/// Share of the blade that major veins cover: in hand traces of grape leaves 7.1 to 9.6 %.
const SHARE: f64 = 0.08;
/// Radius of the joint, share of the size.
const JOINT: f64 = 0.02;
/// Below this gain of the whole tree, in sizes of the blade, what was found may as well be blotches: there are no veins to
/// see. Leaves with plain veins reach 3 to 8, blotched ones with a midrib 1.2 to 2, blotched ones without one 0.5.
const LEAST_EVIDENCE: f64 = 0.75;
/// A blade of which a larger share is of exactly even colour is drawn or a silhouette: scans have 0.02 to 0.11, drawn
/// leaves 0.6 to 1.
const MOST_EVEN: f64 = 0.45;
/// Steps of tone below this are even, Lab units.
const EVEN: f32 = 0.05;
/// A vein that begins this near to the joint (share of the size) and is this long (share of the longest) is a main vein.
const MAIN: (f64, f64) = (0.10, 0.45);
/// Shorter veins are of the third order whatever they hang on, share of the size.
const SHORT: f64 = 0.10;
/// Veins that end nearer to the margin than this go on to it, share of the size.
const NEAR_MARGIN: f64 = 0.07;
/// Distance between the points of a vein, and half the stretch over which cells are averaged to a line, shares of the size.
const SPACING: f64 = 0.01;
/// Narrowest and broadest widths of each order, shares of the size.
const BOUNDS: [(f64, f64); 3] = [(0.004, 0.022), (0.003, 0.014), (0.002, 0.008)];
/// Width of the thin end against the thick one where the scan does not tell.
const TAPER: f64 = 0.4;

/// What a scan tells about veins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evidence {
    /// Gain of the tree of veins, in sizes of the blade (size: square root of the area). Veins are believed from 1 on.
    pub gain: f64,
    /// Share of the blade that is of exactly even colour. Up to 0.45 the picture counts as a scan.
    pub even: f64,
}

impl Evidence {
    /// Whether the scan shows veins.
    #[must_use]
    pub fn suffices(&self) -> bool {
        self.gain >= LEAST_EVIDENCE && self.even <= MOST_EVEN
    }
}

/// The veins that a scan shows, main ones first, in the blade's plane, and what speaks for them. There are none when the
/// evidence does not suffice.
#[must_use]
pub fn scanned(picture: &Picture, trace: &Trace) -> (Vec<Vein>, Evidence) {
    let nothing = (Vec::new(), Evidence { gain: 0.0, even: 1.0 });
    let Some(sheet) = Sheet::new(picture, trace) else { return nothing };
    let even = evenness(&sheet);
    let joint = sheet.place(trace.pose.joint);
    let Some((polarity, tree)) = best_tree(&sheet, joint) else { return nothing };
    let evidence = Evidence { gain: tree.gain / sheet.size, even };
    if !evidence.suffices() {
        return (Vec::new(), evidence);
    }
    let branches = branches(&tree, sheet.inside.width, sheet.size);
    let drawing = Drawing { sheet: &sheet, trace, joint, polarity };
    (drawing.veins(&branches), evidence)
}

/// Share of the sure cells whose tone is that of their left neighbour.
fn evenness(sheet: &Sheet) -> f64 {
    let tones = &sheet.tone.cells;
    let even = |i: &usize| sheet.sure.cells[*i] && (tones[*i] - tones[*i - 1]).abs() < EVEN;
    (1..tones.len()).filter(even).count() as f64 / sheet.sure.area().max(1) as f64
}

/// The tree of bright or that of dark veins, whichever gains more.
fn best_tree(sheet: &Sheet, joint: DVec2) -> Option<(Polarity, Tree)> {
    let level = ridge::flattened(sheet);
    let strip = petiole::folded(sheet, &level, joint);
    let roots = roots(sheet, joint);
    let grow = |(strength, polarity): (Grid<f32>, Polarity)| {
        let threshold = ridge::exceeded_by(&strength, sheet, SHARE).max(1e-6);
        let mut shares = strength.map(|s| s / threshold);
        // What lies under the petiole is not known: there a way neither gains nor loses.
        shares.cells.iter_mut().zip(&strip.cells).filter(|(_, hidden)| **hidden).for_each(|(share, _)| *share = 1.0);
        (polarity, tree::grown(&shares, &sheet.inside, &sheet.inner, &roots, joint, sheet.size))
    };
    let [bright, dark] = ridge::ridges(sheet, &level);
    let [bright, dark] = [(bright, Polarity::Bright), (dark, Polarity::Dark)].map(grow);
    let best = if bright.1.gain >= dark.1.gain { bright } else { dark };
    (!roots.is_empty()).then_some(best)
}

/// The cells of the joint: those near its place, or the nearest of the blade.
fn roots(sheet: &Sheet, joint: DVec2) -> Vec<u32> {
    let width = sheet.inside.width;
    let distance = |&i: &u32| (middle_of(width, i as usize) - joint).norm();
    let inside: Vec<u32> = (0..sheet.inside.cells.len() as u32).filter(|&i| sheet.inside.cells[i as usize]).collect();
    let near: Vec<u32> = inside.iter().copied().filter(|i| distance(i) <= JOINT * sheet.size).collect();
    let nearest = inside.iter().copied().min_by(|a, b| distance(a).total_cmp(&distance(b)));
    if near.is_empty() { nearest.into_iter().collect() } else { near }
}

/// Turns cells into veins.
struct Drawing<'a> {
    sheet: &'a Sheet,
    trace: &'a Trace,
    joint: DVec2,
    polarity: Polarity,
}

impl Drawing<'_> {
    fn veins(&self, branches: &[Branch]) -> Vec<Vein> {
        let lines: Vec<Vec<DVec2>> = branches.iter().map(|b| self.line(b)).collect();
        let lengths: Vec<f64> = lines.iter().map(|line| length(line)).collect();
        let orders = self.orders(branches, &lengths);
        let mut numbers: Vec<usize> = (0..branches.len()).collect();
        numbers.sort_by(|&a, &b| orders[a].cmp(&orders[b]).then(lengths[b].total_cmp(&lengths[a])).then(a.cmp(&b)));
        numbers.into_iter().map(|i| self.vein(&lines[i], orders[i])).collect()
    }

    fn orders(&self, branches: &[Branch], lengths: &[f64]) -> Vec<u8> {
        let size = self.sheet.size;
        let longest = lengths.iter().copied().fold(0.0, f64::max);
        let mut orders: Vec<u8> = Vec::with_capacity(branches.len());
        for (branch, &length) in branches.iter().zip(lengths) {
            let from = middle_of(self.sheet.inside.width, branch.cells[0] as usize);
            let at_joint = (from - self.joint).norm() < MAIN.0 * size && length > MAIN.1 * longest;
            let below = branch.parent.map_or(2, |parent| (orders[parent] + 1).min(3));
            let order = if at_joint { 1 } else { below };
            orders.push(if length < SHORT * size { 3 } else { order });
        }
        orders
    }

    /// A smooth line along the cells, in cells, from the joint or the parent to the margin where it is near.
    fn line(&self, branch: &Branch) -> Vec<DVec2> {
        let spacing = ((SPACING * self.sheet.size).round() as usize).max(1);
        let cells: Vec<DVec2> = branch.cells.iter().map(|&c| middle_of(self.sheet.inside.width, c as usize)).collect();
        let last = cells.len() - 1;
        let mean = |i: usize| {
            let reach = spacing.min(i).min(last - i);
            cells[i - reach..=i + reach].iter().sum::<DVec2>() / (2 * reach + 1) as f64
        };
        let mut line: Vec<DVec2> = (0..last).step_by(spacing).chain([last]).map(mean).collect();
        if branch.parent.is_none() && (line[0] - self.joint).norm() > 0.5 {
            line.insert(0, self.joint);
        }
        self.extend(&mut line);
        line
    }

    /// Leads a line straight on to the margin when it ends near it.
    fn extend(&self, line: &mut Vec<DVec2>) {
        let end = line[line.len() - 1];
        let heading = (end - line[line.len().saturating_sub(5)]).try_normalize(0.0).unwrap_or_default();
        let inside = |p: DVec2| {
            let grid = &self.sheet.inside;
            cell_of(grid.width, grid.height, p).is_some_and(|cell| grid.cells[cell])
        };
        let most = (NEAR_MARGIN * self.sheet.size) as usize;
        let Some(way) = (1..=most).find(|&steps| !inside(end + heading * steps as f64)) else { return };
        if way > 1 && heading != DVec2::zeros() {
            line.push(end + heading * (way - 1) as f64);
        }
    }

    fn vein(&self, line: &[DVec2], order: u8) -> Vein {
        let size = self.sheet.size;
        let (least, most) = BOUNDS[usize::from(order) - 1];
        let bounded = |width: f64| width.clamp(least * size, most * size);
        let [thick, thin] = widths(&self.sheet.tone, line, self.polarity, size);
        let width = bounded(thick.unwrap_or(0.5 * (least + most) * size));
        let end_width = thin.unwrap_or(TAPER * width).clamp(0.5 * least * size, 0.8 * width);
        let metres = self.sheet.step * self.trace.pose.scale;
        let points = line.iter().map(|&p| self.trace.pose.plane(self.sheet.pixel(p))).collect();
        Vein { points, width: width * metres, end_width: end_width * metres, order }
    }
}
