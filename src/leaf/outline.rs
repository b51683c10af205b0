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
    let complaints = of_line("outline", outline, corner);
    let keys = distinct(outline);
    let is_flat = || keys.iter().map(|p| p.norm()).fold(0.0, f64::max) <= 1e-6 * extent(&keys);
    if complaints.is_empty() && is_flat() {
        return vec![Complaint::new("outline", "the outline has no length", "the joint of the petiole is the origin")];
    }
    complaints
}

/// What is wrong with the gaps of an outline that is sound.
pub fn complaints_of_holes(outline: &[[f64; 2]], holes: &[Vec<[f64; 2]>], corner: f64) -> Vec<Complaint> {
    let key = |number: usize| format!("holes.{number}");
    let mut complaints: Vec<Complaint> =
        holes.iter().enumerate().flat_map(|(number, hole)| of_line(&key(number), hole, corner)).collect();
    if !complaints.is_empty() {
        return complaints;
    }
    let drawn = |line: &[[f64; 2]]| Spline::through(&distinct(line), corner).polyline(CROSSING_SAMPLES);
    let rim = drawn(outline);
    let gaps: Vec<Vec<DVec2>> = holes.iter().map(|hole| drawn(hole)).collect();
    for (number, gap) in gaps.iter().enumerate() {
        let is_within = gap.iter().all(|&p| polygon::contains(&rim, p)) && !meets(gap, &rim);
        if !is_within {
            let what = "this gap does not lie within the outline";
            complaints.push(Complaint::new(key(number), what, "let every point of it lie inside the blade"));
        }
        let other = gaps[..number].iter().position(|other| meets(gap, other) || polygon::contains(other, gap[0]));
        if let Some(other) = other {
            let what = format!("this gap and gap {other} meet");
            complaints.push(Complaint::new(key(number), what, "make one gap of both, or move them apart"));
        }
    }
    complaints
}

/// Whether two closed lines touch or cross.
fn meets(a: &[DVec2], b: &[DVec2]) -> bool {
    !polygon::crossings(&[a.to_vec(), b.to_vec()]).is_empty()
}

fn of_line(key: &str, outline: &[[f64; 2]], corner: f64) -> Vec<Complaint> {
    let complaint = |message: String, help: &str| Complaint::new(key, message, help);
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
    Vec::new()
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
    fn gaps_lie_inside_and_apart() {
        let outline = [[0.0, 0.0], [20.0, 0.0], [20.0, 20.0], [0.0, 20.0]];
        let square = |x: f64, y: f64, side: f64| vec![[x, y], [x + side, y], [x + side, y + side], [x, y + side]];
        let told = |holes: &[Vec<[f64; 2]>]| -> Vec<(String, String)> {
            complaints_of_holes(&outline, holes, 1.1).into_iter().map(|one| (one.key, one.message)).collect()
        };
        assert!(told(&[square(3.0, 3.0, 4.0), square(12.0, 3.0, 4.0)]).is_empty());
        assert!(told(&[square(17.0, 3.0, 6.0)])[0].1.contains("does not lie within the outline"));
        assert!(told(&[square(40.0, 3.0, 6.0)])[0].1.contains("does not lie within the outline"));
        let crossing = told(&[square(3.0, 3.0, 8.0), square(9.0, 9.0, 6.0)]);
        assert_eq!(crossing[0], ("holes.1".to_owned(), "this gap and gap 0 meet".to_owned()));
        assert!(told(&[square(3.0, 3.0, 12.0), square(6.0, 6.0, 3.0)])[0].1.contains("gap 0 meet"));
        assert!(told(&[vec![[5.0, 5.0], [6.0, 6.0]]])[0].1.contains("3 distinct"));
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
