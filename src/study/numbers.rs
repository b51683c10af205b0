//! The statistics of a study: medians and quartiles, orders of convergence, and the rows that no other row beats.

use crate::base::maths::ln;

/// Lower quartile, median and upper quartile, interpolated between neighbours; zeros without values.
#[must_use]
pub fn quartiles(values: &[f64]) -> [f64; 3] {
    quantiles(values, [0.25, 0.5, 0.75])
}

/// The values below which these shares of all lie, interpolated between neighbours; zeros without values.
#[must_use]
pub fn quantiles<const N: usize>(values: &[f64], shares: [f64; N]) -> [f64; N] {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let Some(last) = sorted.len().checked_sub(1) else { return [0.0; N] };
    shares.map(|share| {
        let place = share * last as f64;
        let (low, high) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
        low + (high - low) * place.fract()
    })
}

/// The middle of the values; 0 without any.
#[must_use]
pub fn median(values: &[f64]) -> f64 {
    quartiles(values)[1]
}

/// The exponent p of y = c x^p that fits best (least squares of the logarithms); `None` for fewer than two points that are
/// positive at different x.
#[must_use]
pub fn slope(points: &[[f64; 2]]) -> Option<f64> {
    let positive = points.iter().filter(|point| point.iter().all(|value| *value > 0.0 && value.is_finite()));
    let logs: Vec<[f64; 2]> = positive.map(|point| point.map(ln)).collect();
    let count = logs.len() as f64;
    let mean = |axis: usize| logs.iter().map(|point| point[axis]).sum::<f64>() / count;
    let (x, y) = (mean(0), mean(1));
    let across: f64 = logs.iter().map(|point| (point[0] - x) * (point[0] - x)).sum();
    let along: f64 = logs.iter().map(|point| (point[0] - x) * (point[1] - y)).sum();
    (across > 1e-12).then(|| along / across)
}

/// Which points of (work, error) no other point beats: none has less of one and not more of the other. Points that are not
/// finite are never on the front.
#[must_use]
pub fn front(points: &[[f64; 2]]) -> Vec<bool> {
    let beats = |a: &[f64; 2], b: &[f64; 2]| a[0] <= b[0] && a[1] <= b[1] && (a[0] < b[0] || a[1] < b[1]);
    let is_finite = |point: &[f64; 2]| point.iter().all(|value| value.is_finite());
    points.iter().map(|point| is_finite(point) && !points.iter().any(|other| beats(other, point))).collect()
}

/// Which rows beat a row in both: less work and less error, by more than a share `margin` of each.
#[must_use]
pub fn beaten_by(points: &[[f64; 2]], row: usize, margin: f64) -> Vec<usize> {
    let own = points[row];
    let beats = |other: &[f64; 2]| (0..2).all(|axis| other[axis] < own[axis] * (1.0 - margin));
    (0..points.len()).filter(|&other| other != row && beats(&points[other])).collect()
}

/// Half the sum of the differences of two distributions: the largest difference in the chance of any set of states.
#[must_use]
pub fn total_variation(a: &[f64], b: &[f64]) -> f64 {
    0.5 * a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>()
}

/// A number of few significant digits for tables: plain from 0.001 to a million, else with an exponent. Seven digits keep what
/// is compared and drop what rounding leaves.
#[must_use]
pub fn shown(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || (1e-3..1e6).contains(&size) {
        let digits = 6usize.saturating_sub(if size >= 1.0 { whole_digits(size) } else { 0 });
        let text = format!("{value:.digits$}");
        return if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text };
    }
    format!("{value:.4e}")
}

fn whole_digits(size: f64) -> usize {
    let mut digits = 1;
    let mut bound = 10.0;
    while size >= bound {
        bound *= 10.0;
        digits += 1;
    }
    digits
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_are_interpolated_and_do_not_depend_on_the_order() {
        assert_eq!(quartiles(&[4.0, 1.0, 3.0, 2.0]), [1.75, 2.5, 3.25]);
        assert_eq!(quartiles(&[7.0]), [7.0; 3]);
        assert_eq!(quartiles(&[]), [0.0; 3]);
        assert_eq!(median(&[9.0, 1.0, 5.0]), 5.0);
    }

    #[test]
    fn the_order_of_a_power_is_its_exponent() {
        let points: Vec<[f64; 2]> = [1.0, 2.0, 4.0, 8.0].iter().map(|x: &f64| [*x, 3.0 / (x * x)]).collect();
        assert!((slope(&points).unwrap() + 2.0).abs() < 1e-12);
        assert_eq!(slope(&points[..1]), None);
        assert_eq!(slope(&[[1.0, 2.0], [1.0, 3.0]]), None);
        assert_eq!(slope(&[[1.0, 0.0], [2.0, f64::NAN]]), None);
    }

    #[test]
    fn the_front_is_what_nothing_beats() {
        let points = [[1.0, 9.0], [2.0, 4.0], [3.0, 5.0], [4.0, 1.0], [f64::NAN, 0.0], [2.0, 4.0]];
        assert_eq!(front(&points), [true, true, false, true, false, true]);
        assert_eq!(beaten_by(&points, 2, 0.0), [1, 5]);
        assert_eq!(beaten_by(&points, 2, 0.3), [] as [usize; 0]);
    }

    #[test]
    fn numbers_are_short_and_say_their_size() {
        let table = [(0.0, "0"), (1.5, "1.5"), (123456.0, "123456"), (0.001234567, "0.001235"), (2.5e-7, "2.5000e-7")];
        for (value, text) in table {
            assert_eq!(shown(value), text);
        }
        assert_eq!(shown(f64::INFINITY), "inf");
        assert_eq!(shown(1e7), "1.0000e7");
    }
}
