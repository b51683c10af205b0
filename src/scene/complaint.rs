//! What the stages' checks complain of.

use super::{Scene, Species, camera, ground, image, light, output, planting};
use crate::base::settings::Complaint;
use crate::{colour, deform, fall, leaf, season, tree};

/// What is wrong with what all trees of a well-typed scene share: the table's name and the complaint.
#[must_use]
pub fn of_scene(scene: &Scene) -> Vec<(String, Complaint)> {
    let mut found = Vec::new();
    let mut take = |table: &str, list: Vec<Complaint>| {
        found.extend(list.into_iter().map(|complaint| (table.to_owned(), complaint)));
    };
    take("camera", camera::check(&scene.camera));
    take("light", light::check(&scene.light));
    take("image", image::check(&scene.image));
    take("output", output::check(&scene.output, &scene.image, &scene.ground));
    take("ground", ground::check(&scene.ground));
    take("fall", fall::check(&scene.fall));
    for (entry, planted) in scene.trees.iter().enumerate() {
        take(&format!("trees.{entry}"), planting::check(&planted.planting));
    }
    found
}

/// What is wrong with where the trees stand, for any of the scene's seeds.
#[must_use]
pub fn of_planting(scene: &Scene) -> Option<(String, Complaint)> {
    let (entry, complaint) = planting::check_count(&scene.trees).or_else(|| {
        let mut seeds = scene.seeds.iter().copied().chain([scene.seed]);
        let crowded = seeds.find_map(|seed| planting::plant(&scene.trees, seed).err())?;
        Some((crowded.entry, crowded.complaint()))
    })?;
    Some((format!("trees.{entry}"), complaint))
}

/// What is wrong with a species' tables.
#[must_use]
pub fn of_species(species: &Species, weather: &season::Weather) -> Vec<(&'static str, Complaint)> {
    let has_season = !species.season.states.is_empty();
    let tables = [
        ("tree", tree::check(&species.tree)),
        ("leaf", leaf::check(&species.leaf)),
        ("deform", deform::check(&species.deform)),
        ("colour", colour::check(&species.colour)),
        ("fall", fall::check_decay(&species.fall)),
        ("season", if has_season { season::check(&species.season, weather) } else { Vec::new() }),
    ];
    tables.into_iter().flat_map(|(table, list)| list.into_iter().map(move |complaint| (table, complaint))).collect()
}
