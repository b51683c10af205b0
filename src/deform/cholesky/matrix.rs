//! A sparse symmetric matrix of 3 x 3 blocks: the Hessian of something that lives on vertices in space. Only blocks on and
//! below the diagonal are kept, column by column, in the order of elimination.

/// A block, row by row.
pub type Block = [f64; 9];

/// The place of an absent block.
pub const NOWHERE: u32 = u32::MAX;

/// The transpose of a block.
#[must_use]
pub fn transposed(b: &Block) -> Block {
    [b[0], b[3], b[6], b[1], b[4], b[7], b[2], b[5], b[8]]
}

/// The matrix.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Matrix {
    /// Where each column's blocks start in `rows`, and where the last ends.
    pub starts: Vec<u32>,
    /// The row of each block, ascending within a column, the diagonal first.
    pub rows: Vec<u32>,
    /// The blocks.
    pub blocks: Vec<Block>,
}

impl Matrix {
    /// Zeros where `pairs` (of rows and columns, in any order and number) may be non-zero, and on the diagonal.
    #[must_use]
    pub fn new(size: usize, pairs: impl Iterator<Item = [u32; 2]>) -> Self {
        let diagonal = (0..size as u32).map(|i| [i, i]);
        let mut places: Vec<[u32; 2]> = pairs.map(|[a, b]| [a.min(b), a.max(b)]).chain(diagonal).collect();
        places.sort_unstable();
        places.dedup();
        let mut starts = vec![0u32; size + 1];
        for [column, _] in &places {
            starts[*column as usize + 1] += 1;
        }
        for column in 0..size {
            starts[column + 1] += starts[column];
        }
        let rows: Vec<u32> = places.iter().map(|place| place[1]).collect();
        let blocks = vec![[0.0; 9]; rows.len()];
        Self { starts, rows, blocks }
    }

    /// Number of block columns.
    #[must_use]
    pub fn size(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// The blocks of a column, as places in `rows` and `blocks`.
    #[must_use]
    pub fn column(&self, column: usize) -> std::ops::Range<usize> {
        self.starts[column] as usize..self.starts[column + 1] as usize
    }

    /// The place of the block of two indices (either may be the row); [`NOWHERE`] when it is not in the pattern or an index is.
    #[must_use]
    pub fn place(&self, a: u32, b: u32) -> u32 {
        if a == NOWHERE || b == NOWHERE {
            return NOWHERE;
        }
        let range = self.column(a.min(b) as usize);
        let found = self.rows[range.clone()].binary_search(&a.max(b));
        found.map_or(NOWHERE, |at| (range.start + at) as u32)
    }

    /// Sets every block to zero.
    pub fn clear(&mut self) {
        self.blocks.fill([0.0; 9]);
    }

    /// Adds the block of row `a` and column `b`, and with it that of row `b` and column `a`, its transpose. Between two
    /// different things at one index (`twice`) both fall on the diagonal.
    pub fn add(&mut self, place: u32, [a, b]: [u32; 2], block: &Block, twice: bool) {
        if place == NOWHERE {
            return;
        }
        let target = &mut self.blocks[place as usize];
        if a >= b {
            target.iter_mut().zip(block).for_each(|(t, x)| *t += x);
        }
        if a < b || (twice && a == b) {
            target.iter_mut().zip(transposed(block)).for_each(|(t, x)| *t += x);
        }
    }

    /// Adds to the diagonal of every block column its own amount.
    pub fn shift(&mut self, amounts: &[f64], factor: f64) {
        for (column, amount) in amounts.iter().enumerate() {
            let block = &mut self.blocks[self.starts[column] as usize];
            for i in [0, 4, 8] {
                block[i] += amount * factor;
            }
        }
    }

    /// The largest number on the diagonal.
    #[must_use]
    pub fn largest_diagonal(&self) -> f64 {
        let largest = |column: usize| {
            let block = &self.blocks[self.starts[column] as usize];
            block[0].max(block[4]).max(block[8])
        };
        (0..self.size()).map(largest).fold(0.0, f64::max)
    }

    /// The product with a vector.
    #[cfg(test)]
    pub fn times(&self, x: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let mut product = vec![[0.0; 3]; x.len()];
        for column in 0..self.size() {
            for at in self.column(column) {
                let row = self.rows[at] as usize;
                let block = &self.blocks[at];
                for i in 0..3 {
                    for j in 0..3 {
                        product[row][i] += block[3 * i + j] * x[column][j];
                        if row != column {
                            product[column][j] += block[3 * i + j] * x[row][i];
                        }
                    }
                }
            }
        }
        product
    }
}
