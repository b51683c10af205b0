//! The rasteriser: a [`Frame`] -> pixels, on the processor.
//!
//! 1. `canopy` sums the leaves into a coarse volume and gathers the light inside the crown from it;
//! 2. `shadow` draws the sun's view into a depth map;
//! 3. `bins` sorts clusters of triangles into tiles of the picture, nearest first;
//! 4. `tile` finds, sample by sample, which triangle is seen, with the depths of 8 x 8 blocks to reject what is hidden;
//! 5. `shade` lights what is seen, once a pixel and cluster; `tone` averages and encodes.
//!
//! Not a ray tracer: reflections, caustics and depth of field are not drawn. Tiles run in parallel and do not share
//! anything that is written, so the bytes do not depend on the number of threads. Coverage is decided in fixed point
//! (8 bits below a pixel, top-left rule), so two triangles that share an edge never both miss or both own a sample.

mod atmosphere;
mod backdrop;
mod background;
mod bins;
mod canopy;
mod clip;
mod cluster;
mod contest;
mod coverage;
mod distant_wood;
mod draw;
mod drawn;
mod even;
mod ground;
mod ground_shadow;
mod last;
mod layers;
mod metering;
mod open_sky;
mod phase;
mod projection;
mod quadric;
mod reads;
mod renderer;
mod rooms;
mod samples;
mod setup;
mod shade;
mod shadow;
mod simplify;
mod sky;
mod spread;
mod texture;
mod tile;
mod tone;
mod tube;
mod wireframe;
mod wood_light;

use crate::base::figures::{ErrorFigure, Figures};
use crate::base::noise::Nodes;
use crate::base::picture::Picture;
use crate::frame::Frame;
use atmosphere::Atmosphere;
use bins::{Bins, tiles_across};
use canopy::Canopy;
use cluster::ClusteredMesh;
use distant_wood::Noises;
use drawn::{Drawn, Fingerprints};
use last::{DrawnTile, Last, Same, are_tiles_kept};
use projection::Projection;
use rayon::prelude::*;
use reads::Reads;
use rooms::Rooms;
use shadow::ShadowMap;
use std::cell::RefCell;
use std::ops::Deref;
use std::sync::Arc;
use texture::MipMap;
use tile::Workspace;
use tone::Tone;

pub use coverage::SIDE;
pub use layers::{Drawing, Site, Wanted};
pub use renderer::Renderer;
pub use tone::developed;

/// Everything the tiles read: made once a frame.
struct Shared<'a> {
    frame: &'a Frame,
    /// What is drawn: the frame's instances, then the ground's.
    instances: &'a Drawn<'a>,
    /// What they come to, where it is asked for.
    fingerprints: Fingerprints,
    meshes: Vec<Arc<ClusteredMesh>>,
    textures: Vec<Arc<MipMap>>,
    atmosphere: Atmosphere,
    canopy: Option<Arc<Canopy>>,
    shadow: Option<Arc<ShadowMap>>,
    projection: Projection,
    tone: Tone,
    wanted: Wanted,
}

/// The same for one task, which notes what it reads.
struct Prepared<'a> {
    shared: &'a Shared<'a>,
    reads: RefCell<Reads>,
    /// Of the noises of the ground, about its last place.
    nodes: RefCell<[Nodes; 6]>,
    /// Of those of the horizon.
    horizon: RefCell<Noises>,
}

impl<'a> Prepared<'a> {
    fn new(shared: &'a Shared<'a>) -> Self {
        Self { shared, reads: RefCell::default(), nodes: RefCell::default(), horizon: RefCell::default() }
    }
}

impl<'a> Deref for Prepared<'a> {
    type Target = Shared<'a>;

    fn deref(&self) -> &Shared<'a> {
        self.shared
    }
}

/// Draws a frame by itself; see [`Renderer::draw`].
#[must_use]
pub fn draw(frame: &Frame) -> (Picture, Figures) {
    Renderer::default().draw(frame)
}

impl Renderer {
    /// Draws a frame. Meshes must pass their `check`; `frame.view` has at least one pixel. What was
    /// drawn before changes nothing but the time that it takes.
    #[must_use]
    pub fn draw(&mut self, frame: &Frame) -> (Picture, Figures) {
        let drawing = self.draw_wanted(frame, Wanted::default());
        (drawing.picture, drawing.figures)
    }

    /// Draws a frame with what is wanted beside its picture.
    #[must_use]
    pub fn draw_wanted(&mut self, frame: &Frame, wanted: Wanted) -> Drawing {
        if frame.view.metered {
            let metered = metering::metered(frame, self);
            return self.draw_wanted(&metered, wanted);
        }
        let view = frame.view;
        let meshes = self.meshes(frame);
        let projection = Projection::camera(&frame.camera, view.width, view.height);
        let instances = Drawn::of(frame);
        let lod_error = if view.wireframe.is_some() { 0.0 } else { view.lod_error };
        let whole = ([view.width, view.height], 0..tiles_across(view.height));
        let bins = Bins::new(frame, &instances.all, &meshes, &projection, whole, lod_error);
        let textures = self.textures(frame, &halvings(frame, &meshes, &bins));
        let atmosphere = Atmosphere::new(frame, &textures);
        let tone = Tone::new(&view);
        // Tiles that hold more than their colours are not kept; lines tell the instances of the ground by their numbers.
        let may_be_kept = !wanted.sites && !wanted.radiance && view.wireframe.is_none();
        let is_kept = may_be_kept && !wanted.is_last;
        let last = if may_be_kept { self.last.take() } else { None };
        let same = last.as_ref().and_then(|last| last.same(frame, &instances, (&meshes, &textures)));
        let is_compared = is_kept || same.is_some();
        let fingerprints = if is_compared { instances.fingerprints() } else { Fingerprints::default() };
        let canopy = same.as_ref().and_then(|same| same.canopy(frame, fingerprints));
        let canopy = canopy.unwrap_or_else(|| Canopy::new(frame, &meshes, &textures, &atmosphere).map(Arc::new));
        let shadow = same.as_ref().and_then(|same| same.whole_shadow(frame, fingerprints)).unwrap_or_else(|| {
            let is_kept = is_kept && are_tiles_kept(instances.all.len());
            ShadowMap::new(frame, &meshes, same.as_ref(), is_kept).map(Arc::new)
        });
        let shared = Shared {
            frame,
            instances: &instances,
            fingerprints,
            meshes,
            textures,
            atmosphere,
            canopy,
            shadow,
            projection,
            tone,
            wanted,
        };
        let tiles = match samples::at_once(view.samples) {
            1 => draw_tiles::<1>(&shared, &bins, same.as_ref()),
            4 => draw_tiles::<4>(&shared, &bins, same.as_ref()),
            8 => draw_tiles::<8>(&shared, &bins, same.as_ref()),
            _ => draw_tiles::<16>(&shared, &bins, same.as_ref()),
        };
        let kept = same.as_ref().map_or(0, |same| same.kept(&tiles));
        let mut drawing = drawing(&shared, &bins, &tiles);
        drawing.figures = drawing.figures.with("lod_error_px", lod_error).with("tiles_kept", kept);
        self.last = is_kept.then(|| Last::of(shared, bins, tiles));
        drawing
    }
}

/// What was drawn, put together of its tiles.
fn drawing(shared: &Shared, bins: &Bins, tiles: &[Arc<DrawnTile>]) -> Drawing {
    let Shared { frame, wanted, .. } = shared;
    let (width, height) = (frame.view.width, frame.view.height);
    let size = [width as usize, height as usize];
    let pixels = layers::assembled(size, bins.columns, tiles, |tile| &tile.colours);
    let only = |is_wanted: bool| if is_wanted { size } else { [0; 2] };
    let error: f64 = tiles.iter().map(|tile| tile.pixels.squared_error).sum();
    let drawn: u64 = bins.items.iter().map(|item| item.cluster_in(&shared.meshes).triangles.len() as u64).sum();
    Drawing {
        picture: Picture { width, height, pixels },
        sites: layers::assembled(only(wanted.sites), bins.columns, tiles, |tile| &tile.sites),
        radiance: layers::assembled(only(wanted.radiance), bins.columns, tiles, |tile| &tile.radiance),
        ground_shadow: if wanted.ground_shadow { shared.ground_shadow() } else { Vec::new() },
        figures: figures(shared, error).with("triangles_drawn", drawn),
    }
}

/// How often each texture may be halved at least before what is seen of it blurs.
fn halvings(frame: &Frame, meshes: &[Arc<ClusteredMesh>], bins: &Bins) -> Vec<u32> {
    let mut least = vec![f32::INFINITY; frame.textures.len()];
    for item in &bins.items {
        let footprint = item.pixel * meshes[item.mesh as usize].uv_per_metre;
        let material = &frame.materials[item.material as usize];
        let textures = [material.reflected, material.transmitted, material.behind, material.relief];
        for number in textures.into_iter().flatten() {
            let least = &mut least[number as usize];
            *least = least.min(footprint);
        }
    }
    for number in of_surroundings(frame) {
        least[number as usize] = 0.0;
    }
    frame.textures.iter().zip(least).map(|(texture, footprint)| texture::halvings(texture, footprint)).collect()
}

/// The textures of ground, sky and distance, of which every pixel may show another scale.
fn of_surroundings(frame: &Frame) -> impl Iterator<Item = u32> {
    let ground = frame.ground.iter().map(|ground| ground.texture);
    ground.chain(of_plain_numbers(frame))
}

/// The textures of ground, sky and distance that hold plain numbers.
fn of_plain_numbers(frame: &Frame) -> impl Iterator<Item = u32> {
    let wood =
        frame.ground.iter().filter_map(|ground| ground.wood).flat_map(|wood| [wood.form, wood.crowns, wood.horizons]);
    wood.chain(frame.sky.clouds.iter().map(|clouds| clouds.texture))
}

/// The tiles of the picture: those of the last frame where nothing has changed, the others drawn.
fn draw_tiles<const S: usize>(shared: &Shared, bins: &Bins, same: Option<&Same>) -> Vec<Arc<DrawnTile>> {
    let rooms = Rooms::new(Workspace::<S>::new);
    let known = same.map(|same| same.tiles(shared, bins));
    let draw = |(number, [column, row]): (usize, [usize; 2])| {
        if let Some(tile) = known.as_ref().and_then(|known| known(number)) {
            return tile;
        }
        let prepared = Prepared::new(shared);
        let pixels = rooms.with(|workspace| workspace.draw(&prepared, bins, column, row));
        Arc::new(DrawnTile { pixels, reads: prepared.reads.into_inner() })
    };
    // One tile at a time: a few hold most of the work, and no thread may be left with a long row of them.
    bins.places().into_par_iter().enumerate().with_max_len(1).map(draw).collect()
}

/// The antialiasing error is estimated from the spread of the samples of each pixel: their variance over their number is
/// the squared error that independent samples would have, an upper estimate for a stratified pattern. One sample has no
/// spread, so nothing is claimed. Levels of detail add less: they keep within `lod_error_px` of the full mesh.
fn figures(prepared: &Shared, squared_error: f64) -> Figures {
    let frame = prepared.frame;
    let triangles_of = |model: u32| -> u64 {
        let parts = &frame.models[model as usize].parts;
        parts.iter().map(|part| frame.meshes[part.mesh as usize].triangles.len() as u64).sum()
    };
    let triangles: u64 = prepared.instances.all.iter().map(|instance| triangles_of(instance.model)).sum();
    let pixels = u64::from(frame.view.width) * u64::from(frame.view.height);
    let mut figures = Figures::of(pixels).with("triangles", triangles).with("samples", frame.view.samples);
    if frame.view.samples < 2 {
        return figures;
    }
    figures.error = Some(ErrorFigure {
        metric: "RMSE in linear light before tone mapping, antialiasing".to_owned(),
        value: (squared_error / (3.0 * pixels as f64)).sqrt(),
        unit: "radiance x exposure".to_owned(),
        bound: None,
        how: "spread of each pixel's samples over their number".to_owned(),
    });
    figures
}
