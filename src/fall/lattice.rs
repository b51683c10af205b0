//! The middles of cells that lie below a triangle.

/// Rim of a triangle, in its own coordinates, that is taken along: a point on a shared edge is not lost to rounding.
const RIM: f32 = 1e-4;

/// Rounds places below 2^22 to the nearest whole number by the lowest bits of their sum with this.
const ROUNDING: f32 = (1u32 << 23) as f32;

/// A corner of triangles over a patch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    /// Along x and z in cells, not negative.
    pub x: f32,
    pub z: f32,
    /// Metres.
    pub height: f32,
    /// Cells whose middles lie below the corner's x and z.
    column: u32,
    row: u32,
    /// Number of the cell in which it lies.
    pub cell: u32,
}

impl Corner {
    /// A corner at a place within a patch of `side` cells.
    #[inline]
    pub(super) fn new([x, height, z]: [f32; 3], side: usize) -> Self {
        let side = side as u32;
        let cells = |place: f32| ((place + ROUNDING).to_bits() & 0x3f_ffff).min(side);
        let (column, row) = (cells(x), cells(z));
        let within = |nearest: u32, place: f32| (nearest - u32::from(nearest > 0 && nearest as f32 > place)).min(side - 1);
        Self { x, z, height, column, row, cell: within(row, z) * side + within(column, x) }
    }
}

/// Visits every cell whose middle lies below a triangle, with the triangle's height there.
#[inline]
pub(super) fn below([a, b, c]: [&Corner; 3], side: usize, visit: &mut impl FnMut(u32, f32)) {
    let (left, right) = (a.column.min(b.column).min(c.column), a.column.max(b.column).max(c.column));
    let (near, far) = (a.row.min(b.row).min(c.row), a.row.max(b.row).max(c.row));
    // most triangles are smaller than cells, and lie between middles
    if left == right || near == far {
        return;
    }
    let (ux, uz, vx, vz) = (b.x - a.x, b.z - a.z, c.x - a.x, c.z - a.z);
    let area = ux * vz - uz * vx;
    if area.abs() < 1e-6 {
        return;
    }
    let inverse = 1.0 / area;
    let (ux, uz, vx, vz) = (ux * inverse, uz * inverse, vx * inverse, vz * inverse);
    let (rise_u, rise_v) = (b.height - a.height, c.height - a.height);
    let x = left as f32 + 0.5 - a.x;
    let (mut z, mut row) = (near as f32 + 0.5 - a.z, near);
    while row < far {
        let (mut u, mut v) = (x * vz - z * vx, z * ux - x * uz);
        let mut column = left;
        while column < right {
            if u >= -RIM && v >= -RIM && u + v <= 1.0 + RIM {
                visit(row * side as u32 + column, a.height + u * rise_u + v * rise_v);
            }
            (u, v, column) = (u + vz, v - uz, column + 1);
        }
        (z, row) = (z + 1.0, row + 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_below_a_square_is_met_at_its_height() {
        let height = |x: f32, z: f32| 0.01 + 0.002 * x - 0.003 * z;
        let corner = |x: f32, z: f32| Corner::new([x, height(x, z), z], 12);
        let [a, b, c, d] = [corner(1.2, 2.1), corner(9.3, 2.1), corner(9.3, 7.8), corner(1.2, 7.8)];
        let mut met = vec![0; 144];
        for triangle in [[&a, &b, &c], [&a, &c, &d]] {
            below(triangle, 12, &mut |cell, found| {
                let cell = cell as usize;
                met[cell] += 1;
                let (x, z) = ((cell % 12) as f32 + 0.5, (cell / 12) as f32 + 0.5);
                assert!((found - height(x, z)).abs() < 1e-5);
            });
        }
        for (cell, met) in met.into_iter().enumerate() {
            let inside = (1..9).contains(&(cell % 12)) && (2..8).contains(&(cell / 12));
            // 8.5 and 7.5 are within, 9.5 is not; the diagonal may be met twice
            assert_eq!(met > 0, inside, "{cell}");
        }
    }
}
