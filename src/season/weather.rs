//! The weather around the trees: the same for ever, or day by day with dates.

use super::sine_year;
use crate::base::calendar::Date;
use serde::Serialize;

/// Days by which the south's growing year lags the north's.
const SOUTHERN_LAG: i64 = 183;
/// Length of a day at the equator, hours; longer ones are summer's.
const EQUINOX_HOURS: f64 = 12.0;
/// Hours about it that tell neither summer nor winter.
const EQUINOX_MARGIN: f64 = 0.4;

/// A day's weather.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Day {
    /// Mean air temperature, °C.
    pub temperature: f64,
    /// Mean relative humidity, 0 to 1.
    pub humidity: f64,
    /// Hours between sunrise and sunset, where the day has a date.
    pub day_length: Option<f64>,
}

/// The weather of all days. Without dates one day stands for all; with them days before the first and after the last are like those.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Weather {
    /// The date of day 0; none for a constant climate.
    origin: Option<Date>,
    /// The day on which `days` begin, counted from `origin`.
    first: i64,
    /// At least one.
    days: Vec<Day>,
    /// Whether the growing year is that of the southern hemisphere.
    is_south: bool,
}

impl Weather {
    /// The same weather for ever: °C, and humidity of 0 to 1.
    #[must_use]
    pub fn constant(temperature: f64, humidity: f64) -> Self {
        let days = vec![Day { temperature, humidity, day_length: None }];
        Self { origin: None, first: 0, days, is_south: false }
    }

    /// A series of days from a date on, each with its length. `latitude` tells the hemisphere; without it the days' lengths do.
    /// Nothing without days.
    #[must_use]
    pub fn series(origin: Date, days: Vec<Day>, latitude: Option<f64>) -> Option<Self> {
        let summer = |(at, day): (usize, &Day)| {
            let date = origin.plus(at as i64).day_of_year();
            let is_northern = (80..266).contains(&date);
            // About the equinoxes days are of equal length on both halves of the earth.
            let tells = day.day_length.filter(|hours| (hours - EQUINOX_HOURS).abs() > EQUINOX_MARGIN);
            tells.is_some_and(|hours| (hours > EQUINOX_HOURS) != is_northern)
        };
        let against = days.iter().enumerate().filter(|day| summer(*day)).count();
        let is_south = latitude.map_or(2 * against > days.len(), |latitude| latitude < 0.0);
        (!days.is_empty()).then_some(Self { origin: Some(origin), first: 0, days, is_south })
    }

    /// The mean year of a latitude in degrees, over and over: from one year before `origin` (a 1 January) to `last`, a day
    /// counted from it. `humidity` stands before the mean year's own.
    #[must_use]
    pub fn mean_years(latitude: f64, humidity: Option<f64>, origin: Date, last: i64) -> Self {
        let first = Date::new(origin.year() - 1, 1, 1).map_or(-365, |before| before.since(origin));
        let day = |day: i64| sine_year::day(latitude, origin.plus(day).day_of_year() as f64, humidity);
        let days = (first..=last.max(first)).map(day).collect();
        Self { origin: Some(origin), first, days, is_south: latitude < 0.0 }
    }

    /// Whether it is the same every day.
    #[must_use]
    pub fn is_constant(&self) -> bool {
        self.origin.is_none()
    }

    /// The days, from `first` on.
    #[must_use]
    pub fn days(&self) -> &[Day] {
        &self.days
    }

    /// The day on which the weather begins: 0, or below it where a year before is known.
    #[must_use]
    pub fn first(&self) -> i64 {
        self.first
    }

    /// The end of the last day; infinite in a constant climate.
    #[must_use]
    pub fn end(&self) -> f64 {
        if self.is_constant() { f64::INFINITY } else { (self.first + self.days.len() as i64) as f64 }
    }

    /// Number of the day among [`days`](Self::days) that a time lies in; the first or last for times outside.
    #[must_use]
    pub fn number(&self, day: f64) -> usize {
        // Casts of floats saturate.
        (day.floor() as i64).saturating_sub(self.first).clamp(0, self.days.len() as i64 - 1) as usize
    }

    /// The date of a day.
    #[must_use]
    pub fn date(&self, day: f64) -> Option<Date> {
        // A cast of floats saturates, and so does the sum.
        self.origin.map(|origin| origin.plus(day.floor() as i64))
    }

    /// The day of a date.
    #[must_use]
    pub fn day_of(&self, date: Date) -> Option<f64> {
        self.origin.map(|origin| date.since(origin) as f64)
    }

    /// The growing year of day number `at` of [`days`](Self::days), and how far into it the day is: 1 for 1 January of the north,
    /// and for 2 July of the south, whose year is called after the January within it.
    #[must_use]
    pub fn growing_day(&self, at: usize) -> Option<(i64, i64)> {
        let lag = if self.is_south { SOUTHERN_LAG } else { 0 };
        let date = self.origin?.plus(self.first + at as i64 + lag);
        Some((date.year(), date.day_of_year()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn date(text: &str) -> Date {
        Date::parse(text).unwrap()
    }

    fn days(latitude: f64, from: i64) -> Vec<Day> {
        (from..from + 200).map(|day| sine_year::day(latitude, day as f64, None)).collect()
    }

    #[test]
    fn the_hemisphere_is_seen_in_the_days_lengths() {
        for (latitude, is_south) in [(45.0, false), (-35.0, true)] {
            let weather = Weather::series(date("2017-08-01"), days(latitude, 213), None).unwrap();
            assert_eq!(weather.is_south, is_south);
        }
        assert_eq!(Weather::series(date("2017-08-01"), Vec::new(), None), None);
    }

    #[test]
    fn days_have_dates_and_a_growing_year() {
        let weather = Weather::mean_years(45.0, None, date("2017-01-01"), 400);
        assert_eq!((weather.first(), weather.end()), (-366, 401.0));
        assert_eq!(weather.date(31.5), Some(date("2017-02-01")));
        assert_eq!(weather.growing_day(366 + 171), Some((2017, 172)));
        let south = Weather::mean_years(-45.0, None, date("2017-01-01"), 400);
        assert_eq!(south.growing_day(366), Some((2017, 184)));
        assert_eq!(Weather::constant(10.0, 0.5).date(3.0), None);
    }
}
