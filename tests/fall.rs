//! Leaves that fall, from the scene to the files: every leaf is somewhere in every frame, colours are kept on the way, a frame
//! alone is that of the run, and a scene without litter is as it was.

mod common;

use common::{render, small, small_in};
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

#[test]
fn the_way_of_a_leaf_is_found_once_in_a_run() {
    let scene = small(&["time.from=4", "time.to=40", "time.step=2", "output.png=false"]);
    let (_, report) = rendered(&scene, Options::default());
    let last = report.frames.last().unwrap().fall.unwrap();
    let stage = report.stages.iter().find(|stage| stage.name == "fall").unwrap();
    assert!(stage.runs > 10 && last.lying > 100);
    // every frame is counted and drawn; each leaf that fell in any of them is looked into once
    assert_eq!(stage.figures["ways"].as_u64(), Some(last.grown - last.attached));
}

#[test]
fn a_twig_that_loses_two_leaves_in_a_year_has_a_way_for_each() {
    // an oak that holds dead leaves until spring, and sheds the new ones from autumn on
    let year = "time={from=\"2023-01-10\",to=\"2023-12-30\",step=20.0}";
    let oak = ["species=\"english-oak\"", "output.png=false", "fall.days=1e3", year];
    let scene = small_in("climate = { latitude = 48.0 }", &oak);
    let (_, report) = rendered(&scene, Options::default());
    let stage = report.stages.iter().find(|stage| stage.name == "fall").unwrap();
    let last = report.frames.last().unwrap().fall.unwrap();
    assert_eq!(stage.figures["ways"].as_u64(), Some(last.grown - last.attached));
}

#[test]
fn what_lies_as_it_lay_is_not_laid_anew() {
    let settled = |sets: &[&str]| {
        let mut all = vec!["output.png=false", "fall.browning=1", "fall.days=1e5"];
        all.extend(sets);
        let (_, report) = rendered(&small(&all), Options::default());
        let stage = report.stages.iter().find(|stage| stage.name == "fall").unwrap();
        let lying: u64 = report.frames.iter().map(|frame| frame.fall.unwrap().lying).sum();
        (stage.figures["settled"].as_u64().unwrap(), lying, report.frames.last().unwrap().fall.unwrap().lying)
    };
    // all have fallen, and browning does not move them
    let (settled_once, lying, last) = settled(&["time.from=100", "time.to=106", "time.step=1"]);
    assert!(settled_once == last && lying == 7 * last && last > 100, "{settled_once} {lying} {last}");
    // while leaves fall, those away from the new ones are kept
    let (settled_often, lying, last) = settled(&["time.from=10", "time.to=12", "time.step=0.1"]);
    assert!(settled_often >= last && 2 * settled_often < lying, "{settled_often} {lying} {last}");
}

/// A lying leaf of a GLB whose leaves are nodes: its blade's corners, triangle by triangle, metres.
fn lying_blades(glb: &[u8]) -> Vec<Vec<[[f64; 3]; 3]>> {
    let json = json(glb);
    let start = 28 + u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let bytes = |accessor: &Value, size: usize| {
        let accessor = &json["accessors"][accessor.as_u64().unwrap() as usize];
        let view = &json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let offset = |value: &Value| value["byteOffset"].as_u64().unwrap_or(0) as usize;
        let first = start + offset(view) + offset(accessor);
        let stride = view["byteStride"].as_u64().map_or(size, |stride| stride as usize);
        let count = accessor["count"].as_u64().unwrap() as usize;
        (0..count).map(|n| glb[first + n * stride..][..size].to_vec()).collect::<Vec<_>>()
    };
    let number = |bytes: &[u8]| bytes.iter().rev().fold(0u64, |sum, &byte| sum << 8 | u64::from(byte));
    let numbers = |value: &Value, without: &[f64]| {
        value.as_array().map_or(without.to_vec(), |list| list.iter().map(|v| v.as_f64().unwrap()).collect())
    };
    let mut blades = Vec::new();
    for node in json["nodes"].as_array().unwrap() {
        let is_lying = node["name"].as_str().unwrap().starts_with("fallen_") && !node["mesh"].is_null();
        let mesh = &json["meshes"][node["mesh"].as_u64().unwrap_or(0) as usize];
        if !is_lying || !mesh["name"].as_str().unwrap().starts_with("fallen_") {
            continue;
        }
        let primitive = &mesh["primitives"][0];
        let [t, q, s] =
            [("translation", 3, 0.0), ("rotation", 4, 0.0), ("scale", 3, 1.0)].map(|(key, count, value)| {
                let mut without = vec![value; count];
                if key == "rotation" {
                    without[3] = 1.0;
                }
                numbers(&node[key], &without)
            });
        let point = |bytes: &Vec<u8>| {
            let v: [f64; 3] = std::array::from_fn(|k| {
                s[k] * f64::from(f32::from_le_bytes(bytes[4 * k..4 * k + 4].try_into().unwrap()))
            });
            let cross = |a: &[f64], b: &[f64]| {
                [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
            };
            let once = cross(&q[..3], &v);
            let twice = cross(&q[..3], &once);
            std::array::from_fn(|k| t[k] + v[k] + 2.0 * (q[3] * once[k] + twice[k]))
        };
        let points: Vec<[f64; 3]> = bytes(&primitive["attributes"]["POSITION"], 12).iter().map(point).collect();
        let indices = &primitive["indices"];
        let size = match json["accessors"][indices.as_u64().unwrap() as usize]["componentType"].as_u64() {
            Some(5121) => 1,
            Some(5123) => 2,
            _ => 4,
        };
        let corners: Vec<[f64; 3]> = bytes(indices, size).iter().map(|bytes| points[number(bytes) as usize]).collect();
        blades.push(corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect());
    }
    blades
}

/// Points of a blade, a millimetre apart.
fn points(blade: &[[[f64; 3]; 3]]) -> Vec<[f64; 3]> {
    let mut points = Vec::new();
    for [a, b, c] in blade {
        let apart = |p: &[f64; 3], q: &[f64; 3]| (0..3).map(|k| (p[k] - q[k]) * (p[k] - q[k])).sum::<f64>().sqrt();
        let steps = (apart(a, b).max(apart(b, c)).max(apart(c, a)) / 1e-3) as usize + 1;
        for (i, j) in (0..=steps).flat_map(|i| (0..=steps - i).map(move |j| (i, j))) {
            let (u, v) = (i as f64 / steps as f64, j as f64 / steps as f64);
            points.push(std::array::from_fn(|k| a[k] + (b[k] - a[k]) * u + (c[k] - a[k]) * v));
        }
    }
    points
}

#[test]
fn no_leaf_lies_in_the_ground_and_none_hovers() {
    leaves_lie_well(&[]);
}

#[test]
fn no_leaf_lies_in_uneven_ground_and_none_hovers_over_it() {
    leaves_lie_well(&["ground.heights=[[0.0, 0.5, 0.1], [0.9, 0.3, 0.6], [-0.2, 0.4, 0.2]]", "ground.step=2.0"]);
}

/// Every leaf that lies touches the ground or a leaf within 2 mm, and none goes 1 mm into the ground.
fn leaves_lie_well(more: &[&str]) {
    let sets = ["time.day=20", "tree.age=6", "output.png=false", "fall.browning=8", "fall.days=60"];
    let scene = small(&[&sets, more].concat());
    let heights = scene.ground.map();
    let ground = |p: &[f64; 3]| heights.as_ref().map_or(0.0, |map| map.at([p[0], p[2]].into()));
    let (files, report) = rendered(&scene, Options::default());
    let stage = report.stages.iter().find(|stage| stage.name == "fall").unwrap();
    let buried = stage.figures["buried"].as_u64().unwrap() as usize;
    let blades = lying_blades(&files["small.glb"]);
    assert!(blades.len() > 200 && blades.len() + buried == report.frames[0].fall.unwrap().lying as usize);
    let lowest =
        |blade: &Vec<[[f64; 3]; 3]>| blade.iter().flatten().map(|p| p[1] - ground(p)).fold(f64::INFINITY, f64::min);
    assert!(blades.iter().all(|blade| lowest(blade) > -1e-3));
    // those that do not lie on the ground, by the cubes of 2 mm about their points
    let cube = |p: &[f64; 3]| p.map(|metres| (metres / 2e-3).floor() as i64);
    let mut hovering: BTreeSet<usize> = (0..blades.len()).filter(|&n| lowest(&blades[n]) > 2e-3).collect();
    let above = hovering.len();
    let mut near: std::collections::HashMap<[i64; 3], Vec<(usize, [f64; 3])>> = Default::default();
    for &number in &hovering {
        points(&blades[number]).into_iter().for_each(|p| near.entry(cube(&p)).or_default().push((number, p)));
    }
    for (number, blade) in blades.iter().enumerate() {
        for p in points(blade) {
            let [x, y, z] = cube(&p);
            for n in 0..27 {
                let Some(others) = near.get(&[x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1]) else { continue };
                for (other, q) in others.iter().filter(|(other, _)| *other != number) {
                    // points a millimetre apart are within 0.6 mm of any place of their blade
                    if (0..3).map(|k| (p[k] - q[k]) * (p[k] - q[k])).sum::<f64>() < 2.6e-3 * 2.6e-3 {
                        hovering.remove(other);
                    }
                }
            }
        }
    }
    // what lies on buried leaves only, which are not in the file
    assert!(above > 20 && hovering.len() <= buried, "{} of {above} hover; {buried} are buried", hovering.len());
}

#[test]
fn a_lying_leaf_takes_forty_bytes_of_an_instanced_file() {
    let scene = small(&["time.day=9", "output.png=false", "output.gltf=\"instanced\""]);
    let (files, report) = rendered(&scene, Options::default());
    let json = json(&files["small.glb"]);
    let (mut bytes, mut leaves) = (0, 0);
    for node in json["nodes"].as_array().unwrap() {
        let attributes = &node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
        if !node["name"].as_str().unwrap().starts_with("fallen_") {
            continue;
        }
        for (name, accessor) in attributes.as_object().into_iter().flatten() {
            let accessor = &json["accessors"][accessor.as_u64().unwrap() as usize];
            let count = accessor["count"].as_u64().unwrap();
            leaves += if name == "TRANSLATION" { count } else { 0 };
            bytes += count * if accessor["type"] == "VEC4" { 16 } else { 12 };
        }
    }
    assert!(leaves > 50 && leaves <= report.frames[0].fall.unwrap().lying);
    assert_eq!(bytes, 40 * leaves);
}
