//! The mean year of a latitude: temperature and humidity as sines of the day of the year.
//!
//! Judged, from the zonal means of land in textbooks of climatology: the mean falls with the square of the latitude, the yearly
//! swing grows with it, and the year lags the sun by four weeks. Within 3 K of the yearly means of Harvard Forest (7.5 °C), Proctor (6 °C) and
//! Greensboro (15 °C); the sea's mildness is not in it. A series is better.

use super::day_length;
use super::weather::Day;
use crate::base::maths::cos;

/// Mean of the year at the equator, °C, and its fall with the square of the latitude, K per square degree.
const EQUATOR: f64 = 27.0;
const FALL: f64 = 0.0098;
/// Half the swing between the warmest and the coldest day, K per degree of latitude.
const SWING: f64 = 0.29;
/// The coldest day of the north, day of the year.
const COLDEST: f64 = 20.0;
/// Relative humidity in the mean, and by how much winter is damper.
const HUMIDITY: f64 = 0.72;
const HUMIDITY_SWING: f64 = 0.05;

/// The weather of a day of the year at a latitude in degrees; `humidity` stands before the mean year's own.
#[must_use]
pub(super) fn day(latitude: f64, day_of_year: f64, humidity: Option<f64>) -> Day {
    let half_a_year = if latitude < 0.0 { 182.625 } else { 0.0 };
    let winter = cos(std::f64::consts::TAU * (day_of_year - COLDEST - half_a_year) / 365.25);
    Day {
        temperature: EQUATOR - FALL * latitude * latitude - SWING * latitude.abs() * winter,
        humidity: humidity.unwrap_or(HUMIDITY + HUMIDITY_SWING * winter),
        day_length: Some(day_length::hours(latitude, day_of_year)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_have_the_means_that_were_measured() {
        for (latitude, measured) in [(42.54, 7.5), (44.5, 6.0), (36.1, 15.0)] {
            let days = (1..=365).map(|d| day(latitude, f64::from(d), None).temperature);
            assert!((days.sum::<f64>() / 365.0 - measured).abs() < 3.0, "{latitude}");
        }
    }

    #[test]
    fn the_souths_winter_is_the_norths_summer() {
        let north = day(45.0, 202.0, None).temperature;
        assert!((day(-45.0, 202.0 - 182.625, None).temperature - north).abs() < 1e-9);
        assert!(north > day(45.0, 20.0, None).temperature + 20.0);
    }
}
