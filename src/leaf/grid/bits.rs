//! Two-valued grids as bits, 64 cells to a word: dilation and erosion by discs, and the runs of true cells along the rows.

use super::{Grid, Run};

/// Cells of a word.
const WORD: usize = 64;
/// The eight cells of each byte, lowest bit first.
const CELLS: [[bool; 8]; 256] = cells_of_bytes();

/// Rows of words; the lowest bit of a word is its leftmost cell. What lies outside the grid, the bits beyond the end of a row
/// among it, has one value.
pub struct Bits {
    width: usize,
    height: usize,
    /// Words of a row.
    columns: usize,
    words: Vec<u64>,
    /// 0 where all outside is false, all ones where it is true.
    outside: u64,
}

impl Bits {
    /// The cells of a grid; outside all is false.
    pub fn of(grid: &Grid<bool>) -> Self {
        let columns = grid.width.div_ceil(WORD);
        let mut words = Vec::with_capacity(columns * grid.height);
        for row in grid.cells.chunks_exact(grid.width.max(1)) {
            words.extend(row.chunks(WORD).map(word_of));
        }
        Self { width: grid.width, height: grid.height, columns, words, outside: 0 }
    }

    /// The same as a grid.
    pub fn grid(&self) -> Grid<bool> {
        let mut cells = vec![false; self.width * self.height];
        let rows = self.words.chunks_exact(self.columns.max(1));
        for (row, words) in cells.chunks_exact_mut(self.width.max(1)).zip(rows) {
            for (cells, word) in row.chunks_mut(WORD).zip(words) {
                for (cells, byte) in cells.chunks_mut(8).zip(word.to_le_bytes()) {
                    cells.copy_from_slice(&CELLS[usize::from(byte)][..cells.len()]);
                }
            }
        }
        Grid { width: self.width, height: self.height, cells }
    }

    /// True and false exchanged, outside too.
    fn inverted(mut self) -> Self {
        self.words.iter_mut().for_each(|word| *word = !*word);
        self.outside = !self.outside;
        self
    }

    /// The cells farther than `radius` from every false one.
    pub fn eroded(self, radius: f64) -> Self {
        self.inverted().dilated(radius).inverted()
    }

    /// The cells whose centre lies within `radius` of a true cell's. A disc is a heap of horizontal bars that get shorter from
    /// its middle row outwards, and a long bar is a shorter one drawn out: so each row is drawn out by what the bar of the
    /// next row is shorter, joined with the two rows that are one farther, and so on outwards.
    pub fn dilated(&self, radius: f64) -> Self {
        let reach = (radius.max(0.0) as usize).min(self.height);
        let bar = |rise: usize| (radius * radius - (rise * rise) as f64).max(0.0).sqrt() as usize;
        let bars: Vec<usize> = (0..=reach).map(|rise| bar(rise).min(self.width)).collect();
        let mut words = Vec::with_capacity(self.words.len());
        // a word of what is outside on either side
        let mut row = vec![self.outside; self.columns + 2];
        let mut other = row.clone();
        for y in 0..self.height {
            row[1..=self.columns].copy_from_slice(self.row(y));
            for rise in 0..=reach {
                if rise > 0 {
                    self.join(&mut row[1..=self.columns], y.checked_sub(rise));
                    self.join(&mut row[1..=self.columns], Some(y + rise));
                }
                for _ in bars.get(rise + 1).copied().unwrap_or(0)..bars[rise] {
                    draw_out(&row, &mut other);
                    std::mem::swap(&mut row, &mut other);
                }
            }
            self.mend_end(&mut row[1..=self.columns]);
            words.extend_from_slice(&row[1..=self.columns]);
        }
        Self { words, ..*self }
    }

    fn row(&self, y: usize) -> &[u64] {
        &self.words[y * self.columns..(y + 1) * self.columns]
    }

    /// Adds a row's true cells to others.
    fn join(&self, row: &mut [u64], y: Option<usize>) {
        match y.filter(|&y| y < self.height) {
            Some(y) => row.iter_mut().zip(self.row(y)).for_each(|(word, other)| *word |= other),
            None => row.iter_mut().for_each(|word| *word |= self.outside),
        }
    }

    /// Gives the bits beyond the end of a row the value of what is outside.
    fn mend_end(&self, row: &mut [u64]) {
        let used = self.width % WORD;
        if let Some(last) = row.last_mut().filter(|_| used > 0) {
            let beyond = u64::MAX << used;
            *last = (*last & !beyond) | (self.outside & beyond);
        }
    }

    /// The runs of true cells, row by row from the left, where outside is false.
    pub fn runs(&self) -> Vec<Run> {
        let mut runs = Vec::new();
        for (row, words) in self.words.chunks_exact(self.columns.max(1)).enumerate() {
            let mut start = None;
            for (column, &word) in words.iter().enumerate() {
                let before = if start.is_some() { 1 } else { 0 };
                // where a cell differs from its left neighbour
                let mut turns = word ^ (word << 1 | before);
                while turns != 0 {
                    let x = column * WORD + turns.trailing_zeros() as usize;
                    match start.take() {
                        Some(start) => runs.push(Run { row, start, end: x }),
                        None => start = Some(x),
                    }
                    turns &= turns - 1;
                }
            }
            runs.extend(start.map(|start| Run { row, start, end: self.width }));
        }
        runs
    }
}

/// Adds the cells beside the true ones of a row; its outermost words stay.
fn draw_out(from: &[u64], to: &mut [u64]) {
    for (to, words) in to[1..].iter_mut().zip(from.windows(3)) {
        let (before, here, after) = (words[0], words[1], words[2]);
        *to = here | (here << 1 | before >> (WORD - 1)) | (here >> 1 | after << (WORD - 1));
    }
}

/// The bits of up to 64 cells.
fn word_of(cells: &[bool]) -> u64 {
    let (eights, rest) = cells.as_chunks::<8>();
    let mut last = [false; 8];
    last[..rest.len()].copy_from_slice(rest);
    let word = eights.iter().rev().fold(0, |word, eight| word << 8 | byte_of(eight));
    if rest.is_empty() { word } else { word | byte_of(&last) << (8 * eights.len()) }
}

fn byte_of(cells: &[bool; 8]) -> u64 {
    // gathers the lowest bits of the eight bytes in the highest byte
    u64::from_le_bytes(cells.map(u8::from)).wrapping_mul(0x0102_0408_1020_4080) >> 56
}

const fn cells_of_bytes() -> [[bool; 8]; 256] {
    let mut cells = [[false; 8]; 256];
    let mut byte = 0;
    while byte < 256 {
        let mut bit = 0;
        while bit < 8 {
            cells[byte][bit] = byte >> bit & 1 == 1;
            bit += 1;
        }
        byte += 1;
    }
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_hold_the_cells_and_their_runs() {
        for width in [1, 63, 64, 65, 130] {
            let cells = (0..width * 3).map(|i| i * i % 7 < 3 || i % width == width - 1).collect();
            let grid = Grid { width, height: 3, cells };
            let bits = Bits::of(&grid);
            assert_eq!(bits.grid(), grid);
            let mut drawn = grid.map(|_| false);
            for run in bits.runs() {
                let start = run.row * width;
                assert!(run.start == 0 || !grid.at(run.start - 1, run.row));
                drawn.cells[start + run.start..start + run.end].fill(true);
            }
            assert_eq!(drawn, grid);
        }
    }
}
