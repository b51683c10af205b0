//! A leaf by itself in the place of the trees: upright before a plain light ground, its upper side to the camera. For
//! figures, boards and textures' checks.

use super::{Garment, Stock};
use crate::base::vector::{Affine, Vec3};
use crate::frame::{Background, Camera, Frame, Instance, Sky, Sun};
use crate::scene::Scene;
use std::f32::consts::PI;

/// Share of the picture that the leaf fills.
const FILL: f32 = 0.88;
/// Where the light comes from beside the even light of the ground: from the left above the camera.
const SUN: [f32; 3] = [-0.45, 0.62, 0.64];
/// What the even light gives a white leaf that lies flat before the camera; the sun gives the rest to 1.
const EVEN: f32 = 0.7;

impl Stock {
    /// A frame of the leaf that most leaves of `worn` look like; `None` when no leaf hangs. A flat white leaf shows white.
    #[must_use]
    pub fn specimen(&self, scene: &Scene, worn: &[Option<Garment>], frame: &Frame) -> Option<Frame> {
        let model = self.commonest(worn)?;
        let exposure = frame.view.exposure.max(1e-9);
        let direction = Vec3::from(SUN).normalize();
        let strength = |of: f64| of as f32 / exposure;
        let sun = strength(scene.light.sun) * (1.0 - EVEN) * PI / direction.z;
        let even = [strength(scene.light.sky) * EVEN; 3];
        let (meshes, textures) = self.only(model);
        Some(Frame {
            meshes,
            textures,
            materials: self.materials.clone(),
            models: self.models.clone(),
            instances: vec![Instance { model, transform: Affine::identity(), leaf: None }],
            fallen: 0,
            camera: self.before(model, scene)?,
            sun: Sun { direction, irradiance: [sun; 3] },
            sky: Sky { zenith: even, horizon: even, ..Sky::default() },
            ground: None,
            background: Background::Sky,
            view: frame.view,
        })
    }

    /// A camera before a model, far enough that all of it is in the picture; the scene's own place and target win.
    fn before(&self, model: u32, scene: &Scene) -> Option<Camera> {
        let parts = &self.models[model as usize].parts;
        let bounds = parts.iter().filter_map(|part| self.meshes[part.mesh as usize].bounds());
        let (low, high) = bounds.reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1)))?;
        let (middle, size) = ((low + high) * 0.5, high - low);
        let field_of_view = super::view::field_of_view(scene) as f32;
        let aspect = scene.image.width as f32 / scene.image.height as f32;
        let half = (size.y.max(size.x / aspect) * 0.5).max(1e-6) / FILL;
        let distance = half / libm::tanf(field_of_view * 0.5) + size.z * 0.5;
        let given = |place: [f64; 3]| Vec3::new(place[0] as f32, place[1] as f32, place[2] as f32);
        let position = scene.camera.position.map_or(middle + Vec3::z() * distance, given);
        let target = scene.camera.target.map_or(middle, given);
        let reach = (position - middle).norm() + size.norm();
        Some(Camera { position, target, field_of_view, near: reach * 1e-3, far: reach * 10.0 })
    }
}
