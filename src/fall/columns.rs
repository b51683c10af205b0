//! The height of the litter over the ground, cell by cell, in tiles that are made when something lies in them.

use super::Ground;
use crate::base::vector::DVec2;

/// Side of a cell, metres.
pub(super) const CELL: f64 = 0.008;
/// Cells along a tile's side, as a power of two.
const TILE_BITS: u32 = 4;
const TILE: i32 = 1 << TILE_BITS;
const TILE_CELLS: usize = (TILE * TILE) as usize;
/// Most tiles along a side of the plain: a quarter of a kilometre. What lies farther shares the tiles of what is nearer.
const MOST: u32 = 2048;
/// Added to cells before they are rounded towards zero, so that they are rounded down: `floor` is slow on old processors.
const OFFSET: f64 = (1u32 << 29) as f64;

/// Most cells along a patch's side.
const MOST_PATCH: usize = 255;

/// The cells about a leaf, copied: its lines are looked up there by the hundred.
#[derive(Default)]
pub(super) struct Patch {
    column: u32,
    row: u32,
    side: usize,
    /// The leaf's place in cells from the first.
    middle: [f32; 2],
    heights: Vec<f32>,
}

impl Patch {
    /// The number of the cell that lies so many cells from the leaf's place along x and z.
    #[inline]
    pub(super) fn cell(&self, x: f32, z: f32) -> u16 {
        let last = self.side as u16 - 1;
        let place = |offset: f32, middle: f32| ((offset + middle) as u16).min(last);
        place(z, self.middle[1]) * self.side as u16 + place(x, self.middle[0])
    }

    /// The height of a cell.
    #[inline]
    pub(super) fn height(&mut self, cell: u16) -> &mut f32 {
        &mut self.heights[usize::from(cell)]
    }
}

/// The top of what lies, as a field of heights.
pub(super) struct Columns<'a> {
    ground: &'a Ground,
    /// Tiles along both sides less one; their numbers are powers of two, so that tiles wrap by a mask.
    masks: [u32; 2],
    /// Bits of a column of tiles.
    shift: u32,
    /// Number of each tile, one more; 0 for none.
    numbers: Vec<u32>,
    heights: Vec<f32>,
}

impl<'a> Columns<'a> {
    /// Bare ground that reaches over these places with so many metres about them.
    pub(super) fn new(ground: &'a Ground, places: impl Iterator<Item = DVec2>, margin: f64) -> Self {
        let mut bounds: Option<(DVec2, DVec2)> = None;
        for place in places {
            let (low, high) = bounds.unwrap_or((place, place));
            bounds = Some((low.inf(&place), high.sup(&place)));
        }
        let (low, high) = bounds.unwrap_or_default();
        let tiles = (high - low + DVec2::repeat(2.0 * margin)) / (CELL * f64::from(TILE));
        let sides = [tiles.x, tiles.y].map(|tiles| (tiles as u32 + 2).min(MOST).next_power_of_two());
        let numbers = vec![0; (sides[0] * sides[1]) as usize];
        Self {
            ground,
            masks: sides.map(|side| side - 1),
            shift: sides[0].trailing_zeros(),
            numbers,
            heights: Vec::new(),
        }
    }

    /// Copies the cells within `reach` metres of a place into a patch.
    pub(super) fn lift(&mut self, place: DVec2, reach: f64, patch: &mut Patch) {
        let cell = |metres: f64| ((metres - reach) * (1.0 / CELL) + OFFSET) as u32;
        (patch.column, patch.row) = (cell(place.x), cell(place.y));
        patch.side = ((2.0 * reach / CELL) as usize + 2).min(MOST_PATCH);
        let middle = |metres: f64, first: u32| (metres * (1.0 / CELL) + OFFSET - f64::from(first)) as f32;
        patch.middle = [middle(place.x, patch.column), middle(place.y, patch.row)];
        patch.heights.clear();
        for row in 0..patch.side as u32 {
            self.along(patch.row + row, patch.column, patch.side, |part| patch.heights.extend_from_slice(part));
        }
    }

    /// Writes a patch back.
    pub(super) fn lower(&mut self, patch: &Patch) {
        for (row, heights) in (patch.row..).zip(patch.heights.chunks(patch.side)) {
            let mut rest = heights;
            self.along(row, patch.column, patch.side, |part| {
                let (these, others) = rest.split_at(part.len().min(rest.len()));
                part.copy_from_slice(these);
                rest = others;
            });
        }
    }

    /// Visits the cells of a row, tile by tile.
    fn along(&mut self, row: u32, column: u32, count: usize, mut visit: impl FnMut(&mut [f32])) {
        let within = |cell: u32| cell as usize & (TILE as usize - 1);
        let down = (row >> TILE_BITS & self.masks[1]) << self.shift;
        let (mut column, mut left) = (column, count);
        while left > 0 {
            let slot = (down | column >> TILE_BITS & self.masks[0]) as usize;
            if self.numbers[slot] == 0 {
                self.open(slot, column, row);
            }
            let first = (self.numbers[slot] as usize - 1) * TILE_CELLS + (within(row) << TILE_BITS | within(column));
            let length = left.min(TILE as usize - within(column));
            visit(&mut self.heights[first..first + length]);
            column += length as u32;
            left -= length;
        }
    }

    #[cold]
    fn open(&mut self, slot: usize, column: u32, row: u32) {
        if self.ground.heights.is_none() {
            self.heights.resize(self.heights.len() + TILE_CELLS, 0.0);
        } else {
            let first = |cell: u32| f64::from(cell >> TILE_BITS << TILE_BITS) - OFFSET + 0.5;
            let place = |z: i32, x: i32| DVec2::new(first(column) + f64::from(x), first(row) + f64::from(z)) * CELL;
            let ground = self.ground;
            let cells = (0..TILE).flat_map(|z| (0..TILE).map(move |x| (z, x)));
            self.heights.extend(cells.map(|(z, x)| ground.height(place(z, x)) as f32));
        }
        self.numbers[slot] = (self.heights.len() / TILE_CELLS) as u32;
    }
}
