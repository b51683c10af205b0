//! A field over the ground in square cells, in tiles that are made when something lies in them.

use crate::base::vector::DVec2;

/// Cells along a tile's side, as a power of two.
const TILE_BITS: u32 = 5;
const TILE: i32 = 1 << TILE_BITS;
const TILE_CELLS: usize = (TILE * TILE) as usize;
/// Most tiles along a side of the plain. What lies farther shares the tiles of what is nearer.
const MOST: u32 = 2048;
/// Added to cells before they are rounded towards zero, so that they are rounded down: `floor` is slow on old processors.
const OFFSET: f64 = (1u32 << 29) as f64;
/// Most cells along a patch's side: of a larger leaf the rim is looked up in the outermost cells.
const MOST_PATCH: usize = 1024;

/// The cells about a leaf, copied: they are looked up there by the hundred.
#[derive(Default)]
pub(super) struct Patch {
    column: u32,
    row: u32,
    pub side: usize,
    /// The leaf's place in cells from the first.
    pub middle: [f32; 2],
    pub values: Vec<u16>,
}

impl Patch {
    /// The number of the cell in which a point lies, given in cells from the first along x and z.
    #[inline]
    pub(super) fn cell(&self, x: f32, z: f32) -> usize {
        let last = self.side - 1;
        (z as usize).min(last) * self.side + (x as usize).min(last)
    }

    /// The cell in which a point lies, given in cells from the leaf's place, and what leads from there to the cell's middle.
    #[inline]
    pub(super) fn cell_of(&self, x: f32, z: f32) -> (usize, [f32; 2]) {
        // rounding by the lowest bits of a sum: places are positive and small
        const ROUNDING: f32 = (1u32 << 23) as f32;
        let last = self.side as u32 - 1;
        let [x, z] = [x + self.middle[0] - 0.5, z + self.middle[1] - 0.5];
        let nearest = |place: f32| ((place + ROUNDING).to_bits() & 0x3f_ffff).min(last);
        let (column, row) = (nearest(x), nearest(z));
        ((row * self.side as u32 + column) as usize, [column as f32 - x, row as f32 - z])
    }

    /// Where the middle of a cell lies, metres.
    pub(super) fn place(&self, cell: usize, side: f64) -> DVec2 {
        let along = |first: u32, cell: usize| (f64::from(first) + cell as f64 + 0.5 - OFFSET) * side;
        DVec2::new(along(self.column, cell % self.side), along(self.row, cell / self.side))
    }
}

/// The field.
pub(super) struct Columns {
    /// Side of a cell, metres.
    pub side: f64,
    /// Tiles along both sides less one; their numbers are powers of two, so that tiles wrap by a mask.
    masks: [u32; 2],
    /// Bits of a column of tiles.
    shift: u32,
    /// Number of each tile, one more; 0 for none.
    numbers: Vec<u32>,
    values: Vec<u16>,
}

impl Columns {
    /// A field of zeros that reaches over these places with so many metres about them.
    pub(super) fn new(side: f64, places: impl Iterator<Item = DVec2>, margin: f64) -> Self {
        let mut bounds: Option<(DVec2, DVec2)> = None;
        for place in places {
            let (low, high) = bounds.unwrap_or((place, place));
            bounds = Some((low.inf(&place), high.sup(&place)));
        }
        let (low, high) = bounds.unwrap_or_default();
        let tiles = (high - low + DVec2::repeat(2.0 * margin)) / (side * f64::from(TILE));
        let sides = [tiles.x, tiles.y].map(|tiles| (tiles as u32 + 2).min(MOST).next_power_of_two());
        let numbers = vec![0; (sides[0] * sides[1]) as usize];
        Self { side, masks: sides.map(|side| side - 1), shift: sides[0].trailing_zeros(), numbers, values: Vec::new() }
    }

    /// Copies the cells within `reach` metres of a place into a patch.
    pub(super) fn lift(&mut self, place: DVec2, reach: f64, patch: &mut Patch) {
        let cell = |metres: f64| ((metres - reach) / self.side + OFFSET) as u32;
        (patch.column, patch.row) = (cell(place.x), cell(place.y));
        patch.side = ((2.0 * reach / self.side) as usize + 2).min(MOST_PATCH);
        let middle = |metres: f64, first: u32| (metres / self.side + OFFSET - f64::from(first)) as f32;
        patch.middle = [middle(place.x, patch.column), middle(place.y, patch.row)];
        patch.values.clear();
        for row in 0..patch.side as u32 {
            self.along(patch.row + row, patch.column, patch.side, |part| patch.values.extend_from_slice(part));
        }
    }

    /// Writes a patch back.
    pub(super) fn lower(&mut self, patch: &Patch) {
        for (row, values) in (patch.row..).zip(patch.values.chunks(patch.side)) {
            let mut rest = values;
            self.along(row, patch.column, patch.side, |part| {
                let (these, others) = rest.split_at(part.len().min(rest.len()));
                part.copy_from_slice(these);
                rest = others;
            });
        }
    }

    /// Visits the cells of a row, tile by tile.
    fn along(&mut self, row: u32, column: u32, count: usize, mut visit: impl FnMut(&mut [u16])) {
        let within = |cell: u32| cell as usize & (TILE as usize - 1);
        let down = (row >> TILE_BITS & self.masks[1]) << self.shift;
        let (mut column, mut left) = (column, count);
        while left > 0 {
            let slot = (down | column >> TILE_BITS & self.masks[0]) as usize;
            if self.numbers[slot] == 0 {
                self.values.resize(self.values.len() + TILE_CELLS, 0);
                self.numbers[slot] = (self.values.len() / TILE_CELLS) as u32;
            }
            let first = (self.numbers[slot] as usize - 1) * TILE_CELLS + (within(row) << TILE_BITS | within(column));
            let length = left.min(TILE as usize - within(column));
            visit(&mut self.values[first..first + length]);
            column += length as u32;
            left -= length;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_at_a_place_is_read_there_from_anywhere() {
        let places = [DVec2::new(-3.0, 1.0), DVec2::new(2.0, -0.4)];
        let mut columns = Columns::new(0.01, places.into_iter(), 0.5);
        let mut patch = Patch::default();
        for (number, place) in (1u16..).zip(places) {
            columns.lift(place, 0.2, &mut patch);
            let cell = patch.cell(patch.middle[0], patch.middle[1]);
            assert!((patch.place(cell, 0.01) - place).abs().max() <= 0.005 + 1e-9);
            patch.values[cell] = number;
            columns.lower(&patch);
        }
        for (number, place) in (1u16..).zip(places) {
            columns.lift(place + DVec2::new(0.07, -0.05), 0.1, &mut patch);
            let cell = patch.cell(patch.middle[0] - 7.0, patch.middle[1] + 5.0);
            assert_eq!((patch.values[cell], patch.values.iter().filter(|&&v| v > 0).count()), (number, 1));
        }
    }
}
