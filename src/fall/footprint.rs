//! The cells that lie below a leaf in an attitude, with its heights over them: eight points at once.

use super::columns::Patch;
use super::heights::Floor;
use super::shape::Points;
use crate::base::vector::{DMat3, DVec3};
use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f32x8, i32x8};
use nalgebra::UnitQuaternion;

/// What one unit of a cell's value is worth, metres. The lowest bit tells that the height is that of a rim.
pub(super) const UNIT: f32 = 5e-5;
pub(super) const OF_RIM: u16 = 1;
/// The highest that a cell's value tells, in twos of units.
const MOST_UNITS: f32 = (u16::MAX / 2) as f32;
/// Points that are looked at together.
pub(super) const LANES: usize = 8;

/// Cells below points of a leaf.
#[derive(Default)]
pub(super) struct Footprint {
    /// Their numbers.
    cells: Vec<[i32; LANES]>,
    /// The leaf's height over its foot at the middle of each, metres.
    over: Vec<[f32; LANES]>,
    /// The height of uneven ground at the middle of each, metres; empty on level ground.
    floor: Vec<[f32; LANES]>,
    /// There, the leaf's height over its foot at each point itself, metres.
    rise: Vec<[f32; LANES]>,
    /// The lowest of the points over the leaf's foot, metres.
    pub lowest: f32,
}

impl Footprint {
    /// Finds the cells below the points; `middle` is the leaf's place in cells from the patch's first. The slopes of points
    /// are taken to add to the lean. `floor` is the ground of the patch where it is uneven.
    pub(super) fn find(
        &mut self,
        points: &Points,
        axes: &Axes,
        rise: &Rise,
        (patch, floor): (&Patch<'_>, Option<&Floor>),
        middle: [f32; 2],
    ) {
        self.cells.clear();
        self.over.clear();
        self.floor.clear();
        self.rise.clear();
        let frame = ([patch.last[0], patch.last[1], patch.stride as f32], middle.map(|place| place - 0.5));
        dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || self.find_with(simd, points, axes, rise, (frame, floor))));
    }

    #[inline(always)]
    fn find_with<W: Simd>(
        &mut self,
        simd: W,
        points: &Points,
        Axes(axes): &Axes,
        rise: &Rise,
        (([last_x, last_z, stride], [from_x, from_z]), floor): (([f32; 3], [f32; 2]), Option<&Floor>),
    ) {
        let wide = |values: &[f32; LANES]| f32x8::simd_from(simd, *values);
        let zero = f32x8::splat(simd, 0.0);
        let ([cosine, sine], [lean_x, lean_z]) = (rise.turn, rise.lean);
        let mut lowest = f32x8::splat(simd, f32::INFINITY);
        for group in points.groups() {
            let [px, py, pz] = group.at.each_ref().map(wide);
            let [slope_x, slope_z] = group.slope.each_ref().map(wide);
            let [x, y, z]: [f32x8<W>; 3] = std::array::from_fn(|k| px * axes[0][k] + py * axes[1][k] + pz * axes[2][k]);
            let (x, z) = (x + from_x, z + from_z);
            let column = x.max(zero).min(f32x8::splat(simd, last_x)).round_ties_even();
            let row = z.max(zero).min(f32x8::splat(simd, last_z)).round_ties_even();
            let (rise_x, rise_z) =
                (slope_x * cosine + slope_z * sine + lean_x, slope_z * cosine - slope_x * sine + lean_z);
            self.cells.push((row * stride + column).to_int::<i32x8<W>>().into());
            self.over.push((y + rise_x * (column - x) + rise_z * (row - z)).into());
            if let Some(floor) = floor {
                let [columns, rows]: [[i32; LANES]; 2] = [column, row].map(|cells| cells.to_int::<i32x8<W>>().into());
                self.floor.push(std::array::from_fn(|lane| floor.at(columns[lane] as usize, rows[lane] as usize)));
                self.rise.push(y.into());
            }
            lowest = lowest.min(y);
        }
        self.lowest = <[f32; LANES]>::from(lowest).into_iter().fold(f32::INFINITY, f32::min);
    }

    /// The cell of each point, with the leaf's height over its foot there and that of the ground, metres.
    pub(super) fn iter(&self) -> impl Iterator<Item = (usize, f32, f32)> {
        let floor = (0..self.cells.len()).flat_map(|group| self.floor.get(group).copied().unwrap_or_default());
        let cells = self.cells.iter().flatten().map(|&cell| cell as usize);
        cells.zip(self.over.iter().flatten().copied()).zip(floor).map(|((cell, over), floor)| (cell, over, floor))
    }

    /// The points, by group and lane, that may touch uneven ground when the foot is higher than `height`: ground that is up to
    /// `more` higher than in the middle of their cells.
    pub(super) fn may_touch(&self, height: f32, more: f32) -> impl Iterator<Item = (usize, usize)> {
        let groups = self.floor.iter().zip(&self.rise).enumerate();
        groups.flat_map(move |(group, (floor, rise))| {
            let touches: [bool; LANES] = std::array::from_fn(|lane| floor[lane] - rise[lane] + more > height);
            let any = touches.into_iter().fold(false, |any, touches| any | touches);
            (0..if any { LANES } else { 0 }).filter(move |&lane| touches[lane]).map(move |lane| (group, lane))
        })
    }

    /// Whether nothing lies in any of the cells.
    pub(super) fn is_bare(&self, values: &[u16]) -> bool {
        let all = |any: u16, cell: &i32| any | values.get(*cell as usize).copied().unwrap_or(0);
        self.cells.iter().flatten().fold(0, all) == 0
    }

    /// The height of the foot at which one of the points meets the top of its cell, metres.
    #[inline]
    pub(super) fn highest(&self, values: &[u16], give: f32) -> f32 {
        dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || {
            let mut highest = f32x8::splat(simd, f32::NEG_INFINITY);
            for (group, (cells, over)) in self.cells.iter().zip(&self.over).enumerate() {
                let found = cells.map(|cell| values.get(cell as usize).map_or(0, |value| i32::from(*value)));
                let found = i32x8::simd_from(simd, found);
                let of_rim = (found & i32::from(OF_RIM)).to_float::<f32x8<_>>();
                let top = (found & i32::from(!OF_RIM)).to_float::<f32x8<_>>() * UNIT;
                let floor = f32x8::simd_from(simd, self.floor.get(group).copied().unwrap_or_default());
                highest = highest.max(top + floor - f32x8::simd_from(simd, *over) - of_rim * give);
            }
            <[f32; LANES]>::from(highest).into_iter().fold(f32::NEG_INFINITY, f32::max)
        }))
    }

    /// Raises cells to the leaf, whose foot and thickness are at `level`, metres.
    #[inline]
    pub(super) fn raise(&self, values: &mut [u16], level: f32, of_rim: u16) {
        dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || {
            for (group, (cells, over)) in self.cells.iter().zip(&self.over).enumerate() {
                let floor = f32x8::simd_from(simd, self.floor.get(group).copied().unwrap_or_default());
                let over = f32x8::simd_from(simd, *over) + level - floor;
                let units = (over * (0.5 / UNIT) + 0.5).max(f32x8::splat(simd, 0.0)).min(f32x8::splat(simd, MOST_UNITS));
                let tops: [i32; LANES] = units.to_int::<i32x8<_>>().into();
                for (cell, top) in cells.iter().zip(tops) {
                    if let Some(value) = values.get_mut(*cell as usize) {
                        *value = ((2 * top as u16) | of_rim).max(*value);
                    }
                }
            }
        }));
    }
}

/// How a leaf's points rise within their cells.
#[derive(Default)]
pub(super) struct Rise {
    /// Cosine and sine of its turn, in metres a cell.
    turn: [f32; 2],
    /// The slopes along x and z by which it leans, in metres a cell.
    lean: [f32; 2],
}

impl Rise {
    pub(super) fn new(turn: &UnitQuaternion<f64>, yaw: f64, side: f64) -> Self {
        let (sine, cosine) = crate::base::maths::sincos(yaw);
        let up = turn * DVec3::y();
        let lean = [-up.x / up.y, -up.z / up.y].map(|slope| (slope * side) as f32);
        Self { turn: [(cosine * side) as f32, (sine * side) as f32], lean }
    }
}

/// The axes of a lying leaf: x and z in cells, y in metres.
pub(super) struct Axes([[f32; 3]; 3]);

impl Axes {
    pub(super) fn new(matrix: &DMat3, side: f64) -> Self {
        let unit = [1.0 / side, 1.0, 1.0 / side];
        Self(std::array::from_fn(|axis| std::array::from_fn(|k| (matrix[(k, axis)] * unit[k]) as f32)))
    }

    #[inline]
    pub(super) fn turned(&self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        let [a, b, c] = &self.0;
        std::array::from_fn(|k| a[k] * x + b[k] * y + c[k] * z)
    }
}
