//! Grass before the camera, measured from pictures without a tone curve.

use image::RgbaImage;
use leafseason::base::limits::Limits;
use leafseason::base::maths::srgb_to_linear;
use leafseason::run::{self, Options, progress, signals::Signals};
use leafseason::scene;
use std::fs;

/// A shoot on a meadow, seen from well above it.
const SHOOT: &str = r#"
species = "red-maple"
seed = 3
time = { day = 0.0 }
ground = { wood = false }
camera = { position = [0.0, 11.9, 30.0], target = [0.0, 0.0, 0.0], field_of_view = 24.0 }
light = { sun_elevation = 50.0, sun_azimuth = 40.0, tone = "none" }
image = { width = 320, height = 320, samples = 4 }
[tree]
axiom = "!(0.3)F(0.06)[L(1)]"
rules = []
iterations = 0
"#;

/// The pictures of a scene with assignments, in the order of its frames.
fn drawn(time: &str, sets: &[&str]) -> Vec<RgbaImage> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.toml");
    fs::write(&path, SHOOT.replace("{ day = 0.0 }", time)).expect("the scene is written");
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    let scene = scene::read(&path, &sets, &[], &Limits::default()).unwrap_or_else(|fault| panic!("{fault}")).0;
    let out = folder.path().join("out");
    let options = Options { out: out.clone(), ..Options::default() };
    let mut progress = progress::Progress::new(progress::Mode::None);
    run::render(&scene, &options, &mut progress, &Signals::default()).unwrap_or_else(|fault| panic!("{fault}"));
    let files = fs::read_dir(&out).expect("files").map(|entry| entry.expect("a file").path());
    let mut pictures: Vec<_> = files.filter(|path| path.extension().is_some_and(|end| end == "png")).collect();
    pictures.sort();
    pictures.iter().map(|path| image::open(path).expect("a picture").into_rgba8()).collect()
}

/// Mean of the linear light of rows of a picture, channel by channel, and the spread of its green.
fn light(picture: &RgbaImage, rows: std::ops::Range<u32>) -> ([f64; 3], f64) {
    let pixels = rows.flat_map(|row| (0..picture.width()).map(move |column| picture.get_pixel(column, row).0));
    let linear: Vec<[f64; 3]> =
        pixels.map(|pixel| [0, 1, 2].map(|k| f64::from(srgb_to_linear(f32::from(pixel[k]) / 255.0)))).collect();
    let count = linear.len() as f64;
    let mean: [f64; 3] = std::array::from_fn(|k| linear.iter().map(|pixel| pixel[k]).sum::<f64>() / count);
    let variance = linear.iter().map(|pixel| (pixel[1] - mean[1]) * (pixel[1] - mean[1])).sum::<f64>() / count;
    (mean, variance.sqrt() / mean[1])
}

/// From 12 metres on no blade is drawn: the same ground with and without them.
#[test]
fn blades_are_on_the_average_as_light_as_the_ground_that_they_stand_on() {
    for time in ["{ day = 0.0 }", "{ day = 40.0 }"] {
        let seen_from = |height: &str| drawn(time, &[&format!("camera.position=[0,{height},30]")]).remove(0);
        let [with, without] = ["11.9", "12.1"].map(seen_from);
        let ((one, spread), (other, plain)) = (light(&with, 40..300), light(&without, 40..300));
        for k in 0..3 {
            assert!((one[k] / other[k] - 1.0).abs() < 0.06, "{time} {one:?} {other:?}");
        }
        assert!(spread > 1.03 * plain, "{spread} {plain}");
    }
}

#[test]
fn grass_stands_before_a_camera_on_all_sides_of_its_way() {
    let sets = ["camera.position=[0,1.6,16]", "camera.target=[0,1.5,0]", "camera.turn=360"];
    let frames = drawn("{ from = 0.0, to = 0.03, step = 0.01 }", &sets);
    let spreads: Vec<f64> = frames.iter().map(|picture| light(picture, 200..310).1).collect();
    assert_eq!(spreads.len(), 4);
    for spread in &spreads {
        assert!((spread / spreads[0] - 1.0).abs() < 0.25, "{spreads:?}");
    }
}
