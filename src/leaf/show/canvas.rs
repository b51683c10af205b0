//! A picture on which points of the blade's plane are drawn: what charts and previews are made with.

use crate::base::picture::Picture;
use crate::base::vector::DVec2;
use tiny_skia::{Color, FillRule, LineJoin, Paint, Path, PathBuilder, Pixmap, Stroke, Transform};

/// An opaque colour, 8-bit sRGB.
pub type Ink = [u8; 3];

/// Where the plane lies in a picture: x to the right, y up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    /// The pixel of the plane's origin.
    pub origin: DVec2,
    /// Pixels a metre.
    pub scale: f64,
}

impl Layout {
    /// The pixel of a point of the plane.
    pub fn pixel(&self, p: DVec2) -> DVec2 {
        DVec2::new(self.origin.x + self.scale * p.x, self.origin.y - self.scale * p.y)
    }

    /// The point of the plane of a pixel.
    pub fn plane(&self, pixel: DVec2) -> DVec2 {
        DVec2::new(pixel.x - self.origin.x, self.origin.y - pixel.y) / self.scale
    }
}

/// A picture that is being drawn.
pub struct Canvas {
    map: Pixmap,
    layout: Layout,
}

impl Canvas {
    /// A canvas of one colour; no side may be 0 (one pixel is taken then).
    pub fn new(width: u32, height: u32, ground: Ink, layout: Layout) -> Self {
        let map = Pixmap::new(width.max(1), height.max(1));
        let mut map = map.unwrap_or_else(|| unreachable!("a picture of {width} x {height} px is within limits"));
        map.fill(colour(ground));
        Self { map, layout }
    }

    /// Pixels in a row.
    pub fn width(&self) -> u32 {
        self.map.width()
    }

    /// Sets every pixel of a place to what `source` gives for it; `None` leaves it.
    pub fn fill_from(&mut self, source: impl Fn(u32, u32) -> Option<Ink>) {
        let width = self.map.width();
        for (i, pixel) in self.map.pixels_mut().iter_mut().enumerate() {
            if let Some([r, g, b]) = source(i as u32 % width, i as u32 / width) {
                *pixel = tiny_skia::ColorU8::from_rgba(r, g, b, 255).premultiply();
            }
        }
    }

    /// A line through points, `width` pixels wide.
    pub fn line(&mut self, points: &[DVec2], is_closed: bool, width: f64, ink: Ink) {
        let mut builder = PathBuilder::new();
        self.trace(&mut builder, points, is_closed);
        self.stroke(builder.finish(), width, ink);
    }

    /// The sides of all triangles, each side once.
    pub fn triangles(&mut self, positions: &[DVec2], triangles: &[[u32; 3]], width: f64, ink: Ink) {
        let sides = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let mut sides: Vec<[u32; 2]> = sides.map(|[a, b]| [a.min(b), a.max(b)]).collect();
        sides.sort_unstable();
        sides.dedup();
        let mut builder = PathBuilder::new();
        for side in sides {
            self.trace(&mut builder, &side.map(|v| positions[v as usize]), false);
        }
        self.stroke(builder.finish(), width, ink);
    }

    /// The inside of closed lines by the even-odd rule.
    pub fn area(&mut self, lines: &[&[DVec2]], ink: Ink) {
        let mut builder = PathBuilder::new();
        lines.iter().for_each(|line| self.trace(&mut builder, line, true));
        if let Some(path) = builder.finish() {
            self.map.fill_path(&path, &paint(ink), FillRule::EvenOdd, Transform::identity(), None);
        }
    }

    /// A disc about a point, `radius` pixels large.
    pub fn dot(&mut self, place: DVec2, radius: f64, ink: Ink) {
        let p = self.layout.pixel(place);
        if let Some(path) = PathBuilder::from_circle(p.x as f32, p.y as f32, radius as f32) {
            self.map.fill_path(&path, &paint(ink), FillRule::Winding, Transform::identity(), None);
        }
    }

    /// What was drawn.
    pub fn picture(self) -> Picture {
        let (width, height) = (self.map.width(), self.map.height());
        let code = |p: &tiny_skia::PremultipliedColorU8| [p.red(), p.green(), p.blue(), 255];
        Picture { width, height, pixels: self.map.pixels().iter().map(code).collect() }
    }

    fn trace(&self, builder: &mut PathBuilder, points: &[DVec2], is_closed: bool) {
        for (i, &point) in points.iter().enumerate() {
            let p = self.layout.pixel(point);
            if i == 0 {
                builder.move_to(p.x as f32, p.y as f32);
            } else {
                builder.line_to(p.x as f32, p.y as f32);
            }
        }
        if is_closed && points.len() > 2 {
            builder.close();
        }
    }

    fn stroke(&mut self, path: Option<Path>, width: f64, ink: Ink) {
        let stroke = Stroke { width: width as f32, line_join: LineJoin::Round, ..Stroke::default() };
        if let Some(path) = path {
            self.map.stroke_path(&path, &paint(ink), &stroke, Transform::identity(), None);
        }
    }
}

fn colour([r, g, b]: Ink) -> Color {
    Color::from_rgba8(r, g, b, 255)
}

fn paint(ink: Ink) -> Paint<'static> {
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    paint.set_color(colour(ink));
    paint
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plane_lies_as_the_layout_says() {
        let layout = Layout { origin: DVec2::new(10.0, 30.0), scale: 100.0 };
        let p = DVec2::new(0.05, 0.2);
        assert_eq!(layout.pixel(p), DVec2::new(15.0, 10.0));
        assert!((layout.plane(layout.pixel(p)) - p).norm() < 1e-15);
        let mut canvas = Canvas::new(40, 40, [255; 3], layout);
        canvas.dot(p, 2.0, [200, 0, 0]);
        let picture = canvas.picture();
        assert_eq!(picture.at(15, 10), [200, 0, 0, 255]);
        assert_eq!(picture.at(15, 30), [255; 4]);
    }

    #[test]
    fn an_area_leaves_its_holes() {
        let layout = Layout { origin: DVec2::new(0.0, 20.0), scale: 1.0 };
        let square =
            |low: f64, high: f64| [(low, low), (high, low), (high, high), (low, high)].map(|(x, y)| DVec2::new(x, y));
        let (outer, hole) = (square(2.0, 18.0), square(8.0, 12.0));
        let mut canvas = Canvas::new(20, 20, [255; 3], layout);
        canvas.area(&[&outer, &hole], [0; 3]);
        let picture = canvas.picture();
        assert_eq!(picture.pixels.iter().filter(|p| p[0] == 0).count(), 16 * 16 - 4 * 4);
    }
}
