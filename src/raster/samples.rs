//! Where in a pixel the samples lie.

/// Bits of a coordinate below the pixel.
pub(super) const SUBPIXEL_BITS: u32 = 8;
/// Fixed-point units in a pixel.
pub(super) const SUBPIXEL: i32 = 1 << SUBPIXEL_BITS;

/// Sample positions in 1/256 of a pixel from its upper left corner: patterns in which every row and every column of the
/// grid holds one sample, so that edges near the axes are resolved in as many steps as there are samples. The 4 and 8
/// sample patterns are the standard ones of Direct3D; the one of 16 is the base-2 van der Corput set.
pub(super) fn pattern<const S: usize>() -> [[i32; 2]; S] {
    const FOUR: [[i32; 2]; 4] = [[-2, -6], [6, -2], [-6, 2], [2, 6]];
    const EIGHT: [[i32; 2]; 8] = [[1, -3], [-1, 3], [5, 1], [-3, -5], [-5, 5], [-7, -1], [3, 7], [7, -7]];
    let centre = SUBPIXEL / 2;
    std::array::from_fn(|index| match S {
        1 => [centre, centre],
        4 => FOUR[index].map(|step| centre + step * (SUBPIXEL / 16)),
        8 => EIGHT[index].map(|step| centre + step * (SUBPIXEL / 16)),
        _ => {
            let step = SUBPIXEL / S as i32;
            let reversed = (index as u32).reverse_bits() >> (u32::BITS - S.trailing_zeros());
            [index as i32 * step + step / 2, reversed as i32 * step + step / 2]
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn each_row_and_column_holds_one<const S: usize>() {
        let step = SUBPIXEL / 16;
        let size = 16 / S as i32 * step;
        for axis in 0..2 {
            let mut slots: Vec<i32> = pattern::<S>().iter().map(|p| p[axis].div_euclid(size)).collect();
            slots.sort_unstable();
            slots.dedup();
            assert_eq!(slots.len(), S, "axis {axis} of {S}");
        }
    }

    #[test]
    fn patterns_are_stratified_on_both_axes() {
        each_row_and_column_holds_one::<1>();
        each_row_and_column_holds_one::<4>();
        each_row_and_column_holds_one::<8>();
        each_row_and_column_holds_one::<16>();
    }

    #[test]
    fn samples_lie_inside_the_pixel() {
        assert!(pattern::<8>().iter().flatten().all(|&x| (0..SUBPIXEL).contains(&x)));
        assert!(pattern::<16>().iter().flatten().all(|&x| (0..SUBPIXEL).contains(&x)));
    }
}
