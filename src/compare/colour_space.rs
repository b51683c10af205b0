//! The colour spaces of FLIP, all from and to linear sRGB with the white of D65: CIE XYZ, CIELAB, and YCxCz, a linear
//! relative of CIELAB with one achromatic and two opponent channels.

use crate::base::maths::cbrt;

/// Linear sRGB to XYZ: the primaries and white of IEC 61966-2-1.
const TO_XYZ: [[f64; 3]; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];

/// XYZ relative to the white, so that white is (1, 1, 1).
fn relative_xyz(rgb: [f32; 3]) -> [f64; 3] {
    let rgb = rgb.map(f64::from);
    TO_XYZ.map(|row| (row[0] * rgb[0] + row[1] * rgb[1] + row[2] * rgb[2]) / (row[0] + row[1] + row[2]))
}

/// Linear sRGB from XYZ relative to the white, by Cramer's rule.
fn rgb_from_relative(xyz: [f64; 3]) -> [f32; 3] {
    let relative = TO_XYZ.map(|row| row.map(|entry| entry / (row[0] + row[1] + row[2])));
    let determinant = |m: [[f64; 3]; 3]| {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    let whole = determinant(relative);
    [0, 1, 2].map(|column: usize| {
        let mut replaced = relative;
        (0..3).for_each(|row| replaced[row][column] = xyz[row]);
        (determinant(replaced) / whole) as f32
    })
}

/// YCxCz of a linear sRGB colour.
pub(super) fn ycxcz(rgb: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = relative_xyz(rgb);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)].map(|v| v as f32)
}

/// The linear sRGB colour of YCxCz, clipped to what a screen can show.
pub(super) fn rgb_from_ycxcz(ycxcz: [f32; 3]) -> [f32; 3] {
    let [luma, cx, cz] = ycxcz.map(f64::from);
    let y = (luma + 16.0) / 116.0;
    rgb_from_relative([y + cx / 500.0, y, y - cz / 200.0]).map(|v| v.clamp(0.0, 1.0))
}

/// CIELAB (CIE 15) of a linear sRGB colour with Hunt's effect: chroma counts in proportion to lightness.
pub(super) fn hunt_lab(rgb: [f32; 3]) -> [f32; 3] {
    const DELTA: f64 = 6.0 / 29.0;
    let curve = |t: f64| if t > DELTA * DELTA * DELTA { cbrt(t) } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 };
    let [x, y, z] = relative_xyz(rgb).map(curve);
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)].map(|v| v as f32)
}

/// The HyAB distance (Abasi, Tehran and Fairchild 2019): lightness by its amount, chroma by its length.
pub(super) fn hyab(p: [f32; 3], q: [f32; 3]) -> f32 {
    let [l, a, b] = [0, 1, 2].map(|i: usize| p[i] - q[i]);
    l.abs() + (a * a + b * b).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_and_black_have_no_chroma() {
        let near = |p: [f32; 3], q: [f32; 3]| p.iter().zip(q).all(|(a, b)| (a - b).abs() < 1e-4);
        assert!(near(ycxcz([1.0; 3]), [100.0, 0.0, 0.0]));
        assert!(near(ycxcz([0.0; 3]), [-16.0, 0.0, 0.0]));
        assert!(near(hunt_lab([1.0; 3]), [100.0, 0.0, 0.0]));
        assert!(near(hunt_lab([0.0; 3]), [0.0, 0.0, 0.0]));
    }

    #[test]
    fn lab_of_the_primaries_is_that_of_the_tables() {
        // CIELAB of sRGB red (D65): 53.24, 80.09, 67.20.
        let [l, a, b] = hunt_lab([1.0, 0.0, 0.0]);
        assert!((l - 53.24).abs() < 0.01);
        assert!((a / (0.01 * l) - 80.09).abs() < 0.02 && (b / (0.01 * l) - 67.20).abs() < 0.02);
    }

    #[test]
    fn ycxcz_comes_back() {
        for rgb in [[0.2, 0.5, 0.9], [1.0, 0.0, 0.0], [0.0, 0.3, 0.01]] {
            let back = rgb_from_ycxcz(ycxcz(rgb));
            assert!(rgb.iter().zip(back).all(|(a, b)| (a - b).abs() < 1e-6), "{rgb:?} {back:?}");
        }
    }
}
