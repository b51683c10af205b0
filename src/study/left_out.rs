//! What a scene does not need, left out and measured: variants of one scene, each in a process of its own.

use super::desk::Desk;
use super::numbers::{median, shown};
use super::own;
use super::stage::{AUTUMN, staged};
use super::table::{Field, Table};
use crate::base::diagnostic::Diagnostics;
use crate::run::progress::{Mode, Progress};
use crate::run::signals::Signals;
use crate::run::{self, Options};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

const COLUMNS: [&str; 12] = [
    "scene",
    "changes",
    "stages_run",
    "stages_absent",
    "deform_iterations",
    "textures",
    "left_out",
    "reasons",
    "same_bytes",
    "cpu_s_median",
    "ratio_to_full",
    "memory_peak_mb",
];
const STAGES: [&str; 10] = ["tree", "season", "leaf", "deform", "colour", "fall", "compose", "raster", "png", "gltf"];
/// What makes a scene small enough to be drawn with everything that could be left out.
const SMALL: [&str; 6] = [
    "image.width=64",
    "image.height=48",
    "image.samples=1",
    "leaf.vertices=60",
    "colour.size=32",
    "light.shadow_size=256",
];
/// Variants of a quick study.
const QUICK: usize = 6;
/// Of the built-in scene, so that it grows fast.
const YOUNG: &str = "tree.age=5";
/// Processor time of a variant in a round, seconds, and how often it is done to come to that.
const LEAST: f64 = 0.3;
const MOST_TIMES: u32 = 6;
/// What is said of a variant that a scene of the user's does not have: two keys that exclude one another, a limit.
const APART: &str = "no such variant";
/// The share of the full scene's processor time that a bare tree may cost.
const BARE: f64 = 0.15;

/// A variant: its name, what it changes, and what may be added to it for the proof without changing a byte.
struct Variant {
    name: &'static str,
    sets: &'static [&'static str],
    /// A skip that is no job of the plan: the scene without it must give the same picture.
    instead: &'static [&'static str],
}

const fn variant(name: &'static str, sets: &'static [&'static str]) -> Variant {
    Variant { name, sets, instead: &[] }
}

/// The first six are those of a quick study: the full scene first, then the pair that is judged.
const VARIANTS: [Variant; 15] = [
    variant("full", &[]),
    variant("no ground", &["ground.kind=none"]),
    variant("bare winter, no ground", &["time.day=400", "ground.kind=none"]),
    variant("bare winter", &["time.day=400"]),
    variant("glTF only", &["output={png=false, gltf=\"nodes\"}"]),
    variant("one leaf", &["tree={axiom=\"L(1)\", rules=[], petiole=30.0}", "camera.subject=leaf"]),
    variant("picture only", &["output={png=true, inset=true}"]),
    variant("no inset", &["output={png=true, gltf=\"nodes\", inset=false}"]),
    Variant { name: "no sun", sets: &["light.sun=0"], instead: &["light.shadow_size=0"] },
    variant("no shadow", &["light.shadow_size=0"]),
    variant("leaf fall off", &["fall.on=false"]),
    variant("leaf fall only", &["time.day=30"]),
    variant("paper's leaves", &["deform.model=paper"]),
    variant("paper's seasons", &["season.mode=paper"]),
    variant("summer", &["time.day=0.2"]),
];

/// What a process did.
#[derive(Clone, Debug, Default)]
struct Done {
    seconds: f64,
    report: Value,
}

/// Runs the family, on the scene at hand if there is one.
///
/// # Errors
/// Scenes that cannot be made, files that cannot be written.
pub fn study(desk: &mut Desk<'_>) -> Result<(), Diagnostics> {
    let Some(program) = desk.request.program.clone() else {
        desk.section("Left out", "Not measured: this program's own file cannot be found.");
        return Ok(());
    };
    if desk.request.subject.as_ref().is_some_and(|subject| subject.scene.cell_count() > 0) {
        desk.section(
            "Left out",
            "Not measured: a contact sheet is many scenes. Study one of its cells as a scene of its own.",
        );
        return Ok(());
    }
    let (path, own_sets) = match &desk.request.subject {
        Some(subject) => {
            let [width, height] = own::sides(&subject.scene, desk.request.quick);
            let sides = [format!("image.width={width}"), format!("image.height={height}")];
            (subject.path.clone(), subject.sets.iter().cloned().chain(sides).collect())
        }
        None => (staged(desk, "autumn", AUTUMN, &[])?.1, Vec::new()),
    };
    let rounds = if desk.request.quick { 1 } else { 5 };
    let variants = if desk.request.quick { &VARIANTS[..QUICK] } else { &VARIANTS[..] };
    let scratch = desk.request.out.join("left-out-scratch");
    let mut done: Vec<Vec<Done>> = variants.iter().map(|_| Vec::new()).collect();
    for round in 0..rounds {
        for (variant, done) in variants.iter().zip(&mut done) {
            let sets: Vec<String> =
                own_sets.iter().cloned().chain(variant.sets.iter().map(|s| (*s).to_owned())).collect();
            let one = rendered(&program, &path, &sets, &scratch);
            desk.tell(&format!("left out, {}, round {}: {} s", variant.name, round + 1, shown(one.seconds)));
            done.push(one);
        }
    }
    let mut table = Table::new(&COLUMNS);
    let mut differing = Vec::new();
    for (number, variant) in variants.iter().enumerate() {
        let is_drawn = done[number].iter().all(|one| !one.report.is_null());
        let same = if is_drawn { proof(desk, &path, &own_sets, variant, &scratch) } else { APART.to_owned() };
        desk.tell(&format!("left out, {}: {same} with skips disabled", variant.name));
        if same != "the same" && same != APART {
            differing.push(format!("{}: {same}", variant.name));
        }
        table.push(row(variant, &done[number], &done[0], &same));
    }
    let _ = fs::remove_dir_all(&scratch);
    desk.write_table("leftout.csv", &table)?;
    judge(desk, &done, &differing);
    let text = format!(
        "Each variant is drawn by a process of its own on one thread, in turn with the others, {rounds} times. \
         `same_bytes`: a small picture of the variant with everything made that the plan leaves out.\n\n{}",
        table.markdown(&COLUMNS)
    );
    desk.section("Left out", &text);
    Ok(())
}

/// Renders in a process of its own; its processor time and report. What is short is done again until the kernel's ticks, a
/// hundredth of a second, no longer show.
fn rendered(program: &Path, scene: &Path, sets: &[String], scratch: &Path) -> Done {
    let report = scratch.join("report.json");
    let before = children_seconds();
    let mut times = 0;
    loop {
        let _ = fs::remove_dir_all(scratch);
        let _ = fs::create_dir_all(scratch);
        let mut command = Command::new(program);
        command.arg("render").arg(scene).arg("--out").arg(scratch.join("out")).arg("--report").arg(&report);
        command.args(["--threads", "1", "--progress", "none", "--force", "--frames", "0"]);
        sets.iter().for_each(|set| {
            command.arg("--set").arg(set);
        });
        let _ = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).status();
        times += 1;
        let spent = children_seconds() - before;
        if spent >= LEAST || times >= MOST_TIMES {
            let text = fs::read(&report).unwrap_or_default();
            return Done {
                seconds: spent / f64::from(times),
                report: serde_json::from_slice(&text).unwrap_or_default(),
            };
        }
    }
}

/// Processor time of the processes that this one has waited for, seconds; the 14th and 15th field after the name in brackets.
fn children_seconds() -> f64 {
    let stat = fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after = stat.rsplit_once(')').map_or("", |(_, rest)| rest);
    let ticks: u64 = after.split_whitespace().skip(13).take(2).filter_map(|field| field.parse::<u64>().ok()).sum();
    ticks as f64 / 100.0
}

impl Done {
    fn stage(&self, name: &str) -> Option<&Value> {
        self.report["stages"].as_array()?.iter().find(|stage| stage["name"] == name)
    }

    fn iterations(&self) -> u64 {
        self.stage("deform").and_then(|stage| stage["figures"]["iterations"].as_u64()).unwrap_or(0)
    }

    fn textures(&self) -> u64 {
        self.stage("colour").and_then(|stage| stage["items"].as_u64()).unwrap_or(0)
    }

    /// How often each reason stands in the list of what was left out.
    fn reasons(&self) -> BTreeMap<String, u64> {
        let mut reasons = BTreeMap::new();
        for left in self.report["left_out"].as_array().into_iter().flatten() {
            let reason = left["reason"].as_str().map_or_else(|| left["reason"].to_string(), str::to_owned);
            *reasons.entry(reason).or_default() += 1;
        }
        reasons
    }
}

fn row(variant: &Variant, done: &[Done], full: &[Done], same: &str) -> Vec<Field> {
    let first = done.first().cloned().unwrap_or_default();
    let is_there = |name: &&&str| first.stage(name).is_some();
    let there: Vec<&str> = STAGES.iter().filter(is_there).copied().collect();
    let absent: Vec<&str> = STAGES.iter().filter(|name| !is_there(name)).copied().collect();
    let reasons = first.reasons();
    let ratios: Vec<f64> = done.iter().zip(full).map(|(own, full)| own.seconds / full.seconds.max(0.01)).collect();
    let memory = done.iter().filter_map(|one| one.report["peak_memory_bytes"].as_f64()).fold(0.0, f64::max);
    let listed = reasons.iter().map(|(reason, count)| format!("{reason} {count}")).collect::<Vec<_>>().join(" ");
    vec![
        variant.name.into(),
        variant.sets.join(" ").into(),
        there.join(" ").into(),
        absent.join(" ").into(),
        first.iterations().into(),
        first.textures().into(),
        reasons.values().sum::<u64>().into(),
        listed.into(),
        same.into(),
        median(&done.iter().map(|one| one.seconds).collect::<Vec<_>>()).into(),
        median(&ratios).into(),
        (memory / 1e6).into(),
    ]
}

/// Whether a small picture of a variant is the same with everything made that is left out.
fn proof(desk: &Desk<'_>, path: &Path, own: &[String], variant: &Variant, scratch: &Path) -> String {
    let drawn = |folder: &str, leave_out: bool, more: &[&str]| -> Result<Vec<Vec<u8>>, String> {
        let young = desk.request.subject.is_none().then_some(&YOUNG);
        let small = SMALL.iter().chain(young).filter(|set| !clashes(set, variant.sets));
        let changes = small.chain(variant.sets).chain(more);
        let sets: Vec<String> = own.iter().cloned().chain(changes.map(|set| (*set).to_owned())).collect();
        let (scene, _) =
            crate::scene::read(path, &sets, &[], &desk.request.limits).map_err(|faults| faults.to_string())?;
        let out = scratch.join(folder);
        let _ = fs::remove_dir_all(&out);
        let frames = Some("0".parse().map_err(|_| "a frame list".to_owned())?);
        let options = Options { out: out.clone(), frames, force: true, leave_out, ..Options::default() };
        run::render(&scene, &options, &mut Progress::new(Mode::None), &Signals::default())
            .map_err(|f| f.to_string())?;
        Ok(pictures(&out))
    };
    let compared = || -> Result<bool, String> {
        let (all, own) = (drawn("all", false, &[])?, drawn("own", true, &[])?);
        let instead = if variant.instead.is_empty() { own.clone() } else { drawn("instead", true, variant.instead)? };
        Ok(!own.is_empty() && all == own && instead == own)
    };
    match compared() {
        Ok(true) => "the same".to_owned(),
        Ok(false) => "DIFFERENT".to_owned(),
        Err(fault) => fault.lines().next().unwrap_or_default().to_owned(),
    }
}

/// Whether a change of what makes scenes small would stand beside one of the variant's own: of the same key or table.
fn clashes(set: &str, own: &[&str]) -> bool {
    let key = |set: &str| set.split('=').next().unwrap_or_default().to_owned();
    let table = key(set).split('.').next().unwrap_or_default().to_owned();
    own.iter().any(|other| key(other) == key(set) || key(other) == table)
}

/// The pictures and models of a folder, by their names' order; not the manifests, which tell of the run.
fn pictures(folder: &Path) -> Vec<Vec<u8>> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut paths: Vec<PathBuf> =
        entries.filter(|path| path.extension().is_some_and(|e| e == "png" || e == "glb")).collect();
    paths.sort();
    paths.iter().filter_map(|path| fs::read(path).ok()).collect()
}

fn judge(desk: &mut Desk<'_>, done: &[Vec<Done>], differing: &[String]) {
    let ratio = |own: usize, unit: usize| {
        let ratios: Vec<f64> =
            done[own].iter().zip(&done[unit]).map(|(own, unit)| own.seconds / unit.seconds.max(0.01)).collect();
        median(&ratios)
    };
    let (bare, with_grass) = (ratio(2, 1), ratio(3, 0));
    let (steps, textures) = done[2].first().map_or((0, 0), |one| (one.iterations(), one.textures()));
    let is_drawn = done[..4].iter().flatten().all(|one| one.stage("raster").is_some());
    let is_light = if bare <= BARE { "within" } else { "above" };
    let found = format!(
        "{steps} iterations, {textures} textures; {:.1} % of the processor time, {is_light} the 15 % aimed at ({:.1} % with the \
         grass, which both draw)",
        bare * 100.0,
        with_grass * 100.0
    );
    if desk.request.subject.is_some() {
        // When a tree of the user's is bare is for its weather to say.
        return desk.judge(
            "L2",
            differing.is_empty(),
            "what is left out would have changed no byte",
            told(done, differing),
        );
    }
    let asked = "a bare tree takes no iteration of the solver and no texture (its time against the same tree in autumn is told, \
                 not judged)";
    desk.judge("L1", is_drawn && steps == 0 && textures == 0, asked, found);
    desk.judge("L2", differing.is_empty(), "what is left out would have changed no byte", told(done, differing));
}

/// How many variants were drawn, or which of them differ.
fn told(done: &[Vec<Done>], differing: &[String]) -> String {
    let drawn = done.iter().filter(|rounds| rounds.iter().all(|one| !one.report.is_null())).count();
    if differing.is_empty() { format!("all {drawn} variants") } else { differing.join("; ") }
}
