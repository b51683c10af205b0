//! One leaf, enlarged: the picture in the picture of the paper's Figure 12.

use super::petiole::Petiole;
use super::{Garment, Stock};
use crate::base::mesh::Mesh;
use crate::base::vector::{Affine, Mat3, Vec3};
use crate::frame::{Background, Camera, Frame, Instance, Sky, Texture};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Side of the inset relative to the picture's height.
const SIDE: f32 = 0.3;
/// How far the blade leans back, radians.
const LEAN: f32 = 0.35;
/// Field of view of its camera, radians.
const FIELD_OF_VIEW: f32 = 0.35;

impl Stock {
    /// A frame of the leaf that most leaves of `worn` look like, seen from its upper side; `None` when no leaf hangs.
    #[must_use]
    pub fn inset(&self, worn: &[Option<Garment>], frame: &Frame) -> Option<Frame> {
        let model = self.commonest(worn)?;
        let blade = &self.meshes[self.models[model as usize].parts.first()?.mesh as usize];
        let (low, high) = blade.bounds()?;
        let middle = (low + high) * 0.5;
        let radius = (high - low).norm() * 0.5;
        // The blade's upper side (+z) leans a little back from the camera, so that curls cast shadows.
        let (sine, cosine) = libm::sincosf(LEAN);
        let lean = Mat3::new(1.0, 0.0, 0.0, 0.0, cosine, sine, 0.0, -sine, cosine);
        let transform = Affine { linear: lean, translation: Vec3::new(0.0, 1.0, 0.0) - lean * middle };
        let side = ((frame.view.height as f32 * SIDE) as u32).max(1);
        let distance = radius * 1.25 / libm::tanf(FIELD_OF_VIEW * 0.5);
        let mut view = frame.view;
        (view.width, view.height) = (side, side);
        view.shadow_size = view.shadow_size.min(1024);
        let mut sun = frame.sun;
        sun.direction = Vec3::new(-0.45, 0.62, 0.64).normalize();
        // A third of a level white surface's light comes from all sides.
        let mean = 0.2 / frame.view.exposure.max(1e-9);
        let sky = Sky { zenith: [mean; 3], horizon: [mean * 1.5; 3], ..Sky::default() };
        let (meshes, textures) = self.only(model);
        Some(Frame {
            meshes,
            textures,
            materials: self.materials.clone(),
            models: self.models.clone(),
            instances: vec![Instance { model, transform, leaf: None }],
            fallen: 0,
            camera: Camera {
                position: Vec3::new(0.0, 1.0, distance),
                target: Vec3::new(0.0, 1.0, 0.0),
                field_of_view: FIELD_OF_VIEW,
                near: distance * 0.1,
                far: distance * 10.0,
            },
            sun,
            sky,
            ground: None,
            background: Background::Sky,
            view,
        })
    }

    /// The model that most leaves of `worn` look like.
    pub(super) fn commonest(&self, worn: &[Option<Garment>]) -> Option<u32> {
        let mut counts: BTreeMap<Garment, usize> = BTreeMap::new();
        for garment in worn.iter().flatten() {
            *counts.entry(*garment).or_default() += 1;
        }
        let (&garment, _) = counts.iter().max_by_key(|(garment, count)| (**count, std::cmp::Reverse(**garment)))?;
        [Petiole::Mean, Petiole::Short, Petiole::Long].iter().find_map(|p| self.worn.get(&(garment, *p))).copied()
    }

    /// The meshes and textures with those that a model does not use as empty ones: the rasteriser prepares all it is given.
    pub(super) fn only(&self, model: u32) -> (Vec<Arc<Mesh>>, Vec<Arc<Texture>>) {
        let parts = &self.models[model as usize].parts;
        let of_material = |number: u32| {
            let material = &self.materials[number as usize];
            [material.reflected, material.transmitted, material.behind, material.relief].into_iter().flatten()
        };
        let textures: Vec<u32> = parts.iter().flat_map(|part| of_material(part.material)).collect();
        let no_mesh = Arc::new(Mesh::default());
        let (name, pixels) = (String::new(), Arc::new(vec![[0; 3]]));
        let no_texture = Arc::new(Texture { name, width: 1, height: 1, pixels, repeat: false });
        let mesh = |(number, mesh): (usize, &Arc<Mesh>)| {
            let is_used = parts.iter().any(|part| part.mesh as usize == number);
            if is_used { mesh.clone() } else { no_mesh.clone() }
        };
        let texture = |(number, texture): (usize, &Arc<Texture>)| {
            let is_used = textures.contains(&(number as u32));
            if is_used { texture.clone() } else { no_texture.clone() }
        };
        (self.meshes.iter().enumerate().map(mesh).collect(), self.textures.iter().enumerate().map(texture).collect())
    }
}
