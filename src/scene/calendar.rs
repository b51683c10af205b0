//! Weather and days of a scene: `[climate]` and `[time]` together decide whether there is a year, which days it has, and
//! which of them are drawn.

use super::time::{Settings, Time, When};
use crate::base::calendar::Date;
use crate::base::settings::Complaint;
use crate::season::series::Series;
use crate::season::{Climate, Day, MOST_DAYS, Moment, Weather};

/// The day that is drawn in a constant climate when the scene names none, its temperature and humidity.
const DEFAULT_DAY: f64 = 12.0;
const DEFAULT_TEMPERATURE: f64 = 12.0;
const DEFAULT_HUMIDITY: f64 = 0.7;
/// The latitude of a moment without weather.
const DEFAULT_LATITUDE: f64 = 45.0;
/// The year that days of a mean year are dated in when the scene names no date.
const NOMINAL_YEAR: i64 = 2025;
/// Years that dates may lie in, so that days before and after them have dates too.
const YEARS: std::ops::RangeInclusive<i64> = 2..=9000;
/// Years of mean weather at most.
const MOST_YEARS: f64 = 100.0;

/// The weather and days of a scene.
#[derive(Clone, Debug)]
pub struct Calendar {
    /// The weather.
    pub weather: Weather,
    /// The days.
    pub time: Time,
}

impl Calendar {
    /// The climate and day of a scene that names none.
    #[must_use]
    pub fn constant() -> Self {
        let weather = Weather::constant(DEFAULT_TEMPERATURE, DEFAULT_HUMIDITY);
        Self { weather, time: Time::one(DEFAULT_DAY) }
    }
}

/// Complaints with the table they belong to.
type Complaints = Vec<(&'static str, Complaint)>;

/// Resolves weather and days. `series` is the content of `climate.series`.
///
/// # Errors
/// Everything that does not go together.
pub fn resolve(climate: &Climate, time: &Settings, series: Option<Series>) -> Result<Calendar, Complaints> {
    let mut complaints = forms(climate, time);
    let dates = dates(time, &mut complaints);
    if !complaints.is_empty() {
        return Err(complaints);
    }
    let is_year = climate.series.is_some() || climate.latitude.is_some() || time.moment.is_some();
    let weather = match series {
        _ if !is_year => Weather::constant(
            climate.temperature.unwrap_or(DEFAULT_TEMPERATURE),
            climate.humidity.unwrap_or(DEFAULT_HUMIDITY),
        ),
        Some(series) => of_series(climate, &series)?,
        None => mean_years(climate, time, &dates)?,
    };
    let moment = time.moment.or((is_year && is_without_time(time)).then_some(Moment::Peak));
    let mut time = days(time, &weather, &dates);
    time.moment = moment;
    let complaints = outside(&weather, &time);
    if complaints.is_empty() { Ok(Calendar { weather, time }) } else { Err(complaints) }
}

fn is_without_time(time: &Settings) -> bool {
    *time == Settings::default()
}

/// Which forms exclude or need each other.
fn forms(climate: &Climate, time: &Settings) -> Complaints {
    let mut found: Complaints = Vec::new();
    let mut complain =
        |table, key: &str, what: String, help: &str| found.push((table, Complaint::new(key, what, help)));
    let kinds = [("series", climate.series.is_some()), ("latitude", climate.latitude.is_some())];
    let mut years = kinds.iter().filter(|(_, given)| *given).map(|(name, _)| *name);
    let year = years.next().or(time.moment.map(|_| "time.moment"));
    if let (Some(_), Some(year)) = (climate.temperature, year) {
        let what = format!("there are both one temperature for all days and `{year}`, a year's weather");
        complain("climate", "temperature", what, "keep one of them");
    }
    let singles = [("day", time.day.is_some()), ("date", time.date.is_some()), ("moment", time.moment.is_some())];
    let run = [("from", time.from.is_some()), ("to", time.to.is_some()), ("step", time.step.is_some())];
    let mut given = singles.iter().filter(|(_, given)| *given);
    let single = given.next();
    if let (Some((first, _)), Some((second, _))) = (single, given.next()) {
        let what = format!("time has both `{first}` and `{second}`");
        complain("time", second, what, "keep one of them");
    }
    let of_run = run.iter().find(|(_, given)| *given);
    match (single, of_run) {
        (Some((single, _)), Some((key, _))) => {
            let help = "keep the one for one frame, or `from`, `to` and `step` for several";
            complain("time", key, format!("time has both `{single}` and `{key}`"), help);
        }
        (None, Some((key, _))) if time.from.is_none() || time.to.is_none() => {
            let missing = if time.from.is_none() { "from" } else { "to" };
            complain("time", key, format!("time has `{key}` but no `{missing}`"), &format!("add `{missing}`"));
        }
        _ => {}
    }
    let is_date = |when: &Option<When>| matches!(when, Some(When::Date(_)));
    let dated = [("date", time.date.is_some()), ("from", is_date(&time.from)), ("to", is_date(&time.to))];
    if let (None, Some((key, _))) = (year, dated.iter().find(|(_, given)| *given)) {
        let what = "a date needs weather with dates".to_owned();
        complain("time", key, what, "give climate.series, or climate.latitude for the mean year of a place");
    }
    found
}

/// The dates of `date`, `from` and `to`.
struct Dates {
    date: Option<Date>,
    from: Option<Date>,
    to: Option<Date>,
}

fn dates(time: &Settings, complaints: &mut Complaints) -> Dates {
    let mut read = |key: &str, text: Option<&String>| {
        let text = text?;
        let date = Date::parse(text);
        if date.is_none_or(|date| !YEARS.contains(&date.year())) {
            let what = format!("`{key}` is not a date of the years {} to {}", YEARS.start(), YEARS.end());
            complaints.push(("time", Complaint::new(key, what, "write year, month and day: \"2017-10-05\"")));
        }
        date
    };
    let of = |when: &Option<When>| match when {
        Some(When::Date(text)) => Some(text.clone()),
        _ => None,
    };
    Dates {
        date: read("date", time.date.as_ref()),
        from: read("from", of(&time.from).as_ref()),
        to: read("to", of(&time.to).as_ref()),
    }
}

/// Days of a series with what it lacks.
fn of_series(climate: &Climate, series: &Series) -> Result<Weather, Complaints> {
    let lacks_length = series.days.iter().any(|record| record.day_length.is_none());
    if lacks_length && climate.latitude.is_none() {
        let what = "this series has no day lengths (`daylength_h`)";
        return Err(vec![("climate", Complaint::new("series", what, "give climate.latitude, from which they follow"))]);
    }
    let day = |(at, record): (usize, &crate::season::series::Record)| {
        let date = series.start.plus(at as i64);
        let computed = |latitude: f64| crate::season::day_length(latitude, date.day_of_year() as f64);
        Day {
            temperature: record.temperature,
            humidity: record.humidity.or(climate.humidity).unwrap_or(DEFAULT_HUMIDITY),
            day_length: record.day_length.or(climate.latitude.map(computed)),
        }
    };
    let days = series.days.iter().enumerate().map(day).collect();
    Weather::series(series.start, days, climate.latitude).ok_or_else(Vec::new)
}

/// The mean years that the days of the scene lie in.
fn mean_years(climate: &Climate, time: &Settings, dates: &Dates) -> Result<Weather, Complaints> {
    let year = dates.date.or(dates.from).or(dates.to).map_or(NOMINAL_YEAR, Date::year);
    let Some(origin) = Date::new(year, 1, 1) else { return Err(Vec::new()) };
    let numbers = [time.day, number(time.from.as_ref()), number(time.to.as_ref())];
    let of_dates = [dates.date, dates.from, dates.to].map(|date| date.map(|date| date.since(origin) as f64));
    let last = numbers.into_iter().chain(of_dates).flatten().fold(MOST_DAYS, f64::max);
    if last > MOST_YEARS * 366.0 {
        let key = if time.to.is_some() { "to" } else { "day" };
        let what = format!("the days reach over more than {MOST_YEARS} years");
        return Err(vec![("time", Complaint::new(key, what, "draw fewer years"))]);
    }
    let latitude = climate.latitude.unwrap_or(DEFAULT_LATITUDE);
    Ok(Weather::mean_years(latitude, climate.humidity, origin, last.ceil() as i64))
}

fn number(when: Option<&When>) -> Option<f64> {
    match when {
        Some(When::Day(day)) => Some(*day),
        _ => None,
    }
}

fn days(time: &Settings, weather: &Weather, dates: &Dates) -> Time {
    let of = |number: Option<f64>, date: Option<Date>| number.or_else(|| weather.day_of(date?));
    let (from, to) = (of(number(time.from.as_ref()), dates.from), of(number(time.to.as_ref()), dates.to));
    match from.zip(to) {
        Some((from, to)) => Time::run(from, to, time.step.unwrap_or(1.0)),
        None => {
            let default = if weather.is_constant() { DEFAULT_DAY } else { 0.0 };
            Time::one(of(time.day, dates.date).unwrap_or(default))
        }
    }
}

/// Days that run backwards or lie outside the weather.
fn outside(weather: &Weather, time: &Time) -> Complaints {
    let last = time.at(time.count().clamp(1.0, 1e15) as i64 - 1);
    let first = time.at(0);
    let shown = |day: f64| weather.date(day).map_or_else(|| format!("{day}"), |date| date.to_string());
    if let Some(end) = time.end().filter(|_| time.count() < 1.0) {
        let what = format!("time ends at {}, before it begins at {}", shown(end), shown(first));
        return vec![("time", Complaint::new("to", what, "let `to` be at least `from`"))];
    }
    let key = |run: &'static str| if time.is_single() { "" } else { run };
    let mut found = Vec::new();
    if first < weather.first() as f64 {
        let what = format!("{} is before the weather begins, on {}", shown(first), shown(weather.first() as f64));
        found.push(("time", Complaint::new(key("from"), what, "draw days of the series")));
    }
    if last > weather.end() {
        let what = format!("{} is after the weather ends, on {}", shown(last), shown(weather.end() - 1.0));
        found.push(("time", Complaint::new(key("to"), what, "draw days of the series, or give a longer one")));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::season::series;

    fn keys(climate: &Climate, time: &Settings) -> Vec<String> {
        let complaints = resolve(climate, time, None).err().unwrap_or_default();
        complaints.into_iter().map(|(table, complaint)| format!("{table}.{}", complaint.key)).collect()
    }

    fn dated(date: &str) -> Settings {
        Settings { date: Some(date.to_owned()), ..Settings::default() }
    }

    fn at(latitude: f64) -> Climate {
        Climate { latitude: Some(latitude), ..Climate::default() }
    }

    fn run(from: f64, to: f64) -> Settings {
        Settings { from: Some(When::Day(from)), to: Some(When::Day(to)), ..Settings::default() }
    }

    #[test]
    fn exactly_one_form_of_time_is_taken() {
        let constant = Climate::default();
        assert_eq!(keys(&constant, &Settings::default()), [] as [String; 0]);
        assert_eq!(keys(&constant, &run(0.0, 1.0)), [] as [String; 0]);
        assert_eq!(keys(&constant, &Settings { day: Some(1.0), ..run(0.0, 1.0) }), ["time.from"]);
        assert_eq!(keys(&constant, &Settings { from: None, ..run(0.0, 1.0) }), ["time.to"]);
        assert_eq!(keys(&constant, &Settings { to: None, ..run(0.0, 1.0) }), ["time.from"]);
        assert_eq!(keys(&constant, &run(2.0, 1.0)), ["time.to"]);
        assert_eq!(keys(&at(45.0), &Settings { day: Some(3.0), ..dated("2017-10-05") }), ["time.date"]);
    }

    #[test]
    fn dates_need_a_year_and_one_temperature_has_none() {
        assert_eq!(keys(&Climate::default(), &dated("2017-10-05")), ["time.date"]);
        assert_eq!(keys(&at(45.0), &dated("2017-10-35")), ["time.date"]);
        assert_eq!(keys(&at(45.0), &dated("2017-10-05")), [] as [String; 0]);
        let both = Climate { temperature: Some(8.0), ..at(45.0) };
        assert_eq!(keys(&both, &Settings::default()), ["climate.temperature"]);
        let moment = Settings { moment: Some(Moment::Peak), ..Settings::default() };
        let warm = Climate { temperature: Some(8.0), ..Climate::default() };
        assert_eq!(keys(&warm, &moment), ["climate.temperature"]);
    }

    #[test]
    fn days_of_a_series_lie_within_it() {
        let text = "date,tmean_c,daylength_h\n2017-10-01,9,11.5\n2017-10-02,8,11.4\n2017-10-03,7,11.3\n";
        let climate = Climate { series: Some("weather.csv".to_owned()), ..Climate::default() };
        let resolved = |time: &Settings| resolve(&climate, time, series::read(text).ok());
        let calendar = resolved(&dated("2017-10-03")).unwrap();
        assert_eq!((calendar.time.at(0), calendar.weather.days()[2].temperature), (2.0, 7.0));
        assert_eq!(calendar.weather.days()[0].humidity, 0.7);
        for (date, within) in [("2017-09-30", "before"), ("2017-10-05", "after")] {
            assert!(resolved(&dated(date)).unwrap_err()[0].1.message.contains(within));
        }
        let bare = series::read("date,tmean_c\n2017-10-01,9\n").ok();
        assert_eq!(resolve(&climate, &Settings::default(), bare).unwrap_err()[0].1.key, "series");
    }

    #[test]
    fn without_a_time_a_year_is_drawn_at_its_peak() {
        assert_eq!(resolve(&at(45.0), &Settings::default(), None).unwrap().time.moment, Some(Moment::Peak));
        assert_eq!(resolve(&Climate::default(), &Settings::default(), None).unwrap().time.moment, None);
    }
}
