//! What memory a run will take, held against the limit before any of it is taken.

use super::growth::{LEAF_BYTES, SITE_BYTES, WOOD_BYTES};
use super::preparation::{KEPT_BYTES, Prepared, SHED_BYTES, STATE_BYTES};
use super::{fault, memory};
use crate::base::diagnostic::Diagnostics;
use crate::base::limits::{Limit, Limits};
use crate::compose::{Form, Garment, Stand};
use crate::scene::output::Gltf;
use crate::scene::{Scene, Species};
use std::collections::BTreeSet;

/// Bytes by the table of the scene that asks for them.
pub type Parts = Vec<(&'static str, f64)>;

/// Most cells of the light volume of a stand, and the memory of one, bytes.
const CANOPY_CELLS: f64 = 300_000.0;
const CANOPY_BYTES: f64 = 200.0;
/// Pixels along the side of the tiles in which the picture and the map of shadows are drawn and kept.
const TILE: f64 = crate::raster::SIDE as f64;
/// Memory of a tile of the picture, bytes: what it looks like, in the last frame and in this.
const TILE_BYTES: f64 = 2.0 * 4.0 * TILE * TILE;
/// Memory of what a tile of the picture noted of each tile of the map of shadows, in the last frame and in this, bytes.
const NOTE_BYTES: f64 = 2.0 * 4.0;
/// Memory of a leaf as it was drawn in the last frame, with its places in the picture and in the map of shadows, bytes.
const DRAWN_BYTES: f64 = 280.0;
/// Memory of a fallen leaf, bytes.
const FALL_BYTES: f64 = 700.0;
/// Memory of a line of the file of states, bytes.
const LINE_BYTES: f64 = 64.0;
/// Memory of a leaf's node while a glTF file is made, bytes (measured: 750), and of an instance's numbers (measured: 60).
const NODE_BYTES: f64 = 900.0;
const INSTANCE_BYTES: f64 = 100.0;

/// Holds what the run will take against the limit, then against what the system has left to give. The cells of a contact
/// sheet are drawn one after another, but what they draw with is kept.
///
/// # Errors
/// More than is allowed, or than there is.
pub fn allow(cells: &[Prepared], (states_frames, enlarged): (usize, u32), limits: &Limits) -> Result<(), Diagnostics> {
    let Some(first) = cells.first() else { return Ok(()) };
    let mut parts = drawing(&first.scene, first.stand.leaf_ids.len(), first.stand.trees.len(), enlarged);
    parts.push(("output", repeated(first)));
    let sites = cells.iter().map(|cell| cell.stand.leaf_ids.len()).sum::<usize>() as f64;
    parts.push(("output", sites * states_frames as f64 * LINE_BYTES));
    cells.iter().for_each(|cell| parts.extend(kept(cell)));
    // the cells of one picture are laid one after another, those of a film keep their fields from frame to frame
    let fields = cells.iter().map(field);
    let are_kept = first.plan.frames.len() > 1;
    parts.push(("fall", if are_kept { fields.sum() } else { fields.fold(0.0, f64::max) }));
    let wanted = parts.iter().map(|(_, bytes)| bytes).sum();
    // the table that asks for most is the one to mend
    let table = parts.iter().max_by(|a, b| a.1.total_cmp(&b.1)).map_or("image", |part| part.0);
    let allowed = limits.allow(Limit::Memory, "the scene", wanted);
    allowed.map_err(|refusal| place(&first.scene, table, &refusal))?;
    if memory::is_granted(wanted) { Ok(()) } else { Err(fault::out_of_memory(&first.scene.places, table, wanted)) }
}

fn place(scene: &Scene, table: &str, refusal: &crate::base::limits::Refusal) -> Diagnostics {
    let has_table = scene.place(table).is_some();
    let places = if has_table { &scene.places } else { &scene.species[0].places };
    fault::refused(places, table, refusal)
}

/// What is taken while a frame of so many leaves and trees is drawn, `enlarged` times as wide and high as the picture. The
/// factors were measured as growth of the peak with each size, and rounded up.
pub fn drawing(scene: &Scene, leaves: usize, trees: usize, enlarged: u32) -> Parts {
    let shadow = f64::from(scene.light.shadow_size) * f64::from(scene.light.shadow_size) * 16.0;
    let canopy = if trees > 1 { CANOPY_CELLS * CANOPY_BYTES } else { 0.0 };
    vec![
        ("image", 1.2e8 + picture(scene, enlarged) + leaves as f64 * DRAWN_BYTES),
        ("light", shadow + canopy),
        ("output", file(scene, leaves)),
    ]
}

/// What a picture takes that is drawn `enlarged` times as wide and high. It is kept for the next frame in tiles, whole ones at
/// its rims too, with what each of them read of those of the map of shadows.
pub fn picture(scene: &Scene, enlarged: u32) -> f64 {
    let tiles = |size: u32| (f64::from(size) / TILE).ceil();
    let image = &scene.image;
    let of_shadow = tiles(scene.light.shadow_size) * tiles(scene.light.shadow_size);
    let of_picture = tiles(image.width.saturating_mul(enlarged)) * tiles(image.height.saturating_mul(enlarged));
    image.pixels() * f64::from(enlarged * enlarged) * 16.0 + of_picture * (TILE_BYTES + NOTE_BYTES * of_shadow)
}

/// What the making of a frame's glTF file takes.
fn file(scene: &Scene, leaves: usize) -> f64 {
    let vertices = scene.species.iter().map(|species| species.leaf.vertices).max().unwrap_or(0);
    let of_leaf = match scene.output.gltf {
        Some(Gltf::Merged) => f64::from(vertices) * 120.0,
        Some(Gltf::Nodes) => NODE_BYTES,
        Some(Gltf::Instanced) => INSTANCE_BYTES,
        None => 0.0,
    };
    leaves as f64 * of_leaf
}

/// Files that later frames repeat are kept until the last of them.
fn repeated(cell: &Prepared) -> f64 {
    let repeated: BTreeSet<i64> = cell.plan.frames.iter().filter_map(|frame| frame.same_as).collect();
    let of_frame = cell.scene.image.pixels() * 4.0 + file(&cell.scene, cell.stand.leaf_ids.len()) * 0.5;
    repeated.len() as f64 * of_frame
}

/// What grown trees take.
pub fn stand(stand: &Stand) -> f64 {
    let forms = stand.forms.iter();
    let wood = forms.clone().map(Form::wood_vertices).sum::<usize>() as f64;
    let sites = forms.map(|form| form.sites.len()).sum::<usize>() as f64;
    wood * WOOD_BYTES + sites * SITE_BYTES + stand.leaf_ids.len() as f64 * LEAF_BYTES
}

/// What a cell keeps from frame to frame.
fn kept(cell: &Prepared) -> Parts {
    let Prepared { scene, stand, plan, .. } = cell;
    let mut parts = vec![("tree", self::stand(stand))];
    if plan.has("fall") {
        parts.push(("fall", stand.leaf_ids.len() as f64 * FALL_BYTES));
    }
    let of_leaf = STATE_BYTES + if scene.leaves_fall() { SHED_BYTES } else { 0 };
    let states = plan.frames.len() as f64 * (stand.leaf_ids.len() * of_leaf) as f64;
    parts.push(("time", states.min(KEPT_BYTES as f64)));
    for (number, species) in scene.species.iter().enumerate() {
        let made = |garments: Vec<Garment>, count: u32| crate::plan::items(&garments, count).len() as f64;
        let shapes = made(plan.garments_of(number), species.deform.shapes);
        let textures = made(plan.painted_of(number), species.colour.variants);
        let [shapes, textures] = worn(scene, species, [shapes, textures]);
        parts.extend([("deform", shapes), ("colour", textures)]);
    }
    parts
}

/// What the field of heights takes in which a cell's litter is laid.
fn field(cell: &Prepared) -> f64 {
    let leaves = cell.stand.leaf_ids.len() as f64;
    if cell.plan.has("fall") { crate::fall::most_field_bytes(leaves) } else { 0.0 }
}

/// What the litter takes when all of so many leaves have fallen, if leaves fall: each with its way, and the field of heights
/// that they are laid in.
pub fn litter_at_most(scene: &Scene, leaves: f64) -> f64 {
    if scene.leaves_fall() { leaves * FALL_BYTES + crate::fall::most_field_bytes(leaves) } else { 0.0 }
}

/// What so many shapes and textures of a species take.
fn worn(scene: &Scene, species: &Species, [shapes, textures]: [f64; 2]) -> [f64; 2] {
    let size = f64::from(crate::compose::largest_texture(scene, species));
    [shapes * f64::from(species.leaf.vertices) * 300.0, textures * size * size * 95.0]
}

/// What leaves wear when every state of every species is worn.
pub fn worn_at_most(scene: &Scene) -> f64 {
    let of_species = |species: &Species| {
        let every = |count: u32| species.season.states.len() as f64 * f64::from(count);
        worn(scene, species, [every(species.deform.shapes), every(species.colour.variants)]).iter().sum::<f64>()
    };
    scene.species.iter().map(of_species).sum()
}
