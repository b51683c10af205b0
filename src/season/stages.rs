//! Hidden stages: a state of k equal stages is left after a time of Erlang's distribution, the narrower the larger k.

use crate::base::maths::exp;

/// The median of the sum of `stages` exponential times of mean 1: the rate of a stage is this over the half-life of the
/// state, so that half of the leaves have left after it. ln 2 for one stage.
#[must_use]
pub(super) fn median(stages: u32) -> f64 {
    if stages <= 1 {
        return std::f64::consts::LN_2;
    }
    // The median lies between the mean less a third and the mean (Chen and Rubin 1986).
    let (mut low, mut high) = (f64::from(stages) - 1.0 / 3.0, f64::from(stages));
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if staying(stages, middle) > 0.5 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Chance that fewer than `stages` events of a Poisson process have come in a time of mean `time`.
fn staying(stages: u32, time: f64) -> f64 {
    let mut term = exp(-time);
    let mut sum = term;
    for event in 1..stages {
        term *= time / f64::from(event);
        sum += term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_the_leaves_have_left_at_the_median() {
        for stages in 1..=64 {
            assert!((staying(stages, median(stages)) - 0.5).abs() < 1e-12, "{stages} stages");
        }
        // e^-m (1 + m) = 1/2 by Newton's method on paper.
        assert!((median(2) - 1.678_346_990_016_661).abs() < 1e-12);
    }
}
