//! The command as a farm meets it: exit codes, messages on one stream, results on the other, and nothing left behind.

use std::ffi::OsStr;
use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

const SCENE: &str = "species = \"red-maple\"\n[tree]\nage = 3\n[leaf]\nvertices = 30\n[deform]\nsteps = 5\nshapes = 1\n\
                     [colour]\nvariants = 1\nsize = 16\n[image]\nwidth = 24\nheight = 16\nsamples = 1\n";
const FILM: &str = "[time]\nfrom = 0\nto = 2\n";

fn folder(text: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("scene.toml"), text).unwrap();
    folder
}

fn command(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_leafseason"));
    command.current_dir(folder).stdin(Stdio::null());
    command
}

fn run<S: AsRef<OsStr>>(folder: &Path, arguments: &[S]) -> Output {
    command(folder).args(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

/// Asserts exit code and a part of what stderr says, that nothing was printed as a result, and that nothing was written.
fn refuse<S: AsRef<OsStr>>(folder: &Path, arguments: &[S], code: i32, says: &str) {
    let count = || fs::read_dir(folder).unwrap().count();
    let before = count();
    let output = run(folder, arguments);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{message}");
    assert!(message.contains(says) && !message.contains('\u{1b}'), "{message}");
    assert!(output.stdout.is_empty());
    assert_eq!(count(), before, "{message}");
}

#[test]
fn a_scene_that_is_no_plain_file_is_refused_and_never_waited_for() {
    let folder = folder(SCENE);
    fs::create_dir(folder.path().join("folder.toml")).unwrap();
    refuse(folder.path(), &["render", "folder.toml"], 3, "folder.toml:1:1: error: cannot read this file");
    refuse(folder.path(), &["render", "none.toml"], 3, "none.toml:1:1: error: cannot read this file");
    if cfg!(unix) {
        let made = Command::new("mkfifo").arg(folder.path().join("pipe.toml")).status();
        if made.is_ok_and(|status| status.success()) {
            refuse(folder.path(), &["render", "pipe.toml"], 3, "it is a folder, pipe or device");
            refuse(folder.path(), &["compare", "pipe.toml", "pipe.toml"], 4, "is a folder, pipe or device");
        }
        refuse(folder.path(), &["plan", "/dev/zero"], 3, "it is a folder, pipe or device");
    }
}

#[test]
fn wrong_arguments_are_told_without_their_control_characters() {
    let folder = folder(SCENE);
    let refuse = |arguments: &[&str], says: &str| refuse(folder.path(), arguments, 2, says);
    refuse(&["render", "scene.toml", "--frames=x\nopenjd_env: A=B\u{1b}[2J"], "x\\nopenjd_env: A=B\\u{1b}[2J");
    refuse(&["render", "scene.toml", "--shard", "5/3"], "not a shard");
    refuse(&["render", "scene.toml", "--threads", "0"], "--threads");
    refuse(&["render", "scene.toml", "--set", "nonsense"], "KEY=VALUE");
    refuse(&["render", "scene.toml", "--frames", "1"], "the scene has frames 0 to 0");
    refuse(&["nonsense"], "nonsense");
    refuse(&["render", "-scene.toml"], "error");
}

#[cfg(unix)]
#[test]
fn arguments_that_are_not_utf_8_are_a_fault_of_usage_and_paths_that_are_not_are_taken() {
    use std::os::unix::ffi::OsStrExt;
    let folder = folder(SCENE);
    let odd = OsStr::from_bytes(b"\xff.toml");
    refuse(folder.path(), &[OsStr::new("plan"), OsStr::new("scene.toml"), OsStr::new("--set"), odd], 2, "error");
    if fs::write(folder.path().join(odd), SCENE).is_ok() {
        assert!(run(folder.path(), &[OsStr::new("plan"), odd]).status.success());
    }
}

#[test]
fn places_that_cannot_be_written_are_told_before_the_work() {
    let folder = folder(SCENE);
    let refuse = |arguments: &[&str], says: &str| {
        refuse(folder.path(), &[&["render", "scene.toml"], arguments].concat(), 5, says);
    };
    refuse(&["--report", "none/report.json"], "its folder is not there");
    refuse(&["--states", "none/states.csv"], "its folder is not there");
    refuse(&["--out", "scene.toml"], "is not a folder");
    refuse(&["--out", "scene.toml/below"], "is not a folder");
    let long = format!("{}.toml", "a".repeat(245));
    fs::write(folder.path().join(&long), SCENE).unwrap();
    self::refuse(folder.path(), &["render", &long], 5, "shorter name");
}

#[test]
fn limits_refuse_with_the_flag_that_raises_them() {
    let folder = folder(SCENE);
    let refuse = |arguments: &[&str], says: &str| {
        refuse(folder.path(), &[&["plan", "scene.toml"], arguments].concat(), 6, says);
    };
    refuse(&["--set", "image.width=100000", "--set", "image.height=100000"], "--limit pixels=10000000000");
    refuse(&["--set", "image.width=16384", "--set", "image.height=16000"], "--memory-limit");
    refuse(&["--memory-limit", "100M"], "bytes of memory, the limit is 100000000");
    refuse(&["--set", "time.from=0", "--set", "time.to=1e6", "--set", "time.step=1e-3"], "--limit frames=1000000001");
    let bomb = ["--set", "tree.rules=[\"F -> FFF\"]", "--set", "tree.axiom=F", "--set", "tree.iterations=50"];
    refuse(&bomb, "tree.rules needs 717897987691852");
    // 2^22 pieces of wood would be a few gigabytes, although the string is short enough
    let wood = [
        "--set",
        "tree.rules=[\"F(l) -> F(l)+F(l)\"]",
        "--set",
        "tree.axiom=\"F(0.01)\"",
        "--set",
        "tree.iterations=22",
    ];
    refuse(&[&wood[..], &["--memory-limit", "1G"]].concat(), "bytes of memory, the limit is 1000000000");
}

#[test]
fn names_of_states_and_files_reach_the_terminal_escaped() {
    let state =
        "[season]\nstart = \"a\\u001b[2J\\nopenjd_env: X=Y\"\n[season.states.\"a\\u001b[2J\\nopenjd_env: X=Y\"]\n";
    let folder = folder(&format!("{SCENE}{state}"));
    let safe = |bytes: &[u8]| {
        let text = text(bytes);
        assert!(text.contains("openjd_env: X=Y") && !text.contains('\u{1b}'), "{text}");
        assert!(text.lines().all(|line| !line.starts_with("openjd_env")), "{text}");
    };
    safe(&run(folder.path(), &["plan", "scene.toml"]).stdout);
    let name = "b\u{1b}\nopenjd_env: X=Y.manifest.json";
    if fs::write(folder.path().join(name), "").is_ok() {
        safe(&run(folder.path(), &["verify", "."]).stdout);
    }
}

#[test]
fn a_wrong_species_is_all_that_is_said_of_it() {
    let folder = folder("species = \"red-mapel\"\n[season.states.green]\nhalf_life = 1\nnext = [\"late-green\"]\n");
    let output = run(folder.path(), &["plan", "scene.toml"]);
    assert_eq!(output.status.code(), Some(3));
    let message = text(&output.stderr);
    assert!(message.starts_with("scene.toml:1:11: error: there is no built-in species \"red-mapel\""), "{message}");
    assert_eq!(message.matches("error").count(), 1, "{message}");
}

#[test]
fn a_film_is_drawn_compared_verified_and_a_missing_frame_noticed() {
    let folder = folder(&format!("{SCENE}{FILM}"));
    let run = |arguments: &[&str]| run(folder.path(), arguments);
    let output = run(&["render", "scene.toml", "--frames", "2,0-1", "--progress", "json", "--report", "report.json"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let lines: Vec<serde_json::Value> =
        text(&output.stdout).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines.last().unwrap()["done"], 3);
    let report: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.path().join("report.json")).unwrap()).unwrap();
    assert_eq!(report["frames"].as_array().unwrap().len(), 3);
    assert_eq!(run(&["verify", "out"]).status.code(), Some(0));
    let (a, b) = ("out/scene.0000.png", "out/scene.0002.png");
    assert_eq!(run(&["compare", a, a]).status.code(), Some(0));
    assert_eq!(run(&["compare", a, b, "--json"]).status.code(), Some(1));
    assert_eq!(run(&["compare", a, "out/none.png"]).status.code(), Some(4));
    assert!(run(&["render", "scene.toml", "--set", "image.width=25", "--out", "wide"]).status.success());
    assert_eq!(run(&["compare", a, "wide/scene.0000.png"]).status.code(), Some(1));
    fs::remove_file(folder.path().join("out/scene.0001.manifest.json")).unwrap();
    let output = run(&["verify", "out"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stdout).contains("frame 1 is missing"));
}

#[test]
fn a_starter_scene_plans_and_its_plan_is_json() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| run(folder.path(), arguments);
    assert!(run(&["new", "one two"]).status.success());
    assert_eq!(run(&["new", "one two"]).status.code(), Some(5));
    assert_eq!(run(&["new", "other", "--species", "none"]).status.code(), Some(2));
    let output = run(&["plan", "one two/scene.toml", "--json", "--set", "tree.age=3"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let plan: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(plan["jobs"].as_array().is_some_and(|jobs| !jobs.is_empty()));
    for command in ["species", "schema"] {
        assert!(!run(&[command]).stdout.is_empty());
    }
}

#[cfg(target_os = "linux")]
#[test]
fn closed_streams_are_no_fault_and_full_ones_are_told() {
    let folder = folder(SCENE);
    let full = || Stdio::from(fs::OpenOptions::new().write(true).open("/dev/full").unwrap());
    for (arguments, told) in [
        (&["schema"][..], 5),
        (&["--help"], 5),
        (&["plan", "scene.toml"], 5),
        (&["render", "scene.toml", "--progress", "json"], 0),
    ] {
        let status = command(folder.path()).args(arguments).stdout(full()).stderr(full()).status().unwrap();
        assert_eq!(status.code(), Some(told), "{arguments:?}");
        let line = format!("exec \"$0\" {} >&- 2>&-", arguments.join(" "));
        let mut shell = Command::new("sh");
        shell.args(["-c", &line, env!("CARGO_BIN_EXE_leafseason")]).current_dir(folder.path());
        assert_eq!(shell.status().unwrap().code(), Some(0), "{arguments:?}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn in_little_address_space_it_works_or_is_refused() {
    let folder = folder(SCENE);
    for (kibibytes, arguments) in [(150_000, ""), (600_000, "--set image.width=6000 --set image.height=6000")] {
        let line = format!("ulimit -v {kibibytes}; exec \"$0\" render scene.toml --threads 1 {arguments}");
        let mut shell = Command::new("sh");
        let output =
            shell.args(["-c", &line, env!("CARGO_BIN_EXE_leafseason")]).current_dir(folder.path()).output().unwrap();
        assert_eq!(output.status.code(), Some(6), "{}", text(&output.stderr));
        assert!(text(&output.stderr).contains("memory"));
    }
}
