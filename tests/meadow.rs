//! Grass before the camera, measured from pictures without a tone curve.

#[path = "common/drawn.rs"]
mod drawn;

use drawn::drawn;
use leafseason::base::maths::srgb_to_linear;
use leafseason::base::picture::Picture;
use std::ops::Range;

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

/// Mean of the linear light of rows of a picture, channel by channel, and its grain: how far neighbours in a row differ in
/// green, relative to the mean.
fn light(picture: &Picture, rows: Range<usize>) -> ([f64; 3], f64) {
    let width = picture.width as usize;
    let linear: Vec<[f64; 3]> = picture.pixels[rows.start * width..rows.end * width]
        .iter()
        .map(|pixel| [0, 1, 2].map(|k| f64::from(srgb_to_linear(f32::from(pixel[k]) / 255.0))))
        .collect();
    let count = linear.len() as f64;
    let mean: [f64; 3] = std::array::from_fn(|k| linear.iter().map(|pixel| pixel[k]).sum::<f64>() / count);
    let steps = linear.chunks(width).flat_map(|row| row.windows(2)).map(|pair| (pair[0][1] - pair[1][1]).abs());
    (mean, steps.sum::<f64>() / count / mean[1])
}

/// From 12 metres on no blade is drawn: the same ground with and without them.
#[test]
fn blades_are_on_the_average_as_light_as_the_ground_that_they_stand_on() {
    for day in [0, 40] {
        let seen_from = |height: &str| {
            drawn(SHOOT, &[&format!("time.day={day}"), &format!("camera.position=[0,{height},30]")]).remove(0)
        };
        let [with, without] = ["11.9", "12.1"].map(seen_from);
        let ((one, grain), (other, plain)) = (light(&with, 40..300), light(&without, 40..300));
        for k in 0..3 {
            assert!((one[k] / other[k] - 1.0).abs() < 0.06, "day {day} {one:?} {other:?}");
        }
        assert!(grain > 1.1 * plain, "day {day} {grain} {plain}");
    }
}
