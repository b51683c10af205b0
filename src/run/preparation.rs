//! What comes before anything costly: the tree, the states of its leaves in every frame, and the plan that follows.

use super::fault;
use super::memory;
use super::stopwatch::timed;
use crate::base::diagnostic::Diagnostics;
use crate::base::limits::{Limit, Limits};
use crate::base::random::hash;
use crate::compose::Garment;
use crate::plan::{self, Counted, Plan};
use crate::report::Report;
use crate::scene::Scene;
use crate::scene::output::Gltf;
use crate::season::{self, LeafStates};
use crate::tree::{self, Tree};
use std::collections::BTreeSet;
use std::time::Instant;

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

/// Grows the tree, draws the states of all frames and plans. When `stop` turns true the frames counted so far are planned.
///
/// # Errors
/// What the tree's rules or the limits refuse.
pub fn prepare(
    scene: &Scene,
    frames: &[i64],
    limits: &Limits,
    leave_out: bool,
    stop: &dyn Fn() -> bool,
    report: &mut Report,
) -> Result<Prepared, Diagnostics> {
    let grown = timed(report, "tree", || tree::grow(&scene.tree, scene.seed, limits));
    let tree = grown.map_err(|error| fault::tree(scene, &error))?;
    let leaf_ids: Vec<u64> = tree.sites.iter().map(|site| site.id).collect();
    let has_season = !scene.season.states.is_empty() && !leaf_ids.is_empty();
    let states: Vec<String> = if has_season { scene.season.states.keys().cloned().collect() } else { Vec::new() };
    let reachable = if has_season { season::reachable(&scene.season, &scene.climate) } else { Vec::new() };
    let frames = frames.iter().take_while(|_| !stop());
    let counted: Vec<Counted> = frames.map(|&index| count(scene, &leaf_ids, has_season, index, report)).collect();
    let plan = plan::plan(scene, &states, &reachable, &counted, leave_out);
    allow_memory(scene, &tree, &plan, limits)?;
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
    let start = Instant::now();
    let states = season::assign(&scene.season, &scene.climate, scene.seed, leaf_ids, day).0;
    report.spend("season", start.elapsed().as_secs_f64());
    let garments = plan::garments(scene, leaf_ids, &states);
    let mark =
        |garment: &Option<Garment>| garment.map_or(u64::MAX, |g| u64::from(g.state) << 32 | u64::from(g.variant));
    let signature = garments.iter().fold(0, |sum, garment| hash(sum, mark(garment)));
    let worn: BTreeSet<Garment> = garments.into_iter().flatten().collect();
    Counted { index, day, worn, signature }
}

/// Holds what the run will take against the limit, then against what the system has left to give.
fn allow_memory(scene: &Scene, tree: &Tree, plan: &Plan, limits: &Limits) -> Result<(), Diagnostics> {
    let parts = predicted_memory(scene, tree, plan);
    let wanted = parts.iter().map(|(_, bytes)| bytes).sum();
    // the table that asks for most is the one to mend
    let table = parts.iter().max_by(|a, b| a.1.total_cmp(&b.1)).map_or("image", |part| part.0);
    let allowed = limits.allow(Limit::Memory, "the scene", wanted);
    allowed.map_err(|refusal| fault::refused(scene, table, &refusal))?;
    if memory::is_granted(wanted) { Ok(()) } else { Err(fault::out_of_memory(scene, table, wanted)) }
}

/// Bytes that a run will hold at most, by the table of the scene that asks for them. The factors were measured as growth
/// of the peak with each size, and rounded up.
fn predicted_memory(scene: &Scene, tree: &Tree, plan: &Plan) -> [(&'static str, f64); 6] {
    let square = |side: u32| f64::from(side) * f64::from(side);
    let wood: f64 = tree.wood.iter().map(|wood| wood.mesh.positions.len() as f64).sum();
    let leaves = tree.sites.len() as f64;
    let vertices = f64::from(scene.leaf.vertices);
    let made = |stage: &str| plan.jobs.iter().filter(|job| job.stage == stage).count() as f64;
    let merged = scene.output.gltf == Some(Gltf::Merged);
    let copies = leaves * if merged { vertices * 120.0 } else { 0.0 };
    [
        ("image", 1.2e8 + scene.image.pixels() * 16.0),
        ("light", square(scene.light.shadow_size) * 12.0),
        ("tree", wood * 220.0 + leaves * 600.0),
        ("deform", made("deform") * vertices * 300.0),
        ("colour", made("colour") * square(scene.colour.size) * 70.0),
        ("output", copies),
    ]
}
