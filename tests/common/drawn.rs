//! The pictures of a scene that is written as a text.

use leafseason::base::limits::Limits;
use leafseason::base::picture::Picture;
use leafseason::run::{self, Options, progress, signals::Signals};
use leafseason::scene;
use std::fs;
use std::path::Path;

/// The pictures of a scene with assignments, in the order of its frames.
pub fn drawn(text: &str, sets: &[&str]) -> Vec<Picture> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.toml");
    fs::write(&path, text).expect("the scene is written");
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    let scene = scene::read(&path, &sets, &[], &Limits::default()).unwrap_or_else(|fault| panic!("{fault}")).0;
    let out = folder.path().join("out");
    let options = Options { out: out.clone(), ..Options::default() };
    let mut progress = progress::Progress::new(progress::Mode::None);
    run::render(&scene, &options, &mut progress, &Signals::default()).unwrap_or_else(|fault| panic!("{fault}"));
    let files = fs::read_dir(&out).expect("files").map(|entry| entry.expect("a file").path());
    let mut pictures: Vec<_> = files.filter(|path| path.extension().is_some_and(|end| end == "png")).collect();
    pictures.sort();
    pictures.iter().map(|path| decoded(path)).collect()
}

fn decoded(path: &Path) -> Picture {
    let image = image::open(path).unwrap_or_else(|fault| panic!("{}: {fault}", path.display())).into_rgba8();
    let (width, height) = image.dimensions();
    Picture { width, height, pixels: image.pixels().map(|pixel| pixel.0).collect() }
}
