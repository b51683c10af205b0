//! The tree's outline against the sky, from the side: how much sky shows inside it and how lumpy it is.

use crate::base::flat_mesh::FlatMesh;
use crate::base::maths::{cos, sin, sincos};
use crate::base::vector::DVec3;
use crate::tree::{Settings, Tree};
use std::f64::consts::{PI, TAU};
use tiny_skia::{FillRule, Mask, Path, PathBuilder, Transform};

/// Pixels of the tree's height or width: at 10 m a leaf of a maple is 8 of them.
const SIZE: u32 = 1000;
/// Room for leaves beyond the wood's ends, metres.
const MARGIN: f64 = 0.3;
/// Bays narrower than twice this lie inside the outline, metres: about the size of a spray of leaves, so that the outline
/// follows the clumps of the crown and the gaps inside it are what the eye calls sky holes.
const CLOSING: f64 = 0.12;
/// Leaves drawn by one path.
const BATCH: usize = 500;

/// What a side view shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Silhouette {
    /// Share of the sky inside the outline.
    pub sky: f64,
    /// Perimeter of the outline over that of its convex hull.
    pub lumpiness: f64,
}

/// Looks at the tree along -z, in parallel projection. Leaves are ellipses of their blade's length and area at the end of
/// their petioles. With `leaves` off it is the tree in winter.
#[must_use]
pub fn silhouette(tree: &Tree, blade: &FlatMesh, settings: &Settings) -> Silhouette {
    let (mask, metres) = draw(tree, blade, settings);
    let covered = Grid { width: mask.width() as usize, inside: mask.data().iter().map(|&a| a > 127).collect() };
    let outline = covered.closed(CLOSING / metres).largest().filled();
    let drawn = covered.inside.iter().zip(&outline.inside).filter(|(drawn, inside)| **drawn && **inside).count();
    let sky = 1.0 - drawn as f64 / outline.count().max(1) as f64;
    Silhouette { sky, lumpiness: outline.perimeter() / outline.hull_perimeter().max(1.0) }
}

/// The covered pixels, and metres a pixel.
fn draw(tree: &Tree, blade: &FlatMesh, settings: &Settings) -> (Mask, f64) {
    let reach = tree.crown_radius + MARGIN;
    let metres = (tree.height + MARGIN).max(2.0 * reach) / f64::from(SIZE);
    let margin = (CLOSING / metres).ceil() as u32 + 2;
    let half = reach / metres;
    let high = (tree.height + MARGIN) / metres;
    let (width, height) = (2 * half.ceil() as u32 + 2 * margin, high.ceil() as u32 + 2 * margin);
    let mut mask = Mask::new(width, height).unwrap_or_else(|| unreachable!("the picture has a size"));
    let middle = f64::from(width) * 0.5;
    let foot = f64::from(height - margin);
    let project = |p: DVec3| (middle + p.x / metres, foot - p.y / metres);
    let mut shapes: Vec<Vec<(f64, f64)>> = Vec::new();
    for segment in &tree.skeleton.segments {
        let (a, b) = (project(segment.start), project(segment.end));
        shapes.push(bar(a, b, segment.radius / metres));
    }
    let length = blade.positions.iter().map(|p| p.y).fold(0.0, f64::max);
    let breadth = blade.area() / (PI * 0.25 * length.max(1e-6));
    let (upward, forward) = sincos(settings.petiole_angle.to_radians());
    for site in &tree.sites {
        let along = site.blade * (0.5 * length * site.scale);
        let across = site.blade.cross(&site.normal) * (0.5 * breadth * site.scale);
        let joint = site.base
            + (site.blade * forward + site.normal * upward)
                * (settings.petiole * 1e-3 * site.scale * site.petiole_length);
        let corner = |n: usize| {
            let angle = TAU * n as f64 / 8.0;
            project(joint + along + along * cos(angle) + across * sin(angle))
        };
        shapes.push((0..8).map(corner).collect());
    }
    for batch in shapes.chunks(BATCH) {
        if let Some(path) = path(batch) {
            mask.fill_path(&path, FillRule::Winding, true, Transform::identity());
        }
    }
    (mask, metres)
}

/// A line with a thickness of at least a third of a pixel, which keeps twigs in the anti-aliased picture.
fn bar(a: (f64, f64), b: (f64, f64), radius: f64) -> Vec<(f64, f64)> {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let scale = radius.max(0.17) / (dx * dx + dy * dy).sqrt().max(1e-9);
    let (nx, ny) = (-dy * scale, dx * scale);
    vec![(a.0 + nx, a.1 + ny), (b.0 + nx, b.1 + ny), (b.0 - nx, b.1 - ny), (a.0 - nx, a.1 - ny)]
}

/// Polygons as one path, all wound the same way so that overlaps do not cancel.
fn path(shapes: &[Vec<(f64, f64)>]) -> Option<Path> {
    let mut builder = PathBuilder::new();
    for shape in shapes {
        let next = |n: usize| shape[(n + 1) % shape.len()];
        let area: f64 = (0..shape.len()).map(|n| shape[n].0 * next(n).1 - next(n).0 * shape[n].1).sum();
        let at = |n: usize| if area < 0.0 { shape[shape.len() - 1 - n] } else { shape[n] };
        builder.move_to(at(0).0 as f32, at(0).1 as f32);
        (1..shape.len()).for_each(|n| builder.line_to(at(n).0 as f32, at(n).1 as f32));
        builder.close();
    }
    builder.finish()
}

/// Pixels, row by row.
#[derive(Clone)]
struct Grid {
    width: usize,
    inside: Vec<bool>,
}

impl Grid {
    fn count(&self) -> usize {
        self.inside.iter().filter(|&&inside| inside).count()
    }

    /// Morphological closing by a disc of `radius` pixels.
    fn closed(&self, radius: f64) -> Grid {
        let square = radius * radius;
        let grown: Vec<bool> = distances(&self.inside, self.width).iter().map(|&d| d <= square).collect();
        let outside: Vec<bool> = grown.iter().map(|&inside| !inside).collect();
        let inside = distances(&outside, self.width).iter().map(|&d| d > square).collect();
        Grid { width: self.width, inside }
    }

    /// The same without holes: what cannot be reached from the border is inside.
    fn filled(&self) -> Grid {
        // The border is left free when the tree is drawn.
        let mut outside = vec![false; self.inside.len()];
        self.part(0, &mut outside);
        Grid { width: self.width, inside: outside.iter().map(|&outside| !outside).collect() }
    }

    /// The largest connected part.
    fn largest(&self) -> Grid {
        let mut reached = vec![false; self.inside.len()];
        let mut best = Vec::new();
        for start in 0..self.inside.len() {
            if self.inside[start] && !reached[start] {
                let part = self.part(start, &mut reached);
                if part.len() > best.len() {
                    best = part;
                }
            }
        }
        let mut inside = vec![false; self.inside.len()];
        best.into_iter().for_each(|pixel| inside[pixel] = true);
        Grid { width: self.width, inside }
    }

    /// The pixels of the start's kind that four-neighbour steps reach from it; they are marked.
    fn part(&self, start: usize, reached: &mut [bool]) -> Vec<usize> {
        let mut part = vec![start];
        reached[start] = true;
        let mut next = 0;
        while let Some(&pixel) = part.get(next) {
            next += 1;
            let column = pixel % self.width;
            let neighbours = [
                (column > 0).then(|| pixel - 1),
                (column + 1 < self.width).then(|| pixel + 1),
                pixel.checked_sub(self.width),
                (pixel + self.width < self.inside.len()).then(|| pixel + self.width),
            ];
            for next in neighbours.into_iter().flatten() {
                if self.inside[next] == self.inside[start] && !reached[next] {
                    reached[next] = true;
                    part.push(next);
                }
            }
        }
        part
    }

    /// Length of the border, pixels: by Crofton's formula from the crossings of rows, columns and both diagonals, which has
    /// no bias for slanted borders.
    fn perimeter(&self) -> f64 {
        let height = self.inside.len() / self.width;
        let at = |x: usize, y: usize| self.inside[y * self.width + x];
        let (mut straight, mut diagonal) = (0usize, 0usize);
        for y in 0..height - 1 {
            for x in 0..self.width - 1 {
                straight += usize::from(at(x, y) != at(x + 1, y)) + usize::from(at(x, y) != at(x, y + 1));
                diagonal += usize::from(at(x, y) != at(x + 1, y + 1)) + usize::from(at(x + 1, y) != at(x, y + 1));
            }
        }
        (straight as f64 + diagonal as f64 * std::f64::consts::FRAC_1_SQRT_2) * PI / 8.0
    }

    /// Perimeter of the convex hull, pixels (Andrew's monotone chain).
    fn hull_perimeter(&self) -> f64 {
        let mut points: Vec<(f64, f64)> = Vec::new();
        for (y, row) in self.inside.chunks(self.width).enumerate() {
            let ends = [row.iter().position(|&inside| inside), row.iter().rposition(|&inside| inside)];
            points.extend(ends.into_iter().flatten().map(|x| (x as f64, y as f64)));
        }
        points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let mut hull: Vec<(f64, f64)> = half_hull(points.iter());
        hull.pop();
        hull.extend(half_hull(points.iter().rev()));
        let length =
            |(ax, ay): (f64, f64), (bx, by): (f64, f64)| ((bx - ax) * (bx - ax) + (by - ay) * (by - ay)).sqrt();
        hull.windows(2).map(|pair| length(pair[0], pair[1])).sum()
    }
}

fn half_hull<'a>(points: impl Iterator<Item = &'a (f64, f64)>) -> Vec<(f64, f64)> {
    let mut hull: Vec<(f64, f64)> = Vec::new();
    for &c in points {
        while let [.., a, b] = hull[..] {
            if (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0) > 0.0 {
                break;
            }
            hull.pop();
        }
        hull.push(c);
    }
    hull
}

/// Squared distance of every pixel to the nearest marked one, exact (Felzenszwalb and Huttenlocher 2012).
fn distances(marked: &[bool], width: usize) -> Vec<f64> {
    const FAR: f64 = 1e12;
    let height = marked.len() / width;
    let mut field: Vec<f64> = marked.iter().map(|&marked| if marked { 0.0 } else { FAR }).collect();
    let mut line = vec![0.0; width.max(height)];
    for x in 0..width {
        (0..height).for_each(|y| line[y] = field[y * width + x]);
        for (y, value) in lower_envelope(&line[..height]).into_iter().enumerate() {
            field[y * width + x] = value;
        }
    }
    for row in field.chunks_mut(width) {
        let transformed = lower_envelope(row);
        row.copy_from_slice(&transformed);
    }
    field
}

/// min over q of (p - q)^2 + f(q), for all p.
fn lower_envelope(f: &[f64]) -> Vec<f64> {
    let mut apexes: Vec<usize> = Vec::with_capacity(f.len());
    let mut bounds: Vec<f64> = Vec::with_capacity(f.len());
    let meet = |p: usize, q: usize| ((f[q] + (q * q) as f64) - (f[p] + (p * p) as f64)) / (2.0 * (q as f64 - p as f64));
    for q in 0..f.len() {
        let mut from = f64::NEG_INFINITY;
        while let (Some(&p), Some(&bound)) = (apexes.last(), bounds.last()) {
            from = meet(p, q);
            if from > bound {
                break;
            }
            apexes.pop();
            bounds.pop();
            from = f64::NEG_INFINITY;
        }
        apexes.push(q);
        bounds.push(from);
    }
    let mut at = 0;
    (0..f.len())
        .map(|p| {
            while at + 1 < bounds.len() && bounds[at + 1] < p as f64 {
                at += 1;
            }
            let reach = p as f64 - apexes[at] as f64;
            reach * reach + f[apexes[at]]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disc(radius: f64) -> Grid {
        let side = 2 * radius as usize + 21;
        let middle = side as f64 * 0.5;
        let inside = (0..side * side).map(|n| {
            let (x, y) = ((n % side) as f64 + 0.5 - middle, (n / side) as f64 + 0.5 - middle);
            x * x + y * y < radius * radius
        });
        Grid { width: side, inside: inside.collect() }
    }

    #[test]
    fn a_disc_has_its_perimeter_and_is_its_own_hull() {
        let disc = disc(200.0);
        let circle = TAU * 200.0;
        assert!((disc.perimeter() / circle - 1.0).abs() < 0.01, "{}", disc.perimeter() / circle);
        assert!((disc.hull_perimeter() / circle - 1.0).abs() < 0.01);
    }

    #[test]
    fn closing_fills_what_is_narrower_than_its_disc_and_no_more() {
        let whole = disc(60.0);
        let slit = |half: usize| {
            let middle = whole.width / 2;
            let mut slit = whole.clone();
            (0..slit.inside.len())
                .filter(|n| (n % whole.width).abs_diff(middle) <= half)
                .for_each(|n| slit.inside[n] = false);
            slit
        };
        let closed = slit(2).closed(5.0);
        assert!(closed.count() as f64 > 0.99 * whole.count() as f64);
        let open = slit(9).closed(5.0);
        assert!((open.count() as f64 / slit(9).count() as f64 - 1.0).abs() < 0.02);
    }

    #[test]
    fn the_distance_is_the_least_over_all_marked_pixels() {
        let marked: Vec<bool> = (0..20 * 13).map(|n| n % 37 == 5).collect();
        let field = distances(&marked, 20);
        for (n, &found) in field.iter().enumerate() {
            let square = |m: usize| ((n % 20).abs_diff(m % 20).pow(2) + (n / 20).abs_diff(m / 20).pow(2)) as f64;
            let wanted = (0..marked.len()).filter(|&m| marked[m]).map(square).fold(f64::INFINITY, f64::min);
            assert_eq!(found, wanted);
        }
    }

    #[test]
    fn the_largest_part_and_its_holes() {
        let mut grid = disc(30.0);
        let middle = grid.inside.len() / 2;
        grid.inside[middle] = false;
        grid.inside[grid.width + 1] = true;
        let whole = disc(30.0).count();
        assert_eq!(grid.largest().count(), whole - 1);
        assert_eq!(grid.largest().filled().count(), whole);
    }
}
