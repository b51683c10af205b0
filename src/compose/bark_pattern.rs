//! What bark shows at a point: smooth bark with pores that lie across the stem, and over it, as it ages, the furrows,
//! plates, cracks or scars of its kind. Sizes are in metres and judged from photographs of the species named in
//! [`BarkKind`]; there is no relief in it, so depth is shown by darkness alone.

use crate::base::maths::{log2f, mix, sinf, smooth_step};
use crate::base::noise::{Fractal, Lattice};
use crate::base::random::hash;
use crate::tree::{BarkKind, Settings};
use std::f32::consts::PI;
use std::f64::consts::TAU;

type Colour = [f32; 3];

/// Colour of the lichen that old grey bark bears (linear, judged).
const LICHEN: Colour = [0.30, 0.33, 0.26];
/// Octaves of girth over which bark turns from young to old, on each side of half.
const TURNING: f32 = 2.2;
/// Radii between which wood loses the colour of twigs, metres.
const TWIG_RADII: [f64; 2] = [0.004, 0.035];

/// Metres that one repeat covers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    pub around: f64,
    pub along: f64,
}

impl Scale {
    /// Cells of a size (metres, around and along) in one repeat, at least two and one.
    fn cells(self, around: f64, along: f64) -> [u32; 2] {
        [((self.around / around).round() as u32).max(2), ((self.along / along).round() as u32).max(1)]
    }

    fn fractal(self, around: f64, along: f64, octaves: u32, salt: u64) -> Fractal {
        let [columns, rows] = self.cells(around, along);
        Fractal::new(columns, rows, octaves, salt)
    }
}

/// Cells that repeat with the texture.
struct Cells {
    lattice: Lattice,
    counts: [f32; 2],
}

impl Cells {
    fn new(scale: Scale, around: f64, along: f64, salt: u64) -> Self {
        let counts = scale.cells(around, along);
        Self { lattice: Lattice::periodic(salt, counts), counts: counts.map(|count| count as f32) }
    }

    fn at(&self, u: f32, v: f32) -> crate::base::noise::Cell {
        self.lattice.cell(u * self.counts[0], v * self.counts[1])
    }
}

/// The bark of one girth.
pub(super) struct Bark {
    kind: BarkKind,
    /// Colour of the smooth surface, of old plates, and of what lies deepest.
    smooth: Colour,
    plate: Colour,
    deep: Colour,
    /// 0 young, 1 old.
    age: f32,
    /// How much it is a limb's bark and not a twig's.
    limb: f32,
    /// Turns metres of wander into shares of the repeat.
    per_metre: [f32; 2],
    unit: f32,
    wander: Fractal,
    broad: Fractal,
    grain: Fractal,
    pores: Fractal,
    ridges: Fractal,
    cracks: Fractal,
    cells: Cells,
    scars: Cells,
}

impl Bark {
    /// The bark of wood of a radius (metres) in a texture of a size.
    pub(super) fn new(settings: &Settings, radius: f64, scale: Scale, salt: u64) -> Self {
        let colour = |colour: [f64; 3]| colour.map(|c| c as f32);
        let kind = settings.bark_kind;
        let unit = settings.bark_scale;
        let octave = log2f((TAU * radius / settings.bark_girth) as f32);
        let age = smooth_step(-TURNING, TURNING, octave);
        let twig = TWIG_RADII.map(|radius| log2f(radius as f32));
        let limb = smooth_step(twig[0], twig[1], log2f(radius as f32));
        let blended = |a: Colour, b: Colour, t: f32| -> Colour { std::array::from_fn(|k| mix(a[k], b[k], t)) };
        let (young, old) = (colour(settings.bark_young), colour(settings.bark));
        let salt = |number: u64| hash(salt, number);
        let deep = match kind {
            BarkKind::Papery => [0.022, 0.019, 0.017],
            BarkKind::Scarred => [0.045, 0.040, 0.033],
            _ => [0.24, 0.21, 0.19].map(|share| share * old[1]),
        };
        let (length, cleft, wave) = match kind {
            BarkKind::Ridged => (4.0, [1.6, 0.9], 7.0),
            BarkKind::Papery | BarkKind::Scarred => (2.2, [1.0, 2.2], 4.0),
            _ => (6.5, [0.7, 5.0], 4.0),
        };
        Self {
            kind,
            smooth: blended(colour(settings.twig_bark), young, limb),
            plate: blended(colour(settings.twig_bark), old, limb),
            deep,
            age,
            limb,
            per_metre: [(1.0 / scale.around) as f32, (1.0 / scale.along) as f32],
            unit: unit as f32,
            wander: scale.fractal(2.2 * unit, wave * unit, 2, salt(1)),
            broad: scale.fractal(0.11, 0.19, 2, salt(2)),
            grain: scale.fractal(0.0035, 0.011, 1, salt(3)),
            pores: scale.fractal(0.017, 0.0045, 1, salt(4)),
            ridges: scale.fractal(cleft[0] * unit, cleft[1] * unit, 2, salt(5)),
            cracks: scale.fractal(0.25 * unit, 0.6 * unit, 2, salt(6)),
            cells: Cells::new(scale, unit, length * unit, salt(7)),
            scars: Cells::new(scale, 0.14, 0.24, salt(8)),
        }
    }

    /// Reflectance at a place of the repeat, 0..1 both ways.
    pub(super) fn colour(&self, u: f32, v: f32) -> Colour {
        let broad = self.broad.at(u, v) - 0.5;
        let grain = self.grain.at(u, v) - 0.5;
        let smooth = self.smooth_at(u, v, broad, grain);
        // Wood turns old here sooner and there later.
        let age = (self.age + 5.0 * broad * self.age * (1.0 - self.age)).clamp(0.0, 1.0);
        if age <= 0.0 {
            return smooth;
        }
        let drift = (self.wander.at(u, v) - 0.5) * self.unit;
        let (x, y) = (u + drift * self.per_metre[0], v + 1.5 * drift * self.per_metre[1]);
        match self.kind {
            BarkKind::Smooth => self.wrinkled(smooth, x, y, age),
            BarkKind::Ridged => self.ridged(smooth, u, v, [age, broad, grain]),
            BarkKind::Plated => self.plated(smooth, x, y, [age, broad, grain]),
            BarkKind::Papery => self.cracked(smooth, x, y, [age, 0.80]),
            BarkKind::Scarred => {
                let scarred = self.scar(smooth, x, y, age);
                self.cracked(scarred, x, y, [age, 0.74])
            }
        }
    }

    fn smooth_at(&self, u: f32, v: f32, broad: f32, grain: f32) -> Colour {
        let (strength, tone) = match self.kind {
            BarkKind::Papery => (0.85, 0.35),
            BarkKind::Smooth => (0.16, 0.75),
            BarkKind::Scarred => (0.30, 0.45),
            _ => (0.35, 0.5),
        };
        let pores = smooth_step(0.70, 0.86, self.pores.at(u, v) + 0.25 * broad);
        let dark = pores * strength * (0.25 + 0.75 * self.limb);
        let light = (1.0 + tone * broad * self.limb + 0.30 * grain) * (1.0 - dark);
        let lichen = smooth_step(0.10, 0.22, broad) * 0.2 * self.limb;
        std::array::from_fn(|k| mix(self.smooth[k], LICHEN[k].max(self.smooth[k] * 0.9), lichen) * light)
    }

    /// Thick smooth bark: faint wrinkles and darker streaks where water runs.
    fn wrinkled(&self, smooth: Colour, x: f32, y: f32, age: f32) -> Colour {
        let streak = smooth_step(0.05, 0.30, (self.ridges.at(x, y) - 0.5).abs());
        let wrinkle = 1.0 - smooth_step(0.0, 0.06, (self.cracks.at(y, x) - 0.5).abs());
        smooth.map(|c| c * (1.0 - age * (0.16 * streak + 0.14 * wrinkle)))
    }

    /// Ridges that part and join: two families of furrows along the stem that wander and cross.
    fn ridged(&self, smooth: Colour, u: f32, v: f32, [age, broad, grain]: [f32; 3]) -> Colour {
        let count = self.cells.counts[0];
        let (one, other) = (self.wander.at(u, v) - 0.5, self.wander.at(u + 0.5, v + 0.31) - 0.5);
        let fine = 0.35 * (self.cracks.at(u, v) - 0.5);
        let height = |wander: f32| sinf(PI * (count * u + 2.4 * wander + fine)).abs();
        let (a, b) = (height(one), height(other + 0.1));
        let ridge = a.min(b + 0.12);
        let width = mix(0.10, 0.34, age);
        let furrow = 1.0 - smooth_step(0.25 * width, width, ridge);
        let side = 1.0 - smooth_step(width, 2.2 * width, ridge);
        let across = 1.0 - smooth_step(0.0, 0.035, (self.ridges.at(u, v) - 0.5).abs());
        let light = (1.0 + 0.5 * broad + 0.7 * grain) * (1.08 - 0.35 * side) * (1.0 - 0.35 * across);
        self.broken(smooth, light, furrow, age)
    }

    /// Long plates, each of its own tone, lighter where their sides come loose, split along the stem.
    fn plated(&self, smooth: Colour, x: f32, y: f32, [age, broad, grain]: [f32; 3]) -> Colour {
        let cell = self.cells.at(x, y);
        let width = mix(0.03, 0.16, age);
        let clearance = cell.clearance + 0.22 * (self.cracks.at(x, y) - 0.5);
        let furrow = 1.0 - smooth_step(0.1 * width, 1.6 * width, clearance);
        let edge =
            smooth_step(width, 1.6 * width, clearance) * (1.0 - smooth_step(1.6 * width, 3.2 * width, clearance));
        let split = 1.0 - smooth_step(0.0, 0.045, (self.ridges.at(x, y) - 0.5).abs());
        let light =
            (0.84 + 0.3 * cell.value) * (1.0 + 0.5 * broad + 0.9 * grain) * (1.0 + 0.15 * edge) * (1.0 - 0.45 * split);
        self.broken(smooth, light, 0.85 * furrow, age)
    }

    /// Dark cracks in diamonds on smooth bark, which cover more of it the older it is; none below an age.
    fn cracked(&self, smooth: Colour, x: f32, y: f32, [age, from]: [f32; 2]) -> Colour {
        let old = smooth_step(from - 0.25, 1.0, age);
        if old <= 0.0 {
            return smooth;
        }
        let cell = self.cells.at(x, y);
        let patch = self.ridges.at(x, y);
        let crack = smooth_step(0.64 - 0.16 * old, 0.68 - 0.15 * old, patch + 0.12 * (self.cracks.at(x, y) - 0.5));
        let rough = 0.75 + 0.5 * self.cracks.at(x, y);
        let relief = smooth_step(0.05, 0.30, cell.clearance) * (0.4 + 0.6 * cell.value);
        let dark: Colour = std::array::from_fn(|k| mix(self.deep[k], self.deep[k] * 3.2, relief) * rough);
        std::array::from_fn(|k| mix(smooth[k], dark[k], crack))
    }

    /// Dark eyes where branches were shed, wider than high, with a brow.
    fn scar(&self, smooth: Colour, x: f32, y: f32, age: f32) -> Colour {
        let cell = self.scars.at(x, y);
        if cell.value > 0.6 {
            return smooth;
        }
        let eye = 1.0 - smooth_step(0.055, 0.095 + 0.06 * cell.value, cell.distance);
        let ring = smooth_step(0.10, 0.14, cell.distance) * (1.0 - smooth_step(0.16, 0.22, cell.distance));
        let dark = (eye * 0.95).max(ring * 0.15) * smooth_step(0.05, 0.4, age);
        std::array::from_fn(|k| mix(smooth[k], self.deep[k], dark))
    }

    /// Old bark over smooth: it comes in patches first, and its furrows before its colour.
    fn broken(&self, smooth: Colour, light: f32, furrow: f32, age: f32) -> Colour {
        std::array::from_fn(|k| {
            let surface = mix(smooth[k] * mix(1.0, light, age), self.plate[k] * light, age);
            mix(surface, self.deep[k], furrow * smooth_step(0.0, 0.6, age))
        })
    }
}
