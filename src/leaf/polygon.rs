//! Closed polygons in the plane: area, inside, distance, crossing. Points are corners in order; the last joins the first.

use crate::base::vector::DVec2;

/// Twice the signed area, positive when counter-clockwise.
pub fn doubled_area(points: &[DVec2]) -> f64 {
    sides(points).map(|(a, b)| a.perp(&b)).sum()
}

/// Length of the closed line.
pub fn perimeter(points: &[DVec2]) -> f64 {
    sides(points).map(|(a, b)| (b - a).norm()).sum()
}

/// The sides in order.
pub fn sides(points: &[DVec2]) -> impl Iterator<Item = (DVec2, DVec2)> + '_ {
    (0..points.len()).map(|i| (points[i], points[(i + 1) % points.len()]))
}

/// Whether a point lies inside (even-odd rule; on the rim either answer).
pub fn contains(points: &[DVec2], p: DVec2) -> bool {
    let crosses =
        |(a, b): &(DVec2, DVec2)| (a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y);
    sides(points).filter(crosses).count() % 2 == 1
}

/// Distance of a point from a segment.
pub fn segment_distance(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    squared_segment_distance(p, a, b).sqrt()
}

fn squared_segment_distance(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let side = b - a;
    let length = side.norm_squared();
    let t = if length > 0.0 { ((p - a).dot(&side) / length).clamp(0.0, 1.0) } else { 0.0 };
    (a + side * t - p).norm_squared()
}

/// Distance of a point from the closed line.
pub fn distance(points: &[DVec2], p: DVec2) -> f64 {
    sides(points).map(|(a, b)| squared_segment_distance(p, a, b)).fold(f64::INFINITY, f64::min).sqrt()
}

/// Largest distance of the first line's corners and side middles from the second line.
pub fn one_sided_hausdorff(from: &[DVec2], to: &[DVec2]) -> f64 {
    sides(from)
        .flat_map(|(a, b)| [a, (a * 3.0 + b) / 4.0, (a + b) / 2.0, (a + b * 3.0) / 4.0])
        .map(|p| distance(to, p))
        .fold(0.0, f64::max)
}

/// Hausdorff distance of two closed lines, sampled at their corners and three points of each side.
pub fn hausdorff(a: &[DVec2], b: &[DVec2]) -> f64 {
    one_sided_hausdorff(a, b).max(one_sided_hausdorff(b, a))
}

fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp(&(c - a))
}

fn cross(a: DVec2, b: DVec2, c: DVec2, d: DVec2) -> bool {
    let (abc, abd, cda, cdb) = (turn(a, b, c), turn(a, b, d), turn(c, d, a), turn(c, d, b));
    if abc == 0.0 && abd == 0.0 {
        let along = b - a;
        let [pa, pb, pc, pd] = [a, b, c, d].map(|p| p.dot(&along));
        return pa.min(pb) <= pc.max(pd) && pc.min(pd) <= pa.max(pb);
    }
    abc * abd <= 0.0 && cda * cdb <= 0.0
}

/// The first pair of sides (by number) that touch or cross without being neighbours. A sweep over x.
pub fn crossing(points: &[DVec2]) -> Option<(usize, usize)> {
    let count = points.len();
    let ends = |i: usize| (points[i], points[(i + 1) % count]);
    let low = |i: usize| ends(i).0.x.min(ends(i).1.x);
    let high = |i: usize| ends(i).0.x.max(ends(i).1.x);
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|&i, &j| low(i).total_cmp(&low(j)).then(i.cmp(&j)));
    let mut found: Option<(usize, usize)> = None;
    for (rank, &i) in order.iter().enumerate() {
        let (a, b) = ends(i);
        for &j in order[rank + 1..].iter().take_while(|&&j| low(j) <= high(i)) {
            let neighbours = (i + 1) % count == j || (j + 1) % count == i;
            let (c, d) = ends(j);
            if !neighbours && cross(a, b, c, d) {
                let pair = (i.min(j), i.max(j));
                found = Some(found.map_or(pair, |best| best.min(pair)));
            }
        }
    }
    found
}

/// The closed line's points no farther apart than `spacing`, its corners included.
pub fn densified(points: &[DVec2], spacing: f64) -> Vec<DVec2> {
    let mut dense = Vec::new();
    for (a, b) in sides(points) {
        let count = ((b - a).norm() / spacing).ceil().max(1.0) as usize;
        dense.extend((0..count).map(|i| a + (b - a) * (i as f64 / count as f64)));
    }
    dense
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Vec<DVec2> {
        [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)].map(|(x, y)| DVec2::new(x, y)).to_vec()
    }

    #[test]
    fn a_square_has_its_figures() {
        let square = square();
        assert_eq!(doubled_area(&square), 8.0);
        assert_eq!(perimeter(&square), 8.0);
        assert!(contains(&square, DVec2::new(1.0, 1.5)) && !contains(&square, DVec2::new(2.5, 1.0)));
        assert_eq!(distance(&square, DVec2::new(3.0, 3.0)), 2f64.sqrt());
        assert_eq!(crossing(&square), None);
        assert_eq!(densified(&square, 0.5).len(), 16);
    }

    #[test]
    fn crossing_and_touching_sides_are_found() {
        let mut bow_tie = square();
        bow_tie.swap(2, 3);
        assert_eq!(crossing(&bow_tie), Some((1, 3)));
        let mut touching = square();
        touching.insert(3, DVec2::new(1.0, 0.0));
        assert_eq!(crossing(&touching), Some((0, 2)));
    }

    #[test]
    fn hausdorff_of_shifted_squares_is_the_shift() {
        let shifted: Vec<DVec2> = square().iter().map(|p| p + DVec2::new(0.25, 0.0)).collect();
        assert_eq!(hausdorff(&square(), &shifted), 0.25);
    }
}
