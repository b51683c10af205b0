//! The edge of a wood, unrolled: trees of several forms on rows behind a hem of bushes, drawn once into textures of form and
//! light that wrap at the rim, in leaf and bare. The colours are left to who draws the picture.

use super::distant_tree::{Clump, Form, Stroke, Tree};
use crate::base::maths::{exp, sin};
use crate::base::noise::Lattice;
use crate::base::random::{Purpose, Stream, hash, hash_unit};
use crate::frame::{Texture, Wood};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Pixels along and up.
const WIDTH: usize = 2048;
const HEIGHT: usize = 256;
/// Metres that a pixel covers: 0.015 degrees from the meadow's middle.
const PIXEL: f64 = 0.106;
/// Metres that one repeat covers.
const LENGTH: f64 = WIDTH as f64 * PIXEL;
/// Distance of the edge, metres, and its repeats around the horizon, which follow from the width.
const DISTANCE: f64 = LENGTH * REPEATS as f64 / TAU;
const REPEATS: u32 = 12;
/// Rows of trees behind one another, their distance in metres, and metres of edge a tree of a row.
const ROWS: u64 = 3;
const ROW_DEPTH: f64 = 6.0;
const SPACING: f64 = 6.2;
/// Metres of edge a bush of the hem.
const BUSHES: f64 = 1.9;
/// Stems that stand deeper in the wood, seen where it is bare.
const STEMS: u64 = 420;
/// Columns that are drawn together.
const STRIP: usize = 128;

/// What a pixel shows.
#[derive(Clone, Copy)]
struct Texel {
    /// Towards the meadow, metres.
    depth: f64,
    normal: [f64; 2],
    kind: f64,
    light: f64,
    /// How thin the foliage is, 0..1; -1 for wood.
    thin: f64,
    covered: f64,
}

/// The columns of one strip of the edge.
struct Strip {
    first: usize,
    texels: Vec<Texel>,
    seed: u64,
}

/// The edge with the numbers of its textures in leaf.
pub(super) fn wood(form: u32, crowns: u32) -> Wood {
    let height = (HEIGHT as f64 * PIXEL) as f32;
    Wood { form, crowns, distance: DISTANCE as f32, height, repeats: REPEATS, is_bare: false }
}

/// The textures of form and of crowns, in leaf and bare.
pub(super) fn textures(seed: u64) -> [Texture; 4] {
    let trees = stand(seed);
    let in_leaf = painted(|first| in_leaf(seed, first, &trees));
    let bare = painted(|first| bare(seed, first, &trees));
    let [form, crowns] = encoded(&in_leaf, "wood");
    let [bare_form, bare_crowns] = encoded(&bare, "bare_wood");
    [form, crowns, bare_form, bare_crowns]
}

fn painted(strip: impl Fn(usize) -> Strip + Sync) -> Vec<Texel> {
    let strips: Vec<Strip> = (0..WIDTH / STRIP).into_par_iter().map(|number| strip(number * STRIP)).collect();
    (0..WIDTH * HEIGHT)
        .map(|place| strips[place % WIDTH / STRIP].texels[place / WIDTH * STRIP + place % STRIP])
        .collect()
}

fn encoded(texels: &[Texel], name: &str) -> [Texture; 2] {
    let code = |value: f64| (128.0 + 127.0 * value.clamp(-1.0, 1.0)) as u8;
    let of = |part: &str, values: &dyn Fn(&Texel) -> [f64; 3]| Texture {
        name: format!("{name}_{part}"),
        width: WIDTH as u32,
        height: HEIGHT as u32,
        pixels: texels.iter().map(|texel| values(texel).map(code)).collect(),
        repeat: true,
    };
    [
        of("form", &|texel| [texel.covered, texel.normal[0], texel.normal[1]]),
        of("crowns", &|texel| [texel.kind, texel.light, texel.thin]),
    ]
}

/// The trees, the farthest first, then the bushes.
fn stand(seed: u64) -> Vec<Tree> {
    let in_row = (LENGTH / SPACING) as u64;
    let conifers = Lattice::periodic(hash(seed, 51), [9, 0]);
    let tree = |number: u64| {
        let mut random = Stream::new(seed, Purpose::Surroundings, number, 20);
        let row = ROWS - 1 - number / in_row;
        let x = ((number % in_row) as f64 + random.range(-0.35, 1.35)) * LENGTH / in_row as f64;
        // Stands of tall and of low trees follow one another, with a gap here and there; the rows behind are taller.
        let wave = |times: f64, turn: f64| sin(x * TAU / LENGTH * times + turn);
        let tall = 0.5 + 0.26 * wave(2.0, 1.0) + 0.24 * wave(5.0, 0.3) + 0.14 * wave(11.0, 2.0);
        let mean = 7.5 + 7.0 * tall + 1.4 * row as f64;
        let evergreen = f64::from(conifers.value((x / LENGTH * 9.0) as f32, 0.5));
        let form = match random.uniform() + 0.75 * (evergreen - 0.78).max(0.0) * 4.0 {
            lot if lot > 0.95 => Form::Spire,
            lot if lot > 0.84 => Form::Narrow,
            lot if lot > 0.48 => Form::Tall,
            _ => Form::Broad,
        };
        let depth = -(row as f64) * ROW_DEPTH - random.range(0.0, 3.5);
        let open = [1.0, 0.86, 0.72][row as usize];
        Tree { open, ..Tree::new(seed, number, [x, depth], mean, form) }
    };
    let bush = |number: u64| {
        let mut random = Stream::new(seed, Purpose::Surroundings, number, 23);
        let x = (number as f64 + random.uniform()) * BUSHES;
        let thick = 0.5 + 0.5 * sin(x * TAU / LENGTH * 5.0 + 2.0) * sin(x * TAU / LENGTH * 13.0);
        let height = random.range(0.5, 1.7) * (0.5 + 1.5 * thick);
        let depth = random.range(1.0, 5.0);
        Tree { open: 0.9, ..Tree::new(seed, (1 << 20) + number, [x, depth], height, Form::Bush) }
    };
    (0..ROWS * in_row).map(tree).chain((0..(LENGTH / BUSHES) as u64).map(bush)).collect()
}

/// A strip of the edge in leaf.
fn in_leaf(seed: u64, first: usize, trees: &[Tree]) -> Strip {
    let mut strip = Strip::new(seed, first);
    // The dark between the stems: no sky shows there.
    let gloom = Lattice::periodic(hash(seed, 52), [64, 0]);
    strip.fill(|x, y| {
        let top = 1.9 + 4.0 * f64::from(gloom.value((x / LENGTH * 64.0) as f32, 0.5));
        (y < top).then_some(Texel { light: 0.05 + 0.02 * y / top, covered: 1.0, kind: 0.5, ..EMPTY })
    });
    for tree in trees.iter().filter(|tree| Strip::may_show(first, tree)) {
        if tree.form != Form::Bush {
            for stroke in tree.wood(seed) {
                // Below its crown a trunk stands in the wood's shade.
                strip.stroke(&Stroke { light: 0.40 * stroke.light, ..stroke }, true);
            }
        }
        for clump in tree.clumps(seed) {
            strip.clump(&clump);
        }
    }
    strip
}

/// A strip of the bare edge: stems, twigs and what stays green.
fn bare(seed: u64, first: usize, trees: &[Tree]) -> Strip {
    let mut strip = Strip::new(seed, first);
    let streaks = Lattice::periodic(hash(seed, 53), [512, 0]);
    // Deep in the wood stems and twigs are too many to be told apart.
    strip.fill(|x, y| {
        let streak = f64::from(streaks.value((x / LENGTH * 512.0) as f32, (y * 0.25) as f32));
        let covered =
            (0.94 * exp(-(y / 5.5) * (y / 5.5)) + 0.34 * exp(-(y / 11.0) * (y / 11.0))) * (0.72 + 0.4 * streak);
        Some(Texel { covered: covered.min(0.96), light: 0.42 + 0.16 * streak, kind: streak, thin: -1.0, ..EMPTY })
    });
    for stem in (0..STEMS).map(|number| stem(seed, number)) {
        strip.stroke(&stem, false);
    }
    for tree in trees.iter().filter(|tree| Strip::may_show(first, tree)) {
        if tree.form == Form::Spire {
            for clump in tree.clumps(seed) {
                strip.clump(&clump);
            }
            continue;
        }
        let strokes = if tree.form == Form::Bush { Vec::new() } else { tree.wood(seed) };
        for stroke in tree.twigs(seed).chain(strokes) {
            strip.stroke(&stroke, false);
        }
    }
    strip
}

fn stem(seed: u64, number: u64) -> Stroke {
    let mut random = Stream::new(seed, Purpose::Surroundings, number, 24);
    let x = random.uniform() * LENGTH;
    let height = random.range(6.0, 12.0);
    let lean = 0.5 * random.normal().clamp(-2.0, 2.0);
    let widths = [random.range(0.10, 0.28), 0.03];
    let (kind, light) = (random.uniform(), random.range(0.4, 0.75));
    Stroke { from: [x, 0.0], to: [x + lean, height], widths, depth: -30.0, kind, light }
}

/// A pixel that shows what is behind the wood.
const EMPTY: Texel = Texel { depth: -1e3, normal: [0.0, 0.1], kind: 0.5, light: 0.3, thin: 0.0, covered: 0.0 };

impl Strip {
    fn new(seed: u64, first: usize) -> Self {
        Self { first, texels: vec![EMPTY; STRIP * HEIGHT], seed }
    }

    fn fill(&mut self, texel: impl Fn(f64, f64) -> Option<Texel>) {
        for place in 0..self.texels.len() {
            let (x, y) = (self.first + place % STRIP, HEIGHT - 1 - place / STRIP);
            if let Some(found) = texel((x as f64 + 0.5) * PIXEL, (y as f64 + 0.5) * PIXEL) {
                self.texels[place] = found;
            }
        }
    }

    /// Whether a tree may reach into the strip.
    fn may_show(first: usize, tree: &Tree) -> bool {
        let reach = 2.0 * tree.width + tree.lean.abs() + 2.5;
        !columns(first, tree.x - reach, tree.x + reach).is_empty()
    }

    fn rows(low: f64, high: f64) -> std::ops::Range<i64> {
        let row = |y: f64| (y / PIXEL).floor() as i64;
        row(low).max(0)..(row(high) + 1).min(HEIGHT as i64)
    }

    /// Draws a clump where nothing stands before it; leaves fray its rim.
    fn clump(&mut self, clump: &Clump) {
        let Clump { x, y, radius, .. } = *clump;
        for column in columns(self.first, x - radius, x + radius) {
            for row in Self::rows(y - radius, y + radius) {
                let across = ((column as f64 + 0.5) * PIXEL - x) / radius;
                let up = ((row as f64 + 0.5) * PIXEL - y) / radius;
                self.leaves(clump, [column, row], [across, up]);
            }
        }
    }

    fn leaves(&mut self, clump: &Clump, [column, row]: [i64; 2], [across, up]: [f64; 2]) {
        let column = column.rem_euclid(WIDTH as i64) as usize;
        let bits = hash(self.seed ^ clump.radius.to_bits(), (row as u64) << 32 | column as u64);
        let noise = |shift: u32| (bits >> shift & 0xffff) as f64 / 65536.0;
        let distance = across * across + up * up;
        // Towards the rim leaves stand apart.
        if distance + 0.75 * (noise(0) - 0.35) >= 0.92 {
            return;
        }
        let depth = clump.depth + clump.radius * (1.0 - distance).max(0.0).sqrt() + 0.5 * (noise(16) - 0.5);
        let texel = &mut self.texels[(HEIGHT - 1 - row as usize) * STRIP + column - self.first];
        if texel.depth >= depth {
            return;
        }
        let turned = |own: f64, place: f64, noise: f64| own + 0.28 * place + 0.8 * (noise - 0.5);
        *texel = Texel {
            depth,
            normal: [turned(clump.normal[0], across, noise(16)), turned(clump.normal[1], up, noise(32))],
            kind: clump.kind,
            // Between leaves one looks into the shade.
            light: clump.light * (0.86 + 0.14 * up) * (0.52 + 0.75 * noise(48).sqrt()),
            thin: distance.clamp(0.0, 1.0),
            covered: 1.0,
        };
    }

    /// Draws a piece of wood: where nothing stands before it, or over what is there by the share of a pixel that it covers.
    fn stroke(&mut self, stroke: &Stroke, is_solid: bool) {
        let Stroke { from, to, widths, .. } = *stroke;
        let way = [to[0] - from[0], to[1] - from[1]];
        let squared = (way[0] * way[0] + way[1] * way[1]).max(1e-6);
        let reach = 0.5 * widths[0].max(widths[1]) + PIXEL;
        let columns = columns(self.first, from[0].min(to[0]) - reach, from[0].max(to[0]) + reach);
        for column in columns {
            for row in Self::rows(from[1].min(to[1]) - reach, from[1].max(to[1]) + reach) {
                let place = [(column as f64 + 0.5) * PIXEL - from[0], (row as f64 + 0.5) * PIXEL - from[1]];
                let along = ((place[0] * way[0] + place[1] * way[1]) / squared).clamp(0.0, 1.0);
                let off = libm::hypot(place[0] - along * way[0], place[1] - along * way[1]);
                let width = between(widths[0], widths[1], along);
                // A box of a pixel's width over a bar.
                let share = ((0.5 * (width + PIXEL) - off) / PIXEL).clamp(0.0, 1.0).min(width / PIXEL);
                if share > 0.0 {
                    self.wood(stroke, [column, row], share, is_solid);
                }
            }
        }
    }

    fn wood(&mut self, stroke: &Stroke, [column, row]: [i64; 2], share: f64, is_solid: bool) {
        let column = column.rem_euclid(WIDTH as i64) as usize;
        let texel = &mut self.texels[(HEIGHT - 1 - row as usize) * STRIP + column - self.first];
        let bark = 0.8 + 0.4 * f64::from(hash_unit(self.seed, (row as u64 / 3) << 32 | column as u64));
        let light = stroke.light * bark;
        if is_solid {
            if share > 0.5 && texel.depth < stroke.depth {
                let (depth, kind) = (stroke.depth, stroke.kind);
                *texel = Texel { depth, normal: [0.0, 0.1], kind, light, thin: -1.0, covered: 1.0 };
            }
            return;
        }
        // What stays green and stands before it hides it.
        if texel.depth > stroke.depth {
            return;
        }
        let before = texel.covered * (1.0 - share);
        let covered = before + share;
        let of = share / covered.max(1e-6);
        texel.kind = between(texel.kind.max(0.0), stroke.kind, of);
        texel.light = between(texel.light, light, of);
        texel.thin = between(texel.thin, -1.0, of);
        texel.covered = covered;
    }
}

/// The columns of the strip that begins at `first` between two places along the edge, which wraps: numbers that may lie a turn aside.
fn columns(first: usize, left: f64, right: f64) -> std::ops::Range<i64> {
    let [left, right] = [left, right].map(|x| (x / PIXEL).floor() as i64);
    let (first, width) = (first as i64, WIDTH as i64);
    let turn = (left - first - STRIP as i64).div_euclid(width) + 1;
    let first = first + turn * width;
    left.max(first)..(right + 1).min(first + STRIP as i64)
}

fn between(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_edge_is_closed_below_and_open_above_and_wraps() {
        for textures in textures(1).chunks(2) {
            let [form, crowns] = textures else { panic!("pairs") };
            assert_eq!((form.pixels.len(), crowns.pixels.len()), (WIDTH * HEIGHT, WIDTH * HEIGHT));
            let covered = |row: usize| {
                let line = &form.pixels[row * WIDTH..(row + 1) * WIDTH];
                line.iter().map(|pixel| f64::from(pixel[0].max(128) - 128)).sum::<f64>() / (127.0 * WIDTH as f64)
            };
            let (top, middle, low) = (covered(0), covered(HEIGHT * 5 / 8), covered(HEIGHT - 12));
            assert!(top < 0.02 && middle > 0.25 && low > 0.85, "{top} {middle} {low}");
            let top = |x: usize| (0..HEIGHT).find(|y| form.pixels[y * WIDTH + x][0] > 190).unwrap_or(HEIGHT);
            let steps: Vec<usize> = (0..WIDTH).map(|x| top(x).abs_diff(top((x + 1) % WIDTH))).collect();
            let largest = steps[..WIDTH - 1].iter().copied().max().unwrap_or(0);
            assert!(steps[WIDTH - 1] <= largest);
        }
    }

    #[test]
    fn bare_trees_let_the_sky_through_where_leaves_close_it() {
        let [in_leaf, _, bare, _] = textures(2);
        let mean = |texture: &Texture| {
            let rows = HEIGHT / 2..HEIGHT * 3 / 4;
            let texels = &texture.pixels[rows.start * WIDTH..rows.end * WIDTH];
            texels.iter().map(|pixel| f64::from(pixel[0].max(128) - 128)).sum::<f64>() / (127.0 * texels.len() as f64)
        };
        assert!(mean(&bare) < 0.8 * mean(&in_leaf), "{} {}", mean(&bare), mean(&in_leaf));
    }

    #[test]
    fn strips_join() {
        // A clump over the border of two strips, and over the texture's rim, is drawn whole.
        for x in [STRIP as f64 * PIXEL, 0.0, LENGTH] {
            let clump = Clump { x, y: 5.0, depth: 0.0, radius: 1.0, normal: [0.0; 2], kind: 0.5, light: 1.0 };
            let texels = painted(|first| {
                let mut strip = Strip::new(1, first);
                strip.clump(&clump);
                strip
            });
            let drawn = texels.iter().filter(|texel| texel.covered > 0.0).count() as f64 * PIXEL * PIXEL;
            assert!((2.0..3.6).contains(&drawn), "{x}: {drawn}");
        }
    }

    #[test]
    fn repeats_close_the_circle() {
        let wood = wood(0, 1);
        let around = f64::from(wood.repeats) * WIDTH as f64 * PIXEL;
        assert!((around / (TAU * f64::from(wood.distance)) - 1.0).abs() < 1e-6);
    }
}
