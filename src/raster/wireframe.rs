//! The edges of triangles as lines of even width, whatever the distance: what a mesh is made of.
//!
//! A line covers a pixel by its distance from the nearest edge as seen in the picture, so lines are smooth at any number of
//! samples. They are blended by square roots of light, near to how a display encodes it: a thin dark line blended in linear
//! light nearly vanishes where it passes between two pixels. A triangle that reaches behind the camera has no lines.

use super::Prepared;
use super::tile::Visible;
use crate::base::maths::mix;
use crate::frame::Wireframe;

/// Lays the lines of a triangle's edges over its radiance at a point of the picture.
pub(super) fn over(
    prepared: &Prepared,
    visible: &Visible,
    triangle: u16,
    at: [f32; 2],
    lines: Wireframe,
    under: [f32; 3],
) -> [f32; 3] {
    if visible.item.instance as usize >= prepared.frame.instances.len() {
        return under;
    }
    let Some(corners) = corners(prepared, visible, triangle) else { return under };
    let nearest = (0..3).map(|i| distance(at, corners[i], corners[(i + 1) % 3])).fold(f32::INFINITY, f32::min);
    let covered = (lines.width * 0.5 + 0.5 - nearest).clamp(0.0, 1.0).min(lines.width);
    let exposure = prepared.frame.view.exposure;
    std::array::from_fn(|k| {
        let root = mix(under[k].max(0.0).sqrt(), (lines.colour[k] / exposure).sqrt(), covered);
        root * root
    })
}

/// Where the corners of a triangle lie in the picture, pixels.
fn corners(prepared: &Prepared, visible: &Visible, triangle: u16) -> Option<[[f32; 2]; 3]> {
    let Visible { cluster, map, .. } = visible;
    let mapped = cluster.triangles[usize::from(triangle)].map(|v| map.point(cluster.positions[usize::from(v)]));
    let near = prepared.projection.near;
    mapped.iter().all(|p| p.z > near).then(|| mapped.map(|p| prepared.projection.screen(p)).map(|s| [s.x, s.y]))
}

/// Distance of a point from a segment.
fn distance(p: [f32; 2], a: [f32; 2], b: [f32; 2]) -> f32 {
    let (side, from) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let squared = side[0] * side[0] + side[1] * side[1];
    let t = if squared > 0.0 { ((from[0] * side[0] + from[1] * side[1]) / squared).clamp(0.0, 1.0) } else { 0.0 };
    let off = [from[0] - side[0] * t, from[1] - side[1] * t];
    (off[0] * off[0] + off[1] * off[1]).sqrt()
}
