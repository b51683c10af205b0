//! Pictures: samples and levels of detail against the error in linear light.

use super::chart::{self, Curve};
use super::desk::Desk;
use super::fan;
use super::linear::{Linear, reference, structural_similarity};
use super::numbers::{beaten_by, quantiles, shown, slope};
use super::own;
use super::stage::{self, staged};
use super::table::{Field, Table};
use super::timing::{Case, Effort, Times, measured};
use crate::base::diagnostic::Diagnostics;
use crate::compare;
use crate::frame::Frame;
use crate::raster;
use crate::run::still::Still;
use crate::scene::Scene;
use crate::scene::image::{Image, SAMPLES};

const COLUMNS: [&str; 17] = [
    "scene",
    "sweep",
    "pattern",
    "spp",
    "lod_error_px",
    "triangles_drawn",
    "rmse_linear",
    "relmse",
    "flip_mean",
    "flip_p95",
    "ssim",
    "own_estimate",
    "cpu_ms",
    "cpu_ms_q1",
    "cpu_ms_q3",
    "cpu_rounds",
    "ratio_to_1spp",
];
/// Processor time for all rounds of a picture, seconds.
const BUDGET: f64 = 2.0;
/// Errors in pixels that levels of detail may make, tried with the default samples.
const LOD_ERRORS: [f32; 6] = [0.0, 0.1, 0.3, 0.6, 1.2, 2.4];
/// By more than this share another row must be better in both error and work to beat the defaults: less nobody would see or save.
const NOTICED: f64 = 0.01;
/// Sides by which references are enlarged, the one and another that it is held against: 4,096 and 2,304 samples in a pixel.
const SIDES: [u32; 2] = [16, 12];
/// Those of a quick study: 1,600 and 1,024.
const FEW_SIDES: [u32; 2] = [10, 8];
/// Most pixels of an enlarged picture; larger references take smaller sides.
const MOST_PIXELS: u32 = 20_000_000;

/// A frame that is drawn, and what it should look like.
struct Subject {
    name: String,
    frame: Frame,
    exact: Linear,
    /// How far another reference lies from that one.
    floor: f64,
}

/// Runs the family, on the scene's own camera if there is a scene.
///
/// # Errors
/// Scenes that cannot be made, files that cannot be written.
pub fn study(desk: &mut Desk<'_>, of: Option<&Scene>) -> Result<(), Diagnostics> {
    let mut subjects = Vec::new();
    match of {
        Some(scene) => subjects.push(of_scene(desk, &scene.name, &own::pictured(scene, desk.request.quick))?),
        None => {
            let exact = fan::coverage();
            subjects.push(Subject { name: "fan".to_owned(), frame: fan::frame(), exact, floor: 0.0 });
            for (name, text) in [("leaf", stage::LEAF), ("tree", stage::TREE)] {
                let (scene, _) = staged(desk, name, text, &[])?;
                subjects.push(of_scene(desk, name, &scene)?);
            }
        }
    }
    let mut table = Table::new(&COLUMNS);
    let (mut curves, mut levels) = (Vec::new(), Vec::new());
    for subject in &subjects {
        let Measured { samples, levels: own } = ladders(desk, subject, &mut table);
        curves.push(Curve::new(subject.name.clone(), samples));
        levels.push(own);
    }
    desk.write_table("raster.csv", &table)?;
    let frame = chart::Frame {
        title: "Pictures: error against samples",
        x: ["samples in a pixel", ""],
        y: ["root mean square error in linear light", ""],
        orders: &[-0.5, -0.75],
        floor: Some(subjects.iter().map(|subject| subject.floor).fold(0.0, f64::max)),
        left_out: &["random and jittered samples: of the patterns tried before, rooks cost least and are as good"],
    };
    desk.write_chart("raster", &chart::chart(&frame, &curves))?;
    judge(desk, &subjects, &curves, of.is_none());
    judge_levels(desk, &subjects, &levels);
    let columns = ["scene", "spp", "lod_error_px", "triangles_drawn", "rmse_linear", "relmse", "flip_mean", "flip_p95"];
    let columns = [&columns[..], &["ssim", "own_estimate", "cpu_ms", "ratio_to_1spp"]].concat();
    let text = format!(
        "{}References are drawn {} times as large and averaged in linear light, but the fan's, which is its coverage in closed \
         form. `own_estimate` is what the rasteriser itself tells of its antialiasing (before the tone \
         curve).\n\n![error against samples](raster.png)\n\n{}",
        of.map_or_else(String::new, |_| size_told(&subjects[0].frame)),
        sides(desk, &subjects[subjects.len() - 1].frame)[0],
        table.markdown(&columns)
    );
    desk.section("Pictures", &text);
    Ok(())
}

/// In what size a scene of the user's is drawn.
fn size_told(frame: &Frame) -> String {
    let (width, height) = (frame.view.width, frame.view.height);
    format!("Drawn in {width} x {height} pixels; larger pictures have fewer edges for their pixels and err less. ")
}

/// The two sides by which a frame's references are enlarged.
fn sides(desk: &Desk<'_>, frame: &Frame) -> [u32; 2] {
    let wanted = if desk.request.quick { FEW_SIDES } else { SIDES };
    let pixels = frame.view.width * frame.view.height;
    let fits = |side: u32| (1..=side).rev().find(|side| pixels.saturating_mul(side * side) <= MOST_PIXELS).unwrap_or(1);
    wanted.map(fits)
}

fn of_scene(desk: &mut Desk<'_>, name: &str, scene: &Scene) -> Result<Subject, Diagnostics> {
    let (frame, _) = Still::new(scene, 0, &desk.request.limits)?.frame()?;
    let [side, other] = sides(desk, &frame);
    let most = SAMPLES[SAMPLES.len() - 1].min(16);
    desk.tell(&format!("raster {name}: reference of {} samples", side * side * most));
    let exact = reference(&frame, side, most);
    // The smaller one with another pattern.
    let floor = reference(&frame, other, 8).distance(&exact).rmse;
    Ok(Subject { name: name.to_owned(), frame, exact, floor })
}

/// One frame with rising samples, and with coarser and coarser levels of detail.
fn ladders(desk: &mut Desk<'_>, subject: &Subject, table: &mut Table) -> Measured {
    let samples = SAMPLES.map(|samples| {
        let mut frame = subject.frame.clone();
        frame.view.samples = samples;
        frame
    });
    // A frame's own levels of detail are in the first ladder.
    let own = subject.frame.view.lod_error;
    let others = LOD_ERRORS.into_iter().filter(|lod| subject.name != "fan" && lod.total_cmp(&own).is_ne());
    let levels = others.map(|lod| {
        let mut frame = subject.frame.clone();
        (frame.view.samples, frame.view.lod_error) = (Image::default().samples, lod);
        frame
    });
    let frames: Vec<Frame> = samples.into_iter().chain(levels).collect();
    let cases: Vec<Case<'_>> = frames.iter().map(|frame| Case::new(move || digested(frame))).collect();
    let effort = Effort::of(desk.request.quick);
    let effort = Effort { budget: effort.budget.min(BUDGET), ..effort };
    let mut measured_rows = Measured::default();
    for (number, (frame, times)) in frames.iter().zip(measured(&cases, effort)).enumerate() {
        let sweep = if number < SAMPLES.len() { "samples" } else { "lod_error" };
        let (row, point) = row(desk, subject, (sweep, frame), &times);
        table.push(row);
        if sweep == "samples" {
            measured_rows.samples.push([f64::from(frame.view.samples), point[1]]);
        }
        if sweep == "lod_error" || frame.view.samples == Image::default().samples {
            measured_rows.levels.push((frame.view.lod_error, point));
        }
    }
    measured_rows.levels.sort_by(|a, b| a.0.total_cmp(&b.0));
    measured_rows
}

/// What was measured of a frame: samples and errors, and by the levels' error triangles and errors.
#[derive(Default)]
struct Measured {
    samples: Vec<[f64; 2]>,
    levels: Vec<(f32, [f64; 2])>,
}

/// A row of the table; triangles and error.
fn row(
    desk: &mut Desk<'_>,
    subject: &Subject,
    (sweep, frame): (&str, &Frame),
    times: &Times,
) -> (Vec<Field>, [f64; 2]) {
    let (samples, lod) = (frame.view.samples, frame.view.lod_error);
    let (picture, figures) = raster::draw(frame);
    let found = Linear::of(&picture);
    let distance = found.distance(&subject.exact);
    let flip = compare::flip_map(&found.pixels, &subject.exact.pixels, found.width as usize);
    let [noticed] = quantiles(&flip, [0.95]);
    let name = format!("raster {} {samples} spp, levels within {lod} px", subject.name);
    desk.steady(&name, times.is_same);
    desk.tell(&format!("{name}: RMSE {}, {} ms", shown(distance.rmse), shown(times.seconds[1] * 1e3)));
    let figure = |name: &str| figures.values.get(name).and_then(serde_json::Value::as_f64);
    let triangles = figure("triangles_drawn");
    let fields = vec![
        subject.name.as_str().into(),
        sweep.into(),
        "rooks".into(),
        samples.into(),
        f64::from(lod).into(),
        triangles.into(),
        distance.rmse.into(),
        distance.relative.into(),
        (flip.iter().sum::<f64>() / flip.len().max(1) as f64).into(),
        noticed.into(),
        structural_similarity(&found, &subject.exact).into(),
        figures.error.map_or(Field::Number(None), |error| error.value.into()),
        (times.seconds[1] * 1e3).into(),
        (times.seconds[0] * 1e3).into(),
        (times.seconds[2] * 1e3).into(),
        times.rounds.into(),
        times.ratio[1].into(),
    ];
    (fields, [triangles.unwrap_or(0.0), distance.rmse])
}

fn digested(frame: &Frame) -> u64 {
    let (picture, _) = raster::draw(frame);
    picture.pixels.iter().fold(0, |sum, pixel| crate::base::random::hash(sum, u64::from(u32::from_le_bytes(*pixel))))
}

fn judge(desk: &mut Desk<'_>, subjects: &[Subject], curves: &[Curve], is_built_in: bool) {
    if is_built_in {
        let slope = slope(&curves[0].points).unwrap_or(0.0);
        let smallest = |curve: &Curve| curve.points.iter().map(|point| point[1]).fold(f64::INFINITY, f64::min);
        let shares: Vec<f64> =
            subjects.iter().zip(curves).map(|(subject, curve)| subject.floor / smallest(curve)).collect();
        let worst = shares.iter().copied().fold(0.0, f64::max);
        let asked = "error falls with samples to the power -0.65 or faster (fan of edges, exact reference); two references \
                     differ by less than a fifth of the smallest error";
        let found = format!("power {slope:.3}; references differ by {worst:.3} of the smallest error");
        desk.judge("P9", slope <= -0.65 && worst < 0.2, asked, found);
    }
    let default = Image::default().samples;
    for (subject, curve) in subjects.iter().zip(curves).filter(|(subject, _)| subject.name != "fan") {
        let Some(row) = curve.points.iter().position(|point| point[0] == f64::from(default)) else { continue };
        let beaten = beaten_by(&curve.points, row, NOTICED);
        let found = format!("{}: {default} samples, error {}", subject.name, shown(curve.points[row][1]));
        desk.judge("F2", beaten.is_empty(), "the default samples lie on the front of error and samples", found);
    }
}

/// The default levels of detail lie on the front: no other has both a smaller error and fewer triangles.
fn judge_levels(desk: &mut Desk<'_>, subjects: &[Subject], levels: &[Vec<(f32, [f64; 2])>]) {
    let default = Image::default().lod_error as f32;
    for (subject, levels) in subjects.iter().zip(levels) {
        let Some(row) = levels.iter().position(|(lod, _)| lod.total_cmp(&default).is_eq()) else { continue };
        let points: Vec<[f64; 2]> = levels.iter().map(|(_, point)| *point).collect();
        let beaten = beaten_by(&points, row, NOTICED);
        let [triangles, error] = points[row];
        let found = format!("{}: {default} px, error {} with {triangles} triangles", subject.name, shown(error));
        let by: Vec<String> = beaten.iter().map(|&other| format!("{} px", levels[other].0)).collect();
        let found = if by.is_empty() { found } else { format!("{found}; beaten by {}", by.join(", ")) };
        desk.judge(
            "F3",
            beaten.is_empty(),
            "the default levels of detail lie on the front of error and triangles",
            found,
        );
    }
}
