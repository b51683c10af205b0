//! The edge of a wood, unrolled: trees of several forms on rows behind a hem of bushes, drawn once into textures of form and
//! light that wrap at the rim, as fine as a picture shows them. The colours, and which leaves still hang, are left to who draws
//! the picture.

use super::distant_tree::{Form, Stroke, Tree};
use super::foliage_relief::Relief;
use super::wood_canvas::{Canvas, Grid, Mark};
use super::wood_horizons::horizons;
use crate::base::maths::{expf, mix, sin};
use crate::base::noise::{Lattice, fade};
use crate::base::random::{Purpose, Stream, hash};
use crate::frame::{Texture, Wood};
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::sync::{Arc, OnceLock};

/// Texels along and up of the finest edge.
const WIDTH: usize = 2048;
const HEIGHT: usize = 256;
/// Metres that a texel of it covers: 0.015 degrees from the meadow's middle.
const TEXEL: f64 = 0.106;
/// Metres that one repeat covers.
const LENGTH: f64 = WIDTH as f64 * TEXEL;
/// Distance of the edge, metres, and its repeats around the horizon, which follow from the width.
const DISTANCE: f64 = LENGTH * REPEATS as f64 / TAU;
const REPEATS: u32 = 12;
/// How often the edge is halved at most.
const COARSEST: u32 = 4;
/// Texels of the finest edge along one side of its foliage's relief.
const RELIEF: usize = 128;
/// Rows of trees behind one another, their distance in metres, and metres of edge a tree of a row.
const ROWS: u64 = 4;
const ROW_DEPTH: f64 = 6.0;
const SPACING: f64 = 5.8;
/// Metres of edge a bush of the hem.
const BUSHES: f64 = 1.9;
/// Stems that stand deeper in the wood, seen where it is bare.
const STEMS: u64 = 420;

/// The textures of form, of crowns and of their horizons, painted when a frame first shows them.
#[derive(Default)]
pub(super) struct Edge {
    /// Numbers that they have in a frame.
    slots: [u32; 3],
    seed: u64,
    halvings: u32,
    painted: OnceLock<[Arc<Texture>; 3]>,
}

impl Edge {
    /// The edge whose textures are to have these numbers, for pictures whose pixels span an angle, radians.
    pub(super) fn new(seed: u64, slots: [u32; 3], pixel: f64) -> Self {
        Self { slots, seed, halvings: halvings(pixel), ..Self::default() }
    }

    /// Puts the textures where they belong.
    pub(super) fn put(&self, textures: &mut [Arc<Texture>]) {
        let painted = self.painted.get_or_init(|| painted(self.seed, self.halvings).map(Arc::new));
        for (slot, texture) in self.slots.iter().zip(painted) {
            textures[*slot as usize] = texture.clone();
        }
    }
}

/// How often the edge may be halved before pixels of an angle (radians) show it: they keep more than a texel each.
fn halvings(pixel: f64) -> u32 {
    let texels = 0.8 * pixel / (TEXEL / DISTANCE);
    (0..COARSEST).take_while(|halvings| f64::from(2u32 << halvings) <= texels).count() as u32
}

/// A texture that stands where one will be put.
pub(super) fn placeholder(name: &str) -> Texture {
    Texture { name: name.to_owned(), width: 1, height: 1, pixels: Arc::new(vec![[0; 3]]), repeat: true }
}

/// The edge with the numbers of its textures.
pub(super) fn wood([form, crowns, horizons]: [u32; 3]) -> Wood {
    let height = (HEIGHT as f64 * TEXEL) as f32;
    Wood { form, crowns, horizons, distance: DISTANCE as f32, height, repeats: REPEATS, bareness: 0.0 }
}

/// The textures of form, of crowns and of their horizons.
fn painted(seed: u64, halvings: u32) -> [Texture; 3] {
    let canvas = drawn(seed, halvings);
    let code = |value: f32| (128.0 + 127.0 * value.clamp(-1.0, 1.0)) as u8;
    let of = |part: &str, [width, height]: [usize; 2], pixels: Vec<[u8; 3]>| {
        let (width, height) = (width as u32, height as u32);
        Texture { name: format!("wood_{part}"), width, height, pixels: pixels.into(), repeat: true }
    };
    let (texels, size) = (|| canvas.texels.iter(), [canvas.grid.width, canvas.grid.height]);
    let (coarse, horizons) = horizons(&canvas);
    [
        of("form", size, texels().map(|texel| [texel.leaves, texel.normal[0], texel.normal[1]].map(code)).collect()),
        of("crowns", size, texels().map(|texel| [texel.kind, texel.light, texel.wood].map(code)).collect()),
        of("horizons", coarse, horizons.into_iter().map(|sines| sines.map(code)).collect()),
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
        // What stays green stands before the others: it is seen when they are bare.
        let row = if form == Form::Spire { 0 } else { row };
        let depth = -(row as f64) * ROW_DEPTH - random.range(0.0, 3.5) + if form == Form::Spire { 8.0 } else { 0.0 };
        let open = [1.0, 0.92, 0.85, 0.80][row as usize];
        Tree { open, ..Tree::new(seed, number, [x, depth], mean, form) }
    };
    let bush = |number: u64| {
        let mut random = Stream::new(seed, Purpose::Surroundings, number, 23);
        let x = (number as f64 + random.uniform()) * BUSHES;
        let thick = 0.5 + 0.5 * sin(x * TAU / LENGTH * 5.0 + 2.0) * sin(x * TAU / LENGTH * 13.0);
        let height = random.range(0.7, 2.1) * (0.5 + 1.5 * thick);
        let depth = random.range(1.0, 5.0);
        Tree { open: 0.9, ..Tree::new(seed, (1 << 20) + number, [x, depth], height, Form::Bush) }
    };
    (0..ROWS * in_row).map(tree).chain((0..(LENGTH / BUSHES) as u64).map(bush)).collect()
}

/// The edge with its leaves and, behind them, its wood.
fn drawn(seed: u64, halvings: u32) -> Canvas {
    let (width, height) = (WIDTH >> halvings, HEIGHT >> halvings);
    let texel = (TEXEL * f64::from(1u32 << halvings)) as f32;
    let mut canvas = Canvas::new(Grid { width, height, texel });
    undergrowth(&mut canvas, seed);
    // Twigs that are much thinner than a texel make their branches thicker instead.
    let has_twigs = halvings == 0;
    let of = |tree: &Tree| -> Vec<Mark> {
        let leaves = tree.lobes(seed).into_iter().map(Mark::Leaves);
        let (twigs, trunk) = match tree.form {
            Form::Spire => (Vec::new(), None),
            Form::Bush => (tree.twigs(seed, has_twigs), None),
            _ => (tree.twigs(seed, has_twigs), Some(tree.trunk())),
        };
        leaves.chain(twigs.into_iter().map(Mark::Twig)).chain(trunk.into_iter().flatten().map(Mark::Trunk)).collect()
    };
    let stems = (0..STEMS).map(|number| stem(seed, number));
    // The nearest first: what they hide need not be drawn. What hides leaves comes when the leaves are there.
    let mut nearest_first: Vec<Tree> = stand(seed).into_iter().rev().collect();
    nearest_first.sort_by(|one, other| other.depth.total_cmp(&one.depth));
    let marks: Vec<Mark> = nearest_first.par_iter().flat_map_iter(of).chain(stems.collect::<Vec<Mark>>()).collect();
    let (trunks, others): (Vec<Mark>, Vec<Mark>) = marks.into_iter().partition(|mark| matches!(mark, Mark::Trunk(_)));
    let relief = Relief::new(hash(seed, 54), RELIEF, TEXEL as f32, halvings);
    canvas.paint(&others, &relief);
    canvas.paint(&trunks, &relief);
    canvas.continue_upwards();
    canvas
}

/// The dark between the stems, where no sky shows: leaves in the shade in summer, stems and twigs too many to be told apart
/// in winter.
fn undergrowth(canvas: &mut Canvas, seed: u64) {
    /// Metres up to which there is any, and of a node of the streaks' noise.
    const HIGHEST: f32 = 18.0;
    const NODE: f32 = 4.0;
    let (gloom, streaks) = (Lattice::periodic(hash(seed, 52), [64, 0]), Lattice::periodic(hash(seed, 53), [512, 0]));
    let Grid { width, .. } = canvas.grid;
    let along = |column: usize, nodes: f32| (column as f32 + 0.5) / width as f32 * nodes;
    let tops: Vec<f32> = (0..width)
        .map(|column| {
            1.2 + 3.2 * gloom.value(along(column, 64.0), 0.5) + 1.6 * streaks.value(along(column, 512.0), 0.5)
        })
        .collect();
    // Noise on the rows of nodes: between two of them it fades from one to the other.
    let row = |node: usize| (0..width).map(|column| streaks.value(along(column, 512.0), node as f32)).collect();
    let nodes: Vec<Vec<f32>> = (0..=(HIGHEST / NODE) as usize + 1).map(row).collect();
    canvas.fill(|y, texels| {
        if y >= HIGHEST {
            return;
        }
        let [near, far] = [y / 5.5, y / 8.5].map(|share| expf(-share * share));
        let (wood, node) = (0.94 * near + 0.34 * far, (y / NODE) as usize);
        let part = fade(y / NODE - node as f32);
        for (column, texel) in texels.iter_mut().enumerate() {
            let streak = mix(nodes[node][column], nodes[node + 1][column], part);
            texel.wood = (wood * (0.72 + 0.4 * streak)).min(0.96);
            if y < tops[column] {
                (texel.leaves, texel.light) = (1.0, 0.05 + 0.02 * y / tops[column]);
            }
        }
    });
}

fn stem(seed: u64, number: u64) -> Mark {
    let mut random = Stream::new(seed, Purpose::Surroundings, number, 24);
    let x = random.uniform() * LENGTH;
    let height = random.range(6.0, 12.0);
    let lean = 0.5 * random.normal().clamp(-2.0, 2.0);
    let widths = [random.range(0.10, 0.28), 0.03];
    Mark::Twig(Stroke::new([[x, 0.0], [x + lean, height]], widths, -30.0))
}

#[cfg(test)]
mod tests {
    use super::super::wood_canvas::Texel;
    use super::*;

    fn mean(canvas: &Canvas, rows: std::ops::Range<f64>, of: fn(&Texel) -> f32) -> f32 {
        let Grid { width, height, .. } = canvas.grid;
        let [low, high] = [rows.start, rows.end].map(|share| ((1.0 - share) * height as f64) as usize);
        let texels = &canvas.texels[high * width..low * width];
        texels.iter().map(of).sum::<f32>() / texels.len() as f32
    }

    #[test]
    fn the_edge_is_closed_below_and_open_above_and_wraps() {
        let canvas = drawn(1, 1);
        let Grid { width, height, .. } = canvas.grid;
        let covered = |rows: std::ops::Range<f64>| mean(&canvas, rows, |texel| texel.leaves);
        let (top, middle, low) = (covered(0.97..1.0), covered(0.35..0.4), covered(0.0..0.05));
        assert!(top < 0.02 && middle > 0.25 && low > 0.85, "{top} {middle} {low}");
        let top = |x: usize| (0..height).find(|y| canvas.texels[y * width + x].leaves > 0.5).unwrap_or(height);
        let steps: Vec<usize> = (0..width).map(|x| top(x).abs_diff(top((x + 1) % width))).collect();
        let largest = steps[..width - 1].iter().copied().max().unwrap_or(0);
        assert!(steps[width - 1] <= largest);
    }

    #[test]
    fn bare_trees_let_the_sky_through_where_leaves_close_it() {
        let canvas = drawn(2, 1);
        let [leaves, wood] =
            [|texel: &Texel| texel.leaves, |texel: &Texel| texel.wood].map(|of| mean(&canvas, 0.3..0.5, of));
        assert!(wood < 0.8 * leaves && wood > 0.05, "{wood} {leaves}");
    }

    #[test]
    fn what_covers_does_not_depend_on_the_texels() {
        let [fine, coarse] = [0, 3].map(|halvings| drawn(3, halvings));
        let ratio = |of: fn(&Texel) -> f32| mean(&fine, 0.0..1.0, of) / mean(&coarse, 0.0..1.0, of);
        let ratios =
            [ratio(|texel| texel.leaves), ratio(|texel| texel.leaves * texel.light), ratio(|texel| texel.wood)];
        // Twigs that cross within a coarse texel are taken to lie anyhow.
        for (ratio, most) in ratios.into_iter().zip([0.08, 0.12, 0.20]) {
            assert!((ratio - 1.0).abs() < most, "{ratios:?}");
        }
    }

    #[test]
    fn the_texels_follow_the_pixels_of_the_picture() {
        let texel = TEXEL / DISTANCE;
        assert_eq!((halvings(0.1 * texel), halvings(1e3 * texel)), (0, COARSEST));
        for pixel in [1.0, 3.0, 5.0, 9.0, 17.0] {
            let seen = f64::from(1u32 << halvings(pixel * texel));
            assert!(seen <= pixel && seen * 4.0 > 0.79 * pixel, "{pixel} {seen}");
        }
    }

    #[test]
    fn repeats_close_the_circle() {
        let wood = wood([0, 1, 2]);
        let around = f64::from(wood.repeats) * WIDTH as f64 * TEXEL;
        assert!((around / (TAU * f64::from(wood.distance)) - 1.0).abs() < 1e-6);
    }
}
