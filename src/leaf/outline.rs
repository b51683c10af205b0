//! An outline as the user gives it: its faults, and its clean form (distinct neighbours, counter-clockwise, scaled).

use crate::base::settings::Complaint;
use crate::base::vector::DVec2;
use crate::leaf::polygon;
use crate::leaf::spline::Spline;

/// Neighbours nearer than this share of the outline's size are one point.
const MERGED: f64 = 1e-9;
/// Points of the spline between two keys when looking for crossings.
const CROSSING_SAMPLES: usize = 8;

/// What is wrong with an outline; nothing if it can be meshed. `corner` is the turning angle of sharp keys, radians.
pub fn complaints(outline: &[[f64; 2]], corner: f64) -> Vec<Complaint> {
    if let Some(place) = outline.iter().position(|p| !p[0].is_finite() || !p[1].is_finite()) {
        return vec![complaint(format!("point {place} is not finite"), "give two finite millimetres for every point")];
    }
    let keys = distinct(outline);
    if distinct_count(&keys) < 3 {
        return vec![complaint("fewer than 3 distinct points".to_owned(), "give at least 3 points round the blade")];
    }
    let size = extent(&keys);
    if let Some((i, j)) = spline_crossing(&keys, corner) {
        let place = |k: usize| format!("[{}, {}]", keys[k].x, keys[k].y);
        let next = |k: usize| place((k + 1) % keys.len());
        let message = format!(
            "the outline crosses itself: the curve from {} to {} meets that from {} to {}",
            place(i),
            next(i),
            place(j),
            next(j)
        );
        return vec![complaint(
            message,
            "give the points in order round the blade, or more of them where it is narrow",
        )];
    }
    if polygon::doubled_area(&keys).abs() <= 1e-6 * size * size {
        return vec![complaint("the outline encloses no area".to_owned(), "its points must not lie on one line")];
    }
    if keys.iter().map(|p| p.norm()).fold(0.0, f64::max) <= 1e-6 * size {
        return vec![complaint("the outline has no length".to_owned(), "the joint of the petiole is the origin")];
    }
    Vec::new()
}

fn complaint(message: String, help: &str) -> Complaint {
    Complaint::new("outline", message, help)
}

fn extent(points: &[DVec2]) -> f64 {
    let low = points.iter().fold(points[0], |low, p| low.inf(p));
    let high = points.iter().fold(points[0], |high, p| high.sup(p));
    (high - low).norm()
}

fn distinct_count(points: &[DVec2]) -> usize {
    let mut sorted: Vec<(u64, u64)> = points.iter().map(|p| (p.x.to_bits(), p.y.to_bits())).collect();
    sorted.sort_unstable();
    sorted.dedup();
    sorted.len()
}

/// The points without repeated neighbours.
fn distinct(outline: &[[f64; 2]]) -> Vec<DVec2> {
    let all: Vec<DVec2> = outline.iter().map(|p| DVec2::new(p[0] + 0.0, p[1] + 0.0)).collect();
    let Some(&first) = all.first() else { return all };
    let near = MERGED * extent(&all);
    let mut kept: Vec<DVec2> = Vec::with_capacity(all.len());
    for p in all {
        if kept.last().is_none_or(|last| (p - last).norm() > near) {
            kept.push(p);
        }
    }
    while kept.len() > 1 && (kept[kept.len() - 1] - first).norm() <= near {
        kept.pop();
    }
    kept
}

/// The keys (by the number of the span's first) whose curves cross.
fn spline_crossing(keys: &[DVec2], corner: f64) -> Option<(usize, usize)> {
    let line = Spline::through(keys, corner).polyline(CROSSING_SAMPLES);
    polygon::crossing(&line).map(|(i, j)| (i / CROSSING_SAMPLES, j / CROSSING_SAMPLES))
}

/// Metres of a unit of an outline whose point farthest from the origin is to lie at `length`.
pub fn scale(outline: &[[f64; 2]], length: f64) -> f64 {
    let farthest = outline.iter().map(|p| DVec2::from(*p).norm()).fold(0.0, f64::max);
    length / farthest.max(f64::MIN_POSITIVE)
}

/// The keys of a gap, clockwise, in metres.
pub fn cleaned_hole(hole: &[[f64; 2]], scale: f64) -> Vec<DVec2> {
    let mut keys = distinct(hole);
    if polygon::doubled_area(&keys) > 0.0 {
        keys.reverse();
    }
    keys.iter().map(|p| p * scale).collect()
}

/// The keys counter-clockwise from the one nearest the joint, scaled so that the point farthest from the origin lies at
/// `length`. A clockwise outline gives the same keys as its reverse.
pub fn cleaned(outline: &[[f64; 2]], length: f64) -> Vec<DVec2> {
    let mut keys = distinct(outline);
    if polygon::doubled_area(&keys) < 0.0 {
        keys.reverse();
    }
    let farthest = keys.iter().map(|p| p.norm()).fold(0.0, f64::max);
    let order = |&i: &usize, &j: &usize| {
        let (a, b) = (keys[i], keys[j]);
        a.norm().total_cmp(&b.norm()).then(a.x.total_cmp(&b.x)).then(a.y.total_cmp(&b.y))
    };
    let first = (0..keys.len()).min_by(order).unwrap_or(0);
    keys.rotate_left(first);
    keys.iter().map(|p| p * (length / farthest)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_name_what_is_wrong() {
        let message =
            |points: &[[f64; 2]]| complaints(points, 1.1).first().map(|c| c.message.clone()).unwrap_or_default();
        assert!(message(&[[0.0, 0.0], [1.0, f64::NAN], [2.0, 2.0]]).contains("point 1 is not finite"));
        assert!(message(&[[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 0.0]]).contains("3 distinct"));
        assert!(message(&[[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]]).contains("crosses itself"));
        assert!(!message(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0], [3.0, 3.0]]).is_empty());
        assert_eq!(message(&[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]), "");
    }

    #[test]
    fn direction_start_and_repeats_do_not_matter() {
        let round = [[0.0, 0.0], [2.0, 0.5], [3.0, 2.0], [0.0, 3.0], [-1.0, 1.0]];
        let mut reversed = round;
        reversed.reverse();
        let repeated = [round[2], round[3], round[3], round[4], round[0], round[1], round[2]];
        assert_eq!(cleaned(&round, 1.0), cleaned(&reversed, 1.0));
        assert_eq!(cleaned(&round, 1.0), cleaned(&repeated, 1.0));
        let farthest = cleaned(&round, 0.5).iter().map(|p| p.norm()).fold(0.0, f64::max);
        assert!((farthest - 0.5).abs() < 1e-15);
    }
}
