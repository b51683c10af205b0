//! The leaves that have left their twigs, before anything is known of their shapes: which they are, and what has become of them.

use super::stand::{Form, Pose};
use super::{Garment, Stand, variant};
use crate::base::maths::hypot;
use crate::base::vector::{DVec2, DVec3};
use crate::fall::{self, Counts, Course, Fallen, Fate, Flight, Ground, Side, Slopes, Trunk, Wind};
use crate::scene::{Scene, Species, Standing};
use crate::tree::LeafSite;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// Wood below this height is a trunk's foot, metres.
const FOOT: f64 = 0.08;
/// Largest radius of a trunk's foot, metres: wider ones are boughs that touch the ground.
const LARGEST_FOOT: f64 = 0.8;
/// Most leaves whose ways are remembered, of some 300 bytes each: what falls beyond them is computed for each frame.
const MOST_KNOWN: usize = 250_000;

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
    /// How far it moves aside on all of its way, along x and z, metres.
    pub aside: DVec2,
    /// How far gusts roll it along once it has landed, along x and z, metres.
    pub drift: DVec2,
    /// The side on which it will lie, and its turn, radians.
    pub lot: (Side, f64),
    /// What becomes of it, and when.
    pub course: Course,
    /// What has become of it.
    pub fate: Fate,
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

/// The ways of leaves that have fallen, from frame to frame: a way follows from the leaf alone, so it is found once in a run.
#[derive(Clone, Debug, Default)]
pub struct Ways {
    known: BTreeMap<Key, Fall>,
    /// Ways found so far, each time that one was.
    pub found: u64,
}

impl Ways {
    /// Finds the ways of leaves that are not known yet; those that are not remembered are given back.
    fn find(&mut self, finder: &Finder<'_>, dropped: &[Dropped]) -> BTreeMap<Key, Fall> {
        let new: Vec<&Dropped> = dropped.par_iter().filter(|one| self.known(one).is_none()).collect();
        let found: Vec<Option<Fall>> = new.par_iter().map(|one| finder.find(one)).collect();
        self.found += new.len() as u64;
        let mut others = BTreeMap::new();
        for (one, fall) in new.into_iter().zip(found).filter_map(|(one, fall)| Some((one, fall?))) {
            if self.known.len() < MOST_KNOWN {
                self.known.insert(key(one), fall);
            } else {
                others.insert(key(one), fall);
            }
        }
        others
    }

    fn known(&self, one: &Dropped) -> Option<&Fall> {
        self.known.get(&key(one)).filter(|fall| fall.garment.state == one.state)
    }
}

/// A site, a year and the bits of a day: one that holds its dead leaves until spring loses two in one year.
type Key = (usize, u64, u64);

fn key(one: &Dropped) -> Key {
    (one.site, one.year, one.day.to_bits())
}

/// What finds the way of a leaf.
struct Finder<'a> {
    scene: &'a Scene,
    stand: &'a Stand,
    sites: Sites<'a>,
    wind: Wind,
    /// The ground where it is uneven.
    slopes: Option<Slopes<'a>>,
    decays: Vec<fall::Decay>,
    /// Mass over area by species and state, g/m2.
    masses: Vec<Vec<f64>>,
}

impl<'a> Finder<'a> {
    fn new(scene: &'a Scene, stand: &'a Stand, names: &[String]) -> Self {
        let decays = scene.species.iter().map(|one| scene.fall.decay(&one.fall)).collect();
        let masses =
            scene.species.iter().map(|one| names.iter().map(|state| mass_per_area(one, state)).collect()).collect();
        let slopes = stand.heights.as_deref().map(Slopes::new);
        let wind = Wind::new(&scene.fall, scene.seed);
        Self { scene, stand, sites: Sites::new(stand), wind, slopes, decays, masses }
    }

    /// The flight of a leaf, and how far aside it lands.
    fn flight(&self, leaf: &Fallen) -> (Flight, DVec2) {
        if let Some(slopes) = &self.slopes {
            return slopes.landing(leaf, self.scene.seed, &self.wind);
        }
        let flight = Flight::new(leaf, self.scene.seed, 0.0);
        (flight, flight.aside(&self.wind, flight.seconds))
    }

    fn find(&self, dropped: &Dropped) -> Option<Fall> {
        let scene = self.scene;
        let (form, pose, site) = self.sites.at(dropped.site)?;
        let species = &scene.species[form.species];
        let mass_per_area = *self.masses[form.species].get(usize::from(dropped.state))?;
        let id = self.stand.leaf_ids[dropped.site];
        let twig = pose.point(site.base);
        let length = species.leaf.length * 1e-3 * site.scale;
        let leaf = Fallen { leaf: id, year: dropped.year, day: dropped.day, twig, mass_per_area, length };
        let (flight, aside) = self.flight(&leaf);
        let course = Course::new(&scene.fall, &self.decays[form.species], scene.seed, &leaf, &flight);
        let variant = variant(scene.seed, id, species.variants());
        let garment = Garment { species: form.species as u16, state: dropped.state, variant };
        let (drift, lot) = (self.wind.drifted(scene.seed, &leaf), fall::lot(scene.seed, &leaf));
        Some(Fall { site: dropped.site, garment, leaf, flight, aside, drift, lot, course, fate: Fate::Hanging })
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
    /// What has become on `day` of the leaves that fell; `attached` others hang. `ways` are those of earlier frames of the same
    /// scene, and are added to.
    #[must_use]
    pub fn new(
        (scene, stand, names): (&Scene, &Stand, &[String]),
        dropped: &[Dropped],
        attached: u64,
        day: f64,
        ways: &mut Ways,
    ) -> Self {
        let others = ways.find(&Finder::new(scene, stand, names), dropped);
        let way = |one: &Dropped| ways.known(one).or_else(|| others.get(&key(one)));
        let yard = Yard::new(scene, stand);
        let fate = |one: &Dropped| {
            way(one).map(|fall| {
                let (fate, is_raked) = yard.fate(fall, day);
                (fall, fate, is_raked)
            })
        };
        let all: Vec<Option<(&Fall, Fate, bool)>> = dropped.par_iter().map(fate).collect();
        let all = || all.iter().flatten();
        let count = |is: &dyn Fn(Fate) -> bool| all().filter(|(_, fate, _)| is(*fate)).count() as u64;
        let counts = Counts {
            grown: attached + all().count() as u64,
            attached: attached + count(&|fate| fate == Fate::Hanging),
            air: count(&|fate| matches!(fate, Fate::Air(_))),
            lying: count(&Fate::lies),
            decayed: count(&|fate| fate == Fate::Decayed),
            raked: all().filter(|(.., is_raked)| *is_raked).count() as u64,
        };
        let mut seen = Vec::with_capacity((counts.air + counts.lying) as usize);
        seen.extend(all().map(|&(fall, fate, _)| Fall { fate, ..*fall }).filter(|fall| fall.look().is_some()));
        Self { seen, counts }
    }

    /// What any of them looks like.
    #[must_use]
    pub fn looks(&self) -> BTreeSet<(Garment, Look)> {
        self.seen.iter().filter_map(|fall| Some((fall.garment, fall.look()?))).collect()
    }
}

/// The ground below the trees, from which raked circles are cleared.
struct Yard<'a> {
    scene: &'a Scene,
    /// The ground, where any of it is raked.
    raked: Option<Ground>,
}

impl<'a> Yard<'a> {
    fn new(scene: &'a Scene, stand: &Stand) -> Self {
        let is_raked = scene.fall.raked > 0.0;
        Self { scene, raked: is_raked.then(|| ground(stand)) }
    }

    /// What has become of a leaf, and whether it was raked away.
    fn fate(&self, fall: &Fall, day: f64) -> (Fate, bool) {
        let fate = fall.course.fate(&self.scene.fall, &fall.leaf, &fall.flight, day);
        let lies_raked = |ground: &Ground| {
            let landing = DVec2::new(fall.leaf.twig.x, fall.leaf.twig.z) + fall.aside;
            ground.is_raked(rest(self.scene, ground, fall, landing), self.scene.fall.raked)
        };
        match &self.raked {
            Some(ground) if fate.lies() && lies_raked(ground) => (Fate::Decayed, true),
            _ => (fate, false),
        }
    }
}

/// Where a leaf that has landed comes to rest: it drifts on, then slides.
pub(super) fn rest(scene: &Scene, ground: &Ground, fall: &Fall, landing: DVec2) -> DVec2 {
    ground.rest(scene.seed, scene.fall.wind, landing + fall.drift)
}

/// The ground with the feet of all trunks.
pub(super) fn ground(stand: &Stand) -> Ground {
    let radii: Vec<f64> = stand.forms.iter().map(foot).collect();
    let trunk = |(form, standing): &(usize, Standing)| {
        let [x, z] = standing.place;
        Trunk { place: DVec2::new(x, z), radius: radii[*form] }
    };
    Ground { trunks: stand.trees.iter().map(trunk).collect(), heights: stand.heights.clone() }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_falls_from_one_site_in_a_year_are_told_apart() {
        let spring = Dropped { site: 3, year: 2024, day: 90.25, state: 4 };
        let autumn = Dropped { day: 301.5, ..spring };
        assert_ne!(key(&spring), key(&autumn));
    }
}
