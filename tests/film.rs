//! Frames drawn one after another by one renderer, which keeps what has not changed: each is what it is by itself.

use leafseason::base::figures::Figures;
use leafseason::base::mesh::Mesh;
use leafseason::base::vector::{Affine, Mat3, Vec2, Vec3};
use leafseason::frame::{
    Background, Camera, Frame, Ground, GroundPart, Instance, Material, Model, Part, Sky, Sun, Texture, ToneMap,
    UNBALANCED, View, Wood,
};
use leafseason::raster::{Renderer, Wanted, draw};
use std::sync::Arc;

const SIZE: [u32; 2] = [512, 384];
/// Standing leaves and, at the end, lying ones.
const STANDING: usize = 40;
const FALLEN: usize = 25;

/// A square of 20 centimetres.
fn square() -> Mesh {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    Mesh {
        positions: corners.iter().map(|&(x, y)| Vec3::new(0.1 * x, 0.1 * y, 0.0)).collect(),
        normals: vec![Vec3::z(); 4],
        uvs: corners.iter().map(|&(x, y)| Vec2::new(x * 0.5 + 0.5, 0.5 - y * 0.5)).collect(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

fn texture(name: &str, pixel: impl Fn(u8) -> [u8; 3]) -> Arc<Texture> {
    let pixels = (0..64).map(pixel).collect();
    Arc::new(Texture { name: name.into(), width: 8, height: 8, pixels: Arc::new(pixels), repeat: true })
}

fn at(x: f32, y: f32, z: f32) -> Affine {
    Affine { linear: Mat3::identity(), translation: Vec3::new(x, y, z) }
}

fn lying(x: f32, z: f32) -> Affine {
    let linear = Mat3::new(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0);
    Affine { linear, translation: Vec3::new(x, 0.02, z) }
}

/// A place from 0 to 1 in each direction.
fn place(number: usize) -> [f32; 2] {
    [(number * 37 % 101) as f32 / 101.0, (number * 61 % 97) as f32 / 97.0]
}

/// Leaves over a meadow with fallen ones before a wood, in the sun.
fn frame() -> Frame {
    let leaf = |name: &str| Material {
        transmission: [0.1, 0.3, 0.05],
        two_sided: true,
        ..Material::matte(name, [0.3, 0.4, 0.1])
    };
    let red = Material { colour: [0.5, 0.1, 0.1], ..leaf("red") };
    let grass = Material { ground: GroundPart::Blades, ..leaf("grass") };
    let materials = vec![leaf("green"), red, leaf("litter"), grass];
    let model = |material: u32| Model { name: format!("model_{material}"), parts: vec![Part { mesh: 0, material }] };
    let hanging = |number: usize| {
        let [x, y] = place(number);
        let transform = at(2.0 * x - 1.0, 1.0 + 2.0 * y, x * y);
        Instance { model: number as u32 % 2, transform, leaf: Some(number as u64) }
    };
    let fallen = |number: usize| {
        let [x, z] = place(number);
        Instance { model: 2, transform: lying(4.0 * x - 2.0, 4.0 * z - 2.0), leaf: Some(1000 + number as u64) }
    };
    let grass = |number: usize| {
        let [x, z] = place(number);
        Instance { model: 3, transform: at(4.0 * x - 2.0, 0.0, 4.0 * z), leaf: None }
    };
    let wood = Wood { form: 1, crowns: 2, horizons: 3, distance: 60.0, height: 9.0, repeats: 9, bareness: 0.2 };
    Frame {
        meshes: vec![square().into()],
        textures: vec![
            texture("ground", |i| [60 + i, 70 + i, 30]),
            texture("form", |i| [100 + 2 * i, 128, 140]),
            texture("crowns", |i| [128 + i, 200, 90 + i]),
            texture("horizons", |i| [128 + i, 190 - i, 150 + i]),
        ],
        materials,
        models: (0..4).map(model).collect(),
        instances: (0..STANDING).map(hanging).chain((0..FALLEN).map(fallen)).collect(),
        fallen: FALLEN,
        camera: Camera {
            position: Vec3::new(0.0, 1.6, 8.0),
            target: Vec3::new(0.0, 1.4, 0.0),
            field_of_view: 0.6,
            near: 0.05,
            far: 1000.0,
        },
        sun: Sun { direction: Vec3::new(0.5, 0.7, 0.4).normalize(), irradiance: [3.0, 2.9, 2.6] },
        sky: Sky { zenith: [0.2, 0.3, 0.6], horizon: [0.5, 0.6, 0.7], ..Sky::default() },
        ground: Some(Ground {
            tile: 1.3,
            haze: 7000.0,
            wood: Some(wood),
            blades: 1.0,
            cover: (0..30).map(grass).collect(),
            ..Ground::default()
        }),
        background: Background::Sky,
        view: View {
            width: SIZE[0],
            height: SIZE[1],
            samples: 4,
            lod_error: 0.3,
            shadow_size: 512,
            exposure: 0.4,
            metered: false,
            balance: UNBALANCED,
            tone_map: ToneMap::Neutral,
            wireframe: None,
        },
    }
}

fn with_ground(frame: &Frame, change: impl Fn(&mut Ground)) -> Frame {
    let mut frame = frame.clone();
    frame.ground.iter_mut().for_each(change);
    frame
}

/// The frame in other states, each changing one thing that tiles may read.
fn others(frame: &Frame) -> Vec<(&'static str, Frame)> {
    let mut decayed = frame.clone();
    decayed.instances.remove(STANDING + 3);
    decayed.fallen -= 1;
    let mut dropped = frame.clone();
    dropped.instances.remove(5);
    let mut turned = frame.clone();
    turned.instances[8].model = 1 - turned.instances[8].model;
    let mut drifted = frame.clone();
    drifted.instances[STANDING + 7].transform = lying(0.1, 0.9);
    let mut painted = frame.clone();
    painted.materials[2].colour = [0.5, 0.2, 0.1];
    let mut repainted = frame.clone();
    repainted.textures[1] = texture("form", |i| [90 + 2 * i, 120, 150]);
    let mut moved = frame.clone();
    moved.camera.position.x += 0.5;
    let mut lower = frame.clone();
    lower.sun.direction = Vec3::new(0.5, 0.5, 0.4).normalize();
    let mut brighter = frame.clone();
    brighter.view.exposure = 0.5;
    let mut bare = frame.clone();
    bare.instances.drain(..STANDING);
    let mut shifted = frame.clone();
    shifted.meshes[0] = Mesh { positions: square().positions.iter().map(|p| p * 1.1).collect(), ..square() }.into();
    vec![
        ("a lying leaf decays", decayed),
        ("a leaf drops", dropped),
        ("a leaf turns", turned),
        ("a lying leaf drifts", drifted),
        ("litter browns", painted),
        ("the wood is another", repainted),
        ("the camera moves", moved),
        ("the sun sinks", lower),
        ("the exposure rises", brighter),
        ("no leaf hangs", bare),
        ("a mesh grows", shifted),
        ("grass rests", with_ground(frame, |ground| ground.dormant = 0.4)),
        ("the wood sheds", with_ground(frame, |ground| ground.wood.iter_mut().for_each(|wood| wood.bareness = 0.6))),
        ("grass is mown", with_ground(frame, |ground| ground.cover.truncate(20))),
    ]
}

/// The states of which no tile can be kept.
const ANEW: [&str; 4] = ["the camera moves", "the sun sinks", "the exposure rises", "the wood is another"];

fn tiles_kept(figures: &Figures) -> u64 {
    figures.values["tiles_kept"].as_u64().unwrap()
}

#[test]
fn each_frame_of_a_film_is_the_frame_by_itself() {
    let first = frame();
    let mut renderer = Renderer::default();
    let alone = draw(&first).0;
    for (what, other) in others(&first) {
        for (frame, expected) in [(&first, &alone), (&other, &draw(&other).0), (&first, &alone)] {
            assert!(renderer.draw(frame).0 == *expected, "{what}");
        }
        assert!(draw(&other).0 != alone, "{what}: nothing is seen of it");
    }
}

/// The frame with other surroundings.
fn kinds() -> Vec<(&'static str, Frame)> {
    let first = frame();
    let with = |change: fn(&mut Frame)| {
        let mut frame = first.clone();
        change(&mut frame);
        frame
    };
    let uneven = |frame: &mut Frame| {
        let slope = |x: f32, z: f32| Vec3::new(x, 0.12 * x - 0.02 * z, z);
        let corners = [slope(-30.0, 30.0), slope(30.0, 30.0), slope(30.0, -30.0), slope(-30.0, -30.0)];
        let up = Vec3::new(-0.12, 1.0, 0.02).normalize();
        let hill = Mesh { positions: corners.to_vec(), normals: vec![up; 4], ..square() };
        frame.meshes.push(hill.into());
        frame.materials.push(Material { ground: GroundPart::Surface, ..Material::matte("hill", [0.3; 3]) });
        frame.models.push(Model { name: "hill".into(), parts: vec![Part { mesh: 1, material: 4 }] });
        let ground = frame.ground.as_mut().unwrap();
        ground.is_uneven = true;
        ground.cover.push(Instance { model: 4, transform: at(0.0, 0.0, 0.0), leaf: None });
    };
    vec![
        ("uneven ground", with(uneven)),
        ("a plain background", with(|f| (f.ground, f.background) = (None, Background::Plain([0.4, 0.5, 0.6])))),
        ("a transparent background", with(|f| (f.ground, f.background) = (None, Background::Transparent))),
        ("no shadow map", with(|f| f.view.shadow_size = 0)),
        ("light of its own", with(|f| f.view.metered = true)),
    ]
}

#[test]
fn each_frame_of_a_film_with_other_surroundings_is_the_frame_by_itself() {
    for (kind, first) in kinds() {
        let mut renderer = Renderer::default();
        let alone = draw(&first).0;
        let mut seen = 0;
        for (what, other) in others(&first).into_iter().filter(|(what, _)| !ANEW.contains(what)) {
            let expected = draw(&other).0;
            seen += usize::from(expected != alone);
            for (frame, expected) in [(&first, &alone), (&other, &expected)] {
                assert!(renderer.draw(frame).0 == *expected, "{kind}: {what}");
            }
        }
        assert!(seen > 3, "{kind}: {seen}");
    }
}

#[test]
fn the_last_frame_of_a_run_reads_what_is_kept_and_leaves_nothing() {
    let first = frame();
    let mut dropped = first.clone();
    dropped.instances.remove(5);
    let mut renderer = Renderer::default();
    let _ = renderer.draw(&first);
    let last = renderer.draw_wanted(&dropped, Wanted { is_last: true, ..Wanted::default() });
    assert!(tiles_kept(&last.figures) > 0 && last.picture == draw(&dropped).0);
    assert_eq!(tiles_kept(&renderer.draw(&dropped).1), 0);
}

#[test]
fn tiles_are_kept_where_nothing_that_they_show_has_changed() {
    let first = frame();
    let kept = |other: &Frame| {
        let mut renderer = Renderer::default();
        let _ = renderer.draw(&first);
        tiles_kept(&renderer.draw(other).1)
    };
    let all = u64::from(SIZE[0].div_ceil(64) * SIZE[1].div_ceil(64));
    assert_eq!(kept(&first.clone()), all);
    for (what, other) in others(&first) {
        let kept = kept(&other);
        assert!(
            if ANEW.contains(&what) { kept == 0 } else { (all / 8..all).contains(&kept) },
            "{what}: {kept} of {all}"
        );
    }
}

#[test]
fn a_frame_drawn_apart_does_not_come_between() {
    let first = frame();
    let mut renderer = Renderer::default();
    let _ = renderer.draw(&first);
    let mut small = first.clone();
    (small.view.width, small.view.height) = (96, 64);
    assert!(renderer.draw_apart(&small, Wanted::default()).picture == draw(&small).0);
    assert!(tiles_kept(&renderer.draw(&first).1) > 0);
}

#[test]
fn what_is_wanted_beside_the_picture_is_not_missing_where_tiles_are_kept() {
    let first = frame();
    let mut renderer = Renderer::default();
    let _ = renderer.draw(&first);
    let wanted = Wanted { sites: true, radiance: true, ..Wanted::default() };
    let (found, expected) = (renderer.draw_wanted(&first, wanted), Renderer::default().draw_wanted(&first, wanted));
    assert!(found.picture == expected.picture && found.sites == expected.sites && found.radiance == expected.radiance);
    assert_eq!(found.sites.len() as u32, SIZE[0] * SIZE[1]);
}
