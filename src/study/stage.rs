//! The scenes of studies: small ones of our own as texts, written beside the results so that they can be drawn again.

use super::desk::{Desk, bug};
use crate::base::diagnostic::Diagnostics;
use crate::base::limits::Limits;
use crate::scene::{self, Scene};
use std::path::PathBuf;

/// One leaf by itself, from nearby.
pub const LEAF: &str = r#"species = "red-maple"
seed = 3
season = { start = "yellow" }
time = { day = 0.0 }
tree = { axiom = "L(1)", rules = [], petiole = 30.0 }
colour = { size = 512, variants = 1 }
camera = { subject = "leaf" }
light = { shadow_size = 1024 }
image = { width = 128, height = 128, samples = 8 }
output = { inset = false }
"#;

/// A young maple in colour.
pub const TREE: &str = r#"species = "red-maple"
seed = 3
climate = { temperature = 6.0, humidity = 0.7 }
time = { day = 7.0 }
tree = { age = 9 }
light = { shadow_size = 1024 }
image = { width = 160, height = 120, samples = 8 }
output = { inset = false }
"#;

/// A birch before the sky without ground, in summer.
pub const BIRCH: &str = r#"species = "silver-birch"
seed = 5
climate = { temperature = 18.0, humidity = 0.7 }
time = { day = 1.0 }
tree = { age = 10 }
ground = { kind = "none" }
light = { shadow_size = 1024 }
image = { width = 120, height = 160, samples = 8 }
output = { inset = false }
"#;

/// A twig of an oak, from nearby.
pub const TWIG: &str = r#"species = "english-oak"
seed = 4
climate = { temperature = 8.0, humidity = 0.6 }
time = { day = 10.0 }
tree = { age = 3 }
ground = { kind = "none" }
light = { shadow_size = 1024 }
image = { width = 160, height = 120, samples = 8 }
output = { inset = false }
"#;

/// A bare maple.
pub const WINTER: &str = r#"species = "red-maple"
seed = 3
climate = { temperature = 3.0, humidity = 0.7 }
time = { day = 400.0 }
tree = { age = 9 }
light = { shadow_size = 1024 }
image = { width = 160, height = 120, samples = 8 }
output = { inset = false }
"#;

/// A maple in colour whose leaves fall, with every output: what variants leave things out of.
pub const AUTUMN: &str = r#"species = "red-maple"
seed = 3
climate = { temperature = 4.0, humidity = 0.7 }
time = { day = 8.0 }
tree = { age = 10 }
light = { sun_elevation = 34.0, sun_azimuth = 55.0 }
image = { width = 320, height = 180, samples = 8 }
output = { png = true, gltf = "nodes", inset = true }
"#;

/// Writes a scene beside the results and reads it with these assignments.
///
/// # Errors
/// When it cannot be written or, which is a bug, not be read.
pub fn staged(desk: &Desk<'_>, name: &str, text: &str, sets: &[&str]) -> Result<(Scene, PathBuf), Diagnostics> {
    let file = format!("scenes/{name}.toml");
    desk.write(&file, text.as_bytes())?;
    let path = desk.request.out.join(file);
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    let read = scene::read(&path, &sets, &[], &Limits::default()).map_err(|faults| bug(&faults.to_string()))?;
    Ok((read.0, path))
}
