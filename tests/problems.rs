//! Faults of scenes, as a person sees them: the place to the line and column, what is said, and that all are said at once.

use leafseason::base::diagnostic::{Diagnostic, Diagnostics, Fault};
use leafseason::base::limits::{Limit, Limits};
use leafseason::base::message::render;
use leafseason::run::{self, Options};
use leafseason::scene::{self, Scene};
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

const GOOD: &str = "species = \"red-maple\"\n";

fn folder(text: impl AsRef<[u8]>) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.toml"), text).unwrap();
    folder
}

fn read_in(folder: &Path, sets: &[&str], roots: &[PathBuf]) -> Result<Scene, Vec<Diagnostic>> {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    let read = scene::read(&folder.join("scene.toml"), &sets, roots, &Limits::default());
    read.map(|(scene, _)| scene).map_err(|Diagnostics(list)| list)
}

fn read(text: &str, sets: &[&str]) -> Result<Scene, Vec<Diagnostic>> {
    read_in(folder(text).path(), sets, &[])
}

/// The first lines of the messages, without the temporary folder.
fn messages(list: &[Diagnostic]) -> Vec<String> {
    let first = |text: String| text.lines().next().unwrap_or_default().to_owned();
    let bare = |line: String| {
        line.find("scene.toml:").filter(|_| line.starts_with('/')).map_or(line.clone(), |at| line[at..].to_owned())
    };
    list.iter().map(|one| bare(first(render(one)))).collect()
}

/// Asserts the beginnings of all messages for a text, in order.
fn refuse(text: &str, sets: &[&str], expected: &[&str]) {
    let found = messages(&read(text, sets).unwrap_err());
    assert_eq!(found.len(), expected.len(), "{found:#?}");
    for (found, expected) in found.iter().zip(expected) {
        assert!(found.starts_with(expected), "\n{found}\n{expected}");
    }
}

/// Asserts the messages for lines below a species.
fn refuse_below(lines: &str, expected: &[&str]) {
    refuse(&format!("{GOOD}{lines}"), &[], expected);
}

#[test]
fn the_smallest_scene_and_the_starter_read_without_a_word() {
    assert_eq!(read(GOOD, &[]).unwrap().time.at(0), 12.0);
    let starter = scene::starter("red-maple");
    assert_eq!(read(&starter, &[]).unwrap().time.at(0), 40.0);
    // with its examples too, one form of time at a time
    let whole =
        starter.replace("# from", "from").replace("# to", "to").replace("# step", "step").replace("day =", "# day =");
    let run = whole.replace("# gltf", "gltf").replace("# age", "age");
    assert_eq!(read(&run, &[]).unwrap().time.count(), 121.0);
}

#[test]
fn unknown_keys_come_with_what_was_meant() {
    refuse_below(
        "[climate]\n  humidty = 0.5\n",
        &["scene.toml:3:3: error: `humidty` is not known in [climate]; did you mean `humidity`?"],
    );
    refuse_below("sede = 3\n", &["scene.toml:2:1: error: `sede` is not known here; did you mean `seed`?"]);
    refuse_below("humidity = 0.5\n", &["scene.toml:2:1: error: `humidity` is not known here; it belongs in [climate]"]);
    refuse_below(
        "[season.states.x]\nhalflife = 2\n",
        &["scene.toml:3:1: error: `halflife` is not known in [season.states.x]; did you mean `half_life`?"],
    );
    refuse_below("season.states.x.halflife = 2\n", &["scene.toml:2:17: error: `halflife`"]);
}

#[test]
fn wrong_types_are_told_with_how_to_write_it() {
    refuse_below(
        "seed = \"lucky\"\n",
        &["scene.toml:2:8: error: `seed` must be a whole number, this is a string; write the number without quotes"],
    );
    refuse_below(
        "image = { width = 2.5 }\n",
        &[
            "scene.toml:2:19: error: `image.width` must be a whole number, this is a float; write it without a decimal point",
        ],
    );
    refuse_below(
        "climate = 3\n",
        &["scene.toml:2:11: error: `climate` must be a table, this is an integer; write [climate]"],
    );
    refuse_below("[[climate]]\nhumidity = 0.5\n", &["scene.toml:2:"]);
    refuse_below("[tree]\naxiom = [\"A\"]\n", &["scene.toml:3:9: error: `tree.axiom` must be a string"]);
    refuse_below(
        "[climate.humidity]\nx = 1\n",
        &["scene.toml:2:10: error: `climate.humidity` must be a number, this is a table"],
    );
    refuse_below("[output]\npng = 1\n", &["scene.toml:3:7: error: `output.png` must be true or false"]);
    refuse_below("[time]\nday = 2017-08-15\n", &["scene.toml:3:7: error: `time.day` must be a number"]);
}

#[test]
fn numbers_are_finite_and_in_range_also_in_lists() {
    refuse_below("[time]\nday = nan\n", &["scene.toml:3:7: error: `time.day` must be a finite number, not nan"]);
    refuse_below(
        "[camera]\nfield_of_view = -inf\n",
        &["scene.toml:3:17: error: `camera.field_of_view` must be a finite number"],
    );
    refuse_below(
        "[camera]\nposition = [1, inf, 0.0]\n",
        &["scene.toml:3:16: error: `camera.position.1` must be a finite number"],
    );
    refuse_below(
        "[climate]\ntemperature = 1e999\n",
        &["scene.toml:3:15: error: `climate.temperature` must be a finite number, not 1e999"],
    );
    refuse_below(
        "[camera]\nposition = [1, 0]\n",
        &["scene.toml:3:12: error: `camera.position` needs 3 values, here are 2"],
    );
    refuse_below(
        "[leaf]\noutline = [[0, 0], [1, 1], [2]]\n",
        &["scene.toml:3:28: error: `leaf.outline.2` needs 2 values"],
    );
    refuse_below(
        "[climate]\nhumidity = 2.0\n",
        &["scene.toml:3:12: error: `climate.humidity` is 2, outside 0 to 1; write a number from 0 to 1"],
    );
    refuse_below(
        "[image]\nwidth = 0\nsamples = -1\n",
        &["scene.toml:3:9: error: `image.width` is 0", "scene.toml:4:11: error: `image.samples` is -1"],
    );
    refuse_below("seed = -1\n", &["scene.toml:2:8: error: `seed` is -1, outside 0 to"]);
    refuse_below(
        "[season.states.green]\nwet_cold = [-0.5, 1.5]\n",
        &["scene.toml:3:13: error", "scene.toml:3:19: error"],
    );
    assert_eq!(read(&format!("{GOOD}seed = 18446744073709551615\n"), &[]).unwrap().seed, u64::MAX);
    refuse_below("seed = 18446744073709551616\n", &["scene.toml:2:8: error: `seed` is too large"]);
}

#[test]
fn words_are_chosen_from_a_list() {
    refuse_below(
        "[output]\ngltf = \"node\"\n",
        &["scene.toml:3:8: error: `output.gltf` cannot be \"node\"; write \"nodes\""],
    );
    refuse_below(
        "[ground]\nkind = \"concrete\"\n",
        &["scene.toml:3:8: error: `ground.kind` cannot be \"concrete\"; write \"grass\" or \"soil\" or \"none\""],
    );
}

#[test]
fn all_faults_of_all_kinds_are_told_at_once_in_order() {
    refuse(
        "species = \"red-mapel\"\nsede = 1\n[climate]\nhumidity = \"wet\"\ntemperature = 99\n[time]\nday = 1\nfrom = 2\n\
         [camera]\nnear = 10\nfar = 2\n[leaf]\npicture = \"gone.png\"\n[image]\nsamples = 5\n",
        &["climate.temperature=nan", "image.height=-1", "nonsense=1"],
        &[
            "scene.toml:1:11: error: there is no built-in species \"red-mapel\"; did you mean \"red-maple\"?",
            "scene.toml:2:1: error: `sede`",
            "scene.toml:4:12: error: `climate.humidity`",
            "scene.toml:5:15: error: `climate.temperature`",
            "scene.toml:8:8: error: time has both `day` and `from`",
            "scene.toml:11:7: error: the camera's `far`",
            "scene.toml:13:11: error: there is no file \"gone.png\"",
            "scene.toml:15:11: error: 5 samples",
            "--set climate.temperature=nan:1:21: error: `climate.temperature`",
            "--set image.height=-1:1:14: error: `image.height` is -1",
            "--set nonsense=1:1:1: error: `nonsense` is not known",
        ],
    );
}

#[test]
fn checks_between_keys() {
    refuse_below(
        "[camera]\nposition = [1.0, 1, 1]\ntarget = [1, 1, 1]\n",
        &["scene.toml:3:12: error: the camera stands on its target"],
    );
    refuse_below("[time]\nfrom = 3\n", &["scene.toml:3:8: error: time has `from` but no `to`"]);
    refuse_below("[time]\nfrom = 3\nto = 1\n", &["scene.toml:4:6: error: time ends at 1"]);
    refuse_below("[camera]\nnear = 1e4\n", &["scene.toml:2:2: error: `camera.far`: the camera's `far`"]);
}

#[test]
fn assignments_stand_above_the_scene_and_take_bare_words() {
    let text = format!("{GOOD}[time]\nfrom = 0\nto = 9\n[climate]\nhumidity = 0.5\n");
    let sets = [
        "output.gltf=nodes",
        "time.day=3",
        "climate.humidity=0.25",
        "climate.temperature= -4 ",
        "climate.humidity=0.3",
    ];
    let scene = read(&text, &sets).unwrap();
    assert_eq!(scene.output.gltf, Some(scene::output::Gltf::Nodes));
    assert_eq!((scene.time.count(), scene.time.at(0)), (1.0, 3.0));
    let day = scene.weather.days()[0];
    assert_eq!((day.humidity, day.temperature), (0.3, -4.0));
    refuse(
        GOOD,
        &["leaf.picture=gräpe.jpg"],
        &["--set leaf.picture=gräpe.jpg:1:14: error: there is no file \"gräpe.jpg\""],
    );
    refuse(
        GOOD,
        &["output.gltf=noods"],
        &["--set output.gltf=noods:1:13: error: `output.gltf` cannot be \"noods\"; write \"nodes\""],
    );
    refuse(GOOD, &["climate.humidity=2.0"], &["--set climate.humidity=2.0:1:18: error: `climate.humidity` is 2"]);
    refuse(GOOD, &["seed=[1"], &["--set seed=[1:1:"]);
    refuse(GOOD, &["seed="], &["--set seed=:1:1: error: there is no value"]);
    refuse(GOOD, &["seed=1\nseed=2"], &["--set seed=1\\nseed=2:1:1: error: an assignment is one line"]);
    let fault = read(GOOD, &["seed"]).unwrap_err().remove(0);
    assert_eq!(fault.fault, Fault::Usage);
}

#[test]
fn syntax_is_told_at_its_line() {
    refuse("a = 1\nb = 'x\nc = 2\n", &[], &["scene.toml:2:"]);
    refuse("species = \"red-maple\"\nthis is not toml\n", &[], &["scene.toml:2:"]);
    refuse(
        &format!("{GOOD}seed = 1\nseed = 2\nwrong = 1\n"),
        &[],
        &[
            "scene.toml:3:1: error: this is not TOML: duplicate key; keep one of the two",
            "scene.toml:4:1: error: `wrong`",
        ],
    );
    // of a text this large only the first fault is told
    let large = format!("{GOOD}# {}\nseed = = 1\nseed = = 2\n", "x".repeat(1_000_000));
    refuse(&large, &[], &["scene.toml:3:8: error: this is not TOML"]);
    let path = read("species = \"D:\\leaves\\oak.toml\"\n", &[]).unwrap_err();
    assert!(messages(&path)[0].starts_with("scene.toml:1:14: error: "), "{:?}", messages(&path));
    assert!(path[0].help.contains("'...' or with /"));
    let deep = format!("a = {}{}", "[".repeat(10_000), "]".repeat(10_000));
    assert!(messages(&read(&deep, &[]).unwrap_err())[0].starts_with("scene.toml:1:"));
    let nothing = read("", &[]).unwrap_err();
    assert!(messages(&nothing)[0].starts_with("scene.toml:1:1: error: the scene names no species"));
}

#[test]
fn bytes_that_are_not_utf8_have_a_place() {
    let folder = folder(b"a = 1\n\xc3\xa4 = \"\xff\"\n");
    let found = messages(&read_in(folder.path(), &[], &[]).unwrap_err());
    assert_eq!(found, ["scene.toml:2:6: error: byte 0xff is not UTF-8; save the file as UTF-8"]);
}

#[test]
fn a_byte_order_mark_and_line_ends_of_windows_do_not_shift_places() {
    refuse("\u{feff}species = \"red-maple\"\r\nsede = 1\r\n", &[], &["scene.toml:2:1: error: `sede`"]);
    refuse("\u{feff}sede = 1\nspecies = 'red-maple'", &[], &["scene.toml:1:1: error: `sede`"]);
}

#[test]
fn a_species_file_at_fault_is_told_at_its_own_line() {
    let folder = folder("species = \"oak.toml\"\n");
    fs::write(folder.path().join("oak.toml"), "name = \"oak\"\n[tree]\npetiole = -3\n[camera]\nnear = 1\n").unwrap();
    let faults = read_in(folder.path(), &[], &[]).unwrap_err();
    let found = messages(&faults);
    assert!(found[0].starts_with("oak.toml:3:11: error: `tree.petiole` is -3"), "{found:?}");
    assert!(found[1].starts_with("oak.toml:4:2: error: `camera` is not known here"), "{found:?}");
    assert_eq!(Diagnostics(faults).exit_code(), 3);
}

#[test]
fn a_scene_with_an_l_system_of_its_own_needs_no_species() {
    let scene = read("[tree]\naxiom = \"A\"\nrules = [\"A -> F\"]\n", &[]).unwrap();
    let species = &scene.species[0];
    assert_eq!((&species.name, species.tree.axiom.as_str()), (&None, "A"));
    refuse("[tree]\naxiom = \"A\"\n", &[], &["scene.toml:1:1: error: the scene names no species"]);
}

/// The messages for one rule of an L-system, when the scene is read or, if it reads well, when its plan is made; the
/// rule's text begins in column 11 of the third line.
fn rule_faults(rule: &str) -> (Vec<String>, u8) {
    let text = format!("[tree]\naxiom = \"A(1)\"\nrules = [\"{rule}\"]\n");
    let faults = match read(&text, &[]) {
        Err(list) => Diagnostics(list),
        Ok(scene) => run::plan(&scene, &Options::default()).unwrap_err(),
    };
    (messages(&faults.0), faults.exit_code())
}

#[test]
fn faults_of_rules_are_told_at_their_column() {
    let cases = [
        ("A(l) -> F(l)[+(30)A(l)", "3:23: error: `[` has no `]`"),
        ("A(l) -> F(l)]A(l)", "3:23: error: `]` has no `[`"),
        ("A(l) -> F(l)#A(l)", "3:23: error: `#` is not a symbol"),
        ("A(l) -> F(q)A(l)", "3:21: error: `q` is not known; known here: l, age"),
        ("A(l) -> F(foo(l))A(l)", "3:21: error: there is no function `foo`"),
        ("A(l) -> F(l/0)A(l)", "3:21: error: division by zero"),
        ("A(l) -> F(l)A(1/(l-1))", "3:25: error: a value of this expression is not a number"),
        ("A(l) : ln(0-l) > 1 -> F(l)", "3:18: error: a value of this expression is not a number"),
        ("A(l) : * : sqrt(0-l) -> F(l)", "3:22: error: a value of this expression is not a number"),
        ("A(l) -> F(l)A", "3:23: error: `A` has 0 parameters; it takes 1"),
        ("A(l) -> F(l,2)A(l)", "3:19: error: `F` has 2 parameters; it takes 0 to 1"),
        ("A(l) F(m) -> F(l)", "3:16: error: `->` is missing here; a rule rewrites one symbol"),
        ("A(l,m) < A(l) -> F(l)", "3:22: error: `l` stands here twice"),
        ("A(k,m) < A(l) -> F(l)", "3:11: error: `A` cannot have 2 parameters; it takes 1"),
        ("[ < A(l) -> F(l)", "3:11: error: `[` cannot be rewritten or looked for"),
        ("A(l) > -> F(l)", "3:18: error: a symbol is missing here"),
    ];
    for (rule, expected) in cases {
        let (found, code) = rule_faults(rule);
        assert!(found[0].starts_with(&format!("scene.toml:{expected}")), "{rule}: {found:#?}");
        assert_eq!((found.len(), code), (1, 3), "{rule}: {found:#?}");
    }
    let (bomb, code) = rule_faults("A(l) -> A(l)A(l)A(l)A(l)A(l)A(l)A(l)A(l)A(l)A(l)");
    assert!(bomb[0].starts_with("scene.toml:3:9: error: tree.rules needs 10000000000 symbols"), "{bomb:#?}");
    assert_eq!(code, 6);
}

#[test]
fn assets_stay_below_their_folders() {
    let root = tempfile::tempdir().unwrap();
    fs::write(root.path().join("far.png"), "x").unwrap();
    let folder = folder(GOOD);
    fs::write(folder.path().join("grape.png"), "x").unwrap();
    let roots = [root.path().to_owned()];
    let found = |name: &str| {
        read_in(folder.path(), &[&format!("leaf.picture='{name}'")], &roots).map(|s| s.species[0].assets.clone())
    };
    assert_eq!(found("far.png").unwrap()["leaf.picture"].path, root.path().join("far.png"));
    assert!(found("./x/../grape.png").is_ok());
    for (name, word) in [
        ("../scene.toml", "climbs out"),
        ("a/../../x", "climbs out"),
        ("/etc/passwd", "absolute"),
        ("/dev/urandom", "absolute"),
        (".", "names no file"),
        ("graep.png", "did you mean \"grape.png\"?"),
        ("grape.png/x", "there is no file"),
    ] {
        let faults = found(name).unwrap_err();
        assert_eq!(faults[0].fault, Fault::Asset, "{name}");
        assert!(render(&faults[0]).contains(word), "{name}: {}", render(&faults[0]));
    }
}

#[cfg(unix)]
#[test]
fn links_that_lead_out_and_folders_are_refused() {
    let folder = folder(GOOD);
    std::os::unix::fs::symlink("/etc/passwd", folder.path().join("out.png")).unwrap();
    std::os::unix::fs::symlink("scene.toml", folder.path().join("in.png")).unwrap();
    std::os::unix::fs::symlink("/dev/zero", folder.path().join("zero.png")).unwrap();
    fs::create_dir(folder.path().join("sub.png")).unwrap();
    let read = |name: &str| read_in(folder.path(), &[&format!("leaf.mask={name}")], &[]);
    assert!(read("in.png").is_ok());
    for name in ["out.png", "zero.png", "sub.png"] {
        assert_eq!(read(name).unwrap_err()[0].fault, Fault::Asset, "{name}");
    }
}

#[test]
fn limits_are_the_operators_and_name_their_flag() {
    for (lines, flag) in [
        ("[image]\nwidth = 100000\nheight = 100000\n", "--limit pixels=10000000000"),
        ("[deform]\nsteps = 100000000000\n", "--limit steps=100000000000"),
        ("[time]\nfrom = 0\nto = 1000000\nstep = 0.001\n", "--limit frames=1000000001"),
        ("[leaf]\nvertices = 1000000\n", "--limit vertices=1000000"),
    ] {
        let faults = read(&format!("{GOOD}{lines}"), &[]).unwrap_err();
        assert_eq!(faults.len(), 1, "{faults:?}");
        assert_eq!(faults[0].fault, Fault::Limit);
        assert!(faults[0].help.contains(flag), "{}", faults[0].help);
        assert!(faults[0].place.is_some());
    }
    let folder = folder(" ".repeat(16_000_001));
    assert_eq!(Diagnostics(read_in(folder.path(), &[], &[]).unwrap_err()).exit_code(), 6);
    let mut limits = Limits::default();
    limits.set(Limit::Pixels, 10.0);
    let good = self::folder(GOOD);
    assert!(scene::read(&good.path().join("scene.toml"), &[], &[], &limits).is_err());
}

#[test]
fn a_missing_scene_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let found = messages(&read_in(folder.path(), &[], &[]).unwrap_err());
    assert!(found[0].starts_with("scene.toml:1:1: error: cannot read this file"), "{found:?}");
}

#[test]
fn thousands_of_faults_are_bounded() {
    let text: String = (0..5000).map(|i| format!("key{i} = {i}\n")).collect();
    let faults = read(&format!("{GOOD}{text}"), &[]).unwrap_err();
    assert!(faults.len() <= 1001);
    assert!(leafseason::base::message::render_all(&faults).len() <= 8000);
}

#[test]
fn the_resolved_scene_depends_on_values_and_contents_alone() {
    let one = folder(format!("# a remark\n{GOOD}seed = 3\n[leaf]\npicture = 'a.png'\n[climate]\nhumidity = 0.7\n"));
    let two = folder("leaf.picture = \"a.png\"\nseed = 0x3\nspecies = 'red-maple'\n");
    for folder in [&one, &two] {
        fs::write(folder.path().join("a.png"), "x").unwrap();
    }
    let resolved = |folder: &TempDir| read_in(folder.path(), &[], &[]).unwrap().resolved();
    assert_eq!(resolved(&one).to_string(), resolved(&two).to_string());
    fs::write(two.path().join("a.png"), "y").unwrap();
    assert_ne!(resolved(&one), resolved(&two));
    let value = resolved(&one);
    let keys: Vec<&String> = value.as_object().unwrap().keys().collect();
    assert!(keys.is_sorted());
}

#[test]
fn trees_are_checked_like_every_other_table() {
    refuse_below(
        "[[trees]]\nplace = [nan, 0]\n[[trees]]\nplase = [1, 2]\n[[trees]]\nplace = [1, 2, 3]\n[[trees]]\nage = 0\n",
        &[
            "scene.toml:3:10: error: `trees.0.place.0` must be a finite number, not nan",
            "scene.toml:5:1: error: `plase` is not known in [trees.1]; did you mean `place`?",
            "scene.toml:7:9: error: `trees.2.place` needs 2 values, here are 3",
            "scene.toml:9:7: error: `trees.3.age` is 0, outside",
        ],
    );
    refuse_below("[trees]\nplace = [0, 0]\n", &["scene.toml:2:2: error: `trees` must be a list"]);
    refuse_below("trees = []\n", &["scene.toml:2:9: error: `trees` needs 1 to 1000 values, here are 0"]);
    refuse_below("[[trees]]\nspacing = 3\n", &["scene.toml:3:11: error: `spacing` is for groves"]);
    refuse_below("[[trees]]\ncount = 50\narea = [8, 8]\n", &["scene.toml:3:9: error: only "]);
}

#[test]
fn every_tree_has_a_species_that_is_there() {
    refuse(
        "[[trees]]\nspecies = \"red-mapel\"\n[[trees]]\nspecies = \"red-maple\"\n",
        &[],
        &["scene.toml:2:11: error: there is no built-in species \"red-mapel\""],
    );
    refuse(
        "[[trees]]\nspecies = \"red-maple\"\n[[trees]]\nplace = [3, 0]\n",
        &[],
        &["scene.toml:3:1: error: tree 1 of [[trees]] has no species"],
    );
    // The scene's own species is checked although no tree is of it, and told once although two trees are.
    refuse("species = \"oak\"\n[[trees]]\nspecies = \"red-maple\"\n", &[], &["scene.toml:1:11: error: there is no"]);
    refuse("species = \"oak\"\n[[trees]]\n[[trees]]\n", &[], &["scene.toml:1:11: error: there is no"]);
    let trees = read("[[trees]]\nspecies = \"red-maple\"\n[[trees]]\nspecies = \"red-maple\"\nage = 5\n", &[]).unwrap();
    assert_eq!((trees.species.len(), trees.trees.len()), (1, 2));
    assert_ne!(trees.trees[0].tree, trees.trees[1].tree);
}

#[test]
fn faults_of_two_species_are_told_each_in_its_file_and_those_of_the_scene_once() {
    let text = "[leaf]\nvertices = 1\n[[trees]]\nspecies = \"a.toml\"\n[[trees]]\nspecies = \"b.toml\"\n";
    let folder = folder(text);
    let species = |petiole: &str| format!("[tree]\naxiom = \"F\"\nrules = []\npetiole = {petiole}\n");
    fs::write(folder.path().join("a.toml"), species("-1")).unwrap();
    fs::write(folder.path().join("b.toml"), species("-2")).unwrap();
    let found = messages(&read_in(folder.path(), &[], &[]).unwrap_err());
    assert_eq!(found.len(), 3, "{found:#?}");
    for (found, beginning) in found.iter().zip(["scene.toml:2:12", "a.toml:4:11", "b.toml:4:11"]) {
        assert!(found.starts_with(beginning), "{found}");
    }
}

#[test]
fn contact_sheets_are_pictures_of_cells_that_can_be_seen() {
    let folder = folder(format!("{GOOD}seeds = [1, 2]\noutput.gltf = \"nodes\"\n"));
    let (scene, warnings) = scene::read(&folder.path().join("scene.toml"), &[], &[], &Limits::default()).unwrap();
    assert_eq!((scene.output.gltf, warnings.len()), (None, 1));
    assert!(messages(&warnings)[0].starts_with("scene.toml:2:9: warning: a contact sheet is a picture"));
    refuse_below(
        "seeds = [1, 2, 3, 4, 5]\nimage = { width = 40, height = 90 }\n",
        &["scene.toml:2:9: error: cells of 13"],
    );
    refuse_below("seeds = []\n", &["scene.toml:2:9: error: `seeds` needs 1 to 100 values, here are 0"]);
}

#[test]
fn leaves_of_all_trees_are_held_against_the_limit() {
    let mut limits = Limits::default();
    limits.set(Limit::Leaves, 3000.0);
    let folder = folder("species = \"red-maple\"\ntree.age = 5\n[[trees]]\ncount = 60\nforms = 2\n");
    let (scene, _) = scene::read(&folder.path().join("scene.toml"), &[], &[], &limits).unwrap();
    let options = leafseason::run::Options { limits, ..leafseason::run::Options::default() };
    let Diagnostics(found) = leafseason::run::plan(&scene, &options).unwrap_err();
    assert_eq!(found[0].fault, Fault::Limit);
    assert!(found[0].message.starts_with("trees needs "), "{}", found[0].message);
    // What the refusal names is enough.
    let mut limits = Limits::default();
    limits.set(Limit::Memory, 1e8);
    let options = |limits| leafseason::run::Options { limits, ..leafseason::run::Options::default() };
    let Diagnostics(found) = leafseason::run::plan(&scene, &options(limits.clone())).unwrap_err();
    let flag = found[0].help.rsplit_once("--memory-limit ").unwrap().1.trim_end_matches('M');
    limits.set(Limit::Memory, flag.parse::<f64>().unwrap() * 1e6);
    assert!(leafseason::run::plan(&scene, &options(limits)).is_ok());
}
