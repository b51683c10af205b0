//! The same scene gives the same bytes, however it is run: on any number of threads, frame by frame or at once, in
//! shards, again, and with everything made that a run may leave out.

mod common;

use common::{render, small};
use leafseason::plan::Reason;
use leafseason::run::frame_list::Shard;
use leafseason::run::progress::{Mode, Progress};
use leafseason::run::signals::Signals;
use leafseason::run::{self, Options};
use leafseason::scene::Scene;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Write};
use std::path::Path;
use std::sync::{Arc, Mutex};

/// Four frames while the leaves turn and begin to fall.
const TURNING: [&str; 3] = ["time.from=3", "time.to=12", "time.step=3"];
const FRAMES: usize = 4;

/// Every file of a folder, manifests too.
type Files = BTreeMap<String, Vec<u8>>;

fn files(folder: &Path) -> Files {
    let read =
        |entry: fs::DirEntry| (entry.file_name().to_string_lossy().into_owned(), fs::read(entry.path()).unwrap());
    fs::read_dir(folder).unwrap().map(|entry| read(entry.unwrap())).collect()
}

fn into(folder: &Path) -> Options {
    Options { out: folder.to_owned(), ..Options::default() }
}

/// Renders into one new folder with each of the options in turn, whose own folder is ignored.
fn made(scene: &Scene, calls: &[Options]) -> Files {
    let folder = tempfile::tempdir().unwrap();
    for call in calls {
        render(scene, &Options { out: folder.path().to_owned(), ..call.clone() });
    }
    files(folder.path())
}

fn assert_same(found: &Files, expected: &Files, what: &str) {
    let names = |files: &Files| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(found), names(expected), "{what}");
    for (name, bytes) in found {
        assert!(*bytes == expected[name], "{what}: {name} differs");
    }
}

#[test]
fn the_frames_differ_so_that_the_tests_here_can_fail() {
    let scene = small(&TURNING);
    let files = made(&scene, &[Options::default()]);
    assert_eq!(files.len(), 3 * FRAMES, "{:?}", files.keys());
    let pictures: Vec<&Vec<u8>> = files.iter().filter(|(name, _)| name.ends_with(".png")).map(|(_, b)| b).collect();
    assert!(pictures.windows(2).all(|pair| pair[0] != pair[1]));
    let other = made(&small(&[&TURNING[..], &["seed=12"]].concat()), &[Options::default()]);
    assert!(files.iter().all(|(name, bytes)| other[name] != *bytes));
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let scene = small(&TURNING);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| made(&scene, &[Options::default()]))
    };
    let one = on(1);
    assert_same(&on(2), &one, "two threads");
    assert_same(&on(5), &one, "five threads");
}

#[test]
fn frames_one_by_one_backwards_in_shards_or_again_give_the_same_bytes() {
    let scene = small(&TURNING);
    let at_once = made(&scene, &[Options::default()]);
    assert_same(&made(&scene, &[Options::default()]), &at_once, "a second run");
    let one = |frame: usize| Options { frames: Some(frame.to_string().parse().unwrap()), ..Options::default() };
    let backwards: Vec<Options> = (0..FRAMES).rev().map(one).collect();
    assert_same(&made(&scene, &backwards), &at_once, "frames one by one, the last first");
    let shard = |shard: &str| Options { shard: Some(shard.parse::<Shard>().unwrap()), ..Options::default() };
    assert_same(&made(&scene, &[shard("1/2"), shard("0/2")]), &at_once, "two shards");
}

/// A reason's name, whether a reason is that one, and what makes it occur in the small scene.
type Occurrence = (&'static str, fn(Reason) -> bool, &'static [&'static str]);

const REASONS: [Occurrence; 4] = [
    ("unreachable", |reason| reason == Reason::Unreachable, &["time.day=9"]),
    ("worn by no leaf", |reason| reason == Reason::WornByNoLeaf, &["time.day=0.5"]),
    ("no leaf left", |reason| reason == Reason::NoLeafLeft, &["time.day=400"]),
    ("same as", |reason| matches!(reason, Reason::SameAs(_)), &["time.from=0", "time.to=300", "time.step=100"]),
];

/// The layouts of a GLB file, the first with a picture beside it: the picture does not depend on them.
const OUTPUTS: [&str; 3] = [
    "output={png=true, gltf=\"nodes\"}",
    "output={png=false, gltf=\"merged\"}",
    "output={png=false, gltf=\"instanced\"}",
];

#[test]
fn what_is_left_out_would_have_changed_no_byte() {
    for ((name, is_it, sets), output) in REASONS.iter().flat_map(|reason| OUTPUTS.map(|output| (*reason, output))) {
        let scene = small(&[sets, &[output, "ground.kind=none"][..]].concat());
        let has = |leave_out| {
            let plan = run::plan(&scene, &Options { leave_out, ..Options::default() }).unwrap();
            plan.left_out.iter().any(|left| is_it(left.reason))
        };
        assert_eq!((has(true), has(false)), (true, false), "{name}");
        let all = made(&scene, &[Options { leave_out: false, ..Options::default() }]);
        assert_same(&made(&scene, &[Options::default()]), &all, name);
    }
}

/// A shadow map without sun is never drawn; the scene that asks for none shows that it would change nothing.
#[test]
fn a_shadow_map_without_sun_would_have_no_effect() {
    for dark in ["light.sun=0", "light.sun_elevation=-5"] {
        let pictures = ["light.shadow_size=256", "light.shadow_size=0"].map(|size| {
            let scene = small(&["time.day=9", dark, size]);
            let plan = run::plan(&scene, &Options::default()).unwrap();
            let has = plan.left_out.iter().any(|left| left.reason == Reason::NoEffect);
            assert_eq!(has, !size.ends_with("=0"), "{dark}");
            let mut files = made(&scene, &[Options::default()]);
            // The manifest names the scene, and these are two.
            files.retain(|name, _| !name.ends_with(run::manifest::SUFFIX));
            files
        });
        assert_same(&pictures[0], &pictures[1], dark);
    }
    let lit = ["light.shadow_size=256", "light.shadow_size=0"]
        .map(|size| made(&small(&["time.day=9", size]), &[Options::default()])["small.png"].clone());
    assert!(lit[0] != lit[1]);
}

/// What a run tells, kept for a look afterwards.
#[derive(Clone, Default)]
struct Told(Arc<Mutex<Vec<u8>>>);

impl Write for Told {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Renders; the frames that progress calls kept, and those it calls drawn.
fn told(scene: &Scene, options: &Options) -> (Vec<i64>, Vec<i64>) {
    let told = Told::default();
    let mut progress = Progress::to(Mode::Json, Box::new(told.clone()));
    run::render(scene, options, &mut progress, &Signals::default()).unwrap();
    let text = String::from_utf8(told.0.lock().unwrap().clone()).unwrap();
    let events: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let of = |word: &str| {
        let those = events.iter().filter(|event| event["event"] == word);
        those.map(|event| event["frame"].as_i64().unwrap()).collect()
    };
    (of("kept"), of("drawn"))
}

#[test]
fn finished_frames_are_kept_and_damaged_missing_or_foreign_ones_are_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, options) = (small(&TURNING), into(folder.path()));
    let path = |name: &str| folder.path().join(name);
    assert_eq!(told(&scene, &options), (vec![], vec![0, 1, 2, 3]));
    let whole = files(folder.path());
    assert_eq!(told(&scene, &options), (vec![0, 1, 2, 3], vec![]));
    fs::remove_file(path("small.0002.png")).unwrap();
    let mut damaged = whole["small.0000.glb"].clone();
    *damaged.last_mut().unwrap() ^= 1;
    fs::write(path("small.0000.glb"), damaged).unwrap();
    fs::write(path("small.0003.manifest.json"), "{}").unwrap();
    assert_eq!(told(&scene, &options), (vec![1], vec![0, 2, 3]));
    assert_same(&files(folder.path()), &whole, "after mending");
    assert_eq!(told(&scene, &Options { force: true, ..options.clone() }), (vec![], vec![0, 1, 2, 3]));
    assert_same(&files(folder.path()), &whole, "drawn anew");
    // A frame under the right name, but of another scene: as found, and with this one's pictures in its place.
    let warmer = small(&[&TURNING[..], &["climate.temperature=10"]].concat());
    assert_eq!(told(&warmer, &options), (vec![], vec![0, 1, 2, 3]));
    fs::write(path("small.0001.png"), &whole["small.0001.png"]).unwrap();
    assert_eq!(told(&warmer, &options), (vec![0, 2, 3], vec![1]));
    // The manifest of frame 1 does not vouch for frame 2.
    fs::copy(path("small.0001.manifest.json"), path("small.0002.manifest.json")).unwrap();
    assert_eq!(told(&warmer, &options), (vec![0, 1, 3], vec![2]));
}
