//! Squared distances to sets of planes (Garland and Heckbert 1997).

use crate::base::vector::DVec3;

/// Squared distance to a set of planes, weighted: x^T A x + 2 b x + c, and the sum of weights.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Quadric {
    a: [f64; 6],
    b: DVec3,
    c: f64,
    weight: f64,
}

impl Quadric {
    /// One plane with a unit normal through a point.
    pub(super) fn plane(normal: DVec3, point: DVec3, weight: f64) -> Self {
        let d = -normal.dot(&point);
        let n = normal;
        let a = [n.x * n.x, n.x * n.y, n.x * n.z, n.y * n.y, n.y * n.z, n.z * n.z].map(|value| value * weight);
        Self { a, b: n * (d * weight), c: d * d * weight, weight }
    }

    /// The planes of both.
    pub(super) fn plus(&self, other: &Self) -> Self {
        Self {
            a: std::array::from_fn(|k| self.a[k] + other.a[k]),
            b: self.b + other.b,
            c: self.c + other.c,
            weight: self.weight + other.weight,
        }
    }

    /// Root mean square distance of a point from the planes.
    pub(super) fn distance(&self, p: DVec3) -> f64 {
        let [xx, xy, xz, yy, yz, zz] = self.a;
        let square = xx * p.x * p.x
            + yy * p.y * p.y
            + zz * p.z * p.z
            + 2.0 * (xy * p.x * p.y + xz * p.x * p.z + yz * p.y * p.z)
            + 2.0 * self.b.dot(&p)
            + self.c;
        (square.max(0.0) / self.weight.max(1e-30)).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_is_the_root_mean_square_of_those_from_each_plane() {
        let one = Quadric::plane(DVec3::x(), DVec3::new(1.0, 5.0, 2.0), 3.0);
        let two = Quadric::plane(DVec3::y(), DVec3::new(0.0, 2.0, 0.0), 1.0);
        let point = DVec3::new(3.0, -2.0, 9.0);
        assert!((one.distance(point) - 2.0).abs() < 1e-12 && (two.distance(point) - 4.0).abs() < 1e-12);
        assert!((one.plus(&two).distance(point) - ((3.0 * 4.0 + 16.0) / 4.0f64).sqrt()).abs() < 1e-12);
    }
}
