//! The edge of a wood, unrolled: crowns of clumps of foliage on the rows behind a hem of bushes, drawn once into textures of
//! form and light that wrap at the rim. The colours are left to who draws the picture.

use crate::base::maths::{exp, sin};
use crate::base::random::{Purpose, Stream, hash_unit};
use crate::frame::{Texture, Wood};
use std::f64::consts::TAU;

/// Pixels along and up.
const WIDTH: usize = 2048;
const HEIGHT: usize = 128;
/// Metres that a pixel covers: 0.03 degrees from the meadow's middle.
const PIXEL: f64 = 0.212;
/// Distance of the edge, metres, and its repeats around the horizon, which follow from the width.
const DISTANCE: f64 = WIDTH as f64 * PIXEL * REPEATS as f64 / TAU;
const REPEATS: u32 = 6;
/// Rows of trees behind one another, their distance in metres, and metres of edge a tree of a row.
const ROWS: u32 = 3;
const ROW_DEPTH: f64 = 7.0;
const SPACING: f64 = 5.6;
/// Metres of edge a bush of the hem.
const BUSHES: f64 = 1.3;

/// Rows at the ground that are closed.
const FLOOR: usize = 12;

/// What a pixel shows.
#[derive(Clone, Copy)]
struct Texel {
    /// Towards the meadow, metres.
    depth: f64,
    normal: [f64; 2],
    kind: f64,
    light: f64,
    thin: f64,
    covered: bool,
}

/// A clump of foliage: a ball.
struct Clump {
    x: f64,
    y: f64,
    depth: f64,
    radius: f64,
    kind: f64,
    /// Light that comes to its middle, 0..1.
    light: f64,
}

/// The edge with the numbers that its textures have.
pub(super) fn wood(form: u32, crowns: u32) -> Wood {
    Wood { form, crowns, distance: DISTANCE as f32, height: (HEIGHT as f64 * PIXEL) as f32, repeats: REPEATS }
}

/// The textures of form and of crowns.
pub(super) fn textures(seed: u64) -> [Texture; 2] {
    let empty = Texel { depth: f64::MIN, normal: [0.0, 0.3], kind: 0.5, light: 0.3, thin: 0.0, covered: false };
    let mut texels = vec![empty; WIDTH * HEIGHT];
    for clump in interior(seed).chain(trees(seed)).chain(bushes(seed)) {
        draw(&mut texels, &clump, seed);
    }
    // No sky shows between the stems.
    for texel in texels[(HEIGHT - FLOOR) * WIDTH..].iter_mut().filter(|texel| !texel.covered) {
        *texel = Texel { light: 0.12, covered: true, ..*texel };
    }
    let code = |value: f64| (128.0 + 127.0 * value.clamp(-1.0, 1.0)) as u8;
    let of = |name: &str, values: &dyn Fn(&Texel) -> [f64; 3]| Texture {
        name: name.to_owned(),
        width: WIDTH as u32,
        height: HEIGHT as u32,
        pixels: texels.iter().map(|texel| values(texel).map(code)).collect(),
        repeat: true,
    };
    [
        of("wood_form", &|texel| [f64::from(u8::from(texel.covered)), texel.normal[0], texel.normal[1]]),
        of("wood_crowns", &|texel| [texel.kind, texel.light, texel.thin]),
    ]
}

/// The dark between the stems.
fn interior(seed: u64) -> impl Iterator<Item = Clump> {
    (0..180u64).map(move |number| {
        let mut random = Stream::new(seed, Purpose::Surroundings, number, 20);
        let x = (number as f64 + random.uniform()) / 180.0 * WIDTH as f64 * PIXEL;
        let y = random.range(1.0, 5.0);
        Clump { x, y, depth: -30.0, radius: random.range(2.5, 4.5), kind: random.uniform(), light: 0.10 }
    })
}

fn trees(seed: u64) -> impl Iterator<Item = Clump> {
    let length = WIDTH as f64 * PIXEL;
    let in_row = (length / SPACING) as u64;
    (0..u64::from(ROWS) * in_row).flat_map(move |number| {
        let mut random = Stream::new(seed, Purpose::Surroundings, number, 21);
        let row = (number / in_row) as f64;
        let x = ((number % in_row) as f64 + random.range(-0.4, 1.4)) * SPACING;
        // Stands of tall and of low trees follow one another; the rows behind are taller.
        let stand = 0.5 + 0.28 * sin(x * TAU / length * 5.0 + 1.0) + 0.22 * sin(x * TAU / length * 13.0);
        let height = (8.0 + 6.0 * stand + 1.6 * row) * exp(0.16 * random.normal().clamp(-2.0, 2.0));
        let width = height * random.range(0.26, 0.42);
        let kind = random.uniform();
        let depth = -row * ROW_DEPTH - random.range(0.0, 4.0);
        let foot = height * random.range(0.10, 0.28);
        let count = (14.0 + height) as u64;
        (0..count).map(move |clump| {
            let mut random = Stream::new(seed, Purpose::Surroundings, number << 8 | clump, 22);
            // Clumps lie on the crown's surface, an ellipsoid that is widest below its middle.
            let up = random.uniform();
            let turn = random.range(0.0, TAU);
            let girth = (up * (1.0 - up)).sqrt() * 2.0 * (1.12 - 0.35 * up);
            let out = random.range(0.55, 1.0) * width * girth;
            let radius = height * random.range(0.07, 0.13);
            let y = (foot + up * (height - foot)).min(height - 0.5 * radius);
            let (across, towards) = (out * sin(turn), out * sin(turn + 0.25 * TAU));
            // Upper and outer clumps stand in the light; those between neighbours do not.
            let light = (0.30 + 0.75 * up) * (0.75 + 0.25 * towards / width.max(0.1));
            Clump { x: x + across, y, depth: depth + towards, radius, kind, light: light.clamp(0.12, 1.0) }
        })
    })
}

/// The hem of bushes and tall herbs.
fn bushes(seed: u64) -> impl Iterator<Item = Clump> {
    let length = WIDTH as f64 * PIXEL;
    (0..(length / BUSHES) as u64).map(move |number| {
        let mut random = Stream::new(seed, Purpose::Surroundings, number, 23);
        let x = (number as f64 + random.uniform()) * BUSHES;
        let thick = 0.5 + 0.5 * sin(x * TAU / length * 9.0 + 2.0);
        let radius = random.range(0.5, 1.2) * (0.6 + 1.5 * thick);
        let y = radius * random.range(-0.2, 0.9);
        Clump { x, y, depth: random.range(2.0, 6.0), radius, kind: random.uniform(), light: random.range(0.4, 0.75) }
    })
}

/// Draws a clump where nothing stands before it; leaves fray its rim.
fn draw(texels: &mut [Texel], clump: &Clump, seed: u64) {
    let [left, right] = [-1.0, 1.0].map(|side| ((clump.x + side * clump.radius) / PIXEL).floor() as i64);
    let [low, high] = [-1.0, 1.0].map(|side| ((clump.y + side * clump.radius) / PIXEL).floor() as i64);
    for (row, column) in (low.max(0)..=high.min(HEIGHT as i64 - 1)).flat_map(|y| (left..=right).map(move |x| (y, x))) {
        let across = ((column as f64 + 0.5) * PIXEL - clump.x) / clump.radius;
        let up = ((row as f64 + 0.5) * PIXEL - clump.y) / clump.radius;
        let place = (HEIGHT - 1 - row as usize) * WIDTH + column.rem_euclid(WIDTH as i64) as usize;
        let noise = |salt: u64| f64::from(hash_unit(seed ^ salt, place as u64));
        let distance = across * across + up * up + 0.55 * (noise(1) - 0.5);
        let texel = &mut texels[place];
        if distance >= 1.0 || texel.depth >= clump.depth + clump.radius * (1.0 - distance).min(1.0).sqrt() {
            continue;
        }
        *texel = Texel {
            depth: clump.depth + clump.radius * (1.0 - distance).min(1.0).sqrt(),
            normal: [0.8 * across + 0.7 * (noise(2) - 0.5), 0.8 * up + 0.7 * (noise(3) - 0.5)],
            kind: clump.kind,
            // A clump's lower half lies in its own shade.
            light: clump.light * (0.72 + 0.28 * up) * (0.7 + 0.6 * noise(4)),
            thin: distance.clamp(0.0, 1.0),
            covered: true,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_edge_is_closed_below_and_open_above_and_wraps() {
        let [form, crowns] = textures(1);
        assert_eq!((form.pixels.len(), crowns.pixels.len()), (WIDTH * HEIGHT, WIDTH * HEIGHT));
        let covered = |row: usize| {
            let line = &form.pixels[row * WIDTH..(row + 1) * WIDTH];
            line.iter().filter(|pixel| pixel[0] == 255).count() as f64 / WIDTH as f64
        };
        assert!(covered(0) < 0.02 && covered(HEIGHT / 2) > 0.25 && covered(HEIGHT - 12) > 0.97);
        let tops: Vec<usize> =
            (0..WIDTH).map(|x| (0..HEIGHT).find(|y| form.pixels[y * WIDTH + x][0] == 255).unwrap_or(HEIGHT)).collect();
        let steps: Vec<usize> = (0..WIDTH).map(|x| tops[x].abs_diff(tops[(x + 1) % WIDTH])).collect();
        let largest = steps[..WIDTH - 1].iter().copied().max().unwrap_or(0);
        assert!(steps[WIDTH - 1] <= largest);
    }

    #[test]
    fn repeats_close_the_circle() {
        let wood = wood(0, 1);
        let around = f64::from(wood.repeats) * WIDTH as f64 * PIXEL;
        assert!((around / (TAU * f64::from(wood.distance)) - 1.0).abs() < 1e-6);
    }
}
