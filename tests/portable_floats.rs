//! Dependencies whose floating-point results reach an output, each pinned to a known answer that must come out on every
//! processor. A dependency that is added to Cargo.toml must be placed in one of the two lists, which asks the question: do
//! its floats reach a picture or a file, and by which operations?

use sha2::{Digest, Sha256};
use std::collections::BTreeSet;

/// Floats of these reach an output. What they compute with, and the test below that pins it.
const FLOATS_REACH_AN_OUTPUT: &[(&str, &str)] = &[
    ("libm", "software transcendentals in plain arithmetic: `transcendentals_are_those_of_libm`"),
    ("nalgebra", "vectors and matrices up to 4 x 4, + - * / sqrt only (no dynamic matrices): `small_matrices`"),
    ("spade", "orientation and circle predicates, exact by adaptive arithmetic: `a_triangulation`"),
    (
        "fearless_simd",
        "+ - * / floor and comparisons of single precision, no fused ones; equal at every width by \
         `raster::coverage::tests::registers_of_any_width_give_the_same_bits`",
    ),
    ("tiny-skia", "scan conversion of outlines, plain arithmetic in single precision: `a_filled_outline`"),
    ("image", "decoding of JPEG by integer transforms: `a_decoded_picture`"),
    ("serde_json", "shortest decimal that reads back as the same float: `decimals_of_floats`"),
    ("toml", "decimals read to the nearest float: `decimals_of_floats`"),
    ("gltf-json", "numbers of a GLB's JSON, written by serde_json: `decimals_of_floats`"),
];

/// No float of these reaches an output.
const NO_FLOATS: &[(&str, &str)] = &[
    ("clap", "arguments only"),
    ("codespan-reporting", "messages only"),
    ("png", "integers"),
    ("rand", "words only; the mapping to floats is ours"),
    ("rand_chacha", "integers; pinned in base::random"),
    ("rayon", "order of work only; every result has its own slot"),
    ("serde", "passes values on"),
    ("sha2", "integers"),
    ("signal-hook", "signals only"),
    ("thiserror", "messages only"),
];

fn digest(words: impl IntoIterator<Item = u64>) -> String {
    let mut hash = Sha256::new();
    for word in words {
        hash.update(word.to_le_bytes());
    }
    hash.finalize().iter().take(8).map(|byte| format!("{byte:02x}")).collect()
}

/// Numbers of every size and sign, the same each time.
fn numbers(count: u64) -> Vec<f64> {
    use leafseason::base::random::{Purpose, Stream};
    let mut stream = Stream::new(1, Purpose::Texture, 0, 0);
    (0..count).map(|_| stream.range(-20.0, 20.0)).collect()
}

#[test]
fn every_dependency_is_placed() {
    let text = include_str!("../Cargo.toml");
    let manifest: toml::Table = text.parse().expect("a manifest");
    let named: BTreeSet<&str> =
        manifest["dependencies"].as_table().expect("a table").keys().map(String::as_str).collect();
    let placed: Vec<&str> = FLOATS_REACH_AN_OUTPUT.iter().chain(NO_FLOATS).map(|(name, _)| *name).collect();
    assert_eq!(named, placed.iter().copied().collect());
    assert_eq!(placed.len(), named.len(), "each stands in one list");
}

#[test]
fn transcendentals_are_those_of_libm() {
    use leafseason::base::maths as m;
    let double = numbers(4000).into_iter().flat_map(|x| {
        [m::sin(x), m::cos(x), m::exp(x), m::ln(x.abs()), m::pow(x.abs(), 0.37), m::atan2(x, 1.5), m::cbrt(x)]
    });
    assert_eq!(digest(double.map(f64::to_bits)), "fade92c17a99d0cc");
    let single = numbers(4000).into_iter().flat_map(|x| {
        let x = x as f32;
        [m::sinf(x), m::cosf(x), m::expf(x), m::lnf(x.abs()), m::powf(x.abs(), 0.37), m::log2f(x.abs()), m::tanf(x)]
    });
    assert_eq!(digest(single.map(|x| u64::from(x.to_bits()))), "c1e1210770abee01");
}

#[test]
fn small_matrices() {
    use leafseason::base::vector::{DMat3, DVec3, Mat3, Vec3};
    let numbers = numbers(3600);
    let words = numbers.chunks_exact(9).flat_map(|x| {
        let matrix = DMat3::from_column_slice(x);
        let vector = DVec3::new(x[0], x[4], x[8]);
        let product = matrix * matrix.transpose() * vector;
        let single: Mat3 = matrix.cast::<f32>();
        let unit: Vec3 = (single * single * vector.cast::<f32>()).normalize();
        let cross = product.cross(&vector).normalize();
        [product.x, cross.y, cross.norm(), f64::from(unit.x), f64::from(unit.y)].map(f64::to_bits)
    });
    assert_eq!(digest(words.collect::<Vec<_>>()), "6d4b2024797b1ecc");
}

#[test]
fn a_triangulation() {
    use spade::{DelaunayTriangulation, Point2, Triangulation};
    let points = numbers(800).chunks_exact(2).map(|p| Point2::new(p[0], p[1])).collect();
    let mesh = DelaunayTriangulation::<Point2<f64>>::bulk_load_stable(points).expect("finite points");
    let words: Vec<u64> =
        mesh.inner_faces().flat_map(|face| face.vertices().map(|vertex| vertex.fix().index() as u64)).collect();
    assert_eq!(digest(words), "ed0b6fa7876db0f8");
}

#[test]
fn a_filled_outline() {
    use tiny_skia::{FillRule, Mask, PathBuilder, Transform};
    let mut path = PathBuilder::new();
    path.move_to(32.0, 32.0);
    for pair in numbers(80).chunks_exact(2) {
        path.line_to(32.0 + pair[0] as f32 * 1.5, 32.0 + pair[1] as f32 * 1.5);
    }
    let mut mask = Mask::new(64, 64).expect("a mask");
    mask.fill_path(&path.finish().expect("a path"), FillRule::Winding, false, Transform::identity());
    assert_eq!(digest(mask.data().iter().map(|&x| u64::from(x))), "ede889de7861b059");
}

#[test]
fn a_decoded_picture() {
    use image::codecs::jpeg::JpegEncoder;
    let pixels: Vec<u8> = numbers(3 * 32 * 24).iter().map(|x| (x * 6.0 + 128.0) as u8).collect();
    let mut file = Vec::new();
    JpegEncoder::new_with_quality(&mut file, 80)
        .encode(&pixels, 32, 24, image::ExtendedColorType::Rgb8)
        .expect("encoded");
    let decoded = image::load_from_memory(&file).expect("decoded").into_rgb8();
    assert_eq!(digest(decoded.as_raw().iter().map(|&x| u64::from(x))), "f2dc4c7f79560aba");
}

#[test]
fn decimals_of_floats() {
    let text = serde_json::to_string(&numbers(2000)).expect("JSON");
    // serde_json's own reader is off by a last digit now and then; no number is read by it on the way to an output.
    let back = text.trim_matches(['[', ']']).split(',').map(|number| number.parse::<f64>().expect("a number"));
    assert!(back.eq(numbers(2000)));
    assert_eq!(digest(text.bytes().map(u64::from)), "f8a675b32189a914");
    let table: toml::Table = format!("x = {text}").parse().expect("TOML");
    let read: Vec<f64> = table["x"].as_array().expect("a list").iter().filter_map(toml::Value::as_float).collect();
    assert!(read == numbers(2000));
}
