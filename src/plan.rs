//! The plan of a run as data: the jobs that will be done, each with what it feeds, and what is left out, each with its
//! reason. Growing the tree and drawing the leaves' states is cheap, so both come first and narrow the rest: no shape is
//! bent and no texture painted that no leaf wears.

use crate::base::message::shown;
use crate::base::random::hash;
use crate::compose::{BROWN, Falls, Garment, LeafRun, Look, Stand, variant};
use crate::fall::Fate;
use crate::scene::image::Leaves;
use crate::scene::{Scene, Species};
use crate::season::{BUD, FALLEN, LeafStates};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// Longest name of an item that is printed, in characters; states have names of the user's choice.
const LONGEST_NAME: usize = 100;

/// Why something is left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub enum Reason {
    /// The scene does not ask for it.
    NotAskedFor,
    /// No leaf can come to that state.
    Unreachable,
    /// The state can be reached, but no leaf is in it in any frame that is drawn.
    WornByNoLeaf,
    /// Every leaf has fallen.
    NoLeafLeft,
    /// It equals this frame, whose files are written again under its name.
    SameAs(i64),
    /// It would change nothing.
    NoEffect,
    /// It was made before, and its files are whole.
    AlreadyDone,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotAskedFor => write!(f, "the scene does not ask for it"),
            Self::Unreachable => write!(f, "no leaf can come to that state"),
            Self::WornByNoLeaf => write!(f, "worn by no leaf in any frame"),
            Self::NoLeafLeft => write!(f, "every leaf has fallen"),
            Self::SameAs(frame) => write!(f, "same as frame {frame}"),
            Self::NoEffect => write!(f, "it would change nothing"),
            Self::AlreadyDone => write!(f, "made before"),
        }
    }
}

/// Something that is not done.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// What: a stage (`png`) or one of its items (`deform brown 2`).
    pub what: String,
    /// Why.
    pub reason: Reason,
}

/// Something that is done.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Job {
    /// The stage, by the name it has in the report.
    pub stage: &'static str,
    /// Which of the stage's items; empty for a stage that makes one thing.
    pub name: String,
    /// The stages that use the result.
    pub feeds: Vec<&'static str>,
}

/// A frame that is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PlannedFrame {
    /// Its number.
    pub index: i64,
    /// Its time, days.
    pub day: f64,
    /// The earlier frame that has the same leaves, if there is one.
    pub same_as: Option<i64>,
}

/// The jobs of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Plan {
    /// What is done, in order.
    pub jobs: Vec<Job>,
    /// What is not done.
    pub left_out: Vec<LeftOut>,
    /// The frames.
    pub frames: Vec<PlannedFrame>,
    /// Whether a leaf hangs on a tree in any frame.
    #[serde(skip)]
    pub is_worn: bool,
    /// What leaves wear in any frame: the shapes.
    #[serde(skip)]
    pub garments: Vec<Garment>,
    /// The textures that leaves show in any frame: those of what they wear, and of what they turn to on the ground.
    #[serde(skip)]
    pub painted: Vec<Garment>,
    /// What fallen leaves look like in any frame.
    #[serde(skip)]
    pub fallen: BTreeSet<(Garment, Look)>,
}

/// What is known of a frame before anything costly is done.
#[derive(Clone, Debug, Default)]
pub struct Counted {
    /// The frame's number.
    pub index: i64,
    /// Its time, days.
    pub day: f64,
    /// The garments that its leaves wear.
    pub worn: BTreeSet<Garment>,
    /// What its fallen leaves look like.
    pub looks: BTreeSet<(Garment, Look)>,
    /// A number that is equal for frames with the same leaves in the same garments.
    pub signature: u64,
}

/// What every leaf wears, in the order of the stand's ids; `None` for a leaf that has fallen or whose species has no seasons.
#[must_use]
pub fn garments(scene: &Scene, stand: &Stand, states: &LeafStates) -> Vec<Option<Garment>> {
    let on_the_tree: Vec<bool> = states.names.iter().map(|name| !is_off_the_tree(name)).collect();
    let counts: Vec<u32> = scene.species.iter().map(Species::variants).collect();
    let of_run = |LeafRun { form, places, .. }: LeafRun<'_>| {
        let wears = |(&id, &state): (&u64, &u16)| {
            let hangs = on_the_tree.get(usize::from(state)).copied().unwrap_or(false);
            let variant = || variant(scene.seed, id, counts[form.species]);
            hangs.then(|| Garment { species: form.species as u16, state, variant: variant() })
        };
        let leaves = stand.leaf_ids[places.clone()].iter().zip(&states.states[places]);
        leaves.map(wears).collect::<Vec<_>>()
    };
    stand.leaf_runs().into_par_iter().flat_map_iter(of_run).collect()
}

/// Whether a leaf in this state shows no leaf on the tree.
#[must_use]
pub fn is_off_the_tree(state: &str) -> bool {
    state == FALLEN || state == BUD
}

/// What is known of a species before anything costly is done.
#[derive(Clone, Debug, Default)]
pub struct Roll {
    /// Trees of the species.
    pub trees: usize,
    /// Different forms of them.
    pub forms: usize,
    /// Numbers of its states, ascending; empty without leaves or seasons.
    pub states: Vec<u16>,
    /// Whether a leaf can come to each of them.
    pub reachable: Vec<bool>,
}

/// Plans the frames that were counted. `states` names the states of all species, `rolls` holds what is known of each. With
/// `leave_out` false every shape and texture is a job and no frame is taken from another: the same files come out, which
/// tests use to prove that nothing left out was needed.
#[must_use]
pub fn plan(scene: &Scene, states: &[String], rolls: &[Roll], counted: &[Counted], leave_out: bool) -> Plan {
    let is_worn = counted.iter().any(|frame| !frame.worn.is_empty());
    let mut plan = Plan { is_worn, ..Plan::default() };
    let is_one = rolls.iter().map(|roll| roll.trees).sum::<usize>() == 1;
    for (species, roll) in scene.species.iter().zip(rolls) {
        let Roll { trees, forms, .. } = roll;
        let name = if is_one { String::new() } else { format!("{} ({trees} trees, {forms} forms)", species.label()) };
        plan.job("tree", &name, &["season", "compose"]);
    }
    if counted.is_empty() {
        for stage in ["fall", "leaf", "deform", "colour", "compose", "raster", "png", "gltf"] {
            plan.leave(stage, Reason::AlreadyDone);
        }
        return plan;
    }
    if states.is_empty() {
        for stage in ["season", "fall", "leaf", "deform", "colour"] {
            plan.leave(stage, Reason::NotAskedFor);
        }
    } else {
        let fallen: BTreeSet<(Garment, Look)> = counted.iter().flat_map(|frame| frame.looks.iter().copied()).collect();
        let falls = scene.leaves_fall() && !(fallen.is_empty() && leave_out);
        plan.job("season", "", if falls { &["fall", "compose"] } else { &["compose"] });
        if falls {
            plan.fallen = fallen;
            plan.job("fall", "", &["compose"]);
        } else {
            plan.leave("fall", if scene.leaves_fall() { Reason::NoEffect } else { Reason::NotAskedFor });
        }
        for number in 0..rolls.len() {
            plan_leaves(&mut plan, scene, states, (number, &rolls[number]), counted, leave_out);
        }
    }
    plan_outputs(&mut plan, scene);
    // A camera that turns sees the same leaves from another side.
    plan_frames(&mut plan, counted, leave_out && scene.camera.turn == 0.0);
    plan
}

impl Plan {
    fn job(&mut self, stage: &'static str, name: &str, feeds: &[&'static str]) {
        self.jobs.push(Job { stage, name: name.to_owned(), feeds: feeds.to_vec() });
    }

    fn leave(&mut self, what: impl Into<String>, reason: Reason) {
        self.left_out.push(LeftOut { what: what.into(), reason });
    }

    /// Whether a stage has a job.
    #[must_use]
    pub fn has(&self, stage: &str) -> bool {
        self.jobs.iter().any(|job| job.stage == stage)
    }

    /// What leaves of a species wear in any frame.
    #[must_use]
    pub fn garments_of(&self, species: usize) -> Vec<Garment> {
        of_species(&self.garments, species)
    }

    /// The garments of a species whose textures are shown in any frame.
    #[must_use]
    pub fn painted_of(&self, species: usize) -> Vec<Garment> {
        of_species(&self.painted, species)
    }

    /// The plans of a contact sheet's cells as one, each job told with its cell; what every cell leaves out is told once.
    #[must_use]
    pub fn of_sheet(cells: &[(String, Self)]) -> Self {
        let mut sheet = Self::default();
        for (cell, plan) in cells {
            let of_cell = |what: &str| format!("{what} ({cell})").trim_start().to_owned();
            sheet.jobs.extend(plan.jobs.iter().map(|job| Job { name: of_cell(&job.name), ..job.clone() }));
            for left in &plan.left_out {
                if !cells.iter().all(|(_, other)| other.left_out.contains(left)) {
                    sheet.left_out.push(LeftOut { what: of_cell(&left.what), ..left.clone() });
                } else if !sheet.left_out.contains(left) {
                    sheet.left_out.push(left.clone());
                }
            }
            sheet.frames.clone_from(&plan.frames);
        }
        sheet
    }
}

fn of_species(garments: &[Garment], species: usize) -> Vec<Garment> {
    garments.iter().copied().filter(|garment| usize::from(garment.species) == species).collect()
}

/// The jobs of one species; where there are several, its name stands before theirs.
fn plan_leaves(
    plan: &mut Plan,
    scene: &Scene,
    states: &[String],
    (number, roll): (usize, &Roll),
    counted: &[Counted],
    leave_out: bool,
) {
    let species = &scene.species[number];
    let label = if scene.species.len() == 1 { String::new() } else { format!("{} ", species.label()) };
    if roll.states.is_empty() {
        for stage in ["leaf", "deform", "colour"] {
            plan.leave(format!("{stage} {label}").trim_end(), Reason::NotAskedFor);
        }
        return;
    }
    let of_plan = std::mem::take(&mut plan.fallen);
    let [worn, painted] = needed(counted, &of_plan, states, roll);
    plan.fallen = of_plan;
    let every = roll.states.iter().filter(|&&state| !is_off_the_tree(&states[usize::from(state)]));
    let garment = |state: u16, variant: u32| Garment { species: number as u16, state, variant };
    let every = every.flat_map(|&state| (0..species.variants()).map(move |variant| garment(state, variant)));
    let every: Vec<Garment> = every.collect();
    let split = |needed: &BTreeSet<Garment>| -> (Vec<Garment>, Vec<Garment>) {
        every.iter().partition(|garment| !leave_out || needed.contains(garment))
    };
    let (shapes, textures) = (split(&worn), split(&painted));
    if shapes.0.is_empty() {
        for stage in ["leaf", "deform", "colour"] {
            plan.leave(format!("{stage} {label}").trim_end(), Reason::NoLeafLeft);
        }
        return;
    }
    plan.job("leaf", label.trim_end(), &["deform", "colour"]);
    let is_reachable = |state: u16| {
        let place = roll.states.binary_search(&state);
        place.is_ok_and(|place| roll.reachable.get(place).copied().unwrap_or(false))
    };
    let textured = scene.output.png || scene.output.gltf.is_some();
    for (stage, (kept, dropped), count) in
        [("deform", &shapes, species.deform.shapes), ("colour", &textures, species.colour.variants)]
    {
        if stage == "colour" && !(textured && scene.image.leaves == Leaves::Lit) {
            plan.leave(format!("{stage} {label}").trim_end(), Reason::NotAskedFor);
            continue;
        }
        let made = items(kept, count);
        for (state, variant) in &made {
            plan.job(stage, &format!("{label}{} {variant}", states[usize::from(*state)]), &["compose"]);
        }
        for (state, variant) in items(dropped, count).difference(&made) {
            let reason = if is_reachable(*state) { Reason::WornByNoLeaf } else { Reason::Unreachable };
            plan.leave(format!("{stage} {label}{} {variant}", states[usize::from(*state)]), reason);
        }
    }
    plan.garments.extend(shapes.0);
    plan.painted.extend(textures.0);
}

/// The garments of a species whose shapes and whose textures leaves show in any frame.
fn needed(
    counted: &[Counted],
    fallen: &BTreeSet<(Garment, Look)>,
    states: &[String],
    roll: &Roll,
) -> [BTreeSet<Garment>; 2] {
    let hanging: BTreeSet<Garment> = counted.iter().flat_map(|frame| frame.worn.iter().copied()).collect();
    let (mut worn, mut painted) = (hanging.clone(), hanging);
    let brown = states.iter().position(|state| state == BROWN).map(|place| place as u16);
    let brown = brown.filter(|state| roll.states.contains(state));
    for &(garment, look) in fallen {
        worn.insert(garment);
        let turned = matches!(look, Look::Brown | Look::Flat);
        painted.insert(brown.filter(|_| turned).map_or(garment, |state| Garment { state, ..garment }));
    }
    [worn, painted]
}

/// A number that is equal for frames whose fallen leaves lie alike; `sum` is that of the leaves that hang.
#[must_use]
pub fn signature_of_falls(sum: u64, falls: &Falls, day: f64) -> u64 {
    let moves = |fate: Fate| match fate {
        Fate::Air(_) => day.to_bits(),
        Fate::Fresh(share) if share < 1.0 => day.to_bits(),
        _ => 0,
    };
    let of_leaf = |sum: u64, fall: &crate::compose::Fall| {
        let look = fall.look().map_or(0, |look| look as u64 + 1);
        hash(hash(hash(sum, fall.leaf.leaf), fall.leaf.year << 8 | look), moves(fall.fate))
    };
    falls.seen.iter().fold(sum, of_leaf)
}

/// The items of a stage that makes `count` variants of a state, for these garments of one species.
#[must_use]
pub fn items(garments: &[Garment], count: u32) -> BTreeSet<(u16, u32)> {
    garments.iter().map(|garment| (garment.state, garment.variant % count.max(1))).collect()
}

fn plan_outputs(plan: &mut Plan, scene: &Scene) {
    let png = scene.output.png;
    let gltf = scene.output.gltf.is_some();
    if png || gltf {
        let feeds: &[&'static str] = match (png, gltf) {
            (true, true) => &["raster", "gltf"],
            (true, false) => &["raster"],
            _ => &["gltf"],
        };
        plan.job("compose", "", feeds);
    } else {
        plan.leave("compose", Reason::NotAskedFor);
    }
    if png {
        plan.job("raster", "", &["png"]);
        plan.job("png", "", &[]);
    } else {
        plan.leave("raster", Reason::NotAskedFor);
        plan.leave("png", Reason::NotAskedFor);
    }
    if gltf {
        plan.job("gltf", "", &[]);
    } else {
        plan.leave("gltf", Reason::NotAskedFor);
    }
    if scene.light.shadow_size > 0
        && (scene.light.sun <= 0.0 || (scene.light.date.is_none() && scene.light.sun_elevation <= 0.0))
    {
        plan.leave("raster shadow map", Reason::NoEffect);
    }
}

fn plan_frames(plan: &mut Plan, counted: &[Counted], leave_out: bool) {
    let mut first: BTreeMap<u64, i64> = BTreeMap::new();
    for frame in counted {
        let earlier = first.get(&frame.signature).copied().filter(|_| leave_out);
        if let Some(index) = earlier {
            plan.leave(format!("raster frame {}", frame.index), Reason::SameAs(index));
        }
        first.entry(frame.signature).or_insert(frame.index);
        plan.frames.push(PlannedFrame { index: frame.index, day: frame.day, same_as: earlier });
    }
}

impl Plan {
    /// The plan for a person: the jobs in the order of the work, then what is left out and why.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = format!("{} frame(s)\n", self.frames.len());
        for job in &self.jobs {
            let name = if job.name.is_empty() { String::new() } else { format!(" {}", job.name) };
            let feeds = if job.feeds.is_empty() { String::new() } else { format!(" -> {}", job.feeds.join(", ")) };
            text.push_str(&format!("run      {}{}{feeds}\n", job.stage, shown(&name, LONGEST_NAME)));
        }
        for left in &self.left_out {
            text.push_str(&format!("left out {} ({})\n", shown(&left.what, LONGEST_NAME), left.reason));
        }
        text
    }
}
