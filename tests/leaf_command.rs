//! `leafseason leaf`: from a scan to files that a scene takes in place of the scan, with the same picture.

#[path = "common/painted_leaf.rs"]
mod painted_leaf;

use leafseason::base::limits::Limits;
use leafseason::base::picture::Picture;
use leafseason::export;
use leafseason::scene::{self, Asset};
use painted_leaf::{Scan, outline, painted};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

fn leafseason(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_leafseason"));
    command.current_dir(folder).args(arguments).output().expect("the program runs")
}

fn code(output: &Output) -> (i32, String) {
    (output.status.code().unwrap(), String::from_utf8(output.stderr.clone()).unwrap())
}

fn with_scan(scan: Scan) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scan.png"), export::png(&painted(scan)).unwrap()).unwrap();
    folder
}

fn picture(path: &Path) -> Picture {
    scene::read_picture(&Asset::outside(path), &Limits::default()).unwrap()
}

fn figure(report: &Value, name: &str) -> f64 {
    let stage = &report["stages"][0];
    assert_eq!(stage["name"], "leaf");
    stage["figures"][name].as_f64().unwrap_or_else(|| panic!("no {name} in {stage}"))
}

#[test]
fn a_scan_becomes_key_points_mask_texture_and_preview() {
    let folder = with_scan(Scan { hole: true, ..Scan::default() });
    let truth = serde_json::json!({ "blade": outline(Scan::default()) });
    fs::write(folder.path().join("truth.json"), truth.to_string()).unwrap();
    let arguments = ["leaf", "scan.png", "--out", "made", "--truth", "truth.json", "--report", "report.json"];
    let (status, said) = code(&leafseason(folder.path(), &[&arguments[..], &["--set", "leaf.vertices=400"]].concat()));
    assert_eq!((status, said.as_str()), (0, ""));
    let report: Value = serde_json::from_slice(&fs::read(folder.path().join("report.json")).unwrap()).unwrap();
    // The truth has no gap, which covers 2 % of the blade.
    assert!(figure(&report, "iou") > 0.96, "{report}");
    assert_eq!(figure(&report, "holes"), 1.0);
    assert!((380.0..=420.0).contains(&figure(&report, "vertices")), "{report}");
    assert!(figure(&report, "outline_hausdorff_px") <= 1.0, "{report}");
    assert!(figure(&report, "petiole_mm") > 20.0, "{report}");
    let made = folder.path().join("made");
    let (mask, texture, preview) =
        (picture(&made.join("mask.png")), picture(&made.join("texture.png")), picture(&made.join("preview.png")));
    assert!(mask.pixels.iter().all(|p| p[0] == p[1] && p[1] == p[2]));
    let clear = texture.pixels.iter().filter(|p| p[3] == 0).count() as f64 / texture.pixels.len() as f64;
    assert!((0.3..0.8).contains(&clear), "background is clear: {clear}");
    assert!(texture.pixels.iter().all(|p| p[1] > p[2]), "leaf colours also where it is clear");
    assert!(preview.width > 3 * preview.height);
    let text = fs::read_to_string(made.join("leaf.toml")).unwrap();
    assert!(text.contains("outline = [") && text.contains("holes = [") && text.contains("petiole = ["));
}

#[test]
fn the_file_of_a_leaf_gives_the_same_picture_as_its_scan() {
    let folder = with_scan(Scan { hole: true, ..Scan::default() });
    let set = ["--set", "leaf.vertices=150", "--set", "leaf.length=90"];
    let (status, said) = code(&leafseason(folder.path(), &[&["leaf", "scan.png", "--out", "made"][..], &set].concat()));
    assert_eq!(status, 0, "{said}");
    let scene = |leaf: &str| {
        format!(
            "species = \"red-maple\"\nseason.start = \"yellow\"\ntime.day = 0.0\ncamera.subject = \"leaf\"\n\
             tree = {{ axiom = \"L(1)\", rules = [] }}\nimage = {{ width = 160, height = 160, samples = 4 }}\n\
             [leaf]\nvertices = 150\n{leaf}\n"
        )
    };
    fs::write(folder.path().join("scan.toml"), scene("length = 90\npicture = \"scan.png\"")).unwrap();
    fs::write(folder.path().join("file.toml"), scene("file = \"made/leaf.toml\"")).unwrap();
    for name in ["scan", "file"] {
        let (status, said) = code(&leafseason(folder.path(), &["render", &format!("{name}.toml"), "--out", "out"]));
        assert_eq!(status, 0, "{said}");
    }
    let out = folder.path().join("out");
    assert_eq!(fs::read(out.join("scan.png")).unwrap(), fs::read(out.join("file.png")).unwrap());
}

#[test]
fn any_number_of_threads_writes_the_same_files() {
    let folder = with_scan(Scan::default());
    let files = ["leaf.toml", "mask.png", "texture.png", "preview.png"];
    let made = |threads: &str| {
        let arguments = ["leaf", "scan.png", "--out", threads, "--threads", threads];
        assert_eq!(code(&leafseason(folder.path(), &arguments)).0, 0);
        files.map(|name| fs::read(folder.path().join(threads).join(name)).unwrap())
    };
    let one = made("1");
    assert!(made("2") == one && made("5") == one);
}

#[test]
fn of_several_leaves_the_largest_is_taken_and_said() {
    let folder = with_scan(Scan { second: true, ..Scan::default() });
    let (status, said) = code(&leafseason(folder.path(), &["leaf", "scan.png", "--out", "made", "--report", "r.json"]));
    assert_eq!(status, 0, "{said}");
    assert!(said.contains("warning: ") && said.contains("other leaf"), "{said}");
}

#[test]
fn what_cannot_be_traced_is_refused_and_nothing_is_written() {
    let folder = with_scan(Scan { shift: 200.0, ..Scan::default() });
    let place = folder.path();
    let white = Picture::filled(300, 300, [250, 250, 250, 255]);
    fs::write(place.join("white.png"), export::png(&white).unwrap()).unwrap();
    fs::write(place.join("text.png"), "no picture").unwrap();
    fs::write(place.join("wrong.json"), "{ \"blade\": 3 }").unwrap();
    let table: &[(&[&str], i32, &str)] = &[
        (&["scan.png"], 4, "right"),
        (&["white.png"], 4, "white.png"),
        (&["text.png"], 4, "neither PNG nor JPEG"),
        (&["absent.png"], 4, "absent.png"),
        (&["white.png", "--truth", "absent.json"], 4, "absent.json"),
        (&["white.png", "--truth", "wrong.json"], 3, "wrong.json"),
        (&["white.png", "--set", "leaf.vertices=1"], 3, "leaf.vertices=1:1:15"),
        (&["white.png", "--set", "leaf.vertizes=100"], 3, "did you mean `vertices`?"),
        (&["white.png", "--set", "tree.age=3"], 3, "`tree` is not known"),
        (&["white.png", "--limit", "picture-pixels=100"], 6, "--limit picture-pixels="),
        (&["white.png", "--out", "text.png"], 5, "text.png"),
    ];
    for (arguments, status, words) in table {
        let out = if arguments.contains(&"--out") { vec![] } else { vec!["--out", "made"] };
        let found = code(&leafseason(place, &[&["leaf"], &arguments[..], &out].concat()));
        assert_eq!(found.0, *status, "{arguments:?}: {}", found.1);
        assert!(found.1.contains(words), "{arguments:?}: {}", found.1);
        assert!(!place.join("made").exists(), "{arguments:?}");
    }
    assert_eq!(code(&leafseason(place, &["leaf", "white.png"])).0, 2);
}

#[test]
fn a_wrong_file_of_a_leaf_is_told_at_its_own_line() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    fs::create_dir(place.join("sub")).unwrap();
    fs::write(place.join("sub/leaf.toml"), "[leaf]\nlength = -4\noutline = [[0, 0], [1, \"a\"]]\nfile = \"x\"\n")
        .unwrap();
    fs::write(place.join("scene.toml"), "species = \"red-maple\"\nleaf.file = \"sub/leaf.toml\"\n").unwrap();
    let (status, said) = code(&leafseason(place, &["plan", "scene.toml"]));
    assert_eq!(status, 3, "{said}");
    for line in ["sub/leaf.toml:2:10: error: ", "sub/leaf.toml:3:24: error: ", "sub/leaf.toml:4:1: error: "] {
        assert!(said.contains(line), "{line} in {said}");
    }
    fs::write(place.join("sub/leaf.toml"), "[leaf]\nmask = \"mask.png\"\n").unwrap();
    let (status, said) = code(&leafseason(place, &["plan", "scene.toml"]));
    assert_eq!(status, 4, "{said}");
    assert!(said.contains("sub/mask.png"), "names are relative to the leaf's own folder: {said}");
    let (status, said) = code(&leafseason(place, &["plan", "scene.toml", "--set", "leaf.file=absent.toml"]));
    assert_eq!(status, 4, "{said}");
}
