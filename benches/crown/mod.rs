//! A crown of known size for the rasteriser alone: 10,000 leaves of 200 triangles, no two alike in place or attitude, about
//! wood of 100,000 triangles.

use leafseason::base::maths::{cos, sin};
use leafseason::base::mesh::Mesh;
use leafseason::base::random::{Purpose, Stream};
use leafseason::base::vector::{Affine, DVec3, Mat3, Vec2, Vec3, rotated};
use leafseason::frame::{
    Background, Camera, Frame, Ground, GroundPart, Instance, Material, Model, Part, Sky, Sun, Texture, ToneMap,
    UNBALANCED, View,
};
use std::f64::consts::TAU;
use std::sync::Arc;

const LEAVES: u64 = 10_000;
/// Quads along the sides of a leaf: 10 x 10 x 2 triangles.
const LEAF_QUADS: (usize, usize) = (10, 10);
/// Quads around and along the wood: 100 x 500 x 2 triangles.
const WOOD_QUADS: (usize, usize) = (100, 500);
/// Radius of the crown and height of its middle, metres.
const CROWN: (f64, f64) = (2.5, 4.5);

/// The frame: 1920 x 1080 pixels of 8 samples.
pub fn frame() -> Frame {
    let wood = Instance { model: 0, transform: Affine::identity(), leaf: None };
    let leaf = |id| Instance { model: 1, transform: place(id), leaf: Some(id) };
    let textures = [texture("bark", 90), texture("leaf", 200), texture("ground", 130)].map(Arc::new).into();
    Frame {
        meshes: [trunk(), blade()].map(Arc::new).into(),
        textures,
        materials: vec![material("bark", 0, 0.0), material("leaf", 1, 0.3)],
        models: vec![model("trunk", 0), model("leaf", 1)],
        instances: std::iter::once(wood).chain((0..LEAVES).map(leaf)).collect(),
        fallen: 0,
        camera: Camera {
            position: Vec3::new(0.0, 1.6, 11.0),
            target: Vec3::new(0.0, 3.6, 0.0),
            field_of_view: 0.7,
            near: 0.05,
            far: 1000.0,
        },
        sun: Sun { direction: Vec3::new(0.5, 0.6, 0.6).normalize(), irradiance: [3.0, 2.8, 2.4] },
        sky: Sky { zenith: [0.1, 0.2, 0.5], horizon: [0.5, 0.6, 0.7], ..Sky::default() },
        ground: Some(Ground { texture: 2, tile: 2.0, haze: 200.0, ..Ground::default() }),
        background: Background::Sky,
        view: View {
            width: 1920,
            height: 1080,
            samples: 8,
            lod_error: 0.3,
            shadow_size: 2048,
            exposure: 1.0,
            metered: false,
            balance: UNBALANCED,
            tone_map: ToneMap::Neutral,
            wireframe: None,
        },
    }
}

/// What the frame holds, for the heading.
pub fn described(frame: &Frame) -> String {
    let [wood, leaf] = [0, 1].map(|mesh: usize| frame.meshes[mesh].triangles.len());
    format!("a crown of {LEAVES} leaves of {leaf} triangles and {wood} of wood")
}

/// A sheet of quads bent into space by `point`, which takes shares of both sides.
fn sheet((columns, rows): (usize, usize), point: impl Fn(f64, f64) -> DVec3) -> Mesh {
    let mut mesh = Mesh::default();
    for (row, column) in (0..=rows).flat_map(|row| (0..=columns).map(move |column| (row, column))) {
        let (u, v) = (column as f64 / columns as f64, row as f64 / rows as f64);
        mesh.positions.push(point(u, v).cast());
        mesh.uvs.push(Vec2::new(u as f32, 1.0 - v as f32));
    }
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let a = (row * (columns + 1) + column) as u32;
        let (b, c, d) = (a + 1, a + columns as u32 + 2, a + columns as u32 + 1);
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
    mesh.recompute_normals();
    mesh
}

/// A curled leaf, 10 cm long.
fn blade() -> Mesh {
    sheet(LEAF_QUADS, |u, v| {
        let half = 0.045 * sin(TAU / 2.0 * (0.05 + 0.9 * v));
        let x = (2.0 * u - 1.0) * half;
        DVec3::new(x, 0.1 * v, 4.0 * x * x + 0.01 * v * v)
    })
}

/// A trunk that thins into the crown.
fn trunk() -> Mesh {
    sheet(WOOD_QUADS, |u, v| {
        let (angle, radius) = (-TAU * u, 0.16 * (1.0 - 0.95 * v));
        DVec3::new(radius * cos(angle), 6.0 * v, radius * sin(angle))
    })
}

/// Evenly in the crown's ball, turned any way.
fn place(id: u64) -> Affine {
    let mut stream = Stream::new(1, Purpose::LeafSite, id, 0);
    let centre = loop {
        let point = DVec3::from_fn(|_, _| stream.range(-1.0, 1.0));
        if point.norm_squared() <= 1.0 {
            break point * CROWN.0 + DVec3::y() * CROWN.1;
        }
    };
    let axis = DVec3::from_fn(|_, _| stream.normal()).normalize();
    let angle = stream.range(0.0, TAU);
    let size = stream.range(0.7, 1.3);
    let column = |unit: DVec3| (rotated(unit, axis, angle) * size).cast::<f32>();
    let linear = Mat3::from_columns(&[column(DVec3::x()), column(DVec3::y()), column(DVec3::z())]);
    Affine { linear, translation: centre.cast() }
}

/// 256 x 256 pixels of a grain about a mean.
fn texture(name: &str, mean: u8) -> Texture {
    let mut stream = Stream::new(2, Purpose::Variant, u64::from(mean), 0);
    let pixels = (0..256 * 256).map(|_| [mean - stream.below(60) as u8, mean / 2, mean / 4]).collect();
    Texture { name: name.to_owned(), width: 256, height: 256, pixels: Arc::new(pixels), repeat: name != "leaf" }
}

fn material(name: &str, texture: u32, transmission: f32) -> Material {
    let is_leaf = transmission > 0.0;
    Material {
        name: name.to_owned(),
        colour: [1.0; 3],
        reflected: Some(texture),
        transmission: [transmission; 3],
        transmitted: is_leaf.then_some(texture),
        back_gain: 1.0,
        behind: None,
        relief: None,
        gloss: 0.04,
        roughness: 0.5,
        two_sided: is_leaf,
        unlit: false,
        ground: GroundPart::None,
    }
}

fn model(name: &str, number: u32) -> Model {
    Model { name: name.to_owned(), parts: vec![Part { mesh: number, material: number }] }
}
