//! Key points of a traced outline, few and error-bounded: the paper lets a user click them. From the sharp places (or eight
//! even ones) on, the outline point farthest from each span of the spline becomes a key, until outline and spline lie within
//! the bound of each other. Then every key is tried without, and left out where the bound still holds.

use crate::base::vector::DVec2;
use crate::leaf::polygon;
use crate::leaf::spline::{Spline, turning};

/// Turning angle of the first keys, radians.
const SHARP: f64 = 50.0 * std::f64::consts::PI / 180.0;
const ROUNDS: u32 = 40;
/// Samples of a span: one for each this many outline points, within limits.
const STRIDE: usize = 3;
const MOST_SAMPLES: usize = 400;
/// Least samples of a span while keys are chosen, and when all are there: a short curve may go astray between few.
const SAMPLES: usize = 6;
const FINE_SAMPLES: usize = 12;
/// Keys are set until this share of the bound is held, since the distances are sampled.
const HELD: f64 = 0.98;
/// Spans on either side of a key that move when it is left out: its influence falls to a quarter from span to span.
const MOVED: usize = 4;
/// Passes of leaving out.
const PASSES: u32 = 2;

/// Numbers of the outline points that are keys, in order.
pub fn chosen(outline: &[DVec2], tolerance: f64, corner: f64) -> Vec<usize> {
    let bound = tolerance * HELD;
    let mut keys = first_keys(outline, tolerance);
    grow(outline, &mut keys, (bound, SAMPLES), corner);
    for _ in 0..PASSES {
        let thinned = thinned(outline, &keys, bound, corner);
        let mut checked = thinned.clone();
        grow(outline, &mut checked, (bound, SAMPLES), corner);
        if checked.len() >= keys.len() {
            break;
        }
        keys = checked;
    }
    grow(outline, &mut keys, (tolerance, FINE_SAMPLES), corner);
    keys
}

/// Sets keys until the bound is held both ways at so many samples of a span, or the rounds are over.
fn grow(outline: &[DVec2], keys: &mut Vec<usize>, bound: (f64, usize), corner: f64) {
    for _ in 0..ROUNDS {
        let spline = spline(outline, keys, corner);
        let wanted: Vec<usize> =
            (0..keys.len()).filter_map(|span| wanted(outline, keys, &spline, span, bound)).collect();
        if wanted.is_empty() {
            break;
        }
        keys.extend(wanted);
        keys.sort_unstable();
        keys.dedup();
    }
}

/// The outline point that a span needs as a key: the one farthest from it, else, where the curve strays from the outline,
/// the one in the middle of the span.
fn wanted(
    outline: &[DVec2],
    keys: &[usize],
    spline: &Spline,
    span: usize,
    (bound, least): (f64, usize),
) -> Option<usize> {
    let (point, distance) = farthest(outline, keys, spline, (span, least))?;
    if distance > bound {
        return Some(point);
    }
    let middle = (keys[span] + length(outline, keys, span) / 2) % outline.len();
    (straying(outline, keys, spline, (span, least)) > bound).then_some(middle)
}

/// The keys without those that the bound does not need, tried one after the other.
fn thinned(outline: &[DVec2], keys: &[usize], bound: f64, corner: f64) -> Vec<usize> {
    let mut kept = keys.to_vec();
    let mut rank = 0;
    while rank < kept.len() && kept.len() > 8 {
        let key = kept.remove(rank);
        if !holds(outline, &kept, rank, bound, corner) {
            kept.insert(rank, key);
        }
        rank += 1;
    }
    kept
}

/// Whether the bound is held near the place where the key of this rank was left out.
fn holds(outline: &[DVec2], keys: &[usize], rank: usize, bound: f64, corner: f64) -> bool {
    let count = keys.len();
    let (keys, first) = stretch(outline, keys, rank, corner);
    let spline = spline(outline, &keys, corner);
    let near = (0..2 * MOVED).map(|i| (rank + count * MOVED + i - MOVED) % count);
    // the span across the gap is the likeliest to fail
    let mut spans = std::iter::once((rank + count - 1) % count).chain(near);
    spans.all(|span| is_held(outline, &keys, &spline, (span + count - first) % count, bound))
}

/// The keys that have to do with the spans near a rank: from the last corner before them to the first after them, where the
/// spline falls apart, and one more on either side, which makes those two the corners that they are. And the rank of the
/// first of them. All keys where there are no corners.
fn stretch(outline: &[DVec2], keys: &[usize], rank: usize, corner: f64) -> (Vec<usize>, usize) {
    let count = keys.len();
    let point = |i: usize| outline[keys[i % count]];
    let is_corner = |i: usize| turning(point(i + count - 1), point(i), point(i + 1)) > corner;
    // the spans near a rank begin with the keys from MOVED before to MOVED - 1 after it
    let before = (MOVED..count).find(|back| is_corner(rank + count - back));
    let after = (MOVED..count).find(|ahead| is_corner(rank + ahead));
    match before.zip(after) {
        Some((before, after)) if before + after + 3 < count => {
            let first = (rank + count - before - 1) % count;
            ((0..before + after + 3).map(|i| keys[(first + i) % count]).collect(), first)
        }
        _ => (keys.to_vec(), 0),
    }
}

/// Whether a span and its stretch of the outline lie within the bound of each other.
fn is_held(outline: &[DVec2], keys: &[usize], spline: &Spline, span: usize, bound: f64) -> bool {
    let length = length(outline, keys, span);
    let line = samples(spline, span, length, SAMPLES);
    let is_near = |i: usize| from_line(&line, outline[(keys[span] + i) % outline.len()]) <= bound;
    length < 2 || ((1..length).all(is_near) && straying(outline, keys, spline, (span, SAMPLES)) <= bound)
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

/// Points of a span's curve, ends included, about one for every `STRIDE` outline points and no fewer than `least`.
fn samples(spline: &Spline, span: usize, length: usize, least: usize) -> Vec<DVec2> {
    let count = (length / STRIDE).clamp(least, MOST_SAMPLES);
    (0..=count).map(|i| spline.at(span, i as f64 / count as f64)).collect()
}

fn length(outline: &[DVec2], keys: &[usize], span: usize) -> usize {
    (keys[(span + 1) % keys.len()] + outline.len() - keys[span] - 1) % outline.len() + 1
}

fn from_line(line: &[DVec2], p: DVec2) -> f64 {
    line.windows(2).map(|w| polygon::squared_segment_distance(p, w[0], w[1])).fold(f64::INFINITY, f64::min).sqrt()
}

/// The outline point between two keys that lies farthest from their span, and how far.
fn farthest(outline: &[DVec2], keys: &[usize], spline: &Spline, (span, least): (usize, usize)) -> Option<(usize, f64)> {
    let length = length(outline, keys, span);
    let line = samples(spline, span, length, least);
    (1..length)
        .map(|i| (keys[span] + i) % outline.len())
        .map(|i| (i, from_line(&line, outline[i])))
        .max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))
}

/// The farthest that a span's curve goes from its stretch of the outline.
fn straying(outline: &[DVec2], keys: &[usize], spline: &Spline, (span, least): (usize, usize)) -> f64 {
    let length = length(outline, keys, span);
    let stretch: Vec<DVec2> = (0..=length).map(|i| outline[(keys[span] + i) % outline.len()]).collect();
    samples(spline, span, 2 * length, least).into_iter().map(|p| from_line(&stretch, p)).fold(0.0, f64::max)
}

/// Distance between outline and spline, both ways, each span against its own stretch of the outline: never less than the
/// Hausdorff distance at these samples.
pub fn distance(outline: &[DVec2], keys: &[usize], spline: &Spline) -> f64 {
    let there = |span: usize| farthest(outline, keys, spline, (span, SAMPLES)).map_or(0.0, |worst| worst.1);
    (0..keys.len()).map(|span| there(span).max(straying(outline, keys, spline, (span, SAMPLES)))).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::maths::{sin, sincos};
    use proptest::prelude::*;

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
            let spline = spline(&outline, &keys, 1.2);
            let reached = polygon::hausdorff(&outline, &spline.polyline(24));
            assert!(distance(&outline, &keys, &spline) >= reached * 0.99);
            assert!(reached <= tolerance * 1.02, "{reached} for {tolerance} with {} keys", keys.len());
            assert!(keys.len() < 400);
        }
    }

    /// A star of waves (how many, how high, turned by) and spikes about a radius, points a pixel or less apart at its mean.
    fn star(waves: &[(u32, f64, f64)], spikes: u32, radius: f64) -> Vec<DVec2> {
        let count = (radius * 7.0) as u32;
        let point = |i: u32| {
            let angle = std::f64::consts::TAU * f64::from(i) / f64::from(count);
            let wave = |&(n, size, phase): &(u32, f64, f64)| size * sin(f64::from(n) * angle + phase);
            let spike = sin(f64::from(spikes) * angle / 2.0).abs();
            let (sine, cosine) = sincos(angle);
            DVec2::new(cosine, sine) * (radius * (1.0 + 0.3 * spike + waves.iter().map(wave).sum::<f64>()))
        };
        (0..count).map(point).collect()
    }

    /// How far outline and spline are apart, as it is judged while keys are chosen and between points twelve a span.
    fn reached(outline: &[DVec2], tolerance: f64) -> [f64; 2] {
        let keys = chosen(outline, tolerance, 1.134);
        let spline = spline(outline, &keys, 1.134);
        [distance(outline, &keys, &spline), polygon::hausdorff(outline, &spline.polyline(12))]
    }

    #[test]
    fn short_spans_are_looked_at_closely_enough() {
        // Spans of a few points, whose curve went astray between six samples.
        let waves = [
            (11, 0.018_889_984_532_113_005, 4.201_656_970_386_344),
            (22, 0.118_806_472_235_510_08, 1.509_171_216_859_432_5),
            (38, 0.045_069_882_910_091_376, 4.176_478_633_949_644),
        ];
        let [judged, reached] = reached(&star(&waves, 2, 87.649_842_155_096_61), 0.5);
        assert!(judged <= 0.5 && reached <= 0.51, "{judged} {reached}");
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 16, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn the_bound_is_held_on_any_star(
            waves in prop::collection::vec((2u32..40, 0.0..0.12f64, 0.0..6.3f64), 1..6),
            spikes in 0u32..12,
            radius in 40.0..160.0f64,
        ) {
            let outline = star(&waves, spikes, radius);
            for tolerance in [0.5, 1.0, 2.0, 4.0] {
                let [judged, reached] = reached(&outline, tolerance);
                prop_assert!(judged <= tolerance, "{} for {}", judged, tolerance);
                prop_assert!(reached <= tolerance * 1.02, "{} for {}", reached, tolerance);
            }
        }
    }
}
