//! Fallen leaves as instances: in the air the models of the twigs, on the ground the same blades with petioles that lie, in
//! time with the brown texture of their species, at last flat and dark.

use super::falls::{Fall, Falls, Look, Sites, ground, level, rest};
use super::petiole::{self, Petiole};
use super::{Garment, Stand, Stock, Wardrobe, placed};
use crate::base::figures::{ErrorFigure, Figures};
use crate::base::mesh::Mesh;
use crate::base::random::hash;
use crate::base::vector::{Affine, DVec2, DVec3};
use crate::fall::{self, Fate, Ground, Laid, Landed, Litter, Shape, Side, Stalk, Wind};
use crate::frame::{Frame, Instance, Material, Model, Part};
use crate::scene::Scene;
use nalgebra::{Rotation3, UnitQuaternion};
use rayon::prelude::*;
use std::sync::{Arc, MutexGuard, PoisonError};

/// Name of the state whose texture a leaf takes on the ground.
pub const BROWN: &str = "brown";
/// Angle of a lying petiole to its blade, radians.
const LYING_BEND: f64 = 0.06;
/// How much of its height a flat leaf keeps.
const FLATTENED: f32 = 0.2;
/// Reflectance of a leaf that has browned where it lies over that of a brown one that hangs: dusty and rained on (judged).
const DULLER: [f32; 3] = [0.62, 0.75, 1.00];
/// Reflectance of a flat leaf over that of a brown one: wet, and greyed as its tannins are washed out (judged).
const DARKER: [f32; 3] = [0.56, 0.66, 0.88];
/// How far above its rest on bare ground a flight ends, metres: what lies there has to be cleared.
const ARRIVAL: f64 = 0.01;

/// The petioles of a species: their length, metres, and angle, radians.
#[derive(Clone, Copy)]
pub(super) struct Stalks {
    pub length: f64,
    pub bend: f64,
    pub material: Option<u32>,
}

/// A model of fallen leaves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lying {
    as_fell: Worn,
    /// Where other leaves lie over it.
    pressed: Worn,
}

/// A model with the number of its shape.
#[derive(Clone, Copy, Debug)]
struct Worn {
    model: u32,
    shape: u32,
}

impl Stock {
    /// The models of a species' fallen leaves. `meshes` are those of its shapes.
    pub(super) fn add_fallen(
        &mut self,
        scene: &Scene,
        (number, tag): (usize, &str),
        wardrobe: &Wardrobe,
        stalks: Stalks,
        petioles: &[Petiole],
    ) {
        let looks = wardrobe.fallen.iter().filter(|(garment, _)| usize::from(garment.species) == number);
        for &(garment, look) in looks {
            let Some(shape) = wardrobe.shapes.get(&garment) else { continue };
            let (blade, mesh) = match look {
                Look::Flat => self.flat(garment, shape),
                _ => (self.blades[&garment], shape.clone()),
            };
            let material = self.fallen_material(scene, (number, tag), wardrobe, garment, look);
            let name = self.materials[material as usize].name.clone();
            for &petiole in petioles {
                let length = stalks.length * petiole.length();
                let stalk = stalks.material.map(|material| Part { mesh: self.lying_stalk(length), material });
                let model = match self.worn.get(&(garment, petiole)) {
                    Some(&hung) if look == Look::Hung => hung,
                    _ => {
                        let mut parts = vec![Part { mesh: blade, material }];
                        parts.extend(stalk);
                        let name = format!("fallen_{name}_{}_{}{}", garment.state, garment.variant, petiole.suffix());
                        self.models.push(Model { name, parts });
                        self.models.len() as u32 - 1
                    }
                };
                let ends = Stalk { hung: petiole::base(length, stalks.bend), lying: petiole::base(length, LYING_BEND) };
                let as_fell = Worn { model, shape: self.resting(&mesh, ends) };
                let pressed = match look {
                    Look::Fresh | Look::Brown => self.pressed((garment, shape), petiole, material),
                    Look::Hung | Look::Flat => as_fell,
                };
                self.lying.insert((garment, petiole, look), Lying { as_fell, pressed });
            }
        }
    }

    /// The model of a leaf under others: flat, and without the petiole, which is not seen.
    fn pressed(&mut self, (garment, shape): (Garment, &Arc<Mesh>), petiole: Petiole, material: u32) -> Worn {
        let (blade, mesh) = self.flat(garment, shape);
        let name = &self.materials[material as usize].name;
        let name = format!("fallen_{name}_{}_{}{}_pressed", garment.state, garment.variant, petiole.suffix());
        self.models.push(Model { name, parts: vec![Part { mesh: blade, material }] });
        Worn { model: self.models.len() as u32 - 1, shape: self.resting(&mesh, Stalk::default()) }
    }

    /// The number of the shape of a mesh with a petiole.
    fn resting(&mut self, mesh: &Arc<Mesh>, stalk: Stalk) -> u32 {
        let same = |(known, of, _): &(Arc<Mesh>, Stalk, Shape)| Arc::ptr_eq(known, mesh) && *of == stalk;
        if let Some(known) = self.resting.iter().position(same) {
            return known as u32;
        }
        self.resting.push((mesh.clone(), stalk, Shape::new(mesh, stalk)));
        self.resting.len() as u32 - 1
    }

    /// The flattened mesh of a shape.
    fn flat(&mut self, garment: Garment, shape: &Arc<Mesh>) -> (u32, Arc<Mesh>) {
        if let Some(&known) = self.flat.get(&garment) {
            return (known, self.meshes[known as usize].clone());
        }
        let mut flat = Mesh::clone(shape);
        flat.positions.iter_mut().for_each(|p| p.z *= FLATTENED);
        flat.recompute_normals();
        let flat = Arc::new(flat);
        let number = self.push_mesh(flat.clone());
        self.flat.insert(garment, number);
        (number, flat)
    }

    fn lying_stalk(&mut self, length: f64) -> u32 {
        if let Some(&known) = self.lying_stalks.get(&length.to_bits()) {
            return known;
        }
        let number = self.push_mesh(Arc::new(petiole::straight(length, LYING_BEND)));
        self.lying_stalks.insert(length.to_bits(), number);
        number
    }

    fn fallen_material(
        &mut self,
        scene: &Scene,
        (number, tag): (usize, &str),
        wardrobe: &Wardrobe,
        garment: Garment,
        look: Look,
    ) -> u32 {
        let brown = wardrobe.browned(garment).filter(|brown| wardrobe.textures.contains_key(brown));
        let garment = match look {
            Look::Brown | Look::Flat => brown.unwrap_or(garment),
            _ => garment,
        };
        let own = self.leaf_material(scene, (number, tag), wardrobe, garment);
        let (suffix, factor, passing) = match look {
            Look::Hung => return own,
            Look::Fresh => ("lying", [1.0; 3], 1.0),
            Look::Brown => ("browned", DULLER, 0.7),
            Look::Flat => ("flat", DARKER, 0.4),
        };
        let name = format!("{}_{suffix}", self.materials[own as usize].name);
        if let Some(known) = self.materials.iter().position(|material| material.name == name) {
            return known as u32;
        }
        let of_leaf = self.materials[own as usize].clone();
        let colour = std::array::from_fn(|k| of_leaf.colour[k] * factor[k]);
        let transmission = of_leaf.transmission.map(|share| share * passing);
        // Litter is seen along the ground, where a smooth leaf would mirror the sky: lying ones are dusty and bent.
        self.push_material(Material { name, colour, transmission, gloss: 0.0, roughness: 0.95, ..of_leaf })
    }

    /// How leaves lie; what lies as in the frame before is not laid anew.
    fn laid(&self, ground: &Ground, shapes: &[&Shape], landed: &[Landed]) -> Vec<Laid> {
        // Taken out while it works: a lock that is held while other threads help would be waited for by one of them.
        let mut litter = std::mem::take(&mut *self.litter());
        let laid = litter.settle(ground, shapes, landed);
        *self.litter() = litter;
        laid
    }

    /// How many leaves have been laid so far, and the most bytes that their field has taken.
    fn told(&self) -> (u64, u64) {
        let litter = self.litter();
        (litter.settled, litter.field_bytes)
    }

    fn litter(&self) -> MutexGuard<'_, Litter> {
        self.litter.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds fallen leaves to a frame.
    #[must_use]
    pub fn strewn(&self, scene: &Scene, stand: &Stand, falls: &Falls, frame: Frame) -> (Frame, Figures) {
        let strewer = Strewer {
            stock: self,
            scene,
            sites: Sites::new(stand),
            ground: ground(stand),
            wind: Wind::new(&scene.fall, scene.seed),
        };
        let mut fallen = strewer.instances(stand, falls);
        let mut frame = frame;
        frame.fallen = fallen.len();
        let buried = falls.seen.len().saturating_sub(fallen.len());
        frame.instances.append(&mut fallen);
        let (settled, bytes) = self.told();
        let figures = figures(falls).with("buried", buried).with("settled", settled).with("field_bytes", bytes);
        (frame, figures)
    }
}

impl Wardrobe {
    /// What a leaf wears when it is brown, if its species has such a state.
    #[must_use]
    pub fn browned(&self, garment: Garment) -> Option<Garment> {
        let state = self.states.iter().position(|state| state == BROWN)? as u16;
        Some(Garment { state, ..garment })
    }
}

/// What places fallen leaves.
struct Strewer<'a> {
    stock: &'a Stock,
    scene: &'a Scene,
    sites: Sites<'a>,
    ground: Ground,
    wind: Wind,
}

/// A fallen leaf on its way.
#[derive(Clone, Copy)]
struct Way {
    lying: Lying,
    scale: f64,
    side: Side,
    yaw: f64,
    /// Attitude and middle on the twig.
    hung: UnitQuaternion<f64>,
    middle: DVec3,
    /// Where its middle lands, and where it comes to rest.
    landing: DVec2,
    rest: DVec2,
}

impl Strewer<'_> {
    fn instances(&self, stand: &Stand, falls: &Falls) -> Vec<Instance> {
        let ways: Vec<Option<Way>> = falls.seen.par_iter().map(|fall| self.way(fall)).collect();
        let on_the_way = || falls.seen.iter().zip(&ways).filter_map(|(fall, way)| Some((fall, (*way)?)));
        let lying = || on_the_way().filter(|(fall, _)| fall.fate.lies());
        let landed: Vec<Landed> = lying().map(|(fall, way)| landed(fall, &way)).collect();
        let shapes: Vec<&Shape> = self.stock.resting.iter().map(|(.., shape)| shape).collect();
        let laid = self.stock.laid(&self.ground, &shapes, &landed);
        let flying = on_the_way().filter(|(fall, _)| !fall.fate.lies());
        let flying =
            flying.map(|(fall, way)| self.instance(stand, fall, &way, (way.lying.as_fell, self.flying(fall, &way))));
        // what others hide is not drawn
        let lying = lying().zip(&laid).filter(|(_, laid)| !laid.is_buried).map(|((fall, way), laid)| {
            let at = match fall.fate {
                Fate::Fresh(share) if share < 1.0 => self.settling(&way, share, (laid.middle, laid.attitude)),
                _ => (laid.middle, laid.attitude),
            };
            let worn = if laid.is_pressed { way.lying.pressed } else { way.lying.as_fell };
            self.instance(stand, fall, &way, (worn, at))
        });
        flying.chain(lying).collect()
    }

    /// The way of a leaf; `None` without a model.
    fn way(&self, fall: &Fall) -> Option<Way> {
        let (form, pose, site) = self.sites.at(fall.site)?;
        let petiole = Petiole::of(site);
        let lying = *self.stock.lying.get(&(fall.garment, petiole, fall.look()?))?;
        let base = *self.stock.petiole_bases.get(&(form.species, petiole))?;
        let transform = placed(site, pose, base);
        let middle = transform.point(self.shape(lying.as_fell).middle.cast::<f32>()).cast::<f64>();
        let rotation = transform.linear.cast::<f64>() / site.scale;
        let hung = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
        let landing = level(middle) + fall.aside;
        let rest = rest(self.scene, &self.ground, fall, landing);
        let (side, yaw) = fall.lot;
        Some(Way { lying, scale: site.scale, side, yaw, hung, middle, landing, rest })
    }

    fn shape(&self, worn: Worn) -> &Shape {
        &self.stock.resting[worn.shape as usize].2
    }

    /// Middle and attitude at the end of the flight.
    fn arrival(&self, way: &Way) -> (DVec3, UnitQuaternion<f64>) {
        let shape = self.shape(way.lying.as_fell);
        let height = self.ground.height(way.landing) + shape.stands(way.side) * way.scale + ARRIVAL;
        (DVec3::new(way.landing.x, height, way.landing.y), shape.level(way.side, way.yaw))
    }

    /// Middle and attitude in the air.
    fn flying(&self, fall: &Fall, way: &Way) -> (DVec3, UnitQuaternion<f64>) {
        let Fate::Air(seconds) = fall.fate else { return self.arrival(way) };
        let (end, lying) = self.arrival(way);
        let attitude = fall.flight.attitude(seconds, &way.hung, &lying);
        let place = level(way.middle) + fall.flight.aside(&self.wind, seconds);
        let height = end.y + (way.middle.y - end.y) * (1.0 - fall.flight.done(seconds)) + fall.flight.lift(seconds);
        // near the ground a leaf that still turns keeps its rim above it
        let rim = self.shape(way.lying.as_fell).lowest(&attitude) * way.scale;
        let height = height.max(self.ground.height(place) - rim);
        (DVec3::new(place.x, height, place.y), attitude)
    }

    /// Middle and attitude of a leaf that slides to its rest.
    fn settling(&self, way: &Way, share: f64, rest: (DVec3, UnitQuaternion<f64>)) -> (DVec3, UnitQuaternion<f64>) {
        let (from, attitude) = self.arrival(way);
        let slid = 1.0 - (1.0 - share) * (1.0 - share);
        let turned = attitude.try_slerp(&rest.1, slid, 1e-9).unwrap_or(rest.1);
        (from + (rest.0 - from) * slid, turned)
    }

    fn instance(
        &self,
        stand: &Stand,
        fall: &Fall,
        way: &Way,
        (worn, (middle, attitude)): (Worn, (DVec3, UnitQuaternion<f64>)),
    ) -> Instance {
        let linear = attitude.to_rotation_matrix().into_inner() * way.scale;
        let translation = (middle - linear * self.shape(worn).middle).cast::<f32>();
        let id = stand.leaf_ids[fall.site];
        // the leaves of other years are others
        let leaf = if fall.leaf.year == 0 { id } else { hash(id, fall.leaf.year) };
        let transform = Affine { linear: linear.cast::<f32>(), translation };
        Instance { model: worn.model, transform, leaf: Some(leaf) }
    }
}

fn landed(fall: &Fall, way: &Way) -> Landed {
    let (leaf, day) = (fall.leaf.leaf, fall.course.landed);
    let (shape, pressed) = (way.lying.as_fell.shape, way.lying.pressed.shape);
    Landed { leaf, day, place: way.rest, shape, pressed, scale: way.scale, side: way.side, yaw: way.yaw }
}

/// What the report tells of a frame's fallen leaves.
fn figures(falls: &Falls) -> Figures {
    let counts = falls.counts;
    let mut figures = Figures::of(counts.air + counts.lying)
        .with("grown", counts.grown)
        .with("attached", counts.attached)
        .with("air", counts.air)
        .with("lying", counts.lying)
        .with("decayed", counts.decayed)
        .with("raked", counts.raked);
    let leaves = falls.seen.len() as f64;
    if leaves > 0.0 {
        let mean = |value: &dyn Fn(&Fall) -> f64| falls.seen.iter().map(value).sum::<f64>() / leaves;
        let found = mean(&|fall| fall.flight.height / fall.flight.seconds);
        let formula = mean(&|fall| fall::terminal_speed(fall.leaf.mass_per_area));
        figures = figures.with("descent_m_s", found);
        figures.error = Some(ErrorFigure {
            metric: "mean speed of descent, relative".to_owned(),
            value: (found / formula - 1.0).abs(),
            unit: String::new(),
            bound: Some(0.03),
            how: "heights over times of the leaves seen against sqrt(2 (m/A) g / (rho Cd))".to_owned(),
        });
    }
    figures
}
