//! Finds the amounts of pigment at which the mean of an uneven texture has its state's colour. A blade half green and half
//! yellow is lighter than an even one of the same contents; mending that by pigment keeps every place a plausible leaf, and
//! only what is left is mended by a factor on each channel.

use super::palette::{Look, Palette};
use super::pigment_field::{Amounts, Fields, Sample};
use super::surface::Tissue;
use crate::base::maths::expf;

/// Rounds of Newton's method with differences.
const ROUNDS: usize = 5;
/// The farthest that a round moves an amount: the front in leads, the others in logarithms.
const STRIDE: f32 = 0.5;
/// The farthest that all rounds move it.
const REACH: f32 = 1.6;
/// Most and least factor on a channel.
const GAINS: (f32, f32) = (0.25, 4.0);

/// Amounts and the factors on each channel that are still needed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Match {
    pub amounts: Amounts,
    pub gains: Look,
}

/// Matches the mean over some tissue to a look, starting at `amounts`.
pub(super) fn matched(fields: &Fields, palette: &Palette, tissue: &[Tissue], amounts: Amounts, wanted: &Look) -> Match {
    let mut moves = [0.0f32; 3];
    // Errors are compared where the eye does, on about the cube root.
    let root = |x: f32| (x.max(0.0) + 0.005).sqrt();
    let error = |moves: [f32; 3]| -> [f32; 3] {
        let found = mean(fields, palette, tissue, &moved(&amounts, moves), &[1.0; 9]);
        std::array::from_fn(|c| root(wanted[c]) - root(found[c]))
    };
    let size = |e: &[f32; 3]| e.iter().map(|x| x * x).sum::<f32>();
    let mut left = error(moves);
    for _ in 0..ROUNDS {
        let columns: [[f32; 3]; 3] = std::array::from_fn(|axis| {
            let mut nudged = moves;
            nudged[axis] += 0.08;
            let other = error(nudged);
            std::array::from_fn(|c| (left[c] - other[c]) / 0.08)
        });
        let step = damped(&columns, &left);
        let next: [f32; 3] = std::array::from_fn(|a| (moves[a] + step[a].clamp(-STRIDE, STRIDE)).clamp(-REACH, REACH));
        let after = error(next);
        if size(&after) >= size(&left) {
            break;
        }
        (moves, left) = (next, after);
    }
    let amounts = moved(&amounts, moves);
    Match { amounts, gains: gains(fields, palette, tissue, &amounts, wanted) }
}

/// Factors that bring the mean of what is clipped to 0..1 to the look wanted.
fn gains(fields: &Fields, palette: &Palette, tissue: &[Tissue], amounts: &Amounts, wanted: &Look) -> Look {
    let mut gains = [1.0f32; 9];
    for _ in 0..3 {
        let found = mean(fields, palette, tissue, amounts, &gains);
        gains = std::array::from_fn(|c| (gains[c] * wanted[c] / found[c].max(1e-6)).clamp(GAINS.0, GAINS.1));
    }
    gains
}

fn mean(fields: &Fields, palette: &Palette, tissue: &[Tissue], amounts: &Amounts, gains: &Look) -> Look {
    let mut sum = [0.0f64; 9];
    for tissue in tissue {
        let look = seen(palette, &fields.at(tissue, amounts));
        for c in 0..9 {
            sum[c] += f64::from((look[c] * gains[c]).min(1.0));
        }
    }
    sum.map(|s| (s / tissue.len().max(1) as f64) as f32)
}

/// How a sample looks.
#[inline]
pub(super) fn seen(palette: &Palette, sample: &Sample) -> Look {
    let look = palette.at(sample.contents);
    let [above, through, below] = sample.light;
    [
        look[0] * above,
        look[1] * above,
        look[2] * above,
        look[3] * through,
        look[4] * through,
        look[5] * through,
        look[6] * below,
        look[7] * below,
        look[8] * below,
    ]
}

fn moved(amounts: &Amounts, moves: [f32; 3]) -> Amounts {
    let [front, red, brown] = moves;
    Amounts {
        front: amounts.front + front,
        // Where the front cannot move the colour, because all is behind it, the amount behind it does.
        full: amounts.full * expf(0.5 * front),
        anthocyanins: amounts.anthocyanins * expf(red),
        brown: amounts.brown * expf(brown),
    }
}

/// Least squares with a small weight on the step itself (Levenberg 1944): solves (J'J + w I) s = J'e by elimination.
fn damped(columns: &[[f32; 3]; 3], error: &[f32; 3]) -> [f32; 3] {
    let dot = |a: &[f32; 3], b: &[f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let mut rows: [[f32; 4]; 3] = std::array::from_fn(|i| {
        let mut row = [0.0; 4];
        for j in 0..3 {
            row[j] = dot(&columns[i], &columns[j]) + if i == j { 2e-5 } else { 0.0 };
        }
        row[3] = dot(&columns[i], error);
        row
    });
    // Positive definite by the weight: no pivoting.
    for i in 0..3 {
        for j in 0..3 {
            if j != i {
                let factor = rows[j][i] / rows[i][i];
                for k in i..4 {
                    rows[j][k] -= factor * rows[i][k];
                }
            }
        }
    }
    std::array::from_fn(|i| rows[i][3] / rows[i][i])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_damped_step_solves_its_equations() {
        let columns = [[1.0, 0.2, 0.0], [0.1, 2.0, 0.3], [0.0, 0.1, 1.5]];
        let step = damped(&columns, &[1.0, -0.5, 0.7]);
        for c in 0..3 {
            let found: f32 = (0..3).map(|a| columns[a][c] * step[a]).sum();
            assert!((found - [1.0, -0.5, 0.7][c]).abs() < 1e-3, "{step:?}");
        }
    }
}
