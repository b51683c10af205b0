//! Key points of a traced outline, few and error-bounded: the paper lets a user click them. From the sharp places (or eight
//! even ones) on, the outline point farthest from each span of the spline becomes a key, until none lies beyond the bound.

use crate::base::vector::DVec2;
use crate::leaf::spline::{Spline, turning};

/// Turning angle of the first keys, radians.
const SHARP: f64 = 50.0 * std::f64::consts::PI / 180.0;
const ROUNDS: u32 = 40;
/// Samples of a span: one for each this many outline points, within limits.
const STRIDE: usize = 3;

/// Numbers of the outline points that are keys, in order.
pub fn chosen(outline: &[DVec2], tolerance: f64, corner: f64) -> Vec<usize> {
    let mut keys = first_keys(outline, tolerance);
    for _ in 0..ROUNDS {
        let spline = spline(outline, &keys, corner);
        let worst: Vec<usize> = (0..keys.len())
            .filter_map(|span| farthest(outline, &keys, &spline, span))
            .filter(|&(_, distance)| distance > tolerance * 0.98)
            .map(|(point, _)| point)
            .collect();
        if worst.is_empty() {
            break;
        }
        keys.extend(worst);
        keys.sort_unstable();
        keys.dedup();
    }
    keys
}

/// The spline through some of an outline's points.
pub fn spline(outline: &[DVec2], keys: &[usize], corner: f64) -> Spline {
    let points: Vec<DVec2> = keys.iter().map(|&i| outline[i]).collect();
    Spline::through(&points, corner)
}

fn first_keys(outline: &[DVec2], tolerance: f64) -> Vec<usize> {
    let count = outline.len();
    let step = (outline[1] - outline[0]).norm().max(0.3);
    let reach = (((6.0 + 2.0 * tolerance) / step.max(0.7)) as usize).clamp(1, count / 8 + 1);
    let turn = |i: usize| turning(outline[(i + count - reach) % count], outline[i], outline[(i + reach) % count]);
    let mut sharp: Vec<(f64, usize)> = (0..count).map(|i| (turn(i), i)).filter(|s| s.0 > SHARP).collect();
    sharp.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut keys: Vec<usize> = Vec::new();
    for (_, i) in sharp {
        let gap = |j: usize| i.abs_diff(j).min(count - i.abs_diff(j));
        if keys.iter().all(|&j| gap(j) > reach) {
            keys.push(i);
        }
    }
    if keys.len() < 6 {
        keys.extend((0..8).map(|i| i * count / 8));
    }
    keys.sort_unstable();
    keys.dedup();
    keys
}

/// The outline point between two keys that lies farthest from their span, and how far.
fn farthest(outline: &[DVec2], keys: &[usize], spline: &Spline, span: usize) -> Option<(usize, f64)> {
    let count = outline.len();
    let start = keys[span];
    let length = (keys[(span + 1) % keys.len()] + count - start - 1) % count + 1;
    let samples = (length / STRIDE).clamp(6, 400);
    let line: Vec<DVec2> = (0..=samples).map(|i| spline.at(span, i as f64 / samples as f64)).collect();
    let distance = |p: DVec2| {
        line.windows(2).map(|w| crate::leaf::polygon::segment_distance(p, w[0], w[1])).fold(f64::INFINITY, f64::min)
    };
    (1..length)
        .map(|i| (start + i) % count)
        .map(|i| (i, distance(outline[i])))
        .max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::maths::{sin, sincos};
    use crate::leaf::polygon;

    #[test]
    fn a_wavy_outline_is_met_within_the_bound() {
        let point = |i: u32| {
            let angle = std::f64::consts::TAU * f64::from(i) / 2000.0;
            let (sine, cosine) = sincos(angle);
            DVec2::new(cosine, sine) * (200.0 + 40.0 * sin(5.0 * angle) + 6.0 * sin(31.0 * angle))
        };
        let outline: Vec<DVec2> = (0..2000).map(point).collect();
        for tolerance in [1.0, 2.0, 4.0] {
            let keys = chosen(&outline, tolerance, 1.2);
            let line = spline(&outline, &keys, 1.2).polyline(24);
            let reached = polygon::hausdorff(&outline, &line);
            assert!(reached <= tolerance * 1.02, "{reached} for {tolerance} with {} keys", keys.len());
            assert!(keys.len() < 400);
        }
    }
}
