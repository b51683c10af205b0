//! Leaves that fall, from the scene to the files: every leaf is somewhere in every frame, colours are kept on the way, a frame
//! alone is that of the run, and a scene without litter is as it was.

mod common;

use common::{render, small};
use leafseason::plan::Reason;
use leafseason::report::Report;
use leafseason::run::frame_list::FrameList;
use leafseason::run::{self, Options};
use leafseason::scene::Scene;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

fn rendered(scene: &Scene, options: Options) -> (BTreeMap<String, Vec<u8>>, Report) {
    let folder = tempfile::tempdir().unwrap();
    let report = render(scene, &Options { out: folder.path().to_owned(), ..options }).report;
    (files(folder.path()), report)
}

fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder).unwrap().map(Result::unwrap);
    let named =
        entries.map(|entry| (entry.file_name().to_string_lossy().into_owned(), fs::read(entry.path()).unwrap()));
    named.filter(|(name, _)| !name.ends_with(".json")).collect()
}

/// The JSON of a GLB file.
fn json(glb: &[u8]) -> Value {
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&glb[20..20 + length]).unwrap()
}

/// The frames of a year without pictures.
const YEAR: [&str; 6] =
    ["time.from=0", "time.to=360", "time.step=12", "output.png=false", "output.gltf=\"nodes\"", "fall.slow_motion=3e4"];

#[test]
fn in_every_frame_of_a_year_every_leaf_is_somewhere() {
    let scene = small(&YEAR);
    let (_, report) = rendered(&scene, Options::default());
    let mut seen = [false; 4];
    for frame in &report.frames {
        let fall = frame.fall.unwrap();
        assert_eq!(fall.grown, frame.leaves);
        assert_eq!(fall.attached + fall.air + fall.lying + fall.decayed, fall.grown, "{fall:?}");
        assert_eq!(fall.attached, frame.leaves - frame.fallen);
        let states = [fall.attached, fall.air, fall.lying, fall.decayed];
        seen.iter_mut().zip(states).for_each(|(seen, count)| *seen |= count > 0);
    }
    assert_eq!(seen, [true; 4], "each fate is met");
    let [first, last] = [report.frames.first(), report.frames.last()].map(|frame| frame.unwrap().fall.unwrap());
    assert_eq!((first.attached, last.decayed), (first.grown, last.grown));
}

#[test]
fn a_frame_alone_is_that_of_the_run_on_any_number_of_threads() {
    let scene = small(&["time.from=6", "time.to=40", "time.step=2", "fall.slow_motion=2e4", "output.inset=false"]);
    let on = |threads: usize, frames: Option<&str>| {
        let frames = frames.map(|list| list.parse::<FrameList>().unwrap());
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| rendered(&scene, Options { frames, ..Options::default() }))
    };
    let (run, report) = on(2, None);
    assert!(report.frames[9].fall.unwrap().air > 0 && report.frames[9].fall.unwrap().lying > 0);
    for threads in [1, 3] {
        let (alone, _) = on(threads, Some("9"));
        assert!(alone.len() == 2 && alone.iter().all(|(name, bytes)| run[name] == *bytes), "{threads}");
    }
}

#[test]
fn without_litter_nothing_of_it_is_done_and_the_pictures_do_not_depend_on_its_settings() {
    let off = small(&["time.day=9", "fall.on=false"]);
    let (expected, report) = rendered(&off, Options::default());
    assert!(report.stages.iter().all(|stage| stage.name != "fall"));
    assert!(report.left_out.iter().any(|left| left.what == "fall" && left.reason == Reason::NotAskedFor));
    assert!(report.frames[0].fall.is_none() && report.frames[0].fallen > 0);
    let other = small(&["time.day=9", "fall.on=false", "fall.wind=9", "fall.days=3", "fall.browning=1"]);
    assert!(rendered(&other, Options::default()).0 == expected);
    let (with, _) = rendered(&small(&["time.day=9"]), Options::default());
    assert!(with.iter().all(|(name, bytes)| expected[name] != *bytes));
    // no ground, no litter, unless it is asked for
    assert!(
        !small(&["ground.kind=\"none\""]).leaves_fall()
            && small(&["ground.kind=\"none\"", "fall.on=true"]).leaves_fall()
    );
}

#[test]
fn before_the_first_leaf_has_fallen_litter_changes_nothing() {
    let on = rendered(&small(&["time.day=0"]), Options::default());
    let off = rendered(&small(&["time.day=0", "fall.on=false"]), Options::default());
    assert!(on.0 == off.0);
    assert!(on.1.left_out.iter().any(|left| left.what == "fall" && left.reason == Reason::NoEffect));
    let with_all = rendered(&small(&["time.day=9"]), Options { leave_out: false, ..Options::default() });
    assert!(with_all.0 == rendered(&small(&["time.day=9"]), Options::default()).0);
}

/// The mesh and material of every leaf's blade in a GLB, by the leaf's name.
fn blades(glb: &[u8]) -> BTreeMap<String, (String, String)> {
    let json = json(glb);
    let mut blades = BTreeMap::new();
    for node in json["nodes"].as_array().unwrap() {
        let name = node["name"].as_str().unwrap();
        let Some(name) = name.strip_prefix("leaf_").or_else(|| name.strip_prefix("fallen_")) else { continue };
        if node["mesh"].is_null() {
            continue;
        }
        let mesh = &json["meshes"][node["mesh"].as_u64().unwrap() as usize];
        let material = mesh["primitives"][0]["material"].as_u64().unwrap() as usize;
        let material = json["materials"][material]["name"].as_str().unwrap().to_owned();
        blades.insert(name.to_owned(), (mesh["name"].as_str().unwrap().to_owned(), material));
    }
    blades
}

#[test]
fn a_leaf_falls_in_what_it_wore_and_lies_in_its_colours() {
    // half a day between frames, and flights of days: leaves of the first frame are in the air in the second
    let scene = small(&["time.from=14", "time.to=14.5", "time.step=0.5", "fall.slow_motion=5e4", "output.png=false"]);
    let (files, report) = rendered(&scene, Options::default());
    let [before, after] = ["small.0000.glb", "small.0001.glb"].map(|name| blades(&files[name]));
    assert!(report.frames[1].fall.unwrap().air > 10);
    let same = after.iter().filter(|(name, worn)| before.get(*name) == Some(worn)).count();
    assert!(same * 2 > after.len());
    // nothing in the air wears what no twig wears: its models have no name of their own
    let in_the_air = after.values().filter(|(mesh, _)| !mesh.starts_with("fallen_")).count() as u64;
    assert_eq!(in_the_air, report.frames[1].fall.unwrap().attached + report.frames[1].fall.unwrap().air);
    // on the ground the material is that of the twig, matt: its textures are the same
    let landed = small(&["time.day=9", "output.png=false", "fall.browning=1e5", "fall.days=1e5"]);
    let (files, _) = rendered(&landed, Options::default());
    let json = json(&files["small.glb"]);
    let materials = json["materials"].as_array().unwrap();
    let texture = |name: &str| {
        let found = materials.iter().find(|material| material["name"] == name);
        found.map(|material| material["pbrMetallicRoughness"]["baseColorTexture"]["index"].clone())
    };
    let lying: BTreeSet<&str> = materials.iter().filter_map(|m| m["name"].as_str()?.strip_suffix("_lying")).collect();
    assert!(!lying.is_empty());
    for name in lying {
        let own = texture(name);
        assert!(own.is_none() || own == texture(&format!("{name}_lying")), "{name}");
    }
}

#[test]
fn raked_circles_are_clear_and_what_was_raked_is_counted() {
    let kept = rendered(&small(&["time.day=9", "output.png=false"]), Options::default()).1;
    let raked = rendered(&small(&["time.day=9", "output.png=false", "fall.raked=1.0"]), Options::default()).1;
    let [kept, raked] = [&kept, &raked].map(|report| report.frames[0].fall.unwrap());
    assert_eq!((kept.raked, kept.lying), (0, raked.lying + raked.raked));
    assert!(raked.raked > 0 && raked.lying > 0, "{raked:?}");
}

#[test]
fn the_plan_makes_only_what_fallen_leaves_show() {
    // long after the last leaf fell: their shapes, and the brown textures that all of them have come to
    let scene = small(&["time.day=100", "fall.days=1e4", "fall.browning=10"]);
    let plan = run::plan(&scene, &Options::default()).unwrap();
    let of =
        |stage: &str| plan.jobs.iter().filter(|job| job.stage == stage).map(|job| job.name.clone()).collect::<Vec<_>>();
    assert_eq!((of("fall").len(), of("leaf").len()), (1, 1));
    assert!(of("deform").iter().any(|name| name.starts_with("red")));
    assert!(of("colour").iter().all(|name| name.starts_with("brown")), "{:?}", of("colour"));
    let gone = run::plan(&small(&["time.day=400", "fall.days=20"]), &Options::default()).unwrap();
    assert!(!gone.has("fall") && !gone.has("leaf"));
}
