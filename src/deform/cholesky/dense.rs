//! Dense arithmetic on tiles of 4 x 4 numbers. A panel is kept in strips of four rows, each strip column by column, so that
//! the one inner loop, a tile's product of two strips, reads both in order. Products and sums are separate operations in a
//! fixed order: the compiler makes pairs of lanes of them and no more, hence equal bits on every processor.

/// Four rows of one column.
pub type Quad = [f64; 4];

/// Rows and columns of a tile.
pub const TILE: usize = 4;

/// The next multiple of the tile.
pub const fn padded(size: usize) -> usize {
    size.div_ceil(TILE) * TILE
}

/// A tile by columns: the product of one strip with another transposed, over their common columns.
fn product(rows: &[Quad], columns: &[Quad]) -> [Quad; TILE] {
    let mut sum = [[0.0; TILE]; TILE];
    for (a, b) in rows.iter().zip(columns) {
        for j in 0..TILE {
            for i in 0..TILE {
                sum[j][i] += a[i] * b[j];
            }
        }
    }
    sum
}

/// Subtracts the product of two strips from a tile.
fn subtract(tile: &mut [Quad], rows: &[Quad], columns: &[Quad]) {
    let product = product(rows, columns);
    for (column, sum) in tile.iter_mut().zip(&product) {
        for i in 0..TILE {
            column[i] -= sum[i];
        }
    }
}

/// Cholesky's factor of a tile in its lower triangle; false when it is not positive definite.
fn factor_tile(tile: &mut [Quad]) -> bool {
    for j in 0..TILE {
        for k in 0..j {
            let factor = tile[k][j];
            for i in j..TILE {
                tile[j][i] -= tile[k][i] * factor;
            }
        }
        // Also false for NaN; infinity is kept out so that garbage does not pass for a factor.
        if !(tile[j][j] > 0.0 && tile[j][j] < f64::INFINITY) {
            return false;
        }
        let root = tile[j][j].sqrt();
        tile[j][j] = root;
        for i in j + 1..TILE {
            tile[j][i] /= root;
        }
    }
    true
}

/// Solves X T' = tile for X, T the lower triangle of a factored tile.
fn divide(tile: &mut [Quad], factored: &[Quad]) {
    for j in 0..TILE {
        for k in 0..j {
            let factor = factored[k][j];
            for i in 0..TILE {
                tile[j][i] -= tile[k][i] * factor;
            }
        }
        let root = factored[j][j];
        for i in 0..TILE {
            tile[j][i] /= root;
        }
    }
}

/// Factors the first `width` columns of a panel whose first `width` rows are its own; false when they are not positive
/// definite. `width` is a multiple of the tile.
pub fn factor_panel(panel: &mut [Quad], width: usize) -> bool {
    let mut pivot = vec![[0.0; TILE]; width];
    for first in (0..width).step_by(TILE) {
        let last = first + TILE;
        for (number, strip) in panel.chunks_exact_mut(width).enumerate().skip(first / TILE) {
            let (done, rest) = strip.split_at_mut(first);
            if number * TILE == first {
                pivot[..first].copy_from_slice(done);
                subtract(&mut rest[..TILE], done, &pivot[..first]);
                if !factor_tile(&mut rest[..TILE]) {
                    return false;
                }
                pivot[first..last].copy_from_slice(&rest[..TILE]);
            } else {
                subtract(&mut rest[..TILE], done, &pivot[..first]);
                divide(&mut rest[..TILE], &pivot[first..last]);
            }
        }
    }
    true
}

/// Where strip `i` of a lower triangle of tiles starts.
pub const fn triangle_start(i: usize) -> usize {
    i * (i + 1) / 2 * TILE
}

/// Subtracts L L' from a lower triangle of tiles, L the strips of a factored panel below its own rows.
pub fn update_triangle(triangle: &mut [Quad], below: &[Quad], width: usize) {
    for (i, rows) in below.chunks_exact(width).enumerate() {
        let strip = &mut triangle[triangle_start(i)..triangle_start(i + 1)];
        for (tile, columns) in strip.chunks_exact_mut(TILE).zip(below.chunks_exact(width)) {
            subtract(tile, rows, columns);
        }
    }
}

/// Solves L y = x for the panel's own rows in place, and gives L y for the rows below.
pub fn forward(panel: &[Quad], width: usize, own: &mut [f64]) -> Vec<f64> {
    let mut below = Vec::with_capacity(panel.len() / width.max(1) * TILE);
    for (number, strip) in panel.chunks_exact(width.max(1)).enumerate() {
        let first = number * TILE;
        let mut sum = [0.0; TILE];
        for (quad, y) in strip.iter().zip(&own[..first.min(width)]) {
            for i in 0..TILE {
                sum[i] += quad[i] * y;
            }
        }
        if first >= width {
            below.extend_from_slice(&sum);
            continue;
        }
        for j in 0..TILE {
            let column = &strip[first + j];
            let y = (own[first + j] - sum[j]) / column[j];
            own[first + j] = y;
            for i in j + 1..TILE {
                sum[i] += column[i] * y;
            }
        }
    }
    below
}

/// Solves L' x = y for the panel's own rows in place, given x of the rows below.
pub fn backward(panel: &[Quad], width: usize, own: &mut [f64], below: &[f64]) {
    if width == 0 {
        return;
    }
    let (square, rest) = panel.split_at(width / TILE * width);
    for (strip, x) in rest.chunks_exact(width).zip(below.chunks_exact(TILE)) {
        subtract_strip(strip, x, own);
    }
    for (number, strip) in square.chunks_exact(width).enumerate().rev() {
        let first = number * TILE;
        for j in (0..TILE).rev() {
            let column = &strip[first + j];
            let known: f64 = (j + 1..TILE).map(|i| column[i] * own[first + i]).sum();
            own[first + j] = (own[first + j] - known) / column[j];
        }
        let (before, x) = own.split_at_mut(first);
        subtract_strip(strip, x, before);
    }
}

/// Subtracts from each of `targets` the product of its column in a strip with four numbers.
fn subtract_strip(strip: &[Quad], x: &[f64], targets: &mut [f64]) {
    for (quad, target) in strip.iter().zip(targets) {
        *target -= (quad[0] * x[0] + quad[1] * x[1]) + (quad[2] * x[2] + quad[3] * x[3]);
    }
}
