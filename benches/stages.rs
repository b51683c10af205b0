//! How long each stage takes, and how that compares with drawing the picture: `cargo bench`, or `cargo bench -- 21` for as
//! many rounds.
//!
//! Stages run in turn, round after round, so that a slow spell of the machine falls on all of them; the ratio of a stage
//! to the rasteriser is taken within a round. Everything runs on one thread but what says otherwise.

mod crown;
mod timing;

use leafseason::base::blade::Blade;
use leafseason::base::limits::Limits;
use leafseason::base::mesh::Mesh;
use leafseason::base::picture::Picture;
use leafseason::colour::Painted;
use leafseason::compose::{Dropped, Falls, Form, Garment, Stand, Stock, Wardrobe, Ways};
use leafseason::export::Layout;
use leafseason::frame::Frame;
use leafseason::plan::{garments, items};
use leafseason::run::{self, Options};
use leafseason::scene::{self, Scene, Species};
use leafseason::season::LeafStates;
use leafseason::{colour, deform, export, leaf, raster, season, tree};
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;
use timing::{Case, case, consume, report, timed};

/// What ratios are taken to.
const UNIT: &str = "raster";

/// A scene with everything that its stages need from one another.
struct Inputs {
    scene: Scene,
    species: Species,
    stand: Stand,
    worn: Vec<Option<Garment>>,
    blade: Blade,
    shape_jobs: Vec<deform::Job>,
    texture_jobs: Vec<colour::Job>,
    /// The species' colours at 1,024 px, and its blade laid out for them.
    fine: colour::Settings,
    canvas: colour::Canvas,
    wardrobe: Wardrobe,
    stock: Stock,
    falls: Falls,
    frame: Frame,
    /// The frame with its litter.
    strewn: Frame,
    picture: Picture,
}

fn main() {
    let rounds = timing::rounds();
    let inputs = Inputs::new(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/maple.toml"));
    report("scenes/maple.toml", UNIT, &timed(&inputs.cases(), rounds));
    let frame = crown::frame();
    let draw = |name, threads| Case { name, threads, work: Box::new(|| consume(raster::draw(&frame))) };
    report(&crown::described(&frame), UNIT, &timed(&[draw(UNIT, 1), draw("raster", 2)], rounds));
}

impl Inputs {
    fn new(path: &Path) -> Self {
        let limits = Limits::default();
        let (scene, _) = scene::read(path, &[], &[], &limits).expect("a scene");
        let plan = run::plan(&scene, &Options::default()).expect("a plan");
        let worn_garments: Vec<Garment> =
            plan.garments.iter().chain(&plan.painted).copied().collect::<BTreeSet<_>>().into_iter().collect();
        let species = scene.species[0].clone();
        let (tree, _) = tree::grow(&species.tree, scene.seed, &limits).expect("a tree");
        let standing = scene.standing().expect("room").into_iter().map(|tree| (0, tree)).collect();
        let stand = Stand::new(vec![Form::new(0, tree)], standing);
        let states = states(&scene, &stand.leaf_ids);
        let (blade, _) = leaf::model(&species.leaf, leaf::Pictures::default(), &limits).expect("a blade");
        let shape_jobs = shape_jobs(&scene, &states.names, &worn_garments);
        let texture_jobs = texture_jobs(&scene, &states.names, &worn_garments);
        let fine = colour::Settings { size: Some(1024), ..species.colour.clone() };
        let canvas = colour::Canvas::new(&fine, &blade, &colour::Scans::new());
        let worn = garments(&scene, &stand, &states);
        let shapes = bent(&scene, &blade, &shape_jobs);
        let textures = colour::paint(&species.colour, &blade, &texture_jobs, scene.seed).0;
        let falls = falls(&scene, &stand, &states);
        let mut wardrobe = wardrobe(&scene, states.names, &worn_garments, &shapes, &textures);
        wardrobe.fallen = plan.fallen;
        let stock = Stock::new(&scene, &stand, &wardrobe);
        let frame = stock.frame(&scene, &stand, &worn);
        let strewn = stock.strewn(&scene, &stand, &falls, frame.clone()).0;
        let picture = raster::draw(&frame).0;
        Self {
            scene,
            species,
            stand,
            worn,
            blade,
            shape_jobs,
            texture_jobs,
            fine,
            canvas,
            wardrobe,
            stock,
            falls,
            frame,
            strewn,
            picture,
        }
    }

    fn cases(&self) -> Vec<Case<'_>> {
        let Self { scene, species, stand, blade, frame, .. } = self;
        let limits = Limits::default();
        let grow = move || consume(tree::grow(&species.tree, scene.seed, &limits));
        let aged = tree::Settings { age: Some(25.0), ..species.tree.clone() };
        let old = move || consume(tree::grow(&aged, scene.seed, &Limits::default()));
        let limits = Limits::default();
        let model = move || consume(leaf::model(&species.leaf, leaf::Pictures::default(), &limits));
        vec![
            case("tree", grow),
            case("tree, 25 years", old),
            case("season", || consume(states(scene, &stand.leaf_ids))),
            case("leaf", model),
            case("deform", || consume(bent(scene, blade, &self.shape_jobs))),
            case("colour", || consume(colour::paint(&species.colour, blade, &self.texture_jobs, scene.seed))),
            case("colour, canvas of 1,024 px", || {
                consume(colour::Canvas::new(&self.fine, blade, &colour::Scans::new()));
            }),
            case("colour, one texture of 1,024 px", || {
                consume(colour::paint_on(&self.canvas, &self.fine, &self.texture_jobs[..1], scene.seed));
            }),
            case("compose", || consume(Stock::new(scene, stand, &self.wardrobe).frame(scene, stand, &self.worn))),
            // without leaves in between, what lies as it lay would not be laid anew
            case("fall", || {
                consume(self.stock.strewn(scene, stand, &Falls::default(), frame.clone()));
                consume(self.stock.strewn(scene, stand, &self.falls, frame.clone()));
            }),
            case("fall, as before", || consume(self.stock.strewn(scene, stand, &self.falls, frame.clone()))),
            case(UNIT, || consume(raster::draw(frame))),
            case("raster, with litter", || consume(raster::draw(&self.strewn))),
            Case { threads: 2, ..case("raster", || consume(raster::draw(frame))) },
            case("png", || consume(export::png(&self.picture))),
            case("gltf nodes", || consume(export::glb(frame, Layout::Nodes))),
            case("gltf merged", || consume(export::glb(frame, Layout::Merged))),
            case("gltf instanced", || consume(export::glb(frame, Layout::Instanced))),
        ]
    }
}

/// What has become of the leaves that have fallen.
fn falls(scene: &Scene, stand: &Stand, states: &LeafStates) -> Falls {
    let fallen = states.names.iter().position(|name| name == "fallen");
    let places = (0..states.states.len()).filter(|&site| Some(usize::from(states.states[site])) == fallen);
    let drop = |site: usize| Dropped { site, year: 0, day: states.since[site], state: states.before[site] };
    let dropped: Vec<Dropped> = places.map(drop).collect();
    let attached = (states.states.len() - dropped.len()) as u64;
    Falls::new((scene, stand, &states.names), &dropped, attached, scene.time.at(0), &mut Ways::default())
}

fn states(scene: &Scene, ids: &[u64]) -> LeafStates {
    let mut leaves = season::Population::new(&scene.species[0].season, &scene.weather, scene.seed);
    let position = season::Position { height: 0.0, distance: 0.0, limb: 0, shoot: 0 };
    leaves.add(None, None, ids.iter().map(|&id| (id, position)));
    let (day, names) = (scene.time.at(0), leaves.names().to_vec());
    let expected = leaves.laws(&[day]).swap_remove(0).expected;
    let season::Sample { states, before, since, .. } = leaves.at(day);
    LeafStates { names, states, before, since, expected, shed: Vec::new() }
}

fn shape_jobs(scene: &Scene, states: &[String], worn: &[Garment]) -> Vec<deform::Job> {
    let job = |(state, variant): (u16, u32)| {
        let state = states[usize::from(state)].clone();
        let dryness = scene.species[0].deform.states.get(&state).map_or(0.0, |shape| shape.dryness);
        deform::Job { state, variant, dryness }
    };
    items(worn, scene.species[0].deform.shapes).into_iter().map(job).collect()
}

fn texture_jobs(scene: &Scene, states: &[String], worn: &[Garment]) -> Vec<colour::Job> {
    let job = |(state, variant): (u16, u32)| colour::Job { state: states[usize::from(state)].clone(), variant };
    items(worn, scene.species[0].colour.variants).into_iter().map(job).collect()
}

fn bent(scene: &Scene, blade: &Blade, jobs: &[deform::Job]) -> Vec<Mesh> {
    deform::deform(&scene.species[0].deform, blade, jobs, scene.seed, &Limits::default()).expect("shapes").0
}

/// What each garment is made of; `shapes` and `textures` are in the order of their items.
fn wardrobe(scene: &Scene, states: Vec<String>, worn: &[Garment], shapes: &[Mesh], textures: &[Painted]) -> Wardrobe {
    let place = |garment: &Garment, count: u32| {
        items(worn, count).iter().position(|item| *item == (garment.state, garment.variant % count)).expect("an item")
    };
    let species = &scene.species[0];
    Wardrobe {
        shapes: worn.iter().map(|g| (*g, Arc::new(shapes[place(g, species.deform.shapes)].clone()))).collect(),
        textures: worn.iter().map(|g| (*g, Arc::new(textures[place(g, species.colour.variants)].clone()))).collect(),
        states,
        ..Wardrobe::default()
    }
}
