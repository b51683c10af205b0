//! Trees, leaf states, shapes and textures -> [`Frame`].
//!
//! A model is what a leaf can wear: one shape of a state in one of its textures, with a petiole. Leaves are instances of
//! models, and trees are instances of the forms that were grown. Nothing is decided here by chance but which of its state's
//! variants a leaf wears, and that by the leaf's own key.

mod bark;
mod bark_pattern;
mod blades;
mod clouds;
pub mod contact_sheet;
mod daylight;
mod distant_tree;
mod falls;
mod flowers;
mod foliage_relief;
mod ground;
mod hosek_wilkie;
mod inset;
mod leaf_area;
mod light;
mod litter;
mod meadow;
mod outlook;
mod petiole;
pub mod picture_inset;
mod rings;
mod specimen;
mod stand;
mod sun_position;
mod sward;
mod terrain;
mod texture_size;
mod tussocks;
mod upright;
mod view;
mod white_balance;
mod wood_canvas;
mod wood_edge;
mod wood_horizons;

pub use falls::{Dropped, Fall, Falls, Look, Ways};
pub use leaf_area::blade_area;
pub use litter::BROWN;
pub use stand::{Form, LeafRun, Stand};
pub use texture_size::{largest_blade, largest_texture, texture_size};
use view::turned;

use crate::base::mesh::Mesh;
use crate::base::random::{Purpose, Stream};
use crate::base::vector::{Affine, Mat3, Vec3};
use crate::colour::Painted;
use crate::fall::{Litter, Shape, Stalk};
use crate::frame::{Frame, GroundPart, Instance, Material, Model, Part, Texture};
use crate::scene::{Scene, Species, camera::Subject, ground::Cover, image::Backdrop, image::Leaves};
use crate::tree::LeafSite;
use litter::{Lying, Stalks};
use petiole::Petiole;
use rayon::prelude::*;
use stand::Pose;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex};

/// One shape of a state in one of its textures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Garment {
    /// Number of the species.
    pub species: u16,
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
    /// Whether a leaf hangs on a tree.
    pub is_worn: bool,
    /// Shapes by garment; shared by garments whose shape is the same.
    pub shapes: BTreeMap<Garment, Arc<Mesh>>,
    /// Textures by garment; shared by garments whose texture is the same.
    pub textures: BTreeMap<Garment, Arc<Painted>>,
    /// What fallen leaves look like.
    pub fallen: BTreeSet<(Garment, Look)>,
    /// Garments of which only the shape is worn, by fallen leaves that have turned brown.
    pub bare: BTreeSet<Garment>,
}

/// The number of the variant that a leaf wears, of `count`.
#[must_use]
pub fn variant(seed: u64, leaf: u64, count: u32) -> u32 {
    Stream::new(seed, Purpose::Variant, leaf, 0).below(count.max(1))
}

/// What does not change between the frames of a scene.
#[derive(Default)]
pub struct Stock {
    meshes: Vec<Arc<Mesh>>,
    textures: Vec<Arc<Texture>>,
    materials: Vec<Material>,
    models: Vec<Model>,
    /// Number of the model of each garment and length of the petiole.
    worn: BTreeMap<(Garment, Petiole), u32>,
    /// Number of the model of each form's wood.
    wood: Vec<u32>,
    /// Where the petiole of each species and length leaves its twig, in the leaf's coordinates.
    petiole_bases: BTreeMap<(usize, Petiole), Vec3>,
    /// Mesh and material of each garment.
    blades: BTreeMap<Garment, u32>,
    painted: BTreeMap<Garment, u32>,
    /// Models of fallen leaves, with their shapes and what their petioles do.
    lying: BTreeMap<(Garment, Petiole, Look), Lying>,
    resting: Vec<(Arc<Mesh>, Stalk, Shape)>,
    /// The litter of the frame before.
    litter: Mutex<Litter>,
    /// Meshes of flattened blades and, by length, of lying petioles.
    flat: BTreeMap<Garment, u32>,
    lying_stalks: BTreeMap<u64, u32>,
    ground: Option<crate::frame::Ground>,
    /// The wood on the horizon.
    wood_edge: Option<wood_edge::Edge>,
    /// What grows on it before a camera.
    meadow: Option<meadow::Meadow>,
    /// Whether leaves of each state are green.
    green: Vec<bool>,
    /// Number of the texture of clouds.
    clouds: Option<u32>,
    /// Reliefs that textures were made of, and their numbers.
    reliefs: Vec<(Arc<Vec<[u8; 3]>>, u32)>,
}

impl Stock {
    /// Gathers wood, surroundings and wardrobe of a scene. Textures are made only when a picture or a file reads them.
    #[must_use]
    pub fn new(scene: &Scene, stand: &Stand, wardrobe: &Wardrobe) -> Self {
        let tags = tags(&scene.species);
        let green = wardrobe.states.iter().map(|state| ground::GREEN.contains(&state.as_str())).collect();
        let mut stock = Self { green, ..Self::default() };
        stock.add_wood(scene, stand, &tags);
        for (number, tag) in tags.iter().enumerate() {
            stock.add_leaves(scene, stand, (number, tag), wardrobe);
        }
        // The one picture of a leaf by itself shows no ground; where no leaf hangs it is a picture of trees after all.
        let is_alone = scene.camera.subject == Subject::Leaf && scene.time.is_single() && wardrobe.is_worn;
        if scene.output.png && scene.ground.kind != Cover::None && !is_alone {
            stock.add_ground(scene, stand);
        }
        if scene.output.png && !is_alone && scene.light.clouds > 0.0 && scene.image.background == Backdrop::Sky {
            let sun = light::lighting(&scene.light, view::axis(&view::camera(scene, stand)), None).sun.direction;
            stock.clouds = Some(stock.push_texture(clouds::texture(scene.seed, [sun.x.into(), sun.z.into()])));
        }
        stock
    }

    fn push_texture(&mut self, texture: Texture) -> u32 {
        self.textures.push(Arc::new(texture));
        self.textures.len() as u32 - 1
    }

    fn push_mesh(&mut self, mesh: Arc<Mesh>) -> u32 {
        self.meshes.push(mesh);
        self.meshes.len() as u32 - 1
    }

    fn push_material(&mut self, material: Material) -> u32 {
        self.materials.push(material);
        self.materials.len() as u32 - 1
    }

    /// The wood of every form; the forms of a species share its barks.
    fn add_wood(&mut self, scene: &Scene, stand: &Stand, tags: &[String]) {
        let mut barks: BTreeMap<(usize, usize), u32> = BTreeMap::new();
        for (number, form) in stand.forms.iter().enumerate() {
            let (settings, tag) = (&scene.species[form.species].tree, &tags[form.species]);
            let mut parts = Vec::new();
            for of_class in &form.wood {
                let material = *barks.entry((form.species, of_class.class)).or_insert_with(|| {
                    let texture = bark::texture(settings, of_class, scene.seed);
                    let name = format!("{tag}{}", texture.name);
                    let texture = Texture { name: name.clone(), ..texture };
                    let relief = bark::relief(settings, of_class, &texture).map(|relief| self.push_texture(relief));
                    let reflected = Some(self.push_texture(texture));
                    self.push_material(Material { reflected, relief, ..Material::matte(&name, [1.0; 3]) })
                });
                parts.push(Part { mesh: self.push_mesh(of_class.mesh.clone()), material });
            }
            let name = if stand.forms.len() == 1 { "trunk".to_owned() } else { format!("{tag}trunk_{number}") };
            self.wood.push(self.models.len() as u32);
            self.models.push(Model { name, parts });
        }
    }

    /// A model of one mesh in one material.
    fn push_model(&mut self, name: &str, mesh: Mesh, material: u32) -> u32 {
        let part = Part { material, mesh: self.push_mesh(Arc::new(mesh)) };
        self.models.push(Model { name: name.to_owned(), parts: vec![part] });
        self.models.len() as u32 - 1
    }

    /// The models that leaves of a species wear.
    fn add_leaves(&mut self, scene: &Scene, stand: &Stand, (number, tag): (usize, &str), wardrobe: &Wardrobe) {
        let species = &scene.species[number];
        let mut shapes =
            wardrobe.shapes.iter().filter(|(garment, _)| usize::from(garment.species) == number).peekable();
        if shapes.peek().is_none() {
            return;
        }
        let of_species = stand.forms.iter().filter(|form| form.species == number);
        let petioles: BTreeSet<Petiole> = of_species.flat_map(|form| form.sites.iter().map(Petiole::of)).collect();
        let length = species.tree.petiole * 1e-3;
        let bend = species.tree.petiole_angle.to_radians();
        let material = (length > 0.0).then(|| {
            let colour = species.tree.petiole_colour.map(|c| c as f32);
            self.push_material(Material::matte(&format!("{tag}petiole"), colour))
        });
        let stalks: Vec<(Petiole, Option<Part>)> = petioles
            .iter()
            .map(|&petiole| {
                let length = length * petiole.length();
                self.petiole_bases.insert((number, petiole), petiole::base(length, bend));
                let part = material.map(|material| {
                    let mesh = self.push_mesh(Arc::new(petiole::mesh(length, bend, species.leaf.vertices)));
                    Part { mesh, material }
                });
                (petiole, part)
            })
            .collect();
        for (garment, shape) in shapes {
            let name = leaf_name(tag, wardrobe, *garment);
            let mesh = self.push_mesh(shape.clone());
            self.blades.insert(*garment, mesh);
            if wardrobe.bare.contains(garment) {
                continue;
            }
            let material = self.leaf_material(scene, (number, tag), wardrobe, *garment);
            for &(petiole, stalk) in &stalks {
                let mut parts = vec![Part { mesh, material }];
                parts.extend(stalk);
                self.worn.insert((*garment, petiole), self.models.len() as u32);
                self.models.push(Model { name: format!("{name}{}", petiole.suffix()), parts });
            }
        }
        let petioles: Vec<Petiole> = petioles.into_iter().collect();
        self.add_fallen(scene, (number, tag), wardrobe, Stalks { length, bend, material }, &petioles);
    }

    /// The material of a garment, made once.
    fn leaf_material(
        &mut self,
        scene: &Scene,
        (number, tag): (usize, &str),
        wardrobe: &Wardrobe,
        garment: Garment,
    ) -> u32 {
        if let Some(&known) = self.painted.get(&garment) {
            return known;
        }
        let name = leaf_name(tag, wardrobe, garment);
        let painted = wardrobe.textures.get(&garment).map(Arc::as_ref);
        let state = &wardrobe.states[usize::from(garment.state)];
        let material = match scene.image.leaves {
            Leaves::Lit => self.add_leaf_material(&scene.species[number], (tag, &name), state, painted),
            _ => self.add_chart_material(&name, painted),
        };
        self.painted.insert(garment, material);
        material
    }

    fn add_leaf_material(
        &mut self,
        species: &Species,
        (tag, name): (&str, &str),
        state: &str,
        painted: Option<&Painted>,
    ) -> u32 {
        let mut textures = [None; 4];
        if let Some(painted) = painted {
            let (has_lower, none) = (species.colour.painting.lower_side, Arc::default());
            let maps = [
                ("reflected", &painted.reflected),
                ("transmitted", &painted.transmitted),
                ("below", if has_lower { &painted.below } else { &none }),
                ("relief", &painted.relief),
            ];
            for (slot, (side, pixels)) in textures.iter_mut().zip(maps).filter(|(_, (_, pixels))| !pixels.is_empty()) {
                // One relief serves all leaves of a species: it is not named after one of them.
                let of = if side == "relief" { format!("leaf_{tag}relief") } else { format!("{name}_{side}") };
                *slot = Some(self.leaf_texture(&of, side, painted, pixels));
            }
        }
        // A dry leaf has lost its cuticle's sheen (judged, after Qiu et al. 2019 for the living one).
        let dry = species.deform.states.get(state).is_some_and(|shape| shape.dryness > 0.8);
        self.push_material(Material {
            name: name.to_owned(),
            colour: [1.0; 3],
            reflected: textures[0],
            transmission: [1.0; 3],
            transmitted: textures[1],
            // Without a texture of its own the lower side is as much paler as measured ones are.
            back_gain: if textures[2].is_some() || !species.colour.painting.lower_side { 1.0 } else { 1.35 },
            behind: textures[2],
            relief: textures[3],
            gloss: if !species.colour.gloss {
                0.0
            } else if dry {
                0.02
            } else {
                0.034
            },
            roughness: if dry { 0.8 } else { 0.5 },
            two_sided: true,
            unlit: false,
            ground: GroundPart::None,
        })
    }

    /// The texture of one map of a painted leaf; the relief is one for all leaves of a blade.
    fn leaf_texture(&mut self, name: &str, side: &str, painted: &Painted, pixels: &Arc<Vec<[u8; 3]>>) -> u32 {
        if side == "relief" {
            if let Some((_, number)) = self.reliefs.iter().find(|(known, _)| Arc::ptr_eq(known, &painted.relief)) {
                return *number;
            }
            let number = self.textures.len() as u32;
            self.reliefs.push((painted.relief.clone(), number));
        }
        let (width, height) = (painted.size, painted.size);
        self.push_texture(Texture { name: name.to_owned(), width, height, pixels: pixels.clone(), repeat: false })
    }

    /// A chart's colours as they are, white without one.
    fn add_chart_material(&mut self, name: &str, chart: Option<&Painted>) -> u32 {
        let reflected = chart.map(|chart| {
            let (width, height, pixels) = (chart.size, chart.size, chart.reflected.clone());
            self.push_texture(Texture { name: format!("{name}_chart"), width, height, pixels, repeat: false })
        });
        self.push_material(Material { reflected, unlit: true, two_sided: true, ..Material::matte(name, [1.0; 3]) })
    }

    /// One frame: the wood and every leaf that still hangs, tree by tree. `worn` gives each leaf's garment in the order of
    /// the stand's ids, `None` for a leaf that is not there.
    #[must_use]
    pub fn frame(&self, scene: &Scene, stand: &Stand, worn: &[Option<Garment>]) -> Frame {
        let camera = view::camera(scene, stand);
        let lighting = light::lighting(&scene.light, view::axis(&camera), self.clouds);
        let hanging = worn.iter().flatten().count();
        let mut instances = Vec::with_capacity(stand.trees.len() + hanging);
        for (form, standing) in &stand.trees {
            let model = self.wood[*form];
            if !self.models[model as usize].parts.is_empty() {
                instances.push(Instance { model, transform: Pose::of(standing).affine(), leaf: None });
            }
        }
        let of_run = |LeafRun { form, standing, sites, places }: LeafRun<'_>| {
            let pose = Pose::of(standing);
            let leaves = sites.iter().zip(&worn[places.clone()]).zip(&stand.leaf_ids[places]);
            let instance = |((site, garment), &id): ((&LeafSite, &Option<Garment>), &u64)| {
                let petiole = Petiole::of(site);
                let model = *self.worn.get(&((*garment)?, petiole))?;
                let transform = placed(site, pose, self.petiole_bases[&(form.species, petiole)]);
                Some(Instance { model, transform, leaf: Some(id) })
            };
            leaves.filter_map(instance).collect::<Vec<_>>()
        };
        // Without seasons no leaf wears anything.
        let runs = if worn.is_empty() { Vec::new() } else { stand.leaf_runs() };
        let parts: Vec<Vec<Instance>> = runs.into_par_iter().map(of_run).collect();
        parts.into_iter().for_each(|part| instances.extend(part));
        Frame {
            meshes: self.meshes.clone(),
            textures: self.textures_with_wood(),
            materials: self.materials.clone(),
            models: self.models.clone(),
            instances,
            fallen: 0,
            camera,
            sun: lighting.sun,
            sky: lighting.sky,
            ground: self.ground_in_season(worn),
            background: view::background(scene),
            view: view::view(scene, lighting.exposure),
        }
    }
}

/// A leaf at its site: the blade as the site says, the petiole's foot on the twig.
fn placed(site: &LeafSite, pose: Pose, petiole_base: Vec3) -> Affine {
    let (blade, normal) = (pose.direction(site.blade), pose.direction(site.normal));
    let across = blade.cross(&normal);
    let rotation = nalgebra::Matrix3::from_columns(&[across, blade, normal]);
    let linear: Mat3 = (rotation * site.scale).cast::<f32>();
    Affine { linear, translation: pose.point(site.base).cast::<f32>() - linear * petiole_base }
}

/// What the names of each species' models begin with: nothing when there is only one, else its name.
fn tags(species: &[Species]) -> Vec<String> {
    if species.len() == 1 {
        return vec![String::new()];
    }
    let mut tags: Vec<String> = Vec::new();
    for (number, one) in species.iter().enumerate() {
        let stem = one.label().trim_end_matches(".toml").rsplit('/').next().unwrap_or_default();
        let plain = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' };
        let tag: String = stem.chars().map(plain).chain(['_']).collect();
        tags.push(if tags.contains(&tag) { format!("{tag}{number}_") } else { tag });
    }
    tags
}

/// The name of a garment's model.
fn leaf_name(tag: &str, wardrobe: &Wardrobe, garment: Garment) -> String {
    let state = &wardrobe.states[usize::from(garment.state)];
    format!("leaf_{tag}{}_{}", model_name(state, garment.state), garment.variant)
}

/// A state's name as models may bear it; a name with other characters than the built-in ones have gives way to its number.
fn model_name(state: &str, number: u16) -> String {
    let plain = state.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-');
    if plain { state.replace('-', "_") } else { format!("state{number}") }
}
