//! The mask map without a painter (the first future work of Tang, Wu and Fan 2013): an 8-bit grey picture over the blade, laid
//! out by the mesh's texture coordinates as a painted one is. Veins are white (heavy, they stay); margin, tips, the petiole's
//! neighbourhood and what lies far from the joint are dark (light, they move), as the paper paints them.
//!
//! With e the depth below the margin (1 at the deepest place), t the tipness, p the nearness of the joint, g the way to the
//! joint and v the nearness of a vein:
//!
//! ```text
//! curl = lamina + margin (1 - e)^1.5 + tips t + petiole p + distance g^2, held to 0..1
//! grey = 255 (1 - curl (1 - v)), blurred
//! ```
//!
//! The vertices' greys are read from the rounded picture, so that the picture given back as a painted mask changes nothing.

mod fields;
mod geodesic;

use crate::base::blade::Vein;
use crate::base::flat_mesh::FlatMesh;
use crate::base::maths::smooth_step;
use crate::base::picture::Picture;
use crate::base::vector::DVec2;
use crate::leaf::field::blurred;
use crate::leaf::grid::Grid;
use crate::settings;
use fields::{Fields, Layout};

/// Pixels along a side of the mask.
pub const SIDE: usize = 512;
/// The blade's greys go on beyond its margin for this many pixels, so that nothing else is read at the mesh's rim.
const SPILL: usize = 8;

/// Share of `vein_ends` within which veins have no white at all, so that the very rim is free.
const STILL_MARGIN: f32 = 0.2;

settings! {
    /// How the mask is derived when none is painted. The first five are weights in the curl, which is 0 where the blade stays
    /// and 1 where it moves most.
    pub struct Mask {
        /// Curl of the whole blade between its veins.
        lamina: f64 = 0.50, range 0.0 => 1.0;
        /// Curl of the margin; it falls off inwards with the power 1.5 of the height above the deepest place.
        margin: f64 = 0.40, range 0.0 => 1.0;
        /// Curl of tips: of places where less than half of a disc about them lies in the blade.
        tips: f64 = 0.35, range 0.0 => 1.0;
        /// Curl about the petiole's joint.
        petiole: f64 = 0.25, range 0.0 => 1.0;
        /// Curl of the place farthest from the joint; it grows with the square of the way from there.
        distance: f64 = 0.15, range 0.0 => 1.0;
        /// Radius of the disc of `tips`.
        tip_radius: f64 = 0.12, unit "square roots of the blade's area", range 0.01 => 0.5;
        /// Radius of the neighbourhood of the joint.
        petiole_reach: f64 = 0.15, unit "square roots of the blade's area", range 0.01 => 1.0;
        /// Whiteness of veins: 1 holds them still, 0 ignores them.
        veins: f64 = 1.0, range 0.0 => 1.0;
        /// How far the white of a main vein reaches, that of secondaries 0.7 of it. The default is a third of the edges of a
        /// mesh of 220 vertices, so that veins do not slip between them.
        vein_reach: f64 = 0.024, unit "square roots of the blade's area", range 0.001 => 0.2;
        /// Depth below the margin, as a share of the deepest place, at which veins have their full white: their ends move.
        vein_ends: f64 = 0.12, range 0.0 => 1.0;
        /// Deviation of the final blur.
        blur: f64 = 0.005, unit "square roots of the blade's area", range 0.0 => 0.1;
    }
}

/// Draws the mask of a blade: its outline and the outlines of its holes (metres, in the mesh's plane, either sense), its
/// veins, and the mesh for the layout. Grey, opaque; black where there is no blade.
#[must_use]
pub fn drawn(mesh: &FlatMesh, outline: &[DVec2], holes: &[&[DVec2]], veins: &[Vein], law: &Mask) -> Picture {
    let layout = Layout::new(mesh, outline);
    let fields = Fields::new(&layout, outline, holes, law);
    let white = fields::whiteness(&layout, veins, law.vein_reach * layout.size);
    let raw = |cell: usize| if fields.inside.cells[cell] { grey(law, &fields, white.cells[cell], cell) } else { 0.0 };
    let greys = Grid { width: SIDE, height: SIDE, cells: (0..SIDE * SIDE).map(raw).collect() };
    let smooth = smoothed(&greys, &fields.inside, law.blur * layout.size);
    let code = |value: f32| {
        let grey = (value.clamp(0.0, 255.0) + 0.5) as u8;
        [grey, grey, grey, 255]
    };
    Picture { width: SIDE as u32, height: SIDE as u32, pixels: smooth.cells.into_iter().map(code).collect() }
}

/// The law, for one cell.
fn grey(law: &Mask, fields: &Fields, white: f32, cell: usize) -> f32 {
    let outwards = 1.0 - f64::from(fields.depth.cells[cell]);
    let far = f64::from(fields.way.cells[cell]);
    let curl = law.lamina
        + law.margin * outwards * outwards.sqrt()
        + law.tips * f64::from(fields.tipness.cells[cell])
        + law.petiole * f64::from(fields.nearness.cells[cell])
        + law.distance * far * far;
    let ends = law.vein_ends as f32;
    let full = smooth_step(STILL_MARGIN * ends, ends.max(1e-6), fields.depth.cells[cell]);
    let vein = law.veins * f64::from(white * full);
    (255.0 * (1.0 - curl.clamp(0.0, 1.0) * (1.0 - vein))) as f32
}

/// Blurred within the blade (normalised convolution), and spilt a little over its margin.
fn smoothed(greys: &Grid<f32>, inside: &Grid<bool>, deviation: f64) -> Grid<f32> {
    let weight = inside.map(|c| f32::from(u8::from(c)));
    let (sum, share) = if deviation > 0.2 {
        (blurred(greys, deviation), blurred(&weight, deviation))
    } else {
        (greys.clone(), weight)
    };
    let mean = |i: usize| if inside.cells[i] { sum.cells[i] / share.cells[i].max(1e-6) } else { 0.0 };
    let mut made = Grid { cells: (0..greys.cells.len()).map(mean).collect(), ..*greys };
    spill(&mut made, inside);
    made
}

/// Cells beyond the margin take the mean of their known neighbours, ring after ring.
fn spill(greys: &mut Grid<f32>, inside: &Grid<bool>) {
    let mut known = inside.clone();
    let beside = |known: &Grid<bool>, i: usize| !known.cells[i] && inside.neighbours(i).any(|n| known.cells[n]);
    let mut ring: Vec<usize> = (0..known.cells.len()).filter(|&i| beside(&known, i)).collect();
    for _ in 0..SPILL {
        let mean = |&i: &usize| {
            let around: Vec<f32> = known.neighbours(i).filter(|&n| known.cells[n]).map(|n| greys.cells[n]).collect();
            around.iter().sum::<f32>() / around.len().max(1) as f32
        };
        let values: Vec<f32> = ring.iter().map(mean).collect();
        for (&i, value) in ring.iter().zip(values) {
            (greys.cells[i], known.cells[i]) = (value, true);
        }
        let mut next: Vec<usize> =
            ring.iter().flat_map(|&i| known.neighbours(i)).filter(|&n| !known.cells[n]).collect();
        next.sort_unstable();
        next.dedup();
        ring = next;
    }
}

#[cfg(test)]
mod tests;
