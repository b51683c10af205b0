//! Contact sheets of variations: cells are the scene with keys laid over it, each drawn as it would be by itself.

mod common;

use common::{render, small};
use leafseason::base::diagnostic::Diagnostics;
use leafseason::base::limits::Limits;
use leafseason::base::picture::Picture;
use leafseason::compose::contact_sheet::Sheet;
use leafseason::run::Options;
use leafseason::scene::{self, Asset, Scene};
use std::fs;

fn drawn(scene: &Scene) -> Picture {
    let folder = tempfile::tempdir().unwrap();
    render(scene, &Options { out: folder.path().to_owned(), ..Options::default() });
    scene::read_picture(&Asset::outside(&folder.path().join("small.png")), &Limits::default()).unwrap()
}

#[test]
fn a_cell_is_the_scene_with_its_keys_drawn_by_itself() {
    let cells = [["time.day=2", "seed=11"], ["time.day=18", "seed=4"], ["leaf.vertices=40", "time.day=2"]];
    let sheet = small(&["cells=[{time.day=2}, {time.day=18, seed=4}, {leaf.vertices=40, time.day=2}]"]);
    assert_eq!(sheet.cell_count(), 3);
    let picture = drawn(&sheet);
    let places = Sheet::new(sheet.image.width, sheet.image.height, 3);
    for (number, sets) in cells.iter().enumerate() {
        let [left, top, width, height] = places.cell(number);
        let size = [format!("image.width={width}"), format!("image.height={height}"), "output={}".to_owned()];
        let sets: Vec<&str> = sets.iter().copied().chain(size.iter().map(String::as_str)).collect();
        let alone = drawn(&small(&sets));
        for y in 0..height {
            for x in 0..width {
                assert_eq!(picture.at(left + x, top + y), alone.at(x, y), "cell {number} at {x}, {y}");
            }
        }
    }
}

#[test]
fn cells_share_frames_with_the_sheet_and_may_stand_still() {
    let film = small(&["time={from=0, to=3}", "cells=[{}, {time.day=9}]"]);
    assert_eq!(film.time.count(), 4.0);
    assert_eq!((film.cells[0].time.at(2), film.cells[1].time.at(2)), (2.0, 9.0));
}

fn refused(text: &str) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    fs::write(&path, text).unwrap();
    let Diagnostics(found) = scene::read(&path, &[], &[], &Limits::default()).unwrap_err();
    let line = |one: &leafseason::base::diagnostic::Diagnostic| {
        let text = leafseason::base::message::render(one);
        text.lines().next().unwrap().rsplit_once("scene.toml:").unwrap().1.to_owned()
    };
    found.iter().map(line).collect()
}

#[test]
fn faults_of_cells_are_told_where_they_stand() {
    let found = refused(
        "species = \"red-maple\"\n[[cells]]\nclimate.humidity = 3.0\n[[cells]]\ncamera = { near = 5.0, far = 2.0 }\nfoo = 1\n",
    );
    assert_eq!(found.len(), 3, "{found:#?}");
    assert!(found[0].starts_with("3:20: error: `cells.0.climate.humidity` is 3"), "{found:#?}");
    assert!(found[1].starts_with("5:30: error: the camera's `far`"), "{found:#?}");
    assert!(found[2].starts_with("6:1: error: `foo` is not known"), "{found:#?}");
    let found =
        refused("species = \"red-maple\"\n[[cells]]\nimage.samples = 5\n[[cells]]\nimage.samples = 7\nseeds = [1]\n");
    let begins = ["3:17: error: 5 samples", "5:17: error: 7 samples", "6:1: error: `seeds` is not known"];
    assert!(
        found.len() == 3 && begins.iter().all(|begin| found.iter().any(|line| line.starts_with(begin))),
        "{found:#?}"
    );
    let found = refused("species = \"red-maple\"\nleaf.file = \"absent.toml\"\n[[cells]]\n[[cells]]\n");
    assert_eq!(found.len(), 1, "{found:#?}");
    let found = refused("species = \"red-maple\"\nseeds = [1, 2]\n[[cells]]\nseed = 3\n");
    assert!(found[0].contains("a sheet of `seeds` has no [[cells]]"), "{found:#?}");
    let found = refused("species = \"red-maple\"\ntime = { from = 0, to = 3 }\n[[cells]]\ntime.to = 5\n");
    assert!(found[0].starts_with("4:1: error: ") && found[0].contains("has 6 frames, the sheet has 4"), "{found:#?}");
}
