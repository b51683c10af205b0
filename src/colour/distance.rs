//! Exact distances on a grid of pixels: to the nearest pixel of a set, and which one that is.
//!
//! Felzenszwalb and Huttenlocher 2012, "Distance Transforms of Sampled Functions": lower envelopes of parabolas along the rows,
//! over what two sweeps, down and up, find in the columns.

/// Stands for "no pixel of the set here"; a distance whose square still is a finite f32 sum.
const FAR: f32 = 1e12;
/// No row.
const NONE: u32 = u32::MAX;

/// For each pixel of a square grid, the squared distance (pixels) to the nearest pixel of `set` and its number. Without any
/// pixel in the set, distances are at least 1e12 and the numbers mean nothing.
pub(super) fn nearest(set: &[bool], size: usize) -> (Vec<f32>, Vec<u32>) {
    let rows = columns(set, size);
    let mut squares = vec![FAR; set.len()];
    let mut sources: Vec<u32> = (0..set.len() as u32).collect();
    let mut envelope = Envelope::new(size);
    for (row, feet) in rows.chunks_exact(size.max(1)).enumerate() {
        let places = row * size..(row + 1) * size;
        envelope.transform(row, feet, &mut squares[places.clone()], &mut sources[places]);
    }
    (squares, sources)
}

/// For each pixel the row of the nearest pixel of the set in its column, the upper one of two as near; `NONE` in an empty column.
fn columns(set: &[bool], size: usize) -> Vec<u32> {
    let mut rows = vec![NONE; set.len()];
    let mut last = vec![NONE; size];
    for row in 0..size {
        let places = row * size..(row + 1) * size;
        for ((found, last), &is_set) in rows[places.clone()].iter_mut().zip(&mut last).zip(&set[places]) {
            *last = if is_set { row as u32 } else { *last };
            *found = *last;
        }
    }
    last.fill(NONE);
    for row in (0..size).rev() {
        let places = row * size..(row + 1) * size;
        for ((found, last), &is_set) in rows[places.clone()].iter_mut().zip(&mut last).zip(&set[places]) {
            *last = if is_set { row as u32 } else { *last };
            // Without one above, the difference wraps to far more than any row's number.
            let (above, below) = ((row as u32).wrapping_sub(*found), last.wrapping_sub(row as u32));
            *found = if *found == NONE || (*last != NONE && below < above) { *last } else { *found };
        }
    }
    rows
}

/// Working memory for one line: the parabolas of its lower envelope.
struct Envelope {
    /// Where they stand, and how high above the line.
    feet: Vec<(i32, i32)>,
    /// Where each takes over from the one before.
    starts: Vec<f32>,
}

impl Envelope {
    fn new(size: usize) -> Self {
        Self { feet: Vec::with_capacity(size), starts: Vec::with_capacity(size) }
    }

    /// The nearest pixels of a row whose columns have theirs in the rows `found`.
    fn transform(&mut self, row: usize, found: &[u32], squares: &mut [f32], sources: &mut [u32]) {
        self.build(row, found);
        if self.feet.is_empty() {
            return;
        }
        let mut part = 0;
        for (index, (square, source)) in squares.iter_mut().zip(sources).enumerate() {
            while part + 1 < self.feet.len() && self.starts[part + 1] < index as f32 {
                part += 1;
            }
            let (foot, height) = self.feet[part];
            let along = index as i32 - foot;
            *square = (along * along + height) as f32;
            *source = found[foot as usize] * found.len() as u32 + foot as u32;
        }
    }

    /// Makes the lower envelope.
    fn build(&mut self, row: usize, found: &[u32]) {
        self.feet.clear();
        self.starts.clear();
        for (index, _) in found.iter().enumerate().filter(|(_, found)| **found != NONE) {
            let up = row as i32 - found[index] as i32;
            let foot = (index as i32, up * up);
            let mut start = f32::NEG_INFINITY;
            while let (Some(&last), Some(&begun)) = (self.feet.last(), self.starts.last()) {
                start = meeting(last, foot);
                if self.feet.len() == 1 || start > begun {
                    break;
                }
                self.feet.pop();
                self.starts.pop();
            }
            self.feet.push(foot);
            self.starts.push(start);
        }
    }
}

/// Where the parabola `b` comes below `a`, which stands before it. Whole numbers below 2^26 up to the quotient.
fn meeting(a: (i32, i32), b: (i32, i32)) -> f32 {
    let value = |(foot, height): (i32, i32)| height + foot * foot;
    (value(b) - value(a)) as f32 / (2 * (b.0 - a.0)) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::hash_unit;

    #[test]
    fn distances_are_those_of_a_search_through_all_pixels() {
        let size = 24;
        for salt in 0..4 {
            let set: Vec<bool> = (0..size * size).map(|i| hash_unit(salt, i as u64) < 0.03).collect();
            let (squares, sources) = nearest(&set, size);
            for pixel in 0..size * size {
                let to = |other: usize| {
                    let (dx, dy) = ((pixel % size).abs_diff(other % size), (pixel / size).abs_diff(other / size));
                    (dx * dx + dy * dy) as f32
                };
                let expected = (0..set.len()).filter(|&other| set[other]).map(to).fold(f32::INFINITY, f32::min);
                assert_eq!(squares[pixel], expected);
                assert_eq!(to(sources[pixel] as usize), expected);
            }
        }
    }

    #[test]
    fn an_empty_set_is_far() {
        assert!(nearest(&[false; 16], 4).0.iter().all(|&square| square >= FAR));
    }
}
