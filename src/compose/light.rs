//! Sun, sky and exposure of a scene.

use crate::base::maths::{exp, pow, sin, sincos, tan};
use crate::base::vector::{DVec3, Vec3};
use crate::frame::{Sky, Sun};
use crate::scene;
use std::f64::consts::PI;

/// Optical depth of a clear sky overhead for red, green and blue (colour notes after Kasten and Young 1989; judged).
const DEPTH: [f64; 3] = [0.11, 0.18, 0.35];
/// Irradiance of the sun above the air; the unit of every light in a frame.
const SOLAR: f64 = 4.0;
/// Radiance of a clear zenith and horizon, relative to `SOLAR` / 4, for a high sun (judged against photographs: the sky
/// gives about a quarter of the sun's light at noon).
const ZENITH: [f64; 3] = [0.105, 0.185, 0.36];
const HORIZON: [f64; 3] = [0.34, 0.41, 0.50];
/// Displayed value of a white surface that lies level in sun and sky.
const WHITE: f64 = 1.7;

/// Lights and exposure.
pub(super) struct Lighting {
    pub sun: Sun,
    pub sky: Sky,
    pub exposure: f32,
}

/// The lights of a scene seen by a camera that looks along `view` (its height is ignored).
pub(super) fn lighting(settings: &scene::Light, view: DVec3) -> Lighting {
    let elevation = settings.sun_elevation.to_radians();
    let irradiance = DEPTH.map(|depth| settings.sun * SOLAR * exp(-depth * air_mass(settings.sun_elevation.max(0.0))));
    // A low sun lights less sky; after sunset it fades.
    let day = (sin(elevation) * 2.2 + 0.25).clamp(0.02, 1.0);
    let scaled = |radiance: [f64; 3]| radiance.map(|r| r * settings.sky * day);
    let (zenith, horizon) = (scaled(ZENITH), scaled(HORIZON));
    let level = |k: usize| irradiance[k] * sin(elevation).max(0.0) + PI * 0.5 * (zenith[k] + horizon[k]);
    let luminance = 0.2126 * level(0) + 0.7152 * level(1) + 0.0722 * level(2);
    let exposure = if luminance > 0.0 { WHITE * PI / luminance * pow(2.0, settings.exposure) } else { 1.0 };
    Lighting {
        sun: Sun { direction: sun_direction(settings, view), irradiance: irradiance.map(|e| e as f32) },
        sky: Sky { zenith: zenith.map(|r| r as f32), horizon: horizon.map(|r| r as f32) },
        exposure: exposure as f32,
    }
}

/// Unit vector to the sun: azimuth 0 is behind the camera, 90 degrees to its right.
fn sun_direction(settings: &scene::Light, view: DVec3) -> Vec3 {
    let level = DVec3::new(view.x, 0.0, view.z).try_normalize(1e-9).unwrap_or_else(|| -DVec3::z());
    let right = level.cross(&DVec3::y());
    let (sine, cosine) = sincos(settings.sun_azimuth.to_radians());
    let (height, along) = sincos(settings.sun_elevation.to_radians());
    let direction = (right * sine - level * cosine) * along + DVec3::y() * height;
    direction.normalize().cast::<f32>()
}

/// Relative length of the sun's path through the air (Kasten and Young 1989), for an elevation in degrees.
fn air_mass(elevation: f64) -> f64 {
    1.0 / (sin(elevation.to_radians()) + 0.505_72 * pow(elevation + 6.079_95, -1.6364))
}

/// A crown as the camera's fit sees it, relative to the point that the camera is turned to; metres.
pub(super) struct Circle {
    /// To the right.
    pub aside: f64,
    /// Towards the camera.
    pub towards: f64,
    /// Widest reach.
    pub radius: f64,
    /// Highest point.
    pub height: f64,
}

/// The distance at which all crowns fill at most `share` of a picture of this field of view (radians, vertical) and aspect,
/// and the tilt of the camera, seen from `eye` metres up.
pub(super) fn fitted(crowns: &[Circle], eye: f64, field_of_view: f64, aspect: f64, share: f64) -> (f64, f64) {
    let half = tan(field_of_view * 0.5);
    let angles = |distance: f64| {
        let of = |crown: &Circle| {
            let gap = distance - crown.towards;
            let low = libm::atan2(-eye, gap - crown.radius * 0.2);
            let high = libm::atan2(crown.height - eye, gap - crown.radius * 0.3);
            (low, high)
        };
        let all = crowns.iter().map(of);
        all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (l, h)| (low.min(l), high.max(h)))
    };
    let wide = |crown: &Circle, distance: f64| {
        let gap = distance - crown.towards;
        (crown.aside.abs() + crown.radius) / ((gap - crown.radius * 0.3) * half * aspect)
    };
    let fits = |distance: f64| {
        let (low, high) = angles(distance);
        let tall = tan((high - low) * 0.5) / half;
        tall <= share && crowns.iter().all(|crown| wide(crown, distance) <= share)
    };
    let (mut near, mut far) = (0.0f64, 1e5);
    for crown in crowns {
        near = near.max(crown.towards + crown.radius * 1.05 + 0.1);
    }
    for _ in 0..80 {
        let middle = 0.5 * (near + far);
        if fits(middle) { far = middle } else { near = middle }
    }
    let (low, high) = angles(far);
    (far, 0.5 * (low + high))
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
    fn azimuth_turns_from_behind_the_camera_to_its_right() {
        let mut settings = scene::Light { sun_elevation: 0.0, sun_azimuth: 0.0, ..scene::Light::default() };
        let behind = sun_direction(&settings, -DVec3::z());
        assert!((behind - Vec3::z()).norm() < 1e-6);
        settings.sun_azimuth = 90.0;
        assert!((sun_direction(&settings, -DVec3::z()) - Vec3::x()).norm() < 1e-6);
    }

    #[test]
    fn a_fitted_view_holds_the_tree() {
        let tree = Circle { aside: 0.0, towards: 0.0, radius: 3.5, height: 9.0 };
        let (distance, tilt) = fitted(&[tree], 1.6, 0.5, 16.0 / 9.0, 0.82);
        let top = tan(libm::atan2(9.0 - 1.6, distance) - tilt) / tan(0.25);
        let base = tan(libm::atan2(-1.6, distance) - tilt) / tan(0.25);
        assert!(top < 0.85 && top > 0.7, "{top}");
        assert!(base > -0.85 && base < -0.7, "{base}");
    }

    #[test]
    fn a_fitted_view_holds_every_tree_of_a_row_and_a_near_one() {
        let tree = |aside: f64, towards: f64| Circle { aside, towards, radius: 3.0, height: 8.0 };
        let row: Vec<Circle> = (-5..=5).map(|k| tree(f64::from(k) * 8.0, 0.0)).chain([tree(0.0, 30.0)]).collect();
        let (distance, _) = fitted(&row, 1.6, 0.35, 16.0 / 9.0, 0.84);
        for crown in &row {
            let edge = (crown.aside.abs() + crown.radius) / ((distance - crown.towards) * tan(0.175) * 16.0 / 9.0);
            assert!(edge <= 0.84, "{edge}");
        }
        assert!(fitted(&row[..11], 1.6, 0.35, 16.0 / 9.0, 0.84).0 <= distance);
    }
}
