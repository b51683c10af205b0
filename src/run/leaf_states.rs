//! The states of all leaves of a stand, species by species: each has its own chain, the leaves their own clocks.

use crate::base::figures::Figures;
use crate::compose::Stand;
use crate::scene::Scene;
use crate::season::{self, LeafStates};

/// State of a leaf whose species has no seasons.
const NO_STATE: u16 = u16::MAX;

/// The names of the states of all species that have leaves, sorted.
pub fn names(scene: &Scene, stand: &Stand) -> Vec<String> {
    let with_leaves = with_leaves(scene, stand).into_iter();
    let mut names: Vec<String> =
        with_leaves.flat_map(|number| scene.species[number].season.states.keys().cloned()).collect();
    names.sort_unstable();
    names.dedup();
    names
}

/// The numbers of the species that have leaves and seasons.
pub fn with_leaves(scene: &Scene, stand: &Stand) -> Vec<usize> {
    let has_leaves = |number: usize| stand.standing().any(|(form, _)| form.species == number && !form.sites.is_empty());
    let has_seasons = |number: &usize| !scene.species[*number].season.states.is_empty();
    (0..scene.species.len()).filter(has_seasons).filter(|&number| has_leaves(number)).collect()
}

/// The state of every leaf at a frame's time, in the order of the stand's ids; `names` are those of [`names`].
pub fn assigned(scene: &Scene, stand: &Stand, names: &[String], index: i64) -> (LeafStates, Figures) {
    let day = scene.time.at(index);
    let leaves = stand.leaf_ids.len();
    let (mut states, mut before, mut since) = (vec![NO_STATE; leaves], vec![NO_STATE; leaves], vec![0.0; leaves]);
    let mut parts = Vec::new();
    for number in with_leaves(scene, stand) {
        let species = &scene.species[number];
        let places: Vec<usize> =
            stand.species_of_leaves().enumerate().filter(|(_, of)| *of == number).map(|(place, _)| place).collect();
        let ids: Vec<u64> = places.iter().map(|&place| stand.leaf_ids[place]).collect();
        let part = season::assign(&species.season, &scene.climate, scene.seed, &ids, day);
        let own = &part.0;
        let common: Vec<u16> =
            own.names.iter().map(|name| names.binary_search(name).map_or(NO_STATE, |place| place as u16)).collect();
        for (leaf, &place) in places.iter().enumerate() {
            states[place] = common[usize::from(own.states[leaf])];
            before[place] = common[usize::from(own.before[leaf])];
            since[place] = own.since[leaf];
        }
        parts.push(part);
    }
    let (expected, figures) = season::mixed(names, &parts);
    (LeafStates { names: names.to_vec(), states, before, since, expected }, figures)
}
