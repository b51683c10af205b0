//! A small scene that tests read and render in folders of their own.

use leafseason::base::limits::Limits;
use leafseason::run::progress::{Mode, Progress};
use leafseason::run::signals::Signals;
use leafseason::run::{self, Options, Outcome};
use leafseason::scene::{self, Scene};
use std::fs;

/// A maple of five years in colour, its stages made cheap.
const SMALL: &str = r#"
species = "red-maple"
seed = 11
tree = { age = 5 }
leaf = { vertices = 80 }
deform = { steps = 60 }
colour = { size = 32 }
light = { shadow_size = 256 }
image = { width = 96, height = 64, samples = 4 }
output = { gltf = "nodes" }
"#;

/// The small scene with assignments above it, as `--set` takes them.
pub fn small(sets: &[&str]) -> Scene {
    small_in("climate = { temperature = 9.0, humidity = 0.7 }", sets)
}

/// The small scene in another climate: the line of the scene that tells it.
pub fn small_in(climate: &str, sets: &[&str]) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("small.toml");
    fs::write(&path, format!("{SMALL}{climate}\n")).unwrap();
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    scene::read(&path, &sets, &[], &Limits::default()).unwrap_or_else(|fault| panic!("{sets:?}: {fault}")).0
}

/// Renders a scene without a word.
pub fn render(scene: &Scene, options: &Options) -> Outcome {
    run::render(scene, options, &mut Progress::new(Mode::None), &Signals::default()).unwrap()
}
