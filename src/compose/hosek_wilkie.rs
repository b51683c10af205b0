//! The clear sky of Hosek and Wilkie 2012 (An Analytic Model for Full Spectral Sky-Dome Radiance, ACM TOG 31(4)) from its
//! published coefficients: a fit to path-traced skies by the sun's height, the turbidity of the air and the ground's albedo.

use crate::base::maths::{acos, cbrt, exp};
use crate::frame::ClearSky;

/// The published coefficients, a line a control point.
const DATA: &str = include_str!("hosek_wilkie.txt");
/// Control points of the quintic in the sun's height.
const POINTS: usize = 6;
/// Whole turbidities that were fitted.
const TURBIDITIES: usize = 10;
/// Coefficients and radiance of a line.
const COLUMNS: usize = 10;

/// The sky for a turbidity (1 to 10), a ground albedo of each channel (0 to 1) and a sun this high (radians, 0 to pi/2), in
/// W/m2/sr/nm: times 683 about cd/m2.
pub(super) fn clear_sky(turbidity: f64, albedo: [f64; 3], elevation: f64) -> ClearSky {
    let numbers = |line: &str| line.split_ascii_whitespace().filter_map(|number| number.parse().ok()).collect();
    let lines: Vec<Vec<f64>> = DATA.lines().filter(|line| !line.starts_with('#')).map(numbers).collect();
    let place = cbrt((elevation / std::f64::consts::FRAC_PI_2).clamp(0.0, 1.0));
    let mut sky = ClearSky { coefficients: [[0.0; 9]; 3], radiance: [0.0; 3] };
    for channel in 0..3 {
        let values = blended(&lines, channel, turbidity.clamp(1.0, TURBIDITIES as f64), albedo[channel], place);
        sky.coefficients[channel] = std::array::from_fn(|k| values[k] as f32);
        sky.radiance[channel] = values[COLUMNS - 1] as f32;
    }
    sky
}

/// The values between the two nearest turbidities and the two albedos that were fitted.
fn blended(lines: &[Vec<f64>], channel: usize, turbidity: f64, albedo: f64, place: f64) -> [f64; COLUMNS] {
    let below = (turbidity as usize).min(TURBIDITIES - 1);
    let beyond = turbidity - below as f64;
    let mut values = [0.0; COLUMNS];
    for (bright, of_albedo) in [(0, 1.0 - albedo), (1, albedo)] {
        for (step, of_turbidity) in [(0, 1.0 - beyond), (1, beyond)] {
            let first = ((channel * 2 + bright) * TURBIDITIES + below - 1 + step) * POINTS;
            for (point, weight) in bernstein(place).into_iter().enumerate() {
                let line = lines.get(first + point).map_or(&[][..], Vec::as_slice);
                for (value, &number) in values.iter_mut().zip(line) {
                    *value += of_albedo * of_turbidity * weight * number;
                }
            }
        }
    }
    values
}

/// The weights of a quintic Bezier curve's points.
fn bernstein(t: f64) -> [f64; POINTS] {
    let s = 1.0 - t;
    let (t2, s2) = (t * t, s * s);
    [s2 * s2 * s, 5.0 * s2 * s2 * t, 10.0 * s2 * s * t2, 10.0 * s2 * t2 * t, 5.0 * s * t2 * t2, t2 * t2 * t]
}

/// Radiance of each channel at an angle with this cosine from the zenith, and one with this cosine from the sun (equation 8
/// of the paper).
pub(super) fn radiance(sky: &ClearSky, cos_zenith: f64, cos_sun: f64) -> [f64; 3] {
    std::array::from_fn(|channel| {
        let [a, b, c, d, e, f, g, zenith, lobe] = sky.coefficients[channel].map(f64::from);
        let gamma = acos(cos_sun.clamp(-1.0, 1.0));
        let base = 1.0 + lobe * lobe - 2.0 * lobe * cos_sun;
        let mie = (1.0 + cos_sun * cos_sun) / (base * base.sqrt());
        let height = cos_zenith.max(0.0);
        let around = c + d * exp(e * gamma) + f * cos_sun * cos_sun + g * mie + zenith * height.sqrt();
        f64::from(sky.radiance[channel]) * (1.0 + a * exp(b / (height + 0.01))) * around
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::maths::cos;

    #[test]
    fn the_formula_meets_the_reference() {
        // From the published implementation's data, evaluated in double precision apart from this file.
        let cases: [(f64, f64, [(f64, f64, [f64; 3]); 3]); 2] = [
            (
                2.0,
                40.0,
                [
                    (0.0, 50.0, [1.687_610, 3.296_615, 6.889_766]),
                    (60.0, 50.0, [4.063_122, 7.402_160, 12.806_705]),
                    (85.0, 120.0, [11.203_869, 17.544_161, 22.012_472]),
                ],
            ),
            (
                3.5,
                10.0,
                [
                    (0.0, 80.0, [0.952_747, 1.821_804, 3.056_535]),
                    (60.0, 50.0, [4.141_086, 5.586_165, 6.883_705]),
                    (85.0, 120.0, [8.366_500, 9.971_829, 8.296_250]),
                ],
            ),
        ];
        for (turbidity, height, looks) in cases {
            let sky = clear_sky(turbidity, [0.10, 0.12, 0.05], height.to_radians());
            for (zenith, sun, expected) in looks {
                let found = radiance(&sky, cos(zenith.to_radians()), cos(sun.to_radians()));
                for k in 0..3 {
                    assert!((found[k] / expected[k] - 1.0).abs() < 1e-4, "{found:?} {expected:?}");
                }
            }
        }
    }

    #[test]
    fn every_line_of_the_data_is_whole() {
        let lines: Vec<&str> = DATA.lines().filter(|line| !line.starts_with('#')).collect();
        assert_eq!(lines.len(), 3 * 2 * TURBIDITIES * POINTS);
        assert!(lines.iter().all(|line| line.split(' ').filter(|n| n.parse::<f64>().is_ok()).count() == COLUMNS));
    }

    #[test]
    fn zenith_luminance_is_of_the_order_of_measured_ones() {
        // A clear zenith has 2 to 5 kcd/m2 with the sun at 40 degrees (CIE clear sky standards).
        let sky = clear_sky(3.0, [0.1; 3], 40f64.to_radians());
        let [r, g, b] = radiance(&sky, 1.0, cos(50f64.to_radians()));
        let luminance = 683.0 * (0.2126 * r + 0.7152 * g + 0.0722 * b);
        assert!((2000.0..5000.0).contains(&luminance), "{luminance}");
    }
}
