//! Vector types: single precision where pixels are drawn, double where shapes are grown and solved.

/// A pair in single precision.
pub type Vec2 = nalgebra::Vector2<f32>;
/// A triple in single precision: positions in metres, directions, linear colours.
pub type Vec3 = nalgebra::Vector3<f32>;
/// Four numbers in single precision: homogeneous positions.
pub type Vec4 = nalgebra::Vector4<f32>;
/// A 3 x 3 matrix in single precision.
pub type Mat3 = nalgebra::Matrix3<f32>;
/// A 4 x 4 matrix in single precision.
pub type Mat4 = nalgebra::Matrix4<f32>;
/// A pair in double precision.
pub type DVec2 = nalgebra::Vector2<f64>;
/// A triple in double precision.
pub type DVec3 = nalgebra::Vector3<f64>;
/// A 3 x 3 matrix in double precision.
pub type DMat3 = nalgebra::Matrix3<f64>;

/// A linear map followed by a translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    /// Rotation and scale.
    pub linear: Mat3,
    /// Translation, metres.
    pub translation: Vec3,
}

impl Affine {
    /// The map that moves nothing.
    #[must_use]
    pub fn identity() -> Self {
        Self { linear: Mat3::identity(), translation: Vec3::zeros() }
    }

    /// The image of a point.
    #[must_use]
    #[inline(always)]
    pub fn point(&self, point: Vec3) -> Vec3 {
        let [[a, b, c], [d, e, f], [g, h, i]] = self.linear.data.0;
        Vec3::new(
            a * point.x + d * point.y + g * point.z + self.translation.x,
            b * point.x + e * point.y + h * point.z + self.translation.y,
            c * point.x + f * point.y + i * point.z + self.translation.z,
        )
    }
}

/// Any unit vector at right angles to `direction` (unit), chosen without a branch that could jump between processors:
/// the axis least aligned with it is projected out.
#[must_use]
pub fn perpendicular(direction: DVec3) -> DVec3 {
    let absolute = direction.abs();
    let axis = if absolute.x <= absolute.y && absolute.x <= absolute.z {
        DVec3::x()
    } else if absolute.y <= absolute.z {
        DVec3::y()
    } else {
        DVec3::z()
    };
    (axis - direction * axis.dot(&direction)).normalize()
}

/// `vector` turned by `angle` (radians) about the unit vector `axis` (Rodrigues).
#[must_use]
pub fn rotated(vector: DVec3, axis: DVec3, angle: f64) -> DVec3 {
    let (sine, cosine) = libm::sincos(angle);
    vector * cosine + axis.cross(&vector) * sine + axis * (axis.dot(&vector) * (1.0 - cosine))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn perpendicular_is_unit_and_at_right_angles() {
        for direction in [DVec3::x(), DVec3::y(), DVec3::z(), DVec3::new(1.0, 2.0, -3.0).normalize()] {
            let side = perpendicular(direction);
            assert!((side.norm() - 1.0).abs() < 1e-12);
            assert!(side.dot(&direction).abs() < 1e-12);
        }
    }

    #[test]
    fn rotation_turns_x_to_y_about_z() {
        let turned = rotated(DVec3::x(), DVec3::z(), std::f64::consts::FRAC_PI_2);
        assert!((turned - DVec3::y()).norm() < 1e-15);
    }
}
