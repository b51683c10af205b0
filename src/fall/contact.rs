//! A leaf that comes down on the ground and on what lies there, to its first contact.
//!
//! All leaves are compared on one lattice, whose cells hold the height of the topmost blade at their middles, or that of a
//! point of a rim within them that is higher. A leaf comes down until one of its blade's points, taken along its slope to the
//! middle of its cell, or a point of its rim is met. What it touches is thus within half a cell's diagonal and a thickness;
//! only rims pass one another, by little.

use super::columns::{Extent, Patch, Region, in_cells, middle};
use super::descent::slope;
use super::footprint::{Axes, Footprint, OF_RIM, Rise, UNIT};
use super::heights::Floor;
use super::litter::{Laid, Landed};
use super::shape::{Rest, Shape};
use super::support::{Cloud, support};
use super::{Ground, shape::Sample};
use crate::base::vector::{DVec2, DVec3};
use nalgebra::UnitQuaternion;

/// Sides of a cell, metres, for each fineness: half the diagonal is below 2 mm. The first keeps contacts of leaves in piles
/// within 2 mm; of more than `FEW` leaves none is seen from near, and the second takes two thirds of the time.
const CELLS: [f64; 2] = [1.8e-3, 2.5e-3];
const FEW: usize = 16_000;
/// Coarsest cells, of a large stand.
const COARSEST: f64 = 8e-3;
/// How far rims pass one another, metres: they need not lie one above the other where their vertices lie in one cell.
const GIVE: f32 = 1e-3;
/// More than heights of the ground are rounded by, metres.
const ROUNDING: f32 = 1e-4;
/// Room that a blade takes over its lower side, metres: paper and veins.
const THICKNESS: f32 = 3e-4;
/// Steepest that a leaf leans, degrees.
const STEEPEST: f64 = 24.0;
/// How exactly the plane on which a leaf leans is found, metres.
const ACCURACY: f64 = 2e-4;
/// Mean thickness of a leaf among buried ones, metres. Litter of hardwoods lies 6 to 11 mm thick a layer when nothing has
/// pressed it (beds 6 cm deep of 0.34 to 0.72 kg/m2, Anderson 1982, models 8 and 9, at 60 g/m2 a leaf); under other leaves and
/// rain it packs closer.
const BURIED: f32 = 4e-3;
/// Cells along a block's side, as powers of two: a block holds the widest leaf, up to the second. Of a larger leaf the rim is
/// looked up in the outermost cells.
const LEAST_BITS: u32 = 9;
const MOST_BITS: u32 = 10;

/// What leaves come down on.
pub(super) struct Bed<'a> {
    ground: &'a Ground,
    /// Which of the points of shapes are looked at.
    fineness: usize,
    /// Side of a cell, metres.
    pub side: f64,
    /// Cells along a block's side, as a power of two.
    pub bits: u32,
}

/// How a leaf lies: its turn and the height of its foot, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stance {
    turn: UnitQuaternion<f64>,
    height: f32,
}

/// What is needed on the way down, kept from leaf to leaf.
#[derive(Default)]
pub(super) struct Tools {
    copy: Vec<u16>,
    points: Cloud,
    lows: Footprint,
    blade: Footprint,
    rim: Footprint,
    floor: Floor,
}

impl Tools {
    /// Works on the cells of an extent.
    pub(super) fn with<R>(
        &mut self,
        region: &mut Region,
        extent: Extent,
        work: impl FnOnce(&mut Self, Patch<'_>) -> R,
    ) -> R {
        let mut copy = std::mem::take(&mut self.copy);
        let answer = region.open(extent, &mut copy, |patch| work(self, patch));
        self.copy = copy;
        answer
    }
}

impl<'a> Bed<'a> {
    /// The ground. The cells of large stands are coarser, for the memory's sake.
    pub(super) fn new(ground: &'a Ground, shapes: &[&Shape], landed: &[Landed]) -> Self {
        let pairs = ground.trunks.len() as f64 / 2.0;
        let fineness = usize::from(landed.len() > FEW);
        let side = (CELLS[fineness] * pairs.max(1.0).sqrt()).min(COARSEST);
        let widest = landed.iter().map(|leaf| 2.0 * reach(shapes, leaf) / side).fold(0.0, f64::max);
        let bits = (LEAST_BITS..MOST_BITS).find(|&bits| widest + 2.0 <= f64::from(1u32 << bits)).unwrap_or(MOST_BITS);
        Self { ground, fineness, side, bits }
    }

    /// The cells that a leaf may reach.
    pub(super) fn extent(&self, shapes: &[&Shape], leaf: &Landed) -> Extent {
        Extent::new(leaf.place, reach(shapes, leaf), self.side).within(self.bits)
    }

    /// How a leaf comes to rest on what is there.
    pub(super) fn rest(&self, tools: &mut Tools, patch: &Patch<'_>, shape: &Shape, leaf: &Landed) -> Stance {
        let rest = shape.rest(leaf.side);
        let yaw = UnitQuaternion::from_axis_angle(&DVec3::y_axis(), leaf.yaw);
        self.lay_floor(tools, patch);
        let turn = self.leaning(tools, patch, rest, leaf, &yaw) * yaw;
        let axes = self.axes(&turn, leaf);
        self.find(tools, patch, rest, leaf, &turn);
        Stance { turn, height: self.height(tools, patch, rest, &axes, leaf) }
    }

    /// Adds a leaf that lies so. `is_found`: that it has just come to rest with these tools.
    pub(super) fn add(
        &self,
        (tools, is_found): (&mut Tools, bool),
        patch: &mut Patch<'_>,
        shape: &Shape,
        leaf: &Landed,
        Stance { turn, height }: &Stance,
    ) {
        if !is_found {
            self.lay_floor(tools, patch);
            self.find(tools, patch, shape.rest(leaf.side), leaf, turn);
        }
        let level = height + THICKNESS;
        for (found, of_rim) in [(&tools.blade, 0), (&tools.rim, OF_RIM)] {
            found.raise(patch.values, level, of_rim);
        }
    }

    /// The middle and the attitude of a leaf that lies so.
    pub(super) fn laid(&self, shape: &Shape, leaf: &Landed, Stance { turn, height }: &Stance) -> Laid {
        let rest = shape.rest(leaf.side);
        let matrix = turn.to_rotation_matrix().into_inner() * leaf.scale;
        let middle = rest.level * shape.middle - rest.foot;
        let foot = DVec3::new(leaf.place.x, f64::from(*height), leaf.place.y);
        Laid { middle: foot + matrix * middle, attitude: turn * rest.level, is_pressed: false, is_buried: false }
    }

    fn axes(&self, turn: &UnitQuaternion<f64>, leaf: &Landed) -> Axes {
        Axes::new(&(turn.to_rotation_matrix().into_inner() * leaf.scale), self.side)
    }

    /// The ground below a patch, where it is uneven.
    fn lay_floor(&self, tools: &mut Tools, patch: &Patch<'_>) {
        if let Some(map) = &self.ground.heights {
            let middles = |axis: usize| {
                (0..=patch.last[axis] as usize).map(move |cell| middle(patch.first[axis], cell, self.side))
            };
            tools.floor.lay(map, middles(0), middles(1));
        }
    }

    /// The cells below a leaf of this turn.
    fn find(&self, tools: &mut Tools, patch: &Patch<'_>, rest: &Rest, leaf: &Landed, turn: &UnitQuaternion<f64>) {
        let axes = self.axes(turn, leaf);
        let middle = patch.offset(in_cells(leaf.place, self.side, 0));
        let rise = Rise::new(turn, leaf.yaw, self.side);
        let below = (patch, self.ground.heights.as_ref().map(|_| &tools.floor));
        tools.blade.find(&rest.blade[self.fineness], &axes, &rise, below, middle);
        tools.rim.find(&rest.rim[self.fineness], &axes, &Rise::default(), below, middle);
    }

    /// Adds a leaf that lies below several others: a soft layer as wide as the leaf.
    pub(super) fn bury(&self, patch: &mut Patch<'_>, shape: &Shape, leaf: &Landed) -> Laid {
        let rest = shape.rest(leaf.side);
        let radius = (rest.covered * std::f64::consts::FRAC_1_PI).sqrt() * leaf.scale;
        let [x, z] = patch.offset(in_cells(leaf.place, self.side, 0));
        let height = self.top(patch, patch.cell(x, z));
        let within = (self.side / radius.max(1e-6)) as f32;
        for row in 0..=patch.last[1] as usize {
            for column in 0..=patch.last[0] as usize {
                let away = [column as f32 + 0.5 - x, row as f32 + 0.5 - z].map(|cells| cells * within);
                let share = 1.0 - away[0] * away[0] - away[1] * away[1];
                if let Some(value) = patch.values.get_mut(row * patch.stride + column).filter(|_| share > 0.0) {
                    *value = value.saturating_add(units(2.0 * BURIED * share));
                }
            }
        }
        let attitude = UnitQuaternion::from_axis_angle(&DVec3::y_axis(), leaf.yaw) * rest.level;
        let middle = DVec3::new(leaf.place.x, f64::from(height), leaf.place.y);
        Laid { middle, attitude, is_pressed: true, is_buried: true }
    }

    /// Whether others lie over every line of a leaf that has been laid.
    pub(super) fn hides(&self, patch: &Patch<'_>, shape: &Shape, leaf: &Landed, laid: &Laid) -> bool {
        let rest = shape.rest(leaf.side);
        let turn = laid.attitude * rest.level.inverse();
        let matrix = turn.to_rotation_matrix().into_inner() * leaf.scale;
        let foot = laid.middle - matrix * (rest.level * shape.middle - rest.foot);
        let axes = Axes::new(&matrix, self.side);
        let [middle_x, middle_z] = patch.offset(in_cells(leaf.place, self.side, 0));
        let clear = foot.y as f32 + THICKNESS + 2.0 * self.slack(rest, leaf);
        let is_below = |sample: &Sample| {
            let [x, height, z] = axes.turned([sample.place[0], sample.high, sample.place[1]]);
            self.top(patch, patch.cell(middle_x + x, middle_z + z)) > clear + height
        };
        !rest.samples.is_empty() && rest.samples.iter().all(is_below)
    }

    /// How much the top of a leaf itself may differ within a cell from its height on a line, metres.
    fn slack(&self, rest: &Rest, leaf: &Landed) -> f32 {
        2.0 * UNIT + 0.5 * rest.rise * (self.side / (rest.reach * leaf.scale)) as f32
    }

    /// The turn by which a leaf lies on three contacts about its middle.
    fn leaning(
        &self,
        tools: &mut Tools,
        patch: &Patch<'_>,
        rest: &Rest,
        leaf: &Landed,
        yaw: &UnitQuaternion<f64>,
    ) -> UnitQuaternion<f64> {
        let axes = Axes::new(&(yaw.to_rotation_matrix().into_inner() * leaf.scale), self.side);
        let middle = patch.offset(in_cells(leaf.place, self.side, 0));
        let below = (patch, self.ground.heights.as_ref().map(|_| &tools.floor));
        tools.lows.find(&rest.lows, &axes, &Rise::default(), below, middle);
        let Tools { lows, points, .. } = tools;
        if self.ground.heights.is_none() && lows.is_bare(patch.values) {
            return UnitQuaternion::identity();
        }
        points.clear();
        for (sample, (cell, low, floor)) in rest.samples.iter().zip(lows.iter()) {
            let [x, z] = sample.place.map(|metres| f64::from(metres) * leaf.scale);
            points.push([x, z, f64::from(lying(patch, cell) + floor - low)]);
        }
        for point in &rest.stalk {
            let [x, z] = [point[0], point[2]].map(|metres| f64::from(metres) * leaf.scale);
            points.push([x, z, f64::from(self.met(leaf, axes.turned(*point)))]);
        }
        // It leans against the ground's own slope.
        let ground = self.ground.heights.as_ref().map_or_else(DVec2::zeros, |map| {
            let up = yaw.inverse() * map.normal(leaf.place);
            DVec2::new(-up.x, -up.z) / up.y
        });
        let [_, a, b] = support(points, slope(STEEPEST) + ground.norm(), ACCURACY);
        let leant = DVec2::new(a, b) - ground;
        if leant.norm() < 1e-6 && self.ground.heights.is_none() {
            return UnitQuaternion::identity();
        }
        let leant = ground + leant * (slope(STEEPEST) / leant.norm().max(1e-12)).min(1.0);
        let normal = yaw * DVec3::new(-leant.x, 1.0, -leant.y);
        UnitQuaternion::rotation_between(&DVec3::y(), &normal).unwrap_or_else(UnitQuaternion::identity)
    }

    /// The height of a leaf's foot at its first contact, metres.
    fn height(&self, tools: &Tools, patch: &Patch<'_>, rest: &Rest, axes: &Axes, leaf: &Landed) -> f32 {
        let contact = tools.blade.highest(patch.values, 0.0).max(tools.rim.highest(patch.values, GIVE));
        // a petiole is thinner than a cell: it slips between blades, but not into the ground
        let stalk = rest.stalk.iter().map(|p| self.met(leaf, axes.turned(*p))).fold(f32::NEG_INFINITY, f32::max);
        let ground = match &self.ground.heights {
            None => -tools.blade.lowest.min(tools.rim.lowest),
            Some(_) => self.on_uneven(tools, patch, rest, axes, leaf, contact.max(stalk)),
        };
        let height = ground.max(stalk).max(contact);
        if height.is_finite() { height } else { 0.0 }
    }

    /// The height of a leaf's foot, at least `height`, at which none of its points is in uneven ground, metres.
    fn on_uneven(&self, tools: &Tools, patch: &Patch<'_>, rest: &Rest, axes: &Axes, leaf: &Landed, height: f32) -> f32 {
        // The ground at a point differs by no more than this from that in the middle of its cell.
        let is_cut = patch.last.iter().any(|&last| last + 1.0 >= (1u32 << self.bits) as f32);
        let more = if is_cut { f32::INFINITY } else { (0.75 * self.side * tools.floor.steepest) as f32 + ROUNDING };
        let (mut highest, fineness) = (height, self.fineness);
        for (found, points) in [(&tools.blade, &rest.blade[fineness]), (&tools.rim, &rest.rim[fineness])] {
            for (group, lane) in found.may_touch(height, more) {
                let point = points.groups()[group].at.map(|values| values[lane]);
                highest = highest.max(self.met(leaf, axes.turned(point)));
            }
        }
        highest
    }

    /// The height of the foot at which a point of a leaf touches the ground.
    #[inline]
    fn met(&self, leaf: &Landed, point: [f32; 3]) -> f32 {
        if self.ground.heights.is_none() {
            return -point[1];
        }
        let aside = DVec2::new(f64::from(point[0]), f64::from(point[2])) * self.side;
        self.ground.height(leaf.place + aside) as f32 - point[1]
    }

    #[inline]
    fn top(&self, patch: &Patch<'_>, cell: usize) -> f32 {
        let ground = match &self.ground.heights {
            None => 0.0,
            Some(map) => {
                let at = |axis: usize, cell: usize| middle(patch.first[axis], cell, self.side);
                map.at(DVec2::new(at(0, cell % patch.stride), at(1, cell / patch.stride))) as f32
            }
        };
        lying(patch, cell) + ground
    }
}

/// The height of what lies in a cell over the ground, metres.
#[inline]
fn lying(patch: &Patch<'_>, cell: usize) -> f32 {
    f32::from(patch.value(cell) & !OF_RIM) * UNIT
}

/// How far a leaf may reach about its place, metres.
fn reach(shapes: &[&Shape], leaf: &Landed) -> f64 {
    let of = |shape: u32| shapes.get(shape as usize).map_or(0.0, |shape| shape.rest(leaf.side).reach);
    of(leaf.shape).max(of(leaf.pressed)) * leaf.scale
}

/// A height as a cell's value, rounded to the nearest.
fn units(metres: f32) -> u16 {
    ((metres * (0.5 / UNIT) + 0.5) as u16).saturating_mul(2) & !OF_RIM
}
