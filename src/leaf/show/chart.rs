//! Pictures of what the leaf stage made, laid out by the mesh's texture coordinates: the surfaces of leaves that show the
//! mask, the outline or the veins, as in the paper's Figures 1 and 3.

use crate::base::blade::Blade;
use crate::base::picture::Picture;
use crate::base::vector::DVec2;
use crate::leaf::show::canvas::{Canvas, Ink, Layout};

/// Pixels along a side.
const SIDE: u32 = 1024;
const PAPER: Ink = [255, 255, 255];
const CURVE: Ink = [20, 30, 45];
const KEY: Ink = [205, 45, 30];
/// Inks of veins by order.
const VEINS: [Ink; 3] = [[20, 60, 30], [60, 110, 60], [130, 165, 120]];

/// What a chart shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Chart {
    /// The mask map.
    Mask,
    /// The spline with its key points.
    Outline,
    /// The veins, as wide as they are.
    Veins,
}

/// Draws a chart of a blade: square, a power of two along a side.
#[must_use]
pub fn drawn(chart: Chart, blade: &Blade) -> Picture {
    let layout = of_texture(blade, SIDE);
    let mut canvas = Canvas::new(SIDE, SIDE, PAPER, layout);
    match chart {
        Chart::Mask => canvas.fill_from(|x, y| Some(grey(blade, layout, x, y))),
        Chart::Outline => outline(&mut canvas, blade, f64::from(SIDE) / 400.0),
        Chart::Veins => veins(&mut canvas, blade, layout),
    }
    canvas.picture()
}

/// Where the plane lies in a square picture by texture coordinates.
pub(in crate::leaf) fn of_texture(blade: &Blade, side: u32) -> Layout {
    Layout { origin: blade.mesh.uv_origin * f64::from(side), scale: blade.mesh.uv_scale * f64::from(side) }
}

/// The mask's grey at a pixel.
pub(in crate::leaf) fn grey(blade: &Blade, layout: Layout, x: u32, y: u32) -> Ink {
    let place = layout.plane(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
    [(super::texture::grey_at(&blade.mask, blade.mesh.uv(place)) + 0.5) as u8; 3]
}

/// Draws the spline and its key points; `unit` pixels is the width of the curve.
pub(in crate::leaf) fn outline(canvas: &mut Canvas, blade: &Blade, unit: f64) {
    for line in std::iter::once(&blade.outline).chain(&blade.holes) {
        canvas.line(line, true, unit, CURVE);
    }
    blade.keys.iter().for_each(|&key| canvas.dot(key, 2.2 * unit, KEY));
}

/// Draws the veins, thin ones first.
pub(in crate::leaf) fn veins(canvas: &mut Canvas, blade: &Blade, layout: Layout) {
    for vein in blade.veins.iter().rev() {
        let ink = VEINS[usize::from(vein.order.clamp(1, 3)) - 1];
        let pieces = vein.points.len().max(2) as f64 - 1.0;
        for (i, pair) in vein.points.windows(2).enumerate() {
            let along = (i as f64 + 0.5) / pieces;
            let width = (vein.width + (vein.end_width - vein.width) * along) * layout.scale;
            canvas.line(pair, false, width.max(1.0), ink);
        }
    }
}
