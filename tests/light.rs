//! The light inside a green crown at clear noon, measured from pictures without a tone curve; and what the keys of light and
//! camera do to them.

#[path = "common/drawn.rs"]
mod drawn;

use drawn::drawn;
use leafseason::base::maths::srgb_to_linear;
use leafseason::base::picture::Picture;

const NOON: &str = r#"
species = "red-maple"
seed = 3
time = { day = 0.0 }
tree = { age = 16 }
ground = { wood = false }
light = { sun_elevation = 60.0, sun_azimuth = 45.0, shadow_size = 2048 }
image = { width = 400, height = 400, samples = 1 }
"#;

fn only(text: &str, sets: &[&str]) -> Picture {
    drawn(text, sets).remove(0)
}

/// Luminance of a pixel whose codes are linear light.
fn luminance(pixel: [u8; 4]) -> f64 {
    let [r, g, b] = [0, 1, 2].map(|k| f64::from(srgb_to_linear(f32::from(pixel[k]) / 255.0)));
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Which pixels show leaves alone: those that are white where leaves are, before black.
fn leaves(text: &str) -> Vec<bool> {
    let chart = ["image.leaves=white", "image.background=plain", "image.background_colour=[0,0,0]"];
    only(text, &chart).pixels.iter().map(|pixel| pixel[..3] == [255; 3]).collect()
}

#[test]
fn a_green_crown_at_clear_noon_has_deep_but_not_black_shade() {
    let shown = leaves(NOON);
    let of = |picture: &Picture| -> Vec<[u8; 4]> {
        picture.pixels.iter().zip(&shown).filter(|(_, shown)| **shown).map(|(pixel, _)| *pixel).collect()
    };
    let measured = of(&only(NOON, &["light.tone=none", "light.exposure=1.0"]));
    assert!(measured.len() > 5000, "{}", measured.len());
    let mut light: Vec<f64> = measured.into_iter().map(luminance).collect();
    light.sort_by(f64::total_cmp);
    let quarter = light.len() / 4;
    let (shaded, sunlit) = (mean(&light[..quarter]), mean(&light[3 * quarter..]));
    assert!((4.0..10.0).contains(&(sunlit / shaded)), "sunlit to shaded {}", sunlit / shaded);
    assert!(light[0] > 0.01 * sunlit, "the darkest leaf has {} of {sunlit}", light[0]);
    let pictured = of(&only(NOON, &[]));
    let luma = |p: &[u8; 4]| 0.2126 * f64::from(p[0]) + 0.7152 * f64::from(p[1]) + 0.0722 * f64::from(p[2]);
    let lumas: Vec<f64> = pictured.iter().map(luma).collect();
    assert!((50.0..110.0).contains(&mean(&lumas)), "mean luma {}", mean(&lumas));
    let clipped = pictured.iter().filter(|pixel| pixel[..3].contains(&255)).count() as f64 / pictured.len() as f64;
    assert!(clipped < 0.005, "{clipped} of the foliage is clipped");
}

const SHOOT: &str = r#"
species = "red-maple"
seed = 5
time = { day = 0.0 }
tree = { axiom = "!(0.3)F(0.06)[L(1)][/(180)L(1)]F(0.06)/(90)[L(1)][/(180)L(1)]F(0.02)", rules = [], iterations = 0 }
camera = { position = [0.30, 0.25, 0.40], target = [0.02, 0.09, 0.02], field_of_view = 26.0 }
image = { width = 96, height = 96, samples = 4 }
light = { shadow_size = 512 }
"#;

#[test]
fn a_turntable_begins_with_the_scene_s_own_view_and_comes_around() {
    let run = SHOOT.replace("time = { day = 0.0 }", "time = { from = 0.0, to = 0.03, step = 0.01 }");
    // The grass is laid before the camera of each frame.
    let turned = drawn(&run, &["camera.turn=360"]);
    assert_eq!(turned.len(), 4);
    assert!(turned[0] == only(SHOOT, &[]), "the first frame is the scene's own view");
    assert!((1..4).all(|frame| turned[frame] != turned[frame - 1]));
    assert!(turned[1] == only(SHOOT, &["camera.orbit=90"]), "a quarter of the way");
}

#[test]
fn a_plain_background_changes_nothing_but_what_lies_behind() {
    let shown = leaves(SHOOT);
    // Soil: a blade of grass may stand before a leaf.
    let soil = "ground.kind=soil";
    let [sky, plain] =
        [only(SHOOT, &[soil]), only(SHOOT, &[soil, "image.background=plain", "image.background_colour=[0.2,0.5,0.9]"])];
    let corner = plain.at(0, 0);
    assert!(corner[0].abs_diff(51) < 24 && corner[1].abs_diff(128) < 12 && corner[2].abs_diff(230) < 12, "{corner:?}");
    assert_ne!(corner, sky.at(0, 0));
    let differ = (0..shown.len()).filter(|&k| shown[k] && sky.pixels[k] != plain.pixels[k]).count();
    assert!(shown.iter().filter(|shown| **shown).count() > 60 && differ == 0, "{differ}");
}

#[test]
fn metering_by_the_picture_brings_it_to_middle_grey_whatever_the_light() {
    for light in ["light.sun_elevation=50", "light.sun_elevation=4", "light.clouds=1.0"] {
        let picture = only(SHOOT, &["light.metering=auto", "light.tone=none", light]);
        let logarithms: Vec<f64> = picture.pixels.iter().map(|&p| libm::log(luminance(p).max(1e-4))).collect();
        let middle = libm::exp(mean(&logarithms));
        assert!((0.12..0.24).contains(&middle), "{light}: {middle}");
    }
}

#[test]
fn white_balance_makes_warm_light_less_so_and_exposure_is_in_stops() {
    let reds = |sets: &[&str]| {
        let picture = only(SHOOT, &[&["light.tone=none", "light.exposure=-2"], sets].concat());
        let sum = |k: usize| -> f64 {
            picture.pixels.iter().map(|p| f64::from(srgb_to_linear(f32::from(p[k]) / 255.0))).sum()
        };
        (sum(0) / sum(2), sum(1))
    };
    let (neutral, light) = reds(&[]);
    assert!(
        reds(&["light.white_balance=4500"]).0 < 0.8 * neutral && reds(&["light.white_balance=9000"]).0 > 1.15 * neutral
    );
    let darker = reds(&["light.exposure=-3"]).1;
    assert!((light / darker - 2.0).abs() < 0.05, "{}", light / darker);
}
