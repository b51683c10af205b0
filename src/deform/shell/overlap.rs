//! Where a sheet passes through itself: edges that pierce triangles they do not touch. Candidates come from a grid of cells.

use crate::base::vector::DVec3;

/// Most cells along an axis; keeps their numbers whole for a sheet that has flown apart.
const MOST_CELLS: f64 = 1e6;

/// A cell and a triangle whose bounding box meets it.
type Entry = ([i32; 3], u32);

/// Number of (edge, triangle) pairs that pierce. Positions must be finite.
pub fn piercings(positions: &[DVec3], triangles: &[[u32; 3]], edges: &[[u32; 2]]) -> u64 {
    let length = |e: &[u32; 2]| (positions[e[0] as usize] - positions[e[1] as usize]).norm();
    let mean = edges.iter().map(length).sum::<f64>() / edges.len().max(1) as f64;
    let size = mean * 1.5;
    if !(size > 0.0 && size < f64::INFINITY) {
        return 0;
    }
    let mut entries: Vec<Entry> = Vec::new();
    for (number, triangle) in triangles.iter().enumerate() {
        entries.extend(cells(&triangle.map(|v| positions[v as usize]), size).map(|cell| (cell, number as u32)));
    }
    entries.sort_unstable();
    let mut near = Vec::new();
    let mut count = 0;
    for edge in edges {
        let ends = edge.map(|v| positions[v as usize]);
        near.clear();
        for cell in cells(&ends, size) {
            let start = entries.partition_point(|entry| entry.0 < cell);
            near.extend(entries[start..].iter().take_while(|entry| entry.0 == cell).map(|entry| entry.1));
        }
        near.sort_unstable();
        near.dedup();
        let pierced = |&&number: &&u32| {
            let triangle = triangles[number as usize];
            !triangle.iter().any(|v| edge.contains(v)) && pierces(ends, triangle.map(|v| positions[v as usize]))
        };
        count += near.iter().filter(pierced).count() as u64;
    }
    count
}

/// The cells that the bounding box of some points meets.
fn cells(points: &[DVec3], size: f64) -> impl Iterator<Item = [i32; 3]> {
    let (low, high) = points.iter().fold((points[0], points[0]), |(low, high), p| (low.inf(p), high.sup(p)));
    let cell = |p: DVec3| [0, 1, 2].map(|k| (p[k] / size).floor().clamp(-MOST_CELLS, MOST_CELLS) as i32);
    let (low, high) = (cell(low), cell(high));
    (low[0]..=high[0])
        .flat_map(move |x| (low[1]..=high[1]).flat_map(move |y| (low[2]..=high[2]).map(move |z| [x, y, z])))
}

/// Whether a segment passes through the inside of a triangle: its ends lie on both sides of the plane, and all three edges pass
/// it on one side (signed volumes).
fn pierces([p, q]: [DVec3; 2], [a, b, c]: [DVec3; 3]) -> bool {
    let volume = |u: DVec3, v: DVec3, w: DVec3, x: DVec3| (v - u).cross(&(w - u)).dot(&(x - u));
    if volume(a, b, c, p) * volume(a, b, c, q) >= 0.0 {
        return false;
    }
    let [u, v, w] = [(a, b), (b, c), (c, a)].map(|(from, to)| volume(p, q, from, to));
    (u > 0.0 && v > 0.0 && w > 0.0) || (u < 0.0 && v < 0.0 && w < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(place: impl Fn(f64, f64) -> DVec3) -> (Vec<DVec3>, Vec<[u32; 3]>, Vec<[u32; 2]>) {
        let number = |x: u32, y: u32| y * 21 + x;
        let positions =
            (0..6).flat_map(|y| (0..21).map(move |x| (f64::from(x), f64::from(y)))).map(|(x, y)| place(x, y));
        let (mut triangles, mut edges) = (Vec::new(), Vec::new());
        for (x, y) in (0..5).flat_map(|y| (0..20).map(move |x| (x, y))) {
            let [a, b, c, d] = [number(x, y), number(x + 1, y), number(x + 1, y + 1), number(x, y + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
            edges.extend([[a, b], [b, c], [a, c]]);
        }
        (positions.collect(), triangles, edges)
    }

    fn rolled(radius: impl Fn(f64) -> f64) -> u64 {
        let (positions, triangles, edges) = grid(|x, y| {
            let (sine, cosine) = crate::base::maths::sincos(x * 0.45);
            DVec3::new(cosine, sine, 0.0) * radius(x) + DVec3::new(0.0, 0.0, y + 0.013 * x)
        });
        piercings(&positions, &triangles, &edges)
    }

    #[test]
    fn a_spiral_is_free_and_crossed_turns_are_not() {
        assert_eq!(rolled(|x| 2.0 - 0.05 * x), 0);
        // The second turn starts outside the first and ends inside.
        assert!(rolled(|x| if x < 14.0 { 2.0 } else { 2.3 - 0.15 * (x - 14.0) }) > 0);
    }

    #[test]
    fn the_inside_of_a_triangle_counts_and_a_near_miss_does_not() {
        let triangle = [DVec3::zeros(), DVec3::x(), DVec3::y()];
        let needle = |x: f64| [DVec3::new(x, 0.2, -1.0), DVec3::new(x, 0.2, 1.0)];
        assert!(pierces(needle(0.2), triangle) && !pierces(needle(0.9), triangle));
    }
}
