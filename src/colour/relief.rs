//! The surface's relief as a normal map: main veins lie in grooves of the upper side, the tissue of each areole bulges
//! between its veinlets.

use super::surface::{ORDERS, Surface};
use crate::base::vector::Vec3;

/// Depth of the groove over a vein of each order and its half width, millimetres.
const GROOVES: [(f32, f32); ORDERS] = [(0.22, 0.9), (0.13, 0.6), (0.05, 0.35)];
/// Height of the tissue between veinlets, millimetres.
const BULGE: f32 = 0.02;

/// Unit normals of the blade's upper side as 8-bit codes: x to the right, y up the picture, z out of the leaf, each from
/// -1 (0) to 1 (255). `strength` scales the heights.
pub(super) fn normals(surface: &Surface, strength: f32) -> Vec<[u8; 3]> {
    let size = surface.size;
    let mut heights = vec![0.0f32; size * size];
    for (pixel, &veinlet) in surface.pixels().zip(&surface.veinlets) {
        heights[pixel] = strength * height(surface, pixel, veinlet);
    }
    let at = |x: usize, y: usize| heights[y.min(size - 1) * size + x.min(size - 1)];
    let texel = 1.0 / (size as f32 * surface.millimetre);
    let normal = |pixel: usize| {
        if !surface.inside[pixel] {
            return [128, 128, 255];
        }
        let (x, y) = (pixel % size, pixel / size);
        let dx = at(x + 1, y) - at(x.saturating_sub(1), y);
        let dy = at(x, y + 1) - at(x, y.saturating_sub(1));
        let normal = Vec3::new(-dx, dy, 2.0 * texel).normalize();
        [normal.x, normal.y, normal.z].map(|c| (c * 127.0 + 128.5) as u8)
    };
    (0..size * size).map(normal).collect()
}

/// Height above the blade's plane, millimetres, of a pixel inside, so far from a veinlet.
fn height(surface: &Surface, pixel: usize, veinlet: f32) -> f32 {
    let mut groove = 0.0f32;
    for (order, (depth, half)) in GROOVES.into_iter().enumerate() {
        let near = 1.0 - (surface.veins[order][pixel].max(0.0) / (half * surface.millimetre)).min(1.0);
        groove = groove.max(depth * near * near * (3.0 - 2.0 * near));
    }
    let swell = (veinlet / (0.35 * surface.net.width)).min(1.0);
    BULGE * (2.0 - swell) * swell - groove
}
