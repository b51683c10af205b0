//! When: one day, or an even run of days.

use crate::base::settings::Complaint;
use crate::settings;

settings! {
    /// The moments that are drawn: one `day`, or `from`, `to` and `step`.
    pub struct Time {
        /// Days in this climate since every leaf was in the state `season.start`; 12 when no other form is given.
        day: Option<f64> = None, unit "d", range 0.0 => 1e6;
        /// First frame of several.
        from: Option<f64> = None, unit "d", range 0.0 => 1e6;
        /// Last frame of several, included when the steps meet it.
        to: Option<f64> = None, unit "d", range 0.0 => 1e6;
        /// From one frame to the next; 1 when absent.
        step: Option<f64> = None, unit "d", range 1e-6 => 1e6;
    }
}

/// The day that is drawn when the scene names none.
pub const DEFAULT_DAY: f64 = 12.0;
/// Share of a step by which `to` may miss the last frame: 0.1 summed ten times is not 1.
const SLACK: f64 = 1e-6;

impl Time {
    /// How many frames there are; a prediction that may exceed any integer type.
    #[must_use]
    pub fn count(&self) -> f64 {
        match (self.from, self.to) {
            (Some(from), Some(to)) => ((to - from) / self.step() + SLACK).floor() + 1.0,
            _ => 1.0,
        }
    }

    /// The day of frame `index`; a negative index lies before the first frame (the run-in of a film).
    #[must_use]
    pub fn at(&self, index: i64) -> f64 {
        match self.from {
            Some(from) => from + index as f64 * self.step(),
            None => self.day.unwrap_or(DEFAULT_DAY),
        }
    }

    /// Whether the scene names one day instead of a run of them; decides the form of the names of frames.
    #[must_use]
    pub fn is_single(&self) -> bool {
        self.from.is_none()
    }

    fn step(&self) -> f64 {
        self.step.unwrap_or(1.0)
    }
}

/// What is wrong with well-typed settings.
#[must_use]
pub fn check(time: &Time) -> Vec<Complaint> {
    let run = [("from", time.from), ("to", time.to), ("step", time.step)];
    let given = run.iter().find(|(_, value)| value.is_some());
    match (time.day, given, time.from, time.to) {
        (Some(_), Some((key, _)), _, _) => vec![Complaint::new(
            *key,
            format!("time has both `day` and `{key}`"),
            "keep `day` for one frame, or `from`, `to` and `step` for several",
        )],
        (None, Some((key, _)), from, to) if from.is_none() || to.is_none() => {
            let missing = if from.is_none() { "from" } else { "to" };
            vec![Complaint::new(*key, format!("time has `{key}` but no `{missing}`"), format!("add `{missing}`"))]
        }
        (None, _, Some(from), Some(to)) if to < from => {
            vec![Complaint::new(
                "to",
                format!("time ends at {to}, before it begins at {from}"),
                "let `to` be at least `from`",
            )]
        }
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(from: f64, to: f64, step: f64) -> Time {
        Time { day: None, from: Some(from), to: Some(to), step: Some(step) }
    }

    #[test]
    fn the_end_is_included_although_steps_are_rounded() {
        assert_eq!(run(0.0, 1.0, 0.1).count(), 11.0);
        assert_eq!(run(0.0, 120.0, 1.0).count(), 121.0);
        assert_eq!(run(0.0, 0.95, 0.1).count(), 10.0);
        let once = run(5.0, 5.0, 1.0);
        assert_eq!((once.count(), once.at(0)), (1.0, 5.0));
    }

    #[test]
    fn negative_frames_lie_before_the_first() {
        assert_eq!(run(10.0, 20.0, 2.0).at(-3), 4.0);
        assert_eq!((Time::default().count(), Time::default().at(0)), (1.0, DEFAULT_DAY));
    }

    #[test]
    fn exactly_one_form_is_taken() {
        assert!(check(&Time::default()).is_empty());
        assert!(check(&run(0.0, 1.0, 1.0)).is_empty());
        assert_eq!(check(&Time { day: Some(1.0), ..run(0.0, 1.0, 1.0) })[0].key, "from");
        assert_eq!(check(&Time { from: None, ..run(0.0, 1.0, 1.0) })[0].key, "to");
        assert_eq!(check(&Time { to: None, ..run(0.0, 1.0, 1.0) })[0].key, "from");
        assert_eq!(check(&run(2.0, 1.0, 1.0))[0].key, "to");
    }
}
