//! The ground of a scene, and what grows on it.

use super::outlook::Outlook;
use super::sward::{Division, Patch};
use super::{Stand, Stock, blades, flowers, ground, rings, sward, terrain, turned, tussocks, view, wood_edge};
use crate::base::mesh::Mesh;
use crate::base::vector::{Affine, DVec3};
use crate::fall::HeightMap;
use crate::frame::{Frame, GroundPart, Instance, Material};
use crate::scene::{Scene, ground::Cover, image::Backdrop};

/// A model that grows on the ground.
#[derive(Clone, Copy, Debug)]
struct Plant {
    model: u32,
    /// How far it reaches along the level ground, metres.
    reach: f32,
}

impl Plant {
    /// Where it stands on level or uneven ground, told from where it would on level ground; nowhere if it stood off that.
    fn laid(self, level: Affine, heights: Option<&HeightMap>) -> Option<Affine> {
        let Some(map) = heights else { return Some(level) };
        let laid = terrain::laid(map, level);
        terrain::lies(map, &laid, self.reach).then_some(laid)
    }

    fn at(self, transform: Affine) -> Instance {
        Instance { model: self.model, transform, leaf: None }
    }

    /// One at each of these places on level ground where it stands.
    fn all(self, places: Vec<Affine>, heights: Option<&HeightMap>) -> impl Iterator<Item = Instance> {
        places.into_iter().filter_map(move |place| Some(self.at(self.laid(place, heights)?)))
    }
}

/// What grows on the meadow before a camera.
pub(super) struct Meadow {
    division: Division,
    /// Patches of the sward by their levels.
    sward: Vec<Plant>,
    tussock: Plant,
    /// Flowers by their kinds.
    flowers: Vec<Plant>,
}

impl Stock {
    /// Adds the ground.
    pub(super) fn add_ground(&mut self, scene: &Scene, stand: &Stand) {
        let is_grass = scene.ground.kind == Cover::Grass;
        let texture = self.push_texture(ground::texture(scene.seed, is_grass));
        let is_open = scene.image.background == Backdrop::Sky;
        let mut ground = ground::ground(texture, scene.light.turbidity, is_grass);
        ground.feet = ground::feet(stand);
        let heights = stand.heights.as_deref().filter(|_| is_open);
        if is_grass && is_open {
            ground.cover = self.add_grass(scene, &ground.feet, heights);
        }
        if let Some(map) = heights {
            ground.is_uneven = true;
            // Both sides: an eye may be led below it.
            let matte = Material { two_sided: true, ..Material::matte("ground", [1.0; 3]) };
            let material =
                self.push_material(Material { reflected: Some(texture), ground: GroundPart::Surface, ..matte });
            let model = self.push_model("ground", terrain::mesh(map, ground.tile), material);
            ground.cover.push(Instance { model, transform: Affine::identity(), leaf: None });
        }
        if is_open && scene.ground.wood {
            let slots = ["wood_form", "wood_crowns", "wood_horizons"]
                .map(|name| self.push_texture(wood_edge::placeholder(name)));
            ground.wood = Some(wood_edge::wood(slots));
            self.wood_edge = Some(wood_edge::Edge::new(scene.seed, slots, view::pixel(scene)));
        }
        self.ground = Some(ground);
    }

    fn push_plant(&mut self, name: &str, mesh: Mesh, material: u32) -> Plant {
        let reach = mesh.positions.iter().map(|p| p.x.abs().max(p.z.abs())).fold(0.0, f32::max);
        Plant { model: self.push_model(name, mesh, material), reach }
    }

    /// Adds what grows on the meadow; rings of grass about the feet of trunks are laid at once.
    fn add_grass(&mut self, scene: &Scene, feet: &[[f32; 3]], heights: Option<&HeightMap>) -> Vec<Instance> {
        let palette = self.push_texture(blades::palette());
        let grass = self.push_material(blades::material(palette));
        let division = Division::new(view::pixel(scene));
        let level = |level: usize| self.push_plant(&format!("sward_{level}"), sward::mesh(scene.seed, level), grass);
        let sward = (0..division.levels).map(level).collect();
        let tussock = self.push_plant("tussock", tussocks::mesh(scene.seed), grass);
        let ring = self.push_plant("ring", rings::mesh(scene.seed), grass);
        let flowers = (0..).zip(&flowers::KINDS).map(|(number, kind)| {
            let material = self.push_material(Material::matte(kind.name, kind.colour));
            self.push_plant(kind.name, flowers::mesh(scene.seed, number), material)
        });
        let flowers = flowers.collect();
        self.meadow = Some(Meadow { division, sward, tussock, flowers });
        ring.all(rings::places(feet), heights).collect()
    }

    /// Turns the camera of a frame as the scene says and as the frames before it make it, and lays the meadow before it.
    pub fn aim(&self, scene: &Scene, stand: &Stand, index: i64, frame: &mut Frame) {
        frame.camera = turned(scene, stand, index, frame.camera);
        let (Some(meadow), Some(ground)) = (&self.meadow, &mut frame.ground) else { return };
        let (eye, aspect): (DVec3, _) =
            (frame.camera.position.cast(), f64::from(frame.view.width) / f64::from(frame.view.height));
        let half = libm::atan(libm::tan(f64::from(frame.camera.field_of_view) * 0.5) * aspect);
        let outlook = Outlook::new(eye.into(), view::axis(&frame.camera).into(), half);
        let trees: Vec<[f64; 2]> = stand.trees.iter().map(|(_, tree)| tree.place).collect();
        let heights = stand.heights.as_deref();
        let lies = |patch: &Patch| meadow.sward[patch.level].laid(patch.place, heights);
        let sward = meadow.division.patches(&outlook, lies).into_iter();
        ground.cover.extend(sward.map(|patch| meadow.sward[patch.level].at(patch.place)));
        for (number, plant) in (0..).zip(&meadow.flowers) {
            let mut places = flowers::places(scene.seed, number, &outlook);
            places.retain(|place| flowers::stand(place, ground.dormant));
            ground.cover.extend(plant.all(places, heights));
        }
        ground.cover.extend(meadow.tussock.all(tussocks::places(scene.seed, &outlook, &trees), heights));
    }
}
