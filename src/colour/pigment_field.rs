//! Where in a blade the pigments are: how a leaf ages from its margin and between its veins, and where it is scorched.
//!
//! Each place has a lead, how far ahead of its leaf it ages: areoles and the patches they form each at their own pace, the
//! margin early, tissue near veins late. Chlorophyll is what is left behind a front that moves over the leads, so that its
//! borders are sharp and run along veinlets; anthocyanin follows a field of its own; dead tissue takes whole areoles, in
//! from the margin and in spots. Observed on scans of autumn leaves; amounts by eye.

use super::areoles::own;
use super::noise::Noise;
use super::palette::below;
use super::surface::{Surface, Tissue};
use super::{Painting, Pigments};
use crate::base::maths::{exp, expf, ln, mix, smooth_step};
use crate::base::random::Stream;
use crate::base::vector::Vec2;

/// Entries of a table over -1..1.
const ENTRIES: usize = 1024;
/// Beyond this the front's curve is flat, in its widths.
const TAIL: f32 = 8.0;

/// What one areole brings to the fields of a texture.
#[derive(Clone, Copy, Debug, Default)]
struct Share {
    lead: f32,
    /// Factor on anthocyanins.
    redness: f32,
    /// Distance from the margin up to which tissue is dead, texture widths.
    dry: f32,
    /// Brown pigment of dead spots, and how dead it is, 0..1.
    brown: f32,
    dead: f32,
    /// Factor on the brown pigment that lies all over the blade.
    tint: f32,
    /// Factor on chlorophyll.
    mottle: f32,
    /// Factor on reflected light.
    light: f32,
}

impl Share {
    /// A share with a part of another.
    #[inline]
    fn mixed(&self, other: &Self, part: f32) -> Self {
        Self {
            lead: mix(self.lead, other.lead, part),
            redness: mix(self.redness, other.redness, part),
            dry: mix(self.dry, other.dry, part),
            brown: mix(self.brown, other.brown, part),
            dead: mix(self.dead, other.dead, part),
            tint: mix(self.tint, other.tint, part),
            mottle: mix(self.mottle, other.mottle, part),
            light: mix(self.light, other.light, part),
        }
    }
}

/// The amounts by which the fields are scaled: found so that a texture's mean has its state's colour.
#[derive(Clone, Copy, Debug)]
pub(super) struct Amounts {
    /// The lead at which half of the chlorophyll is left.
    pub front: f32,
    /// Chlorophyll behind the front (ug/cm2).
    pub full: f32,
    /// Anthocyanins where the field is 1 (ug/cm2).
    pub anthocyanins: f32,
    /// Brown pigment of living tissue.
    pub brown: f32,
}

/// What a place holds, and how its surface looks.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sample {
    /// Chlorophyll and anthocyanins (ug/cm2) and brown pigment.
    pub contents: [f32; 3],
    /// Factors on light reflected above, let through, and reflected below.
    pub light: [f32; 3],
}

/// The fields of one texture.
pub(super) struct Fields<'a> {
    shares: Vec<Share>,
    painting: &'a Painting,
    /// How far a state has gone: 0 in a green leaf, 1 when the chlorophyll is gone; and 0 in a living leaf, 1 in a brown one.
    pub faded: f32,
    pub dead: f32,
    /// Width of the front, in leads.
    width: f32,
    /// The same of a vein itself.
    vein_paling: f32,
    /// How much longer tissue at veins keeps its chlorophyll, in leads.
    hold: f32,
    /// Share of its chlorophyll that a vein lacks.
    pale: f32,
    /// One over a fifth of a millimetre, in texture widths.
    per_fifth: f32,
    /// Factor on the brown pigment of what died before the leaf did.
    fresh_death: f32,
    /// The logistic function over -TAIL..TAIL.
    front: Vec<f32>,
    /// Share of its anthocyanin that tissue beside a vein lacks.
    paling: f32,
    /// Share of the brown pigment of living tissue that a vein lacks, and a veinlet.
    bare: [f32; 2],
}

impl<'a> Fields<'a> {
    /// The fields of a state's texture. `reference` is the chlorophyll of the green leaf; `stream` belongs to the texture.
    pub(super) fn new(
        surface: &Surface,
        painting: &'a Painting,
        pigments: &Pigments,
        reference: f64,
        stream: &mut Stream,
    ) -> Self {
        let faded = (1.0 - pigments.chlorophyll / reference.max(1e-6)).clamp(0.0, 1.0) as f32;
        let dead = smooth_step(0.4, 1.0, pigments.brown as f32);
        let logistic = |entry: usize| 1.0 / (1.0 + expf((2.0 * entry as f32 / ENTRIES as f32 - 1.0) * TAIL));
        let mut fields = Self {
            shares: Vec::new(),
            painting,
            faded,
            dead,
            // What little green a dead leaf has left lies nowhere in particular.
            width: painting.softness as f32 * mix(0.45, 0.15, smooth_step(0.2, 0.55, faded)) * (1.0 + 6.0 * dead),
            // A red or a dead leaf keeps little green at its veins.
            hold: painting.hold as f32
                * (1.0 - 0.9 * dead)
                * (1.0 - 0.6 * smooth_step(4.0, 12.0, pigments.anthocyanins as f32)),
            pale: 0.05 + 0.45 * (1.0 - faded) * (1.0 - faded) * (1.0 - faded),
            per_fifth: 5.0 / surface.millimetre,
            fresh_death: mix(1.0, 0.7, dead),
            front: (0..=ENTRIES).map(logistic).collect(),
            vein_paling: 0.5 * (1.0 - dead),
            paling: mix(0.25, 0.5, faded),
            bare: [mix(0.3, 0.62, dead), mix(0.0, 0.3, dead)],
        };
        let salt = stream.bits();
        let clouds = Clouds::new(salt);
        let used = surface.used.iter().enumerate();
        let share = |(number, used): (usize, &bool)| {
            if *used { fields.share(surface, &clouds, number, salt) } else { Share::default() }
        };
        fields.shares = used.map(share).collect();
        fields.add_spots(surface, stream);
        fields
    }

    /// Amounts before any matching: those of a leaf whose mean contents are the state's.
    pub(super) fn amounts(&self, pigments: &Pigments, reference: f64, tissue: &[Tissue]) -> Amounts {
        // What is behind the front has lost some of the green leaf's chlorophyll too.
        let share = f64::from(mix(0.7, 0.5, smooth_step(0.8, 1.0, self.faded)));
        let rest = (reference / pigments.chlorophyll.max(0.05)).max(1.0);
        let full = (1.05 * pigments.chlorophyll * exp(share * ln(rest))) as f32;
        let mut amounts = Amounts { front: 0.0, full, anthocyanins: 1.0, brown: 0.0 };
        let (mut low, mut high) = (-4.0f32, 4.0f32);
        for _ in 0..10 {
            amounts.front = 0.5 * (low + high);
            if self.mean(tissue, 0, &amounts) < pigments.chlorophyll {
                low = amounts.front;
            } else {
                high = amounts.front;
            }
        }
        amounts.anthocyanins = (pigments.anthocyanins / self.mean(tissue, 1, &amounts).max(1e-6)) as f32;
        let spent = self.mean(tissue, 2, &amounts);
        amounts.brown = (pigments.brown - spent).max(0.35 * pigments.brown) as f32;
        amounts
    }

    /// The largest contents that a palette must hold.
    pub(super) fn most(&self, amounts: &Amounts, pigments: &Pigments) -> [f32; 3] {
        let reddest = self.shares.iter().map(|share| share.redness).fold(1.0, f32::max);
        [
            (1.5 * amounts.full).max(8.0),
            (1.6 * amounts.anthocyanins * reddest.min(4.0)).max(6.0),
            (3.0 * pigments.brown as f32).max(3.0),
        ]
    }

    fn mean(&self, tissue: &[Tissue], content: usize, amounts: &Amounts) -> f64 {
        let sum: f64 = tissue.iter().map(|tissue| f64::from(self.at(tissue, amounts).contents[content])).sum();
        sum / tissue.len().max(1) as f64
    }

    /// What a place holds.
    #[inline]
    pub(super) fn at(&self, tissue: &Tissue, amounts: &Amounts) -> Sample {
        let share = &self.shares[tissue.areole as usize];
        let share =
            if tissue.beyond > 0.0 { share.mixed(&self.shares[tissue.next as usize], tissue.beyond) } else { *share };
        let lead = share.lead + tissue.lead + 0.22 * tissue.grain
            - self.hold * (0.5 * tissue.supply + 0.3 * tissue.vein + 0.12 * tissue.veinlet);
        // The front of what dried up at the margin: ragged, darkest where it came to rest.
        let inward = share.dry * (1.0 + 0.2 * tissue.grain) - tissue.margin;
        let scorch = (inward * self.per_fifth).clamp(0.0, 1.0);
        let rest = (1.0 - 0.2 * inward * self.per_fifth).clamp(0.0, 1.0);
        let dead = share.dead.max(scorch);
        // A pale vein in a green leaf; the last green in a yellow one.
        let pale = 1.0 - self.pale * tissue.vein.max(0.4 * tissue.veinlet);
        let behind = read(&self.front, (lead - amounts.front) / (self.width * TAIL));
        let chlorophyll = amounts.full
            * share.mottle
            * pale
            * (1.0 - 0.8 * dead)
            * (1.0 - 0.8 * self.dead * tissue.vein)
            * behind.max(0.25 * share.dead);
        let anthocyanins = amounts.anthocyanins
            * (share.redness * tissue.redness)
            * (1.0 - self.paling * tissue.beside)
            * (1.0 + 0.35 * tissue.grain)
            * (1.0 - self.vein_paling * tissue.vein)
            * (1.0 - 0.22 * tissue.veinlet)
            * (1.0 - 0.7 * dead);
        // Veins hold less of the brown, most of all in a dead leaf, where all of them show as pale lines.
        let bare = (1.0 - self.bare[0] * tissue.vein) * (1.0 - self.bare[1] * tissue.veinlet);
        let brown = amounts.brown * share.tint * (1.0 + 0.3 * tissue.grain) * bare
            + (share.brown.max(scorch * (0.9 + 1.5 * rest) * self.fresh_death) + tissue.brown)
                * (1.0 - 0.3 * tissue.vein);
        let bright = tissue.vein * mix(0.24, 0.10, self.faded) * (1.0 - self.dead) + tissue.veinlet * 0.05;
        let light = tissue.light * share.light;
        Sample {
            contents: [chlorophyll, anthocyanins, brown],
            light: [light * (1.0 + bright), tissue.through, light * (1.0 + 1.3 * bright)],
        }
    }

    /// The part of an areole in everything but spots.
    fn share(&self, surface: &Surface, clouds: &Clouds, number: usize, salt: u64) -> Share {
        let areole = surface.net.areoles[number];
        let own_of = |layer: u64, number: u32| own(salt ^ layer << 56, number) - 0.5;
        let (patch, single) = (own_of(1, areole.patch), own_of(2, number as u32));
        let [broad, blotch, shadow, ragged, cloud] = clouds.at(areole.place);
        let (margin, supply) = surface.about(areole.place);
        let rim = expf(-margin / 0.06);
        let painting = self.painting;
        let uneven = painting.patchiness as f32;
        let lead = painting.margin as f32 * rim
            + uneven * (0.42 * broad + 0.36 * blotch + 0.40 * patch + 0.26 * single)
            - 0.55 * self.hold * supply;
        // Leaves that lay on this one kept the sun, and the red, from part of it.
        let shaded = smooth_step(0.0, 0.10, shadow - 0.45);
        let red = uneven * (0.34 * broad + 0.40 * ragged + 0.45 * own_of(3, areole.patch) + 0.34 * single) + 0.30 * rim
            - 0.6 * shaded;
        Share {
            lead,
            redness: expf(mix(0.35, 1.0, self.faded) * red),
            dry: self.scorch(broad, ragged + 0.5 * single + 0.5 * patch) * surface.millimetre,
            brown: 0.0,
            dead: 0.0,
            tint: (1.0 + 0.45 * cloud + 0.42 * patch + 0.30 * single - 0.4 * supply * self.dead).max(0.25),
            mottle: 1.0 + 0.16 * single + 0.14 * patch + 0.12 * blotch,
            light: 1.0 + 0.05 * own_of(4, number as u32) + 0.05 * own_of(4, areole.patch),
        }
    }

    /// How far the margin dried up at an areole, millimetres: in stretches, along a ragged front.
    fn scorch(&self, broad: f32, frayed: f32) -> f32 {
        let stretch = smooth_step(0.0, 0.8, broad + 0.4 * frayed);
        self.painting.scorch as f32 * stretch * (1.0 + 0.6 * frayed).max(0.0) * smooth_step(0.5, 1.0, self.faded)
    }

    /// Dead spots: Poisson in number, log-normal in size, made of whole areoles, pale within a dark rim when they are
    /// large, and with a yellow halo in green leaves.
    fn add_spots(&mut self, surface: &Surface, stream: &mut Stream) {
        let wanted = self.painting.spots * f64::from(0.06 + 0.94 * self.faded);
        let mut spent = 0.0;
        loop {
            // Unit-rate events until `wanted` is spent are Poisson in number.
            spent += stream.exponential();
            if spent > wanted {
                return;
            }
            let place = Vec2::new(stream.uniform() as f32, stream.uniform() as f32);
            let radius = (0.38 * expf(0.75 * stream.normal() as f32)).min(3.0) * surface.millimetre;
            let ragged = stream.bits();
            self.add_spot(surface, place, radius, ragged);
        }
    }

    fn add_spot(&mut self, surface: &Surface, place: Vec2, radius: f32, ragged: u64) {
        let large = radius > 2.2 * surface.net.width;
        for number in surface.net.around(place, 2.2 * radius) {
            let Some(areole) = surface.net.areoles.get(number) else { continue };
            let frayed = 1.0 + 0.7 * (own(ragged, number as u32) - 0.5);
            let far = (areole.place - place).norm() / (radius * frayed);
            let share = &mut self.shares[number];
            if far < 1.15 {
                let centre = large && far < 0.62;
                let dead = 1.0 - smooth_step(0.8, 1.15, far);
                share.dead = share.dead.max(dead);
                share.brown = share.brown.max(dead * if centre { 0.9 } else { 2.6 } * mix(1.0, 0.75, self.dead));
            } else if far < 1.9 {
                share.lead += 0.6 * (1.9 - far);
                share.redness *= 1.0 + 0.3 * (1.9 - far);
            }
        }
    }
}

/// Smooth unevenness over the texture, on a grid: cheap to read at every areole.
struct Clouds(Vec<[f32; 5]>);

impl Clouds {
    /// Cells of the grid along each side.
    const GRID: usize = 48;
    /// Frequencies of what ages broadly, in blotches, lies in another leaf's shade, is ragged, and browns in clouds.
    const FREQUENCIES: [f32; 5] = [2.6, 8.5, 1.7, 7.0, 3.1];

    fn new(salt: u64) -> Self {
        let noise = |layer: usize| Noise(salt.wrapping_add((layer as u64 + 5).wrapping_mul(0x9E37_79B9_7F4A_7C15)));
        let node = |index: usize| {
            let place = |i: usize| i as f32 / Self::GRID as f32;
            let (x, y) = (place(index % (Self::GRID + 1)), place(index / (Self::GRID + 1)));
            std::array::from_fn(|layer| noise(layer).octaves(x, y, Self::FREQUENCIES[layer]))
        };
        Self((0..(Self::GRID + 1) * (Self::GRID + 1)).map(node).collect())
    }

    fn at(&self, place: Vec2) -> [f32; 5] {
        let axis = |value: f32| {
            let value = value.clamp(0.0, 1.0) * Self::GRID as f32;
            let node = (value as usize).min(Self::GRID - 1);
            (node, value - node as f32)
        };
        let ((column, u), (row, v)) = (axis(place.x), axis(place.y));
        let first = row * (Self::GRID + 1) + column;
        let [a, b, c, d] = [first, first + 1, first + Self::GRID + 1, first + Self::GRID + 2].map(|i| &self.0[i]);
        std::array::from_fn(|k| mix(mix(a[k], b[k], u), mix(c[k], d[k], u), v))
    }
}

/// A table over -1..1, linear between entries, its ends beyond.
#[inline]
fn read(table: &[f32], x: f32) -> f32 {
    let place = ((x + 1.0) * (0.5 * ENTRIES as f32)).clamp(0.0, ENTRIES as f32 - 0.01);
    let entry = below(place).min(ENTRIES - 1);
    let (low, high) = (table[entry], table[entry + 1]);
    low + (high - low) * (place - entry as f32)
}

#[cfg(test)]
mod tests {
    use super::super::surface::tests::blade;
    use super::*;
    use crate::base::random::Purpose;

    const GREEN: f64 = 38.0;

    /// The tissue and what it holds, of a leaf with some of its chlorophyll left.
    fn field(left: f64, variant: u64) -> (Surface, Vec<Sample>) {
        let pigments = Pigments { chlorophyll: left * GREEN, anthocyanins: 2.5, brown: 0.1, ..Pigments::default() };
        let surface = Surface::new(&blade(), 256);
        let painting = Painting::default();
        let mut stream = Stream::new(1, Purpose::Texture, 0, variant);
        let fields = Fields::new(&surface, &painting, &pigments, GREEN, &mut stream);
        let amounts = fields.amounts(&pigments, GREEN, &surface.tissue);
        let samples = surface.tissue.iter().map(|tissue| fields.at(tissue, &amounts)).collect();
        (surface, samples)
    }

    /// Mean of a content over the tissue that a condition picks.
    fn mean(surface: &Surface, samples: &[Sample], content: usize, picks: impl Fn(&Tissue) -> bool) -> f32 {
        let picked: Vec<f32> = surface
            .tissue
            .iter()
            .zip(samples)
            .filter(|(tissue, _)| picks(tissue))
            .map(|(_, sample)| sample.contents[content])
            .collect();
        picked.iter().sum::<f32>() / picked.len() as f32
    }

    #[test]
    fn before_matching_means_are_the_states_contents() {
        for left in [0.9, 0.5, 0.15, 0.03] {
            let (surface, samples) = field(left, 0);
            let chlorophyll = f64::from(mean(&surface, &samples, 0, |_| true));
            assert!((chlorophyll / (left * GREEN) - 1.0).abs() < 0.02, "{chlorophyll} at {left}");
            assert!((mean(&surface, &samples, 1, |_| true) - 2.5).abs() < 0.01);
        }
    }

    #[test]
    fn at_half_the_chlorophyll_veins_hold_half_as_much_again_as_the_fields_between() {
        for variant in 0..3 {
            let (surface, samples) = field(0.5, variant);
            let veins = mean(&surface, &samples, 0, |tissue| tissue.vein > 0.7);
            let beside = mean(&surface, &samples, 0, |tissue| tissue.vein == 0.0 && tissue.supply > 0.5);
            let between = mean(&surface, &samples, 0, |tissue| tissue.vein == 0.0 && tissue.supply < 0.3);
            assert!(veins > 1.5 * between && beside > 1.5 * between, "{veins} {beside} {between}");
        }
    }

    #[test]
    fn chlorophyll_leaves_the_margin_first() {
        let (surface, samples) = field(0.5, 0);
        let middle = mean(&surface, &samples, 0, |tissue| tissue.supply < 0.3 && tissue.margin > 0.1);
        let rim = mean(&surface, &samples, 0, |tissue| tissue.supply < 0.3 && tissue.margin < 0.03);
        assert!(middle > 1.2 * rim, "{middle} {rim}");
    }

    #[test]
    fn in_a_green_leaf_veins_are_paler_than_the_fields_between() {
        let (surface, samples) = field(1.0, 0);
        let veins = mean(&surface, &samples, 0, |tissue| tissue.vein > 0.7);
        assert!(veins < 0.8 * mean(&surface, &samples, 0, |tissue| tissue.vein == 0.0));
    }

    #[test]
    fn what_turns_is_bounded_by_veinlets() {
        // Over a border of two areoles chlorophyll changes more than within either, by the same distance.
        let (surface, samples) = field(0.4, 0);
        let numbers: Vec<usize> = surface.pixels().collect();
        let (mut across, mut within) = ((0.0, 0), (0.0, 0));
        for (pair, contents) in surface
            .tissue
            .windows(2)
            .zip(samples.windows(2))
            .zip(numbers.windows(2))
            .filter_map(|((tissue, samples), numbers)| (numbers[1] == numbers[0] + 1).then_some((tissue, samples)))
        {
            let change = (contents[1].contents[0] - contents[0].contents[0]).abs();
            let borders = pair[0].areole != pair[1].areole || pair.iter().any(|tissue| tissue.beyond > 0.0);
            let side = if borders { &mut across } else { &mut within };
            *side = (side.0 + change, side.1 + 1);
        }
        let mean = |(sum, count): (f32, usize)| sum / count as f32;
        assert!(mean(across) > 1.3 * mean(within), "{across:?} {within:?}");
    }

    #[test]
    fn variants_differ() {
        let ((_, one), (_, other)) = (field(0.3, 0), field(0.3, 1));
        let same = one.iter().zip(&other).filter(|(a, b)| (a.contents[1] - b.contents[1]).abs() < 1e-3).count();
        assert!(same * 20 < one.len(), "{same} of {}", one.len());
    }
}
