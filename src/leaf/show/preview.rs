//! What was made of a scan, side by side: the picture, the outline with its key points, the mesh, the veins and the mask.

use crate::base::blade::Blade;
use crate::base::picture::Picture;
use crate::base::vector::DVec2;
use crate::leaf::show::canvas::{Canvas, Ink, Layout};
use crate::leaf::show::chart;
use crate::leaf::trace::Trace;

/// Height of a panel, pixels, and the narrowest and widest that it may be.
const HEIGHT: u32 = 720;
const WIDTHS: [f64; 2] = [240.0, 1440.0];
/// Share of a panel that the leaf fills.
const FILL: f64 = 0.92;
const PAPER: Ink = [250, 249, 245];
const MESH: Ink = [30, 45, 60];
const MASKLESS: Ink = [214, 222, 230];
const TRACED: Ink = [230, 40, 120];

/// The five panels from left to right.
#[must_use]
pub fn drawn(picture: &Picture, trace: &Trace, blade: &Blade) -> Picture {
    let (layout, width) = fitted(blade);
    let panel = |draw: &dyn Fn(&mut Canvas)| {
        let mut canvas = Canvas::new(width, HEIGHT, PAPER, layout);
        draw(&mut canvas);
        canvas.picture()
    };
    let texture = |strength: f64| move |x: u32, y: u32| shown(blade, layout, strength, x, y);
    let panels = [
        scan(picture, trace),
        panel(&|canvas| {
            canvas.fill_from(texture(0.35));
            chart::outline(canvas, blade, 1.6);
            stalk(canvas, blade, 1.2);
        }),
        panel(&|canvas| {
            canvas.triangles(&blade.mesh.positions, &blade.mesh.triangles, 0.9, MESH);
            stalk(canvas, blade, 0.9);
        }),
        panel(&|canvas| {
            canvas.fill_from(texture(0.5));
            chart::veins(canvas, blade, layout);
        }),
        panel(&|canvas| mask(canvas, blade, layout)),
    ];
    joined(&panels)
}

/// The layout in which blade and petiole fill a panel, and the panel's width.
fn fitted(blade: &Blade) -> (Layout, u32) {
    let petiole = blade.petiole.iter().flat_map(|strip| &strip.positions);
    let points = || blade.outline.iter().chain(petiole.clone());
    let low = points().fold(DVec2::repeat(f64::INFINITY), |low, p| low.inf(p));
    let high = points().fold(DVec2::repeat(f64::NEG_INFINITY), |high, p| high.sup(p));
    let size = (high - low).sup(&DVec2::repeat(1e-9));
    let scale = (f64::from(HEIGHT) * FILL / size.y).min(WIDTHS[1] * FILL / size.x);
    let width = (size.x * scale / FILL).clamp(WIDTHS[0], WIDTHS[1]).round();
    let middle = (low + high) * 0.5;
    let origin = DVec2::new(width * 0.5 - scale * middle.x, f64::from(HEIGHT) * 0.5 + scale * middle.y);
    (Layout { origin, scale }, width as u32)
}

/// The picture as it is, with the traced outline and the joint.
fn scan(picture: &Picture, trace: &Trace) -> Picture {
    let factor = f64::from(HEIGHT) / f64::from(picture.height);
    let width = (f64::from(picture.width) * factor).clamp(WIDTHS[0], WIDTHS[1]).round() as u32;
    // Rows of the picture run down, those of the plane up.
    let layout = Layout { origin: DVec2::zeros(), scale: factor };
    let mut canvas = Canvas::new(width, HEIGHT, PAPER, layout);
    canvas.fill_from(|x, y| averaged(picture, f64::from(x) / factor, f64::from(y) / factor, 1.0 / factor));
    let flipped = |line: &[DVec2]| -> Vec<DVec2> { line.iter().map(|p| DVec2::new(p.x, -p.y)).collect() };
    for line in std::iter::once(&trace.outline).chain(&trace.holes) {
        canvas.line(&flipped(line), true, 1.5, TRACED);
    }
    canvas.dot(DVec2::new(trace.pose.joint.x, -trace.pose.joint.y), 5.0, TRACED);
    canvas.picture()
}

/// Mean colour of a square of the picture over paper; `None` beside the picture.
fn averaged(picture: &Picture, left: f64, top: f64, side: f64) -> Option<Ink> {
    let range = |from: f64, size: u32| {
        let first = (from as u32).min(size);
        first..((from + side).ceil() as u32).clamp((first + 1).min(size), size)
    };
    let (columns, rows) = (range(left, picture.width), range(top, picture.height));
    let mut sum = [0u32; 3];
    let count = (columns.len() * rows.len()) as u32;
    for (x, y) in rows.flat_map(|y| columns.clone().map(move |x| (x, y))) {
        let pixel = picture.at(x, y);
        let alpha = u32::from(pixel[3]);
        for (k, total) in sum.iter_mut().enumerate() {
            *total += (u32::from(pixel[k]) * alpha + u32::from(PAPER[k]) * (255 - alpha)) / 255;
        }
    }
    (count > 0).then(|| sum.map(|total| (total / count) as u8))
}

/// The scan's colour at a pixel of a panel, paled to a strength of 0 to 1; `None` beside the leaf.
fn shown(blade: &Blade, layout: Layout, strength: f64, x: u32, y: u32) -> Option<Ink> {
    let scan = blade.scan.as_ref()?;
    let uv = blade.mesh.uv(layout.plane(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)));
    let inside = |t: f32| (0.0..1.0).contains(&t);
    if !inside(uv.x) || !inside(uv.y) {
        return None;
    }
    let pixel = scan.at((uv.x * scan.width as f32) as u32, (uv.y * scan.height as f32) as u32);
    let paled = |k: usize| (f64::from(pixel[k]) * strength + f64::from(PAPER[k]) * (1.0 - strength)).round() as u8;
    (pixel[3] > 127).then(|| [0, 1, 2].map(paled))
}

fn stalk(canvas: &mut Canvas, blade: &Blade, width: f64) {
    if let Some(strip) = &blade.petiole {
        canvas.triangles(&strip.positions, &strip.triangles, width, MESH);
    }
}

/// The mask within the blade, on a ground on which its white and its black stand out.
fn mask(canvas: &mut Canvas, blade: &Blade, layout: Layout) {
    let mut cover = Canvas::new(canvas.width(), HEIGHT, MASKLESS, layout);
    let lines: Vec<&[DVec2]> = std::iter::once(&blade.outline).chain(&blade.holes).map(Vec::as_slice).collect();
    cover.area(&lines, [0; 3]);
    let cover = cover.picture();
    canvas.fill_from(|x, y| {
        let [r, g, b, _] = cover.at(x, y);
        Some(if r == 0 { chart::grey(blade, layout, x, y) } else { [r, g, b] })
    });
}

/// Pictures of one height side by side.
fn joined(panels: &[Picture]) -> Picture {
    let width = panels.iter().map(|panel| panel.width).sum();
    let mut pixels = Vec::with_capacity(width as usize * HEIGHT as usize);
    for y in 0..HEIGHT {
        for panel in panels {
            let start = (y * panel.width) as usize;
            pixels.extend_from_slice(&panel.pixels[start..start + panel.width as usize]);
        }
    }
    Picture { width, height: HEIGHT, pixels }
}
