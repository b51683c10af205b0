//! Where the sun stands on a date, at an hour and a latitude: Spencer's series of 1971 for its declination and the equation of
//! time. Geometric places, without refraction; within half a degree, the sun's own width, of the NREL algorithm.

use crate::base::maths::{asin, atan2, cos, sin, sincos};
use std::f64::consts::{PI, TAU};

/// A place in the sky, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    /// Above the horizon.
    pub elevation: f64,
    /// From north through east.
    pub azimuth: f64,
}

/// The sun's place on a day of the year (1 is the first of January), at an hour of local mean time (universal time plus a
/// fifteenth of the longitude), at a latitude in degrees.
pub(super) fn place(day_of_year: f64, hour: f64, latitude: f64) -> Place {
    let angle = TAU * (day_of_year - 1.0 + (hour - 12.0) / 24.0) / 365.25;
    let (s1, c1) = sincos(angle);
    let (s2, c2) = sincos(2.0 * angle);
    let (s3, c3) = sincos(3.0 * angle);
    let declination =
        0.006_918 - 0.399_912 * c1 + 0.070_257 * s1 - 0.006_758 * c2 + 0.000_907 * s2 - 0.002_697 * c3 + 0.001_48 * s3;
    // Hours that a sundial is ahead of the clock.
    let ahead = 12.0 / PI * (0.000_075 + 0.001_868 * c1 - 0.032_077 * s1 - 0.014_615 * c2 - 0.040_89 * s2);
    let turned = (hour + ahead - 12.0) * PI / 12.0;
    let latitude = latitude.to_radians();
    let up = sin(latitude) * sin(declination) + cos(latitude) * cos(declination) * cos(turned);
    let east = -cos(declination) * sin(turned);
    let north = cos(latitude) * sin(declination) - sin(latitude) * cos(declination) * cos(turned);
    let azimuth = atan2(east, north).to_degrees();
    Place {
        elevation: asin(up.clamp(-1.0, 1.0)).to_degrees(),
        azimuth: if azimuth < 0.0 { azimuth + 360.0 } else { azimuth },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::calendar::Date;

    fn assert_near(found: Place, elevation: f64, azimuth: f64) {
        assert!((found.elevation - elevation).abs() < 0.6, "{found:?} {elevation} {azimuth}");
        let turn = (found.azimuth - azimuth + 540.0).rem_euclid(360.0) - 180.0;
        assert!((turn * cos(elevation.to_radians())).abs() < 0.6, "{found:?} {elevation} {azimuth}");
    }

    #[test]
    fn the_sun_stands_where_the_almanac_says() {
        // Harvard Forest, 42.54 N 72.17 W, by the NREL algorithm.
        for (day, utc, elevation, azimuth) in [
            (79.0, 12.0, 11.66, 100.98),
            (172.0, 9.0, -2.55, 54.46),
            (172.0, 17.5, 69.22, 206.29),
            (285.0, 13.0, 20.06, 121.62),
        ] {
            assert_near(place(day, utc - 72.1715 / 15.0, 42.5378), elevation, azimuth);
        }
    }

    #[test]
    fn noon_is_as_high_as_latitude_and_season_make_it() {
        // At the solstices the noon sun stands at 90 - latitude +- 23.44 degrees.
        assert!((place(172.0, 12.0, 50.0).elevation - 63.44).abs() < 0.2);
        assert!((place(355.0, 12.0, 50.0).elevation - 16.56).abs() < 0.2);
        assert!(
            place(172.0, 12.0, -35.0).azimuth.min(360.0 - place(172.0, 12.0, -35.0).azimuth) < 3.0,
            "north at noon in the south"
        );
    }

    #[test]
    fn a_whole_table_agrees() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data/climate/sun_positions.csv");
        let Ok(text) = std::fs::read_to_string(path) else { return };
        for line in text.lines().skip(1) {
            let fields: Vec<&str> = line.split(',').collect();
            let number = |k: usize| fields[k].parse::<f64>().expect("a number");
            let (date, clock) = fields[3].trim_end_matches('Z').split_once('T').expect("a moment");
            let (hours, minutes) = clock.split_once(':').expect("a clock");
            let utc = hours.parse::<f64>().expect("hours") + minutes.parse::<f64>().expect("minutes") / 60.0;
            let day = Date::parse(date).expect("a date").day_of_year() as f64;
            assert_near(place(day, utc + number(2) / 15.0, number(1)), number(4), number(5));
        }
    }
}
