//! The camera of a scene, fitted to its trees where the scene leaves it open, and the picture that it takes.

use super::light::{Circle, fitted};
use super::stand::Stand;
use crate::base::vector::DVec3;
use crate::frame::{Camera, ToneMap, View, Wireframe};
use crate::scene::{Scene, image::Leaves, light::Tone};

/// Height of the eye of a fitted camera: a standing person's, metres.
const EYE: f64 = 1.6;
/// Colour of a wireframe's lines.
const LINES: [f32; 3] = [0.02, 0.03, 0.05];
/// Share of the picture that fitted trees fill.
const FILL: f64 = 0.84;

pub(super) fn view(scene: &Scene, exposure: f32) -> View {
    View {
        width: scene.image.width,
        height: scene.image.height,
        samples: scene.image.samples,
        lod_error: scene.image.lod_error as f32,
        shadow_size: scene.light.shadow_size,
        exposure,
        tone_map: match (scene.light.tone, scene.image.leaves) {
            (Tone::Neutral, Leaves::Lit) => ToneMap::Neutral,
            // charts show their colours as they are
            _ => ToneMap::None,
        },
        wireframe: (scene.image.wireframe > 0.0)
            .then_some(Wireframe { width: scene.image.wireframe as f32, colour: LINES }),
    }
}

/// The scene's camera; what it leaves open is fitted to the trees, seen from +z.
pub(super) fn camera(scene: &Scene, stand: &Stand) -> Camera {
    let field_of_view = scene.camera.field_of_view.to_radians();
    let aspect = f64::from(scene.image.width) / f64::from(scene.image.height);
    let height = stand.height().max(0.2);
    let [x, z] = middle(stand);
    let circle = |(form, standing): (&super::Form, &crate::scene::Standing)| Circle {
        aside: standing.place[0] - x,
        towards: standing.place[1] - z,
        radius: form.crown_radius.max(0.1),
        height: form.height.max(0.2),
    };
    let circles: Vec<Circle> = stand.standing().map(circle).collect();
    let eye = EYE.min(height * 0.6);
    let (distance, tilt) = fitted(&circles, eye, field_of_view, aspect, FILL);
    let position = scene.camera.position.map_or(DVec3::new(x, eye, z + distance), DVec3::from);
    let fitted_target = if scene.camera.position.is_some() {
        DVec3::new(x, height * 0.5, z)
    } else {
        DVec3::new(x, eye + distance * libm::tan(tilt), z)
    };
    let target = scene.camera.target.map_or(fitted_target, DVec3::from);
    Camera {
        position: position.cast::<f32>(),
        target: target.cast::<f32>(),
        field_of_view: field_of_view as f32,
        near: scene.camera.near as f32,
        far: scene.camera.far as f32,
    }
}

/// The middle of the box of ground that the crowns cover: x and z.
fn middle(stand: &Stand) -> [f64; 2] {
    let middle = |k: usize| {
        let reach = |side: f64| stand.standing().map(move |(form, tree)| tree.place[k] + side * form.crown_radius);
        let (low, high) = (reach(-1.0).fold(f64::INFINITY, f64::min), reach(1.0).fold(f64::NEG_INFINITY, f64::max));
        // A tree by itself stands in the middle, whatever the sum rounds to.
        if stand.trees.len() == 1 { stand.trees[0].1.place[k] } else { 0.5 * (low + high) }
    };
    [middle(0), middle(1)]
}
