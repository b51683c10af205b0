//! One channel of a picture as floats, and work on its rows by all threads.

use rayon::prelude::*;

/// Values of all pixels, row by row.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Plane {
    pub(super) width: usize,
    pub(super) values: Vec<f32>,
}

impl Plane {
    /// A plane of a function of each pixel.
    pub(super) fn of<P: Sync>(pixels: &[P], width: usize, value: impl Fn(&P) -> f32 + Sync + Send) -> Self {
        Self { width, values: pixels.par_iter().map(value).collect() }
    }

    /// Correlation with a row of weights, then with a column of weights; beyond its rim the picture continues.
    /// Both have an odd length. Each result has its own sum in a fixed order, so threads cannot show.
    pub(super) fn correlated(&self, row_weights: &[f32], column_weights: &[f32]) -> Self {
        self.along_rows(row_weights).along_columns(column_weights)
    }

    fn along_rows(&self, weights: &[f32]) -> Self {
        let mut values = vec![0.0; self.values.len()];
        let radius = weights.len() / 2;
        values.par_chunks_mut(self.width).zip(self.values.par_chunks(self.width)).for_each(|(target, source)| {
            let (first, last) = (source[0], source[source.len() - 1]);
            let mut padded = vec![first; radius];
            padded.extend_from_slice(source);
            padded.resize(padded.len() + radius, last);
            for (x, value) in target.iter_mut().enumerate() {
                *value = weights.iter().zip(&padded[x..]).map(|(w, v)| w * v).sum();
            }
        });
        Self { width: self.width, values }
    }

    fn along_columns(&self, weights: &[f32]) -> Self {
        let mut values = vec![0.0; self.values.len()];
        let (radius, rows) = (weights.len() / 2, self.values.len() / self.width);
        values.par_chunks_mut(self.width).enumerate().for_each(|(y, target)| {
            for (offset, weight) in weights.iter().enumerate() {
                let row = (y + offset).saturating_sub(radius).min(rows - 1);
                let source = &self.values[row * self.width..][..self.width];
                target.iter_mut().zip(source).for_each(|(value, v)| *value += weight * v);
            }
        });
        Self { width: self.width, values }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_spreads_into_the_weights() {
        let mut values = vec![0.0; 35];
        values[2 * 7 + 3] = 1.0;
        let plane = Plane { width: 7, values };
        let spread = plane.correlated(&[1.0, 2.0, 3.0], &[5.0, 7.0, 11.0]);
        assert_eq!(spread.values[7 + 2..7 + 5], [33.0, 22.0, 11.0]);
        assert_eq!(spread.values[14 + 2..14 + 5], [21.0, 14.0, 7.0]);
        assert_eq!(spread.values.iter().sum::<f32>(), 6.0 * 23.0);
    }

    #[test]
    fn a_flat_picture_stays_flat_to_its_rim() {
        let plane = Plane { width: 4, values: vec![2.0; 12] };
        let filtered = plane.correlated(&[0.25, 0.5, 0.25], &[0.25, 0.5, 0.25]);
        assert_eq!(filtered, plane);
    }
}
