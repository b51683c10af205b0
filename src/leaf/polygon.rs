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

/// Squared distance of a point from a segment.
pub fn squared_segment_distance(p: DVec2, a: DVec2, b: DVec2) -> f64 {
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

/// The first pair of sides (by number) that touch or cross without being neighbours.
pub fn crossing(points: &[DVec2]) -> Option<(usize, usize)> {
    let pairs = crossings(std::slice::from_ref(&points.to_vec()));
    pairs.into_iter().map(|[(_, i), (_, j)]| (i.min(j), i.max(j))).min()
}

/// All pairs of sides (loop, number) that touch or cross without being neighbours in one loop. A sweep over x.
pub fn crossings(loops: &[Vec<DVec2>]) -> Vec<[(usize, usize); 2]> {
    let numbered = |(k, points): (usize, &Vec<DVec2>)| (0..points.len()).map(|i| (k, i)).collect::<Vec<_>>();
    let ends = |(k, i): (usize, usize)| (loops[k][i], loops[k][(i + 1) % loops[k].len()]);
    let low = |side: (usize, usize)| ends(side).0.x.min(ends(side).1.x);
    let mut order: Vec<(f64, (usize, usize))> =
        loops.iter().enumerate().flat_map(numbered).map(|side| (low(side), side)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let are_neighbours = |(k, i): (usize, usize), (m, j): (usize, usize)| {
        let count = loops[k].len();
        k == m && ((i + 1) % count == j || (j + 1) % count == i)
    };
    let mut found = Vec::new();
    for (rank, &(_, one)) in order.iter().enumerate() {
        let (a, b) = ends(one);
        let (lower, upper) = (a.y.min(b.y), a.y.max(b.y));
        for &(_, other) in order[rank + 1..].iter().take_while(|side| side.0 <= a.x.max(b.x)) {
            let (c, d) = ends(other);
            let overlap = c.y.min(d.y) <= upper && c.y.max(d.y) >= lower;
            if overlap && !are_neighbours(one, other) && cross(a, b, c, d) {
                found.push([one, other]);
            }
        }
    }
    found
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
    }

    #[test]
    fn crossing_and_touching_sides_are_found() {
        let mut bow_tie = square();
        bow_tie.swap(2, 3);
        assert_eq!(crossing(&bow_tie), Some((1, 3)));
        let mut touching = square();
        touching.insert(3, DVec2::new(1.0, 0.0));
        assert_eq!(crossing(&touching), Some((0, 2)));
        let shifted: Vec<DVec2> = square().iter().map(|p| p + DVec2::new(1.0, 1.0)).collect();
        assert_eq!(crossings(&[square(), shifted]).len(), 2);
    }

    #[test]
    fn hausdorff_of_shifted_squares_is_the_shift() {
        let shifted: Vec<DVec2> = square().iter().map(|p| p + DVec2::new(0.25, 0.0)).collect();
        assert_eq!(hausdorff(&square(), &shifted), 0.25);
    }
}
