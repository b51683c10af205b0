//! The report as others read it: every field of the contract, with its type, and no stage that did not run.

mod common;

use common::{render, small};
use leafseason::base::limits::Limits;
use leafseason::base::picture::Picture;
use leafseason::export;
use leafseason::plan::Reason;
use leafseason::report::Report;
use leafseason::run::{self, Options};
use leafseason::scene::{self, Scene};
use serde_json::Value;
use std::fs;

fn reported(scene: &Scene) -> Report {
    let folder = tempfile::tempdir().unwrap();
    render(scene, &Options { out: folder.path().to_owned(), ..Options::default() }).report
}

/// The report as it is written.
fn written(report: &Report) -> Value {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("report.json");
    run::write_report(&path, report).unwrap();
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

/// Whether a value is of a kind; a `?` behind it allows null.
fn is(value: &Value, kind: &str) -> bool {
    match kind {
        "text" => value.is_string(),
        "count" => value.is_u64(),
        "whole" => value.is_i64(),
        "number" => value.is_number(),
        "list" => value.is_array(),
        "table" => value.is_object(),
        "counts" => value.as_object().is_some_and(|table| table.values().all(Value::is_u64)),
        "numbers" => value.as_object().is_some_and(|table| table.values().all(Value::is_number)),
        "error?" => value.is_null() || keys_are(value, &ERROR),
        "reason" => value.is_string() || value["SameAs"].is_i64(),
        "figures" => value.is_object(),
        _ => kind.strip_suffix('?').is_some_and(|kind| value.is_null() || is(value, kind)),
    }
}

/// Whether a table has these keys, of these kinds, and no others.
fn keys_are(table: &Value, keys: &[(&str, &str)]) -> bool {
    let Some(found) = table.as_object() else { return false };
    let wrong: Vec<&str> = keys.iter().filter(|(key, kind)| !is(&table[*key], kind)).map(|(key, _)| *key).collect();
    assert!(wrong.is_empty(), "{wrong:?} in {table:#}");
    found.len() == keys.len()
}

const ERROR: [(&str, &str); 5] =
    [("metric", "text"), ("value", "number"), ("unit", "text"), ("bound", "number?"), ("how", "text")];
const REPORT: [(&str, &str); 8] = [
    ("version", "text"),
    ("scene", "text"),
    ("threads", "count"),
    ("seconds", "number"),
    ("peak_memory_bytes", "count"),
    ("stages", "list"),
    ("left_out", "list"),
    ("frames", "list"),
];
const STAGE: [(&str, &str); 6] = [
    ("name", "text"),
    ("runs", "count"),
    ("seconds", "number"),
    ("items", "count"),
    ("error", "error?"),
    ("figures", "figures"),
];
const LEFT_OUT: [(&str, &str); 2] = [("what", "text"), ("reason", "reason")];
const FRAME: [(&str, &str); 12] = [
    ("index", "whole"),
    ("day", "number"),
    ("date", "text?"),
    ("leaves", "count"),
    ("states", "counts"),
    ("expected", "numbers"),
    ("fallen", "count"),
    ("fall", "counts"),
    ("png", "text?"),
    ("gltf", "text?"),
    ("view", "table"),
    ("seconds", "number"),
];

/// The figures of each stage that others read, for a leaf without a scan.
const FIGURES: [(&str, &[(&str, &str)]); 6] = [
    (
        "tree",
        &[
            ("symbols", "count"),
            ("segments", "count"),
            ("leaves", "count"),
            ("height_m", "number"),
            ("leaf_area_index", "number"),
        ],
    ),
    (
        "leaf",
        &[
            ("vertices", "count"),
            ("min_angle_deg", "number"),
            ("edge_cv", "number"),
            ("q_mean", "number"),
            ("q_p05", "number"),
            ("key_points", "count"),
        ],
    ),
    ("deform", &[("shapes", "count"), ("iterations", "count"), ("residual", "number"), ("max_strain", "number")]),
    ("colour", &[("states", "table")]),
    ("fall", &[("grown", "count"), ("attached", "count"), ("air", "count"), ("lying", "count"), ("decayed", "count")]),
    ("raster", &[("triangles", "count"), ("samples", "count"), ("cpu_seconds", "number")]),
];

fn stage<'a>(report: &'a Value, name: &str) -> &'a Value {
    let stages = report["stages"].as_array().unwrap();
    stages.iter().find(|stage| stage["name"] == name).unwrap_or_else(|| panic!("no stage {name}"))
}

fn names(report: &Report) -> Vec<&str> {
    report.stages.iter().map(|stage| stage.name.as_str()).collect()
}

#[test]
fn every_field_of_the_contract_is_there() {
    let report = written(&reported(&small(&["time.from=3", "time.to=9", "time.step=3"])));
    assert!(keys_are(&report, &REPORT));
    for (list, keys) in [("stages", &STAGE[..]), ("left_out", &LEFT_OUT), ("frames", &FRAME)] {
        let list = report[list].as_array().unwrap();
        assert!(!list.is_empty() && list.iter().all(|one| keys_are(one, keys)), "{list:#?}");
    }
    for (name, figures) in FIGURES {
        let found = &stage(&report, name)["figures"];
        let wrong: Vec<&str> =
            figures.iter().filter(|(key, kind)| !is(&found[*key], kind)).map(|(key, _)| *key).collect();
        assert!(wrong.is_empty(), "{name}: {wrong:?} in {found:#}");
    }
    for (state, colours) in stage(&report, "colour")["figures"]["states"].as_object().unwrap() {
        for side in ["reflected", "transmitted"] {
            let colour = colours[side].as_array().unwrap_or_else(|| panic!("{state} {side}"));
            assert!(colour.len() == 3 && colour.iter().all(Value::is_number), "{state} {side}");
        }
    }
    for name in ["season", "leaf", "deform", "colour", "fall", "raster"] {
        assert!(!stage(&report, name)["error"].is_null(), "{name} states no error");
    }
}

#[test]
fn the_numbers_of_a_report_agree_with_one_another() {
    let report = reported(&small(&["time.from=3", "time.to=9", "time.step=3"]));
    let order = ["tree", "season", "leaf", "deform", "colour", "fall", "compose", "raster", "png", "gltf"];
    assert_eq!(names(&report), order);
    assert_eq!(report.frames.iter().map(|frame| frame.day).collect::<Vec<_>>(), [3.0, 6.0, 9.0]);
    let leaves = report.figure("tree", "leaves").and_then(Value::as_u64).unwrap();
    for frame in &report.frames {
        assert_eq!((frame.leaves, frame.states.values().sum::<u64>()), (leaves, leaves));
        assert_eq!(frame.fallen, frame.states["fallen"]);
        assert!((frame.expected.values().sum::<f64>() - 1.0).abs() < 1e-9);
    }
    for (stage, runs) in [("tree", 1), ("leaf", 1), ("raster", 3), ("png", 3), ("gltf", 3)] {
        assert_eq!(report.stages.iter().find(|one| one.name == stage).unwrap().runs, runs, "{stage}");
    }
    let index = report.figure("tree", "leaf_area_index").and_then(Value::as_f64).unwrap();
    assert!((0.05..20.0).contains(&index), "{index}");
}

#[test]
fn a_leafless_scene_makes_no_leaf_and_says_why() {
    let scene = small(&["time.day=400"]);
    let report = reported(&scene);
    assert_eq!(names(&report), ["tree", "season", "compose", "raster", "png", "gltf"]);
    assert_eq!(report.frames[0].fallen, report.frames[0].leaves);
    let plan = run::plan(&scene, &Options::default()).unwrap();
    assert_eq!(plan.left_out, report.left_out);
    for stage in ["leaf", "deform", "colour"] {
        assert!(!plan.has(stage), "{stage}");
        let reasons: Vec<Reason> =
            plan.left_out.iter().filter(|left| left.what == stage).map(|left| left.reason).collect();
        assert_eq!(reasons, [Reason::NoLeafLeft], "{stage}");
    }
    // Without a blade nothing is known of its area.
    assert_eq!(report.figure("tree", "leaf_area_index"), None);
}

#[test]
fn outputs_that_are_not_asked_for_do_not_appear() {
    let report = reported(&small(&["time.day=9", "output.png=false"]));
    assert_eq!(names(&report), ["tree", "season", "leaf", "deform", "colour", "fall", "compose", "gltf"]);
    assert_eq!((report.frames[0].png.as_deref(), report.frames[0].gltf.as_deref()), (None, Some("small.glb")));
}

/// An oval leaf on paper with a stalk below it.
fn scan() -> Picture {
    let mut picture = Picture::filled(160, 240, [250, 249, 246, 255]);
    for (index, pixel) in picture.pixels.iter_mut().enumerate() {
        let (x, y) = ((index % 160) as f64 - 80.0, (index / 160) as f64 - 110.0);
        let blade = (x / 52.0) * (x / 52.0) + (y / 85.0) * (y / 85.0) < 1.0;
        let stalk = x.abs() < 1.5 && (0.0..120.0).contains(&y);
        if blade || stalk {
            *pixel = [70, 120, 40, 255];
        }
    }
    picture
}

#[test]
fn a_traced_leaf_tells_its_errors_in_pixels() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("leaf.png"), export::png(&scan()).unwrap()).unwrap();
    let text = "species = \"red-maple\"\ntree = { age = 4 }\nleaf = { picture = \"leaf.png\", vertices = 80 }\n\
                colour = { size = 32 }\nimage = { width = 16, height = 16, samples = 1 }\nlight = { shadow_size = 0 }\n";
    let path = folder.path().join("scan.toml");
    fs::write(&path, text).unwrap();
    let scene = scene::read(&path, &[], &[], &Limits::default()).unwrap().0;
    let report = written(&reported(&scene));
    let figures = &stage(&report, "leaf")["figures"];
    for name in ["outline_hausdorff_px", "boundary_hausdorff_px"] {
        assert!(figures[name].as_f64().is_some_and(|gap| (0.0..10.0).contains(&gap)), "{name}: {}", figures[name]);
    }
    // a small picture: the least default bound
    let bound = scene.species[0].leaf.tolerance_px.unwrap_or(1.0);
    assert!(figures["outline_hausdorff_px"].as_f64().unwrap() <= bound);
    let without = reported(&small(&["time.day=9"]));
    assert_eq!(without.figure("leaf", "outline_hausdorff_px"), None);
}
