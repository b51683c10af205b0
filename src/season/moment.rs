//! Days named by what is seen on the tree.

use super::course::{EQUINOX, LONGEST_DAY};
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
/// Days of the growing year in which buds open.
const SPRING: std::ops::Range<i64> = EQUINOX..LONGEST_DAY;
/// Those in which young leaves may be the most.
const YOUNG: std::ops::Range<i64> = EQUINOX..LONGEST_DAY + 30;
/// Share of the leaves that have turned at first colour, and that are still there in winter beside those that stay on.
const TURNED: f64 = 0.1;
const LEFT: f64 = 0.01;
/// Days that are looked through: a year, and on to the middle of January.
pub const MOST_DAYS: f64 = 380.0;
/// Days after the longest one on which it is summer.
const SUMMER: f64 = 25.0;
/// Days after that on which it still is.
const LATE_SUMMER: f64 = 30.0;
/// Days of an autumn that reaches into winter.
const SHORTEST_AUTUMN: usize = 190;
/// Share of leaves that must be in colour, or young, for a height of it.
const FEWEST: f64 = 0.02;
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
    let autumn = autumn(weather, &days)?;
    let begin = days[autumn.start];
    if moment == Moment::Summer {
        let day = summer(weather, begin).max(begin);
        return (day < end && day - summer(weather, begin) < LATE_SUMMER).then_some(day);
    }
    let is_whole = autumn.end < days.len() || days.len() - autumn.start > SHORTEST_AUTUMN;
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
    let autumn = || seen[autumn.clone()].iter();
    let spring = |seen: &&Seen| growing_date(weather, seen.day).is_some_and(|date| YOUNG.contains(&date));
    let largest = |value: fn(&Seen) -> f64, seen: &mut dyn Iterator<Item = &Seen>| {
        let best = seen.fold(None, |best: Option<&Seen>, next| match best {
            Some(best) if value(best) >= value(next) => Some(best),
            _ => Some(next),
        });
        best.filter(|seen| value(seen) >= FEWEST).map(|seen| seen.day)
    };
    match moment {
        Moment::Summer => None,
        Moment::FirstColour => autumn().find(|seen| seen.green < 1.0 - TURNED).map(|seen| seen.day),
        Moment::Peak => largest(|seen| seen.leaves - seen.green - seen.brown, &mut autumn()),
        Moment::HalfBare => autumn().find(|seen| seen.leaves <= 0.5).map(|seen| seen.day),
        // Some species keep leaves: then it is winter in the middle of January, or on the last day that is known.
        Moment::Winter => {
            autumn().find(|seen| seen.leaves <= LEFT).or(autumn().next_back().filter(|_| is_whole)).map(|seen| seen.day)
        }
        Moment::Flush => largest(|seen| seen.flush, &mut seen.iter().filter(spring)),
    }
}

/// How far into its growing year a day is.
fn growing_date(weather: &Weather, day: f64) -> Option<i64> {
    weather.growing_day(weather.number(day)).map(|(_, date)| date)
}

/// The days, by number, from the longest one, or from the first where that is past it, to the next spring.
fn autumn(weather: &Weather, days: &[f64]) -> Option<std::ops::Range<usize>> {
    let date = |day: &f64| growing_date(weather, *day).unwrap_or(0);
    let start = days.iter().position(|day| date(day) >= LONGEST_DAY)?;
    let length = days[start..].iter().position(|day| SPRING.contains(&date(day))).unwrap_or(days.len() - start);
    Some(start..start + length)
}

/// The day of full leaf of the growing year that a day after its longest one lies in.
fn summer(weather: &Weather, day: f64) -> f64 {
    day + SUMMER - (growing_date(weather, day).unwrap_or(LONGEST_DAY) - LONGEST_DAY) as f64
}
