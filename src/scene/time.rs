//! When: one day, date or moment, or an even run of days.

use crate::base::settings::{Described, Kind};
use crate::season::Moment;
use crate::settings;
use serde::{Deserialize, Serialize};

settings! {
    /// The moments that are drawn: one `day`, `date` or `moment`, or `from`, `to` and `step`. Days are counted from day 0: in a
    /// constant climate when every leaf was in `season.start`, else the first day of the series, or 1 January. A date means the
    /// beginning of its day.
    pub struct Settings {
        /// One day; 12 when no form is given in a constant climate.
        day: Option<f64> = None, unit "d", range 0.0 => 1e6;
        /// One date, 2017-10-05; with `climate.series` or `climate.latitude`.
        date: Option<String> = None;
        /// The day in a year's weather on which a moment comes to the first species; `peak` when no form is given there.
        moment: Option<Moment> = None;
        /// First frame of several: a day, or a date in quotes.
        from: Option<When> = None, unit "d", range 0.0 => 1e6;
        /// Last frame of several, included when the steps meet it: a day, or a date in quotes.
        to: Option<When> = None, unit "d", range 0.0 => 1e6;
        /// From one frame to the next; 1 when absent.
        step: Option<f64> = None, unit "d", range 1e-8 => 1e6;
    }
}

/// A day by number or date.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(untagged)]
pub enum When {
    /// Days from day 0.
    Day(f64),
    /// A date as the user wrote it.
    Date(String),
}

impl Described for When {
    fn kind() -> Kind {
        Kind::Either(vec![Kind::Number, Kind::Text])
    }
}

/// Share of a step by which `to` may miss the last frame: 0.1 summed ten times is not 1.
const SLACK: f64 = 1e-6;

/// The days that are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Time {
    /// The day of frame 0.
    first: f64,
    /// The last day, and days from frame to frame; none for one frame.
    run: Option<(f64, f64)>,
    /// The moment whose day is to be found when the leaves are known; `first` is 0 until then.
    pub moment: Option<Moment>,
}

impl Time {
    /// One day.
    #[must_use]
    pub fn one(day: f64) -> Self {
        Self { first: day, run: None, moment: None }
    }

    /// The days from `from` to `to`, every `step` of them; both ends included when the steps meet.
    #[must_use]
    pub fn run(from: f64, to: f64, step: f64) -> Self {
        Self { first: from, run: Some((to, step)), moment: None }
    }

    /// The end of a run of days.
    #[must_use]
    pub fn end(&self) -> Option<f64> {
        self.run.map(|(to, _)| to)
    }

    /// How many frames there are; a prediction that may exceed any integer type.
    #[must_use]
    pub fn count(&self) -> f64 {
        self.run.map_or(1.0, |(to, step)| ((to - self.first) / step + SLACK).floor() + 1.0)
    }

    /// The day of frame `index`; a negative index lies before the first frame (the run-in of a film).
    #[must_use]
    pub fn at(&self, index: i64) -> f64 {
        self.run.map_or(self.first, |(_, step)| self.first + index as f64 * step)
    }

    /// Whether the scene names one day instead of a run of them; decides the form of the names of frames.
    #[must_use]
    pub fn is_single(&self) -> bool {
        self.run.is_none()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_end_is_included_although_steps_are_rounded() {
        assert_eq!(Time::run(0.0, 1.0, 0.1).count(), 11.0);
        assert_eq!(Time::run(0.0, 120.0, 1.0).count(), 121.0);
        assert_eq!(Time::run(0.0, 0.95, 0.1).count(), 10.0);
        let once = Time::run(5.0, 5.0, 1.0);
        assert_eq!((once.count(), once.at(0), once.is_single()), (1.0, 5.0, false));
    }

    #[test]
    fn negative_frames_lie_before_the_first() {
        assert_eq!(Time::run(10.0, 20.0, 2.0).at(-3), 4.0);
        assert_eq!((Time::one(12.0).count(), Time::one(12.0).at(0)), (1.0, 12.0));
    }
}
