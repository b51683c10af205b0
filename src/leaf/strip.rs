//! The petiole of a scanned leaf as a strip of its own beside the blade's mesh: stalk and blade have nothing in common but
//! the joint, and triangles as thin as a stalk would spoil the blade's.

use crate::base::blade::Strip;
use crate::base::vector::DVec2;

/// The strip along a centre line with the width at each point; `None` with fewer than two distinct points. Pieces are as
/// long as the strip is wide there, so that its triangles are even.
pub fn strip(points: &[(DVec2, f64)]) -> Option<Strip> {
    let stations = stations(points);
    if stations.len() < 2 {
        return None;
    }
    let line: Vec<DVec2> = stations.iter().map(|station| station.0).collect();
    let last = line.len() - 1;
    let across = |i: usize| {
        let along = line[(i + 1).min(last)] - line[i.saturating_sub(1)];
        DVec2::new(-along.y, along.x).try_normalize(0.0).unwrap_or_else(DVec2::x)
    };
    let sides = |(i, &(centre, width)): (usize, &(DVec2, f64))| {
        let half = across(i) * (width * 0.5);
        [centre + half, centre - half]
    };
    let positions = stations.iter().enumerate().flat_map(sides).collect();
    // The line runs from left to right of the reader who looks along it: left, right, next left is counter-clockwise.
    let piece = |i: u32| [[2 * i, 2 * i + 1, 2 * i + 2], [2 * i + 2, 2 * i + 1, 2 * i + 3]];
    Some(Strip { positions, triangles: (0..last as u32).flat_map(piece).collect(), line })
}

/// Points along the line about a width apart, each with the width there.
fn stations(points: &[(DVec2, f64)]) -> Vec<(DVec2, f64)> {
    let mut stations: Vec<(DVec2, f64)> = points.first().copied().into_iter().collect();
    for pair in points.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        let length = (to.0 - from.0).norm();
        let mut walked = 0.0;
        while let Some(&(last, width)) = stations.last() {
            let step = width.max(length * 1e-3);
            let left = step - (from.0 + (to.0 - from.0) * (walked / length.max(1e-300)) - last).norm();
            if length <= 0.0 || walked + left.max(step * 1e-3) > length {
                break;
            }
            walked += left.max(step * 1e-3);
            let t = walked / length;
            stations.push((from.0 + (to.0 - from.0) * t, from.1 + (to.1 - from.1) * t));
        }
    }
    // The last piece reaches to the end: a short one is joined to the one before.
    if let (Some(&end), Some(&(last, width))) = (points.last(), stations.last()) {
        if stations.len() > 1 && (end.0 - last).norm() < 0.5 * width {
            stations.pop();
        }
        if stations.last().is_some_and(|station| (station.0 - end.0).norm() > 0.0) {
            stations.push(end);
        }
    }
    stations
}

/// Length of the centre line.
pub fn length(strip: &Strip) -> f64 {
    strip.line.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn doubled_area(strip: &Strip, triangle: [u32; 3]) -> f64 {
        let [a, b, c] = triangle.map(|v| strip.positions[v as usize]);
        (b - a).perp(&(c - a))
    }

    #[test]
    fn a_straight_stalk_has_its_length_and_area_and_even_triangles() {
        let points = [(DVec2::zeros(), 2.0), (DVec2::new(0.0, -7.0), 2.0), (DVec2::new(0.0, -30.0), 2.0)];
        let strip = strip(&points).unwrap();
        assert!((length(&strip) - 30.0).abs() < 1e-12);
        let areas: Vec<f64> = strip.triangles.iter().map(|&t| doubled_area(&strip, t) * 0.5).collect();
        assert!(areas.iter().all(|&area| area > 0.0));
        assert!((areas.iter().sum::<f64>() - 60.0).abs() < 1e-12);
        let sides = strip.line.windows(2).map(|pair| (pair[1] - pair[0]).norm());
        assert!(sides.fold(0.0, f64::max) < 2.6);
    }

    #[test]
    fn points_and_repeats_are_no_strip() {
        assert_eq!(strip(&[]), None);
        assert_eq!(strip(&[(DVec2::x(), 1.0), (DVec2::x(), 1.0)]), None);
        let repeated = [(DVec2::zeros(), 1.0), (DVec2::zeros(), 1.0), (DVec2::new(5.0, 0.0), 1.0)];
        let strip = strip(&repeated).unwrap();
        assert!(strip.triangles.iter().all(|&t| doubled_area(&strip, t) > 0.0));
    }
}
