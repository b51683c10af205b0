//! The frames that a call asks for: `A`, `A-B`, `A-B:S` and comma lists of these, negative numbers among them (`-3--1`),
//! and the share of one worker among several.

use crate::base::limits::{Limit, Limits, Refusal};
use std::collections::BTreeSet;
use std::fmt;
use std::str::FromStr;
use thiserror::Error;

/// Frames from `first` to `last` in steps of `step`; `last` itself is one of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Run {
    first: i64,
    last: i64,
    step: i64,
}

/// A list of frames as ranges: nothing is counted out before a limit has allowed it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FrameList(Vec<Run>);

/// What is wrong with a frame list.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum FrameListFault {
    /// There is nothing between two commas, or nothing at all.
    #[error("an entry is empty; write frames as 3, 1-10, 1-10:2 or a comma list of these")]
    Empty,
    /// An entry is not of a known form.
    #[error("{entry:?} is not a frame or a range; write frames as 3, 1-10, 1-10:2 or a comma list of these")]
    Form {
        /// The entry.
        entry: String,
    },
    /// A number has too many digits.
    #[error("{entry:?} holds a number beyond 2147483647")]
    Large {
        /// The entry.
        entry: String,
    },
    /// A range ends before it starts.
    #[error("{entry:?} runs backwards; write the smaller frame first")]
    Backwards {
        /// The entry.
        entry: String,
    },
    /// A step is 0.
    #[error("{entry:?} has a step of 0; the smallest step is 1")]
    Step {
        /// The entry.
        entry: String,
    },
}

/// Why a well-formed list cannot be counted out.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ExpansionFault {
    /// It has more frames than the limit allows.
    #[error(transparent)]
    Limit(#[from] Refusal),
    /// A frame occurs twice, so that two workers could be given it.
    #[error("frame {frame} is named twice; name each frame once")]
    Twice {
        /// The first such frame.
        frame: i64,
    },
}

impl FromStr for FrameList {
    type Err = FrameListFault;

    fn from_str(text: &str) -> Result<Self, FrameListFault> {
        text.split(',').map(|entry| run(entry.trim())).collect::<Result<_, _>>().map(Self)
    }
}

impl FrameList {
    /// Every frame from 0 to `count - 1`; none for 0.
    #[must_use]
    pub fn whole(count: u64) -> Self {
        let last = i64::try_from(count).unwrap_or(i64::MAX) - 1;
        Self(if last < 0 { Vec::new() } else { vec![Run { first: 0, last, step: 1 }] })
    }

    /// Number of frames, without counting them out.
    #[must_use]
    pub fn count(&self) -> u64 {
        let length = |run: &Run| ((run.last - run.first) / run.step) as u64 + 1;
        self.0.iter().map(length).fold(0, u64::saturating_add)
    }

    /// The smallest frame at or beyond `count`, which a scene of `count` frames does not have.
    #[must_use]
    pub fn beyond(&self, count: u64) -> Option<i64> {
        let count = i64::try_from(count).unwrap_or(i64::MAX);
        let first_beyond = |run: &Run| {
            let steps = (count.saturating_sub(run.first) + run.step - 1) / run.step;
            if run.first >= count { run.first } else { run.first + steps * run.step }
        };
        self.0.iter().filter(|run| run.last >= count).map(first_beyond).min()
    }

    /// The frames in the order of the list.
    ///
    /// # Errors
    /// [`ExpansionFault::Limit`] before any memory is taken, [`ExpansionFault::Twice`] for a repeated frame.
    pub fn frames(&self, limits: &Limits) -> Result<Vec<i64>, ExpansionFault> {
        limits.allow(Limit::Frames, "the list of frames", self.count() as f64)?;
        let mut seen = BTreeSet::new();
        let mut frames = Vec::new();
        for run in &self.0 {
            for frame in (run.first..=run.last).step_by(run.step as usize) {
                if !seen.insert(frame) {
                    return Err(ExpansionFault::Twice { frame });
                }
                frames.push(frame);
            }
        }
        Ok(frames)
    }
}

fn run(entry: &str) -> Result<Run, FrameListFault> {
    let form = || FrameListFault::Form { entry: entry.to_owned() };
    if entry.is_empty() {
        return Err(FrameListFault::Empty);
    }
    let (range, step) = entry.split_once(':').map_or((entry, None), |(range, step)| (range, Some(step)));
    // The hyphen that parts the ends is the first one that is not a sign.
    let (first, last) = match range.get(1..).and_then(|rest| rest.find('-')) {
        Some(at) => (&range[..=at], Some(&range[at + 2..])),
        None => (range, None),
    };
    if step.is_some() && last.is_none() {
        return Err(form());
    }
    let first = number(first, entry)?;
    let last = last.map_or(Ok(first), |last| number(last, entry))?;
    let step = match step.map_or(Ok(1), |step| number(step, entry))? {
        0 => return Err(FrameListFault::Step { entry: entry.to_owned() }),
        step if step < 0 => return Err(form()),
        step => step,
    };
    if last < first {
        return Err(FrameListFault::Backwards { entry: entry.to_owned() });
    }
    Ok(Run { first, last: first + (last - first) / step * step, step })
}

/// A whole number in decimal digits with an optional minus; 32 bits, so that no sum of two can overflow.
fn number(text: &str, entry: &str) -> Result<i64, FrameListFault> {
    let digits = text.strip_prefix('-').unwrap_or(text);
    if digits.is_empty() || !digits.bytes().all(|b| b.is_ascii_digit()) {
        return Err(FrameListFault::Form { entry: entry.to_owned() });
    }
    text.parse::<i32>().map(i64::from).map_err(|_| FrameListFault::Large { entry: entry.to_owned() })
}

/// One worker among several: it takes every `count`-th frame of the list from the `index`-th on, so that costly and cheap
/// stretches are shared out evenly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Number of the worker, from 0.
    pub index: u64,
    /// Number of workers, at least 1.
    pub count: u64,
}

impl Default for Shard {
    fn default() -> Self {
        Self { index: 0, count: 1 }
    }
}

/// A shard is written `K/N` with K below N.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{text:?} is not a shard; write K/N with K from 0 to N-1, for example 0/4")]
pub struct ShardFault {
    /// What was given.
    pub text: String,
}

impl FromStr for Shard {
    type Err = ShardFault;

    fn from_str(text: &str) -> Result<Self, ShardFault> {
        let digits = |part: &str| part.bytes().all(|b| b.is_ascii_digit()).then(|| part.parse::<u64>().ok()).flatten();
        let shard = text.split_once('/').and_then(|(k, n)| Some(Self { index: digits(k)?, count: digits(n)? }));
        shard.filter(|shard| shard.index < shard.count).ok_or_else(|| ShardFault { text: text.to_owned() })
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

impl Shard {
    /// This worker's frames.
    #[must_use]
    pub fn take(self, frames: &[i64]) -> Vec<i64> {
        let (index, count) = (usize::try_from(self.index), usize::try_from(self.count));
        match (index, count) {
            (Ok(index), Ok(count)) => frames.iter().skip(index).step_by(count.max(1)).copied().collect(),
            (Ok(index), Err(_)) => frames.get(index).copied().into_iter().collect(),
            _ => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn frames(text: &str) -> Vec<i64> {
        text.parse::<FrameList>().unwrap().frames(&Limits::default()).unwrap()
    }

    #[test]
    fn every_form_is_read() {
        let table: &[(&str, &[i64])] = &[
            ("7", &[7]),
            ("1-4", &[1, 2, 3, 4]),
            ("9-9", &[9]),
            ("22-26:2", &[22, 24, 26]),
            ("22-27:2", &[22, 24, 26]),
            ("8-10,20", &[8, 9, 10, 20]),
            (" 3 , 1 ", &[3, 1]),
            ("-3", &[-3]),
            ("-3--1", &[-3, -2, -1]),
            ("-2-1", &[-2, -1, 0, 1]),
            ("-3,-2", &[-3, -2]),
            ("-4-4:4", &[-4, 0, 4]),
            ("0007", &[7]),
        ];
        for (text, wanted) in table {
            assert_eq!(frames(text), *wanted, "{text}");
        }
    }

    #[test]
    fn wrong_forms_are_refused() {
        for text in
            ["a", "1..3", "1-", "-", "--3", "1-2-3", "5:2", "1-3:", "1-3:-1", "+3", "1 2", "١", "1-3:1:1", "é-3"]
        {
            assert!(matches!(text.parse::<FrameList>(), Err(FrameListFault::Form { .. })), "{text}");
        }
        for text in ["", ",", "1,", " "] {
            assert_eq!(text.parse::<FrameList>(), Err(FrameListFault::Empty), "{text:?}");
        }
        assert!(matches!("10-1".parse::<FrameList>(), Err(FrameListFault::Backwards { .. })));
        assert!(matches!("-1--3".parse::<FrameList>(), Err(FrameListFault::Backwards { .. })));
        assert!(matches!("1-3:0".parse::<FrameList>(), Err(FrameListFault::Step { .. })));
        assert!(matches!("99999999999".parse::<FrameList>(), Err(FrameListFault::Large { .. })));
    }

    #[test]
    fn a_frame_named_twice_is_refused() {
        let twice = |text: &str| text.parse::<FrameList>().unwrap().frames(&Limits::default());
        assert_eq!(twice("1-5,3"), Err(ExpansionFault::Twice { frame: 3 }));
        assert_eq!(twice("2,2"), Err(ExpansionFault::Twice { frame: 2 }));
        assert!(twice("1-9:2,2-8:2").is_ok());
    }

    #[test]
    fn a_list_beyond_the_limit_is_refused_uncounted() {
        let list: FrameList = "-2000000000-2000000000".parse().unwrap();
        assert_eq!(list.count(), 4_000_000_001);
        assert!(matches!(list.frames(&Limits::default()), Err(ExpansionFault::Limit(_))));
    }

    #[test]
    fn frames_beyond_the_scene_are_named() {
        let beyond = |text: &str, count| text.parse::<FrameList>().unwrap().beyond(count);
        assert_eq!(beyond("-3,0-9", 10), None);
        assert_eq!(beyond("0-10", 10), Some(10));
        assert_eq!(beyond("1-12:3", 5), Some(7));
        assert_eq!(beyond("20,15", 10), Some(15));
        assert_eq!(FrameList::whole(3).frames(&Limits::default()), Ok(vec![0, 1, 2]));
        assert_eq!(FrameList::whole(0).count(), 0);
    }

    #[test]
    fn shards_are_read_and_bad_ones_refused() {
        assert_eq!("1/4".parse(), Ok(Shard { index: 1, count: 4 }));
        for text in ["4/4", "0/0", "1", "/2", "a/b", "-1/2", "1/2/3", "+1/2", ""] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
    }

    proptest! {
        #[test]
        fn shards_share_out_every_frame_once(count in 1u64..9, frames in proptest::collection::vec(-50i64..50, 0..40)) {
            let mut all: Vec<i64> = (0..count).flat_map(|index| Shard { index, count }.take(&frames)).collect();
            let mut wanted = frames.clone();
            all.sort_unstable();
            wanted.sort_unstable();
            prop_assert_eq!(all, wanted);
        }

        #[test]
        fn no_text_panics(text in "[-0-9:, ]{0,24}") {
            let list = text.parse::<FrameList>();
            let frames = list.as_ref().ok().and_then(|list| list.frames(&Limits::default()).ok());
            if let (Ok(list), Some(frames)) = (list, frames) {
                prop_assert_eq!(frames.len() as u64, list.count());
            }
        }
    }
}
