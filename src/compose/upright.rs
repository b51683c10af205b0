//! Plants that stand upright on level ground, each turned its own way.

use crate::base::vector::{Affine, Mat3, Vec3};

/// Turn between successive plants of a kind, radians.
pub(super) const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;

/// Where a plant stands (x, z; metres) that is turned by an angle of this sine and cosine and scaled.
pub(super) fn upright([x, z]: [f64; 2], (sine, cosine): (f64, f64), scale: f64) -> Affine {
    let [sine, cosine, scale] = [sine * scale, cosine * scale, scale].map(|value| value as f32);
    Affine {
        linear: Mat3::new(cosine, 0.0, sine, 0.0, scale, 0.0, -sine, 0.0, cosine),
        translation: Vec3::new(x as f32, 0.0, z as f32),
    }
}
