//! The report of a run: what was done, how long it took, how wrong it is, and what was left out.

use crate::base::figures::{ErrorFigure, Figures};
use crate::base::message::shown;
use crate::fall::Counts;
use crate::plan::LeftOut;
use serde::Serialize;
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Longest name of an item that is printed, in characters; states have names of the user's choice.
const LONGEST_NAME: usize = 100;
/// The stages in the order of the work; the report lists those that ran.
const STAGES: [&str; 10] = ["tree", "season", "leaf", "deform", "colour", "fall", "compose", "raster", "png", "gltf"];

/// One stage, over all its runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StageReport {
    /// Its name.
    pub name: String,
    /// How often it ran.
    pub runs: u64,
    /// Wall time of all runs, seconds.
    pub seconds: f64,
    /// Things made in all runs.
    pub items: u64,
    /// The largest error of any run.
    pub error: Option<ErrorFigure>,
    /// Further figures, of the last run; `cpu_seconds` is summed.
    pub figures: BTreeMap<String, Value>,
}

/// One frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FrameReport {
    /// Its number.
    pub index: i64,
    /// Its time, days.
    pub day: f64,
    /// Its date, with a weather series.
    pub date: Option<String>,
    /// Leaf sites of all trees.
    pub leaves: u64,
    /// How many leaves are in each state.
    pub states: BTreeMap<String, u64>,
    /// The share that the chain's law expects.
    pub expected: BTreeMap<String, f64>,
    /// How many have fallen.
    pub fallen: u64,
    /// What has become of all leaves that grew, where leaves fall: grown = attached + air + lying + decayed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fall: Option<Counts>,
    /// Name of the picture.
    pub png: Option<String>,
    /// Name of the glTF file.
    pub gltf: Option<String>,
    /// From where it was seen; none for a sheet, and where nothing was drawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view: Option<ViewReport>,
    /// Wall time of its own work, seconds; 0 for a frame that was there already.
    pub seconds: f64,
}

/// The camera and the sun of a frame, for those who light or lay other things to match: metres, y up.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ViewReport {
    /// Where the eye is.
    pub position: [f32; 3],
    /// The point in the middle of the picture.
    pub target: [f32; 3],
    /// Angle from the picture's lower to its upper rim, degrees.
    pub field_of_view: f32,
    /// Unit vector to the sun.
    pub sun: [f32; 3],
    /// The sun's irradiance on what faces it, linear sRGB.
    pub sun_irradiance: [f32; 3],
    /// The factor on radiance before the tone curve.
    pub exposure: f32,
}

/// What was chosen for the error that a scene asks for. Errors are root mean squares in linear light.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Reached {
    /// The error asked for.
    pub asked: f64,
    /// The error foreseen of the pictures, by measuring small ones.
    pub reached: f64,
    /// Whether the one is within the other.
    pub is_within: bool,
    /// Samples of a pixel.
    pub samples: u32,
    /// How many times as large in each direction a picture is drawn before it is averaged.
    pub enlarged: u32,
    /// Distance in pixels that a coarser mesh may lie from the full one.
    pub lod_error_px: f64,
    /// What was chosen for the leaves, species by species.
    pub leaves: Vec<ChosenLeaf>,
    /// The part of each stage in the error: leaf (the rim and the shapes of meshes), deform (the solver), raster (samples, levels
    /// of detail and textures).
    pub stages: BTreeMap<String, f64>,
}

/// What was chosen for the leaves of a species.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ChosenLeaf {
    /// The species.
    pub species: String,
    /// Vertices of its meshes.
    pub vertices: u32,
    /// Tolerance of its shapes, extents of the blade.
    pub tolerance: f64,
}

/// The report of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Report {
    /// Version of the program.
    pub version: String,
    /// Name of the scene.
    pub scene: String,
    /// Threads in use.
    pub threads: u64,
    /// Wall time of the run, seconds.
    pub seconds: f64,
    /// Largest memory that the process has held.
    pub peak_memory_bytes: u64,
    /// The stages that ran.
    pub stages: Vec<StageReport>,
    /// What the person should know of what was made.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// What was chosen for the error that the scene asks for, and what was reached.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quality: Option<Reached>,
    /// What was left out and why.
    pub left_out: Vec<LeftOut>,
    /// The frames asked for.
    pub frames: Vec<FrameReport>,
}

impl Report {
    /// Adds a run of a stage.
    pub fn add(&mut self, name: &str, seconds: f64, figures: Figures) {
        let new = figures.notes.into_iter().filter(|note| !self.notes.contains(note)).collect::<Vec<_>>();
        self.notes.extend(new);
        let stage = self.stage(name);
        stage.runs += 1;
        stage.seconds += seconds;
        stage.items += figures.items;
        if let Some(error) = figures.error {
            let larger = stage.error.as_ref().is_none_or(|known| error.value > known.value);
            if larger {
                stage.error = Some(error);
            }
        }
        for (key, value) in figures.values {
            let before = stage.figures.get(&key).and_then(Value::as_f64).filter(|_| key == "cpu_seconds");
            let summed = before.zip(value.as_f64()).map(|(a, b)| Value::from(a + b));
            stage.figures.insert(key, summed.unwrap_or(value));
        }
    }

    /// Adds time that a stage takes beside its runs: counting ahead, preparing what all frames share.
    pub fn spend(&mut self, name: &str, seconds: f64) {
        self.stage(name).seconds += seconds;
    }

    fn stage(&mut self, name: &str) -> &mut StageReport {
        let place = self.stages.iter().position(|stage| stage.name == name);
        let place = place.unwrap_or_else(|| {
            let rank = |name: &str| STAGES.iter().position(|stage| *stage == name);
            let at = self.stages.partition_point(|stage| rank(&stage.name) < rank(name));
            let figures = BTreeMap::new();
            let stage = StageReport { name: name.to_owned(), runs: 0, seconds: 0.0, items: 0, error: None, figures };
            self.stages.insert(at, stage);
            at
        });
        &mut self.stages[place]
    }

    /// A stage's figure; `None` when the stage did not run or has none of that name.
    #[must_use]
    pub fn figure(&self, stage: &str, name: &str) -> Option<&Value> {
        self.stages.iter().find(|known| known.name == stage)?.figures.get(name)
    }

    /// Adds a figure to a stage that ran, without counting a run.
    pub fn note(&mut self, stage: &str, name: &str, value: impl Into<Value>) {
        if let Some(stage) = self.stages.iter_mut().find(|known| known.name == stage) {
            stage.figures.insert(name.to_owned(), value.into());
        }
    }

    /// Keeps the figures of one species beside those of a stage that runs for each: `species.NAME.FIGURE`.
    pub fn note_of(&mut self, stage: &str, species: &str, figures: Figures) {
        let table = self.stage(stage).figures.entry("species".to_owned()).or_insert_with(|| Value::Object(Map::new()));
        if let Value::Object(table) = table {
            table.insert(species.to_owned(), Value::Object(figures.values.into_iter().collect()));
        }
    }

    /// The report of a run of this program that has done nothing yet.
    #[must_use]
    pub fn begun(scene: &str) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            scene: scene.to_owned(),
            threads: rayon::current_num_threads() as u64,
            ..Self::default()
        }
    }

    /// The short table for a person.
    #[must_use]
    pub fn table(&self) -> String {
        let mut text = format!("{:<8} {:>5} {:>10} {:>9}  error\n", "stage", "runs", "items", "seconds");
        for stage in &self.stages {
            let error = stage
                .error
                .as_ref()
                .map_or_else(String::new, |error| format!("{:.2e} {} ({})", error.value, error.unit, error.metric));
            let StageReport { name, runs, items, seconds, .. } = stage;
            let _ = writeln!(text, "{name:<8} {runs:>5} {items:>10} {seconds:>9.3}  {error}");
        }
        for left in &self.left_out {
            let _ = writeln!(text, "left out: {} ({})", shown(&left.what, LONGEST_NAME), left.reason);
        }
        let (frames, seconds) = (self.frames.len(), self.seconds);
        let megabytes = self.peak_memory_bytes as f64 / 1e6;
        let _ = writeln!(text, "{frames} frame(s) in {seconds:.2} s, {} thread(s), {megabytes:.0} MB", self.threads);
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_of_a_stage_add_up_in_the_order_of_the_work() {
        let mut report = Report::default();
        let error = |value| ErrorFigure { metric: "m".into(), value, unit: "u".into(), bound: None, how: "h".into() };
        report.add("raster", 1.0, Figures { error: Some(error(0.2)), ..Figures::of(3) }.with("cpu_seconds", 1.5));
        report.add("tree", 0.5, Figures::of(7));
        report.add("raster", 2.0, Figures { error: Some(error(0.1)), ..Figures::of(4) }.with("cpu_seconds", 2.0));
        let names: Vec<&str> = report.stages.iter().map(|stage| stage.name.as_str()).collect();
        assert_eq!(names, ["tree", "raster"]);
        let raster = &report.stages[1];
        assert_eq!((raster.runs, raster.items, raster.seconds), (2, 7, 3.0));
        assert_eq!(raster.error.as_ref().map(|e| e.value), Some(0.2));
        assert_eq!(raster.figures["cpu_seconds"], Value::from(3.5));
    }

    #[test]
    fn figures_are_noted_for_stages_that_ran_and_no_others() {
        let mut report = Report::default();
        report.add("tree", 0.5, Figures::of(7));
        report.note("tree", "leaf_area_index", 3.0);
        report.note("leaf", "vertices", 220);
        assert_eq!(report.figure("tree", "leaf_area_index"), Some(&Value::from(3.0)));
        assert_eq!((report.stages.len(), report.stages[0].runs), (1, 1));
        assert_eq!(report.figure("leaf", "vertices"), None);
    }
}
