//! The house's plan as a test: which room may look into which. A stage that needs something from another gets it handed in
//! by `compose` or `run`; if this test is in the way, the thing belongs in `base` or in the caller.

use std::fs;
use std::path::{Path, PathBuf};

/// Each room with the rooms that its code may name. A room is a folder or a file of `src`.
const MAY_IMPORT: &[(&str, &[&str])] = &[
    ("base", &[]),
    ("leaf", &["base"]),
    ("deform", &["base"]),
    ("colour", &["base"]),
    ("season", &["base"]),
    ("fall", &["base"]),
    ("tree", &["base"]),
    ("frame", &["base"]),
    ("raster", &["base", "frame"]),
    ("export", &["base", "frame"]),
    ("compare", &["base"]),
    ("plot", &["base"]),
    ("species", &["base"]),
    ("scene", &["base", "species", "leaf", "deform", "colour", "season", "fall", "tree"]),
    ("compose", &["base", "frame", "scene", "tree", "colour", "fall"]),
    ("plan", &["base", "compose", "scene", "season", "fall"]),
    ("report", &["base", "plan", "fall"]),
    (
        "run",
        &[
            "base", "frame", "leaf", "deform", "colour", "season", "fall", "tree", "raster", "export", "scene",
            "compose", "plan", "report", "plot",
        ],
    ),
    // The study is on top: it measures every stage by itself, and whole runs.
    (
        "study",
        &[
            "base", "frame", "leaf", "deform", "colour", "season", "fall", "tree", "raster", "export", "scene",
            "compose", "plan", "report", "run", "plot", "compare", "species",
        ],
    ),
    ("cli", &["base", "run"]),
];

fn source_files(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a readable folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            source_files(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
}

/// The room of a source file: the first part of its path below `src`.
fn room(root: &Path, file: &Path) -> String {
    let below = file.strip_prefix(root).expect("below src");
    let first = below.components().next().expect("a component").as_os_str().to_string_lossy().into_owned();
    first.trim_end_matches(".rs").to_owned()
}

/// The rooms that a text names by `crate::ROOM`, also in grouped imports, with their lines.
fn named(text: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for (start, _) in text.match_indices("crate::") {
        let line = text[..start].matches('\n').count() + 1;
        let line_start = text[..start].rfind('\n').map_or(0, |at| at + 1);
        let before = text[line_start..start].trim_start();
        if before.starts_with("//") || text[..start].ends_with('$') {
            continue;
        }
        let rest = &text[start + "crate::".len()..];
        let name =
            |part: &str| part.trim().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
        if let Some(group) = rest.strip_prefix('{') {
            let mut depth = 0;
            let mut part = String::new();
            for c in group.chars() {
                match c {
                    '{' => depth += 1,
                    '}' if depth == 0 => break,
                    '}' => depth -= 1,
                    ',' if depth == 0 => {
                        found.push((line, name(&part)));
                        part.clear();
                        continue;
                    }
                    _ => {}
                }
                part.push(c);
            }
            found.push((line, name(&part)));
        } else {
            found.push((line, name(rest)));
        }
    }
    // The macros of `base::settings` stand at the crate's root.
    found.retain(|(_, name)| !name.is_empty() && name != "settings" && name != "choice");
    found
}

#[test]
fn rooms_name_only_the_rooms_they_may() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    source_files(&root, &mut files);
    let mut faults = Vec::new();
    for file in &files {
        let room = room(&root, file);
        if room == "lib" || room == "main" {
            continue;
        }
        let Some((_, allowed)) = MAY_IMPORT.iter().find(|(name, _)| *name == room) else {
            faults.push(format!("{}: the room `{room}` is not in the table", file.display()));
            continue;
        };
        for (line, name) in named(&fs::read_to_string(file).expect("a text")) {
            if name != room && !allowed.contains(&name.as_str()) {
                faults.push(format!("{}:{line}: `{room}` may not name `{name}`", file.display()));
            }
        }
    }
    assert!(files.len() > 30, "the source was found");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn the_reader_of_imports_sees_every_form() {
    let text = "use crate::base::x;\nuse crate::{leaf, tree::{a, b}, season as s};\n// crate::ghost\nlet y = crate::raster::draw();";
    let names: Vec<String> = named(text).into_iter().map(|(_, name)| name).collect();
    assert_eq!(names, ["base", "leaf", "tree", "season", "raster"]);
}

#[test]
fn no_file_has_grown_into_a_hall() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    source_files(&root, &mut files);
    let lines = |file: &PathBuf| fs::read_to_string(file).expect("a text").lines().count();
    let long: Vec<String> =
        files.iter().filter(|file| lines(file) > 500).map(|file| file.display().to_string()).collect();
    assert!(long.is_empty(), "over 500 lines: {}", long.join(", "));
}

/// What a run or a comparison leaves behind is easily committed with the rest; the top level is given by the project's plan.
#[test]
fn the_top_level_holds_what_the_plan_names_alone() {
    let planned = [
        "CHANGELOG.md",
        "Cargo.lock",
        "Cargo.toml",
        "LICENSE-APACHE",
        "LICENSE-MIT",
        "README.md",
        "benches",
        "build.rs",
        "clippy.toml",
        "golden",
        "out",
        "rustfmt.toml",
        "scenes",
        "src",
        "target",
        "tests",
    ];
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let stray: Vec<String> = fs::read_dir(root)
        .expect("a readable folder")
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .filter(|name| !name.starts_with('.') && !planned.contains(&name.as_str()))
        .collect();
    assert!(stray.is_empty(), "at the top level and not in the plan: {}", stray.join(", "));
}
