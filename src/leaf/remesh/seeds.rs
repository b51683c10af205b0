//! The first inner vertices: points of a hexagonal lattice, clear of the rim.

use crate::base::maths::{atan2, pow, sincos};
use crate::base::vector::DVec2;
use crate::leaf::polygon;
use crate::leaf::remesh::sizing::Sizing;

/// Seeds keep this share of the pitch away from the rim.
const CLEARANCE: f64 = 0.62;
/// How often the pitch is changed for the wanted number.
const TRIALS: u32 = 10;
/// Where a lattice point lies, in pitches and row heights: the next is taken if the number is off by a share of more than
/// one in `CLOSE`.
const ORIGINS: [[f64; 2]; 4] = [[0.0, 0.0], [0.5, 0.0], [0.25, 0.5], [0.75, 0.5]];
const CLOSE: usize = 50;
/// Pitches between that of an even mesh and the finest of a sizing.
const SHELLS: u32 = 4;

/// About `wanted` lattice points inside the loops, one row of the lattice turned by `angle` from +x.
pub fn lattice(loops: &[Vec<DVec2>], (spacing, sizing): (f64, Sizing), wanted: usize, angle: f64) -> Vec<DVec2> {
    if wanted == 0 {
        return Vec::new();
    }
    let (sine, cosine) = sincos(angle);
    let turned = |p: &DVec2| DVec2::new(cosine * p.x + sine * p.y, cosine * p.y - sine * p.x);
    let loops: Vec<Vec<DVec2>> = loops.iter().map(|points| points.iter().map(turned).collect()).collect();
    let miss = |points: &[DVec2]| points.len().abs_diff(wanted);
    let mut best = pitched(&loops, (spacing, sizing), wanted, ORIGINS[0]);
    for origin in &ORIGINS[1..] {
        if miss(&best) * CLOSE > wanted {
            let trial = pitched(&loops, (spacing, sizing), wanted, *origin);
            best = if miss(&trial) < miss(&best) { trial } else { best };
        }
    }
    best.iter().map(|p| DVec2::new(cosine * p.x - sine * p.y, cosine * p.y + sine * p.x)).collect()
}

/// The lattice whose pitch gives the number nearest to `wanted`.
fn pitched(loops: &[Vec<DVec2>], (spacing, sizing): (f64, Sizing), wanted: usize, origin: [f64; 2]) -> Vec<DVec2> {
    let miss = |points: &[DVec2]| points.len().abs_diff(wanted);
    let (mut pitch, mut best) = (spacing, shells(loops, (spacing, sizing), origin));
    for _ in 0..TRIALS {
        let ratio = (best.len() as f64 + 1.0) / (wanted as f64 + 1.0);
        let next = (pitch * ratio.sqrt()).clamp(0.6 * spacing, 1.6 * spacing);
        let trial = shells(loops, (next, sizing), origin);
        if miss(&trial) >= miss(&best) {
            break;
        }
        (pitch, best) = (next, trial);
    }
    best
}

/// Lattice points, in each shell of a sizing those of a lattice of its own pitch.
fn shells(loops: &[Vec<DVec2>], (pitch, sizing): (f64, Sizing), origin: [f64; 2]) -> Vec<DVec2> {
    if sizing.is_even() {
        return rows(loops, pitch, origin);
    }
    let step = pow(sizing.finest, 1.0 / f64::from(SHELLS));
    let shell = |k: u32| {
        let share = pow(step, f64::from(k));
        let bounds = [share * step.sqrt(), share / step.sqrt()];
        let mut points = rows(loops, pitch * share, origin);
        points.retain(|&p| sizing.at(p) >= bounds[0] && sizing.at(p) < bounds[1]);
        points
    };
    (0..=SHELLS).flat_map(shell).collect()
}

/// The direction of rows with which most of the rim's length runs along rows: the mean heading of its sides, where headings
/// that differ by 60 degrees are the same.
pub fn heading(loops: &[Vec<DVec2>]) -> f64 {
    let sides = loops.iter().flat_map(|points| polygon::sides(points));
    // A side's heading times six: the sixth power of the unit complex number.
    let sextuple = sides.map(|(a, b)| {
        let length = (b - a).norm();
        let along = (b - a).try_normalize(0.0).unwrap_or_default();
        let times = |p: DVec2, q: DVec2| DVec2::new(p.x * q.x - p.y * q.y, p.x * q.y + p.y * q.x);
        let cube = times(times(along, along), along);
        times(cube, cube) * length
    });
    let sum: DVec2 = sextuple.sum();
    // A round rim has no heading but rounding errors.
    let is_round = sum.norm() < 1e-6 * loops.iter().map(|points| polygon::perimeter(points)).sum::<f64>();
    if is_round { 0.0 } else { atan2(sum.y, sum.x) / 6.0 }
}

/// All lattice points inside the loops that are clear of them, row by row; the lattice has a point at `origin`, in pitches and
/// row heights.
fn rows(loops: &[Vec<DVec2>], pitch: f64, [right, up]: [f64; 2]) -> Vec<DVec2> {
    let rise = pitch * 0.75f64.sqrt();
    let sides: Vec<(DVec2, DVec2)> = loops.iter().flat_map(|points| polygon::sides(points)).collect();
    let low = sides.iter().map(|side| side.0.y).fold(f64::INFINITY, f64::min);
    let high = sides.iter().map(|side| side.0.y).fold(f64::NEG_INFINITY, f64::max);
    let first = (low / rise).floor() as i64 - 1;
    let count = ((high / rise).ceil() as i64 - first + 1).max(0) as usize;
    // For each row, where it passes the rim, and where it is too near to it.
    let (mut passes, mut near) = (vec![Vec::new(); count], vec![Vec::new(); count]);
    let reach = CLEARANCE * pitch;
    for &(a, b) in &sides {
        let (bottom, top) = (a.y.min(b.y) - reach, a.y.max(b.y) + reach);
        let from = (((bottom / rise).floor() as i64 - 1 - first).max(0) as usize).min(count);
        let to = (((top / rise).ceil() as i64 - first).max(-1) + 1) as usize;
        for row in from..to.min(count) {
            let y = ((first + row as i64) as f64 + up) * rise;
            if (a.y > y) != (b.y > y) {
                passes[row].push(a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y));
            }
            near[row].extend(overlap(a, b, y, reach));
        }
    }
    let mut points = Vec::new();
    for row in 0..count {
        passes[row].sort_by(f64::total_cmp);
        near[row].sort_by(|a, b| a.0.total_cmp(&b.0));
        let number = first + row as i64;
        let shift = right + if number.rem_euclid(2) == 1 { 0.5 } else { 0.0 };
        for pair in passes[row].chunks_exact(2) {
            let columns = (pair[0] / pitch - shift).ceil() as i64..=(pair[1] / pitch - shift).floor() as i64;
            let places = columns.map(|column| (column as f64 + shift) * pitch);
            let is_clear = |x: &f64| !near[row].iter().any(|&(start, end)| *x > start && *x < end);
            points.extend(places.filter(is_clear).map(|x| DVec2::new(x, (number as f64 + up) * rise)));
        }
    }
    points
}

/// Where a row at height `y` is nearer than `reach` to a segment.
fn overlap(a: DVec2, b: DVec2, y: f64, reach: f64) -> Option<(f64, f64)> {
    let round = |p: DVec2| {
        let half = reach * reach - (y - p.y) * (y - p.y);
        (half > 0.0).then(|| (p.x - half.sqrt(), p.x + half.sqrt()))
    };
    let (side, length) = (b - a, (b - a).norm());
    // The row's points that project onto the segment and are near its line.
    let strip = (length > 0.0 && side.y != 0.0).then(|| {
        let along = side / length;
        let cross = a.x + (y - a.y) * side.x / side.y;
        let wide = reach / along.y.abs();
        let (mut start, mut end) = (cross - wide, cross + wide);
        if along.x != 0.0 {
            let from = a.x - (y - a.y) * along.y / along.x;
            let ends = (from, from + length / along.x);
            (start, end) = (start.max(ends.0.min(ends.1)), end.min(ends.0.max(ends.1)));
        }
        (start, end)
    });
    let level = (side.y == 0.0 && (y - a.y).abs() < reach).then(|| (a.x.min(b.x), a.x.max(b.x)));
    let strip = strip.filter(|s| s.0 < s.1 && (side.x != 0.0 || (y - a.y) * (y - b.y) <= 0.0));
    let parts = [round(a), round(b), strip, level];
    let parts = parts.into_iter().flatten();
    parts.fold(None, |hull, part| Some(hull.map_or(part, |h: (f64, f64)| (h.0.min(part.0), h.1.max(part.1)))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_are_those_of_the_plain_search() {
        let notched = [(0.0, 0.0), (4.0, 0.2), (4.0, 3.0), (2.0, 0.7), (0.3, 3.0)].map(|(x, y)| DVec2::new(x, y));
        let hole = [(0.8, 0.5), (0.8, 0.9), (1.2, 0.9), (1.2, 0.5)].map(|(x, y)| DVec2::new(x, y));
        let pitch = 0.17;
        let found = rows(&[notched.to_vec(), hole.to_vec()], pitch, [0.0, 0.0]);
        let mut wanted = Vec::new();
        for row in -2..30i32 {
            for column in -2..40i32 {
                let shift = if row.rem_euclid(2) == 1 { 0.5 } else { 0.0 };
                let p = DVec2::new((f64::from(column) + shift) * pitch, f64::from(row) * pitch * 0.75f64.sqrt());
                let far = |points: &[DVec2]| polygon::distance(points, p) > CLEARANCE * pitch;
                if polygon::contains(&notched, p) && !polygon::contains(&hole, p) && far(&notched) && far(&hole) {
                    wanted.push(p);
                }
            }
        }
        assert_eq!(found.len(), wanted.len());
        assert!(found.iter().zip(&wanted).all(|(a, b)| (a - b).norm() < 1e-12));
    }

    #[test]
    fn about_as_many_as_wanted() {
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec2::new(x, y));
        for wanted in [1, 20, 300] {
            let spacing = (1.0 / 0.75f64.sqrt() / wanted as f64).sqrt();
            let seeds = lattice(&[square.to_vec()], (spacing, Sizing::EVEN), wanted, 0.3);
            assert!(seeds.len().abs_diff(wanted) as f64 <= 2.0 + 0.03 * wanted as f64, "{} of {wanted}", seeds.len());
        }
    }
}
