//! How large a leaf's texture must be for the camera to find nothing missing.

use super::stand::{Pose, Stand};
use super::view;
use crate::base::maths::tan;
use crate::colour;
use crate::scene::camera::Subject;
use crate::scene::{Scene, Species};

/// Largest size of a texture of a leaf that is a picture by itself, and of leaves on trees, when none is given.
const BY_ITSELF: u32 = 1024;
const ON_TREES: u32 = colour::Settings::USUAL_SIZE;
/// Smallest size.
const LEAST: u32 = 16;
/// Share of a texture's side that the blade takes.
const BLADE: f64 = 0.94;

/// Pixels along a side of the textures of a species, a power of two: as the scene says, else so many that a texel is no
/// larger than a pixel of the nearest leaf, whether it hangs or has fallen below its place.
#[must_use]
pub fn texture_size(scene: &Scene, stand: &Stand, number: usize) -> u32 {
    let species = &scene.species[number];
    let most = largest_texture(scene, species);
    if species.colour.size.is_some() || scene.output.gltf.is_some() || scene.output.inset {
        return most;
    }
    let pixels = largest_blade(scene, stand, number);
    ((pixels / BLADE).clamp(1.0, f64::from(most)) as u32).next_power_of_two().clamp(LEAST, most)
}

/// Pixels along the blade of the leaf of a species that the camera sees largest.
#[must_use]
pub fn largest_blade(scene: &Scene, stand: &Stand, number: usize) -> f64 {
    match scene.camera.subject {
        Subject::Leaf => f64::from(scene.image.height.max(scene.image.width)),
        Subject::Trees => seen(scene, stand, number) * scene.species[number].leaf.length * 1e-3,
    }
}

/// The size that a species' textures have at most.
#[must_use]
pub fn largest_texture(scene: &Scene, species: &Species) -> u32 {
    let usual = if scene.camera.subject == Subject::Leaf { BY_ITSELF } else { ON_TREES };
    species.colour.size.unwrap_or(usual)
}

/// Pixels a metre of the blade of the leaf that the camera sees largest.
fn seen(scene: &Scene, stand: &Stand, number: usize) -> f64 {
    let camera = view::camera(scene, stand);
    let eye = camera.position.cast::<f64>();
    let pixels = f64::from(scene.image.height) * 0.5 / tan(f64::from(camera.field_of_view) * 0.5);
    let mut largest = 0.0f64;
    for (form, standing) in stand.standing().filter(|(form, _)| form.species == number) {
        let pose = Pose::of(standing);
        for site in &form.sites {
            let hanging = pose.point(site.base);
            let mut lying = hanging;
            lying.y = 0.0;
            let near = (hanging - eye).norm_squared().min((lying - eye).norm_squared());
            largest = largest.max(site.scale * pixels / near.sqrt().max(f64::from(camera.near)));
        }
    }
    largest
}
