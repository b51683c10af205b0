//! Where a node stands, as glTF says it: translation, unit quaternion, one scale.

use crate::base::maths::cbrt;
use crate::base::vector::{Affine, DMat3};

/// Largest difference that is put down to single precision, relative to the scale.
const TOLERANCE: f64 = 1e-4;

/// A similarity: scale first, then rotation, then translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Metres.
    pub translation: [f32; 3],
    /// Unit quaternion x, y, z, w with w >= 0.
    pub rotation: [f32; 4],
    /// Factor on all three axes, above 0.
    pub scale: f32,
}

impl Placement {
    /// The similarity that a transform is.
    ///
    /// # Errors
    /// The largest entry of the difference relative to the scale, when it exceeds 1e-4; infinity for a transform without
    /// size, with a mirror, or not finite.
    pub fn of(transform: &Affine) -> Result<Self, f64> {
        let linear: DMat3 = transform.linear.map(f64::from);
        let scale = cbrt(linear.determinant());
        if !(scale.is_finite() && scale > 0.0 && transform.translation.iter().all(|x| x.is_finite())) {
            return Err(f64::INFINITY);
        }
        let quaternion = quaternion(&(linear / scale));
        let placement = Self {
            translation: transform.translation.into(),
            rotation: quaternion.map(|x| x as f32),
            scale: scale as f32,
        };
        let residual = ((placement.linear() - linear) / scale).amax();
        if residual <= TOLERANCE { Ok(placement) } else { Err(residual) }
    }

    /// Rotation and scale as a matrix.
    #[must_use]
    pub fn linear(&self) -> DMat3 {
        let [x, y, z, w] = self.rotation.map(f64::from);
        let rotation = DMat3::new(
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y - w * z),
            2.0 * (x * z + w * y),
            2.0 * (x * y + w * z),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z - w * x),
            2.0 * (x * z - w * y),
            2.0 * (y * z + w * x),
            1.0 - 2.0 * (x * x + y * y),
        );
        rotation * f64::from(self.scale)
    }
}

/// The unit quaternion (x, y, z, w) of a rotation matrix, by its largest component (Shepperd, "Quaternion from rotation
/// matrix", Journal of Guidance and Control 1, 1978), so that nothing is divided by a small number.
fn quaternion(m: &DMat3) -> [f64; 4] {
    let (xx, yy, zz) = (m[(0, 0)], m[(1, 1)], m[(2, 2)]);
    // Four times the square of each component.
    let squares = [1.0 + xx - yy - zz, 1.0 - xx + yy - zz, 1.0 - xx - yy + zz, 1.0 + xx + yy + zz];
    let largest = (1..4).fold(0, |best, i| if squares[i] > squares[best] { i } else { best });
    let sum = |i: usize, j: usize| m[(i, j)] + m[(j, i)];
    let difference = |i: usize, j: usize| m[(i, j)] - m[(j, i)];
    let mut q = match largest {
        0 => [squares[0], sum(0, 1), sum(0, 2), difference(2, 1)],
        1 => [sum(0, 1), squares[1], sum(1, 2), difference(0, 2)],
        2 => [sum(0, 2), sum(1, 2), squares[2], difference(1, 0)],
        _ => [difference(2, 1), difference(0, 2), difference(1, 0), squares[3]],
    };
    let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    let sign = if q[3] < 0.0 { -1.0 } else { 1.0 };
    q.iter_mut().for_each(|x| *x *= sign / length);
    q
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::vector::{DVec3, Mat3, Vec3, rotated};
    use proptest::prelude::*;

    fn turned(axis: DVec3, angle: f64, scale: f64) -> Affine {
        let columns = [DVec3::x(), DVec3::y(), DVec3::z()].map(|e| (rotated(e, axis, angle) * scale).map(|x| x as f32));
        Affine { linear: Mat3::from_columns(&columns), translation: Vec3::new(1.0, 2.0, 3.0) }
    }

    proptest! {
        #[test]
        fn the_matrix_comes_back(x in -1.0..1.0, y in -1.0..1.0, z in -1.0..1.0, angle in -7.0..7.0, scale in 1e-3..1e3) {
            let axis = DVec3::new(x, y, z + 2.0).normalize();
            let affine = turned(axis, angle, scale);
            let placement = Placement::of(&affine).unwrap();
            let length: f32 = placement.rotation.iter().map(|q| q * q).sum();
            prop_assert!((length - 1.0).abs() < 1e-6);
            prop_assert!((placement.linear() - affine.linear.map(f64::from)).amax() < 1e-6 * scale);
        }
    }

    #[test]
    fn half_turns_have_their_quaternions() {
        let half = std::f64::consts::PI;
        for (axis, place) in [(DVec3::x(), 0), (DVec3::y(), 1), (DVec3::z(), 2)] {
            let rotation = Placement::of(&turned(axis, half, 2.0)).unwrap().rotation;
            assert!((rotation[place].abs() - 1.0).abs() < 1e-6, "{rotation:?}");
        }
    }

    #[test]
    fn shear_mirrors_and_nothing_are_refused() {
        let with = |linear| Affine { linear, translation: Vec3::zeros() };
        let shear = with(Mat3::new(1.0, 0.1, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0));
        assert!(Placement::of(&shear).unwrap_err() > 0.04);
        let uneven = with(Mat3::new(1.0, 0.0, 0.0, 0.0, 1.1, 0.0, 0.0, 0.0, 1.0));
        assert!(Placement::of(&uneven).unwrap_err() > 0.02);
        assert!(Placement::of(&with(-Mat3::identity())).is_err());
        assert!(Placement::of(&with(Mat3::zeros())).is_err());
        assert!(Placement::of(&with(Mat3::identity() * f32::NAN)).is_err());
    }
}
