//! A fan of wedges before the camera, whose coverage of every pixel is known in closed form.

use super::linear::Linear;
use crate::base::maths::{atan, sincos};
use crate::base::mesh::Mesh;
use crate::base::vector::{Affine, DVec2, Vec2, Vec3};
use crate::frame::{Background, Camera, Frame, Instance, Material, Model, Part, Sky, Sun, ToneMap, UNBALANCED, View};
use std::f64::consts::TAU;

/// Pixels along each side.
const SIDE: u32 = 96;
/// Wedges; every other is open.
const WEDGES: u32 = 46;
/// Pixels that a metre covers.
const SCALE: f64 = 48.0;
/// Radius of the fan, metres, and its middle off the picture's, so that edges fall on pixels in all ways.
const RADIUS: f64 = 0.93;
const MIDDLE: [f64; 2] = [0.0137, -0.0071];

/// The corners of the wedges, metres.
fn wedges() -> Vec<[DVec2; 3]> {
    let middle = DVec2::from(MIDDLE);
    let at = |number: u32| {
        let (sine, cosine) = sincos(0.1 + TAU * f64::from(number) / f64::from(WEDGES));
        middle + DVec2::new(cosine, sine) * RADIUS
    };
    (0..WEDGES).step_by(2).map(|number| [middle, at(number), at(number + 1)]).collect()
}

/// The fan as a frame: white on black, whatever the light.
#[must_use]
pub fn frame() -> Frame {
    let corner = |p: &DVec2| Vec3::new(p.x as f32, p.y as f32, 0.0);
    let positions: Vec<Vec3> = wedges().iter().flatten().map(corner).collect();
    let count = positions.len();
    let mesh = Mesh {
        normals: vec![Vec3::z(); count],
        uvs: vec![Vec2::zeros(); count],
        triangles: (0..count as u32 / 3).map(|number| [3 * number, 3 * number + 1, 3 * number + 2]).collect(),
        positions,
    };
    let material = Material { roughness: 0.5, two_sided: true, unlit: true, ..Material::matte("white", [1.0; 3]) };
    let distance = 4.0;
    let half = f64::from(SIDE) / 2.0 / SCALE / distance;
    Frame {
        meshes: vec![mesh.into()],
        textures: Vec::new(),
        materials: vec![material],
        models: vec![Model { name: "fan".into(), parts: vec![Part { mesh: 0, material: 0 }] }],
        instances: vec![Instance { model: 0, transform: Affine::identity(), leaf: None }],
        fallen: 0,
        camera: Camera {
            position: Vec3::new(0.0, 0.0, distance as f32),
            target: Vec3::zeros(),
            field_of_view: (2.0 * atan(half)) as f32,
            near: 0.05,
            far: 100.0,
        },
        sun: Sun { direction: Vec3::y(), irradiance: [0.0; 3] },
        sky: Sky { zenith: [0.0; 3], horizon: [0.0; 3], clear: None, clouds: None },
        ground: None,
        background: Background::Sky,
        view: View {
            width: SIDE,
            height: SIDE,
            samples: 1,
            lod_error: 0.0,
            shadow_size: 0,
            exposure: 1.0,
            metered: false,
            balance: UNBALANCED,
            tone_map: ToneMap::None,
            wireframe: None,
        },
    }
}

/// The share of every pixel that the wedges cover.
#[must_use]
pub fn coverage() -> Linear {
    let half = f64::from(SIDE) / 2.0;
    let pixel = |p: DVec2| DVec2::new(half + SCALE * p.x, half - SCALE * p.y);
    let wedges: Vec<[DVec2; 3]> = wedges().iter().map(|corners| corners.map(pixel)).collect();
    let share = |x: u32, y: u32| {
        let low = DVec2::new(f64::from(x), f64::from(y));
        wedges.iter().map(|corners| clipped_area(corners, low)).sum::<f64>() as f32
    };
    let pixels = (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y))).map(|(x, y)| [share(x, y); 3]).collect();
    Linear { width: SIDE, height: SIDE, pixels }
}

/// Area of a triangle within the unit square at `low` (Sutherland and Hodgman 1974).
fn clipped_area(corners: &[DVec2], low: DVec2) -> f64 {
    let mut points = corners.to_vec();
    for (axis, side, bound) in [(0, 1.0, low.x), (0, -1.0, low.x + 1.0), (1, 1.0, low.y), (1, -1.0, low.y + 1.0)] {
        let inside = |p: &DVec2| side * (p[axis] - bound);
        let mut kept = Vec::new();
        for (number, &to) in points.iter().enumerate() {
            let from = points[(number + points.len() - 1) % points.len()];
            let (before, after) = (inside(&from), inside(&to));
            if (before < 0.0) != (after < 0.0) {
                kept.push(from + (to - from) * (before / (before - after)));
            }
            if after >= 0.0 {
                kept.push(to);
            }
        }
        points = kept;
    }
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).map(|(a, b)| a.perp(b)).sum::<f64>().abs() * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_sum_to_the_area_of_the_fan() {
        let sum: f64 = coverage().pixels.iter().map(|pixel| f64::from(pixel[0])).sum();
        let area = f64::from(WEDGES) / 2.0 * 0.5 * RADIUS * RADIUS * libm::sin(TAU / f64::from(WEDGES));
        assert!((sum / (area * SCALE * SCALE) - 1.0).abs() < 1e-5, "{sum}");
    }

    #[test]
    fn the_picture_nears_the_closed_form() {
        let mut frame = frame();
        let errors = [1, 16].map(|samples| {
            frame.view.samples = samples;
            super::super::linear::drawn(&frame).distance(&coverage()).rmse
        });
        assert!(errors[1] < 0.3 * errors[0] && errors[0] < 0.3, "{errors:?}");
    }
}
