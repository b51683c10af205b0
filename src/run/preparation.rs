//! What comes before anything costly: the tree, the states of its leaves in every frame, and the plan that follows.

use super::fault;
use super::stopwatch::timed;
use crate::base::diagnostic::Diagnostics;
use crate::base::limits::{Limit, Limits};
use crate::base::random::hash;
use crate::compose::Garment;
use crate::plan::{self, Counted, Plan};
use crate::report::Report;
use crate::scene::Scene;
use crate::season::{self, LeafStates};
use crate::tree::{self, Tree};
use std::collections::BTreeSet;

/// A scene whose tree has grown and whose leaves are counted.
pub struct Prepared {
    /// The tree.
    pub tree: Tree,
    /// The ids of its leaves, in the order of the sites.
    pub leaf_ids: Vec<u64>,
    /// Names of the states; empty without a season.
    pub states: Vec<String>,
    /// What is to be done.
    pub plan: Plan,
}

/// Grows the tree, draws the states of all frames and plans.
///
/// # Errors
/// What the tree's rules or the limits refuse.
pub fn prepare(
    scene: &Scene,
    frames: &[i64],
    limits: &Limits,
    leave_out: bool,
    report: &mut Report,
) -> Result<Prepared, Diagnostics> {
    let grown = timed(report, "tree", || tree::grow(&scene.tree, scene.seed, limits));
    let tree = grown.map_err(|error| fault::tree(scene, &error))?;
    limits
        .allow(Limit::Memory, "the scene", predicted_memory(scene, &tree))
        .map_err(|refusal| fault::refused(scene, "image", &refusal))?;
    let leaf_ids: Vec<u64> = tree.sites.iter().map(|site| site.id).collect();
    let has_season = !scene.season.states.is_empty() && !leaf_ids.is_empty();
    let states: Vec<String> = if has_season { scene.season.states.keys().cloned().collect() } else { Vec::new() };
    let reachable = if has_season { season::reachable(&scene.season, &scene.climate) } else { Vec::new() };
    let counted: Vec<Counted> =
        frames.iter().map(|&index| count(scene, &leaf_ids, has_season, index, report)).collect();
    let plan = plan::plan(scene, &states, &reachable, &counted, leave_out);
    Ok(Prepared { tree, leaf_ids, states, plan })
}

/// The states of all leaves at a frame's time.
pub fn assigned(scene: &Scene, leaf_ids: &[u64], index: i64, report: &mut Report) -> LeafStates {
    let day = scene.time.at(index);
    timed(report, "season", || {
        let made = season::assign(&scene.season, &scene.climate, scene.seed, leaf_ids, day);
        Ok::<_, std::convert::Infallible>(made)
    })
    .unwrap_or_else(|never| match never {})
}

fn count(scene: &Scene, leaf_ids: &[u64], has_season: bool, index: i64, report: &mut Report) -> Counted {
    let day = scene.time.at(index);
    if !has_season {
        return Counted { index, day, ..Counted::default() };
    }
    let states = assigned(scene, leaf_ids, index, report);
    let garments = plan::garments(scene, leaf_ids, &states);
    let mark =
        |garment: &Option<Garment>| garment.map_or(u64::MAX, |g| u64::from(g.state) << 32 | u64::from(g.variant));
    let signature = garments.iter().fold(0, |sum, garment| hash(sum, mark(garment)));
    let worn: BTreeSet<Garment> = garments.into_iter().flatten().collect();
    Counted { index, day, worn, signature }
}

/// Bytes that a run will hold at most, estimated from what grows with the scene: picture and tiles, shadow map, wood,
/// leaves with their places in tiles.
fn predicted_memory(scene: &Scene, tree: &Tree) -> f64 {
    let pixels = f64::from(scene.image.width) * f64::from(scene.image.height);
    let shadow = f64::from(scene.light.shadow_size) * f64::from(scene.light.shadow_size);
    let wood = (tree.bark.positions.len() + tree.twigs.positions.len()) as f64;
    let leaves = tree.sites.len() as f64;
    6e7 + pixels * 30.0 + shadow * 20.0 + wood * 220.0 + leaves * 600.0
}
