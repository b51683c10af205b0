//! What comes before anything costly: the trees, the states of their leaves in every frame, and the plan that follows.

use super::fault;
use super::growth;
use super::leaf_falls;
use super::leaf_states::{self, Seasons};
use super::prediction;
use super::stopwatch::timed;
use crate::base::diagnostic::Diagnostics;
use crate::base::figures::Figures;
use crate::base::limits::{Limit, Limits};
use crate::base::random::hash;
use crate::compose::{Garment, Stand, Ways};
use crate::plan::{self, Counted, Plan, Roll};
use crate::report::Report;
use crate::scene::Scene;
use crate::season::LeafStates;
use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

/// Bytes of states that are kept from the count of a frame until it is drawn; those beyond are drawn twice.
pub(super) const KEPT_BYTES: usize = 64_000_000;
/// Bytes of a leaf's state, and of what is told of a leaf of the year before.
pub(super) const STATE_BYTES: usize = 12;
pub(super) const SHED_BYTES: usize = 24;

/// A scene with one seed, whose trees have grown and whose leaves are counted. A contact sheet has one for each cell.
pub struct Prepared {
    /// The scene.
    pub scene: Scene,
    /// Its trees.
    pub stand: Stand,
    /// Names of the states of all species; empty without a season.
    pub states: Vec<String>,
    /// What is to be done.
    pub plan: Plan,
    /// The leaves' seasons.
    pub seasons: Seasons,
    /// The states of frames that are still to be drawn.
    kept: BTreeMap<i64, (LeafStates, Figures)>,
    /// What those took when all were counted, bytes.
    kept_bytes: usize,
    /// The ways of the leaves that have fallen, found once for all frames.
    pub ways: Ways,
}

/// What a run asks of its preparation.
pub struct Asked<'a> {
    /// The frames that are not there yet.
    pub frames: &'a [i64],
    /// The limits in force.
    pub limits: &'a Limits,
    /// Whether what a scene does not need is left out.
    pub leave_out: bool,
    /// Frames whose states are written down.
    pub states_frames: usize,
    /// How many times as wide and high pictures are drawn.
    pub enlarged: u32,
    /// When this turns true the frames counted so far are planned.
    pub stop: &'a dyn Fn() -> bool,
}

/// Grows the trees of each cell's scene, draws the states of all frames and plans.
///
/// # Errors
/// What the trees' rules or the limits refuse.
pub fn prepare(cells: Vec<Scene>, asked: &Asked<'_>, report: &mut Report) -> Result<Vec<Prepared>, Diagnostics> {
    let mut prepared: Vec<Prepared> = Vec::new();
    let mut counts: Vec<Vec<Counted>> = Vec::new();
    let count = cells.len();
    for mut scene in cells {
        let stand = timed(report, "tree", || growth::grow(&scene, asked.limits))?;
        let states = leaf_states::names(&scene, &stand);
        if count > 1 {
            // The cells of a sheet are alike: what has grown so far tells what all will take.
            let so_far = prepared.iter().map(|one| &one.stand).chain([&stand]).map(prediction::stand).sum::<f64>();
            let all = so_far * count as f64 / (prepared.len() + 1) as f64;
            let allowed = asked.limits.allow(Limit::Memory, "the sheet", all);
            let key = if scene.places.of("cells").is_some() { "cells" } else { "seeds" };
            allowed.map_err(|refusal| fault::refused(&scene.places, key, &refusal))?;
        }
        let mut seasons = Seasons::new(&scene, &stand, &states);
        if !states.is_empty() {
            let start = Instant::now();
            if let Some(moment) = scene.time.moment {
                scene.time = seasons.find(moment).ok_or_else(|| fault::no_moment(&scene.places))?;
            }
            seasons.prepare(asked.frames, asked.frames.len() > 1);
            report.spend("season", start.elapsed().as_secs_f64());
        }
        let mut one = Prepared {
            scene,
            stand,
            states,
            plan: Plan::default(),
            seasons,
            kept: BTreeMap::new(),
            kept_bytes: 0,
            ways: Ways::default(),
        };
        let frames = asked.frames.iter().take_while(|_| !(asked.stop)());
        counts.push(frames.map(|&index| one.count(index, report)).collect());
        prepared.push(one);
    }
    // Cells are drawn frame by frame: a frame is planned only when all are counted, and equals another only in all.
    let frames = counts.iter().map(Vec::len).min().unwrap_or(0);
    let signature =
        |frame: usize| counts.iter().fold(0, |sum, counted| mixed(sum, counted[frame].signature, counts.len()));
    let signatures: Vec<u64> = (0..frames).map(signature).collect();
    for (one, mut counted) in prepared.iter_mut().zip(std::mem::take(&mut counts)) {
        counted.truncate(frames);
        counted.iter_mut().zip(&signatures).for_each(|(frame, signature)| frame.signature = *signature);
        let rolls = one.rolls();
        one.plan = plan::plan(&one.scene, &one.states, &rolls, &counted, asked.leave_out);
    }
    prediction::allow(&prepared, (asked.states_frames, asked.enlarged), asked.limits)?;
    Ok(prepared)
}

/// The signature of a frame in one cell more.
fn mixed(sum: u64, signature: u64, cells: usize) -> u64 {
    if cells == 1 { signature } else { hash(sum, signature) }
}

impl Prepared {
    /// The states of all leaves at a frame's time; none without seasons. Each call adds a run of the season to the report.
    pub fn assigned(&mut self, index: i64, report: &mut Report) -> Option<LeafStates> {
        if self.states.is_empty() {
            return None;
        }
        if let Some((states, figures)) = self.kept.remove(&index) {
            report.add("season", 0.0, figures);
            return Some(states);
        }
        let seasons = &mut self.seasons;
        let made = timed(report, "season", || Ok::<_, std::convert::Infallible>(seasons.at(index)));
        Some(made.unwrap_or_else(|never| match never {}))
    }

    fn count(&mut self, index: i64, report: &mut Report) -> Counted {
        let day = self.scene.time.at(index);
        if self.states.is_empty() {
            return Counted { index, day, ..Counted::default() };
        }
        let start = Instant::now();
        let (states, figures) = self.seasons.at(index);
        report.spend("season", start.elapsed().as_secs_f64());
        let garments = plan::garments(&self.scene, &self.stand, &states);
        let mark = |garment: &Option<Garment>| {
            garment.map_or(u64::MAX, |g| u64::from(g.species) << 48 | u64::from(g.state) << 32 | u64::from(g.variant))
        };
        let signature = garments.iter().fold(0, |sum, garment| hash(sum, mark(garment)));
        let worn: BTreeSet<Garment> = garments.into_iter().flatten().collect();
        let start = Instant::now();
        let falls = leaf_falls::falls((&self.scene, &self.stand), &states, index, &mut self.ways);
        if falls.as_ref().is_some_and(|falls| !falls.seen.is_empty()) {
            report.spend("fall", start.elapsed().as_secs_f64());
        }
        let falls = falls.unwrap_or_default();
        let signature = plan::signature_of_falls(signature, &falls, day);
        let bytes = states.states.len() * STATE_BYTES + states.shed.len() * SHED_BYTES;
        if self.kept_bytes + bytes <= KEPT_BYTES {
            self.kept_bytes += bytes;
            self.kept.insert(index, (states, figures));
        }
        Counted { index, day, worn, looks: falls.looks(), signature }
    }

    fn rolls(&self) -> Vec<Roll> {
        let roll = |number: usize| {
            let forms = self.stand.forms.iter().filter(|form| form.species == number).count();
            let (states, reachable) = self.seasons.reachable(number).into_iter().unzip();
            Roll { trees: self.stand.trees_of(number), forms, states, reachable }
        };
        (0..self.scene.species.len()).map(roll).collect()
    }
}
