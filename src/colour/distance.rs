//! Exact distances on a grid of pixels: to the nearest pixel of a set, and which one that is.
//!
//! Felzenszwalb and Huttenlocher 2012, "Distance Transforms of Sampled Functions": lower envelopes of parabolas, first down
//! the columns and then along the rows.

/// Stands for "no pixel of the set here"; a distance whose square still is a finite f32 sum.
const FAR: f32 = 1e12;

/// For each pixel of a square grid, the squared distance (pixels) to the nearest pixel of `set` and its number. Without any
/// pixel in the set, distances are at least 1e12 and the numbers mean nothing.
pub(super) fn nearest(set: &[bool], size: usize) -> (Vec<f32>, Vec<u32>) {
    let mut squares: Vec<f32> = set.iter().map(|&inside| if inside { 0.0 } else { FAR }).collect();
    let mut sources: Vec<u32> = (0..set.len() as u32).collect();
    let mut envelope = Envelope::new(size);
    for column in 0..size {
        envelope.transform(&mut squares, &mut sources, column, size);
    }
    for row in 0..size {
        envelope.transform(&mut squares, &mut sources, row * size, 1);
    }
    (squares, sources)
}

/// Working memory for one line.
struct Envelope {
    values: Vec<f32>,
    owners: Vec<u32>,
    /// Where the parabolas of the envelope stand.
    feet: Vec<usize>,
    /// Where each takes over from the one before.
    starts: Vec<f32>,
}

impl Envelope {
    fn new(size: usize) -> Self {
        Self { values: vec![0.0; size], owners: vec![0; size], feet: vec![0; size], starts: vec![0.0; size] }
    }

    /// Transforms the line that begins at `first` and goes on every `stride` pixels.
    fn transform(&mut self, squares: &mut [f32], sources: &mut [u32], first: usize, stride: usize) {
        let size = self.values.len();
        for index in 0..size {
            self.values[index] = squares[first + index * stride];
            self.owners[index] = sources[first + index * stride];
        }
        let last = self.build();
        let mut part = 0;
        for index in 0..size {
            while part < last && self.starts[part + 1] < index as f32 {
                part += 1;
            }
            let foot = self.feet[part];
            let along = index as f32 - foot as f32;
            squares[first + index * stride] = along * along + self.values[foot];
            sources[first + index * stride] = self.owners[foot];
        }
    }

    /// Makes the lower envelope; returns the number of its last parabola.
    fn build(&mut self) -> usize {
        let mut last = 0;
        self.feet[0] = 0;
        self.starts[0] = f32::NEG_INFINITY;
        for index in 1..self.values.len() {
            let mut start = self.meeting(self.feet[last], index);
            while last > 0 && start <= self.starts[last] {
                last -= 1;
                start = self.meeting(self.feet[last], index);
            }
            last += 1;
            self.feet[last] = index;
            self.starts[last] = start;
        }
        last
    }

    /// Where the parabola at `b` comes below that at `a`, for a < b. In f64: squares of far pixels swamp f32.
    fn meeting(&self, a: usize, b: usize) -> f32 {
        let value = |foot: usize| f64::from(self.values[foot]) + (foot * foot) as f64;
        ((value(b) - value(a)) / (2.0 * (b - a) as f64)) as f32
    }
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
