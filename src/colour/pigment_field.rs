//! Where in a blade the pigments are: how a leaf ages from its margin and between its veins, and where it is scorched.
//!
//! Chlorophyll leaves the margin and the areoles first and the veins last; the areoles, the cells of the vein net, age
//! each at its own pace, so that blotches are bounded by veins; anthocyanin is uneven over the blade and scarce along the
//! veins; dead tissue creeps in from the margin and in specks. Observed on scans of autumn leaves; amounts by eye.

use super::Pigments;
use super::noise::Noise;
use super::surface::{ORDERS, Surface};
use crate::base::maths::{expf, mix, smooth_step};
use crate::base::random::Stream;

/// Coarse and fine areoles in a texture's width: about 4 and 1.5 mm on a leaf of 75 mm.
const PATCHES: f32 = 19.0;
const AREOLES: f32 = 48.0;
/// How far from a vein of each order its tissue stays supplied, texture widths, and by how much.
const SUPPLY: [(f32, f32); ORDERS] = [(0.030, 1.0), (0.016, 0.85), (0.007, 0.5)];

/// What one pixel of the blade holds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Sample {
    /// Chlorophyll and anthocyanins (ug/cm2) and brown pigment.
    pub contents: [f32; 3],
    /// Factor on reflected light: relief, and the thick tissue of veins.
    pub reflected: f32,
    /// Factor on transmitted light.
    pub transmitted: f32,
}

/// How far a state has gone, read from its pigments.
#[derive(Clone, Copy, Debug)]
struct Age {
    /// 0 in a green leaf, 1 when the chlorophyll is gone.
    faded: f32,
    /// 0 in a living leaf, 1 in a brown one.
    dead: f32,
}

impl Age {
    fn new(pigments: &Pigments) -> Self {
        Self {
            faded: 1.0 - smooth_step(2.0, 26.0, pigments.chlorophyll as f32),
            dead: smooth_step(0.4, 1.0, pigments.brown as f32),
        }
    }
}

/// The painter of one texture.
struct Pattern<'a> {
    surface: &'a Surface,
    age: Age,
    salt: u64,
    /// Density of dead specks, 0 to 1, and of the pale halo round them.
    specks: Vec<(f32, f32)>,
}

/// The pigments of every pixel of the blade, in the order of the pixels inside; their means are the state's contents
/// (brown may exceed it where the margin is scorched). `stream` belongs to the texture.
pub(super) fn pigment_field(surface: &Surface, pigments: &Pigments, stream: &mut Stream) -> Vec<Sample> {
    let age = Age::new(pigments);
    let pattern = Pattern { surface, age, salt: stream.bits(), specks: specks(surface.size, age, stream) };
    let pixels = (0..surface.inside.len()).filter(|&pixel| surface.inside[pixel]);
    let mut samples: Vec<Sample> = pixels.map(|pixel| pattern.sample(pixel)).collect();
    scale(&mut samples, 0, pigments.chlorophyll as f32);
    scale(&mut samples, 1, pigments.anthocyanins as f32);
    let scorched = mean(&samples, 2);
    // Scorch is part of the state's brown pigment, but never all of it: the rest lies evenly.
    let even = (pigments.brown as f32 - scorched).max(0.35 * pigments.brown as f32);
    for (sample, tint) in samples.iter_mut().zip(pattern.tints()) {
        sample.contents[2] += even * tint;
    }
    samples
}

fn mean(samples: &[Sample], content: usize) -> f32 {
    let sum: f64 = samples.iter().map(|sample| f64::from(sample.contents[content])).sum();
    (sum / samples.len().max(1) as f64) as f32
}

fn scale(samples: &mut [Sample], content: usize, wanted: f32) {
    let factor = wanted / mean(samples, content).max(1e-9);
    samples.iter_mut().for_each(|sample| sample.contents[content] *= factor);
}

/// How near the veins a pixel is, and whether it is one.
struct Near {
    /// 1 on a vein, falling to 0 in the tissue between.
    supply: f32,
    /// Share of the pixel covered by veins of the first and of the second and third order.
    core: [f32; 2],
    /// Crease beside the larger veins.
    crease: f32,
}

impl Pattern<'_> {
    fn noise(&self, layer: u64) -> Noise {
        Noise(self.salt.wrapping_add(layer.wrapping_mul(0x9E37_79B9_7F4A_7C15)))
    }

    fn near(&self, pixel: usize) -> Near {
        let edges: [f32; ORDERS] = std::array::from_fn(|order| self.surface.veins[order][pixel]);
        let supply = (0..ORDERS).map(|o| SUPPLY[o].1 * expf(-edges[o].max(0.0) / SUPPLY[o].0)).fold(0.0, f32::max);
        let covered = |edge: f32| (0.75 - edge * self.surface.size as f32).clamp(0.0, 1.0);
        let crease = expf(-edges[0].max(0.0) / 0.007).max(0.6 * expf(-edges[1].max(0.0) / 0.005));
        Near { supply, core: [covered(edges[0]), (0.75 * covered(edges[1])).max(0.18 * covered(edges[2]))], crease }
    }

    /// A pixel's factors of chlorophyll and anthocyanins, and its scorch.
    fn sample(&self, pixel: usize) -> Sample {
        let (u, v) = self.surface.place(pixel);
        let Age { faded, dead } = self.age;
        let near = self.near(pixel);
        // Warped places keep cells and bands from looking drawn with a ruler.
        let warp = 0.010;
        let (x, y) = (u + warp * self.noise(1).octaves(u, v, 14.0), v + warp * self.noise(2).octaves(u, v, 14.0));
        let (patch, areole) = (self.noise(3).cell(x, y, PATCHES), self.noise(4).cell(x, y, AREOLES));
        let net = 1.0 - smooth_step(0.0, 0.16, areole.clearance);
        let (broad, blotch) = (self.noise(5).octaves(u, v, 2.7), self.noise(6).octaves(x, y, 8.0));
        let margin = self.surface.margin[pixel];
        let rim = expf(-margin / 0.055);
        let (speck, halo) = self.speck(x, y);

        // How far ahead of its leaf this place ages.
        let ahead = 0.8 * rim + 0.55 * broad + 0.45 * blotch + 0.55 * (patch.value - 0.5) + 0.35 * (areole.value - 0.5)
            - 1.45 * near.supply
            - 0.22 * net;
        let core = near.core[0].max(near.core[1]);
        let chlorophyll =
            expf(-mix(0.20, 1.45, faded) * ahead) * (1.0 - mix(0.60, 0.35, faded) * core) * (1.0 - 0.4 * halo);
        let redness =
            0.55 * broad + 0.35 * blotch + 0.45 * (patch.value - 0.5) + 0.30 * (areole.value - 0.5) + 0.35 * rim
                - 0.75 * near.supply
                - 0.15 * net;
        let anthocyanins = expf(mix(0.3, 1.0, faded) * redness) * (1.0 - 0.70 * core) * (1.0 + 0.3 * halo);
        Sample {
            contents: [chlorophyll, anthocyanins, self.scorch(margin, (x, y), broad, speck)],
            reflected: self.relief(&near, areole.value, net, (u, v)) * mix(1.0 + 0.45 * core, 1.0 + 0.22 * core, dead),
            transmitted: (1.0 - 0.45 * near.core[0]) * (1.0 - 0.25 * near.core[1]) * (1.0 - 0.08 * net),
        }
    }

    /// Specks at a warped place, so that none is a perfect disc.
    fn speck(&self, x: f32, y: f32) -> (f32, f32) {
        let size = self.surface.size;
        let pixel = |value: f32| ((value * size as f32).max(0.0) as usize).min(size - 1);
        self.specks[pixel(y) * size + pixel(x)]
    }

    /// Brown pigment of tissue that died early: a ragged band along parts of the margin, and specks.
    fn scorch(&self, margin: f32, (x, y): (f32, f32), broad: f32, speck: f32) -> f32 {
        // Whole stretches of the margin are spared; where it is scorched, the band's front is frayed at the scale of areoles.
        let stretch = smooth_step(-0.1, 0.9, broad + 0.6 * self.noise(10).octaves(x, y, 6.0));
        let frayed = 1.0 + 0.9 * self.noise(11).octaves(x, y, 26.0);
        let width = 0.022 * stretch * frayed * smooth_step(0.55, 1.0, self.age.faded);
        let band = if width > 0.0 { 1.0 - smooth_step(0.0, width, margin) } else { 0.0 };
        (1.5 * band + 1.0 * speck) * mix(1.0, 0.6, self.age.dead)
    }

    /// Light and shade of the surface itself: creases beside veins, tissue that bulges between them, fine grain.
    fn relief(&self, near: &Near, areole: f32, net: f32, (u, v): (f32, f32)) -> f32 {
        let crease = 0.12 * near.crease * (1.0 - near.core[0].max(near.core[1]));
        let grain = 0.03 * self.noise(7).octaves(u, v, 90.0);
        (1.0 - crease) * (1.0 + grain + 0.05 * (areole - 0.5)) * (1.0 + mix(0.02, 0.05, self.age.dead) * net)
    }

    /// Unevenness of the brown pigment that lies all over the blade, mean about 1, never below 0.3.
    fn tints(&self) -> impl Iterator<Item = f32> + '_ {
        let pixels = (0..self.surface.inside.len()).filter(|&pixel| self.surface.inside[pixel]);
        pixels.map(|pixel| {
            let (u, v) = self.surface.place(pixel);
            let cloud = 0.42 * self.noise(8).octaves(u, v, 3.1) + 0.30 * self.noise(9).octaves(u, v, 11.0);
            let patch = self.noise(3).cell(u, v, PATCHES).value - 0.5;
            (1.0 + cloud + 0.35 * patch - 0.45 * self.near(pixel).supply * self.age.dead).max(0.3)
        })
    }
}

/// Dead specks: a Poisson number of dots, sizes log-normal about 0.2 % of the texture, each with a halo.
fn specks(size: usize, age: Age, stream: &mut Stream) -> Vec<(f32, f32)> {
    let mut covered = vec![(0.0f32, 0.0f32); size * size];
    let (wanted, mut spent) = (f64::from(2.0 + 60.0 * age.faded), 0.0);
    loop {
        // Unit-rate events until `wanted` is spent are Poisson in number.
        spent += stream.exponential();
        if spent > wanted {
            return covered;
        }
        let (x, y) = (stream.uniform() as f32, stream.uniform() as f32);
        let radius = (0.0022 * expf(0.6 * stream.normal() as f32)).min(0.010);
        stamp(&mut covered, size, (x, y), radius);
    }
}

fn stamp(covered: &mut [(f32, f32)], size: usize, (x, y): (f32, f32), radius: f32) {
    let pixel = |value: f32| (value * size as f32).clamp(0.0, size as f32) as usize;
    let (reach, soft) = (3.0 * radius, 0.7 / size as f32);
    for row in pixel(y - reach)..pixel(y + reach) {
        for column in pixel(x - reach)..pixel(x + reach) {
            let (dx, dy) = ((column as f32 + 0.5) / size as f32 - x, (row as f32 + 0.5) / size as f32 - y);
            let distance = (dx * dx + dy * dy).sqrt();
            // A dot smaller than a pixel covers only part of it.
            let part = (radius * size as f32).min(1.0);
            let dot = part * (1.0 - smooth_step(radius - soft, radius + soft, distance));
            let (core, halo) = &mut covered[row * size + column];
            *core = core.max(dot);
            *halo = halo.max(part * (1.0 - smooth_step(radius, reach, distance)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::surface::tests::blade;
    use super::*;
    use crate::base::random::Purpose;

    fn turning() -> Pigments {
        Pigments { chlorophyll: 5.0, anthocyanins: 2.5, brown: 0.1, ..Pigments::default() }
    }

    fn field(variant: u64) -> (Surface, Vec<Sample>) {
        let surface = Surface::new(&blade(), 128);
        let samples = pigment_field(&surface, &turning(), &mut Stream::new(1, Purpose::Texture, 0, variant));
        (surface, samples)
    }

    /// Mean chlorophyll of the pixels that a condition picks.
    fn chlorophyll(surface: &Surface, samples: &[Sample], picks: impl Fn(usize) -> bool) -> f32 {
        let inside = (0..surface.inside.len()).filter(|&pixel| surface.inside[pixel]);
        let picked: Vec<f32> =
            inside.zip(samples).filter(|(pixel, _)| picks(*pixel)).map(|(_, sample)| sample.contents[0]).collect();
        picked.iter().sum::<f32>() / picked.len() as f32
    }

    #[test]
    fn means_are_the_states_contents() {
        let (_, samples) = field(0);
        assert!((mean(&samples, 0) - 5.0).abs() < 1e-3);
        assert!((mean(&samples, 1) - 2.5).abs() < 1e-3);
    }

    #[test]
    fn chlorophyll_stays_along_the_veins_and_leaves_the_margin_first() {
        let (surface, samples) = field(0);
        let vein = |pixel: usize| surface.veins[0][pixel].min(surface.veins[1][pixel]);
        let beside = chlorophyll(&surface, &samples, |pixel| (0.006..0.02).contains(&vein(pixel)));
        let between = chlorophyll(&surface, &samples, |pixel| vein(pixel) > 0.06 && surface.margin[pixel] > 0.1);
        let rim = chlorophyll(&surface, &samples, |pixel| vein(pixel) > 0.06 && surface.margin[pixel] < 0.03);
        assert!(beside > 1.5 * between, "{beside} {between}");
        assert!(between > 1.2 * rim, "{between} {rim}");
    }

    #[test]
    fn variants_differ_everywhere() {
        let ((_, one), (_, other)) = (field(0), field(1));
        let values = |samples: &[Sample]| samples.iter().map(|sample| sample.contents[1]).collect::<Vec<_>>();
        let (one, other) = (values(&one), values(&other));
        let same = one.iter().zip(&other).filter(|(a, b)| (*a - *b).abs() < 1e-3).count();
        assert!(same * 20 < one.len(), "{same} of {}", one.len());
    }
}
