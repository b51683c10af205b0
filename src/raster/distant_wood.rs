//! The edge of a wood on the horizon: what closes a meadow off. Painted on the sky by noise over azimuth and height, in haze;
//! it is scenery, not geometry, and casts no shadow.

use crate::base::maths::{atan2f, mix, smooth_step};
use crate::base::noise::Lattice;
use crate::base::vector::Vec3;
use crate::frame::Ground;
use std::f32::consts::PI;

/// Reflectances between which the crowns vary: dark green, olive, ochre, rust (linear, judged).
const CROWNS: [[f32; 3]; 4] =
    [[0.030, 0.045, 0.018], [0.060, 0.070, 0.022], [0.130, 0.085, 0.022], [0.105, 0.048, 0.020]];

/// Smooth noise in 0..1 with `count` features along the whole horizon, at a share of the way around it.
fn noise(count: u32, around: f32, y: f32, salt: u64) -> f32 {
    Lattice::periodic(salt, [count, 0]).value(around * count as f32, y)
}

/// How much of a ray the wood stops, and the reflectance of what it meets; `pixel` is the angle that a pixel spans.
pub(super) fn met(ground: &Ground, direction: Vec3, pixel: f32) -> (f32, [f32; 3]) {
    let level = (direction.x * direction.x + direction.z * direction.z).sqrt().max(1e-6);
    let height = direction.y / level;
    if ground.wood <= 0.0 || height > ground.wood * 1.6 {
        return (0.0, [0.0; 3]);
    }
    let around = atan2f(-direction.x, -direction.z) / (2.0 * PI) + 0.5;
    let hill = noise(21, around, 0.5, 11);
    // Crowns along the whole horizon, and smaller features on them.
    let outline = [(420, 0.30), (966, 0.26), (2142, 0.20), (5040, 0.14), (11_340, 0.10)];
    let crowns: f32 =
        outline.iter().zip(12..).map(|(&(count, weight), salt)| weight * noise(count, around, 0.5, salt)).sum();
    let top = ground.wood * (0.50 + 0.3 * hill + 0.55 * crowns);
    let covered = 1.0 - smooth_step(top - pixel, top + pixel, height);
    let up = height / ground.wood * 5.0;
    let kind = noise(378, around, up * 0.3, 21) * 0.7 + noise(46, around, 0.5, 22) * 0.3;
    let place = (kind * 1.7 - 0.4).clamp(0.0, 1.0) * (CROWNS.len() - 1) as f32;
    let first = (place as usize).min(CROWNS.len() - 2);
    let rounded = mix(0.45, 1.1, (height / top.max(1e-6)).clamp(0.0, 1.0));
    let clumps = noise(1680, around, up * 1.6, 23) * 0.6 + noise(5460, around, up * 5.0, 24) * 0.4;
    let leaves = rounded * (0.25 + 1.5 * clumps);
    let colour = std::array::from_fn(|k| mix(CROWNS[first][k], CROWNS[first + 1][k], place - first as f32) * leaves);
    (covered, colour)
}
