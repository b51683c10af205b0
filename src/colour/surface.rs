//! A blade at the resolution of its texture: which pixels are leaf, how far each is from the margin and from the veins.
//!
//! Lengths are in texture widths (the blade is about 0.94 long); the layout is that of the mesh's texture coordinates.

use super::areoles::Net;
use super::distance;
use crate::base::blade::{Blade, Vein};
use crate::base::maths::expf;
use crate::base::noise::Lattice;
use crate::base::random::hash_unit;
use crate::base::vector::{DVec2, Vec2};
use tiny_skia::{FillRule, Mask, PathBuilder, Transform};

/// Pixels from the blade beyond which nothing of its rim is seen.
pub(super) const FAR: f32 = 14.0;
/// Orders of veins told apart.
pub(super) const ORDERS: usize = 3;
/// How far a vein of each order makes itself felt.
const REACH: [f32; ORDERS] = [0.075, 0.045, 0.02];
/// How steeply the supply of tissue falls beside a vein of each order, a texture width, and the logarithm of what it is there:
/// 1, 0.8 and 0.36.
const SUPPLY: [(f32, f32); ORDERS] = [(1.0 / 0.019, 0.0), (1.0 / 0.011, -0.223), (1.0 / 0.0045, -1.02)];
/// Widths of the veinlets that bound a patch and of those within it, millimetres.
const VEINLETS: [f64; 2] = [0.15, 0.07];

/// Half width of the border between two areoles, millimetres.
const SOFT: f32 = 0.05;

/// What never changes at one place of a blade, whatever its state.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tissue {
    /// Number of its areole, of the one beyond the nearest veinlet, and the part of the latter in what the place is like, 0 to
    /// 0.5: half way at the veinlet itself.
    pub areole: u32,
    pub next: u32,
    pub beyond: f32,
    /// Distance from the margin.
    pub margin: f32,
    /// 1 on a vein, falling to 0 in the tissue between.
    pub supply: f32,
    /// 1 on a vein, falling steeply beside it.
    pub beside: f32,
    /// Share covered by main and secondary veins, and by those of the third order.
    pub vein: f32,
    /// Share covered by veinlets.
    pub veinlet: f32,
    /// Unevenness finer than areoles, -0.5..0.5.
    pub grain: f32,
    /// Factor on reflected light of the surface's own unevenness.
    pub light: f32,
    /// Factor on transmitted light: veins are thick.
    pub through: f32,
    /// What a scan shows of the place: its lead, a factor on anthocyanins, and brown pigment of dead tissue.
    pub lead: f32,
    pub redness: f32,
    pub brown: f32,
}

/// The blade, rasterised.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    /// Pixels along one side.
    pub size: usize,
    /// Whether the pixel's middle lies in the blade, and the numbers of the pixels for which it does.
    pub inside: Vec<bool>,
    numbers: Vec<u32>,
    /// Distance from the margin, for pixels inside.
    pub margin: Vec<f32>,
    /// For each order, the distance from the edge of the nearest vein of that order (negative inside the vein), at most its
    /// reach.
    pub veins: [Vec<f32>; ORDERS],
    /// The pixels outside that are near enough to show the blade's rim: the pixel, the nearest one inside, and its distance in
    /// pixels, above 0 and below [`FAR`].
    pub filler: Vec<(u32, u32, f32)>,
    /// The net of veinlets.
    pub net: Net,
    /// Which areoles have a pixel inside.
    pub used: Vec<bool>,
    /// The tissue of each pixel inside, in their order.
    pub tissue: Vec<Tissue>,
    /// Distance to the nearest veinlet of each pixel inside, in their order.
    pub veinlets: Vec<f32>,
    /// Texture widths in a millimetre.
    pub millimetre: f32,
}

impl Surface {
    pub(super) fn new(blade: &Blade, size: u32) -> Self {
        let size = size as usize;
        let mut inside = filled(blade, size);
        if !inside.contains(&true) {
            // A blade without an outline, or one too thin for any pixel: all of the texture is leaf.
            inside = vec![true; size * size];
        }
        let outside: Vec<bool> = inside.iter().map(|leaf| !leaf).collect();
        let (squares, _) = distance::nearest(&outside, size);
        let (gaps, sources) = distance::nearest(&inside, size);
        let veins: [Vec<f32>; ORDERS] = std::array::from_fn(|order| vein_distances(blade, size, order));
        let scale = if blade.mesh.uv_scale > 0.0 { blade.mesh.uv_scale } else { 12.5 };
        let net = Net::new(scale, size, |place, within| {
            let pixel = |value: f32| ((value * size as f32).max(0.0) as usize).min(size - 1);
            let pixel = pixel(place.y) * size + pixel(place.x);
            veins[0][pixel].min(veins[1][pixel]) < within
        });
        let mut surface = Self {
            size,
            margin: squares.iter().map(|square| (square.sqrt() - 0.5).clamp(0.0, size as f32) / size as f32).collect(),
            veins,
            filler: filler(&gaps, &sources),
            numbers: (0..inside.len() as u32).filter(|&pixel| inside[pixel as usize]).collect(),
            inside,
            used: vec![false; net.areoles.len()],
            net,
            tissue: Vec::new(),
            veinlets: Vec::new(),
            millimetre: (scale * 1e-3) as f32,
        };
        (surface.tissue, surface.veinlets) = surface.pixels().map(|pixel| surface.tissue_at(pixel)).unzip();
        for tissue in &surface.tissue {
            surface.used[tissue.areole as usize] = true;
            surface.used[tissue.next as usize] = true;
        }
        surface
    }

    /// Numbers of the pixels inside, in order.
    pub(super) fn pixels(&self) -> impl Iterator<Item = usize> + '_ {
        self.numbers.iter().map(|&pixel| pixel as usize)
    }

    /// The middle of a pixel in texture coordinates.
    pub(super) fn place(&self, pixel: usize) -> Vec2 {
        let (column, row) = (pixel % self.size, pixel / self.size);
        Vec2::new((column as f32 + 0.5) / self.size as f32, (row as f32 + 0.5) / self.size as f32)
    }

    /// Distance from the margin and supply at a place, those of the nearest pixel.
    pub(super) fn about(&self, place: Vec2) -> (f32, f32) {
        let pixel = |value: f32| ((value * self.size as f32).max(0.0) as usize).min(self.size - 1);
        let pixel = pixel(place.y) * self.size + pixel(place.x);
        (self.margin[pixel], self.supply(std::array::from_fn(|order| self.veins[order][pixel])))
    }

    /// 1 on a main vein, falling with the distance from veins of all orders: the largest of what each supplies.
    fn supply(&self, edges: [f32; ORDERS]) -> f32 {
        // The largest of several exponentials is that of the largest exponent.
        expf((0..ORDERS).map(|o| SUPPLY[o].1 - edges[o].max(0.0) * SUPPLY[o].0).fold(-30.0, f32::max))
    }

    /// The share of a pixel that a line of a half width covers at a distance from its edge.
    fn covered(&self, edge: f32, half: f32) -> f32 {
        let size = self.size as f32;
        // A line narrower than a pixel covers only part of it.
        (0.5 - edge * size).clamp(0.0, 1.0) * (2.0 * half * size).min(1.0)
    }

    /// The tissue of a pixel, and its distance from the nearest veinlet.
    fn tissue_at(&self, pixel: usize) -> (Tissue, f32) {
        let edges: [f32; ORDERS] = std::array::from_fn(|order| self.veins[order][pixel]);
        let spot = self.net.at(self.place(pixel));
        let half = 0.5 * VEINLETS[usize::from(!spot.strong)] as f32 * self.millimetre;
        let veinlet = self.covered(spot.veinlet - half, half) * if spot.strong { 0.85 } else { 0.4 };
        let [main, second, third] = std::array::from_fn(|o| self.covered(edges[o], 1.0));
        let supply = self.supply(edges);
        // Tissue beside the larger veins lies in their shade.
        let crease = expf((-edges[0].max(0.0) / 0.006).max(-0.51 - edges[1].max(0.0) / 0.004));
        let place = self.place(pixel) * (1.0 / self.millimetre);
        let fleck = Lattice::new(7).value(place.x / 0.28, place.y / 0.28) - 0.5;
        let grain = 0.7 * fleck + 0.5 * (hash_unit(8, pixel as u64) - 0.5);
        // A vein is round: its flanks turn away from the light.
        let flank = (1.0 - (edges[0].min(edges[1]) / (0.12 * self.millimetre)).abs()).max(0.0);
        // Round, and so palest along its middle.
        let main = main * (0.65 + 0.35 * (-edges[0] / (0.22 * self.millimetre)).clamp(0.0, 1.0));
        let square = supply * supply;
        // What an areole holds runs into the next over a pixel or a tenth of a millimetre.
        let soft = 1.0 / (0.5 / self.size as f32).max(SOFT * self.millimetre);
        let vein = main.max(0.85 * second).max(0.45 * third);
        let tissue = Tissue {
            areole: spot.areole,
            next: spot.next,
            beyond: (0.5 - 0.5 * spot.veinlet * soft).max(0.0),
            margin: self.margin[pixel],
            supply,
            beside: square * square * square,
            vein,
            veinlet,
            grain,
            light: (1.0 - 0.10 * crease * (1.0 - vein) - 0.10 * flank) * (1.0 + 0.09 * grain),
            through: (1.0 - 0.5 * main) * (1.0 - 0.38 * second) * (1.0 - 0.22 * third) * (1.0 - 0.16 * veinlet),
            lead: 0.0,
            redness: 1.0,
            brown: 0.0,
        };
        (tissue, spot.veinlet)
    }
}

/// The pixels outside and near, by the squared distances from the blade and its nearest pixels.
fn filler(squares: &[f32], sources: &[u32]) -> Vec<(u32, u32, f32)> {
    let near =
        squares.iter().zip(sources).enumerate().filter(|(_, (square, _))| **square > 0.0 && **square < FAR * FAR);
    near.map(|(pixel, (square, source))| (pixel as u32, *source, square.sqrt())).collect()
}

/// Pixels whose middle lies within the outline, where lobes overlap too, and in none of the gaps.
fn filled(blade: &Blade, size: usize) -> Vec<bool> {
    let mut inside = area(blade, &blade.outline, size);
    for hole in &blade.holes {
        let gap = area(blade, hole, size);
        inside.iter_mut().zip(gap).for_each(|(leaf, gap)| *leaf &= !gap);
    }
    inside
}

/// Pixels within a closed line, by the non-zero rule.
fn area(blade: &Blade, line: &[DVec2], size: usize) -> Vec<bool> {
    let mut path = PathBuilder::new();
    for (index, &point) in line.iter().enumerate() {
        let place = blade.mesh.uv(point) * size as f32;
        if index == 0 {
            path.move_to(place.x, place.y);
        } else {
            path.line_to(place.x, place.y);
        }
    }
    path.close();
    let mask = Mask::new(size as u32, size as u32);
    match (path.finish(), mask) {
        (Some(path), Some(mut mask)) => {
            mask.fill_path(&path, FillRule::Winding, false, Transform::identity());
            mask.data().iter().map(|&coverage| coverage > 0).collect()
        }
        _ => vec![false; size * size],
    }
}

fn vein_distances(blade: &Blade, size: usize, order: usize) -> Vec<f32> {
    let mut distances = vec![REACH[order]; size * size];
    let of_order = |vein: &&Vein| usize::from(vein.order).clamp(1, ORDERS) == order + 1;
    for vein in blade.veins.iter().filter(of_order) {
        let parts = vein.points.len().saturating_sub(1).max(1) as f64;
        let half = |part: usize| {
            0.5 * blade.mesh.uv_scale * (vein.width + (vein.end_width - vein.width) * part as f64 / parts)
        };
        for (part, ends) in vein.points.windows(2).enumerate() {
            let segment = Segment::new(blade, [ends[0], ends[1]], [half(part) as f32, half(part + 1) as f32]);
            segment.stamp(&mut distances, size, REACH[order]);
        }
    }
    distances
}

/// A straight piece of vein in texture coordinates.
struct Segment {
    a: Vec2,
    along: Vec2,
    halves: [f32; 2],
}

impl Segment {
    fn new(blade: &Blade, ends: [DVec2; 2], halves: [f32; 2]) -> Self {
        let [a, b] = ends.map(|end| blade.mesh.uv(end));
        Self { a, along: b - a, halves }
    }

    /// Lowers the distances of all pixels within reach: from the edge, negative inside.
    fn stamp(&self, distances: &mut [f32], size: usize, reach: f32) {
        let (a, along, [half, last]) = (self.a, self.along, self.halves);
        let (b, wider) = (a + along, last - half);
        let reach = reach + half.max(last);
        let texel = 1.0 / size as f32;
        let per_square = 1.0 / along.norm_squared().max(1e-12);
        let pixel = |value: f32| (value * size as f32).clamp(0.0, size as f32) as usize;
        for row in pixel(a.y.min(b.y) - reach)..pixel(a.y.max(b.y) + reach + texel) {
            let up = (row as f32 + 0.5) * texel - a.y;
            let [from, to] = self.span(up, reach);
            let columns = pixel(from)..pixel(to + texel);
            let first = (columns.start as f32 + 0.5) * texel - a.x;
            let line = &mut distances[row * size..][columns];
            for (number, distance) in line.iter_mut().enumerate() {
                let right = first + number as i32 as f32 * texel;
                let part = ((right * along.x + up * along.y) * per_square).clamp(0.0, 1.0);
                let (x, y) = (right - along.x * part, up - along.y * part);
                let found = (x * x + y * y).sqrt() - (half + wider * part);
                *distance = if found < *distance { found } else { *distance };
            }
        }
    }

    /// From where to where a row may lie within `reach`, the row being `up` below the segment's start.
    fn span(&self, up: f32, reach: f32) -> [f32; 2] {
        let ends = if self.along.y.abs() < 1e-6 {
            [0.0, 1.0]
        } else {
            [up - reach, up + reach].map(|y| (y / self.along.y).clamp(0.0, 1.0))
        };
        let [c, d] = ends.map(|part| self.a.x + self.along.x * part);
        [c.min(d) - reach, c.max(d) + reach]
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::base::flat_mesh::FlatMesh;
    use crate::base::maths::{cos, sin};

    /// A round-lobed blade 70 mm long with a midrib and two side veins.
    pub fn blade() -> Blade {
        let point = |x: f64, y: f64| DVec2::new(x, y) * 1e-3;
        let outline = (0..240).map(|i| {
            let angle = std::f64::consts::TAU * f64::from(i) / 240.0;
            let radius = 30.0 + 4.0 * cos(5.0 * angle);
            point(radius * sin(angle), 34.0 - radius * cos(angle))
        });
        let vein = |order, width, points: &[(f64, f64)]| Vein {
            points: points.iter().map(|&(x, y)| point(x, y)).collect(),
            width: width * 1e-3,
            end_width: 0.3 * width * 1e-3,
            order,
        };
        Blade {
            mesh: FlatMesh { uv_scale: 0.94 / 0.068, uv_origin: DVec2::new(0.5, 0.97), ..FlatMesh::default() },
            outline: outline.collect(),
            veins: vec![
                vein(1, 1.2, &[(0.0, 0.0), (0.0, 34.0), (1.0, 60.0)]),
                vein(2, 0.7, &[(0.0, 8.0), (22.0, 34.0)]),
                vein(2, 0.7, &[(0.0, 8.0), (-22.0, 34.0)]),
            ],
            ..Blade::default()
        }
    }

    #[test]
    fn the_blade_covers_the_area_of_its_outline() {
        let blade = blade();
        let surface = Surface::new(&blade, 256);
        let count = blade.outline.len();
        let doubled: f64 = (0..count).map(|i| blade.outline[i].perp(&blade.outline[(i + 1) % count])).sum();
        let expected = 0.5 * doubled * blade.mesh.uv_scale * blade.mesh.uv_scale;
        let covered = surface.inside.iter().filter(|&&leaf| leaf).count() as f64 / 65536.0;
        assert!(expected > 0.0 && (covered / expected - 1.0).abs() < 3e-3, "{covered} {expected}");
    }

    #[test]
    fn distances_grow_away_from_veins_and_margin() {
        let blade = blade();
        let surface = Surface::new(&blade, 256);
        let at = |x: f64, y: f64| {
            let uv = blade.mesh.uv(DVec2::new(x * 1e-3, y * 1e-3)) * 256.0;
            uv.y as usize * 256 + uv.x as usize
        };
        let scale = blade.mesh.uv_scale as f32;
        assert!(surface.veins[0][at(0.0, 20.0)] < 0.0);
        // 5 mm beside a vein 0.95 mm wide there, within a pixel.
        assert!((surface.veins[0][at(5.0, 20.0)] - (5.0 - 0.48) * 1e-3 * scale).abs() < 1.5 / 256.0);
        // The middle of the lower lobe is nearest to a place about 30 mm away on the margin.
        let margin = surface.margin[at(0.0, 34.0)] / scale * 1e3;
        assert!((25.0..27.5).contains(&margin), "{margin}");
        assert_eq!(surface.margin[0], 0.0);
    }

    #[test]
    fn a_blade_without_an_outline_fills_the_texture() {
        let surface = Surface::new(&Blade::default(), 16);
        assert!(surface.inside.iter().all(|&leaf| leaf));
        assert!(surface.margin.iter().all(|margin| margin.is_finite()));
    }
}
