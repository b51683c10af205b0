//! The camera of a scene, fitted to its trees where the scene leaves it open, and the picture that it takes.

use super::light::{Circle, fitted};
use super::stand::Stand;
use super::white_balance::balance;
use crate::base::maths::srgb_to_linear;
use crate::base::vector::{DVec3, rotated};
use crate::frame::{Background, Camera, ToneMap, UNBALANCED, View, Wireframe};
use crate::scene::{Scene, image::Backdrop, image::Leaves, light::Metering, light::Tone};

/// Colour of a wireframe's lines.
const LINES: [f32; 3] = [0.02, 0.03, 0.05];
/// Least height of the eye over the ground below it, over that which it has on level ground.
const LEAST_EYE: f64 = 0.75;
/// Width of a full-frame camera's picture, millimetres.
const FULL_FRAME: f64 = 36.0;

pub(super) fn view(scene: &Scene, exposure: f32) -> View {
    View {
        width: scene.image.width,
        height: scene.image.height,
        samples: scene.image.samples,
        lod_error: scene.image.lod_error as f32,
        shadow_size: scene.light.shadow_size,
        exposure,
        metered: scene.light.metering == Metering::Auto && scene.light.exposure_value.is_none(),
        balance: if scene.image.leaves == Leaves::Lit { balance(scene.light.white_balance) } else { UNBALANCED },
        tone_map: match (scene.light.tone, scene.image.leaves) {
            (Tone::Neutral, Leaves::Lit) => ToneMap::Neutral,
            (Tone::Agx, Leaves::Lit) => ToneMap::Agx,
            // charts show their colours as they are
            _ => ToneMap::None,
        },
        wireframe: (scene.image.wireframe > 0.0)
            .then_some(Wireframe { width: scene.image.wireframe as f32, colour: LINES }),
    }
}

/// What is seen where nothing stands.
pub(super) fn background(scene: &Scene) -> Background {
    match scene.image.background {
        Backdrop::Sky => Background::Sky,
        Backdrop::Plain => Background::Plain(scene.image.background_colour.map(|c| srgb_to_linear(c as f32))),
        Backdrop::Transparent => Background::Transparent,
    }
}

/// The direction in which a camera looks; not of unit length.
pub(super) fn axis(camera: &Camera) -> DVec3 {
    (camera.target - camera.position).cast()
}

/// Angle from the lower to the upper rim, radians: as set, or of a full-frame lens whose picture is 36 mm wide.
pub(super) fn field_of_view(scene: &Scene) -> f64 {
    let aspect = f64::from(scene.image.width) / f64::from(scene.image.height);
    match scene.camera.focal_length {
        Some(length) => 2.0 * libm::atan(FULL_FRAME / (2.0 * aspect * length)),
        None => scene.camera.field_of_view.to_radians(),
    }
}

/// Angle that a pixel spans, radians.
pub(super) fn pixel(scene: &Scene) -> f64 {
    field_of_view(scene) / f64::from(scene.image.height)
}

/// The camera of a frame of the scene: turned around its target as the scene says and as the frames before it make it.
#[must_use]
pub(super) fn turned(scene: &Scene, stand: &Stand, frame: i64, camera: Camera) -> Camera {
    let turn = scene.camera.orbit + scene.camera.turn * frame as f64 / scene.time.count().max(1.0);
    if turn == 0.0 {
        return camera;
    }
    let mut turned = orbited(camera, turn);
    // A fitted camera is led over uneven ground.
    if stand.heights.is_some() && scene.camera.position.is_none() {
        let place = [f64::from(turned.position.x), f64::from(turned.position.z)];
        let least = stand.ground_height(place) + LEAST_EYE * eye(scene, stand);
        turned.position.y = turned.position.y.max(least as f32);
    }
    turned
}

/// A camera moved around the vertical through its target, degrees; from above counter-clockwise.
fn orbited(camera: Camera, degrees: f64) -> Camera {
    let arm = (camera.position - camera.target).cast::<f64>();
    let arm = rotated(arm, DVec3::y(), degrees.to_radians());
    Camera { position: camera.target + arm.cast::<f32>(), ..camera }
}

/// The scene's camera before it is turned, with which the sun goes; what it leaves open is fitted to the trees, seen from +z.
pub(super) fn camera(scene: &Scene, stand: &Stand) -> Camera {
    let field_of_view = field_of_view(scene);
    let aspect = f64::from(scene.image.width) / f64::from(scene.image.height);
    let height = height(stand);
    let [x, z] = middle(stand);
    // On uneven ground the fitted camera stands as high as the trees do, but above the ground.
    let base = stand.trees.iter().map(|(_, tree)| tree.height).sum::<f64>() / stand.trees.len().max(1) as f64;
    let circle = |(form, standing): (&super::Form, &crate::scene::Standing)| Circle {
        aside: standing.place[0] - x,
        towards: standing.place[1] - z,
        radius: form.crown_radius.max(0.1),
        foot: standing.height - base,
        height: standing.height - base + form.height.max(0.2),
    };
    let circles: Vec<Circle> = stand.standing().map(circle).collect();
    let eye = eye(scene, stand);
    let (distance, tilt) = fitted(&circles, eye, field_of_view, aspect, scene.camera.fill);
    let above = (stand.ground_height([x, z + distance]) + LEAST_EYE * eye).max(base + eye);
    let position = scene.camera.position.map_or(DVec3::new(x, above, z + distance), DVec3::from);
    let fitted_target = if scene.camera.position.is_some() {
        DVec3::new(x, base + height * 0.5, z)
    } else {
        DVec3::new(x, base + eye + distance * libm::tan(tilt), z)
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

/// The height of what a fitted camera looks at, metres.
fn height(stand: &Stand) -> f64 {
    stand.height().max(0.2)
}

/// The height of a fitted camera's eye over level ground, metres: lower before saplings than the scene has it.
fn eye(scene: &Scene, stand: &Stand) -> f64 {
    scene.camera.eye_height.min(height(stand) * 0.6)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::vector::Vec3;

    #[test]
    fn a_quarter_turn_moves_the_camera_to_its_right_and_keeps_its_target_and_distance() {
        let (position, target) = (Vec3::new(1.0, 1.6, 21.0), Vec3::new(1.0, 4.0, 1.0));
        let camera = Camera { position, target, field_of_view: 0.4, near: 0.1, far: 100.0 };
        let moved = orbited(camera, 90.0);
        assert!((moved.position - Vec3::new(21.0, 1.6, 1.0)).norm() < 1e-4, "{:?}", moved.position);
        assert_eq!(moved.target, target);
        assert!((orbited(moved, 270.0).position - position).norm() < 1e-4);
    }
}
