//! The ground of a scene, and what grows on it.

use super::outlook::Outlook;
use super::{Stand, Stock, flowers, ground, sward, terrain, turned, tussocks, view, wood_edge};
use crate::base::mesh::Mesh;
use crate::base::vector::{Affine, DVec3};
use crate::fall::HeightMap;
use crate::frame::{Instance, Material};
use crate::scene::{Scene, ground::Cover, image::Backdrop};
use std::collections::BTreeMap;

impl Stock {
    /// Adds the ground.
    pub(super) fn add_ground(&mut self, scene: &Scene, stand: &Stand) {
        let is_grass = scene.ground.kind == Cover::Grass;
        let texture = self.push_texture(ground::texture(scene.seed, is_grass));
        let is_open = scene.image.background == Backdrop::Sky;
        let cover = if is_grass && is_open { self.add_grass(scene, stand) } else { Vec::new() };
        let mut ground = ground::ground(texture, cover, scene.light.turbidity, is_grass);
        ground.feet = ground::feet(stand);
        if let Some(map) = stand.heights.as_ref().filter(|_| is_open) {
            self.uneven(map, &mut ground);
        }
        if is_open && scene.ground.wood {
            let slots = ["wood_form", "wood_crowns"].map(|name| self.push_texture(wood_edge::placeholder(name)));
            ground.wood = Some(wood_edge::wood(slots[0], slots[1]));
            let pixel = view::field_of_view(scene) / f64::from(scene.image.height);
            self.wood_edge = Some(wood_edge::Edge::new(scene.seed, slots, pixel));
        }
        self.ground = Some(ground);
    }

    /// Gives the ground its heights.
    fn uneven(&mut self, map: &HeightMap, ground: &mut crate::frame::Ground) {
        ground.cover.iter_mut().for_each(|grass| grass.transform = terrain::laid(map, grass.transform));
        let mut reaches = BTreeMap::new();
        ground.cover.retain(|grass| {
            let reach = *reaches.entry(grass.model).or_insert_with(|| self.reach(grass.model));
            terrain::lies(map, &grass.transform, reach)
        });
        ground.is_uneven = true;
        // Both sides: an eye may be led below it.
        let matte = Material { two_sided: true, ..Material::matte("ground", [1.0; 3]) };
        let material = self.push_material(Material { reflected: Some(ground.texture), is_ground: true, ..matte });
        let model = self.push_model("ground", terrain::mesh(map, ground.tile), material);
        ground.cover.push(Instance { model, transform: Affine::identity(), leaf: None });
    }

    /// How far a model reaches along the level ground, metres.
    fn reach(&self, model: u32) -> f32 {
        let parts = self.models[model as usize].parts.iter();
        let positions = parts.flat_map(|part| &self.meshes[part.mesh as usize].positions);
        positions.map(|p| p.x.abs().max(p.z.abs())).fold(0.0, f32::max)
    }

    /// Blades of grass at the trees' feet and before the camera.
    fn add_grass(&mut self, scene: &Scene, stand: &Stand) -> Vec<Instance> {
        let palette = self.push_texture(sward::palette());
        let material =
            self.push_material(Material { reflected: Some(palette), ..Material::matte(sward::NAME, [1.0; 3]) });
        let mut model = |name: &str, mesh: Mesh| self.push_model(name, mesh, material);
        let (foot, meadow) = (model("sward", sward::mesh(scene.seed)), model("meadow", sward::meadow(scene.seed)));
        let ring = model("sward_ring", sward::ring(scene.seed));
        let tussock = model("tussock", tussocks::mesh(scene.seed));
        let camera = turned(scene, stand, 0, view::camera(scene, stand));
        let eye: DVec3 = camera.position.cast();
        let aspect = f64::from(scene.image.width) / f64::from(scene.image.height);
        let half = libm::atan(libm::tan(f64::from(camera.field_of_view) * 0.5) * aspect);
        // A camera on its way around sees all sides.
        let half = if scene.camera.turn == 0.0 { half } else { std::f64::consts::PI };
        let trees: Vec<[f64; 2]> = stand.trees.iter().map(|(_, tree)| tree.place).collect();
        let at_feet =
            sward::places(&trees).into_iter().map(|transform| Instance { model: foot, transform, leaf: None });
        let outlook = Outlook::new(eye.into(), view::axis(&camera).into(), half);
        let before = sward::meadow_places(&outlook);
        let rank = tussocks::places(scene.seed, &outlook, &trees).into_iter();
        let rank = rank.map(|transform| Instance { model: tussock, transform, leaf: None });
        let about = sward::ring_places(&ground::feet(stand)).into_iter();
        let about = about.map(|transform| Instance { model: ring, transform, leaf: None });
        let flowers = self.add_flowers(scene.seed, &before);
        let before = before.into_iter().map(|transform| Instance { model: meadow, transform, leaf: None });
        at_feet.chain(about).chain(before).chain(flowers).chain(rank).collect()
    }

    /// Flowers on some of the meadow's patches.
    fn add_flowers(&mut self, seed: u64, patches: &[Affine]) -> Vec<Instance> {
        let mut cover = Vec::new();
        for (number, kind) in (0..).zip(&flowers::KINDS) {
            let material = self.push_material(Material::matte(kind.name, kind.colour));
            let model = self.push_model(kind.name, flowers::mesh(seed, number), material);
            self.flowers.insert(model);
            let places = flowers::places(seed, number, patches).into_iter();
            cover.extend(places.map(|transform| Instance { model, transform, leaf: None }));
        }
        cover
    }
}
