//! How a bent leaf lies on level ground, by either side: on the three lowest points about its middle.
//!
//! The plane that carries a body is the facet of the lower convex hull below its centre of mass. Of all planes below the shape
//! it is the one that is highest at the centre: the maximum of the concave function min_i (h_i - a p_i - b q_i) of the slopes
//! a and b, found by nested golden sections. A curled leaf thus stands on its rims and a flat one lies.

use super::footprint::LANES;
use super::lines::{End, Line, Lines};
use super::support::{Cloud, support};
use crate::base::mesh::Mesh;
use crate::base::vector::{DVec2, DVec3, Vec3};
use nalgebra::{Rotation3, UnitQuaternion};

/// Distance of the lines through a shape, metres: what it leans on and what hides it is judged on them.
const SAMPLE: f64 = 7e-3;
/// Most samples along one side of a shape; larger leaves are sampled farther apart.
const MOST: f64 = 24.0;
/// Steepest slope at which a shape may stand on its rims.
const STEEPEST: f64 = 0.7;
/// Points of a petiole that may touch the ground.
const STALK: usize = 4;
/// Distance of the points of a blade, metres, for each fineness: below the side of a cell.
const POINTS: [f64; 2] = [1.5e-3, 2.4e-3];
/// Most points along one side of a shape.
const MOST_POINTS: f64 = 256.0;
/// Distance of the points along a rim, metres, and most parts of one edge.
const RIMS: [f64; 2] = [1.5e-3, 2.2e-3];
const MOST_PARTS: u32 = 64;
/// Room about what a leaf may reach, metres.
const ROOM: f64 = 0.01;

/// The side of a leaf that faces the sky.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Its upper side.
    Upper,
    /// Its lower side.
    Lower,
}

/// Where a straight petiole ends that begins at the origin of its blade, metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stalk {
    /// On the twig and in the air.
    pub hung: Vec3,
    /// On the ground.
    pub lying: Vec3,
}

/// A vertical line through a lying shape of scale 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    /// Where, from the leaf's middle, along x and z before it is turned, metres.
    pub place: [f32; 2],
    /// Lowest point above the ground, metres.
    pub low: f32,
    /// Highest point above the ground, metres.
    pub high: f32,
}

/// Points of a lying blade of scale 1, coordinate by coordinate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Group {
    /// Along x from the middle, heights over the ground, along z, metres.
    pub at: [[f32; LANES]; 3],
    /// How the blade rises there along x and z, metres a metre.
    pub slope: [[f32; LANES]; 2],
}

/// Points in groups; the last one is filled up with its first point.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Points {
    groups: Vec<Group>,
}

impl Points {
    fn new(points: impl Iterator<Item = ([f32; 3], [f32; 2])>) -> Self {
        let points: Vec<([f32; 3], [f32; 2])> = points.collect();
        let group = |points: &[([f32; 3], [f32; 2])]| {
            let lane = |lane: usize| points.get(lane).unwrap_or(&points[0]);
            Group {
                at: std::array::from_fn(|k| std::array::from_fn(|n| lane(n).0[k])),
                slope: std::array::from_fn(|k| std::array::from_fn(|n| lane(n).1[k])),
            }
        };
        Self { groups: points.chunks(LANES).map(group).collect() }
    }

    /// The groups.
    pub(super) fn groups(&self) -> &[Group] {
        &self.groups
    }

    /// All points; some more than once.
    #[cfg(test)]
    fn iter(&self) -> impl Iterator<Item = [f32; 3]> {
        self.groups.iter().flat_map(|group| (0..LANES).map(|lane| group.at.map(|values| values[lane])))
    }
}

/// A shape as it lies on one side.
#[derive(Clone, Debug)]
pub(super) struct Rest {
    /// From the model's axes to those of the ground.
    pub level: UnitQuaternion<f64>,
    /// The point of the turned model that lies on the ground below its middle, metres.
    pub foot: DVec3,
    /// Points of the blade, closer than cells, for each fineness.
    pub blade: [Points; 2],
    /// Points of its rim, with no slope.
    pub rim: [Points; 2],
    /// Points of the petiole.
    pub stalk: Vec<[f32; 3]>,
    /// Lines through the blade.
    pub samples: Vec<Sample>,
    /// Their lowest points, with no slope.
    pub lows: Points,
    /// The height of the highest of them, metres.
    pub rise: f32,
    /// Area that the blade covers, m2.
    pub covered: f64,
    /// Within so many metres of the middle lies all of it, however it leans.
    pub reach: f64,
}

/// A shape that can fly and lie.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Its middle in the model's coordinates, metres.
    pub middle: DVec3,
    /// The corners of its convex hull and more, with what hangs from it, in the model's coordinates.
    outline: Vec<DVec3>,
    rests: [Rest; 2],
}

impl Shape {
    /// A shape of a mesh in the axes of blades: base to tip along y, the upper side towards +z. A mesh without vertices is a
    /// point.
    #[must_use]
    pub fn new(mesh: &Mesh, stalk: Stalk) -> Self {
        let sum = mesh.positions.iter().fold(DVec3::zeros(), |sum, p| sum + p.cast::<f64>());
        let middle = sum / mesh.positions.len().max(1) as f64;
        let outline = mesh.positions.iter().chain([&stalk.hung]).map(|p| p.cast::<f64>()).collect();
        let rests = [Side::Upper, Side::Lower].map(|side| rest(mesh, stalk.lying, middle, side));
        Self { middle, outline, rests }
    }

    pub(super) fn rest(&self, side: Side) -> &Rest {
        &self.rests[side as usize]
    }

    /// Attitude on level ground, turned by `yaw` radians.
    #[must_use]
    pub fn level(&self, side: Side, yaw: f64) -> UnitQuaternion<f64> {
        UnitQuaternion::from_axis_angle(&DVec3::y_axis(), yaw) * self.rest(side).level
    }

    /// Height of the middle over level ground, metres.
    #[must_use]
    pub fn stands(&self, side: Side) -> f64 {
        let rest = self.rest(side);
        (rest.level * self.middle).y - rest.foot.y
    }

    /// The lowest point in an attitude, relative to the middle, metres.
    #[must_use]
    pub fn lowest(&self, attitude: &UnitQuaternion<f64>) -> f64 {
        let down = attitude.inverse() * DVec3::y();
        let height = |point: &DVec3| (point - self.middle).dot(&down);
        self.outline.iter().map(height).fold(0.0, f64::min)
    }
}

/// From the model's axes to the ground's: x stays, the given side turns to +y.
fn laid(point: DVec3, side: Side) -> DVec3 {
    match side {
        Side::Upper => DVec3::new(point.x, point.z, -point.y),
        Side::Lower => DVec3::new(point.x, -point.z, point.y),
    }
}

fn rest(mesh: &Mesh, stalk: Vec3, middle: DVec3, side: Side) -> Rest {
    let axes = [DVec3::x(), DVec3::y(), DVec3::z()].map(|axis| laid(axis, side));
    let base =
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(nalgebra::Matrix3::from_columns(&axes)));
    let along = (1..=STALK).map(|part| stalk * (part as f32 / STALK as f32));
    let places = mesh.positions.iter().copied().chain(along);
    let points: Vec<DVec3> = places.map(|p| base * (p.cast::<f64>() - middle)).collect();
    let [a, b] = carrying(&points);
    let normal = DVec3::new(-a, 1.0, -b);
    let upright = UnitQuaternion::rotation_between(&normal, &DVec3::y()).unwrap_or_else(UnitQuaternion::identity);
    let level = upright * base;
    let turned: Vec<DVec3> = points.iter().map(|p| upright * p).collect();
    let lowest = turned.iter().map(|p| p.y).fold(f64::INFINITY, f64::min);
    let lowest = if lowest.is_finite() { lowest } else { 0.0 };
    let (vertices, stalk) = turned.split_at(mesh.positions.len());
    let coarse = Lines::new(vertices, &mesh.triangles, SAMPLE, MOST);
    let fine = POINTS.map(|apart| Lines::new(vertices, &mesh.triangles, apart, MOST_POINTS));
    let foot = level * middle + DVec3::new(0.0, lowest, 0.0);
    let reach = turned.iter().map(|p| p.norm() + p.y - lowest).fold(0.0, f64::max) + ROOM;
    let covered = coarse.lines.len() as f64 * coarse.step * coarse.step;
    let single = |points: &[DVec3]| -> Vec<[f32; 3]> {
        points.iter().map(|p| [p.x as f32, (p.y - lowest) as f32, p.z as f32]).collect()
    };
    let height = |end: End| (end.height - lowest) as f32;
    let sample = |line: &Line| Sample {
        place: [line.place.x as f32, line.place.y as f32],
        low: height(line.low),
        high: height(line.high),
    };
    let point = |(place, end): (DVec2, End)| {
        ([place.x as f32, height(end), place.y as f32], [end.slope.x as f32, end.slope.y as f32])
    };
    let rim = RIMS.map(|apart| single(&along_rim(vertices, &mesh.triangles, apart)));
    Rest {
        level,
        foot,
        blade: fine.map(|lines| Points::new(lines.ends().map(point))),
        rim: rim.map(|rim| Points::new(rim.into_iter().map(|at| (at, [0.0; 2])))),
        stalk: single(stalk),
        rise: coarse.lines.iter().map(|line| height(line.high)).fold(0.0, f32::max),
        lows: Points::new(coarse.lines.iter().map(sample).map(|s| ([s.place[0], s.low, s.place[1]], [0.0; 2]))),
        samples: coarse.lines.iter().map(sample).collect(),
        covered,
        reach,
    }
}

/// Points along the edges that belong to one triangle only, so many metres apart.
fn along_rim(points: &[DVec3], triangles: &[[u32; 3]], apart: f64) -> Vec<DVec3> {
    let edge = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
    let mut edges: Vec<[u32; 2]> = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]].map(edge)).collect();
    edges.sort_unstable();
    let rim = edges.chunk_by(|one, next| one == next).filter(|same| same.len() == 1).map(|same| same[0]);
    let between = |[a, b]: [u32; 2]| {
        let (from, to) = (points[a as usize], points[b as usize]);
        let parts = ((to - from).norm() / apart) as u32 + 1;
        (0..parts.min(MOST_PARTS)).map(move |part| from + (to - from) * (f64::from(part) / f64::from(parts)))
    };
    rim.flat_map(between).collect()
}

/// Slopes along x and z of the plane that carries the points.
fn carrying(points: &[DVec3]) -> [f64; 2] {
    let mut hanging = Cloud::default();
    points.iter().for_each(|p| hanging.push([p.x, p.z, -p.y]));
    let [_, a, b] = support(&hanging, STEEPEST, 1e-7);
    [-a, -b]
}

#[cfg(test)]
mod tests {
    use super::super::tests::blade;
    use super::*;

    #[test]
    fn a_flat_leaf_lies_flat_on_either_side() {
        let shape = Shape::new(&blade(0.0), Stalk::default());
        for side in [Side::Upper, Side::Lower] {
            let rest = shape.rest(side);
            assert!(rest.samples.iter().all(|s| s.low.abs() < 1e-6 && s.high < 1e-6));
            assert!(shape.stands(side).abs() < 1e-6);
            let up = rest.level * DVec3::z();
            assert!((up.y.abs() - 1.0).abs() < 1e-6 && (up.y > 0.0) == (side == Side::Upper));
        }
    }

    #[test]
    fn a_bowl_stands_on_its_bottom_and_turned_over_on_its_rim() {
        let shape = Shape::new(&blade(8.0), Stalk::default());
        let [up, down] = [Side::Upper, Side::Lower].map(|side| shape.rest(side));
        let touching = |rest: &Rest| rest.samples.iter().filter(|s| s.low < 5e-4).count();
        assert!(up.samples.iter().chain(&down.samples).all(|s| s.low >= -1e-6 && s.high >= s.low));
        assert!(touching(up) > 0 && touching(down) >= 3, "{} {}", touching(up), touching(down));
        // Upside down its middle is the highest part.
        let centre = |rest: &Rest| {
            let near = rest
                .samples
                .iter()
                .min_by(|a, b| libm::hypotf(a.place[0], a.place[1]).total_cmp(&libm::hypotf(b.place[0], b.place[1])));
            near.unwrap().low
        };
        assert!(centre(up) < 1e-3 && centre(down) > 3e-3, "{} {}", centre(up), centre(down));
    }

    #[test]
    fn a_tilted_shape_comes_down_on_three_points_about_its_middle() {
        let mut mesh = blade(8.0);
        for p in &mut mesh.positions {
            p.z += 0.25 * p.x - 0.15 * p.y;
        }
        let shape = Shape::new(&mesh, Stalk::default());
        let rest = shape.rest(Side::Lower);
        let points = rest.rim[0].iter().chain(rest.blade[0].iter());
        let feet = points.filter(|v| v[1] < 3e-4);
        let feet: Vec<DVec2> = feet.map(|v| DVec2::new(f64::from(v[0]), f64::from(v[2]))).collect();
        let around = (0..8).all(|k| {
            let angle = f64::from(k) * std::f64::consts::FRAC_PI_4;
            let way = DVec2::new(crate::base::maths::cos(angle), crate::base::maths::sin(angle));
            feet.iter().any(|foot| foot.dot(&way) > 0.0)
        });
        assert!(around, "{feet:?}");
    }
}
