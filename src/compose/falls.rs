//! The leaves that have left their twigs, before anything is known of their shapes: which they are, and what has become of them.

use super::stand::{Form, Pose};
use super::{Garment, Stand, variant};
use crate::base::maths::hypot;
use crate::base::vector::{DVec2, DVec3};
use crate::fall::{self, Counts, Fallen, Fate, Flight, Ground, Trunk, Wind};
use crate::scene::{Scene, Species, Standing};
use crate::tree::LeafSite;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Wood below this height is a trunk's foot, metres.
const FOOT: f64 = 0.08;
/// Largest radius of a trunk's foot, metres: wider ones are boughs that touch the ground.
const LARGEST_FOOT: f64 = 0.8;

/// A leaf that its twig has let go: one for every fall, also of earlier years.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dropped {
    /// Place of its site among the stand's leaves.
    pub site: usize,
    /// Which fall of that site it is: the year it fell in, 0 in a climate without years.
    pub year: u64,
    /// When, days.
    pub day: f64,
    /// The state in which it fell.
    pub state: u16,
}

/// What a fallen leaf looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Look {
    /// As on its twig: in the air.
    Hung,
    /// As it fell, lying.
    Fresh,
    /// Brown, in the shape in which it fell.
    Brown,
    /// Brown, dark and flat.
    Flat,
}

/// A fallen leaf at a time.
#[derive(Clone, Copy, Debug)]
pub struct Fall {
    /// Place of its site among the stand's leaves.
    pub site: usize,
    /// What it wore on the twig.
    pub garment: Garment,
    /// What fell.
    pub leaf: Fallen,
    /// Its way down.
    pub flight: Flight,
    /// What has become of it.
    pub fate: Fate,
    /// When it landed or will land, days.
    pub landed: f64,
}

impl Fall {
    /// What it looks like; `None` when it is not to be seen.
    #[must_use]
    pub fn look(&self) -> Option<Look> {
        match self.fate {
            Fate::Hanging | Fate::Decayed => None,
            Fate::Air(_) => Some(Look::Hung),
            Fate::Fresh(_) => Some(Look::Fresh),
            Fate::Brown => Some(Look::Brown),
            Fate::Flat => Some(Look::Flat),
        }
    }
}

/// All fallen leaves at a time.
#[derive(Clone, Debug, Default)]
pub struct Falls {
    /// Those that may be seen, in the order in which they were given.
    pub seen: Vec<Fall>,
    /// What has become of all.
    pub counts: Counts,
}

impl Falls {
    /// What has become on `day` of the leaves that fell; `attached` others hang.
    #[must_use]
    pub fn new(scene: &Scene, stand: &Stand, names: &[String], dropped: &[Dropped], attached: u64, day: f64) -> Self {
        let sites = Sites::new(stand);
        let decays: Vec<fall::Decay> = scene.species.iter().map(|one| scene.fall.decay(&one.fall)).collect();
        let masses: Vec<Vec<f64>> =
            scene.species.iter().map(|one| names.iter().map(|state| mass_per_area(one, state)).collect()).collect();
        let of = |dropped: &Dropped| {
            let (form, pose, site) = sites.at(dropped.site)?;
            let species = &scene.species[form.species];
            let mass_per_area = *masses[form.species].get(usize::from(dropped.state))?;
            let id = stand.leaf_ids[dropped.site];
            let twig = pose.point(site.base);
            let length = species.leaf.length * 1e-3 * site.scale;
            let leaf = Fallen { leaf: id, year: dropped.year, day: dropped.day, twig, mass_per_area, length };
            let flight = Flight::new(&leaf, scene.seed, 0.0);
            let (fate, landed) = fall::fate(&scene.fall, &decays[form.species], scene.seed, &leaf, &flight, day);
            let variant = variant(scene.seed, id, species.variants());
            let garment = Garment { species: form.species as u16, state: dropped.state, variant };
            Some(Fall { site: dropped.site, garment, leaf, flight, fate, landed })
        };
        let mut all: Vec<Fall> = dropped.par_iter().filter_map(of).collect();
        let raked = rake(scene, stand, &mut all);
        let count = |is: &dyn Fn(Fate) -> bool| all.iter().filter(|fall| is(fall.fate)).count() as u64;
        let counts = Counts {
            grown: attached + all.len() as u64,
            attached: attached + count(&|fate| fate == Fate::Hanging),
            air: count(&|fate| matches!(fate, Fate::Air(_))),
            lying: count(&Fate::lies),
            decayed: count(&|fate| fate == Fate::Decayed),
            raked,
        };
        all.retain(|fall| fall.look().is_some());
        Self { seen: all, counts }
    }

    /// What any of them looks like.
    #[must_use]
    pub fn looks(&self) -> BTreeSet<(Garment, Look)> {
        self.seen.iter().filter_map(|fall| Some((fall.garment, fall.look()?))).collect()
    }
}

/// Takes away what lies in raked circles; how many leaves that are.
fn rake(scene: &Scene, stand: &Stand, all: &mut [Fall]) -> u64 {
    if scene.fall.raked <= 0.0 {
        return 0;
    }
    let (ground, wind) = (ground(stand), Wind::new(&scene.fall, scene.seed));
    let raked = |fall: &mut Fall| {
        let below = DVec2::new(fall.leaf.twig.x, fall.leaf.twig.z);
        let landed = below + fall.flight.aside(&wind, fall.flight.seconds);
        let rest = ground.rest(scene.seed, scene.fall.wind, landed);
        let is_raked = fall.fate.lies() && ground.is_raked(rest, scene.fall.raked);
        if is_raked {
            fall.fate = Fate::Decayed;
        }
        is_raked
    };
    all.par_iter_mut().map(|fall| u64::from(raked(fall))).sum()
}

/// The level ground with the feet of all trunks.
pub(super) fn ground(stand: &Stand) -> Ground {
    let radii: Vec<f64> = stand.forms.iter().map(foot).collect();
    let trunk = |(form, standing): &(usize, Standing)| {
        let [x, z] = standing.place;
        Trunk { place: DVec2::new(x, z), radius: radii[*form] }
    };
    Ground { trunks: stand.trees.iter().map(trunk).collect(), heights: None }
}

/// Radius of a trunk at the ground, metres.
fn foot(form: &Form) -> f64 {
    let vertices = form.wood.iter().flat_map(|wood| &wood.mesh.positions);
    let low = vertices.filter(|p| f64::from(p.y) < FOOT).map(|p| hypot(f64::from(p.x), f64::from(p.z)));
    low.filter(|radius| *radius < LARGEST_FOOT).fold(0.0, f64::max)
}

/// Mass over area of a leaf of a state, g/m2: its water and dry matter.
fn mass_per_area(species: &Species, state: &str) -> f64 {
    let pigments = species.colour.contents(state);
    (pigments.water + pigments.dry_matter) * 1e4
}

/// Sites of leaves by their place among all of a stand.
pub(super) struct Sites<'a> {
    stand: &'a Stand,
    /// The place of each tree's first leaf.
    firsts: Vec<usize>,
}

impl<'a> Sites<'a> {
    pub(super) fn new(stand: &'a Stand) -> Self {
        let mut next = 0;
        let first = |(form, _): (&Form, &Standing)| {
            next += form.sites.len();
            next - form.sites.len()
        };
        Self { stand, firsts: stand.standing().map(first).collect() }
    }

    /// A site with its tree's form and pose.
    pub(super) fn at(&self, place: usize) -> Option<(&'a Form, Pose, &'a LeafSite)> {
        let tree = self.firsts.partition_point(|&first| first <= place).checked_sub(1)?;
        let (form, standing) = self.stand.trees.get(tree)?;
        let form = &self.stand.forms[*form];
        Some((form, Pose::of(standing), form.sites.get(place - self.firsts[tree])?))
    }
}

/// The level part of a point: x and z.
pub(super) fn level(point: DVec3) -> DVec2 {
    DVec2::new(point.x, point.z)
}
