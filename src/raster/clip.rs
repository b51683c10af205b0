//! Triangles that reach behind the eye or far beyond the picture, cut to what fixed-point coordinates can hold
//! (Sutherland and Hodgman 1974).

use super::projection::NEAR;
use crate::base::vector::Vec3;

/// Pixels from the upper left corner beyond which triangles are cut.
pub(super) const GUARD: f32 = 30_000.0;

/// The signed distances that must not be negative: before the near plane, inside the guard band on four sides.
const PLANES: [fn(Vec3) -> f32; 5] =
    [|p| p.z - NEAR, |p| p.x + GUARD * p.z, |p| GUARD * p.z - p.x, |p| p.y + GUARD * p.z, |p| GUARD * p.z - p.y];

/// Whether a mapped point (x w, y w, w) needs no cutting.
pub(super) fn is_inside(point: Vec3) -> bool {
    PLANES.iter().all(|plane| plane(point) >= 0.0)
}

/// The part of a triangle of mapped points that lies inside, as a convex polygon; empty when nothing does.
pub(super) fn clipped(triangle: [Vec3; 3]) -> Vec<Vec3> {
    let mut polygon = triangle.to_vec();
    for plane in PLANES {
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (index, &here) in polygon.iter().enumerate() {
            let next = polygon[(index + 1) % polygon.len()];
            let (a, b) = (plane(here), plane(next));
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
        assert_eq!(clipped(triangle), triangle.to_vec());
        assert!(triangle.into_iter().all(is_inside));
    }

    #[test]
    fn a_corner_behind_the_eye_is_cut_off() {
        let polygon = clipped([Vec3::new(0.0, 0.0, -1.0), Vec3::new(50.0, 0.0, 2.0), Vec3::new(0.0, 50.0, 3.0)]);
        assert_eq!(polygon.len(), 4);
        assert!(polygon.iter().all(|p| p.z >= NEAR * 0.999));
        assert!(clipped([Vec3::new(0.0, 0.0, -1.0); 3]).is_empty());
    }
}
