//! The mirror symmetry of a blade: how much of it falls on itself when it is folded along an axis through its centroid.

use crate::base::maths::{atan2, sincos};
use crate::base::vector::DVec2;
use crate::leaf::grid::Grid;
use crate::leaf::raster::cell_of;

/// About so many points of the blade are mirrored.
const SAMPLES: f64 = 3000.0;
/// Half angle of the outline points that count as the end of an axis, radians.
const END: f64 = 0.15;

/// A blade to be folded.
pub struct Symmetry<'a> {
    blade: &'a Grid<bool>,
    /// The centroid, pixels.
    pub centre: DVec2,
    samples: Vec<DVec2>,
}

impl<'a> Symmetry<'a> {
    /// Of a blade with at least one cell.
    pub fn of(blade: &'a Grid<bool>) -> Self {
        let stride = ((blade.area() as f64 / SAMPLES).sqrt().ceil() as usize).max(1);
        let rows = (0..blade.height).step_by(stride);
        let samples: Vec<DVec2> = rows
            .flat_map(|y| (0..blade.width).step_by(stride).map(move |x| (x, y)))
            .filter(|&(x, y)| blade.at(x, y))
            .map(|(x, y)| DVec2::new(x as f64 + 0.5, y as f64 + 0.5))
            .collect();
        Self { blade, centre: centroid(blade), samples }
    }

    /// The direction (unit) from the centroid to a point.
    pub fn heading(&self, point: DVec2) -> DVec2 {
        (point - self.centre).try_normalize(0.0).unwrap_or_else(DVec2::y)
    }

    /// Share of the blade that falls on itself when folded along an axis (unit) through the centroid.
    pub fn along(&self, axis: DVec2) -> f64 {
        let mirrored = |p: &&DVec2| {
            let from = *p - self.centre;
            self.inside(self.centre + axis * (2.0 * from.dot(&axis)) - from)
        };
        self.samples.iter().filter(mirrored).count() as f64 / self.samples.len().max(1) as f64
    }

    /// The axis of best symmetry, to a degree.
    pub fn best(&self) -> DVec2 {
        let axis = |step: u32| {
            let (sine, cosine) = sincos(f64::from(step) * std::f64::consts::PI / 180.0);
            DVec2::new(cosine, sine)
        };
        let better = |a: &(f64, DVec2), b: &(f64, DVec2)| a.0.total_cmp(&b.0);
        // of equals the last is taken, which is the first angle
        (0..180)
            .rev()
            .map(|step| (self.along(axis(step)), axis(step)))
            .max_by(better)
            .map_or_else(DVec2::y, |best| best.1)
    }

    /// Without a petiole: the end of the axis of best symmetry where the base is, drawn to the nearest inward place of the
    /// outline.
    pub fn joint(&self, outline: &[DVec2]) -> DVec2 {
        let best = self.best();
        let reach = |p: &DVec2| (p - self.centre).norm();
        let end = |heading: DVec2| {
            let off = |p: &&DVec2| {
                let from = *p - self.centre;
                atan2(heading.perp(&from), heading.dot(&from)).abs()
            };
            let near = outline.iter().filter(|p| off(p) < END).min_by(|a, b| reach(a).total_cmp(&reach(b)));
            near.copied().unwrap_or(self.centre)
        };
        end(if self.is_base(best) { best } else { -best })
    }

    /// Whether the base lies in this direction (unit) from the centroid rather than in the opposite one: it is broader than
    /// the tip, so it is nearer, and the blade trails off the other way.
    pub fn is_base(&self, heading: DVec2) -> bool {
        let along = |p: &DVec2| (p - self.centre).dot(&heading);
        let spread = self.samples.iter().map(|p| along(p) * along(p)).sum::<f64>() / self.samples.len().max(1) as f64;
        let third = self.samples.iter().map(|p| along(p) * along(p) * along(p)).sum::<f64>();
        let skewness = third / self.samples.len().max(1) as f64 / (spread * spread.sqrt()).max(1e-9);
        let (here, there) = (self.reach(heading), self.reach(-heading));
        skewness / 0.1 + (here - there) / (0.1 * (here + there)).max(1e-9) < 0.0
    }

    /// How far the blade goes from the centroid along a direction.
    fn reach(&self, heading: DVec2) -> f64 {
        let mut reach: f64 = 0.0;
        for p in &self.samples {
            let from = p - self.centre;
            if heading.perp(&from).abs() < 0.1 * heading.dot(&from) {
                reach = reach.max(heading.dot(&from));
            }
        }
        reach
    }

    fn inside(&self, p: DVec2) -> bool {
        cell_of(self.blade.width, self.blade.height, p).is_some_and(|cell| self.blade.cells[cell])
    }
}

fn centroid(blade: &Grid<bool>) -> DVec2 {
    let (mut columns, mut rows, mut area) = (0u64, 0u64, 0u64);
    for (y, row) in blade.cells.chunks_exact(blade.width.max(1)).enumerate() {
        for x in (0..row.len()).filter(|&x| row[x]) {
            (columns, rows, area) = (columns + x as u64, rows + y as u64, area + 1);
        }
    }
    let middle = |sum: u64| (sum as f64 + 0.5 * area as f64) / area.max(1) as f64;
    DVec2::new(middle(columns), middle(rows))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_egg_is_symmetric_about_its_axis_and_joined_at_its_broad_end() {
        // broad at the top, running to a point at the bottom
        let inside = |i: usize| {
            let (x, y) = ((i % 120) as f64 + 0.5 - 60.0, (i / 120) as f64 + 0.5 - 60.0);
            if y < 0.0 { x * x / 1600.0 + y * y / 900.0 < 1.0 } else { x.abs() < 40.0 * (1.0 - y / 90.0) }
        };
        let blade = Grid { width: 120, height: 160, cells: (0..120 * 160).map(inside).collect() };
        let symmetry = Symmetry::of(&blade);
        assert!(symmetry.best().x.abs() < 0.02);
        assert!(symmetry.along(DVec2::y()) > 0.99 && symmetry.along(DVec2::x()) < 0.9);
        let outline = crate::leaf::trace::contour::outlined(&blade).remove(0);
        assert!((symmetry.joint(&outline) - DVec2::new(60.0, 30.0)).norm() < 3.0);
    }
}
