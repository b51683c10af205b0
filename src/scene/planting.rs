//! Which trees stand in the scene, and where. An entry of `[[trees]]` plants one tree, or with `count` a grove: places in an
//! area, drawn one after another, each kept when no trunk planted before is too near (Poisson-disc sampling by dart
//! throwing, Cook 1986). A tree depends on nothing planted after it, so one more tree or entry at the end changes no other.

use super::Scene;
use crate::base::random::{Purpose, Stream, hash};
use crate::base::settings::{Complaint, Key, Schema};
use crate::{settings, tree};
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::sync::Arc;

settings! {
    /// A tree of the scene, or with `count` a grove of one species and age. The scene's own tables (`[tree]`, `[leaf]`, `[season]`,
    /// `[deform]`, `[colour]`) hold for all trees; what they leave open each tree takes from its species.
    pub struct Planting {
        /// A built-in species, or the path of a species file; the scene's `species` when absent.
        species: Option<String> = None;
        /// Where the trunk meets the ground: x to the right, z towards the default camera. Of a grove, the middle of its area.
        place: [f64; 2] = [0.0, 0.0], unit "m", range -1e4 => 1e4;
        /// What the tree grows from. When absent it follows from the scene's `seed` and the entry's number; the first tree
        /// grows from the scene's `seed` itself, as a scene without `[[trees]]` does.
        seed: Option<u64> = None, range 0 => u64::MAX;
        /// Turn about the vertical, counter-clockwise seen from above. 0 when absent; trees of a grove are turned by chance.
        turn: Option<f64> = None, unit "°", range -360.0 => 360.0;
        /// Trees of a grove; absent for one tree that stands at `place`.
        count: Option<u32> = None, range 1 => 10000;
        /// Extent of a grove along x and z; 40 by 40 when absent.
        area: Option<[f64; 2]> = None, unit "m", range 0.1 => 1e4;
        /// Least distance of a grove's trunks from one another and from those planted before; 4 when absent.
        spacing: Option<f64> = None, unit "m", range 0.1 => 1000.0;
        /// Different trees that are grown for a grove, each standing several times and turned another way; 10 when absent.
        forms: Option<u32> = None, range 1 => 10000;
    }
}

/// Most entries of `[[trees]]`; one entry plants many trees with `count`.
pub(super) const MOST_ENTRIES: usize = 1000;
/// Most trees of a scene.
const MOST_TREES: u64 = 100_000;
/// Extent of a grove that gives none, metres.
const AREA: [f64; 2] = [40.0, 40.0];
/// Least distance of trunks in a grove that gives none, metres.
const SPACING: f64 = 4.0;
/// Forms of a grove that gives none.
const FORMS: u32 = 10;
/// Places tried for a tree before its grove counts as full.
const TRIES: usize = 2000;
/// Places tried for all trees of a grove: bounds the time that an absurd grove takes.
const MOST_TRIES: usize = 5_000_000;

/// An entry of `[[trees]]` with its species found.
#[derive(Clone, Debug, Serialize)]
pub struct Planted {
    /// Number of its species in the scene.
    pub species: usize,
    /// The age that the entry gives, if any.
    pub age: Option<Value>,
    /// How its trees grow: the species' settings at that age.
    #[serde(skip)]
    pub tree: Arc<tree::Settings>,
    /// What the entry says.
    pub planting: Planting,
}

/// A tree where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Standing {
    /// Number of its entry in `[[trees]]`; 0 without one.
    pub entry: usize,
    /// What it grows from.
    pub seed: u64,
    /// Tells its leaves from those of other trees that grew from the same seed; 0 for the first tree, whose leaves keep the
    /// ids that they have without `[[trees]]`.
    pub key: u64,
    /// Where its trunk meets the ground: x and z, metres.
    pub place: [f64; 2],
    /// Height of the ground there, metres; 0 until it is known what it stands on.
    pub height: f64,
    /// Turn about the vertical, degrees.
    pub turn: f64,
}

impl Standing {
    /// An identity of the tree that it grew from, made this tree's own.
    #[must_use]
    pub fn own(&self, id: u64) -> u64 {
        if self.key == 0 { id } else { hash(self.key, id) }
    }
}

/// The keys of an entry; `age` takes what `tree.age` takes.
pub(super) fn schema() -> Schema {
    let mut schema = Planting::schema();
    let age = tree::Settings::schema().keys.into_iter().find(|key| key.name == "age");
    schema.keys.extend(age.map(|age| Key { doc: format!("As tree.age: {}", age.doc), ..age }));
    schema
}

/// What is wrong with a well-typed entry.
pub(super) fn check(planting: &Planting) -> Vec<Complaint> {
    let of_groves = [
        ("area", planting.area.is_some()),
        ("spacing", planting.spacing.is_some()),
        ("forms", planting.forms.is_some()),
    ];
    let alone = of_groves.into_iter().filter(|(_, given)| *given && planting.count.is_none());
    let complaint = |(key, _)| Complaint::new(key, format!("`{key}` is for groves"), "add `count`, or take it away");
    alone.map(complaint).collect()
}

/// The number of the entry with which the scene has too many trees, and the complaint.
pub(super) fn check_count(trees: &[Planted]) -> Option<(usize, Complaint)> {
    let mut count = 0;
    let too_many = |planted: &Planted| {
        count += u64::from(planted.planting.count.unwrap_or(1));
        count > MOST_TREES
    };
    let entry = trees.iter().position(too_many)?;
    let what = format!("with this the scene has more than {MOST_TREES} trees");
    Some((entry, Complaint::new("count", what, "plant fewer")))
}

/// A grove has no room for all of its trees.
#[derive(Clone, Debug, PartialEq)]
pub struct Crowded {
    /// Number of the entry in `[[trees]]`.
    pub entry: usize,
    /// Trees that found room.
    pub placed: usize,
    /// Trees that it asks for.
    pub count: u32,
    /// Extent of the area, metres.
    pub area: [f64; 2],
    /// Distance that it asks for, metres.
    pub spacing: f64,
}

impl Crowded {
    /// As a complaint below the entry.
    #[must_use]
    pub fn complaint(&self) -> Complaint {
        let Self { placed, count, area: [width, depth], spacing, .. } = self;
        let what =
            format!("only {placed} of {count} trees find room in {width} by {depth} m with {spacing} m between them");
        Complaint::new("count", what, "plant fewer, lower `spacing`, or enlarge `area`")
    }
}

impl Scene {
    /// Every tree where it stands, in the order of the entries.
    ///
    /// # Errors
    /// A grove in which there is not room for all.
    pub fn standing(&self) -> Result<Vec<Standing>, Crowded> {
        plant(&self.trees, self.seed)
    }
}

/// Plants every entry, in order, for a scene's seed.
pub(super) fn plant(trees: &[Planted], scene_seed: u64) -> Result<Vec<Standing>, Crowded> {
    let mut ground = Trunks::default();
    for (entry, Planted { planting, .. }) in trees.iter().enumerate() {
        let seed = planting.seed.unwrap_or_else(|| derived(scene_seed, entry as u64));
        match planting.count {
            None => {
                let (place, turn) = (planting.place, planting.turn.unwrap_or(0.0));
                ground.add(Standing { entry, seed, key: key(seed, entry, 0), place, height: 0.0, turn });
            }
            Some(count) => ground.sow(planting, (entry, seed), count)?,
        }
    }
    Ok(ground.trees)
}

/// The seed of the `number`th of something; the first one's is the seed itself.
fn derived(seed: u64, number: u64) -> u64 {
    if number == 0 { seed } else { hash(seed, number) }
}

/// The key of a tree: of the entry and the number in it.
fn key(seed: u64, entry: usize, number: u32) -> u64 {
    let first = entry == 0 && number == 0;
    if first { 0 } else { hash(seed, (entry as u64) << 32 | u64::from(number)) | 1 }
}

/// The trees planted so far, and their trunks by cells of the ground.
#[derive(Default)]
struct Trunks {
    trees: Vec<Standing>,
    cells: BTreeMap<[i64; 2], Vec<[f64; 2]>>,
}

/// Sides of the cells, metres.
const CELL: f64 = 4.0;

impl Trunks {
    fn add(&mut self, tree: Standing) {
        self.cells.entry(cell(tree.place)).or_default().push(tree.place);
        self.trees.push(tree);
    }

    fn has_room(&self, place: [f64; 2], spacing: f64) -> bool {
        let [low, high] = [-spacing, spacing].map(|reach| cell(place.map(|x| x + reach)));
        (low[0]..=high[0]).all(|x| {
            let row = self.cells.range([x, low[1]]..=[x, high[1]]);
            let square = |trunk: &[f64; 2]| (0..2).map(|k| (trunk[k] - place[k]) * (trunk[k] - place[k])).sum::<f64>();
            let apart = |trunk: &[f64; 2]| square(trunk) >= spacing * spacing;
            row.flat_map(|(_, trunks)| trunks).all(apart)
        })
    }

    /// Plants a grove.
    fn sow(&mut self, planting: &Planting, (entry, seed): (usize, u64), count: u32) -> Result<(), Crowded> {
        let (area, spacing) = (planting.area.unwrap_or(AREA), planting.spacing.unwrap_or(SPACING));
        let forms = planting.forms.unwrap_or(FORMS);
        let mut tries = MOST_TRIES;
        for number in 0..count {
            let mut chance = Stream::new(seed, Purpose::Planting, entry as u64, u64::from(number));
            let mut dart = || std::array::from_fn(|k| planting.place[k] + (chance.uniform() - 0.5) * area[k]);
            let darts = TRIES.min(tries);
            let place = (0..darts).map(|_| (tries -= 1, dart()).1).find(|&place| self.has_room(place, spacing));
            let Some(place) = place else {
                return Err(Crowded { entry, placed: number as usize, count, area, spacing });
            };
            let turn = planting.turn.unwrap_or_else(|| chance.range(0.0, 360.0));
            let key = key(seed, entry, number);
            self.add(Standing { entry, seed: derived(seed, u64::from(number % forms)), key, place, height: 0.0, turn });
        }
        Ok(())
    }
}

fn cell(place: [f64; 2]) -> [i64; 2] {
    place.map(|x| (x / CELL).floor() as i64)
}
