//! Layers of depth, normal, leaf and state against the file of states, the ground's plane and one another; pictures without a
//! background against pictures before one.

mod common;

use common::{render, small};
use image::{DynamicImage, RgbaImage};
use leafseason::run::Options;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

struct Layers {
    folder: TempDir,
    depth: Vec<u16>,
    normal: Vec<[u8; 3]>,
    leaf: Vec<u32>,
    state: Vec<u8>,
}

fn open(folder: &Path, name: &str) -> DynamicImage {
    image::open(folder.join(name)).unwrap_or_else(|fault| panic!("{name}: {fault}"))
}

fn layers(sets: &[&str]) -> Layers {
    let folder = tempfile::tempdir().unwrap();
    let sets: Vec<&str> = sets.iter().copied().chain(["output.layers=true", "output.gltf=\"nodes\""]).collect();
    let scene = small(&sets);
    let states = Some(folder.path().join("states.csv"));
    let done = render(&scene, &Options { out: folder.path().to_owned(), states, ..Options::default() });
    assert!(done.failed.is_empty());
    let rgb = |kind: &str| open(folder.path(), &format!("small.{kind}.png")).into_rgb8();
    let number = |pixel: &image::Rgb<u8>| pixel.0.iter().fold(0u32, |sum, &byte| sum * 256 + u32::from(byte));
    Layers {
        depth: open(folder.path(), "small.depth.png").into_luma16().into_raw(),
        normal: rgb("normal").pixels().map(|pixel| pixel.0).collect(),
        leaf: rgb("leaf").pixels().map(number).collect(),
        state: open(folder.path(), "small.state.png").into_luma8().into_raw(),
        folder,
    }
}

/// The state of every leaf, in the order of the file of states.
fn states(folder: &Path) -> Vec<String> {
    let text = fs::read_to_string(folder.join("states.csv")).unwrap();
    text.lines().skip(1).map(|line| line.split(',').nth(3).unwrap().to_owned()).collect()
}

#[test]
fn hanging_leaves_have_the_state_that_the_file_of_states_says() {
    let layers = layers(&["time.day=6", "fall.on=false"]);
    let states = states(layers.folder.path());
    let mut named: BTreeMap<u8, &str> = BTreeMap::new();
    let mut seen = 0;
    for (&leaf, &state) in layers.leaf.iter().zip(&layers.state).filter(|(leaf, _)| **leaf > 0) {
        let name = states[leaf as usize - 1].as_str();
        assert_ne!(name, "fallen");
        assert_eq!(*named.entry(state).or_insert(name), name, "one number stands for one state");
        seen += 1;
    }
    assert!(seen > 20 && named.len() > 1, "{seen} pixels of {named:?}");
    assert!(!named.contains_key(&0));
    let other = layers.leaf.iter().zip(&layers.state).filter(|(leaf, _)| **leaf == 0);
    assert!(other.clone().count() > 1000 && other.into_iter().all(|(_, state)| *state == 0));
}

#[test]
fn the_ground_is_as_far_as_its_plane_and_faces_up() {
    let layers = layers(&["camera.position=[0, 2, 6]", "camera.target=[0, 2, 0]", "camera.field_of_view=40"]);
    // A level camera 2 m up sees the ground, y pixels below the horizon, at 2 f / y metres along its axis.
    let focal = 32.0 / leafseason::base::maths::tan(f64::to_radians(20.0));
    for y in [40u32, 50, 60] {
        let place = (y * 96 + 3) as usize;
        assert_eq!((layers.leaf[place], layers.normal[place]), (0, [128, 255, 128]));
        let depths = [0.0, 1.0].map(|edge| 2000.0 * focal / (f64::from(y) - 32.0 + edge));
        let found = f64::from(layers.depth[place]);
        assert!(found <= depths[0] + 1.0 && found >= depths[1] - 1.0, "{found} of {depths:?}");
    }
    assert_eq!((layers.depth[3], layers.normal[3]), (u16::MAX, [128; 3]), "the sky");
}

#[test]
fn uneven_ground_is_as_far_as_its_heights_say() {
    // A slope that rises away from a level camera 3 m up: height 0.1 (6 - z) where it is a plane, with its normal (0, 10, 1).
    let row = |z: i32| format!("[{}]", vec![format!("{}", 0.1 * f64::from(6 - z)); 12].join(","));
    let heights = (-6..6).map(|number| row(2 * number)).collect::<Vec<_>>().join(",");
    let heights = format!("ground.heights=[{heights}]");
    let camera = ["camera.position=[3, 3, 5]", "camera.target=[3, 3, 0]", "camera.field_of_view=40", "ground.step=2.0"];
    let layers = layers(&[&camera[..], &[heights.as_str()]].concat());
    let focal = 32.0 / leafseason::base::maths::tan(f64::to_radians(20.0));
    let mut seen = 0;
    for y in [44u32, 50, 56, 60] {
        // Rows lie at z = 2 n + 1 about the middle: the plane is 0.1 (7 - z).
        let depths = [0.0, 1.0].map(|edge| {
            let fall = (f64::from(y) - 32.0 + edge) / focal;
            // 3 - fall d = 0.1 (7 - (5 - d)) at a distance d along the axis.
            1000.0 * 2.8 / (fall + 0.1)
        });
        let place = (y * 96 + 48) as usize;
        let found = f64::from(layers.depth[place]);
        if layers.leaf[place] == 0 && depths[0] < 9000.0 {
            assert!(found <= depths[0] + 3.0 && found >= depths[1] - 3.0, "row {y}: {found} of {depths:?}");
            let [_, up, near] = layers.normal[place].map(|code| (f64::from(code) - 128.0) / 127.0);
            assert!((near / up - 0.1).abs() < 0.02, "{:?}", layers.normal[place]);
            seen += 1;
        }
    }
    assert!(seen >= 2, "{seen} places");
}

#[test]
fn unit_normals_face_the_eye() {
    let layers = layers(&["camera.position=[0, 1, 9]", "camera.target=[0, 1, 0]", "camera.field_of_view=30"]);
    for normal in layers.normal.iter().zip(&layers.leaf).filter(|(_, leaf)| **leaf > 0).map(|(normal, _)| normal) {
        let [x, y, z] = normal.map(|code| (f64::from(code) - 128.0) / 127.0);
        assert!(((x * x + y * y + z * z).sqrt() - 1.0).abs() < 0.02);
        // Within 15 degrees of the axis a face that is seen turns to +z, but for the smoothing of its normals.
        assert!(z > -0.6, "{normal:?}");
    }
}

fn picture(sets: &[&str]) -> RgbaImage {
    let folder = tempfile::tempdir().unwrap();
    let scene = small(&[sets, &["output.gltf=\"nodes\"", "ground.kind=\"none\"", "light.tone=\"none\""]].concat());
    render(&scene, &Options { out: folder.path().to_owned(), ..Options::default() });
    open(folder.path(), "small.png").into_rgba8()
}

#[test]
fn a_picture_without_background_laid_over_a_colour_is_the_picture_before_it() {
    let open = picture(&["image.background=\"transparent\""]);
    let plain = picture(&["image.background=\"plain\"", "image.background_colour=[1, 1, 1]"]);
    let linear = |code: u8| f64::from(leafseason::base::maths::srgb_to_linear(f32::from(code) / 255.0));
    let mut mixed = 0;
    for (over, before) in open.pixels().zip(plain.pixels()) {
        let alpha = f64::from(over[3]) / 255.0;
        mixed += usize::from(alpha > 0.0 && alpha < 1.0);
        for k in 0..3 {
            let laid = alpha * linear(over[k]) + (1.0 - alpha);
            assert!((laid - linear(before[k])).abs() < 0.012, "{over:?} over white is not {before:?}");
        }
    }
    assert!(mixed > 50, "{mixed} pixels are covered in part");
    assert!(open.pixels().any(|pixel| pixel[3] == 0) && open.pixels().any(|pixel| pixel[3] == 255));
}

/// A scene in the small picture's camera with these outputs, in a folder.
fn drawn(sets: &[&str]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let sets = [sets, &["output.gltf=\"nodes\"", "image.background=\"transparent\"", "ground.kind=\"none\""]].concat();
    let done = render(&small(&sets), &Options { out: folder.path().to_owned(), ..Options::default() });
    assert!(done.failed.is_empty());
    folder
}

#[test]
fn a_picture_of_16_bits_is_that_of_8_bits_in_finer_steps() {
    for tone in ["light.tone=\"neutral\"", "light.tone=\"agx\"", "light.tone=\"none\""] {
        let (deep, usual) = (drawn(&[tone, "output.bits=16"]), drawn(&[tone]));
        let DynamicImage::ImageRgba16(deep) = open(deep.path(), "small.png") else { panic!("not 16 bits with alpha") };
        let usual = open(usual.path(), "small.png").into_rgba8();
        let mut between = 0;
        for (deep, usual) in deep.pixels().zip(usual.pixels()).filter(|(_, usual)| usual[3] > 0) {
            for k in 0..3 {
                // A dithered code is that above or below, and the steps of the table of codes add a little.
                let exact = f64::from(deep[k]) / 257.0;
                assert!((exact - f64::from(usual[k])).abs() < 1.3, "{tone}: {deep:?} is not {usual:?}");
                between += usize::from(deep[k] % 257 > 20);
            }
            assert!((f64::from(deep[3]) / 257.0 - f64::from(usual[3])).abs() < 0.6);
        }
        assert!(between > 100, "{tone}: {between} channels lie between two codes of 8 bits");
    }
}

#[test]
#[cfg(feature = "exr")]
fn linear_light_is_the_picture_without_a_tone_curve() {
    let folder = drawn(&["light.tone=\"none\"", "output.exr=true"]);
    let light = open(folder.path(), "small.exr").into_rgba32f();
    let picture = open(folder.path(), "small.png").into_rgba8();
    for (light, pixel) in light.pixels().zip(picture.pixels()).filter(|(_, pixel)| pixel[3] > 0) {
        for k in 0..3 {
            let code = leafseason::base::maths::linear_to_srgb8(light[k] / light[3]);
            assert!(code.abs_diff(pixel[k]) <= 1, "{light:?} is not {pixel:?}");
        }
    }
}

#[test]
fn the_shadow_laid_on_ground_of_one_colour_darkens_it_where_the_tree_stands_before_the_sun() {
    let folder = drawn(&["output.ground_shadow=true", "camera.position=[0, 6, 9]", "camera.target=[0, 0, 0]"]);
    let shadow = open(folder.path(), "small.shadow.png").into_rgba8();
    assert!(shadow.pixels().all(|pixel| pixel.0[..3] == [0; 3]));
    let alphas: Vec<u8> = shadow.pixels().map(|pixel| pixel[3]).collect();
    let dark = alphas.iter().filter(|&&alpha| alpha > 100).count();
    let open_ground = alphas.iter().filter(|&&alpha| alpha < 8).count();
    assert!(dark > 10 && open_ground > alphas.len() / 4, "{dark} pixels in shadow, {open_ground} in the open");
    let dark_sky = drawn(&["output.ground_shadow=true", "camera.position=[0, 6, 9]", "camera.target=[0, 9, 0]"]);
    let above = open(dark_sky.path(), "small.shadow.png").into_rgba8();
    assert!(above.rows().take(8).flatten().all(|pixel| pixel[3] == 0), "the sky has no shadow");
}
