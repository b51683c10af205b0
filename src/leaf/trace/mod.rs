//! From a scan to key points in the blade's plane: segment, outline, key points, joint and axis.

pub(in crate::leaf) mod contour;
pub(in crate::leaf) mod key_points;
pub(in crate::leaf) mod symmetry;

use crate::base::picture::Picture;
use crate::base::vector::DVec2;
use crate::leaf::grid::Grid;
use crate::leaf::segmentation::petiole::Petiole;
use crate::leaf::segmentation::{Segment, segmented};
use crate::leaf::trace::symmetry::Symmetry;
use crate::leaf::{LeafError, polygon};

/// How the plane lies in the picture: a turn, a scale and the joint's place; the picture's rows run down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// The joint, pixels.
    pub joint: DVec2,
    /// Unit vector of the blade's axis in the picture, pixels.
    pub axis: DVec2,
    /// Metres of a pixel.
    pub scale: f64,
}

impl Pose {
    /// The point of the plane (metres) of a point of the picture (pixels).
    #[must_use]
    pub fn plane(&self, pixel: DVec2) -> DVec2 {
        let from = pixel - self.joint;
        DVec2::new(from.dot(&self.across()), from.dot(&self.axis)) * self.scale
    }

    /// The point of the picture (pixels) of a point of the plane (metres).
    #[must_use]
    pub fn pixel(&self, plane: DVec2) -> DVec2 {
        self.joint + (self.across() * plane.x + self.axis * plane.y) / self.scale
    }

    /// The direction of +x in the picture: to the right of the axis as seen with rows running down.
    fn across(&self) -> DVec2 {
        DVec2::new(-self.axis.y, self.axis.x)
    }
}

/// A traced scan. Places are pixels of the picture, the centre of the top left pixel at (0.5, 0.5). Seen with rows running
/// down, `outline` and `keys` run counter-clockwise round the blade, `holes` and `hole_keys` clockwise: the blade is always to
/// the left.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// True on the blade, petiole and kept gaps excluded.
    pub(in crate::leaf) blade: Grid<bool>,
    /// True where the blade's own colour shows.
    pub(in crate::leaf) shown: Grid<bool>,
    /// The outline with sub-pixel places.
    pub outline: Vec<DVec2>,
    /// Key points, in the outline's order.
    pub keys: Vec<DVec2>,
    /// Rims of the gaps through which the background is seen, each at least a thousandth of the leaf's area.
    pub holes: Vec<Vec<DVec2>>,
    /// Key points of each hole.
    pub hole_keys: Vec<Vec<DVec2>>,
    /// Hausdorff distance of the spline through the keys from the outline, and of those of the holes, pixels.
    pub hausdorff: f64,
    /// How plane and picture lie to each other.
    pub pose: Pose,
    /// The petiole that was cut off, when there is one.
    pub petiole: Option<Petiole>,
    /// See-through gaps that were kept as holes.
    pub gaps: usize,
    /// Enclosed places that were filled: pale spots, and gaps too small to keep.
    pub filled: usize,
    /// Further leaves on the sheet: parts of at least a tenth of this one's area. This one is the largest.
    pub others: usize,
}

impl Trace {
    /// Key points of a `leaf.outline`: millimetres, the joint at the origin.
    #[must_use]
    pub fn outline_millimetres(&self) -> Vec<[f64; 2]> {
        self.keys.iter().map(|&p| (self.pose.plane(p) * 1e3).into()).collect()
    }

    /// The size of the picture, pixels.
    #[must_use]
    pub fn picture_size(&self) -> [usize; 2] {
        [self.blade.width, self.blade.height]
    }

    /// Area of the blade without its holes, pixels.
    #[must_use]
    pub fn area(&self) -> usize {
        self.blade.area()
    }

    /// Share of the pixels in either the traced blade's mask (without its holes) or a truth polygon (pixels; it may cross itself: filled by the
    /// non-zero rule) that lie in both.
    #[must_use]
    pub fn iou(&self, truth: &[[f64; 2]]) -> f64 {
        let (mut both, mut either) = (0u64, 0u64);
        for y in 0..self.blade.height {
            let turns = windings(truth, y as f64 + 0.5);
            let (mut rank, mut winding) = (0, 0);
            for x in 0..self.blade.width {
                while rank < turns.len() && turns[rank].0 <= x as f64 + 0.5 {
                    winding += turns[rank].1;
                    rank += 1;
                }
                let (a, b) = (self.blade.at(x, y), winding != 0);
                both += u64::from(a && b);
                either += u64::from(a || b);
            }
        }
        both as f64 / either.max(1) as f64
    }
}

/// Where a row crosses a polygon's sides, and in which sense, from left to right.
fn windings(polygon: &[[f64; 2]], y: f64) -> Vec<(f64, i32)> {
    let mut turns = Vec::new();
    for (i, a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        if (a[1] > y) != (b[1] > y) {
            let x = a[0] + (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]);
            turns.push((x, if b[1] > a[1] { 1 } else { -1 }));
        }
    }
    turns.sort_by(|a, b| a.0.total_cmp(&b.0));
    turns
}

/// Traces the leaf in a picture; `length` in metres from the joint to the farthest key point, the joint in pixels where it is
/// known, `tolerance` in pixels (a thousandth
/// of the diagonal of the blade's bounding box, at least 1, without one), `corner` in radians.
///
/// # Errors
/// [`LeafError::Picture`] when there is no leaf, or its outline cannot be followed.
pub fn traced(
    picture: &Picture,
    (length, joint): (f64, Option<DVec2>),
    tolerance: Option<f64>,
    corner: f64,
) -> Result<Trace, LeafError> {
    let segment = segmented(picture)?;
    let mut lines = contour::outlined(&segment.blade).into_iter();
    let outline = lines.next().filter(|line| line.len() >= 16);
    let outline = outline.ok_or_else(|| LeafError::picture("the leaf is too small in the picture; scan it larger"))?;
    let tolerance = tolerance.unwrap_or_else(|| default_tolerance(&outline));
    let (keys, mut hausdorff) = keyed(&outline, tolerance, corner)?;
    // a gap that is kept is far longer round than the blur's specks
    let holes: Vec<Vec<DVec2>> = lines.filter(|l| l.len() >= 16 && polygon::doubled_area(l) > 0.0).collect();
    let mut hole_keys = Vec::with_capacity(holes.len());
    for hole in &holes {
        let (keys, distance) = keyed(hole, tolerance, corner)?;
        hausdorff = hausdorff.max(distance);
        hole_keys.push(keys);
    }
    let mut pose = posed(&segment.blade, &outline, joint.or(segment.joint));
    pose.scale = length / keys.iter().map(|key| (key - pose.joint).norm()).fold(f64::MIN_POSITIVE, f64::max);
    let Segment { blade, shown, petiole, gaps, filled, others, .. } = segment;
    Ok(Trace { blade, shown, outline, keys, holes, hole_keys, hausdorff, pose, petiole, gaps, filled, others })
}

fn default_tolerance(outline: &[DVec2]) -> f64 {
    let low = outline.iter().fold(outline[0], |low, p| low.inf(p));
    let high = outline.iter().fold(outline[0], |high, p| high.sup(p));
    (0.001 * (high - low).norm()).max(1.0)
}

/// Key points of a closed line, and the distance of their spline from it. Where the spline crosses itself, as it can in a
/// narrow place, a smaller bound is tried.
///
/// # Errors
/// [`LeafError::Picture`] with the place where the spline crosses itself.
fn keyed(line: &[DVec2], tolerance: f64, corner: f64) -> Result<(Vec<DVec2>, f64), LeafError> {
    let mut bound = tolerance;
    let mut place = line[0];
    for _ in 0..4 {
        let chosen = key_points::chosen(line, bound, corner);
        let spline = key_points::spline(line, &chosen, corner);
        let drawn = spline.polyline(16);
        let Some((side, _)) = polygon::crossing(&drawn) else {
            let keys = chosen.iter().map(|&i| line[i]).collect();
            return Ok((keys, key_points::distance(line, &chosen, &spline)));
        };
        place = drawn[side];
        bound *= 0.5;
    }
    Err(LeafError::picture(&format!(
        "the leaf's outline crosses itself near column {:.0}, row {:.0} of the picture; give a larger picture, or a smaller \
         leaf.tolerance_px",
        place.x, place.y
    )))
}

/// Joint and axis of a blade; the scale is left at 1.
fn posed(blade: &Grid<bool>, outline: &[DVec2], stalk: Option<DVec2>) -> Pose {
    let symmetry = Symmetry::of(blade);
    let centre = symmetry.centre;
    let near = |target: DVec2| {
        let far = |p: &&DVec2| (*p - target).norm();
        outline.iter().min_by(|a, b| far(a).total_cmp(&far(b))).copied().unwrap_or(target)
    };
    let joint = stalk.map_or_else(|| symmetry.joint(outline), near);
    let heading = (centre - joint).try_normalize(0.0).unwrap_or_else(DVec2::y);
    let ahead = |p: &&DVec2| {
        let from = *p - joint;
        from.dot(&heading) > from.norm() * 0.82
    };
    let far = |p: &DVec2| (p - joint).norm();
    let tip = outline.iter().filter(ahead).max_by(|a, b| far(a).total_cmp(&far(b))).copied().unwrap_or(centre);
    Pose { joint, axis: (tip - joint).try_normalize(0.0).unwrap_or_else(DVec2::y), scale: 1.0 }
}

#[cfg(test)]
mod tests;
