//! Hours between sunrise and sunset.

use crate::base::maths::{acos, cos, sin, tan};

/// Depth of the sun's centre below the horizon at sunrise, degrees: refraction and half the sun's width.
const SUNRISE_DEPTH: f64 = 0.833;

/// The length of a day in hours at a latitude in degrees on a day of the year, by Spencer's series of 1971 for the sun's declination;
/// 0 and 24 beyond the polar circles' seasons. Against the day lengths of Daymet it is within 0.1 h.
#[must_use]
pub fn hours(latitude: f64, day_of_year: f64) -> f64 {
    let angle = std::f64::consts::TAU * (day_of_year - 1.0) / 365.25;
    let declination = 0.006_918 - 0.399_912 * cos(angle) + 0.070_257 * sin(angle) - 0.006_758 * cos(2.0 * angle)
        + 0.000_907 * sin(2.0 * angle)
        - 0.002_697 * cos(3.0 * angle)
        + 0.001_48 * sin(3.0 * angle);
    let latitude = latitude.to_radians();
    let risen = -sin(SUNRISE_DEPTH.to_radians()) / (cos(latitude) * cos(declination));
    let cosine = risen - tan(latitude) * tan(declination);
    24.0 / std::f64::consts::PI * acos(cosine.clamp(-1.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_are_as_long_as_almanacs_say() {
        // Sunrise to sunset from the NREL solar position algorithm.
        for (latitude, day, expected) in
            [(42.54, 172.0, 15.27), (42.54, 355.0, 9.09), (0.0, 80.0, 12.11), (60.0, 172.0, 18.87)]
        {
            let found = hours(latitude, day);
            assert!((found - expected).abs() < 0.06, "{latitude} on day {day}: {found}");
        }
    }

    #[test]
    fn south_mirrors_north_and_the_pole_has_its_night() {
        assert!((hours(-42.0, 355.0) - hours(42.0, 172.0)).abs() < 0.03);
        assert_eq!((hours(80.0, 355.0), hours(80.0, 172.0)), (0.0, 24.0));
    }
}
