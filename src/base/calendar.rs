//! Dates of the Gregorian calendar, before and after its introduction alike, as ISO 8601 writes them.

use std::fmt;

/// The first and last year that dates may have; four digits.
const YEARS: std::ops::RangeInclusive<i64> = 1..=9999;

/// A day. Counted as days from 1 January 1970, so that dates are compared and added as whole numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Date(i64);

impl serde::Serialize for Date {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl Date {
    /// The date of a year, month (1 to 12) and day of the month; nothing when there is none.
    #[must_use]
    pub fn new(year: i64, month: i64, day: i64) -> Option<Self> {
        let is_in = |range: std::ops::RangeInclusive<i64>, value| range.contains(&value);
        if !is_in(YEARS, year) || !is_in(1..=12, month) || !is_in(1..=days_of_month(year, month), day) {
            return None;
        }
        // Years are counted from March, so that the leap day ends one; 153 days make five months from March on.
        let shifted = year - i64::from(month <= 2);
        let months_since_march = (month + 9) % 12;
        let day_of_year = (153 * months_since_march + 2) / 5 + day - 1;
        Some(Self(365 * shifted + leap_days(shifted) + day_of_year - 719_468))
    }

    /// Reads `2017-08-15`.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let is_form = text.len() == 10
            && text.bytes().enumerate().all(|(at, byte)| match at {
                4 | 7 => byte == b'-',
                _ => byte.is_ascii_digit(),
            });
        if !is_form {
            return None;
        }
        Self::new(text[..4].parse().ok()?, text[5..7].parse().ok()?, text[8..].parse().ok()?)
    }

    /// The date `days` later (earlier when negative).
    #[must_use]
    pub fn plus(self, days: i64) -> Self {
        Self(self.0.saturating_add(days))
    }

    /// Days from `other` to this one.
    #[must_use]
    pub fn since(self, other: Self) -> i64 {
        self.0.saturating_sub(other.0)
    }

    /// Year, month and day of the month.
    #[must_use]
    pub fn parts(self) -> (i64, i64, i64) {
        let from_march = self.0.saturating_add(719_468);
        let era = from_march.div_euclid(146_097);
        let of_era = from_march.rem_euclid(146_097);
        let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
        let day_of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
        let months = (5 * day_of_year + 2) / 153;
        let month = if months < 10 { months + 3 } else { months - 9 };
        let year = year_of_era + era * 400 + i64::from(month <= 2);
        (year, month, day_of_year - (153 * months + 2) / 5 + 1)
    }

    /// The year.
    #[must_use]
    pub fn year(self) -> i64 {
        self.parts().0
    }

    /// Day of the year, 1 for 1 January.
    #[must_use]
    pub fn day_of_year(self) -> i64 {
        self.0 - Self::new(self.year(), 1, 1).map_or(self.0, |first| first.0) + 1
    }
}

impl fmt::Display for Date {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (year, month, day) = self.parts();
        write!(f, "{year:04}-{month:02}-{day:02}")
    }
}

/// Leap days up to the end of a year that begins in March.
fn leap_days(year: i64) -> i64 {
    year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400)
}

fn days_of_month(year: i64, month: i64) -> i64 {
    match month {
        2 if year % 4 == 0 && (year % 100 != 0 || year % 400 == 0) => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn days_are_counted_from_1970_over_leap_years() {
        let day = |text: &str| Date::parse(text).unwrap().0;
        assert_eq!((day("1970-01-01"), day("2000-03-01"), day("2026-11-26")), (0, 11_017, 20_783));
        assert_eq!(day("2016-12-31") - day("2016-01-01"), 365);
        assert_eq!(day("1900-12-31") - day("1900-01-01"), 364);
    }

    #[test]
    fn the_day_of_the_year_knows_leap_days() {
        let of = |text: &str| Date::parse(text).unwrap().day_of_year();
        assert_eq!((of("2017-06-21"), of("2016-06-21"), of("2016-12-31"), of("2017-01-01")), (172, 173, 366, 1));
    }

    #[test]
    fn what_is_no_date_is_refused() {
        for text in [
            "2017-02-29",
            "2017-13-01",
            "2017-00-10",
            "17-01-01",
            "2017/01/01",
            "2017-1-1",
            "",
            "2017-01-0é",
            "0000-01-01",
        ] {
            assert_eq!(Date::parse(text), None, "{text}");
        }
    }

    proptest! {
        #[test]
        fn dates_are_read_as_they_are_written(days in -700_000i64..2_900_000) {
            let date = Date::parse("1970-01-01").unwrap().plus(days);
            prop_assert_eq!(Date::parse(&date.to_string()), Some(date));
        }
    }
}
