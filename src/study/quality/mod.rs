//! The promise of `[quality] error`: what is asked for against what is reached, over a ladder of errors on several scenes.

mod exact;

use super::chart::{self, Curve};
use super::desk::{Desk, bug};
use super::linear::Linear;
use super::numbers::shown;
use super::own;
use super::stage::{BIRCH, LEAF, TREE, TWIG, WINTER, staged};
use super::table::{Field, Table};
use crate::base::diagnostic::Diagnostics;
use crate::report::Reached;
use crate::run::progress::{Mode, Progress};
use crate::run::quality::Chooser;
use crate::run::signals::Signals;
use crate::run::{self, Options};
use crate::scene::{self, Asset, Scene};
use exact::{References, VERTICES};
use std::fs;

const COLUMNS: [&str; 14] = [
    "scene",
    "asked",
    "reached",
    "foreseen",
    "told_within",
    "kept",
    "samples",
    "enlarged",
    "lod_error_px",
    "vertices",
    "tolerance",
    "foreseen_leaf",
    "foreseen_raster",
    "seconds",
];
/// The errors that are asked for.
const ASKED: [f64; 6] = [0.1, 0.05, 0.03, 0.02, 0.01, 0.007];
const FEW: [f64; 1] = [0.04];
const FEW_OF_OWN: [f64; 2] = [0.05, 0.02];

/// Runs the family, on the scene at hand if there is one.
///
/// # Errors
/// Scenes that cannot be made, files that cannot be written.
pub fn study(desk: &mut Desk<'_>) -> Result<(), Diagnostics> {
    let quick = desk.request.quick;
    let pictured = |scene: &Scene| (scene.name.clone(), own::pictured(scene, quick));
    let own = desk.request.subject.as_ref().map(|subject| pictured(&subject.scene));
    let asked = match (quick, &own) {
        (true, None) => &FEW[..],
        (true, Some(_)) => &FEW_OF_OWN[..],
        (false, _) => &ASKED[..],
    };
    let mut scenes: Vec<(String, Scene)> = match own {
        Some(own) => vec![own],
        None => {
            let all = [("leaf", LEAF), ("tree", TREE), ("birch", BIRCH), ("twig", TWIG), ("winter", WINTER)];
            let wanted = if desk.request.quick { &all[..2] } else { &all[..] };
            let read = |&(name, text): &(&str, &str)| Ok((name.to_owned(), staged(desk, name, text, &[])?.0));
            wanted.iter().map(read).collect::<Result<_, Diagnostics>>()?
        }
    };
    let mut table = Table::new(&COLUMNS);
    let (mut curves, mut broken, mut out_of_reach) = (Vec::new(), Vec::new(), Vec::new());
    let (mut floor, mut cheaper, mut settings) = (0.0f64, Vec::new(), Vec::new());
    for (name, scene) in &mut scenes {
        // Nothing but the picture is judged.
        (scene.output.gltf, scene.output.inset) = (None, false);
        let mut references = References::new(desk, scene)?;
        let mut chooser = Chooser::new(scene, &desk.request.limits);
        let (mut points, mut work) = (Vec::new(), Vec::new());
        for &asked in asked {
            let (picture, told, seconds) = drawn(desk, scene, asked, &mut chooser)?;
            let exact = references.of(desk, name, &told)?;
            floor = floor.max(exact.floor);
            let reached = picture.distance(&exact.picture).rmse;
            let kept = reached <= asked;
            if told.is_within && !kept {
                broken.push(format!("{name}: {asked} asked, {} reached", shown(reached)));
            }
            if !told.is_within {
                out_of_reach.push(format!("{name} {asked}"));
            }
            desk.tell(&format!(
                "quality {name}: {asked} asked, {} reached, {} samples x {}",
                shown(reached),
                told.samples,
                told.enlarged
            ));
            table.push(row(name, &told, reached, seconds));
            points.push([asked, reached]);
            work.push(told.samples * told.enlarged * told.enlarged);
            settings.push((told, reached));
        }
        cheaper.push(work.is_sorted());
        curves.push(Curve::new(name.clone(), points));
    }
    desk.write_table("quality.csv", &table)?;
    let frame = chart::Frame {
        title: "The error that a scene asks for, and the one it gets",
        x: ["root mean square error asked for", ""],
        y: ["error reached", ""],
        orders: &[],
        floor: Some(floor),
        left_out: &[],
    };
    let mut plot = chart::chart(&frame, &curves);
    if let Some(panel) = plot.panels.first_mut() {
        let label = "as asked".to_owned();
        panel.guides.push(crate::plot::Guide::Slope { order: 1.0, through: [0.01, 0.01], label });
    }
    desk.write_chart("quality", &plot)?;
    let rows = table.rows.len();
    let reach = if out_of_reach.is_empty() {
        String::new()
    } else {
        format!("; told to be out of reach: {}", out_of_reach.join(", "))
    };
    let found = if broken.is_empty() {
        format!("{rows} pictures of {} scenes{reach}", scenes.len())
    } else {
        broken.join("; ")
    };
    desk.judge(
        "Q1",
        broken.is_empty(),
        "no picture has a larger error than was asked for, unless the report says so",
        found,
    );
    let found =
        if cheaper.iter().all(|is| *is) { "in every scene".to_owned() } else { "not in every scene".to_owned() };
    desk.judge("Q2", cheaper.iter().all(|is| *is), "a larger error asked for never takes more samples", found);
    let text = format!(
        "`reached` is the distance of the picture that was written from one drawn many times as large with leaves of \
         {VERTICES} vertices in the same textures; `foreseen` is what the report told, and `told_within` whether it told that the error is \
         kept.\n\n![asked and reached](quality.png)\n\n{}",
        table.markdown(&COLUMNS)
    );
    desk.section("The error that a scene asks for", &text);
    if desk.request.subject.is_some() {
        let [width, height] = [scenes[0].1.image.width, scenes[0].1.image.height];
        desk.section("Recommendation", &recommendation(&settings, [width, height]));
    }
    Ok(())
}

/// The cheapest settings that were seen to reach errors, as lines to be written into the scene, the coarsest first; settings
/// that were chosen for several errors stand once, with the least of them.
fn recommendation(settings: &[(Reached, f64)], [width, height]: [u32; 2]) -> String {
    let mut lines: Vec<(String, String)> = Vec::new();
    for (told, reached) in settings {
        let line = format!("`{}`{}", setting(told), enlarged(told));
        let fit = if *reached <= told.asked { "reaches" } else { "MISSES" };
        let text = format!("\n- {fit} {} ({} measured): {line}", told.asked, shown(*reached));
        lines.retain(|(known, _)| *known != line);
        lines.push((line, text));
    }
    let texts: Vec<String> = lines.into_iter().map(|(_, text)| text).collect();
    format!(
        "Write `[quality] error` into the scene, or set what it chose here for a picture of {width} x {height} pixels:\n{}",
        texts.concat()
    )
}

/// What was chosen, as assignments of a scene.
fn setting(told: &Reached) -> String {
    let (samples, lod) = (told.samples, shown(told.lod_error_px));
    let mut text = format!("image.samples = {samples}, image.lod_error = {lod}");
    // Species have their own tables in a scene of several; there the names tell which.
    let is_one = told.leaves.len() == 1;
    for leaf in &told.leaves {
        let name = if is_one { String::new() } else { format!("{}: ", leaf.species) };
        let tolerance = shown(leaf.tolerance);
        text.push_str(&format!(", {name}leaf.vertices = {}, deform.shell.tolerance = {tolerance}", leaf.vertices));
    }
    text
}

fn enlarged(told: &Reached) -> String {
    match told.enlarged {
        1 => String::new(),
        times => format!(", drawn {times} times as large (which only `[quality] error` does)"),
    }
}

/// Renders the scene with an error asked for, as a run does; the picture that was written, what was told, and the seconds.
fn drawn(
    desk: &Desk<'_>,
    scene: &Scene,
    asked: f64,
    chooser: &mut Chooser,
) -> Result<(Linear, Reached, f64), Diagnostics> {
    let mut scene = scene.clone();
    scene.quality.error = Some(asked);
    let out = desk.request.out.join("quality-scratch");
    let _ = fs::remove_dir_all(&out);
    let options = Options { out: out.clone(), force: true, limits: desk.request.limits.clone(), ..Options::default() };
    let options = Options { frames: Some("0".parse().map_err(|_| bug("a frame list"))?), ..options };
    let watched = (&mut Progress::new(Mode::None), &Signals::default());
    let outcome = run::render_by(&scene, &options, watched, |error| chooser.choose(error))?;
    let name = outcome.report.frames.first().and_then(|frame| frame.png.clone()).unwrap_or_default();
    let picture = scene::read_picture(&Asset::outside(&out.join(name)), &desk.request.limits)?;
    let _ = fs::remove_dir_all(&out);
    Ok((Linear::of(&picture), outcome.report.quality.unwrap_or_default(), outcome.report.seconds))
}

fn row(name: &str, told: &Reached, reached: f64, seconds: f64) -> Vec<Field> {
    let part = |stage: &str| Field::Number(told.stages.get(stage).copied());
    let leaf = told.leaves.first();
    vec![
        name.into(),
        told.asked.into(),
        reached.into(),
        told.reached.into(),
        told.is_within.into(),
        (reached <= told.asked).into(),
        told.samples.into(),
        told.enlarged.into(),
        told.lod_error_px.into(),
        leaf.map_or(Field::Number(None), |leaf| leaf.vertices.into()),
        leaf.map(|leaf| leaf.tolerance).into(),
        part("leaf"),
        part("raster"),
        seconds.into(),
    ]
}
