//! The chart as pixels.

use super::lettering;
use super::palette::PAPER;
use super::primitive::{Drawing, Pen, Pixel, Primitive, Text};
use crate::base::picture::Picture;
use tiny_skia::{Color, FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Stroke, StrokeDash, Transform};

/// Draws a chart on paper.
pub(super) fn draw(drawing: &Drawing) -> Picture {
    let blank = || Picture::filled(drawing.width, drawing.height, [PAPER[0], PAPER[1], PAPER[2], 255]);
    let Some(mut pixels) = Pixmap::new(drawing.width, drawing.height) else { return blank() };
    let [red, green, blue] = PAPER;
    pixels.fill(Color::from_rgba8(red, green, blue, 255));
    drawing.items.iter().for_each(|item| draw_item(item, &mut pixels));
    let opaque = pixels.pixels().iter().map(|p| [p.red(), p.green(), p.blue(), 255]).collect();
    Picture { width: drawing.width, height: drawing.height, pixels: opaque }
}

fn draw_item(item: &Primitive, pixels: &mut Pixmap) {
    match item {
        Primitive::Polyline { points, pen } => stroke(std::slice::from_ref(points), pen, LineCap::Butt, pixels),
        Primitive::Polygon { points, fill } => {
            if let Some(path) = path(std::slice::from_ref(points), true) {
                pixels.fill_path(&path, &paint(*fill), FillRule::Winding, Transform::identity(), None);
            }
        }
        Primitive::Text(text) => draw_text(text, pixels),
        Primitive::Group { items, .. } => items.iter().for_each(|item| draw_item(item, pixels)),
    }
}

fn draw_text(text: &Text, pixels: &mut Pixmap) {
    let lettering = lettering::letter(text);
    let pen = |colour, width| Pen { colour, width, dashes: None };
    if text.halo {
        let width = lettering.stroke + text.size * HALO;
        stroke(&lettering.lines, &pen(PAPER, width), LineCap::Round, pixels);
    }
    stroke(&lettering.lines, &pen(text.colour, lettering.stroke), LineCap::Round, pixels);
}

/// How much wider than the strokes the paper around them is, in sizes.
pub(super) const HALO: f64 = 0.3;

fn paint([red, green, blue]: [u8; 3]) -> Paint<'static> {
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    paint.set_color_rgba8(red, green, blue, 255);
    paint
}

fn path(lines: &[Vec<Pixel>], is_closed: bool) -> Option<Path> {
    let mut builder = PathBuilder::new();
    for line in lines {
        for (at, point) in line.iter().enumerate() {
            let (x, y) = (point[0] as f32, point[1] as f32);
            if at == 0 { builder.move_to(x, y) } else { builder.line_to(x, y) }
        }
        if is_closed {
            builder.close();
        }
    }
    builder.finish()
}

/// Strokes lines.
pub(super) fn stroke(lines: &[Vec<Pixel>], pen: &Pen, line_cap: LineCap, pixels: &mut Pixmap) {
    let dash = pen.dashes.and_then(|[dash, gap]| StrokeDash::new(vec![dash as f32, gap as f32], 0.0));
    let stroke = Stroke { width: pen.width as f32, line_cap, line_join: LineJoin::Round, dash, ..Stroke::default() };
    if let Some(path) = path(lines, false) {
        pixels.stroke_path(&path, &paint(pen.colour), &stroke, Transform::identity(), None);
    }
}
