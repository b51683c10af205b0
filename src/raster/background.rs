//! What stands behind everything in a tile.

use super::coverage::BLOCK;

/// A plane behind everything: its nearness over the tile, linear from the tile's upper left corner. Where that is not
/// positive there is nothing.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Background {
    /// Nearness at the corner.
    pub at: f32,
    /// Its growth a pixel to the right.
    pub right: f32,
    /// Its growth a pixel down.
    pub down: f32,
    /// Who the plane is.
    pub owner: u32,
    /// Who stands where there is nothing.
    pub beyond: u32,
}

impl Background {
    /// The nearness at a place in the tile, pixels.
    #[inline(always)]
    pub(super) fn nearness(&self, x: f32, y: f32) -> f32 {
        self.at + self.right * x + self.down * y
    }

    /// The least and the largest nearness of the plane over the block at a column and row of the tile, pixels.
    pub(super) fn range(&self, [left, top]: [usize; 2]) -> [f32; 2] {
        let [left, top] = [left, top].map(|place| place as f32);
        let side = BLOCK as f32;
        let corners = [[0.0, 0.0], [side, 0.0], [0.0, side], [side, side]];
        let corners = corners.map(|[x, y]| self.nearness(left + x, top + y));
        corners.into_iter().fold([f32::MAX, f32::MIN], |[low, high], value| [low.min(value), high.max(value)])
    }
}
