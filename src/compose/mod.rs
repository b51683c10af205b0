//! Tree, leaf states, shapes and textures -> [`Frame`].
//!
//! A model is what a leaf can wear: one shape of a state in one of its textures, with a petiole. Leaves are instances of
//! models; wood is drawn as it was grown. Nothing is decided here by chance but which of its state's variants a leaf wears,
//! and that by the leaf's own key.

mod bark;
mod bark_pattern;
mod ground;
mod inset;
mod light;
mod petiole;
mod sward;

use crate::base::mesh::Mesh;
use crate::base::random::{Purpose, Stream};
use crate::base::vector::{Affine, DVec3, Mat3, Vec3};
use crate::colour::Painted;
use crate::frame::{Camera, Frame, Instance, Material, Model, Part, Texture, ToneMap, View};
use crate::scene::{Scene, ground::Cover, light::Tone};
use crate::tree::{LeafSite, Tree};
use std::collections::BTreeMap;

/// One shape of a state in one of its textures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Garment {
    /// Number of the state.
    pub state: u16,
    /// Number of the variant, of the shape and of the texture alike.
    pub variant: u32,
}

/// The shapes and textures that were made, by what wears them.
#[derive(Clone, Debug, Default)]
pub struct Wardrobe {
    /// Names of the states.
    pub states: Vec<String>,
    /// Shapes by garment; shared by garments whose shape is the same.
    pub shapes: BTreeMap<Garment, Mesh>,
    /// Textures by garment.
    pub textures: BTreeMap<Garment, Painted>,
}

/// The number of the variant that a leaf wears, of `count`.
#[must_use]
pub fn variant(seed: u64, leaf: u64, count: u32) -> u32 {
    Stream::new(seed, Purpose::Variant, leaf, 0).below(count.max(1))
}

/// What does not change between the frames of a scene.
pub struct Stock {
    meshes: Vec<Mesh>,
    textures: Vec<Texture>,
    materials: Vec<Material>,
    models: Vec<Model>,
    /// Number of the model of each garment.
    worn: BTreeMap<Garment, u32>,
    wood: u32,
    petiole_base: Vec3,
    ground: Option<crate::frame::Ground>,
}

impl Stock {
    /// Gathers wood, surroundings and wardrobe of a scene. Textures are made only when a picture or a file reads them.
    #[must_use]
    pub fn new(scene: &Scene, tree: &Tree, wardrobe: &Wardrobe) -> Self {
        let mut stock = Self {
            meshes: Vec::new(),
            textures: Vec::new(),
            materials: Vec::new(),
            models: Vec::new(),
            worn: BTreeMap::new(),
            wood: 0,
            petiole_base: Vec3::zeros(),
            ground: None,
        };
        stock.add_wood(scene, tree);
        if !wardrobe.shapes.is_empty() {
            stock.add_leaves(scene, wardrobe);
        }
        if scene.output.png && scene.ground.kind == Cover::Grass {
            stock.add_ground(scene);
        }
        stock
    }

    fn push_texture(&mut self, texture: Texture) -> u32 {
        self.textures.push(texture);
        self.textures.len() as u32 - 1
    }

    fn push_mesh(&mut self, mesh: &Mesh) -> u32 {
        self.meshes.push(mesh.clone());
        self.meshes.len() as u32 - 1
    }

    fn push_material(&mut self, material: Material) -> u32 {
        self.materials.push(material);
        self.materials.len() as u32 - 1
    }

    fn add_wood(&mut self, scene: &Scene, tree: &Tree) {
        let textures = bark::textures(&scene.tree, &tree.wood, scene.seed);
        let mut parts = Vec::new();
        for (wooden, texture) in tree.wood.iter().zip(textures) {
            let name = texture.name.clone();
            let reflected = Some(self.push_texture(texture));
            let material = self.push_material(Material { reflected, ..wood(&name, [1.0; 3]) });
            parts.push(Part { mesh: self.push_mesh(&wooden.mesh), material });
        }
        self.models.push(Model { name: "trunk".to_owned(), parts });
    }

    fn add_ground(&mut self, scene: &Scene) {
        let texture = self.push_texture(ground::texture(scene.seed));
        let palette = self.push_texture(sward::palette());
        let grass = Material { reflected: Some(palette), ..wood("sward", [1.0; 3]) };
        let part = Part { material: self.push_material(grass), mesh: self.push_mesh(&sward::mesh(scene.seed)) };
        let model = self.models.len() as u32;
        self.models.push(Model { name: "sward".to_owned(), parts: vec![part] });
        let cover = vec![Instance { model, transform: Affine::identity(), leaf: None }];
        self.ground = Some(ground::ground(texture, cover));
    }

    fn add_leaves(&mut self, scene: &Scene, wardrobe: &Wardrobe) {
        let length = scene.tree.petiole * 1e-3;
        let bend = scene.tree.petiole_angle.to_radians();
        let stalk = (length > 0.0).then(|| {
            self.petiole_base = petiole::base(length, bend);
            let mesh = self.push_mesh(&petiole::mesh(length, bend));
            let material = self.push_material(wood("petiole", scene.tree.petiole_colour.map(|c| c as f32)));
            Part { mesh, material }
        });
        for (garment, shape) in &wardrobe.shapes {
            let state = &wardrobe.states[usize::from(garment.state)];
            let name = format!("leaf_{}_{}", model_name(state, garment.state), garment.variant);
            let mesh = self.push_mesh(shape);
            let material = self.add_leaf_material(scene, &name, state, wardrobe.textures.get(garment));
            let mut parts = vec![Part { mesh, material }];
            parts.extend(stalk);
            self.worn.insert(*garment, self.models.len() as u32);
            self.models.push(Model { name, parts });
        }
    }

    fn add_leaf_material(&mut self, scene: &Scene, name: &str, state: &str, painted: Option<&Painted>) -> u32 {
        let mut textures = [None, None];
        if let Some(painted) = painted {
            for (slot, (side, pixels)) in
                textures.iter_mut().zip([("reflected", &painted.reflected), ("transmitted", &painted.transmitted)])
            {
                let (width, height) = (painted.size, painted.size);
                let name = format!("{name}_{side}");
                *slot = Some(self.push_texture(Texture { name, width, height, pixels: pixels.clone(), repeat: false }));
            }
        }
        // A dry leaf has lost its cuticle's sheen (judged, after Qiu et al. 2019 for the living one).
        let dry = scene.deform.states.get(state).is_some_and(|shape| shape.dryness > 0.8);
        self.push_material(Material {
            name: name.to_owned(),
            colour: [1.0; 3],
            reflected: textures[0],
            transmission: [1.0; 3],
            transmitted: textures[1],
            back_gain: 1.35,
            gloss: if dry { 0.02 } else { 0.034 },
            roughness: if dry { 0.8 } else { 0.5 },
            two_sided: true,
        })
    }

    /// One frame: the wood and every leaf that still hangs, in the order of the sites. `worn` gives each site's garment,
    /// `None` for a leaf that is not there.
    #[must_use]
    pub fn frame(&self, scene: &Scene, tree: &Tree, worn: &[Option<Garment>]) -> Frame {
        let camera = camera(scene, tree);
        let view_axis = (camera.target - camera.position).cast::<f64>();
        let lighting = light::lighting(&scene.light, view_axis);
        let mut instances = Vec::with_capacity(1 + worn.len());
        if !self.models[self.wood as usize].parts.is_empty() {
            instances.push(Instance { model: self.wood, transform: Affine::identity(), leaf: None });
        }
        for (site, garment) in tree.sites.iter().zip(worn) {
            if let Some(&model) = garment.as_ref().and_then(|garment| self.worn.get(garment)) {
                instances.push(Instance { model, transform: self.placed(site), leaf: Some(site.id) });
            }
        }
        Frame {
            meshes: self.meshes.clone(),
            textures: self.textures.clone(),
            materials: self.materials.clone(),
            models: self.models.clone(),
            instances,
            camera,
            sun: lighting.sun,
            sky: lighting.sky,
            ground: self.ground.clone(),
            view: view(scene, lighting.exposure),
        }
    }

    /// A leaf at its site: the blade as the site says, the petiole's foot on the twig.
    fn placed(&self, site: &LeafSite) -> Affine {
        let (blade, normal) = (site.blade, site.normal);
        let across = blade.cross(&normal);
        let rotation = nalgebra::Matrix3::from_columns(&[across, blade, normal]);
        let linear: Mat3 = (rotation * site.scale).cast::<f32>();
        Affine { linear, translation: site.base.cast::<f32>() - linear * self.petiole_base }
    }
}

/// A state's name as models may bear it; a name with other characters than the built-in ones have gives way to its number.
fn model_name(state: &str, number: u16) -> String {
    let plain = state.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-');
    if plain { state.replace('-', "_") } else { format!("state{number}") }
}

fn wood(name: &str, colour: [f32; 3]) -> Material {
    Material {
        name: name.to_owned(),
        colour,
        reflected: None,
        transmission: [0.0; 3],
        transmitted: None,
        back_gain: 1.0,
        gloss: 0.0,
        roughness: 0.95,
        two_sided: false,
    }
}

fn view(scene: &Scene, exposure: f32) -> View {
    View {
        width: scene.image.width,
        height: scene.image.height,
        samples: scene.image.samples,
        shadow_size: scene.light.shadow_size,
        exposure,
        tone_map: match scene.light.tone {
            Tone::Neutral => ToneMap::Neutral,
            Tone::None => ToneMap::None,
        },
    }
}

/// Height of the eye of a fitted camera: a standing person's, metres.
const EYE: f64 = 1.6;
/// Share of the picture that a fitted tree fills.
const FILL: f64 = 0.84;

/// The scene's camera; what it leaves open is fitted to the tree, seen from +z.
fn camera(scene: &Scene, tree: &Tree) -> Camera {
    let field_of_view = scene.camera.field_of_view.to_radians();
    let aspect = f64::from(scene.image.width) / f64::from(scene.image.height);
    let height = tree.height.max(0.2);
    let radius = tree.crown_radius.max(0.1);
    let eye = EYE.min(height * 0.6);
    let (distance, tilt) = light::fitted(height, radius, eye, field_of_view, aspect, FILL);
    let fitted_position = DVec3::new(0.0, eye, distance);
    let position = scene.camera.position.map_or(fitted_position, DVec3::from);
    let fitted_target = if scene.camera.position.is_some() {
        DVec3::new(0.0, height * 0.5, 0.0)
    } else {
        DVec3::new(0.0, eye + distance * libm::tan(tilt), 0.0)
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
