//! Where in a pixel the samples lie.

/// Bits of a coordinate below the pixel.
pub(super) const SUBPIXEL_BITS: u32 = 8;
/// Fixed-point units in a pixel.
pub(super) const SUBPIXEL: i32 = 1 << SUBPIXEL_BITS;

/// Most samples that are found in one pass over a tile.
pub(super) const MOST_AT_ONCE: u32 = 16;

/// How many samples a pixel gets in a pass, of `samples` (a power of two but 2) in all.
pub(super) fn at_once(samples: u32) -> u32 {
    samples.min(MOST_AT_ONCE)
}

/// Sample positions in 1/256 of a pixel from its upper left corner, of one of several passes over the same pixels: patterns in
/// which every row and every column of the grid holds one sample of all passes, so that edges near the axes are resolved in
/// as many steps as there are samples. The 4 and 8 sample patterns are the standard ones of Direct3D; those of 16 and more
/// are base-2 Hammersley sets, of which each pass has every so-manieth point.
pub(super) fn pattern<const S: usize>(passes: u32, pass: u32) -> [[i32; 2]; S] {
    const FOUR: [[i32; 2]; 4] = [[-2, -6], [6, -2], [-6, 2], [2, 6]];
    const EIGHT: [[i32; 2]; 8] = [[1, -3], [-1, 3], [5, 1], [-3, -5], [-5, 5], [-7, -1], [3, 7], [7, -7]];
    let centre = SUBPIXEL / 2;
    std::array::from_fn(|index| match S {
        1 => [centre, centre],
        4 => FOUR[index].map(|step| centre + step * (SUBPIXEL / 16)),
        8 => EIGHT[index].map(|step| centre + step * (SUBPIXEL / 16)),
        _ => {
            let count = S as u32 * passes;
            let number = index as u32 * passes + pass;
            let step = SUBPIXEL / count as i32;
            let reversed = number.reverse_bits() >> (u32::BITS - count.trailing_zeros());
            [number as i32 * step + step / 2, reversed as i32 * step + step / 2]
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn each_row_and_column_holds_one<const S: usize>(passes: u32) {
        let places: Vec<[i32; 2]> = (0..passes).flat_map(|pass| pattern::<S>(passes, pass)).collect();
        let size = SUBPIXEL / places.len() as i32;
        for axis in 0..2 {
            let mut slots: Vec<i32> = places.iter().map(|p| p[axis].div_euclid(size)).collect();
            slots.sort_unstable();
            slots.dedup();
            assert_eq!(slots.len(), places.len(), "axis {axis} of {}", places.len());
        }
        assert!(places.iter().flatten().all(|x| (0..SUBPIXEL).contains(x)));
    }

    #[test]
    fn patterns_are_stratified_on_both_axes() {
        each_row_and_column_holds_one::<1>(1);
        each_row_and_column_holds_one::<4>(1);
        each_row_and_column_holds_one::<8>(1);
        for passes in [1, 2, 4, 8, 16] {
            each_row_and_column_holds_one::<16>(passes);
        }
    }
}
