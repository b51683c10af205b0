//! Runs a scene: the part that touches disk, clock, threads and signals. Everything it calls is pure.

pub mod comparison;
pub mod destination;
mod drawing;
pub mod enlargement;
pub mod fault;
pub mod files;
mod finishing;
pub mod frame_list;
mod growth;
mod layers;
pub mod leaf;
mod leaf_falls;
mod leaf_states;
pub mod manifest;
pub mod memory;
mod names;
mod prediction;
mod preparation;
pub mod progress;
pub mod quality;
mod shares_chart;
pub mod signals;
mod states_file;
pub mod still;
pub mod stopwatch;
pub mod verify;
mod wardrobe;

use crate::base::diagnostic::{Diagnostic, Diagnostics, Fault};
use crate::base::limits::{Limit, Limits};
use crate::compose::contact_sheet::Sheet;
use crate::plan::{LeftOut, Plan, Reason};
use crate::report::Report;
use crate::scene::Scene;
use drawing::Run;
use frame_list::{FrameList, Shard};
use manifest::Key;
use names::Names;
use preparation::{Asked, Prepared};
use progress::{Event, Progress};
use quality::{Chooser, Chosen};
use signals::Signals;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// How a scene is run; decides no byte of an output.
#[derive(Clone, Debug)]
pub struct Options {
    /// Where the files go.
    pub out: PathBuf,
    /// The frames asked for; all when absent.
    pub frames: Option<FrameList>,
    /// The part of them that is this process's.
    pub shard: Option<Shard>,
    /// Whether other frames go on when one fails.
    pub keep_going: bool,
    /// Whether finished frames are drawn anew.
    pub force: bool,
    /// Where every leaf's state is written.
    pub states: Option<PathBuf>,
    /// The limits in force.
    pub limits: Limits,
    /// Whether what a scene does not need is left out; off only in tests.
    pub leave_out: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            out: PathBuf::from("out"),
            frames: None,
            shard: None,
            keep_going: false,
            force: false,
            states: None,
            limits: Limits::default(),
            leave_out: true,
        }
    }
}

/// How a run ended.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// The report, also of an interrupted run.
    pub report: Report,
    /// Frames that failed, with the reason (only with `keep_going`).
    pub failed: Vec<(i64, Diagnostics)>,
    /// Whether a signal ended it.
    pub interrupted: bool,
}

/// Prints what would be done, without doing it: grows the trees, counts leaves, opens every picture.
///
/// # Errors
/// Faults of the scene, its files or limits.
pub fn plan(scene: &Scene, options: &Options) -> Result<Plan, Diagnostics> {
    let frames = asked(scene, options)?;
    for asset in scene.species.iter().flat_map(|species| species.assets.values()) {
        crate::scene::read_picture(asset, &options.limits)?;
    }
    let asked = Asked {
        frames: &frames,
        limits: &options.limits,
        leave_out: options.leave_out,
        states_frames: 0,
        enlarged: 1,
        stop: &|| false,
    };
    let prepared = preparation::prepare(cells(scene), &asked, &mut Report::default())?;
    Ok(whole_plan(scene, &prepared))
}

/// The scenes that a frame of a scene shows: itself, or the cells of its contact sheet.
fn cells(scene: &Scene) -> Vec<Scene> {
    if scene.cell_count() == 0 {
        return vec![scene.clone()];
    }
    let sheet = Sheet::in_columns(scene.image.width, scene.image.height, scene.cell_count(), scene.image.columns);
    let cell = |number: usize| {
        let [_, _, width, height] = sheet.cell(number);
        scene.cell(number, [width, height])
    };
    (0..scene.cell_count()).map(cell).collect()
}

/// The plan of all cells.
fn whole_plan(scene: &Scene, prepared: &[Prepared]) -> Plan {
    if scene.cell_count() == 0 {
        return prepared.first().map_or_else(Plan::default, |cell| cell.plan.clone());
    }
    let named = |(number, cell): (usize, &Prepared)| (scene.cell_name(number), cell.plan.clone());
    let plans: Vec<(String, Plan)> = prepared.iter().enumerate().map(named).collect();
    Plan::of_sheet(&plans)
}

/// Renders the frames that are asked for and not finished yet.
///
/// # Errors
/// The first fault; with `keep_going` only what stops every frame.
pub fn render(
    scene: &Scene,
    options: &Options,
    progress: &mut Progress,
    signals: &Signals,
) -> Result<Outcome, Diagnostics> {
    let choose = |error: f64| Chooser::new(scene, &options.limits).choose(error);
    render_by(scene, options, (progress, signals), choose)
}

/// As [`render`], where `choose` tells what keeps within the error that the scene asks for.
///
/// # Errors
/// As [`render`].
pub fn render_by(
    scene: &Scene,
    options: &Options,
    (progress, signals): (&mut Progress, &Signals),
    choose: impl FnOnce(f64) -> Result<Chosen, Diagnostics>,
) -> Result<Outcome, Diagnostics> {
    let start = Instant::now();
    let frames = asked(scene, options)?;
    destination::check(scene, &options.out, options.states.as_deref())?;
    let mut report = Report::begun(&scene.name);
    let names = Names::new(scene);
    let scene_hash = manifest::hash(scene.resolved().to_string().as_bytes());
    let key = |frame: i64| Key { build: manifest::BUILD.to_owned(), scene: scene_hash.clone(), frame };
    let kept = |&frame: &i64| {
        !options.force && manifest::is_done(&options.out, &scene.name, names.frames, &key(frame), &names.all(frame))
    };
    let (kept, to_do): (Vec<i64>, Vec<i64>) = frames.iter().copied().partition(kept);
    progress.tell(Event::Started { frames: frames.len() as u64 });
    let chosen = match scene.quality.error.filter(|_| !to_do.is_empty() && scene.cell_count() == 0) {
        Some(error) => Some(choose(error)?),
        None => None,
    };
    let enlarged = chosen.as_ref().map_or(1, |chosen| chosen.reached.enlarged);
    if let Some(chosen) = &chosen {
        report.notes.extend(chosen.note());
        report.quality = Some(chosen.reached.clone());
    }
    let scene = chosen.as_ref().map_or(scene, |chosen| &chosen.scene);
    let asked = Asked {
        frames: &to_do,
        limits: &options.limits,
        leave_out: options.leave_out,
        states_frames: if options.states.is_some() { frames.len() } else { 0 },
        enlarged,
        stop: &|| signals.came(),
    };
    let prepared = preparation::prepare(cells(scene), &asked, &mut report)?;
    report.left_out = whole_plan(scene, &prepared).left_out;
    report.left_out.extend(
        kept.iter().map(|frame| LeftOut { what: format!("raster frame {frame}"), reason: Reason::AlreadyDone }),
    );
    let mut run = Run::new(scene, options, prepared, names, report).enlarged(enlarged);
    for frame in kept {
        run.count_kept(frame);
        progress.tell(Event::Kept { frame });
    }
    let mut outcome = Outcome::default();
    if !to_do.is_empty() {
        run.draw_all(progress, signals, &key, &mut outcome)?;
    }
    if let Some(form) = scene.output.shares.filter(|_| !outcome.interrupted) {
        run.write_shares(form)?;
    }
    let (mut report, states) = run.finished();
    if let Some(path) = options.states.as_ref().filter(|_| !outcome.interrupted) {
        files::write(path, states.as_bytes()).map_err(|error| fault::written(&error))?;
    }
    report.frames.sort_by_key(|frame| frame.index);
    report.seconds = start.elapsed().as_secs_f64();
    report.peak_memory_bytes = stopwatch::peak_memory();
    outcome.report = report;
    Ok(outcome)
}

/// The frames of a run, in order.
fn asked(scene: &Scene, options: &Options) -> Result<Vec<i64>, Diagnostics> {
    let count = scene.time.count();
    options
        .limits
        .allow(Limit::Frames, "the scene", count)
        .map_err(|refusal| fault::refused(&scene.places, "time", &refusal))?;
    let list = options.frames.clone().unwrap_or_else(|| FrameList::whole(count as u64));
    if let Some(frame) = list.beyond(count as u64) {
        let what = format!("frame {frame} is asked for, but the scene has frames 0 to {}", count - 1.0);
        return Err(Diagnostic::error(Fault::Usage, what, "name frames of the scene with --frames").into());
    }
    let frames = list.frames(&options.limits).map_err(|error| fault::frame_list(&error))?;
    let single_before_start = scene.time.is_single() && frames.iter().any(|&frame| frame < 0);
    if single_before_start {
        let what = "negative frames lie before `time.from`, which this scene does not have";
        return Err(Diagnostic::error(Fault::Usage, what, "give time.from, time.to and time.step").into());
    }
    Ok(options.shard.map_or(frames.clone(), |shard| shard.take(&frames)))
}

/// Writes the report as JSON.
///
/// # Errors
/// When the file cannot be written.
pub fn write_report(path: &Path, report: &Report) -> Result<(), Diagnostics> {
    let mut text = serde_json::to_vec_pretty(report)
        .map_err(|error| Diagnostic::error(Fault::Bug, format!("the report cannot be written: {error}"), ""))?;
    text.push(b'\n');
    files::write(path, &text).map_err(|error| fault::written(&error))
}
