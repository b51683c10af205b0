//! Ticks of an axis of dates: days, months, years.

use super::ticks::{Tick, Ticks};
use crate::base::calendar::Date;

const MONTHS: [&str; 12] = ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];

/// A span of more days is told in months.
const DAYS_TOLD: f64 = 62.0;

/// Days from an origin, as a row of whole days.
struct Span {
    origin: Date,
    range: [f64; 2],
}

impl Span {
    /// Whether every day of it has a date with a year of four digits, so that all sums below are small.
    fn new(origin: Date, range: [f64; 2]) -> Option<Self> {
        if range.iter().any(|end| end.abs() > 4.0e6) {
            return None;
        }
        let is_dated = |end: f64| (1..=9999).contains(&origin.plus(end as i64).year());
        (is_dated(range[0].floor()) && is_dated(range[1].ceil())).then_some(Self { origin, range })
    }

    /// The value of a date, when it lies in the span.
    fn value(&self, date: Option<Date>) -> Option<f64> {
        let value = date?.since(self.origin) as f64;
        (value >= self.range[0] && value <= self.range[1]).then_some(value)
    }

    /// The first and the last month that it touches, counted from the year 0.
    fn months(&self) -> std::ops::RangeInclusive<i64> {
        let month = |day: f64| {
            let (year, month, _) = self.origin.plus(day as i64).parts();
            12 * year + month - 1
        };
        month(self.range[0].floor())..=month(self.range[1].floor())
    }
}

/// From the densest to the sparsest; none when the span is no span of dates. `fits(label, days)` says whether that many
/// days have room for a label.
pub(super) fn candidates(origin: Date, range: [f64; 2], fits: &dyn Fn(&str, f64) -> bool) -> Vec<Ticks> {
    let Some(span) = Span::new(origin, range) else { return vec![] };
    let mut found = vec![];
    if range[1] - range[0] <= DAYS_TOLD {
        const EVEN: [i64; 15] = [1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29];
        let every: Vec<i64> = (1..=31).collect();
        let rows: [&[i64]; 6] = [&every, &EVEN, &[1, 5, 10, 15, 20, 25], &[1, 8, 15, 22], &[1, 11, 21], &[1, 15]];
        found.extend(rows.iter().map(|days| days_of_months(&span, days)));
    } else {
        found.push(whole_months(&span, fits));
    }
    found.extend([2, 3, 6].map(|step| every_months(&span, step)));
    found.extend([1, 2, 5, 10, 20, 50, 100, 200, 500, 1000].map(|step| every_months(&span, 12 * step)));
    found
}

fn first_of(month: i64) -> Option<Date> {
    Date::new(month.div_euclid(12), month.rem_euclid(12) + 1, 1)
}

fn name(month: i64) -> &'static str {
    MONTHS[month.rem_euclid(12) as usize]
}

fn days_of_months(span: &Span, days: &[i64]) -> Ticks {
    let date = |month: i64, day| Date::new(month.div_euclid(12), month.rem_euclid(12) + 1, day);
    let tick = |month, day| Some(Tick::new(span.value(date(month, day))?, format!("{day} {}", name(month))));
    let all = span.months().flat_map(|month| days.iter().map(move |&day| (month, day)));
    Ticks { major: all.filter_map(|(month, day)| tick(month, day)).collect(), minor: vec![] }
}

/// Ticks where months begin and their names in their middles; a month that is cut off by an end is named if it has room.
fn whole_months(span: &Span, fits: &dyn Fn(&str, f64) -> bool) -> Ticks {
    let [low, high] = span.range;
    let of_month = |month: i64| {
        let day = |date: Option<Date>, otherwise| date.map_or(otherwise, |date| date.since(span.origin) as f64);
        let (from, to) = (day(first_of(month), low), day(first_of(month + 1), high));
        let seen = [from.max(low), to.min(high)];
        let is_whole = from >= low && to <= high;
        let label = if is_whole || fits(name(month), seen[1] - seen[0]) { name(month) } else { "" };
        Tick { value: from.max(low), label_at: seen[0].midpoint(seen[1]), label: label.to_owned() }
    };
    Ticks { major: span.months().map(of_month).collect(), minor: vec![] }
}

/// Every `step`-th month from January on; January carries the year.
fn every_months(span: &Span, step: i64) -> Ticks {
    let is_counted = |month: &i64| month % step == 0;
    let tick = |month: i64| {
        let label = if month % 12 == 0 { (month / 12).to_string() } else { name(month).to_owned() };
        Some(Tick::new(span.value(first_of(month))?, label))
    };
    Ticks { major: span.months().filter(is_counted).filter_map(tick).collect(), minor: vec![] }
}

/// The year or years of a range: `2017`, `2017 to 2018`; nothing when it is no span of dates.
pub(super) fn years(origin: Date, range: [f64; 2]) -> Option<String> {
    let span = Span::new(origin, range)?;
    let year = |day: f64| span.origin.plus(day as i64).year();
    // The end is the beginning of a day that is not seen any more.
    let (first, last) = (year(range[0].floor()), year((range[1].ceil() - 1.0).max(range[0].floor())));
    Some(if first == last { first.to_string() } else { format!("{first} to {last}") })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn date(text: &str) -> Date {
        Date::parse(text).unwrap()
    }

    fn ticks_of_months(from: &str, to: &str) -> Vec<Tick> {
        let range = [0.0, date(to).since(date(from)) as f64];
        candidates(date(from), range, &|label, days| days >= 3.0 * label.len() as f64)[0].major.clone()
    }

    #[test]
    fn months_begin_on_their_days_in_leap_years_too() {
        let starts = |from, to| ticks_of_months(from, to).iter().map(|tick| tick.value).collect::<Vec<_>>();
        assert_eq!(starts("2016-01-01", "2016-05-01"), [0.0, 31.0, 60.0, 91.0, 121.0]);
        assert_eq!(starts("2017-01-01", "2017-05-01"), [0.0, 31.0, 59.0, 90.0, 120.0]);
        assert_eq!(starts("1900-02-01", "1900-05-01"), [0.0, 28.0, 59.0, 89.0]);
    }

    #[test]
    fn months_are_named_in_their_middles_and_where_there_is_room() {
        let ticks = ticks_of_months("2017-08-15", "2017-12-04");
        let labels: Vec<&str> = ticks.iter().map(|tick| tick.label.as_str()).collect();
        assert_eq!(labels, ["Aug", "Sep", "Oct", "Nov", ""]);
        assert_eq!((ticks[1].value, ticks[1].label_at), (17.0, 32.0));
    }

    #[test]
    fn short_spans_are_told_in_days_over_the_end_of_february() {
        let labels = |from| {
            let found = candidates(date(from), [0.0, 3.0], &|_, _| true);
            found[0].major.iter().map(|tick| tick.label.clone()).collect::<Vec<_>>()
        };
        assert_eq!(labels("2016-02-27"), ["27 Feb", "28 Feb", "29 Feb", "1 Mar"]);
        assert_eq!(labels("2017-02-27"), ["27 Feb", "28 Feb", "1 Mar", "2 Mar"]);
    }

    #[test]
    fn long_spans_are_told_in_years() {
        let found = candidates(date("2000-01-01"), [0.0, 36_525.0], &|_, _| true);
        let centuries = &found[found.len() - 4];
        let labels: Vec<&str> = centuries.major.iter().map(|tick| tick.label.as_str()).collect();
        assert_eq!(labels, ["2000", "2100"]);
        assert_eq!(centuries.major[1].value, 36_525.0);
    }

    #[test]
    fn years_are_named_as_they_are_seen() {
        let of = |from, days| years(date(from), [0.0, days]);
        assert_eq!(of("2017-01-01", 365.0).as_deref(), Some("2017"));
        assert_eq!(of("2016-07-01", 365.0).as_deref(), Some("2016 to 2017"));
        assert_eq!(of("9999-12-01", 365.0), None);
        assert_eq!(of("2017-01-01", 1.0e300), None);
    }
}
