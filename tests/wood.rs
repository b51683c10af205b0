//! The distant wood as it is seen: which way round it stands, and which of its sides the sun lights.

use leafseason::base::mesh::Mesh;
use leafseason::base::picture::Picture;
use leafseason::base::vector::{Affine, Mat3, Vec2, Vec3};
use leafseason::frame::{
    Background, Camera, Frame, Ground, Instance, Material, Model, Part, Sky, Sun, Texture, ToneMap, UNBALANCED, View,
    Wood,
};
use leafseason::raster;
use std::sync::Arc;

const SIDE: u32 = 96;

/// A texture of 8 by 8 texels that is the same up and down.
fn texture(name: &str, column: impl Fn(usize) -> [f32; 3]) -> Arc<Texture> {
    let code = |value: f32| (128.0 + 127.0 * value) as u8;
    let pixels = (0..64).map(|place| column(place % 8).map(code)).collect();
    Arc::new(Texture { name: name.into(), width: 8, height: 8, pixels: Arc::new(pixels), repeat: true })
}

/// A closed wood under an even sky, and a leaf out of sight that tells its colour; the sun from one side, before the wood.
fn frame(sun: f32, textures: [Arc<Texture>; 3]) -> Frame {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (0.0, 1.0)];
    let mesh = Mesh {
        positions: corners.iter().map(|&(x, y)| Vec3::new(x, y, 0.0)).collect(),
        normals: vec![Vec3::z(); 3],
        uvs: vec![Vec2::zeros(); 3],
        triangles: vec![[0, 1, 2]],
    };
    let behind = Affine { linear: Mat3::identity(), translation: Vec3::new(0.0, 2.0, 60.0) };
    let leaf = Material { transmission: [0.1, 0.3, 0.05], two_sided: true, ..Material::matte("leaf", [0.2, 0.4, 0.1]) };
    // A repeat spans a quarter of the horizon, the picture a twentieth; its middle lies in the texture's third column.
    let wood = Wood { form: 1, crowns: 2, horizons: 3, distance: 60.0, height: 30.0, repeats: 4, bareness: 0.0 };
    let [form, crowns, horizons] = textures;
    Frame {
        meshes: vec![mesh.into()],
        textures: vec![texture("ground", |_| [0.1; 3]), form, crowns, horizons],
        materials: vec![leaf],
        models: vec![Model { name: "leaf".into(), parts: vec![Part { mesh: 0, material: 0 }] }],
        instances: vec![Instance { model: 0, transform: behind, leaf: Some(1) }],
        fallen: 0,
        camera: Camera {
            position: Vec3::new(0.0, 1.6, 8.0),
            target: Vec3::new(0.0, 3.4, 0.0),
            field_of_view: 0.3,
            near: 0.05,
            far: 1000.0,
        },
        sun: Sun { direction: Vec3::new(sun, 0.3, 0.5).normalize(), irradiance: [3.0, 2.9, 2.6] },
        sky: Sky { zenith: [0.3; 3], horizon: [0.3; 3], ..Sky::default() },
        ground: Some(Ground { tile: 1.3, haze: 1e7, wood: Some(wood), ..Ground::default() }),
        background: Background::Sky,
        view: View {
            width: SIDE,
            height: SIDE,
            samples: 1,
            lod_error: 0.0,
            shadow_size: 64,
            exposure: 0.5,
            metered: false,
            balance: UNBALANCED,
            tone_map: ToneMap::None,
            wireframe: None,
        },
    }
}

/// Mean codes of green in the left and in the right half of a picture.
fn halves(picture: &Picture) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for (place, pixel) in picture.pixels.iter().enumerate() {
        sums[usize::from(place as u32 % SIDE >= SIDE / 2)] += f64::from(pixel[1]);
    }
    sums.map(|sum| sum / f64::from(SIDE * SIDE / 2))
}

fn drawn(sun: f32, form: [f32; 3], light: impl Fn(usize) -> f32, horizons: [f32; 3]) -> [f64; 2] {
    let crowns = texture("crowns", |column| [0.5, light(column), 0.0]);
    halves(&raster::draw(&frame(sun, [texture("form", |_| form), crowns, texture("horizons", |_| horizons)])).0)
}

const FACING: [f32; 3] = [1.0, 0.0, 0.0];

#[test]
fn the_edge_runs_from_left_to_right() {
    let [left, right] = drawn(0.0, FACING, |column| if column < 3 { 0.1 } else { 1.0 }, [0.0; 3]);
    assert!(right > 1.5 * left, "{left} {right}");
}

#[test]
fn the_sun_lights_the_side_that_faces_it() {
    let of = |sun: f32, right: f32| drawn(sun, [1.0, right, 0.0], |_| 1.0, [0.0; 3])[0];
    for side in [-1.0, 1.0] {
        assert!(
            of(side, 0.6 * side) > 1.2 * of(-side, 0.6 * side),
            "{} {}",
            of(side, 0.6 * side),
            of(-side, 0.6 * side)
        );
    }
}

#[test]
fn crowns_stand_in_the_shade_of_those_towards_the_sun() {
    let of = |sun: f32, horizons: [f32; 3]| drawn(sun, FACING, |_| 1.0, horizons)[0];
    let (left, right) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    assert!(of(-1.0, right) > 1.5 * of(-1.0, left), "{} {}", of(-1.0, right), of(-1.0, left));
    assert!(of(1.0, left) > 1.5 * of(1.0, right), "{} {}", of(1.0, left), of(1.0, right));
}
