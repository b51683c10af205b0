//! What changes so little over a block of pixels that it need not be found at each: light, haze, the clear sky.

use super::coverage::BLOCK;
use crate::base::maths::mix;

/// Largest departure from a straight course that counts as even, relative to the largest of the block's values: a quarter of
/// a code of 8 bits in a bright place.
const TOLERANCE: f32 = 1e-3;

/// Values over a block, known at the middles of its corner pixels and straight between them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Even<const N: usize> {
    /// Upper left, upper right, lower left, lower right.
    corners: [[f32; N]; 4],
}

/// Share of the way between the middles of a block's first and last pixels.
#[inline(always)]
fn share(pixel: f32) -> f32 {
    (pixel - 0.5) * (1.0 / (BLOCK - 1) as f32)
}

impl<const N: usize> Even<N> {
    /// Finds values at the corners of a block whose upper left corner is `corner` (pixels); none if they are not even, judged
    /// at the middles of the block and of its sides.
    pub(super) fn over(corner: [f32; 2], find: impl Fn([f32; 2]) -> [f32; N]) -> Option<Self> {
        let last = BLOCK as f32 - 0.5;
        let at = |x: f32, y: f32| find([corner[0] + x, corner[1] + y]);
        let even = Self { corners: [at(0.5, 0.5), at(last, 0.5), at(0.5, last), at(last, last)] };
        let half = BLOCK as f32 * 0.5;
        let checked = [[half, half], [half, 0.5], [0.5, half], [last, half], [half, last]];
        let is_near = |[x, y]: [f32; 2]| {
            let (found, guessed) = (at(x, y), even.at([x, y]));
            (0..N).all(|k| {
                let largest = even.corners.iter().fold(0.0f32, |largest, corner| largest.max(corner[k].abs()));
                (found[k] - guessed[k]).abs() <= TOLERANCE * largest
            })
        };
        checked.into_iter().all(is_near).then_some(even)
    }

    /// The values at a place in the block, pixels from its upper left corner.
    #[inline(always)]
    pub(super) fn at(&self, [x, y]: [f32; 2]) -> [f32; N] {
        let (x, y) = (share(x), share(y));
        let [a, b, c, d] = &self.corners;
        std::array::from_fn(|k| mix(mix(a[k], b[k], x), mix(c[k], d[k], x), y))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn straight_courses_are_exact() {
        let course = |[x, y]: [f32; 2]| [3.0 + 0.25 * x - 0.5 * y, 7.0];
        let even = Even::over([64.0, 8.0], course).expect("even");
        for place in [[0.5, 0.5], [3.0, 6.5], [7.5, 1.5]] {
            let expected = course([64.0 + place[0], 8.0 + place[1]]);
            assert!(even.at(place).iter().zip(expected).all(|(got, want)| (got - want).abs() < 1e-4));
        }
    }

    #[test]
    fn steps_and_bends_are_not_even() {
        assert!(Even::over([0.0, 0.0], |[x, _]| [f32::from(x > 3.0)]).is_none());
        assert!(Even::over([0.0, 0.0], |[x, y]| [1.0 + 0.001 * x * y * y]).is_none());
        assert!(Even::over([0.0, 0.0], |[x, y]| [1.0 + 1e-6 * x * y * y]).is_some());
    }
}
