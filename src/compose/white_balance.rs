//! White balance: the map of linear sRGB that makes light of a colour temperature neutral.

use crate::base::vector::{DMat3, DVec3};
use crate::frame::UNBALANCED;

/// The colour temperature that sRGB takes for neutral (CIE illuminant D65), kelvin.
const NEUTRAL: f64 = 6504.0;

/// CIE XYZ of linear sRGB (IEC 61966-2-1).
fn xyz_of_srgb() -> DMat3 {
    DMat3::new(
        0.412_390_8,
        0.357_584_3,
        0.180_480_8, //
        0.212_639_0,
        0.715_168_7,
        0.072_192_3, //
        0.019_330_8,
        0.119_194_8,
        0.950_532_2,
    )
}

/// Cone responses of CIE XYZ (Bradford; Lam 1985).
fn bradford() -> DMat3 {
    DMat3::new(
        0.8951, 0.2664, -0.1614, //
        -0.7502, 1.7135, 0.0367, //
        0.0389, -0.0685, 1.0296,
    )
}

/// CIE XYZ, with luminance 1, of light of a colour temperature in kelvin: daylight from 4000 K (CIE 15), a black body below
/// (Kim et al. 2002). Clamped to 1667 to 25,000 K, where the formulae end.
fn white(kelvin: f64) -> DVec3 {
    let t = 1000.0 / kelvin.clamp(1667.0, 25_000.0);
    let (t2, t3) = (t * t, t * t * t);
    let (x, y) = if t <= 0.25 {
        let x = if t >= 1.0 / 7.0 {
            0.244_063 + 0.099_11 * t + 2.967_8 * t2 - 4.607_0 * t3
        } else {
            0.237_040 + 0.247_48 * t + 1.901_8 * t2 - 2.006_4 * t3
        };
        (x, -3.0 * x * x + 2.870 * x - 0.275)
    } else {
        let x = -0.266_123_9 * t3 - 0.234_358_9 * t2 + 0.877_695_6 * t + 0.179_910;
        let (x2, x3) = (x * x, x * x * x);
        let y = if t >= 1.0 / 2.222 {
            -1.106_381_4 * x3 - 1.348_110_2 * x2 + 2.185_558_32 * x - 0.202_196_83
        } else {
            -0.954_947_6 * x3 - 1.374_185_93 * x2 + 2.091_370_15 * x - 0.167_488_67
        };
        (x, y)
    };
    DVec3::new(x / y, 1.0, (1.0 - x - y) / y)
}

/// Linear sRGB, of luminance 1, of light of a colour temperature in kelvin.
pub(super) fn colour(kelvin: f64) -> [f64; 3] {
    let inverse = xyz_of_srgb().try_inverse().unwrap_or_else(DMat3::identity);
    (inverse * white(kelvin)).into()
}

/// The rows of the map for light of a colour temperature in kelvin; none changes nothing.
pub(super) fn balance(kelvin: Option<f64>) -> [[f32; 3]; 3] {
    let Some(kelvin) = kelvin else { return UNBALANCED };
    let cones = bradford() * xyz_of_srgb();
    let (from, to) = (bradford() * white(kelvin), bradford() * white(NEUTRAL));
    let gains = DMat3::from_diagonal(&to.component_div(&from));
    let Some(inverse) = cones.try_inverse() else { return UNBALANCED };
    let map = inverse * gains * cones;
    std::array::from_fn(|row| std::array::from_fn(|column| map[(row, column)] as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_of_the_temperature_becomes_neutral() {
        for kelvin in [2500.0, 3200.0, 4500.0, 5500.0, 8000.0, 15_000.0] {
            let light = colour(kelvin);
            let map = balance(Some(kelvin));
            let shown = map.map(|row| (0..3).map(|k| f64::from(row[k]) * light[k]).sum::<f64>());
            assert!((shown[0] / shown[1] - 1.0).abs() < 3e-3 && (shown[2] / shown[1] - 1.0).abs() < 3e-3, "{shown:?}");
        }
    }

    #[test]
    fn warm_light_is_red_cold_light_blue_and_neutral_changes_nothing() {
        let [warm, cold] = [3000.0, 12_000.0].map(colour);
        assert!(warm[0] > warm[1] && warm[1] > warm[2] && cold[2] > cold[1] && cold[1] > cold[0]);
        assert_eq!(balance(None), UNBALANCED);
        let map = balance(Some(NEUTRAL));
        for (row, expected) in map.iter().zip(UNBALANCED) {
            assert!((0..3).all(|k| (row[k] - expected[k]).abs() < 2e-3), "{map:?}");
        }
    }

    #[test]
    fn daylight_has_the_chromaticity_of_its_standard() {
        // CIE D65 and illuminant A.
        for (kelvin, x, y) in [(6504.0, 0.312_7, 0.329_0), (2856.0, 0.447_6, 0.407_4)] {
            let xyz = white(kelvin);
            let sum = xyz.sum();
            assert!((xyz.x / sum - x).abs() < 1e-3 && (xyz.y / sum - y).abs() < 1e-3, "{kelvin}");
        }
    }
}
