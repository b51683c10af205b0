//! The edge of a wood, unrolled: trees of several forms on rows behind a hem of bushes, drawn once into textures of form and
//! light that wrap at the rim, in leaf and bare. The colours are left to who draws the picture.

use super::distant_tree::{Clump, Form, Stroke, Tree};
use crate::base::maths::{exp, sin};
use crate::base::noise::Lattice;
use crate::base::random::{Purpose, Stream, hash, hash_unit};
use crate::frame::{Texture, Wood};
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::ops::Range;
use std::sync::{Arc, OnceLock};

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
const ROWS: u64 = 4;
const ROW_DEPTH: f64 = 6.0;
const SPACING: f64 = 5.8;
/// Metres of edge a bush of the hem.
const BUSHES: f64 = 1.9;
/// Stems that stand deeper in the wood, seen where it is bare.
const STEMS: u64 = 420;
/// Rows that are drawn at once.
const BAND: usize = 16;

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

/// The edge while it is drawn.
struct Canvas {
    texels: Vec<Texel>,
    seed: u64,
}

/// Some rows of the edge, drawn by themselves.
struct Band<'a> {
    texels: &'a mut [Texel],
    /// From the ground.
    rows: Range<i64>,
    seed: u64,
}

/// The textures of form and of crowns, each painted when a frame first shows it.
#[derive(Default)]
pub(super) struct Edge {
    /// Numbers that they have in a frame.
    slots: [u32; 2],
    seed: u64,
    in_leaf: OnceLock<[Arc<Texture>; 2]>,
    bare: OnceLock<[Arc<Texture>; 2]>,
}

impl Edge {
    /// The edge whose textures are to have these numbers.
    pub(super) fn new(seed: u64, slots: [u32; 2]) -> Self {
        Self { slots, seed, ..Self::default() }
    }

    /// Puts the textures of a season where they belong.
    pub(super) fn put(&self, is_bare: bool, textures: &mut [Arc<Texture>]) {
        let known = if is_bare { &self.bare } else { &self.in_leaf };
        let season = known.get_or_init(|| painted(self.seed, is_bare).map(Arc::new));
        for (slot, texture) in self.slots.iter().zip(season) {
            textures[*slot as usize] = texture.clone();
        }
    }
}

/// A texture that stands where one will be put.
pub(super) fn placeholder(name: &str) -> Texture {
    Texture { name: name.to_owned(), width: 1, height: 1, pixels: vec![[0; 3]], repeat: true }
}

/// The edge with the numbers of its textures.
pub(super) fn wood(form: u32, crowns: u32) -> Wood {
    let height = (HEIGHT as f64 * PIXEL) as f32;
    Wood { form, crowns, distance: DISTANCE as f32, height, repeats: REPEATS, is_bare: false }
}

/// The textures of form and of crowns.
fn painted(seed: u64, is_bare: bool) -> [Texture; 2] {
    let trees = stand(seed);
    let canvas = if is_bare { bare(seed, &trees) } else { in_leaf(seed, &trees) };
    let code = |value: f64| (128.0 + 127.0 * value.clamp(-1.0, 1.0)) as u8;
    let of = |part: &str, values: &dyn Fn(&Texel) -> [f64; 3]| Texture {
        name: format!("wood_{part}"),
        width: WIDTH as u32,
        height: HEIGHT as u32,
        pixels: canvas.texels.iter().map(|texel| values(texel).map(code)).collect(),
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
        let mean = 8.0 + 7.5 * tall + 1.3 * row as f64;
        let evergreen = f64::from(conifers.value((x / LENGTH * 9.0) as f32, 0.5));
        let form = match random.uniform() + 2.2 * (evergreen - 0.80).max(0.0) {
            lot if lot > 0.972 => Form::Spire,
            lot if lot > 0.89 => Form::Narrow,
            lot if lot > 0.55 => Form::Tall,
            _ => Form::Broad,
        };
        let depth = -(row as f64) * ROW_DEPTH - random.range(0.0, 3.5);
        let open = [1.0, 0.88, 0.76, 0.66][row as usize];
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

/// What is drawn on the edge.
#[derive(Clone, Copy)]
enum Mark {
    /// Leaves, where nothing stands before them.
    Clump(Clump),
    /// Wood where nothing stands before it.
    Solid(Stroke),
    /// Wood over what is there, by the share of a pixel that it covers.
    Fine(Stroke),
}

/// What is drawn for each of some trees, one after another.
fn marks(trees: &[Tree], of: impl Fn(&Tree) -> Vec<Mark> + Sync + Send) -> Vec<Mark> {
    trees.par_iter().flat_map_iter(of).collect()
}

/// The edge in leaf.
fn in_leaf(seed: u64, trees: &[Tree]) -> Canvas {
    let mut canvas = Canvas::new(seed);
    // The dark between the stems: no sky shows there.
    let gloom = Lattice::periodic(hash(seed, 52), [64, 0]);
    canvas.fill(|x, y| {
        let top = 2.8 + 5.0 * f64::from(gloom.value((x / LENGTH * 64.0) as f32, 0.5));
        (y < top).then_some(Texel { light: 0.05 + 0.02 * y / top, covered: 1.0, kind: 0.5, ..EMPTY })
    });
    let of = |tree: &Tree| {
        let strokes = if tree.form == Form::Bush { Vec::new() } else { tree.wood(seed) };
        // Below its crown a trunk stands in the wood's shade.
        let strokes = strokes.into_iter().map(|stroke| Mark::Solid(Stroke { light: 0.40 * stroke.light, ..stroke }));
        strokes.chain(tree.clumps(seed).map(Mark::Clump)).collect()
    };
    // The nearest first: what they hide need not be drawn.
    let nearest_first: Vec<Tree> = trees.iter().rev().copied().collect();
    canvas.paint(&marks(&nearest_first, of));
    canvas
}

/// The bare edge: stems, twigs and what stays green.
fn bare(seed: u64, trees: &[Tree]) -> Canvas {
    let mut canvas = Canvas::new(seed);
    let streaks = Lattice::periodic(hash(seed, 53), [512, 0]);
    // Deep in the wood stems and twigs are too many to be told apart.
    canvas.fill(|x, y| {
        let streak = f64::from(streaks.value((x / LENGTH * 512.0) as f32, (y * 0.25) as f32));
        let covered =
            (0.94 * exp(-(y / 5.5) * (y / 5.5)) + 0.34 * exp(-(y / 11.0) * (y / 11.0))) * (0.72 + 0.4 * streak);
        Some(Texel { covered: covered.min(0.96), light: 0.42 + 0.16 * streak, kind: streak, thin: -1.0, ..EMPTY })
    });
    let of = |tree: &Tree| match tree.form {
        Form::Spire => tree.clumps(seed).map(Mark::Clump).collect(),
        Form::Bush => tree.twigs(seed).map(Mark::Fine).collect(),
        _ => tree.twigs(seed).chain(tree.wood(seed)).map(Mark::Fine).collect(),
    };
    let stems = (0..STEMS).map(|number| Mark::Fine(stem(seed, number)));
    canvas.paint(&stems.chain(marks(trees, of)).collect::<Vec<Mark>>());
    canvas
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

impl Canvas {
    fn new(seed: u64) -> Self {
        Self { texels: vec![EMPTY; WIDTH * HEIGHT], seed }
    }

    fn fill(&mut self, texel: impl Fn(f64, f64) -> Option<Texel> + Sync) {
        self.texels.par_iter_mut().enumerate().for_each(|(place, own)| {
            let (x, y) = (place % WIDTH, HEIGHT - 1 - place / WIDTH);
            if let Some(found) = texel((x as f64 + 0.5) * PIXEL, (y as f64 + 0.5) * PIXEL) {
                *own = found;
            }
        });
    }

    /// Draws marks one over another, in bands of rows at once: a pixel depends on no other.
    fn paint(&mut self, marks: &[Mark]) {
        let seed = self.seed;
        self.texels.par_chunks_mut(WIDTH * BAND).enumerate().for_each(|(number, texels)| {
            let above = HEIGHT as i64 - (number * BAND) as i64;
            let mut band = Band { texels, rows: above - BAND as i64..above, seed };
            for mark in marks {
                match mark {
                    Mark::Clump(clump) => band.clump(clump),
                    Mark::Solid(stroke) => band.stroke(stroke, true),
                    Mark::Fine(stroke) => band.stroke(stroke, false),
                }
            }
        });
    }
}

impl Band<'_> {
    fn columns(left: f64, right: f64) -> Range<i64> {
        (left / PIXEL).floor() as i64..(right / PIXEL).floor() as i64 + 1
    }

    fn rows(&self, low: f64, high: f64) -> Range<i64> {
        let row = |y: f64| (y / PIXEL).floor() as i64;
        row(low).max(self.rows.start)..(row(high) + 1).min(self.rows.end)
    }

    fn texel(&mut self, column: usize, row: i64) -> &mut Texel {
        &mut self.texels[(self.rows.end - 1 - row) as usize * WIDTH + column]
    }

    /// Draws a clump where nothing stands before it; leaves fray its rim.
    fn clump(&mut self, clump: &Clump) {
        let Clump { x, y, radius, .. } = *clump;
        let rows = self.rows(y - radius, y + radius);
        if rows.is_empty() {
            return;
        }
        for column in Self::columns(x - radius, x + radius) {
            for row in rows.clone() {
                let across = ((column as f64 + 0.5) * PIXEL - x) / radius;
                let up = ((row as f64 + 0.5) * PIXEL - y) / radius;
                self.leaves(clump, [column, row], [across, up]);
            }
        }
    }

    fn leaves(&mut self, clump: &Clump, [column, row]: [i64; 2], [across, up]: [f64; 2]) {
        let column = column.rem_euclid(WIDTH as i64) as usize;
        let seed = self.seed;
        let texel = self.texel(column, row);
        if texel.depth >= clump.depth + clump.radius + 0.25 {
            return;
        }
        let bits = hash(seed ^ clump.radius.to_bits(), (row as u64) << 32 | column as u64);
        let noise = |shift: u32| (bits >> shift & 0xffff) as f64 / 65536.0;
        let distance = across * across + up * up;
        // Towards the rim leaves stand apart.
        if distance + 1.1 * (noise(0) - 0.35) >= 0.92 {
            return;
        }
        let depth = clump.depth + clump.radius * (1.0 - distance).max(0.0).sqrt() + 0.5 * (noise(16) - 0.5);
        if texel.depth >= depth {
            return;
        }
        let turned = |own: f64, place: f64, noise: f64| own + 0.18 * place + 0.9 * (noise - 0.5);
        *texel = Texel {
            depth,
            normal: [turned(clump.normal[0], across, noise(16)), turned(clump.normal[1], up, noise(32))],
            kind: clump.kind,
            // Between leaves one looks into the shade.
            light: clump.light * (0.86 + 0.14 * up) * (0.38 + 0.92 * noise(48).sqrt()),
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
        if self.rows(from[1].min(to[1]) - 1.5 * reach, from[1].max(to[1]) + 1.5 * reach).is_empty() {
            return;
        }
        let is_steep = way[1].abs() > way[0].abs();
        // Steps along the longer way, and across it only as far as the stroke is wide.
        let (main, other) = if is_steep { (1, 0) } else { (0, 1) };
        let [low, high] = [from[main].min(to[main]) - reach, from[main].max(to[main]) + reach];
        for step in if is_steep { self.rows(low, high) } else { Self::columns(low, high) } {
            let at = (step as f64 + 0.5) * PIXEL - from[main];
            let middle =
                from[other] + way[other] * (at / way[main].abs().max(1e-6) * way[main].signum()).clamp(0.0, 1.0);
            let (low, high) = (middle - 1.5 * reach, middle + 1.5 * reach);
            for aside in if is_steep { Self::columns(low, high) } else { self.rows(low, high) } {
                let [column, row] = if is_steep { [aside, step] } else { [step, aside] };
                let place = [(column as f64 + 0.5) * PIXEL - from[0], (row as f64 + 0.5) * PIXEL - from[1]];
                let along = ((place[0] * way[0] + place[1] * way[1]) / squared).clamp(0.0, 1.0);
                let off = [place[0] - along * way[0], place[1] - along * way[1]];
                let off = (off[0] * off[0] + off[1] * off[1]).sqrt();
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
        let seed = self.seed;
        let texel = self.texel(column, row);
        let bark = 0.8 + 0.4 * f64::from(hash_unit(seed, (row as u64 / 3) << 32 | column as u64));
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

fn between(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_edge_is_closed_below_and_open_above_and_wraps() {
        for is_bare in [false, true] {
            let [form, crowns] = painted(1, is_bare);
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
        let [[in_leaf, _], [bare, _]] = [false, true].map(|is_bare| painted(2, is_bare));
        let mean = |texture: &Texture| {
            let rows = HEIGHT / 2..HEIGHT * 3 / 4;
            let texels = &texture.pixels[rows.start * WIDTH..rows.end * WIDTH];
            texels.iter().map(|pixel| f64::from(pixel[0].max(128) - 128)).sum::<f64>() / (127.0 * texels.len() as f64)
        };
        assert!(mean(&bare) < 0.8 * mean(&in_leaf), "{} {}", mean(&bare), mean(&in_leaf));
    }

    #[test]
    fn what_reaches_over_the_rim_comes_in_on_the_other_side() {
        for x in [0.5 * LENGTH, 0.0, LENGTH] {
            let mut canvas = Canvas::new(1);
            let ball = Clump { x, y: 5.0, depth: 0.0, radius: 1.0, normal: [0.0; 2], kind: 0.5, light: 1.0 };
            canvas.paint(&[Mark::Clump(ball)]);
            let area = |canvas: &Canvas| canvas.texels.iter().map(|texel| texel.covered).sum::<f64>() * PIXEL * PIXEL;
            assert!((1.8..3.6).contains(&area(&canvas)), "{x}: {}", area(&canvas));
            // A bar thinner than a pixel covers its own area.
            let mut canvas = Canvas::new(1);
            let (from, to) = ([x - 2.0, 3.0], [x + 2.0, 4.5]);
            let bar = Stroke { from, to, widths: [0.04; 2], depth: 0.0, kind: 0.5, light: 1.0 };
            canvas.paint(&[Mark::Fine(bar)]);
            let expected = 0.04 * libm::hypot(4.0, 1.5);
            assert!((area(&canvas) / expected - 1.0).abs() < 0.4, "{x}: {} {expected}", area(&canvas));
        }
    }

    #[test]
    fn repeats_close_the_circle() {
        let wood = wood(0, 1);
        let around = f64::from(wood.repeats) * WIDTH as f64 * PIXEL;
        assert!((around / (TAU * f64::from(wood.distance)) - 1.0).abs() < 1e-6);
    }
}
