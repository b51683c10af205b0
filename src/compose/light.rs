//! Sun, sky and exposure of a scene.

use super::daylight::{self, LUX};
use super::sun_position;
use crate::base::calendar::Date;
use crate::base::maths::{pow, sincos, tan};
use crate::base::vector::DVec3;
use crate::frame::{ClearSky, Clouds, Sky, Sun};
use crate::scene;
use std::f64::consts::PI;

/// Exposed radiance of a white surface that lies level in sun and sky, as an incident light meter's reading sets it: about a
/// stop over mid grey at 18 %, as cameras render sunlit scenes (judged).
const WHITE: f64 = 1.7;
/// Illuminance that an incident light meter calls EV 0 at ISO 100, lux (ISO 2720 with C = 250).
const EV_ZERO: f64 = 2.5;

/// Lights and exposure.
pub(super) struct Lighting {
    pub sun: Sun,
    pub sky: Sky,
    pub exposure: f32,
}

/// The lights of a scene seen by a camera that looks along `view` (its height is ignored). `clouds` is the number of their
/// texture.
pub(super) fn lighting(settings: &scene::Light, view: DVec3, clouds: Option<u32>) -> Lighting {
    let (elevation, direction) = sun_direction(settings, view);
    let cover = settings.clouds;
    let clear = daylight::clear(elevation, settings.turbidity);
    let overcast = daylight::overcast(elevation).map(|r| r * settings.sky);
    // Clouds hide the sun the more surely the more there are; a few leave it free.
    let free = 1.0 - cover * cover * (3.0 - 2.0 * cover);
    let full = daylight::sunlight(elevation, settings.turbidity);
    let irradiance = full.map(|e| e * settings.sun * free);
    let scale = settings.sky as f32;
    let whole = ClearSky { radiance: clear.radiance.map(|r| r * scale), ..clear };
    let thinned = ClearSky { radiance: whole.radiance.map(|r| r * (1.0 - cover) as f32), ..whole };
    let diffuse = daylight::level(&thinned, elevation);
    let sine = direction.y.max(0.0);
    let level: [f64; 3] =
        std::array::from_fn(|k| irradiance[k] * met(sine) + diffuse[k] + cover * overcast[k] * PI * 7.0 / 9.0);
    let level = daylight::luminance(level);
    let sky = Sky {
        zenith: overcast.map(|r| (r * cover) as f32),
        horizon: overcast.map(|r| (r * cover / 3.0) as f32),
        clear: Some(thinned),
        clouds: clouds.map(|texture| {
            // A cloud scatters about two thirds of what meets it; its base sees little of the sun.
            let beam: [f64; 3] = std::array::from_fn(|k| full[k] * settings.sun * 0.60 / PI + 0.8 * overcast[k]);
            Clouds {
                texture,
                cover: cover as f32,
                lit: beam.map(|r| r as f32),
                shaded: std::array::from_fn(|k| (0.9 * overcast[k] + 0.10 * full[k] * settings.sun / PI) as f32),
            }
        }),
    };
    Lighting {
        sun: Sun { direction: direction.cast::<f32>(), irradiance: irradiance.map(|e| e as f32) },
        sky,
        exposure: exposure(settings, level) as f32,
    }
}

/// The share of a beam that a light meter's dome reads: what is level, and a share of what stands upright, as trees do, scaled
/// so that the two agree at 40 degrees. A low sun would burn out what faces it otherwise.
fn met(sine: f64) -> f64 {
    if sine > 0.0 { (sine + 0.7 * (1.0 - sine * sine).sqrt()) / 1.834 } else { 0.0 }
}

/// The factor on radiance: as an incident meter reads this level irradiance, or as the scene sets the exposure value.
fn exposure(settings: &scene::Light, level: f64) -> f64 {
    let read = settings.exposure_value.map_or(level, |value| EV_ZERO * pow(2.0, value) / LUX);
    if read > 0.0 { WHITE * PI / read * pow(2.0, settings.exposure) } else { 1.0 }
}

/// Elevation, degrees, and unit vector to the sun: azimuth 0 is behind the camera, 90 degrees to its right; with a date,
/// as the almanac says, north lying where the scene says.
fn sun_direction(settings: &scene::Light, view: DVec3) -> (f64, DVec3) {
    if let Some(day) = settings.date.as_deref().and_then(Date::parse) {
        let place = sun_position::place(day.day_of_year() as f64, settings.hour, settings.latitude);
        let (east, north) = sincos((place.azimuth + settings.north).to_radians());
        let (up, along) = sincos(place.elevation.to_radians());
        return (place.elevation, DVec3::new(east * along, up, -north * along));
    }
    let level = DVec3::new(view.x, 0.0, view.z).try_normalize(1e-9).unwrap_or_else(|| -DVec3::z());
    let right = level.cross(&DVec3::y());
    let (sine, cosine) = sincos(settings.sun_azimuth.to_radians());
    let (height, along) = sincos(settings.sun_elevation.to_radians());
    let direction = (right * sine - level * cosine) * along + DVec3::y() * height;
    (settings.sun_elevation, direction.normalize())
}

/// What an incident light meter shows for this level irradiance: EV at ISO 100.
#[cfg(test)]
fn exposure_value(level: f64) -> f64 {
    libm::log2(level * LUX / EV_ZERO)
}

/// A crown as the camera's fit sees it, relative to the point that the camera is turned to; metres.
pub(super) struct Circle {
    /// To the right.
    pub aside: f64,
    /// Towards the camera.
    pub towards: f64,
    /// Widest reach.
    pub radius: f64,
    /// Its foot and its highest point, above the ground that the eye is told from.
    pub foot: f64,
    pub height: f64,
}

/// The distance at which all crowns fill at most `share` of a picture of this field of view (radians, vertical) and aspect,
/// and the tilt of the camera, seen from `eye` metres up.
pub(super) fn fitted(crowns: &[Circle], eye: f64, field_of_view: f64, aspect: f64, share: f64) -> (f64, f64) {
    let half = tan(field_of_view * 0.5);
    let angles = |distance: f64| {
        let of = |crown: &Circle| {
            let gap = distance - crown.towards;
            let low = libm::atan2(crown.foot - eye, gap - crown.radius * 0.2);
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
    fn azimuth_turns_from_behind_the_camera_to_its_right() {
        let mut settings = scene::Light { sun_elevation: 0.0, sun_azimuth: 0.0, ..scene::Light::default() };
        let behind = sun_direction(&settings, -DVec3::z()).1;
        assert!((behind - DVec3::z()).norm() < 1e-6);
        settings.sun_azimuth = 90.0;
        assert!((sun_direction(&settings, -DVec3::z()).1 - DVec3::x()).norm() < 1e-6);
    }

    #[test]
    fn by_date_the_noon_sun_of_the_north_is_behind_a_camera_that_looks_north() {
        let date = Some("2017-06-21".to_owned());
        let settings = scene::Light { date, hour: 12.0, latitude: 45.0, ..scene::Light::default() };
        let (elevation, sun) = sun_direction(&settings, -DVec3::z());
        assert!((elevation - 68.4).abs() < 0.5 && sun.z > 0.3 && sun.x.abs() < 0.05, "{elevation} {sun:?}");
        let turned = scene::Light { north: 90.0, ..settings };
        assert!(sun_direction(&turned, -DVec3::z()).1.x < -0.3);
    }

    #[test]
    fn a_clear_noon_is_ev_15_and_each_step_halves_the_exposure() {
        let settings = scene::Light { sun_elevation: 60.0, ..scene::Light::default() };
        let lighting = lighting(&settings, -DVec3::z(), None);
        // The "sunny 16" rule: f/16 at 1/100 s.
        let level = WHITE * PI / f64::from(lighting.exposure);
        assert!((exposure_value(level) - 15.0).abs() < 0.5, "{}", exposure_value(level));
        let set = |value: f64| exposure(&scene::Light { exposure_value: Some(value), ..scene::Light::default() }, 1.0);
        assert!((set(14.0) / set(15.0) - 2.0).abs() < 1e-9);
        assert!((set(exposure_value(level)) / f64::from(lighting.exposure) - 1.0).abs() < 1e-5);
    }

    #[test]
    fn clouds_take_the_sun_and_even_the_sky() {
        let under = |clouds: f64| lighting(&scene::Light { clouds, ..scene::Light::default() }, -DVec3::z(), None);
        let (open, half, closed) = (under(0.0), under(0.5), under(1.0));
        assert!(half.sun.irradiance[1] < open.sun.irradiance[1] && closed.sun.irradiance[1] == 0.0);
        assert_eq!(closed.sky.zenith[1], closed.sky.horizon[1] * 3.0);
        assert!(closed.sky.clear.is_some_and(|sky| sky.radiance == [0.0; 3]));
        assert!(closed.exposure > open.exposure);
    }

    #[test]
    fn a_fitted_view_holds_the_tree() {
        let tree = Circle { aside: 0.0, towards: 0.0, radius: 3.5, foot: 0.0, height: 9.0 };
        let (distance, tilt) = fitted(&[tree], 1.6, 0.5, 16.0 / 9.0, 0.82);
        let top = tan(libm::atan2(9.0 - 1.6, distance) - tilt) / tan(0.25);
        let base = tan(libm::atan2(-1.6, distance) - tilt) / tan(0.25);
        assert!(top < 0.85 && top > 0.7, "{top}");
        assert!(base > -0.85 && base < -0.7, "{base}");
    }

    #[test]
    fn a_fitted_view_holds_every_tree_of_a_row_and_a_near_one() {
        let tree = |aside: f64, towards: f64| Circle { aside, towards, radius: 3.0, foot: 0.0, height: 8.0 };
        let row: Vec<Circle> = (-5..=5).map(|k| tree(f64::from(k) * 8.0, 0.0)).chain([tree(0.0, 30.0)]).collect();
        let (distance, _) = fitted(&row, 1.6, 0.35, 16.0 / 9.0, 0.84);
        for crown in &row {
            let edge = (crown.aside.abs() + crown.radius) / ((distance - crown.towards) * tan(0.175) * 16.0 / 9.0);
            assert!(edge <= 0.84, "{edge}");
        }
        assert!(fitted(&row[..11], 1.6, 0.35, 16.0 / 9.0, 0.84).0 <= distance);
    }
}
