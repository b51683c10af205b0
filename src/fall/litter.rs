//! Leaves that lie on one another.
//!
//! They are laid in the order in which they landed, ties by id, each on the ground and on what lies there: rigid, on three
//! contacts about its middle, down to the first contact (`contact`). A leaf rests on nothing that landed after it, but what
//! lies over it presses it: leaves with others over them lie in their pressed shapes, and those under several whole covers
//! (`layers`) are not laid one by one but add a soft layer. The litter of any day can be made by itself, and the list of its
//! leaves may come in any order.

use super::changes::Changes;
use super::columns::{Cells, Columns, Extent, Patch, Region};
use super::contact::{Bed, Stance, Tools};
use super::layers::{self, Over, WIDER};
use super::schedule::Schedule;
use super::shape::{Shape, Side};
use super::windows::{MOST_BYTES, Reason, Window, Windows};
use super::{Fallen, Ground};
use crate::base::random::{Purpose, Stream};
use crate::base::vector::{DVec2, DVec3};
use nalgebra::{Quaternion, UnitQuaternion};
use std::f64::consts::TAU;

/// Leaves over a leaf, in the mean, that press it flat.
const PRESSES: f32 = 0.5;
/// Whole covers over a leaf that bury it: what lies under so many is not seen from anywhere.
const BURIES: u16 = 4;

/// A leaf that has come down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landed {
    /// Its id.
    pub leaf: u64,
    /// When it landed, days.
    pub day: f64,
    /// Where its middle lies, along x and z, metres.
    pub place: DVec2,
    /// Number of its shape.
    pub shape: u32,
    /// Number of its shape when other leaves press it.
    pub pressed: u32,
    /// Its size over that of the shape.
    pub scale: f64,
    /// The side that faces the sky.
    pub side: Side,
    /// Its turn, radians.
    pub yaw: f64,
}

/// How a leaf lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Laid {
    /// Its middle, metres.
    pub middle: DVec3,
    /// Its attitude.
    pub attitude: UnitQuaternion<f64>,
    /// Whether it lies in its pressed shape.
    pub is_pressed: bool,
    /// Whether other leaves lie over all of it.
    pub is_buried: bool,
}

/// What is told of a leaf without a shape.
const NOWHERE: Laid = Laid {
    middle: DVec3::new(0.0, 0.0, 0.0),
    attitude: UnitQuaternion::new_unchecked(Quaternion::new(1.0, 0.0, 0.0, 0.0)),
    is_pressed: false,
    is_buried: false,
};

/// The side and the turn in which a leaf will lie: either side by chance.
#[must_use]
pub fn lot(seed: u64, leaf: &Fallen) -> (Side, f64) {
    let mut stream = Stream::new(seed, Purpose::Litter, leaf.leaf, leaf.year ^ 1 << 63);
    let side = if stream.uniform() < 0.5 { Side::Upper } else { Side::Lower };
    (side, stream.range(0.0, TAU))
}

/// Lays leaves; the answers are in the order in which the leaves are given.
#[must_use]
pub fn settle(ground: &Ground, shapes: &[&Shape], landed: &[Landed]) -> Vec<Laid> {
    Litter::default().settle(ground, shapes, landed)
}

/// Litter that is laid again and again, as days go by: what lies as it lay, on what lies as it lay, is not laid anew. The
/// answers are those of `settle`.
#[derive(Clone, Debug)]
pub struct Litter {
    /// What a field of heights may take, bytes; of more it is cut into windows.
    most_bytes: usize,
    /// What the leaves lie on.
    ground: Ground,
    /// Sizes of cells: those of leaves that were laid in others are not theirs.
    cells: (f64, u32),
    /// All leaves in the order of their landings.
    kept: Vec<Kept>,
    /// Where fields are made.
    field: Cells,
    /// Leaves laid so far, each time that one was.
    pub settled: u64,
    /// The most that a field of heights has taken so far, bytes.
    pub field_bytes: u64,
}

/// A leaf that has been laid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kept {
    pub landed: Landed,
    pub extent: Extent,
    /// Whether it lies in its pressed shape, and whether in a soft layer.
    pub form: (bool, bool),
    /// How it lies, but in a soft layer.
    stance: Option<Stance>,
    laid: Laid,
}

impl Default for Litter {
    fn default() -> Self {
        Self::within(MOST_BYTES)
    }
}

impl Litter {
    /// Litter whose field of heights takes about so many bytes at most.
    pub(super) fn within(most_bytes: usize) -> Self {
        let (ground, cells, kept, field) = (Ground::default(), (0.0, 0), Vec::new(), Cells::default());
        Self { most_bytes, ground, cells, kept, field, settled: 0, field_bytes: 0 }
    }

    /// Lays leaves as `settle` does. The shapes have to be the same at each call.
    pub fn settle(&mut self, ground: &Ground, shapes: &[&Shape], landed: &[Landed]) -> Vec<Laid> {
        let order = order(landed);
        let bed = Bed::new(ground, shapes, landed);
        if self.ground != *ground || self.cells != (bed.side, bed.bits) {
            (self.ground, self.cells) = (ground.clone(), (bed.side, bed.bits));
            self.kept.clear();
        }
        let sorted: Vec<Landed> = order.iter().map(|&place| landed[place as usize]).collect();
        let extents: Vec<Extent> = sorted.iter().map(|leaf| bed.extent(shapes, leaf)).collect();
        let over = self.over(&bed, shapes, &sorted, &extents);
        let new = |rank: usize| {
            let form = (over[rank].mean >= PRESSES, over[rank].least >= BURIES);
            Kept { landed: sorted[rank], extent: extents[rank], form, stance: None, laid: NOWHERE }
        };
        let mut leaves: Vec<Kept> = (0..order.len()).map(new).collect();
        let changes = Changes::new(&self.kept, &leaves, bed.bits);
        for (leaf, before) in leaves.iter_mut().zip(&changes.before) {
            if let Some(before) = before.map(|before| &self.kept[before]) {
                (leaf.stance, leaf.laid) = (before.stance, before.laid);
            }
        }
        self.settled += changes.before.iter().filter(|before| before.is_none()).count() as u64;
        let needed: Vec<u32> =
            (0..order.len()).filter(|&rank| changes.is_needed(rank, &leaves)).map(|rank| rank as u32).collect();
        // what is in a soft layer takes its place whatever lies below it
        let known = leaves.iter().zip(&changes.before).map(|(leaf, before)| leaf.form.1 || before.is_some()).collect();
        Windows::new(&extents, &needed, bed.bits, self.most_bytes).each(Reason::Laid, known, |window, known| {
            let bytes = laid_in((window, &mut self.field), &bed, shapes, (&mut leaves, known), (&over, &changes));
            self.field_bytes = self.field_bytes.max(bytes);
        });
        let mut all = vec![NOWHERE; landed.len()];
        order.iter().zip(&leaves).for_each(|(&place, leaf)| all[place as usize] = leaf.laid);
        // litter that is laid once leaves no field behind
        if self.kept.is_empty() {
            self.field = Cells::default();
        }
        self.kept = leaves;
        all
    }

    /// What lies over each of the leaves, in the order of their landings.
    fn over(&mut self, bed: &Bed<'_>, shapes: &[&Shape], sorted: &[Landed], extents: &[Extent]) -> Vec<Over> {
        let all: Vec<u32> = (0..sorted.len() as u32).collect();
        let mut over = vec![Over::default(); sorted.len()];
        let most_bytes = self.most_bytes << (2 * WIDER);
        Windows::new(extents, &all, bed.bits, most_bytes).each(Reason::Counted, Vec::new(), |window, _| {
            let schedule = schedule(window, extents, bed.bits);
            let keep = |rank: usize, found: Over| {
                if window.owns(rank) {
                    over[rank] = found;
                }
            };
            let bytes = layers::over(shapes, sorted, (&schedule, extents), (bed.side, bed.bits), &mut self.field, keep);
            self.field_bytes = self.field_bytes.max(bytes);
        });
        over
    }
}

fn schedule(window: &Window, extents: &[Extent], bits: u32) -> Schedule {
    Schedule::new(window.leaves.iter().map(|&rank| (rank, extents[rank as usize])), bits)
}

/// Lays the leaves of a window; known leaves have their stances. The bytes of the field that it took.
fn laid_in(
    (window, field): (&Window, &mut Cells),
    bed: &Bed<'_>,
    shapes: &[&Shape],
    (leaves, known): (&mut [Kept], &[bool]),
    (over, changes): (&[Over], &Changes),
) -> u64 {
    let extents = window.leaves.iter().map(|&rank| (rank, leaves[rank as usize].extent));
    let schedule = Schedule::new(extents, bed.bits);
    let mut columns = Columns::new(&schedule, bed.bits, field);
    let mut found = Vec::with_capacity(window.own.len());
    let lay = |tools: &mut Tools, region: &mut Region<'_>, rank: usize| {
        tools.with(region, leaves[rank].extent, |tools, mut patch| {
            laid(bed, tools, &mut patch, shapes, &leaves[rank], known[rank])
        })
    };
    columns.each(&schedule, false, lay, |rank, new| {
        if !known[rank] || (window.owns(rank) && changes.before[rank].is_none()) {
            found.push((rank, new));
        }
    });
    found.into_iter().for_each(|(rank, new)| (leaves[rank].stance, leaves[rank].laid) = new);
    let hides = |tools: &mut Tools, region: &mut Region<'_>, rank: usize| {
        let Kept { landed, extent, form, stance, laid } = &leaves[rank];
        if !window.owns(rank) || !changes.is_seen_anew(rank, leaves) {
            return laid.is_buried;
        }
        let shape = worn(shapes, landed, *form).filter(|_| stance.is_some() && over[rank].least > 0);
        let own = Laid { is_buried: false, ..*laid };
        let is_hidden = |shape| tools.with(region, *extent, |_, patch| bed.hides(&patch, shape, landed, &own));
        form.1 || shape.is_some_and(is_hidden)
    };
    let mut hidden = Vec::with_capacity(window.own.len());
    columns.each(&schedule, false, hides, |rank, is_hidden| hidden.push((rank, is_hidden)));
    hidden.into_iter().for_each(|(rank, is_hidden)| leaves[rank].laid.is_buried = is_hidden);
    columns.bytes
}

/// Lays a leaf, or puts it where it lay before.
fn laid(
    bed: &Bed<'_>,
    tools: &mut Tools,
    patch: &mut Patch<'_>,
    shapes: &[&Shape],
    leaf: &Kept,
    is_kept: bool,
) -> (Option<Stance>, Laid) {
    let Kept { landed, form, .. } = leaf;
    let Some(shape) = worn(shapes, landed, *form) else { return (None, NOWHERE) };
    if form.1 {
        return (None, Laid { is_pressed: form.0, ..bed.bury(patch, shape, landed) });
    }
    let kept = leaf.stance.filter(|_| is_kept);
    let stance = kept.unwrap_or_else(|| bed.rest(tools, patch, shape, landed));
    bed.add((tools, kept.is_none()), patch, shape, landed, &stance);
    (Some(stance), Laid { is_pressed: form.0, ..bed.laid(shape, landed, &stance) })
}

/// The order of the landings.
fn order(landed: &[Landed]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..landed.len() as u32).collect();
    order.sort_unstable_by(|&a, &b| {
        let (one, other) = (&landed[a as usize], &landed[b as usize]);
        one.day.total_cmp(&other.day).then(one.leaf.cmp(&other.leaf)).then(a.cmp(&b))
    });
    order
}

/// The shape in which a leaf lies.
fn worn<'a>(shapes: &[&'a Shape], leaf: &Landed, (is_pressed, _): (bool, bool)) -> Option<&'a Shape> {
    let number = if is_pressed { leaf.pressed } else { leaf.shape };
    shapes.get(number as usize).copied()
}
