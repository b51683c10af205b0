//! Scenes of several trees and contact sheets: what trees share, what each has for itself, and what stays as it is when
//! another is planted.

mod common;

use common::{render, small};
use leafseason::compose::contact_sheet::Sheet;
use leafseason::run::{self, Options};
use leafseason::scene::{self, Scene};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

const THREE: &str = "trees=[{}, {place=[4, -2]}, {place=[-3, 1], age=4, seed=9}]";

fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let read =
        |entry: fs::DirEntry| (entry.file_name().to_string_lossy().into_owned(), fs::read(entry.path()).unwrap());
    fs::read_dir(folder).unwrap().map(|entry| read(entry.unwrap())).collect()
}

/// What a run leaves: its folder, its report and the lines of its file of states.
struct Made {
    folder: TempDir,
    report: leafseason::report::Report,
    states: String,
}

fn made(scene: &Scene) -> Made {
    let folder = tempfile::tempdir().unwrap();
    let states = tempfile::tempdir().unwrap();
    let csv = states.path().join("states.csv");
    let options = Options { out: folder.path().to_owned(), states: Some(csv.clone()), ..Options::default() };
    let report = render(scene, &options).report;
    Made { folder, report, states: fs::read_to_string(csv).unwrap() }
}

/// The lines of each tree, without the tree's number.
fn by_tree(states: &str) -> BTreeMap<String, Vec<String>> {
    let mut trees: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for line in states.lines().skip(1) {
        let (line, tree) = line.rsplit_once(',').unwrap();
        trees.entry(tree.to_owned()).or_default().push(line.to_owned());
    }
    trees
}

fn figure(made: &Made, name: &str) -> f64 {
    made.report.figure("tree", name).and_then(Value::as_f64).unwrap_or_else(|| panic!("no {name}"))
}

#[test]
fn one_entry_at_the_origin_is_the_scene_without_it() {
    let (plain, planted) = (small(&["time.day=9"]), small(&["time.day=9", "trees=[{}]"]));
    assert_eq!(plain.resolved(), planted.resolved());
    let (plain, planted) = (made(&plain), made(&planted));
    assert_eq!(files(plain.folder.path()), files(planted.folder.path()));
    assert_eq!(plain.states, planted.states);
    assert!(plain.states.starts_with("frame,day,leaf,state,since_day\n"));
}

#[test]
fn every_leaf_of_every_tree_has_an_id_of_its_own() {
    let made = made(&small(&["time.day=9", "output.png=false", "trees=[{}, {count=9, forms=2, area=[30, 30]}]"]));
    assert!(made.states.starts_with("frame,day,leaf,state,since_day,tree\n"));
    let fields: Vec<Vec<&str>> = made.states.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let ids: BTreeSet<&str> = fields.iter().map(|fields| fields[2]).collect();
    assert_eq!((ids.len(), fields.len()), (fields.len(), figure(&made, "leaves") as usize));
    let trees: BTreeSet<&str> = fields.iter().map(|fields| fields[5]).collect();
    assert_eq!(trees.len(), 10);
    assert_eq!((figure(&made, "trees"), figure(&made, "forms")), (10.0, 3.0));
    // Trees of one form lose their leaves each in their own time.
    let trees = by_tree(&made.states);
    let states = |tree: &str| -> Vec<String> {
        trees[tree].iter().map(|line| line.split(',').skip(3).collect::<Vec<_>>().join(",")).collect()
    };
    assert_eq!(states("1").len(), states("3").len());
    assert_ne!(states("1"), states("3"));
}

#[test]
fn a_tree_more_at_the_end_changes_no_other() {
    let sets = |trees: &str| made(&small(&["time.day=9", "output.png=false", trees])).states;
    let two = by_tree(&sets("trees=[{count=3, area=[9, 9]}, {place=[8, 8]}]"));
    let three = by_tree(&sets("trees=[{count=3, area=[9, 9]}, {place=[8, 8]}, {place=[-9, 0]}]"));
    assert_eq!((two.len(), three.len()), (4, 5));
    assert!(two.iter().all(|(tree, lines)| three[tree] == *lines));
    let alone = made(&small(&["time.day=9", "output.png=false"])).states;
    assert_eq!(alone.lines().skip(1).collect::<Vec<_>>(), three["0"]);
}

#[test]
fn a_grove_that_grows_keeps_its_trees_and_its_distances() {
    let grove = |count: u32| {
        let scene = small(&[&format!("trees=[{{place=[1, 1]}}, {{count={count}, area=[30, 20], spacing=2.5}}]")]);
        scene.standing().unwrap()
    };
    let (few, many) = (grove(20), grove(40));
    assert_eq!(few[..], many[..21]);
    for (number, tree) in many.iter().enumerate() {
        assert!(tree.place[0].abs() <= 15.0 && tree.place[1].abs() <= 10.0);
        for other in &many[..number] {
            let apart = libm::hypot(tree.place[0] - other.place[0], tree.place[1] - other.place[1]);
            assert!(apart >= 2.5, "{apart}");
        }
    }
    assert_eq!(many.iter().map(|tree| tree.key).collect::<BTreeSet<_>>().len(), 41);
}

#[test]
fn leaves_times_their_mean_area_is_the_area_over_the_ground_times_the_ground() {
    for sets in [&["time.day=9", "output.png=false"][..], &["time.day=9", "output.png=false", THREE]] {
        let made = made(&small(sets));
        let blades = figure(&made, "leaves") * figure(&made, "mean_blade_area_cm2") * 1e-4;
        let ground = figure(&made, "leaf_area_index") * figure(&made, "crown_projection_m2");
        assert!((blades / ground - 1.0).abs() < 1e-9, "{blades} {ground}");
        let frame = &made.report.frames[0];
        assert_eq!(frame.leaves as f64, figure(&made, "leaves"));
        assert_eq!(frame.states.values().sum::<u64>(), frame.leaves);
        assert!((frame.expected.values().sum::<f64>() - 1.0).abs() < 1e-9);
    }
}

#[test]
fn trees_give_the_same_bytes_on_any_threads_and_with_everything_made() {
    let scene = small(&["time.day=400", THREE]);
    let scenes = [scene, small(&["time.day=9", THREE])];
    for scene in &scenes {
        let run = |threads: usize, leave_out: bool| {
            let folder = tempfile::tempdir().unwrap();
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let options = Options { out: folder.path().to_owned(), leave_out, ..Options::default() };
            pool.install(|| render(scene, &options));
            files(folder.path())
        };
        let one = run(1, true);
        assert!(one == run(3, true) && one == run(2, false));
    }
}

/// Two species files: the small one loses its leaves at once, so that states and their laws differ.
fn two_species() -> (TempDir, Scene) {
    let folder = tempfile::tempdir().unwrap();
    let tree = |lines: &str| format!("[tree]\naxiom = \"F(1)[+L]L\"\nrules = []\n{lines}");
    let leaf = "[leaf]\noutline = [[0, 0], [15, 20], [0, 45], [-15, 20]]\nvertices = 60\n[colour]\nsize = 32\nvariants = 1\n\
                [deform]\nsteps = 40\nshapes = 1\n";
    let season = |states: &str| format!("[season]\nstart = \"green\"\n[season.states]\n{states}");
    let one = season("green = {}\n");
    let two = season(
        "green = { half_life = 0.001, next = [\"pale\"], wet_cold = [1.0], wet_warm = [1.0], dry_cold = [1.0], dry_warm = [1.0] }\npale = {}\n",
    );
    let pigment = "[colour.pigments.pale]\nchlorophyll = 2.0\n";
    fs::write(folder.path().join("one.toml"), format!("{}{leaf}{one}", tree(""))).unwrap();
    fs::write(folder.path().join("two.toml"), format!("{}{leaf}{pigment}{two}", tree("petiole = 20.0\n"))).unwrap();
    let scene = "species = \"one.toml\"\nlight.shadow_size = 64\nimage = { width = 64, height = 48, samples = 1 }\n\
                 time.day = 3.0\noutput.gltf = \"nodes\"\n\
                 [[trees]]\n[[trees]]\nspecies = \"two.toml\"\nplace = [2.0, 0.0]\n[[trees]]\nplace = [4.0, 0.0]\n";
    let path = folder.path().join("pair.toml");
    fs::write(&path, scene).unwrap();
    let read = scene::read(&path, &[], &[], &leafseason::base::limits::Limits::default());
    (folder, read.unwrap_or_else(|fault| panic!("{fault}")).0)
}

#[test]
fn species_have_their_own_states_and_the_report_counts_all() {
    let (_folder, scene) = two_species();
    assert_eq!(scene.species.len(), 2);
    let made = made(&scene);
    let frame = &made.report.frames[0];
    assert_eq!(frame.leaves, 6);
    assert_eq!(frame.states, BTreeMap::from([("green".to_owned(), 4), ("pale".to_owned(), 2)]));
    assert!((frame.expected["pale"] - 1.0 / 3.0).abs() < 1e-9);
    for stage in ["leaf", "deform", "colour"] {
        let of_species = made.report.figure(stage, "species").unwrap().as_object().unwrap();
        assert_eq!(of_species.keys().collect::<Vec<_>>(), ["one.toml", "two.toml"], "{stage}");
    }
    let plan = run::plan(&scene, &Options::default()).unwrap();
    let jobs: Vec<String> = plan.jobs.iter().map(|job| format!("{} {}", job.stage, job.name)).collect();
    assert!(jobs.contains(&"deform two.toml pale 0".to_owned()), "{jobs:?}");
    let left: Vec<&str> = plan.left_out.iter().map(|left| left.what.as_str()).collect();
    assert!(left.contains(&"deform two.toml green 0"), "{left:?}");
    let file = gltf::Gltf::open(made.folder.path().join("pair.glb")).unwrap();
    let names: BTreeSet<&str> = file.meshes().filter_map(|mesh| mesh.name()).collect();
    assert!(names.contains("leaf_one_green_0") && names.contains("leaf_two_pale_0"), "{names:?}");
    let wood = file.nodes().filter(|node| node.name().is_some_and(|name| name.contains("trunk"))).count();
    assert_eq!(
        (wood, file.meshes().filter(|mesh| mesh.name().is_some_and(|name| name.contains("trunk"))).count()),
        (3, 3)
    );
}

#[test]
fn trees_of_one_form_share_their_wood() {
    let sets = ["time.day=9", "output.png=false", "trees=[{seed=4}, {seed=4, place=[5, 0], turn=70}]"];
    let made = made(&small(&sets));
    let file = gltf::Gltf::open(made.folder.path().join("small.glb")).unwrap();
    let wood: Vec<_> = file.nodes().filter(|node| node.name().is_some_and(|name| name.starts_with("trunk"))).collect();
    assert_eq!((wood.len(), figure(&made, "forms")), (2, 1.0));
    assert_eq!(wood[0].mesh().unwrap().index(), wood[1].mesh().unwrap().index());
    let (translation, rotation, _) = wood[1].transform().decomposed();
    assert_eq!(translation, [5.0, 0.0, 0.0]);
    assert!((rotation[1] - libm::sinf(35f32.to_radians())).abs() < 1e-6);
}

#[test]
fn a_fitted_camera_sees_every_tree() {
    use leafseason::compose::{Form, Stand, Stock, Wardrobe};
    let scene = small(&["trees=[{place=[-30, 0]}, {place=[40, 5]}, {place=[0, -20]}]"]);
    let grown = leafseason::tree::grow(&scene.species[0].tree, 1, &leafseason::base::limits::Limits::default());
    let form = Form::new(0, grown.unwrap().0);
    let trees = scene.standing().unwrap().into_iter().map(|tree| (0, tree)).collect();
    let stand = Stand::new(vec![form], trees);
    let camera = Stock::new(&scene, &stand, &Wardrobe::default()).frame(&scene, &stand, &[]).camera;
    assert!((camera.position.x - 5.0).abs() < 1e-3, "{}", camera.position.x);
    for [x, z] in [[-30.0, 0.0], [40.0, 5.0], [0.0, -20.0]] {
        let slope = (x - camera.position.x).abs() / (camera.position.z - z);
        assert!(slope < libm::tanf(camera.field_of_view * 0.5) * 1.5);
    }
}

#[test]
fn a_contact_sheet_has_each_seed_in_its_cell() {
    let sets = ["time.day=9", "ground.kind=none", "light.shadow_size=0"];
    let sheet = small(&[&sets[..], &["seeds=[7, 3, 7]"]].concat());
    let picture = |scene: &Scene| {
        let made = made(scene);
        let image = image::open(made.folder.path().join("small.png")).unwrap().into_rgb8();
        (made, image)
    };
    let (run, image) = picture(&sheet);
    assert_eq!(image.dimensions(), (96, 64));
    assert!(run.states.starts_with("frame,day,leaf,state,since_day,seed\n"));
    let sums: u64 = run.report.frames[0].states.values().sum();
    assert_eq!(run.report.frames[0].leaves, sums);
    let grid = Sheet::new(96, 64, 3);
    let pixels = |number: usize| -> Vec<image::Rgb<u8>> {
        let [left, top, width, height] = grid.cell(number);
        let places = (top..top + height).flat_map(|y| (left..left + width).map(move |x| (x, y)));
        places.map(|(x, y)| *image.get_pixel(x, y)).collect()
    };
    assert_ne!(pixels(0)[..], pixels(1)[..]);
    // The cell is what the scene draws with that seed at that size, but for the number in the corner.
    let [_, _, width, height] = grid.cell(1);
    let size = [format!("image.width={width}"), format!("image.height={height}"), "seed=3".to_owned()];
    let alone = small(&[&sets[..], &size.each_ref().map(String::as_str)].concat());
    let alone: Vec<image::Rgb<u8>> = picture(&alone).1.pixels().copied().collect();
    let differing = pixels(1).iter().zip(&alone).filter(|(a, b)| a != b).count();
    assert!(differing > 10 && differing < 60, "{differing}");
    let plan = run::plan(&sheet, &Options::default()).unwrap();
    assert!(plan.jobs.iter().any(|job| job.name == "(seed 7)") && plan.jobs.iter().any(|job| job.name == "(seed 3)"));
}

#[test]
fn a_seed_chosen_from_a_sheet_draws_its_tree() {
    assert!(small(&["seeds=[4, 5]", "seed=5"]).seeds.is_empty());
    let sheet = small(&["seed=5", "seeds=[4, 6]"]);
    assert_eq!((sheet.seed, sheet.seeds), (4, vec![4, 6]));
}
