//! A leaf that comes down on the ground and on what lies there, to its first contact.
//!
//! All leaves are compared on one lattice, whose cells hold the height of the topmost blade at their middles, or that of a
//! point of a rim within them that is higher. A leaf comes down until one of its blade's points, taken along its slope to the
//! middle of its cell, or a point of its rim is met. What it touches is thus within half a cell's diagonal and a thickness;
//! only rims pass one another, by little.

use super::columns::{Columns, Patch};
use super::descent::slope;
use super::litter::{Laid, Landed};
use super::shape::{Rest, Shape};
use super::support::{Point, support};
use super::{Ground, shape::Sample};
use crate::base::vector::{DMat3, DVec2, DVec3};
use nalgebra::UnitQuaternion;

/// Side of a cell, metres: half its diagonal is below 2 mm.
const CELL: f64 = 2.5e-3;
/// Coarsest cells, of a large stand.
const COARSEST: f64 = 8e-3;
/// What one unit of a cell's value is worth, metres. The lowest bit tells that the height is that of a rim.
const UNIT: f32 = 5e-5;
const OF_RIM: u16 = 1;
/// How far rims pass one another, metres: they need not lie one above the other where their vertices lie in one cell.
const GIVE: f32 = 1e-3;
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
/// Metres about a leaf's middle that its blade may reach.
const MARGIN: f64 = 0.5;

/// What leaves come down on, with what is needed on the way.
pub(super) struct Bed<'a> {
    ground: &'a Ground,
    columns: Columns,
    patch: Patch,
    /// Cells below the leaf, with its height over its foot there and whether that is a rim's.
    below: Vec<(u32, f32, u16)>,
    points: Vec<Point>,
}

impl<'a> Bed<'a> {
    /// Bare ground. The cells of large stands are coarser, for the memory's sake.
    pub(super) fn new(ground: &'a Ground, landed: &[Landed]) -> Self {
        let pairs = ground.trunks.len() as f64 / 2.0;
        let side = (CELL * pairs.max(1.0).sqrt()).min(COARSEST);
        let columns = Columns::new(side, landed.iter().map(|leaf| leaf.place), MARGIN);
        Self { ground, columns, patch: Patch::default(), below: Vec::new(), points: Vec::new() }
    }

    /// Lays a leaf on what is there.
    pub(super) fn lay(&mut self, shape: &Shape, leaf: &Landed) -> Laid {
        let rest = shape.rest(leaf.side);
        self.columns.lift(leaf.place, rest.reach * leaf.scale, &mut self.patch);
        let yaw = UnitQuaternion::from_axis_angle(&DVec3::y_axis(), leaf.yaw);
        let turn = self.leaning(rest, leaf, &yaw) * yaw;
        let matrix = turn.to_rotation_matrix().into_inner() * leaf.scale;
        let axes = Axes::new(&matrix, self.columns.side);
        let height = self.height(rest, &axes, &turn, leaf);
        for &(cell, over, of_rim) in &self.below {
            let top = units(height + over + THICKNESS - self.ground_at(cell as usize)) | of_rim;
            let value = &mut self.patch.values[cell as usize];
            *value = top.max(*value);
        }
        self.columns.lower(&self.patch);
        let middle = rest.level * shape.middle - rest.foot;
        let foot = DVec3::new(leaf.place.x, f64::from(height), leaf.place.y);
        Laid { middle: foot + matrix * middle, attitude: turn * rest.level, is_pressed: false, is_buried: false }
    }

    /// Adds a leaf that lies below several others: a soft layer as wide as the leaf.
    pub(super) fn bury(&mut self, shape: &Shape, leaf: &Landed) -> Laid {
        let rest = shape.rest(leaf.side);
        let radius = (rest.covered * std::f64::consts::FRAC_1_PI).sqrt() * leaf.scale;
        self.columns.lift(leaf.place, radius + 2.0 * self.columns.side, &mut self.patch);
        let [x, z] = self.patch.middle;
        let centre = self.patch.cell(x, z);
        let height = self.top(centre);
        let within = (self.columns.side / radius.max(1e-6)) as f32;
        for row in 0..self.patch.side {
            for column in 0..self.patch.side {
                let away = [column as f32 + 0.5 - x, row as f32 + 0.5 - z].map(|cells| cells * within);
                let share = 1.0 - away[0] * away[0] - away[1] * away[1];
                if share > 0.0 {
                    let value = &mut self.patch.values[row * self.patch.side + column];
                    *value = value.saturating_add(units(2.0 * BURIED * share));
                }
            }
        }
        self.columns.lower(&self.patch);
        let attitude = UnitQuaternion::from_axis_angle(&DVec3::y_axis(), leaf.yaw) * rest.level;
        let middle = DVec3::new(leaf.place.x, f64::from(height), leaf.place.y);
        Laid { middle, attitude, is_pressed: true, is_buried: true }
    }

    /// Whether others lie over every line of a leaf that has been laid.
    pub(super) fn hides(&mut self, shape: &Shape, leaf: &Landed, laid: &Laid) -> bool {
        let rest = shape.rest(leaf.side);
        let turn = laid.attitude * rest.level.inverse();
        let matrix = turn.to_rotation_matrix().into_inner() * leaf.scale;
        let foot = laid.middle - matrix * (rest.level * shape.middle - rest.foot);
        let axes = Axes::new(&matrix, self.columns.side);
        self.columns.lift(leaf.place, rest.reach * leaf.scale, &mut self.patch);
        let is_below = |sample: &Sample| {
            let [x, height, z] = axes.turned([sample.place[0], sample.high, sample.place[1]]);
            let top = self.top(self.patch.cell(self.patch.middle[0] + x, self.patch.middle[1] + z));
            top > foot.y as f32 + height + THICKNESS + 2.0 * self.slack(rest, leaf)
        };
        !rest.samples.is_empty() && rest.samples.iter().all(is_below)
    }

    /// How much the top of a leaf itself may differ within a cell from its height on a line, metres.
    fn slack(&self, rest: &Rest, leaf: &Landed) -> f32 {
        let rise = rest.samples.iter().fold(0.0f32, |most, sample| most.max(sample.high));
        2.0 * UNIT + 0.5 * rise * (self.columns.side / (rest.reach * leaf.scale)) as f32
    }

    /// The turn by which a leaf lies on three contacts about its middle.
    fn leaning(&mut self, rest: &Rest, leaf: &Landed, yaw: &UnitQuaternion<f64>) -> UnitQuaternion<f64> {
        let axes = Axes::new(&(yaw.to_rotation_matrix().into_inner() * leaf.scale), self.columns.side);
        let mut is_bare = self.ground.heights.is_none();
        self.points.clear();
        for sample in &rest.samples {
            let [x, low, z] = axes.turned([sample.place[0], sample.low, sample.place[1]]);
            let cell = self.patch.cell(self.patch.middle[0] + x, self.patch.middle[1] + z);
            is_bare &= self.patch.values[cell] == 0;
            let place = sample.place.map(|metres| f64::from(metres) * leaf.scale);
            self.points.push([place[0], place[1], f64::from(self.top(cell) - low)]);
        }
        for point in &rest.stalk {
            let place = [point[0], point[2]].map(|metres| f64::from(metres) * leaf.scale);
            self.points.push([place[0], place[1], f64::from(self.met(leaf, axes.turned(*point)))]);
        }
        let [_, a, b] = if is_bare { [0.0; 3] } else { support(&self.points, slope(STEEPEST), ACCURACY) };
        let size = DVec2::new(a, b).norm();
        if size < 1e-6 {
            return UnitQuaternion::identity();
        }
        let part = (slope(STEEPEST) / size).min(1.0);
        let normal = yaw * DVec3::new(-a * part, 1.0, -b * part);
        UnitQuaternion::rotation_between(&DVec3::y(), &normal).unwrap_or_else(UnitQuaternion::identity)
    }

    /// The height of a leaf's foot at its first contact, metres; the cells below it are left in `below`.
    fn height(&mut self, rest: &Rest, axes: &Axes, turn: &UnitQuaternion<f64>, leaf: &Landed) -> f32 {
        let rise = Rise::new(turn, leaf.yaw, self.columns.side);
        let mut height = f32::NEG_INFINITY;
        self.below.clear();
        for point in &rest.blade {
            let turned = axes.turned(point.at);
            let (cell, aside) = self.patch.cell_of(turned[0], turned[2]);
            let over = turned[1] + rise.over(point.slope, aside);
            height = height.max(self.top(cell) - over).max(self.met(leaf, turned));
            self.below.push((cell as u32, over, 0));
        }
        for point in &rest.rim {
            let turned = axes.turned(*point);
            let (cell, _) = self.patch.cell_of(turned[0], turned[2]);
            let give = if self.patch.values[cell] & OF_RIM == 0 { 0.0 } else { GIVE };
            height = height.max(self.top(cell) - turned[1] - give).max(self.met(leaf, turned));
            self.below.push((cell as u32, turned[1], OF_RIM));
        }
        // a petiole is thinner than a cell: it slips between blades, but not into the ground
        let height = rest.stalk.iter().map(|point| self.met(leaf, axes.turned(*point))).fold(height, f32::max);
        if height.is_finite() { height } else { 0.0 }
    }

    /// The height of the foot at which a point of a leaf touches the ground.
    #[inline]
    fn met(&self, leaf: &Landed, point: [f32; 3]) -> f32 {
        if self.ground.heights.is_none() {
            return -point[1];
        }
        let aside = DVec2::new(f64::from(point[0]), f64::from(point[2])) * self.columns.side;
        self.ground.height(leaf.place + aside) as f32 - point[1]
    }

    #[inline]
    fn top(&self, cell: usize) -> f32 {
        f32::from(self.patch.values[cell] & !OF_RIM) * UNIT + self.ground_at(cell)
    }

    #[inline]
    fn ground_at(&self, cell: usize) -> f32 {
        match self.ground.heights {
            None => 0.0,
            Some(_) => self.ground.height(self.patch.place(cell, self.columns.side)) as f32,
        }
    }
}

/// A height as a cell's value, rounded to the nearest.
fn units(metres: f32) -> u16 {
    ((metres * (0.5 / UNIT) + 0.5) as u16).saturating_mul(2) & !OF_RIM
}

/// How a leaf's points rise within their cells.
struct Rise {
    /// Cosine and sine of its turn, in metres a cell.
    turn: [f32; 2],
    /// The slopes along x and z by which it leans, in metres a cell.
    lean: [f32; 2],
}

impl Rise {
    fn new(turn: &UnitQuaternion<f64>, yaw: f64, side: f64) -> Self {
        let (sine, cosine) = crate::base::maths::sincos(yaw);
        let up = turn * DVec3::y();
        let lean = [-up.x / up.y, -up.z / up.y].map(|slope| (slope * side) as f32);
        Self { turn: [(cosine * side) as f32, (sine * side) as f32], lean }
    }

    /// The rise of a point of this slope towards the middle of its cell, metres; slopes are taken to add to the lean.
    #[inline]
    fn over(&self, [x, z]: [f32; 2], aside: [f32; 2]) -> f32 {
        let [cosine, sine] = self.turn;
        (x * cosine + z * sine + self.lean[0]) * aside[0] + (z * cosine - x * sine + self.lean[1]) * aside[1]
    }
}

/// The axes of a lying leaf: x and z in cells, y in metres.
struct Axes([[f32; 3]; 3]);

impl Axes {
    fn new(matrix: &DMat3, side: f64) -> Self {
        let unit = [1.0 / side, 1.0, 1.0 / side];
        Self(std::array::from_fn(|axis| std::array::from_fn(|k| (matrix[(k, axis)] * unit[k]) as f32)))
    }

    #[inline]
    fn turned(&self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        let [a, b, c] = &self.0;
        std::array::from_fn(|k| a[k] * x + b[k] * y + c[k] * z)
    }
}
