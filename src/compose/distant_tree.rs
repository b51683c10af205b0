//! Trees of a distant wood, as few strokes and clumps: a trunk, boughs about it inside the envelope of a form, clumps of leaves
//! about each bough. The same tree bears the leaves of summer and shows the twigs of winter.

use super::sward::GOLDEN_ANGLE;
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

/// A clump of leaves: a frayed ball.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clump {
    pub x: f64,
    pub y: f64,
    pub depth: f64,
    pub radius: f64,
    /// The part of the crown's normal along the edge and up.
    pub normal: [f64; 2],
    /// Kind of foliage, 0..1; -1 for what stays green.
    pub kind: f64,
    /// Share of light that comes to it, 0..1.
    pub light: f64,
}

/// A piece of wood: a straight stroke, metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stroke {
    pub from: [f64; 2],
    pub to: [f64; 2],
    /// At both ends.
    pub widths: [f64; 2],
    pub depth: f64,
    pub kind: f64,
    pub light: f64,
}

/// A bough: where it leaves the trunk, its middle, its reach and the share of the crown's height.
struct Bough {
    foot: [f64; 2],
    middle: [f64; 3],
    reach: f64,
    up: f64,
}

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

    /// Boughs of a tree and clumps of a bough.
    fn counts(self) -> (u32, u64) {
        match self {
            Self::Broad => (34, 10),
            Self::Tall => (32, 9),
            Self::Narrow => (24, 7),
            Self::Spire => (46, 11),
            Self::Bush => (4, 7),
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
        let count = self.form.counts().0;
        (0..count).map(move |number| {
            let mut random = Stream::new(seed, Purpose::Surroundings, tree.number, 100 + u64::from(number));
            let up = ((f64::from(number) + random.uniform()) / f64::from(count)).clamp(0.03, 0.97);
            let turn = f64::from(number) * GOLDEN_ANGLE + random.range(-0.5, 0.5);
            let girth = tree.form.girth(up) * tree.width;
            let bottom = tree.bole * tree.height;
            let y = bottom + up * (tree.height - bottom);
            let (out, reach, rise) = match tree.form {
                Form::Spire => (girth * 0.42, (0.58 * girth * random.range(0.8, 1.15)).max(0.25), -0.1),
                Form::Narrow => (girth * random.range(0.2, 0.6), (0.5 * tree.width).max(0.5), 1.3),
                _ => {
                    let reach = tree.width * random.range(0.16, 0.34) * (0.4 + 0.6 * girth / tree.width);
                    (girth * random.range(0.15, 0.92), reach, 0.75)
                }
            };
            let y = (y - 0.4 * reach).max(0.25 * reach);
            let foot = (y - out * rise).clamp(0.1 * tree.height, tree.height * 0.95);
            let middle = [tree.trunk_at(y) + out * sin(turn), y, tree.depth + out * sin(turn + 0.25 * TAU)];
            Bough { foot: [tree.trunk_at(foot), foot], middle, reach, up }
        })
    }

    /// Its leaves.
    pub(super) fn clumps(&self, seed: u64) -> impl Iterator<Item = Clump> {
        let tree = *self;
        self.boughs(seed).enumerate().flat_map(move |(number, bough)| {
            let mut random = Stream::new(seed, Purpose::Surroundings, tree.number, 200 + number as u64);
            let own = random.range(0.86, 1.14);
            (0..tree.form.counts().1).map(move |_| tree.clump(&bough, own, &mut random))
        })
    }

    fn clump(&self, bough: &Bough, own: f64, random: &mut Stream) -> Clump {
        // Leaves are on a bough's upper and outer side.
        let (up, turn) = (random.range(-0.55, 1.0), random.range(0.0, TAU));
        let level = (1.0 - up * up).sqrt() * random.range(0.3, 1.35);
        let squash = if self.form == Form::Spire { 0.30 } else { 0.66 };
        let step = [level * sin(turn), up, level * sin(turn + 0.25 * TAU)];
        let x = bough.middle[0] + step[0] * bough.reach;
        let y = bough.middle[1] + step[1] * bough.reach * squash * random.range(0.6, 1.3);
        let depth = bough.middle[2] + step[2] * bough.reach;
        let crown = [(x - self.trunk_at(y)) / self.width, 1.3 * bough.up - 0.35];
        let towards = ((depth - self.depth) / self.width).clamp(-1.0, 1.0);
        // The crown's top is in the open, its inside and what hangs under a bough are not.
        let light = (0.34 + 0.66 * pow(bough.up, 0.8)) * (0.74 + 0.26 * towards) * (0.70 + 0.30 * up);
        Clump {
            x,
            y: y.min(self.height),
            depth,
            radius: self.clump_radius() * random.range(0.5, 1.25),
            normal: [0.72 * crown[0] + 0.26 * step[0], 0.55 * crown[1] + 0.18 + 0.32 * step[1]],
            kind: if self.form == Form::Spire { -1.0 } else { self.kind },
            light: (light * own * self.open * random.range(0.78, 1.22)).clamp(0.06, 1.0),
        }
    }

    fn clump_radius(&self) -> f64 {
        match self.form {
            Form::Spire => 0.14 + 0.011 * self.height,
            Form::Bush => 0.16 + 0.13 * self.height,
            _ => 0.26 + 0.021 * self.height,
        }
    }

    /// Its trunk and boughs.
    pub(super) fn wood(&self, seed: u64) -> Vec<Stroke> {
        let tree = *self;
        let (kind, light) = (self.kind, self.open);
        let diameter = self.diameter();
        let mut strokes = Vec::new();
        const PIECES: u32 = 6;
        let at = |piece: u32| f64::from(piece) / f64::from(PIECES) * tree.height * 0.96;
        let width = |y: f64| (diameter * pow((1.0 - y / tree.height).max(0.0), 0.8)).max(0.02);
        for piece in 0..PIECES {
            let (low, high) = (at(piece), at(piece + 1));
            let [from, to] = [low, high].map(|y| [tree.trunk_at(y), y]);
            strokes.push(Stroke { from, to, widths: [width(low), width(high)], depth: tree.depth, kind, light });
        }
        let limbs = self.boughs(seed).map(|bough| {
            let to = [bough.middle[0], bough.middle[1]];
            let start = 0.45 * width(bough.foot[1]);
            Stroke { from: bough.foot, to, widths: [start.max(0.05), 0.05], depth: bough.middle[2], kind, light }
        });
        strokes.extend(limbs);
        strokes
    }

    /// Its twigs, which show when it is bare.
    pub(super) fn twigs(&self, seed: u64) -> impl Iterator<Item = Stroke> {
        let tree = *self;
        self.boughs(seed).enumerate().flat_map(move |(number, bough)| {
            let mut random = Stream::new(seed, Purpose::Surroundings, tree.number, 200 + number as u64);
            let own = random.range(0.86, 1.14);
            let mut strokes = Vec::new();
            for _ in 0..tree.form.counts().1 {
                let end = tree.clump(&bough, own, &mut random);
                tree.spray(&bough, &end, &mut random, &mut strokes);
            }
            strokes
        })
    }

    /// A branch from a bough to where a clump of leaves would be, with the twigs on it.
    fn spray(&self, bough: &Bough, end: &Clump, random: &mut Stream, strokes: &mut Vec<Stroke>) {
        let leaves_at = random.range(0.35, 1.0);
        let from = [0, 1].map(|k| between(bough.foot[k], bough.middle[k], leaves_at));
        let (kind, light) = (self.kind, self.open);
        let branch = Stroke { from, to: [end.x, end.y], widths: [0.05, 0.02], depth: end.depth, kind, light };
        let way = [branch.to[0] - from[0], branch.to[1] - from[1]];
        let long = (way[0] * way[0] + way[1] * way[1]).sqrt().max(0.3);
        for _ in 0..2 {
            let along = random.range(0.35, 1.0);
            let foot = [0, 1].map(|k| between(from[k], branch.to[k], along));
            let (length, aside) = (random.range(0.4, 1.2) * (0.3 + 0.05 * self.height), random.range(-0.6, 0.6));
            // Twigs fork off their branch and turn up to the light.
            let to = [
                foot[0] + (way[0] - aside * way[1]) / long * length * 0.75,
                foot[1] + (way[1] + aside * way[0]) / long * length * 0.75 + 0.35 * length,
            ];
            strokes.push(Stroke { from: foot, to, widths: [0.036, 0.014], ..branch });
        }
        strokes.push(branch);
    }
}

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
            let reach = 2.0 * tree.width + tree.lean.abs();
            let clumps: Vec<Clump> = tree.clumps(1).collect();
            assert!(!clumps.is_empty());
            for clump in clumps {
                assert!(clump.y <= tree.height && clump.y > -tree.width, "{form:?} {clump:?}");
                assert!((clump.x - tree.x).abs() < reach && (0.0..=1.0).contains(&clump.light), "{form:?} {clump:?}");
                assert_eq!(clump.kind < 0.0, form == Form::Spire);
            }
            let wood = tree.wood(1);
            let base = wood.iter().find(|stroke| stroke.from[1] == 0.0).expect("a trunk's foot");
            assert!((base.widths[0] - tree.diameter()).abs() < 1e-9 && base.widths[1] <= base.widths[0]);
        }
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
