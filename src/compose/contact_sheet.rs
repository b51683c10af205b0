//! A contact sheet: one picture of many cells; cells that differ in their seed have its number in the upper left corner.

use crate::base::picture::Picture;
use crate::scene::sheet::grid;

/// Colour of the lines between cells and of cells that stay empty.
const LINE: [u8; 4] = [245, 245, 240, 255];
/// Colour of a number, and of what lies behind it.
const INK: [u8; 4] = [245, 245, 240, 255];
const PLATE: [u8; 4] = [28, 28, 26, 255];
/// The digits, three dots wide and five high; a row's bits from the left.
const DIGITS: [[u8; 5]; 10] = [
    [0b111, 0b101, 0b101, 0b101, 0b111],
    [0b010, 0b110, 0b010, 0b010, 0b111],
    [0b111, 0b001, 0b111, 0b100, 0b111],
    [0b111, 0b001, 0b111, 0b001, 0b111],
    [0b101, 0b101, 0b111, 0b001, 0b001],
    [0b111, 0b100, 0b111, 0b001, 0b111],
    [0b111, 0b100, 0b111, 0b101, 0b111],
    [0b111, 0b001, 0b010, 0b010, 0b010],
    [0b111, 0b101, 0b111, 0b101, 0b111],
    [0b111, 0b101, 0b111, 0b001, 0b111],
];
/// Dots from the left of one digit to that of the next.
const ADVANCE: u32 = 4;
/// Dots of a digit's height.
const HEIGHT: u32 = 5;
/// Height of a number relative to its cell's.
const RELATIVE_HEIGHT: u32 = 16;

/// The cells of a sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sheet {
    width: u32,
    height: u32,
    columns: u32,
    rows: u32,
    /// Pixels of a line between cells.
    line: u32,
}

impl Sheet {
    /// A sheet of so many pixels with `count` cells in a grid that is as square as can be.
    #[must_use]
    pub fn new(width: u32, height: u32, count: usize) -> Self {
        Self::in_columns(width, height, count, 0)
    }

    /// The same with so many cells in a row; 0 for as square as can be.
    #[must_use]
    pub fn in_columns(width: u32, height: u32, count: usize, columns: u32) -> Self {
        let [columns, rows] = grid(count, columns);
        // A line may not take a cell's last pixel.
        let line = (height / 360).max(1).min(width / columns / 4).min(height / rows / 4);
        Self { width, height, columns, rows, line }
    }

    /// A cell's left and upper edge, width and height in pixels; each side is at least one.
    #[must_use]
    pub fn cell(&self, number: usize) -> [u32; 4] {
        let number = number as u32;
        let part = |index: u32, count: u32, all: u32| {
            let edge = |index: u32| (u64::from(all) * u64::from(index) / u64::from(count)) as u32;
            let (low, high) = (edge(index).min(all - 1), edge(index + 1).max(1));
            let line = if index + 1 < count { self.line } else { 0 };
            (low, high.saturating_sub(low + line).max(1))
        };
        let (left, width) = part(number % self.columns, self.columns, self.width);
        let (top, height) = part(number / self.columns, self.rows, self.height);
        [left, top, width, height]
    }

    /// Lays pictures into their cells, with their seeds if given.
    #[must_use]
    pub fn assemble(&self, cells: &[(Option<u64>, Picture)]) -> Picture {
        let mut sheet = Picture::filled(self.width, self.height, LINE);
        for (number, (seed, picture)) in cells.iter().enumerate() {
            let [left, top, width, height] = self.cell(number);
            for y in 0..picture.height.min(height) {
                for x in 0..picture.width.min(width) {
                    set(&mut sheet, [left + x, top + y], picture.at(x, y));
                }
            }
            // Numbers are of one size, though cells differ by a pixel.
            let dot = (self.height / self.rows / RELATIVE_HEIGHT / HEIGHT).max(1);
            if let Some(seed) = seed {
                label(&mut sheet, [left, top, width, height], dot, *seed);
            }
        }
        sheet
    }
}

fn set(picture: &mut Picture, [x, y]: [u32; 2], colour: [u8; 4]) {
    picture.pixels[y as usize * picture.width as usize + x as usize] = colour;
}

/// Writes a number on a plate in the corner of a cell, its dots so many pixels wide, or fewer where it would not fit.
fn label(sheet: &mut Picture, [left, top, width, height]: [u32; 4], dot: u32, number: u64) {
    let text = number.to_string();
    let wide = text.len() as u32 * ADVANCE + 1;
    let tall = HEIGHT + 2;
    let dot = dot.min(width / wide).min(height / tall);
    for (y, x) in (0..tall * dot).flat_map(|y| (0..wide * dot).map(move |x| (y, x))) {
        set(sheet, [left + x, top + y], PLATE);
    }
    for (place, digit) in text.bytes().enumerate() {
        let rows = DIGITS[usize::from(digit - b'0')];
        for (row, column) in (0..HEIGHT).flat_map(|row| (0..3u32).map(move |column| (row, column))) {
            if rows[row as usize] >> (2 - column) & 1 == 0 {
                continue;
            }
            let (x, y) = ((1 + place as u32 * ADVANCE + column) * dot, (1 + row) * dot);
            for (dy, dx) in (0..dot).flat_map(|dy| (0..dot).map(move |dx| (dy, dx))) {
                set(sheet, [left + x + dx, top + y + dy], INK);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn cells_lie_in_the_sheet_and_apart(width in 1u32..400, height in 1u32..300, count in 1usize..40) {
            let sheet = Sheet::new(width, height, count);
            let mut covered = vec![0u32; (width * height) as usize];
            for number in 0..count {
                let [left, top, w, h] = sheet.cell(number);
                prop_assert!(w >= 1 && h >= 1 && left + w <= width && top + h <= height);
                for (y, x) in (top..top + h).flat_map(|y| (left..left + w).map(move |x| (y, x))) {
                    covered[(y * width + x) as usize] += 1;
                }
            }
            let fits = width >= sheet.columns && height >= sheet.rows;
            prop_assert!(!fits || covered.iter().all(|&count| count <= 1));
        }

        #[test]
        fn any_seed_is_written_into_any_cell(width in 1u32..200, height in 1u32..100, seed: u64) {
            let cell = Picture::filled(width, height, [1, 2, 3, 255]);
            let sheet = Sheet::new(width, height, 1).assemble(&[(Some(seed), cell)]);
            prop_assert_eq!(sheet.pixels.len(), (width * height) as usize);
        }
    }

    #[test]
    fn grids_are_nearly_square() {
        let grid = |count| {
            let Sheet { columns, rows, .. } = Sheet::new(800, 600, count);
            (columns, rows)
        };
        let Sheet { columns, rows, .. } = Sheet::in_columns(800, 600, 66, 6);
        assert_eq!((columns, rows), (6, 11));
        let found: Vec<(u32, u32)> = [1, 2, 3, 4, 5, 9, 10, 12].map(grid).into();
        assert_eq!(found, [(1, 1), (2, 1), (2, 2), (2, 2), (3, 2), (3, 3), (4, 3), (4, 3)]);
    }

    /// The number read back from the dots.
    #[test]
    fn numbers_can_be_read() {
        let sheet =
            Sheet::new(240, 160, 1).assemble(&[(Some(1_234_567_890), Picture::filled(240, 160, [0, 0, 0, 255]))]);
        let dot = 160 / RELATIVE_HEIGHT / HEIGHT;
        let digit = |place: u32| {
            let row = |row: u32| {
                let lit = |column: u32| sheet.at((1 + place * ADVANCE + column) * dot, (1 + row) * dot) == INK;
                (0..3).fold(0u8, |bits, column| bits << 1 | u8::from(lit(column)))
            };
            let rows: Vec<u8> = (0..HEIGHT).map(row).collect();
            DIGITS.iter().position(|digit| digit[..] == rows[..])
        };
        let read: Vec<usize> = (0..10).map(|place| digit(place).unwrap()).collect();
        assert_eq!(read, [1, 2, 3, 4, 5, 6, 7, 8, 9, 0]);
    }
}
