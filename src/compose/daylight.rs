//! The light of a day: what reaches the ground of the sun through air, ozone and haze, the clear sky around it, and the
//! overcast sky. The unit of irradiance is a quarter of the sun's above the air, so 1 is 33,275 lx.

use super::hosek_wilkie::{clear_sky, radiance};
use super::white_balance;
use crate::base::maths::{cos, exp, pow, sin, sincos};
use crate::frame::ClearSky;
use std::f64::consts::{PI, TAU};

/// Irradiance of the sun above the air.
const SOLAR: f64 = 4.0;
/// Illuminance of the sun above the air, lux (Darula, Kittler and Gueymard 2005).
const SOLAR_LUX: f64 = 133_100.0;
/// Lux of one unit of irradiance, and cd/m2 of one of radiance.
pub(super) const LUX: f64 = SOLAR_LUX / SOLAR;
/// Colour temperature of the sun above the air, kelvin (solar spectrum ASTM E490).
const SOLAR_KELVIN: f64 = 5900.0;
/// Wavelengths that stand for red, green and blue, micrometres (judged: centroids of the sRGB primaries in daylight).
const WAVELENGTHS: [f64; 3] = [0.610, 0.550, 0.465];
/// Absorption of ozone at these wavelengths, 1/cm, and its usual depth, cm (Preetham et al. 1999, table of k_o).
const OZONE: [f64; 3] = [0.115, 0.085, 0.008];
const OZONE_DEPTH: f64 = 0.35;
/// Luminance of one unit of the sky's formula, cd/m2: the efficacy of light at 555 nm.
const EFFICACY: f64 = 683.0;
/// Factors on the formula's channels. Its RGB fit lies on the green side of the CIE daylight locus, by 0.008 to 0.010 in CIE
/// 1960 uv from 45 to 85 degrees off the zenith at turbidities of 2 to 4; these halve it and leave the zenith blue.
const ONTO_LOCUS: [f64; 3] = [1.12, 0.97, 1.00];
/// Albedo of the land around, for the light that it sends back to the sky.
const LAND: [f64; 3] = [0.10, 0.12, 0.05];
/// Colour of an overcast sky (about 6800 K).
const OVERCAST: [f64; 3] = [0.975, 1.0, 1.055];

/// Rec. 709 luminance.
pub(super) fn luminance([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// Relative length of the sun's path through the air (Kasten and Young 1989), for an elevation in degrees.
pub(super) fn air_mass(elevation: f64) -> f64 {
    1.0 / (sin(elevation.to_radians()) + 0.505_72 * pow(elevation + 6.079_95, -1.6364))
}

/// Share of the sun's light that the air lets through, for an elevation in degrees and a turbidity: Rayleigh scattering,
/// Angstrom's law for haze, ozone (Preetham, Shirley and Smits 1999, appendix A.1).
fn transmittance(elevation: f64, turbidity: f64) -> [f64; 3] {
    let mass = air_mass(elevation.max(0.0));
    let haze = (0.046_08 * turbidity - 0.045_86).max(0.0);
    std::array::from_fn(|k| {
        let wavelength = WAVELENGTHS[k];
        let rayleigh = 0.008_735 * pow(wavelength, -4.08);
        exp(-mass * (rayleigh + haze * pow(wavelength, -1.3) + OZONE[k] * OZONE_DEPTH))
    })
}

/// The sun's irradiance on a surface that faces it, under a clear sky.
pub(super) fn sunlight(elevation: f64, turbidity: f64) -> [f64; 3] {
    let colour = white_balance::colour(SOLAR_KELVIN);
    let passed = transmittance(elevation, turbidity);
    std::array::from_fn(|k| SOLAR * colour[k] * passed[k])
}

/// Share of the daylight that remains with the sun below the horizon: a tenth every 2.9 degrees, as in civil twilight (from
/// 400 lx at sunset to 3.4 lx at 6 degrees).
fn twilight(elevation: f64) -> f64 {
    pow(10.0, 0.345 * elevation.min(0.0))
}

/// The clear sky for a sun at this elevation, degrees.
pub(super) fn clear(elevation: f64, turbidity: f64) -> ClearSky {
    let mut sky = clear_sky(turbidity, LAND, elevation.to_radians());
    let factor = EFFICACY / LUX * twilight(elevation);
    sky.radiance = std::array::from_fn(|k| (f64::from(sky.radiance[k]) * factor * ONTO_LOCUS[k]) as f32);
    sky
}

/// Radiance of the zenith of an overcast sky (Krochmann and Seidl 1974: 123 + 8600 sin h cd/m2); its horizon has a third.
pub(super) fn overcast(elevation: f64) -> [f64; 3] {
    let zenith = (123.0 + 8600.0 * sin(elevation.to_radians()).max(0.0)) * twilight(elevation) / LUX;
    OVERCAST.map(|c| c * zenith / luminance(OVERCAST))
}

/// Irradiance of a clear sky on level ground, by the midpoint rule over 24 heights and 48 azimuths.
pub(super) fn level(sky: &ClearSky, elevation: f64) -> [f64; 3] {
    const HEIGHTS: u32 = 24;
    const AZIMUTHS: u32 = 48;
    let (sun_up, sun_along) = sincos(elevation.max(0.0).to_radians());
    let mut sum = [0.0; 3];
    for row in 0..HEIGHTS {
        // Even steps of the squared sine of the height have equal projected solid angles.
        let up = ((f64::from(row) + 0.5) / f64::from(HEIGHTS)).sqrt();
        let along = (1.0 - up * up).sqrt();
        for column in 0..AZIMUTHS {
            let azimuth = (f64::from(column) + 0.5) / f64::from(AZIMUTHS) * TAU;
            let found = radiance(sky, up, up * sun_up + along * sun_along * cos(azimuth));
            for k in 0..3 {
                sum[k] += found[k];
            }
        }
    }
    sum.map(|s| s * PI / f64::from(HEIGHTS * AZIMUTHS))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_air_mass_is_one_overhead_and_two_at_thirty_degrees() {
        assert!((air_mass(90.0) - 1.0).abs() < 1e-3);
        assert!((air_mass(30.0) - 2.0).abs() < 0.01);
        assert!((air_mass(0.0) - 38.0).abs() < 1.0);
    }

    #[test]
    fn sun_and_sky_have_the_illuminances_of_clear_days() {
        // Direct normal 85 to 105 klx at 60 degrees, 60 to 90 at 20; diffuse 8 to 18 klx (IES clear day).
        let direct = |elevation: f64| luminance(sunlight(elevation, 2.5)) * LUX;
        assert!((85e3..105e3).contains(&direct(60.0)), "{}", direct(60.0));
        assert!((45e3..90e3).contains(&direct(20.0)), "{}", direct(20.0));
        for elevation in [20.0, 40.0, 60.0] {
            let diffuse = luminance(level(&clear(elevation, 2.5), elevation)) * LUX;
            assert!((8e3..18e3).contains(&diffuse), "{elevation}: {diffuse}");
        }
    }

    #[test]
    fn the_sky_s_colours_are_those_of_daylight() {
        for (turbidity, elevation, zenith, sun) in
            [(2.0, 40.0, 70.0, 90.0), (2.5, 40.0, 85.0, 120.0), (2.5, 20.0, 70.0, 90.0), (4.0, 40.0, 85.0, 120.0)]
        {
            let of = |degrees: f64| cos(f64::to_radians(degrees));
            let found = radiance(&clear(elevation, turbidity), of(zenith), of(sun));
            let offset = (60..250).map(|hundreds| {
                let light = white_balance::colour(f64::from(hundreds) * 100.0);
                let [a, b] = [found, light].map(uv);
                libm::hypot(a[0] - b[0], a[1] - b[1])
            });
            let nearest = offset.fold(f64::INFINITY, f64::min);
            assert!(nearest < 0.005, "{turbidity} {elevation} {zenith}: {nearest} off the daylight locus");
        }
    }

    /// CIE 1960 chromaticity of linear sRGB.
    fn uv([r, g, b]: [f64; 3]) -> [f64; 2] {
        let x = 0.4124 * r + 0.3576 * g + 0.1805 * b;
        let y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        let z = 0.0193 * r + 0.1192 * g + 0.9505 * b;
        let scale = x + 15.0 * y + 3.0 * z;
        [4.0 * x / scale, 6.0 * y / scale]
    }

    #[test]
    fn an_overcast_sky_has_its_standard_illuminance() {
        // 7/9 pi of the zenith's luminance: 300 + 21,000 sin h lx.
        for elevation in [10.0f64, 40.0, 70.0] {
            let expected = 300.0 + 21_000.0 * sin(elevation.to_radians());
            let found = luminance(overcast(elevation)) * LUX * 7.0 / 9.0 * PI;
            assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
        }
    }

    #[test]
    fn a_low_sun_is_dim_and_red_and_night_follows() {
        let [noon, evening] = [60.0, 4.0].map(|elevation| sunlight(elevation, 2.5));
        assert!(evening[0] / evening[2] > 3.0 * noon[0] / noon[2] && evening[1] < 0.3 * noon[1]);
        let dusk = |elevation: f64| luminance(level(&clear(elevation, 2.5), elevation));
        assert!(dusk(-6.0) < 0.01 * dusk(0.0) && dusk(-3.0) > dusk(-6.0));
    }
}
