//! Days named by what is seen on the tree.

use super::law::Law;
use super::weather::Weather;
use super::{BUD, FALLEN};
use crate::choice;

choice! {
    /// A moment of the year.
    pub enum Moment {
        /// The tree in full green leaf.
        Summer = "summer",
        /// One leaf in ten has turned.
        FirstColour = "first-colour",
        /// The most leaves hang in colour.
        Peak = "peak",
        /// Half of the leaves have left the tree.
        HalfBare = "half-bare",
        /// The leaves that fall have fallen.
        Winter = "winter",
        /// The young leaves are out.
        Flush = "flush",
    }
}

/// States that are green.
const GREEN: [&str; 3] = ["flush", "green", "late-green"];
/// Share of the leaves that have turned at first colour, and that are still there in winter beside those that stay on.
const TURNED: f64 = 0.1;
const LEFT: f64 = 0.01;
/// Days that are looked through: a year, and on to the middle of January.
pub const MOST_DAYS: f64 = 380.0;
/// Days after the longest one on which it is summer.
const SUMMER: f64 = 25.0;
/// Shares on a day.
struct Seen {
    day: f64,
    green: f64,
    brown: f64,
    flush: f64,
    leaves: f64,
}

/// The first day from `from` on, within [`MOST_DAYS`] and the weather, on which a moment has come to leaves of which `laws` gives the
/// exact shares of days that ascend, in the order of `names`; none when it does not come, as in a constant climate.
pub(super) fn day_of(
    names: &[String],
    weather: &Weather,
    moment: Moment,
    from: f64,
    laws: impl Fn(&[f64]) -> Vec<Law>,
) -> Option<f64> {
    if weather.is_constant() || names.is_empty() {
        return None;
    }
    let end = weather.end().min(from + MOST_DAYS);
    let days: Vec<f64> = (0..).map(|day| from + f64::from(day)).take_while(|day| *day < end).collect();
    let longest = longest_day(weather, &days)?;
    if moment == Moment::Summer {
        return Some((longest + SUMMER).min(end - 1.0));
    }
    let laws = laws(&days);
    let share = |law: &Law, wanted: &[&str]| -> f64 {
        let numbered = names.iter().zip(&law.expected);
        numbered.filter(|(name, _)| wanted.contains(&name.as_str())).map(|(_, share)| share).sum()
    };
    let seen = |(&day, law): (&f64, &Law)| Seen {
        day,
        green: share(law, &GREEN),
        brown: share(law, &["brown"]),
        flush: share(law, &["flush"]),
        leaves: 1.0 - share(law, &[FALLEN, BUD]),
    };
    let seen: Vec<Seen> = days.iter().zip(&laws).map(seen).collect();
    let autumn = || seen.iter().filter(|seen| seen.day >= longest);
    let largest = |value: fn(&Seen) -> f64, seen: &mut dyn Iterator<Item = &Seen>| {
        let best = seen.fold(None, |best: Option<&Seen>, next| match best {
            Some(best) if value(best) >= value(next) => Some(best),
            _ => Some(next),
        });
        best.map(|seen| seen.day)
    };
    match moment {
        Moment::Summer => None,
        Moment::FirstColour => autumn().find(|seen| seen.green < 1.0 - TURNED).map(|seen| seen.day),
        Moment::Peak => largest(|seen| seen.leaves - seen.green - seen.brown, &mut autumn()),
        Moment::HalfBare => autumn().find(|seen| seen.leaves <= 0.5).map(|seen| seen.day),
        // Some species keep leaves: then it is winter in the middle of January, or on the last day that is known.
        Moment::Winter => autumn().find(|seen| seen.leaves <= LEFT).or(seen.last()).map(|seen| seen.day),
        Moment::Flush => largest(|seen| seen.flush, &mut seen.iter().filter(|seen| seen.day < longest)),
    }
}

/// The day of the growing year's longest day among days.
fn longest_day(weather: &Weather, days: &[f64]) -> Option<f64> {
    let at = |day: f64| (day as i64 - weather.first()) as usize;
    let is_longest =
        |day: &&f64| weather.growing_day(at(**day)).is_some_and(|(_, date)| date == super::course::LONGEST_DAY);
    days.iter().find(is_longest).or(days.first()).copied()
}
