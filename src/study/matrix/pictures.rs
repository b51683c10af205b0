//! Cases of the rasteriser.

use super::bench::SMALL;
use super::{Bench, Case, Seen, case};
use crate::base::picture::Picture;
use crate::base::vector::Vec3;
use crate::export;
use crate::frame::{Frame, ToneMap};
use crate::raster;
use crate::study::fan;
use crate::study::timing::pool;

pub const CASES: &[Case] = &[
    case("R01a", "one sample, one pixel", "a picture of that size", |_| sized(1, 1, 1)),
    case("R01b", "as many samples as there are", "a picture of that size", |_| {
        sized(64, 64, *crate::scene::image::SAMPLES.iter().max().unwrap_or(&1))
    }),
    case("R01c", "16384 pixels in a row of one", "a picture of that size", |_| sized(16_384, 1, 4)),
    case("R01d", "4096 samples, for which there is no pattern", "error that names the key", |bench| {
        bench.render("r01d", SMALL, &["image.samples=4096"]).is_refusal(&["image.samples"])
    }),
    case("R03", "two leaves in one plane", "the same bytes on one thread and two, and again", |_| twins()),
    case("R05a", "the camera inside a leaf", "a finite picture", |_| {
        looking(Vec3::new(0.01, 0.0, 1e-4), Vec3::new(0.01, 0.4, 1e-4))
    }),
    case("R05b", "the camera looking straight up", "a finite picture", |_| {
        looking(Vec3::new(0.0, -2.0, 0.0), Vec3::new(0.0, 2.0, 0.0))
    }),
    case("R05c", "a picture without pixels", "error that names the key", |bench| {
        bench.render("r05c", SMALL, &["image.width=0"]).is_refusal(&["image.width"])
    }),
    case("R05d", "a camera on its target", "error that names the key", |bench| {
        let sets = ["camera.position=[1, 1, 1]", "camera.target=[1, 1, 1]"];
        bench.render("r05d", SMALL, &sets).is_refusal(&["camera.position"])
    }),
    case("R06a", "a texture that is clear everywhere", "error that names the key", |bench| {
        textured(bench, "r06a", 16, 0).is_refusal(&["r06a.toml", "texture"])
    }),
    case("R06b", "a solid texture", "drawn", |bench| textured(bench, "r06b", 16, 255).is_drawn()),
    case("R06c", "a texture of one pixel", "drawn", |bench| textured(bench, "r06c", 1, 255).is_drawn()),
    case("R06d", "a texture that is not there", "error that names the file", |bench| {
        let scene = format!("{SMALL}[leaf]\nvertices = 40\ntexture = \"none.png\"\n");
        bench.render("r06d", &scene, &[]).is_refusal(&["none.png"])
    }),
    case("R07a", "the sun below the horizon", "drawn", |bench| {
        bench.render("r07a", SMALL, &["light.sun_elevation=-20"]).is_drawn()
    }),
    case("R07b", "no light at all", "a black picture where nothing shines", |_| lit(0.0)),
    case("R07c", "light of 1e6", "no overflow: a white picture where the leaves are lit", |_| lit(1e6)),
];

/// The pixels of a frame; whether there are as many as asked for.
fn drawn(frame: &Frame) -> (bool, Picture) {
    let (picture, _) = raster::draw(frame);
    let whole = picture.pixels.len() == frame.view.width as usize * frame.view.height as usize;
    (whole, picture)
}

fn sized(width: u32, height: u32, samples: u32) -> Seen {
    let mut frame = fan::frame();
    (frame.view.width, frame.view.height, frame.view.samples) = (width, height, samples);
    let (whole, picture) = drawn(&frame);
    let is_encoded = export::png(&picture).is_ok();
    (whole && is_encoded, format!("{} x {}", picture.width, picture.height))
}

fn twins() -> Seen {
    let mut frame = fan::frame();
    frame.view.samples = 8;
    let mut other = frame.materials[0].clone();
    (other.name, other.colour) = ("grey".to_owned(), [0.3; 3]);
    frame.materials.push(other);
    let mut model = frame.models[0].clone();
    model.name = "twin".to_owned();
    model.parts[0].material = 1;
    frame.models.push(model);
    let twin = crate::frame::Instance { model: 1, ..frame.instances[0] };
    frame.instances.push(twin);
    let on = |threads: usize| pool(threads).map(|pool| pool.install(|| drawn(&frame).1));
    let all = [on(1), on(2), on(2), on(1)];
    let same = all.iter().all(|picture| picture.is_some() && *picture == all[0]);
    (same, if same { "the same four times".to_owned() } else { "not the same".to_owned() })
}

fn looking(position: Vec3, target: Vec3) -> Seen {
    let mut frame = fan::frame();
    (frame.camera.position, frame.camera.target) = (position, target);
    let (whole, picture) = drawn(&frame);
    (whole && export::png(&picture).is_ok(), format!("{} pixels", picture.pixels.len()))
}

fn textured(bench: &Bench, name: &str, side: u32, alpha: u8) -> super::bench::Ended {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, side, side);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    let data: Vec<u8> = (0..side * side).flat_map(|_| [200, 90, 30, alpha]).collect();
    let _ = encoder.write_header().and_then(|mut writer| writer.write_image_data(&data));
    bench.put(&format!("{name}.png"), &bytes);
    bench.render(name, &format!("{SMALL}[leaf]\nvertices = 40\ntexture = \"{name}.png\"\n"), &[])
}

fn lit(light: f32) -> Seen {
    let mut frame = fan::frame();
    frame.materials[0].unlit = false;
    frame.view.tone_map = ToneMap::Neutral;
    frame.sun = crate::frame::Sun { direction: Vec3::new(0.0, 0.6, 0.8), irradiance: [light; 3] };
    (frame.sky.zenith, frame.sky.horizon) = ([light; 3], [light; 3]);
    let (whole, picture) = drawn(&frame);
    let brightest = picture.pixels.iter().map(|pixel| pixel[0]).max().unwrap_or(0);
    let expected = if light > 0.0 { 255 } else { 0 };
    (whole && brightest == expected, format!("brightest code {brightest}"))
}
