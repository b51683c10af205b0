//! The texture of a meadow, blades of grass drawn over soil, or of bare soil; wrapping at the rim so that it tiles.

use super::falls;
use super::{Garment, Stand, Stock};
use crate::base::encoding::SrgbEncoder;
use crate::base::maths::{cos, mix, sin, smooth_step};
use crate::base::noise::Fractal;
use crate::base::random::{Purpose, Stream, hash};
use crate::frame::{Ground, Texture, Wood};
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Pixels along one side.
const SIZE: i32 = 512;
/// Metres that one repeat covers: 2.5 mm a pixel, the width of a blade of grass.
const TILE: f32 = 1.28;
/// Blades in one repeat, about 6,000 a square metre of those that show.
const BLADES: u64 = 10_000;

/// Metres after which clear air of turbidity 1 hides all but 1/e (judged: a visual range of 50 km at turbidity 2.5, less what
/// dust and damp near the ground take).
const HAZE: f64 = 18_000.0;

/// The ground with its texture's number, in air of a turbidity.
pub(super) fn ground(texture: u32, turbidity: f64, is_grass: bool) -> Ground {
    let blades = if is_grass { 1.0 } else { 0.0 };
    let haze = (HAZE / turbidity) as f32;
    Ground { texture, tile: TILE, haze, blades, ..Ground::default() }
}

/// The feet of a stand's trunks, metres.
pub(super) fn feet(stand: &Stand) -> Vec<[f32; 3]> {
    let trunks = falls::ground(stand).trunks.into_iter();
    trunks.map(|trunk| [trunk.place.x as f32, trunk.place.y as f32, trunk.radius as f32]).collect()
}

/// Share of the leaf sites that are bare, 0..1; trees without any are bare.
fn bareness(worn: &[Option<Garment>]) -> f32 {
    let hanging = worn.iter().flatten().count();
    1.0 - hanging as f32 / worn.len().max(1) as f32
}

/// Steps in which a season's shares are told: a step changes no colour by more than half a code, and what shows them stays as
/// it is on days on which hardly a leaf turns.
const STEPS: f32 = 256.0;

/// A share, 0..1, told in steps.
fn in_steps(share: f32) -> f32 {
    (share * STEPS + 0.5).floor() / STEPS
}

/// The states in which leaves are green.
pub(super) const GREEN: [&str; 3] = ["flush", "green", "late-green"];

impl Stock {
    /// How far grass has gone into its winter rest: it dulls as the trees turn and bleaches as they drop their leaves (judged).
    fn dormancy(&self, worn: &[Option<Garment>]) -> f32 {
        let is_green = |garment: &&Garment| self.green.get(usize::from(garment.state)).is_some_and(|green| *green);
        let green = worn.iter().flatten().filter(is_green).count() as f32 / worn.len().max(1) as f32;
        0.32 * smooth_step(0.1, 1.0, 1.0 - green) + 0.68 * smooth_step(0.25, 1.0, bareness(worn))
    }

    /// The ground as it looks while the trees wear this.
    pub(super) fn ground_in_season(&self, worn: &[Option<Garment>]) -> Option<Ground> {
        let mut ground = self.ground.clone()?;
        ground.dormant = in_steps(self.dormancy(worn));
        ground.wood = ground.wood.map(|wood| Wood { bareness: in_steps(bareness(worn)), ..wood });
        Some(ground)
    }

    /// The textures, those of the wood on the horizon among them.
    pub(super) fn textures_with_wood(&self) -> Vec<Arc<Texture>> {
        let mut textures = self.textures.clone();
        if let Some(edge) = &self.wood_edge {
            edge.put(&mut textures);
        }
        textures
    }
}

/// Paints the meadow, or bare soil.
pub(super) fn texture(seed: u64, is_grass: bool) -> Texture {
    let (soils, droughts) = (Fractal::new(48, 48, 1, hash(seed, 1)), Fractal::new(3, 3, 3, hash(seed, 2)));
    let crumbs = Fractal::new(16, 16, 4, hash(seed, 4));
    let mut linear = vec![[0.0f32; 3]; (SIZE * SIZE) as usize];
    linear.par_iter_mut().enumerate().for_each(|(index, texel)| {
        let (u, v) = ((index as i32 % SIZE) as f32 / SIZE as f32, (index as i32 / SIZE) as f32 / SIZE as f32);
        let soil = 0.6 + 0.8 * soils.at(u, v);
        *texel = if is_grass {
            [0.055 * soil, 0.058 * soil, 0.022 * soil]
        } else {
            let crumbs = soil * (0.55 + 0.9 * crumbs.at(u, v)) * (0.7 + 0.6 * droughts.at(u, v));
            [0.135 * crumbs, 0.100 * crumbs, 0.068 * crumbs]
        };
    });
    for blade in 0..if is_grass { BLADES } else { 0 } {
        draw_blade(&mut linear, &droughts, seed, blade);
    }
    let encoder = SrgbEncoder::default();
    let pixels = linear.iter().map(|texel| texel.map(|value| encoder.code(value))).collect();
    Texture {
        name: "ground".to_owned(),
        width: SIZE as u32,
        height: SIZE as u32,
        pixels: Arc::new(pixels),
        repeat: true,
    }
}

fn draw_blade(linear: &mut [[f32; 3]], droughts: &Fractal, seed: u64, number: u64) {
    let mut random = Stream::new(seed, Purpose::Surroundings, number, 0);
    let (x, y) = (random.range(0.0, f64::from(SIZE)), random.range(0.0, f64::from(SIZE)));
    let angle = random.range(0.0, TAU);
    let length = random.range(8.0, 26.0);
    let (u, v) = (x as f32 / SIZE as f32, y as f32 / SIZE as f32);
    let dry = droughts.at(u, v) * 0.4 - 0.26 + 0.35 * random.uniform() as f32;
    let shade = random.range(0.55, 1.25) as f32;
    let green = [0.078, 0.142, 0.028];
    let straw = [0.26, 0.22, 0.085];
    let colour: [f32; 3] = std::array::from_fn(|k| mix(green[k], straw[k], dry.clamp(0.0, 1.0)) * shade);
    let steps = length as usize;
    for step in 0..steps {
        let t = step as f64;
        let column = ((x + cos(angle) * t) as i32).rem_euclid(SIZE);
        let row = ((y + sin(angle) * t) as i32).rem_euclid(SIZE);
        // The root of a blade lies deeper in the sward, hence darker.
        let lift = 0.55 + 0.45 * (t / length) as f32;
        linear[(row * SIZE + column) as usize] = colour.map(|c| c * lift);
    }
}
