//! Trees of a distant wood, as few strokes and lobes: a trunk, boughs about it inside the envelope of a form, a lobe of leaves
//! on each bough with smaller ones on it. The same tree bears the leaves of summer and shows the twigs of winter.

use super::upright::GOLDEN_ANGLE;
use crate::base::maths::{exp, pow, sin};
use crate::base::random::{Purpose, Stream};
use std::f64::consts::{PI, TAU};

/// How a tree holds its crown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    /// Broad and domed: oaks and maples at a wood's edge.
    Broad,
    /// Egg-shaped: drawn up between neighbours.
    Tall,
    /// Narrow: birches, poplars.
    Narrow,
    /// A conifer's spire, green in winter.
    Spire,
    /// A bush of the hem.
    Bush,
}

/// A tree of the wood.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tree {
    /// Number that its parts are drawn by.
    pub number: u64,
    pub form: Form,
    /// Where it stands along the edge and how far towards the meadow, metres.
    pub x: f64,
    pub depth: f64,
    /// Metres.
    pub height: f64,
    /// Radius of the crown, metres.
    pub width: f64,
    /// Share of the height below the crown.
    pub bole: f64,
    /// How far the top leans along the edge, metres.
    pub lean: f64,
    /// Kind of foliage, 0..1.
    pub kind: f64,
    /// Share of light that comes to it between its neighbours, 0..1.
    pub open: f64,
}

/// A lobe of leaves: the near half of an ellipsoid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lobe {
    /// The middle: along the edge, up and towards the meadow, metres.
    pub middle: [f32; 3],
    /// Half of its width (and depth) and of its height, metres.
    pub radii: [f32; 2],
    /// The part of the crown's normal along the edge and up.
    pub normal: [f32; 2],
    /// Kind of foliage, 0..1; -1 for what stays green.
    pub kind: f32,
    /// Share of light that comes to it, 0..1.
    pub light: f32,
}

/// A piece of wood: a straight stroke, metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stroke {
    pub from: [f32; 2],
    pub to: [f32; 2],
    /// At both ends.
    pub widths: [f32; 2],
    pub depth: f32,
}

impl Stroke {
    pub(super) fn new([from, to]: [[f64; 2]; 2], widths: [f64; 2], depth: f64) -> Self {
        let single = |pair: [f64; 2]| pair.map(|value| value as f32);
        Self { from: single(from), to: single(to), widths: single(widths), depth: depth as f32 }
    }
}

/// A bough: where it leaves the trunk, its middle, its reach and the share of the crown's height.
struct Bough {
    foot: [f64; 2],
    middle: [f64; 3],
    reach: f64,
    up: f64,
}

/// Boughs of a conifer's whorl.
const IN_A_WHORL: u32 = 6;

impl Form {
    /// Height over that of the stand, and ranges of the crown's radius over the height.
    fn proportions(self) -> (f64, [f64; 2]) {
        match self {
            Self::Broad => (0.94, [0.31, 0.44]),
            Self::Tall => (1.08, [0.22, 0.32]),
            Self::Narrow => (1.02, [0.11, 0.17]),
            Self::Spire => (1.12, [0.15, 0.22]),
            Self::Bush => (1.0, [0.5, 0.9]),
        }
    }

    /// Radius over the largest at a share of the crown's height.
    fn girth(self, up: f64) -> f64 {
        match self {
            Self::Broad => pow(sin(PI * pow(0.06 + 0.94 * up, 0.72)).max(0.0), 0.55),
            Self::Tall | Self::Narrow => pow(sin(PI * pow(0.05 + 0.95 * up, 0.66)).max(0.0), 0.75),
            Self::Spire => pow(1.0 - up, 0.85) * (8.0 * up + 0.35).min(1.0),
            Self::Bush => (1.0 - up * up).sqrt(),
        }
    }

    /// Boughs of a tree, branches of a bough and small lobes on a bough's lobe.
    fn counts(self) -> [u32; 3] {
        match self {
            Self::Broad => [34, 10, 8],
            Self::Tall => [34, 9, 6],
            Self::Narrow => [20, 8, 4],
            Self::Spire => [84, 0, 0],
            Self::Bush => [4, 7, 5],
        }
    }
}

impl Tree {
    /// A tree by its number, where it stands, in a stand of a mean height (metres).
    pub(super) fn new(seed: u64, number: u64, [x, depth]: [f64; 2], stand: f64, form: Form) -> Self {
        let mut random = Stream::new(seed, Purpose::Surroundings, number, 21);
        let (share, [slender, stout]) = form.proportions();
        let height = stand * share * exp(0.15 * random.normal().clamp(-2.0, 2.0));
        let width = height * random.range(slender, stout);
        let bole = match form {
            Form::Bush => 0.0,
            Form::Spire => random.range(0.03, 0.14),
            // The meadow's side of an edge is leafy to the ground, but not of every tree.
            _ => random.range(0.07, 0.30),
        };
        let lean = height * 0.07 * random.normal().clamp(-1.8, 1.8);
        Self { number, form, x, depth, height, width, bole, lean, kind: random.uniform(), open: 1.0 }
    }

    /// Where the trunk is at a height, along the edge.
    fn trunk_at(&self, y: f64) -> f64 {
        self.x + self.lean * (y / self.height) * (y / self.height)
    }

    /// Diameter of the trunk at its foot, metres.
    fn diameter(&self) -> f64 {
        0.014 * self.height + 0.035 * self.width
    }

    fn boughs(&self, seed: u64) -> impl Iterator<Item = Bough> {
        let tree = *self;
        let count = self.form.counts()[0];
        (0..count).map(move |number| {
            let mut random = Stream::new(seed, Purpose::Surroundings, tree.number, 100 + u64::from(number));
            let up = match tree.form {
                // Whorls, a year's growth apart, closer towards the top.
                Form::Spire => {
                    let tiers = f64::from(count / IN_A_WHORL);
                    let tier = f64::from(number / IN_A_WHORL) + 0.55 * random.uniform();
                    1.0 - pow(1.0 - tier / tiers, 1.12)
                }
                _ => (f64::from(number) + random.uniform()) / f64::from(count),
            };
            let up = up.clamp(0.02, 0.985);
            let turn = f64::from(number) * GOLDEN_ANGLE + random.range(-0.5, 0.5);
            let girth = tree.form.girth(up) * tree.width;
            let bottom = tree.bole * tree.height;
            let y = bottom + up * (tree.height - bottom);
            let (out, reach, rise) = match tree.form {
                Form::Spire => {
                    let reach = (girth * random.range(0.78, 1.14)).max(0.12);
                    (reach, reach, 0.0)
                }
                Form::Narrow => (girth * random.range(0.2, 0.6), (0.5 * tree.width).max(0.5), 1.3),
                _ => {
                    let reach = tree.width * random.range(0.20, 0.36) * (0.35 + 0.65 * girth / tree.width);
                    (girth * random.range(0.15, 0.85), reach, 0.75)
                }
            };
            let y = if tree.form == Form::Spire { y } else { (y - 0.4 * reach).max(0.25 * reach) };
            let foot = (y - out * rise).clamp(0.1 * tree.height, tree.height * 0.95);
            let middle = [tree.trunk_at(y) + out * sin(turn), y, tree.depth + out * sin(turn + 0.25 * TAU)];
            Bough { foot: [tree.trunk_at(foot), foot], middle, reach, up }
        })
    }

    /// Its leaves.
    pub(super) fn lobes(&self, seed: u64) -> Vec<Lobe> {
        let mut lobes = Vec::new();
        for (number, bough) in self.boughs(seed).enumerate() {
            let mut random = Stream::new(seed, Purpose::Surroundings, self.number, 300 + number as u64);
            match self.form {
                Form::Spire => self.drooping(&bough, &mut random, &mut lobes),
                _ => self.domed(&bough, &mut random, &mut lobes),
            }
        }
        // The nearest first: what they hide need not be drawn.
        lobes.sort_by(|one, other| other.middle[2].total_cmp(&one.middle[2]));
        lobes
    }

    /// A lobe on a bough with smaller ones on its upper and outer side.
    fn domed(&self, bough: &Bough, random: &mut Stream, lobes: &mut Vec<Lobe>) {
        let flat = if self.form == Form::Narrow { 1.1 } else { random.range(0.62, 0.84) };
        let own = random.range(0.88, 1.12);
        let reach = 1.05 * bough.reach;
        lobes.push(self.lobe(bough.middle, [reach, reach * flat], own));
        // Leaves along the bough join its lobe to the crown.
        let [x, y] = [self.trunk_at(bough.middle[1]), bough.middle[1]];
        let inside = [between(x, bough.middle[0], 0.45), y - 0.3 * reach, between(self.depth, bough.middle[2], 0.45)];
        lobes.push(self.lobe(inside, [0.85 * reach, 0.8 * reach], 0.85 * own));
        for _ in 0..self.form.counts()[2] {
            let (up, turn) = (random.range(-0.45, 1.0), random.range(0.0, TAU));
            let level = (1.0 - up * up).sqrt();
            let step = [level * sin(turn), up * flat, level * sin(turn + 0.25 * TAU)];
            let out = reach * random.range(0.70, 1.16);
            let middle = [0, 1, 2].map(|k| bough.middle[k] + out * step[k]);
            let size = reach * random.range(0.22, 0.48);
            let light = own * random.range(0.86, 1.14) * (0.86 + 0.14 * up);
            lobes.push(self.lobe(middle, [size, size * (0.5 + 0.5 * flat)], light));
        }
    }

    /// A conifer's bough: it leaves the trunk, droops under its needles and lifts its tip.
    fn drooping(&self, bough: &Bough, random: &mut Stream, lobes: &mut Vec<Lobe>) {
        const PIECES: u32 = 4;
        let droop = bough.reach * (0.62 - 0.75 * bough.up) * random.range(0.8, 1.2);
        let own = random.range(0.80, 1.16);
        let [x, y, depth] = [self.trunk_at(bough.middle[1]), bough.middle[1], self.depth];
        let out = [bough.middle[0] - x, bough.middle[2] - depth];
        for piece in 1..=PIECES {
            let along = f64::from(piece) / f64::from(PIECES);
            let down = droop * (1.25 * along * along - 0.42 * pow(along, 5.0));
            let middle = [x + out[0] * along, (y - down).max(0.15), depth + out[1] * along];
            let wide = (0.30 * bough.reach * (1.15 - 0.72 * along)).max(0.14);
            let thick = (0.029 * self.height * (1.2 - 0.75 * along)).clamp(0.10, 0.60) * random.range(0.7, 1.2);
            let light = own * (0.55 + 0.55 * along);
            lobes.push(self.lobe(middle, [wide, thick], light));
        }
    }

    /// A lobe with the crown's normal and the light that comes to its place.
    fn lobe(&self, [x, y, depth]: [f64; 3], radii: [f64; 2], own: f64) -> Lobe {
        let bottom = self.bole * self.height;
        let up = ((y - bottom) / (self.height - bottom)).clamp(0.0, 1.0);
        let aside = ((x - self.trunk_at(y)) / self.width).clamp(-1.0, 1.0);
        // A crown turns from its top, some boughs before others.
        let kind = (self.kind + 0.18 * (up - 0.5) + 0.6 * (own - 1.0)).clamp(0.0, 1.0);
        // The crown's top is in the open, its inside and its foot are not; tops rise over the neighbours' shade.
        let open = self.open + (1.0 - self.open) * up * up;
        let light = (0.80 + 0.20 * up) * open * own;
        Lobe {
            middle: [x as f32, y.min(self.height) as f32, depth as f32],
            radii: radii.map(|radius| radius as f32),
            normal: [(0.60 * aside) as f32, (0.60 * up - 0.10) as f32],
            kind: if self.form == Form::Spire { -1.0 } else { kind as f32 },
            light: light.clamp(0.05, 1.0) as f32,
        }
    }

    /// Where a branch of a bough ends: its height along the bough's reach is up, its way out level.
    fn tip(&self, bough: &Bough, random: &mut Stream) -> [f64; 3] {
        let (up, turn) = (random.range(-0.25, 1.0), random.range(0.0, TAU));
        let level = (1.0 - up * up).sqrt() * random.range(0.3, 1.25) * bough.reach;
        let y = bough.middle[1] + up * bough.reach * 0.85 * random.range(0.6, 1.4);
        [bough.middle[0] + level * sin(turn), y.min(self.height), bough.middle[2] + level * sin(turn + 0.25 * TAU)]
    }

    /// Its trunk, from the foot up.
    pub(super) fn trunk(&self) -> impl Iterator<Item = Stroke> {
        const PIECES: u32 = 6;
        let tree = *self;
        let at = move |piece: u32| f64::from(piece) / f64::from(PIECES) * tree.height * 0.96;
        (0..PIECES).map(move |piece| {
            let [low, high] = [at(piece), at(piece + 1)];
            let ends = [low, high].map(|y| [tree.trunk_at(y), y]);
            Stroke::new(ends, [tree.width_at(low), tree.width_at(high)], tree.depth)
        })
    }

    /// Width of the trunk at a height, metres.
    fn width_at(&self, y: f64) -> f64 {
        (self.diameter() * pow((1.0 - y / self.height).max(0.0), 0.8)).max(0.02)
    }

    /// Its boughs and what is on them, which show when it is bare; without twigs the branches are thicker by their
    /// area.
    pub(super) fn twigs(&self, seed: u64, has_twigs: bool) -> Vec<Stroke> {
        let mut strokes = Vec::new();
        for (number, bough) in self.boughs(seed).enumerate() {
            let mut random = Stream::new(seed, Purpose::Surroundings, self.number, 200 + number as u64);
            let mut of_twigs = Stream::new(seed, Purpose::Surroundings, self.number, 400 + number as u64);
            let to = [bough.middle[0], bough.middle[1]];
            let start = (0.45 * self.width_at(bough.foot[1])).max(0.05);
            strokes.push(Stroke::new([bough.foot, to], [start, 0.05], bough.middle[2]));
            for _ in 0..self.form.counts()[1] {
                let (ends, depth) = self.branch(&bough, &mut random);
                let bare = [0.05, 0.02];
                let widths = if has_twigs { bare } else { bare.map(|width| width + self.twigs_area() / length(ends)) };
                if has_twigs {
                    strokes.extend((0..TWIGS).map(|_| Stroke::new(self.twig(ends, &mut of_twigs), TWIG, depth)));
                }
                strokes.push(Stroke::new(ends, widths, depth));
            }
        }
        strokes
    }

    /// A branch from a bough to its end, and its depth.
    fn branch(&self, bough: &Bough, random: &mut Stream) -> ([[f64; 2]; 2], f64) {
        let end = self.tip(bough, random);
        let leaves_at = random.range(0.35, 1.0);
        ([[0, 1].map(|k| between(bough.foot[k], bough.middle[k], leaves_at)), [end[0], end[1]]], end[2])
    }

    /// A twig on a branch: it forks off and turns up to the light.
    fn twig(&self, [from, to]: [[f64; 2]; 2], random: &mut Stream) -> [[f64; 2]; 2] {
        let way = [0, 1].map(|k| (to[k] - from[k]) / length([from, to]));
        let along = random.range(0.35, 1.0);
        let foot = [0, 1].map(|k| between(from[k], to[k], along));
        let (length, aside) =
            (random.range(TWIG_LENGTHS[0], TWIG_LENGTHS[1]) * self.twig_scale(), random.range(-0.6, 0.6));
        let end = [
            foot[0] + (way[0] - aside * way[1]) * length * 0.75,
            foot[1] + (way[1] + aside * way[0]) * length * 0.75 + 0.35 * length,
        ];
        [foot, end]
    }

    fn twig_scale(&self) -> f64 {
        0.3 + 0.05 * self.height
    }

    /// Mean area of the twigs on a branch, square metres.
    fn twigs_area(&self) -> f64 {
        let length = 0.5 * (TWIG_LENGTHS[0] + TWIG_LENGTHS[1]) * self.twig_scale();
        f64::from(TWIGS) * 0.5 * (TWIG[0] + TWIG[1]) * length
    }
}

/// Length of a line, metres, at least a little.
fn length([from, to]: [[f64; 2]; 2]) -> f64 {
    let way = [to[0] - from[0], to[1] - from[1]];
    (way[0] * way[0] + way[1] * way[1]).sqrt().max(0.3)
}

/// Widths of a twig at its ends, metres, and its shortest and longest, of trees of a scale of 1 metre.
const TWIG: [f64; 2] = [0.036, 0.014];
const TWIG_LENGTHS: [f64; 2] = [0.4, 1.2];
/// Twigs on a branch.
const TWIGS: u32 = 2;

fn between(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

#[cfg(test)]
mod tests {
    use super::*;

    const FORMS: [Form; 5] = [Form::Broad, Form::Tall, Form::Narrow, Form::Spire, Form::Bush];

    #[test]
    fn crowns_keep_to_their_trees() {
        for (number, form) in FORMS.into_iter().enumerate() {
            let tree = Tree::new(1, number as u64, [50.0, 0.0], 12.0, form);
            let reach = (2.0 * tree.width + tree.lean.abs()) as f32;
            let lobes = tree.lobes(1);
            assert!(!lobes.is_empty());
            for lobe in lobes {
                let [x, y, _] = lobe.middle;
                assert!(y <= tree.height as f32 && y > -tree.width as f32, "{form:?} {lobe:?}");
                assert!((x - 50.0).abs() < reach && (0.0..=1.0).contains(&lobe.light), "{form:?} {lobe:?}");
                assert_eq!(lobe.kind < 0.0, form == Form::Spire);
            }
            let base = tree.trunk().next().expect("a trunk's foot");
            assert!((base.widths[0] - tree.diameter() as f32).abs() < 1e-6 && base.widths[1] <= base.widths[0]);
        }
    }

    #[test]
    fn branches_without_their_twigs_have_the_same_area() {
        let tree = Tree::new(1, 3, [50.0, 0.0], 12.0, Form::Broad);
        let area = |has_twigs: bool| -> f32 {
            let of = |stroke: &Stroke| {
                let length = libm::hypotf(stroke.to[0] - stroke.from[0], stroke.to[1] - stroke.from[1]);
                length * 0.5 * (stroke.widths[0] + stroke.widths[1])
            };
            tree.twigs(1, has_twigs).iter().map(of).sum()
        };
        // Twigs that turn aside are a little longer or shorter than they are wide for.
        assert!((area(false) / area(true) - 1.0).abs() < 0.12, "{} {}", area(false), area(true));
    }

    #[test]
    fn forms_differ_in_breadth() {
        let breadth = |form: Form| {
            let trees = (0..20).map(|number| Tree::new(3, number, [0.0; 2], 12.0, form));
            trees.map(|tree| tree.width / tree.height).sum::<f64>() / 20.0
        };
        assert!(breadth(Form::Broad) > breadth(Form::Tall) && breadth(Form::Tall) > breadth(Form::Narrow));
    }
}
