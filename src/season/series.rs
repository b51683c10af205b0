//! A file of daily weather: separated values with a header. Every fault that can be found is found.

use crate::base::calendar::Date;
use std::ops::Range;

/// Faults kept of one file.
const MOST_FAULTS: usize = 50;
/// Days that may be missing in a row; they are filled in on a straight line between their neighbours.
const LONGEST_GAP: i64 = 7;
/// Most days of a series: 400 years.
const MOST_DAYS: usize = 146_100;
/// What a weather station can have measured: °C, and hours of a day.
const TEMPERATURES: std::ops::RangeInclusive<f64> = -90.0..=60.0;
const HOURS: std::ops::RangeInclusive<f64> = 0.0..=24.0;
/// Relative humidity in percent; a wet sensor shows a little more than 100, which counts as 100.
const PERCENTS: std::ops::RangeInclusive<f64> = 0.0..=105.0;
/// What separates fields: the first of these that the header has. Spreadsheets write semicolons or tabs where numbers have
/// commas for points.
const SEPARATORS: [char; 3] = [';', '\t', ','];

/// What was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// The first day.
    pub start: Date,
    /// Every day from it on.
    pub days: Vec<Record>,
    /// How many of them were missing and filled in.
    pub filled: usize,
}

/// A day as the file has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Record {
    /// Mean temperature, °C.
    pub temperature: f64,
    /// Relative humidity, 0 to 1.
    pub humidity: Option<f64>,
    /// Length of the day, hours.
    pub day_length: Option<f64>,
}

/// What is wrong with a file, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SeriesFault {
    /// Bytes of the text.
    pub span: Range<usize>,
    /// What is wrong.
    pub message: String,
    /// How to mend it.
    pub help: String,
}

/// Reads a series. Columns are found by name: `date`; `tmean_c`, or `tmin_c` and `tmax_c`; perhaps `rh_pct` and `daylength_h`.
///
/// # Errors
/// All faults: no header, no such column, what is no date or number, dates out of order or twice, more than a week missing.
pub fn read(text: &str) -> Result<Series, Vec<SeriesFault>> {
    let mut lines = lines(text);
    let header = lines.next().map_or(0..0, |line| line);
    let columns = Columns::of(text, header).map_err(|fault| vec![fault])?;
    let mut reader = Reader { text, columns, faults: Vec::new(), start: None, days: Vec::new(), filled: 0 };
    for line in lines {
        if reader.faults.len() >= MOST_FAULTS {
            break;
        }
        reader.line(line);
    }
    match reader.start {
        Some(start) if reader.faults.is_empty() => Ok(Series { start, days: reader.days, filled: reader.filled }),
        None if reader.faults.is_empty() => {
            let help = "write a line for each day below the header".to_owned();
            Err(vec![SeriesFault { span: 0..text.len().min(1), message: "this series has no days".to_owned(), help }])
        }
        _ => Err(reader.faults),
    }
}

/// The lines that say something, without their ends.
fn lines(text: &str) -> impl Iterator<Item = Range<usize>> {
    let mut from = 0;
    text.split_inclusive('\n').filter_map(move |line| {
        let start = from;
        from += line.len();
        let length = line.trim_end().len();
        (length > 0).then_some(start..start + length)
    })
}

/// The fields of a line, without the blanks and quotes around them.
fn fields(text: &str, line: Range<usize>, separator: char) -> Vec<Range<usize>> {
    let mut from = line.start;
    let of = |field: &str| {
        let start = from;
        from += field.len() + 1;
        let inner = field.trim().trim_matches('"');
        let lead = field.find(inner).unwrap_or(0);
        start + lead..start + lead + inner.len()
    };
    text[line].split(separator).map(of).collect()
}

/// Numbers of the columns that are read.
struct Columns {
    separator: char,
    count: usize,
    date: usize,
    temperature: Temperature,
    humidity: Option<usize>,
    day_length: Option<usize>,
}

enum Temperature {
    Mean(usize),
    Extremes(usize, usize),
}

impl Columns {
    fn of(text: &str, header: Range<usize>) -> Result<Self, SeriesFault> {
        let separator = SEPARATORS.into_iter().find(|&one| text[header.clone()].contains(one)).unwrap_or(',');
        let names = fields(text, header.clone(), separator);
        let find = |name: &str| names.iter().position(|field| text[field.clone()].eq_ignore_ascii_case(name));
        let miss = |what: &str| SeriesFault {
            span: header.clone(),
            message: format!("the first line names no column {what}"),
            help: "name the columns, for example date,tmean_c,rh_pct,daylength_h".to_owned(),
        };
        let temperature = match (find("tmean_c"), find("tmin_c"), find("tmax_c")) {
            (Some(mean), ..) => Temperature::Mean(mean),
            (None, Some(low), Some(high)) => Temperature::Extremes(low, high),
            _ => return Err(miss("`tmean_c`, nor both `tmin_c` and `tmax_c`")),
        };
        let date = find("date").ok_or_else(|| miss("`date`"))?;
        let (count, humidity, day_length) = (names.len(), find("rh_pct"), find("daylength_h"));
        Ok(Self { separator, count, date, temperature, humidity, day_length })
    }
}

struct Reader<'a> {
    text: &'a str,
    columns: Columns,
    faults: Vec<SeriesFault>,
    start: Option<Date>,
    days: Vec<Record>,
    filled: usize,
}

impl Reader<'_> {
    fn line(&mut self, line: Range<usize>) {
        let fields = fields(self.text, line.clone(), self.columns.separator);
        if fields.len() != self.columns.count {
            let what = format!("this line has {} fields, the first has {}", fields.len(), self.columns.count);
            return self.fault(line, what, "write a field for each column, separated as in the first line");
        }
        let date = self.date(&fields[self.columns.date]);
        let record = self.record(&fields);
        if let (Some(date), Some(record)) = (date, record) {
            self.add(&fields[self.columns.date], date, record);
        }
    }

    fn date(&mut self, field: &Range<usize>) -> Option<Date> {
        let date = Date::parse(&self.text[field.clone()]);
        if date.is_none() {
            self.fault(field.clone(), "this is not a date".to_owned(), "write year, month and day as 2017-08-15");
        }
        date
    }

    fn record(&mut self, fields: &[Range<usize>]) -> Option<Record> {
        let temperature = match self.columns.temperature {
            Temperature::Mean(mean) => self.number(&fields[mean], &TEMPERATURES, "°C"),
            Temperature::Extremes(low, high) => {
                let low = self.number(&fields[low], &TEMPERATURES, "°C");
                low.zip(self.number(&fields[high], &TEMPERATURES, "°C")).map(|(low, high)| 0.5 * (low + high))
            }
        };
        let optional = |reader: &mut Self, column: Option<usize>, range, unit| match column {
            Some(column) => reader.number(&fields[column], range, unit).map(Some),
            None => Some(None),
        };
        let humidity = optional(self, self.columns.humidity, &PERCENTS, "%");
        let day_length = optional(self, self.columns.day_length, &HOURS, "h");
        let humidity = humidity?.map(|percent: f64| percent.min(100.0) / 100.0);
        Some(Record { temperature: temperature?, humidity, day_length: day_length? })
    }

    fn number(&mut self, field: &Range<usize>, range: &std::ops::RangeInclusive<f64>, unit: &str) -> Option<f64> {
        let written = &self.text[field.clone()];
        let with_point = written.replace(',', ".");
        let number = if self.columns.separator == ',' { written } else { &with_point };
        let number = number.parse().ok().filter(|number: &f64| range.contains(number));
        if number.is_none() {
            let what = format!("this is not a number from {} to {} {unit}", range.start(), range.end());
            self.fault(field.clone(), what, "give every day's measurement, or leave the day's line out");
        }
        number
    }

    fn add(&mut self, field: &Range<usize>, date: Date, record: Record) {
        let Some(start) = self.start else {
            self.start = Some(date);
            self.days.push(record);
            return;
        };
        let last = start.plus(self.days.len() as i64 - 1);
        let step = date.since(last);
        if step == 0 {
            return self.fault(field.clone(), format!("{date} stands twice"), "leave one of the two lines out");
        }
        if step < 0 {
            return self.fault(field.clone(), format!("{date} comes after {last}"), "sort the lines by date");
        }
        if step > LONGEST_GAP + 1 {
            let what = format!("{} days are missing before {date}", step - 1);
            let help = format!("give them: up to {LONGEST_GAP} days in a row are filled in");
            // Told once: the days after it are judged as if they had been given.
            self.fault(field.clone(), what, &help);
        }
        if self.days.len() + step as usize > MOST_DAYS {
            return self.fault(field.clone(), format!("with this the series has more than {MOST_DAYS} days"), "cut it");
        }
        self.fill(record, step);
    }

    /// Adds a day `step` days after the last one, and those between on a straight line.
    fn fill(&mut self, record: Record, step: i64) {
        let Some(&last) = self.days.last() else { return };
        let between = |part: f64| {
            let mix = |a: f64, b: f64| a + (b - a) * part;
            Record {
                temperature: mix(last.temperature, record.temperature),
                humidity: last.humidity.zip(record.humidity).map(|(a, b)| mix(a, b)),
                day_length: last.day_length.zip(record.day_length).map(|(a, b)| mix(a, b)),
            }
        };
        self.days.extend((1..step).map(|day| between(day as f64 / step as f64)));
        self.filled += step as usize - 1;
        self.days.push(record);
    }

    fn fault(&mut self, span: Range<usize>, message: String, help: &str) {
        self.faults.push(SeriesFault { span, message, help: help.to_owned() });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "date,doy,tmean_c,rh_pct,daylength_h\n";

    fn faults(lines: &str) -> Vec<(String, String)> {
        let text = format!("{HEADER}{lines}");
        let faults = read(&text).unwrap_err();
        faults.into_iter().map(|fault| (text[fault.span].to_owned(), fault.message)).collect()
    }

    #[test]
    fn columns_are_found_by_name_and_others_passed_over() {
        let series =
            read(&format!("{HEADER}2017-01-01,1,-0.5,80,9.1\r\n2017-01-02,2, 1.5 ,\"100.4\",9.2\r\n\r\n")).unwrap();
        assert_eq!((series.start.to_string(), series.days.len(), series.filled), ("2017-01-01".to_owned(), 2, 0));
        assert_eq!(series.days[1], Record { temperature: 1.5, humidity: Some(1.0), day_length: Some(9.2) });
        let bare = read("tmax_c,tmin_c,date\n4,2,2017-01-01").unwrap();
        assert_eq!(bare.days[0], Record { temperature: 3.0, humidity: None, day_length: None });
    }

    #[test]
    fn spreadsheets_may_write_semicolons_or_tabs_with_commas_for_points() {
        let with_commas = read("date,tmean_c,rh_pct\n2017-01-01,-0.5,80.5\n").unwrap();
        assert_eq!(read("date;tmean_c;rh_pct\n2017-01-01;-0,5;80,5\n").unwrap(), with_commas);
        assert_eq!(read("date\ttmean_c\trh_pct\r\n2017-01-01\t-0.5\t80.5\r\n").unwrap(), with_commas);
        let found = read("date;tmean_c\n2017-01-01;1,2,3\n2017-01-02;1;2\n").unwrap_err();
        let messages: Vec<&str> = found.iter().map(|fault| fault.message.as_str()).collect();
        assert_eq!(messages, ["this is not a number from -90 to 60 °C", "this line has 3 fields, the first has 2"]);
    }

    #[test]
    fn a_week_may_be_missing_and_is_filled_in_straight() {
        let series = read(&format!("{HEADER}2017-01-01,1,0,50,9\n2017-01-05,5,8,70,9\n")).unwrap();
        assert_eq!((series.days.len(), series.filled), (5, 3));
        assert_eq!((series.days[2].temperature, series.days[2].humidity), (4.0, Some(0.6)));
        let found = faults("2017-01-01,1,0,50,9\n2017-01-20,5,8,70,9\n2017-01-21,5,8,70,9\n");
        assert_eq!(found.len(), 1, "told once: {found:?}");
        assert_eq!(found[0].1, "18 days are missing before 2017-01-20");
    }

    #[test]
    fn all_faults_are_found_each_at_its_place() {
        let found = faults("2017-13-01,1,0,50,9\n2017-01-02,2,warm,500,9\n2017-01-03,3\n2017-01-04,4,nan,50,9\n");
        let expected = ["2017-13-01", "warm", "500", "2017-01-03,3", "nan"];
        assert_eq!(found.iter().map(|(place, _)| place.as_str()).collect::<Vec<_>>(), expected);
    }

    #[test]
    fn dates_that_go_back_or_stand_twice_are_refused() {
        let found = faults("2017-01-02,1,0,50,9\n2017-01-02,1,0,50,9\n2017-01-01,1,0,50,9\n2017-01-03,1,0,50,9");
        let messages: Vec<&str> = found.iter().map(|(_, message)| message.as_str()).collect();
        assert_eq!(messages, ["2017-01-02 stands twice", "2017-01-01 comes after 2017-01-02"]);
    }

    #[test]
    fn empty_files_and_strange_headers_are_refused() {
        assert_eq!(faults("")[0].1, "this series has no days");
        for text in ["", "\n\n", "day,temperature\n1,2\n", "date,rh_pct\n2017-01-01,5\n"] {
            assert!(read(text).unwrap_err()[0].message.contains("names no column"), "{text}");
        }
    }

    #[test]
    fn a_thousand_faults_are_not_all_told() {
        assert_eq!(faults(&"x,1,0,50,9\n".repeat(1000)).len(), MOST_FAULTS);
    }
}
