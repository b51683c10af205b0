//! What is told of frames: the report, the file of states, progress.

use super::{CellFalls, CellStates, Run};
use crate::base::diagnostic::Diagnostics;
use crate::fall::Counts;
use crate::report::{FrameReport, ViewReport};
use crate::run::finishing::{Made, Written};
use crate::run::manifest::Key;
use crate::run::progress::{Event, Progress};
use crate::run::{Outcome, states_file};
use crate::season;
use std::collections::BTreeMap;

/// What is told of a frame once its files are written.
pub(super) struct Drawn {
    pub(super) index: i64,
    pub(super) states: CellStates,
    pub(super) falls: CellFalls,
    pub(super) view: Option<ViewReport>,
    /// Wall time of the drawing, seconds.
    pub(super) seconds: f64,
}

/// What hears of a run.
pub(super) struct Listeners<'a> {
    pub(super) progress: &'a mut Progress,
    pub(super) outcome: &'a mut Outcome,
}

impl Run<'_> {
    /// Writes a frame's files and tells of it.
    pub(super) fn finish(
        &mut self,
        frame: Option<(Drawn, Made)>,
        key: &dyn Fn(i64) -> Key,
        is_repeated: impl Fn(i64) -> bool,
        listeners: &mut Listeners<'_>,
    ) -> Result<(), Diagnostics> {
        let Some((told, made)) = frame else { return Ok(()) };
        let written = made.written(&self.options.out, &self.names, key(told.index));
        self.tell(&told, written, is_repeated, listeners)
    }

    /// Tells of a frame that is written, and keeps its files if others repeat it.
    pub(super) fn tell(
        &mut self,
        frame: &Drawn,
        written: Result<Written, Diagnostics>,
        is_repeated: impl Fn(i64) -> bool,
        listeners: &mut Listeners<'_>,
    ) -> Result<(), Diagnostics> {
        let written = match written {
            Ok(written) => written,
            Err(fault) => return self.failed(frame.index, fault, listeners),
        };
        if let Some((seconds, figures)) = written.encoding {
            self.report.add("png", seconds, figures);
        }
        self.note(frame, frame.seconds + written.seconds);
        listeners.progress.tell(Event::Drawn { frame: frame.index });
        if is_repeated(frame.index) {
            self.repeated.insert(frame.index, written.files);
        }
        Ok(())
    }

    /// Notes a frame that failed, or ends the run with its fault.
    pub(super) fn failed(
        &self,
        frame: i64,
        fault: Diagnostics,
        listeners: &mut Listeners<'_>,
    ) -> Result<(), Diagnostics> {
        if !self.options.keep_going {
            return Err(fault);
        }
        listeners.progress.tell(Event::Failed { frame, message: &fault.to_string() });
        listeners.outcome.failed.push((frame, fault));
        Ok(())
    }

    /// Reports a frame that was there already.
    pub fn count_kept(&mut self, index: i64) {
        let states = self.states(index);
        let falls = self.falls(index, &states);
        self.note(&Drawn { index, states, falls, view: None, seconds: 0.0 }, 0.0);
    }

    /// Adds a frame to the report and to the file of states. The counts are of all trees, and of all cells.
    pub(super) fn note(&mut self, drawn: &Drawn, seconds: f64) {
        let Drawn { index, states, falls, view, .. } = drawn;
        let index = *index;
        // A moment's day is known to the cells.
        let shown = self.cells.first().map_or(self.scene, |cell| &cell.scene);
        let day = shown.time.at(index);
        let mut frame = FrameReport {
            index,
            day,
            date: shown.weather.date(day).map(|date| date.to_string()),
            leaves: self.cells.iter().map(|cell| cell.stand.leaf_ids.len() as u64).sum(),
            states: BTreeMap::new(),
            expected: BTreeMap::new(),
            fallen: 0,
            fall: falls.iter().flatten().map(|falls| falls.counts).reduce(Counts::plus),
            png: self.names.png(index),
            gltf: self.names.gltf(index),
            view: *view,
            seconds,
        };
        let drawn: usize = states.iter().flatten().map(|states| states.states.len()).sum();
        for (number, (cell, states)) in self.cells.iter().zip(states).enumerate() {
            let Some(states) = states else { continue };
            let alone = states.states.len() == drawn;
            let weight = states.states.len() as f64 / drawn.max(1) as f64;
            for (place, name) in states.names.iter().enumerate() {
                let count = states.states.iter().filter(|&&state| usize::from(state) == place).count() as u64;
                *frame.states.entry(name.clone()).or_default() += count;
                let share = if alone { states.expected[place] } else { weight * states.expected[place] };
                *frame.expected.entry(name.clone()).or_default() += share;
            }
            if self.options.states.is_some() {
                let when = (index, cell.scene.time.at(index));
                let of_sheet =
                    self.scene.sheet_column().map(|_| self.scene.seeds.get(number).copied().unwrap_or(number as u64));
                states_file::append(&mut self.states_text, when, &cell.stand, states, of_sheet);
            }
        }
        frame.fallen = frame.states.get(season::FALLEN).copied().unwrap_or(0);
        self.report.frames.push(frame);
    }
}
