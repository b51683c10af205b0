//! Leaves that lie on one another.
//!
//! They are laid in the order in which they landed, ties by id, each on the ground and on what lies there: a field of heights
//! holds the top of all that has been laid. A leaf leans as the plane that fits what is beneath it best, then comes down until
//! the first of its lowest points touches. The order is part of the list and not of the calls, and a leaf rests on nothing that
//! landed after it, so the litter of any day can be made by itself.

use super::columns::{CELL, Columns, Patch};
use super::descent::slope;
use super::shape::{Rest, Sample, Shape, Side};
use super::{Fallen, Ground};
use crate::base::random::{Purpose, Stream};
use crate::base::vector::{DMat3, DVec2, DVec3};
use nalgebra::UnitQuaternion;
use std::f64::consts::TAU;

/// Room that a leaf takes beside its shape, metres: its thickness and veins.
const THICKNESS: f32 = 5e-4;
/// How much higher than a leaf others lie that hide it, metres.
const COVER: f32 = 2e-3;
/// The plane beneath a leaf is fitted to every so many-th sample.
pub(super) const FITTED: usize = 3;
/// How far a leaf follows the plane beneath it.
const LEANING: f64 = 0.85;
/// Steepest that a leaf leans, degrees.
const STEEPEST: f64 = 24.0;
/// A cell holds the highest point of all within it, so the first contacts are met a little early, and blades give way: a leaf
/// comes to rest on the last of so many contacts, but no more than so many metres below the first.
const NEAR: usize = 4;
const SINK: f32 = 4e-3;
/// Metres about a leaf's middle that its blade may reach.
const MARGIN: f64 = 0.5;

/// A leaf that has come down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landed {
    /// Its id.
    pub leaf: u64,
    /// When it landed, days.
    pub day: f64,
    /// Where its middle lies, along x and z, metres.
    pub place: DVec2,
    /// Number of its shape.
    pub shape: u32,
    /// Its size over that of the shape.
    pub scale: f64,
    /// The side that faces the sky.
    pub side: Side,
    /// Its turn, radians.
    pub yaw: f64,
}

/// How a leaf lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Laid {
    /// Its middle, metres.
    pub middle: DVec3,
    /// Its attitude.
    pub attitude: UnitQuaternion<f64>,
    /// Whether other leaves lie over all of it.
    pub is_buried: bool,
}

/// The side and the turn in which a leaf will lie: either side by chance.
#[must_use]
pub fn lot(seed: u64, leaf: &Fallen) -> (Side, f64) {
    let mut stream = Stream::new(seed, Purpose::Litter, leaf.leaf, leaf.year ^ 1 << 63);
    let side = if stream.uniform() < 0.5 { Side::Upper } else { Side::Lower };
    (side, stream.range(0.0, TAU))
}

/// Lays leaves; the answers are in the order in which the leaves are given.
#[must_use]
pub fn settle(ground: &Ground, shapes: &[Shape], landed: &[Landed]) -> Vec<Laid> {
    let mut order: Vec<usize> = (0..landed.len()).collect();
    order.sort_unstable_by(|&a, &b| {
        landed[a].day.total_cmp(&landed[b].day).then(landed[a].leaf.cmp(&landed[b].leaf)).then(a.cmp(&b))
    });
    let mut columns = Columns::new(ground, landed.iter().map(|leaf| leaf.place), MARGIN);
    let nowhere = Laid { middle: DVec3::zeros(), attitude: UnitQuaternion::identity(), is_buried: false };
    let mut laid = vec![nowhere; landed.len()];
    let mut patch = Patch::default();
    let mut lines = Vec::new();
    for &place in &order {
        let leaf = &landed[place];
        if let Some(shape) = shapes.get(leaf.shape as usize) {
            laid[place] = lay(&mut columns, &mut patch, shape, leaf, &mut lines);
        }
    }
    for (leaf, laid) in landed.iter().zip(&mut laid) {
        if let Some(shape) = shapes.get(leaf.shape as usize) {
            laid.is_buried = is_buried(&mut columns, &mut patch, shape, leaf, laid);
        }
    }
    laid
}

/// A line through a leaf where it lies: its cell, and its highest point over the leaf's foot, metres.
type Line = (u16, f32);

fn lay(columns: &mut Columns<'_>, patch: &mut Patch, shape: &Shape, leaf: &Landed, lines: &mut Vec<Line>) -> Laid {
    let rest = shape.rest(leaf.side);
    columns.lift(leaf.place, rest.reach * leaf.scale, patch);
    let yaw = UnitQuaternion::from_axis_angle(&DVec3::y_axis(), leaf.yaw);
    let turn = leaning(patch, rest, leaf, &yaw) * yaw;
    let matrix = turn.to_rotation_matrix().into_inner() * leaf.scale;
    let axes = single(&matrix);
    lines.clear();
    let mut contacts = Contacts::default();
    for sample in &rest.samples {
        let [low, high] = axes.ends(sample);
        let cell = patch.cell(low[0], low[2]);
        let met = *patch.height(cell) - low[1];
        lines.push((cell, high[1]));
        contacts.add(met);
    }
    let height = contacts.height();
    for &(cell, high) in lines.iter() {
        let top = patch.height(cell);
        *top = top.max(height + high + THICKNESS);
    }
    columns.lower(patch);
    let middle = rest.level * shape.middle - rest.foot;
    let foot = DVec3::new(leaf.place.x, f64::from(height), leaf.place.y);
    Laid { middle: foot + matrix * middle, attitude: turn * rest.level, is_buried: false }
}

/// The highest places at which a leaf that comes down may touch.
struct Contacts([f32; NEAR]);

impl Default for Contacts {
    fn default() -> Self {
        Self([f32::NEG_INFINITY; NEAR])
    }
}

impl Contacts {
    #[inline]
    fn add(&mut self, met: f32) {
        if met <= self.0[NEAR - 1] {
            return;
        }
        let mut met = met;
        for known in &mut self.0 {
            if met > *known {
                std::mem::swap(known, &mut met);
            }
        }
    }

    /// Where the leaf comes to rest.
    fn height(&self) -> f32 {
        let last = self.0[NEAR - 1];
        if last.is_finite() { last.max(self.0[0] - SINK) } else { self.0[0].max(0.0) }
    }
}

/// The axes of a lying leaf: x and z in cells, y in metres.
struct Axes([[f32; 3]; 3]);

fn single(matrix: &DMat3) -> Axes {
    let unit = [1.0 / CELL, 1.0, 1.0 / CELL];
    Axes(std::array::from_fn(|axis| std::array::from_fn(|k| (matrix[(k, axis)] * unit[k]) as f32)))
}

impl Axes {
    /// The lowest and the highest point of a line.
    fn ends(&self, sample: &Sample) -> [[f32; 3]; 2] {
        let [a, b, c] = &self.0;
        let [x, z] = sample.place;
        let flat: [f32; 3] = std::array::from_fn(|k| a[k] * x + c[k] * z);
        [sample.low, sample.high].map(|height| std::array::from_fn(|k| flat[k] + b[k] * height))
    }
}

/// The turn by which a leaf follows what is beneath it: the plane of least squares through the heights below some samples.
fn leaning(patch: &mut Patch, rest: &Rest, leaf: &Landed, yaw: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
    let axes = single(&(yaw.to_rotation_matrix().into_inner() * leaf.scale));
    let mut sums = [0.0f32; 5];
    for sample in rest.samples.iter().step_by(FITTED) {
        let [x, z] = sample.place;
        let [at, _] = axes.ends(&Sample { low: 0.0, ..*sample });
        let cell = patch.cell(at[0], at[2]);
        let height = *patch.height(cell);
        for (sum, value) in sums.iter_mut().zip([height, x, z, x * height, z * height]) {
            *sum += value;
        }
    }
    // heights about their mean, since the samples' middle need not be the leaf's
    let [height, x, z, xh, zh] = sums.map(f64::from);
    let count = rest.samples.len().div_ceil(FITTED).max(1) as f64;
    let lever = DVec2::new(xh - x * height / count, zh - z * height / count);
    let [xx, xz, zz] = rest.moments;
    let fitted = DVec2::new(xx * lever.x + xz * lever.y, xz * lever.x + zz * lever.y) / leaf.scale.max(1e-6);
    let (size, most) = (fitted.norm() * LEANING, slope(STEEPEST));
    if size < 1e-6 {
        return UnitQuaternion::identity();
    }
    let fitted = fitted * (LEANING * (most / size).min(1.0));
    let normal = yaw * DVec3::new(-fitted.x, 1.0, -fitted.y);
    UnitQuaternion::rotation_between(&DVec3::y(), &normal).unwrap_or_else(UnitQuaternion::identity)
}

/// Whether others lie over every line of a leaf.
fn is_buried(columns: &mut Columns<'_>, patch: &mut Patch, shape: &Shape, leaf: &Landed, laid: &Laid) -> bool {
    let rest = shape.rest(leaf.side);
    let turn = laid.attitude * rest.level.inverse();
    let matrix = turn.to_rotation_matrix().into_inner() * leaf.scale;
    let foot = laid.middle - matrix * (rest.level * shape.middle - rest.foot);
    let (axes, height) = (single(&matrix), foot.y as f32);
    columns.lift(leaf.place, rest.reach * leaf.scale, patch);
    let is_below = |sample: &Sample| {
        let [_, high] = axes.ends(sample);
        let cell = patch.cell(high[0], high[2]);
        *patch.height(cell) > height + high[1] + THICKNESS + COVER
    };
    !rest.samples.is_empty() && rest.samples.iter().all(is_below)
}
