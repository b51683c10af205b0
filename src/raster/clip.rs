//! Triangles that reach behind the eye or far beyond the picture, cut to what fixed-point coordinates can hold
//! (Sutherland and Hodgman 1974).

use crate::base::vector::Vec3;

/// Pixels from the upper left corner beyond which triangles are cut: wider than any picture, and small enough that the
/// products of fixed-point coordinates stay far below 2^63.
pub(super) const GUARD: f32 = 2_000_000.0;

/// The signed distances of a mapped point (x w, y w, w) that must not be negative: between the near and the far plane,
/// inside the guard band on four sides.
#[inline(always)]
fn distances(point: Vec3, near: f32, far: f32) -> [f32; 6] {
    let edge = GUARD * point.z;
    [point.z - near, far - point.z, point.x + edge, edge - point.x, point.y + edge, edge - point.y]
}

/// Whether a mapped point needs no cutting.
#[inline(always)]
pub(super) fn is_inside(point: Vec3, near: f32, far: f32) -> bool {
    distances(point, near, far).iter().all(|&distance| distance >= 0.0)
}

/// Whether the corners of a triangle lie beyond one of the planes, all of them.
#[inline(always)]
pub(super) fn is_outside(triangle: &[Vec3; 3], near: f32, far: f32) -> bool {
    let distances = triangle.map(|point| distances(point, near, far));
    (0..6).any(|plane| distances.iter().all(|distances| distances[plane] < 0.0))
}

/// The part of a triangle of mapped points that lies inside, as a convex polygon; empty when nothing does.
pub(super) fn clipped(triangle: [Vec3; 3], near: f32, far: f32) -> Vec<Vec3> {
    let mut polygon = triangle.to_vec();
    for plane in 0..6 {
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (index, &here) in polygon.iter().enumerate() {
            let next = polygon[(index + 1) % polygon.len()];
            let [a, b] = [here, next].map(|point| distances(point, near, far)[plane]);
            if a >= 0.0 {
                kept.push(here);
            }
            if (a >= 0.0) != (b >= 0.0) {
                kept.push(here + (next - here) * (a / (a - b)));
            }
        }
        polygon = kept;
    }
    polygon
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_in_front_is_kept_whole() {
        let triangle = [Vec3::new(0.0, 0.0, 1.0), Vec3::new(50.0, 0.0, 2.0), Vec3::new(0.0, 50.0, 3.0)];
        assert_eq!(clipped(triangle, 0.05, 9.0), triangle.to_vec());
        assert!(triangle.into_iter().all(|p| is_inside(p, 0.05, 9.0)));
    }

    #[test]
    fn a_corner_behind_the_eye_is_cut_off() {
        let triangle = [Vec3::new(0.0, 0.0, -1.0), Vec3::new(50.0, 0.0, 2.0), Vec3::new(0.0, 50.0, 3.0)];
        let polygon = clipped(triangle, 0.05, 9.0);
        assert_eq!(polygon.len(), 4);
        assert!(polygon.iter().all(|p| p.z >= 0.05 * 0.999));
        assert!(clipped([Vec3::new(0.0, 0.0, -1.0); 3], 0.05, 9.0).is_empty());
        let beyond = triangle.map(|p| p + Vec3::z() * 20.0);
        assert!(clipped(beyond, 0.05, 9.0).is_empty() && is_outside(&beyond, 0.05, 9.0));
        assert!(!is_outside(&triangle, 0.05, 9.0));
    }
}
