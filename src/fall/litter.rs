//! Leaves that lie on one another.
//!
//! They are laid in the order in which they landed, ties by id, each on the ground and on what lies there: rigid, on three
//! contacts about its middle, down to the first contact (`contact`). A leaf rests on nothing that landed after it, but what
//! lies over it presses it: leaves with others over them lie in their pressed shapes, and those under several whole covers
//! (`layers`) are not laid one by one but add a soft layer. The litter of any day can be made by itself, and the list of its
//! leaves may come in any order.

use super::columns::{Columns, Extent, Region};
use super::contact::{Bed, Tools};
use super::layers::{Over, over};
use super::schedule::Schedule;
use super::shape::{Shape, Side};
use super::{Fallen, Ground};
use crate::base::random::{Purpose, Stream};
use crate::base::vector::{DVec2, DVec3};
use nalgebra::{Quaternion, UnitQuaternion};
use std::f64::consts::TAU;

/// Leaves over a leaf, in the mean, that press it flat.
const PRESSES: f32 = 0.8;
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
    let mut order: Vec<u32> = (0..landed.len() as u32).collect();
    let key = |place: u32| (&landed[place as usize], place);
    order.sort_unstable_by(|&a, &b| {
        let ((a, first), (b, second)) = (key(a), key(b));
        a.day.total_cmp(&b.day).then(a.leaf.cmp(&b.leaf)).then(first.cmp(&second))
    });
    let bed = Bed::new(ground, shapes, landed);
    let extents: Vec<Extent> = landed.iter().map(|leaf| bed.extent(shapes, leaf)).collect();
    let schedule = Schedule::new(order.iter().map(|&place| (place, extents[place as usize])), bed.bits);
    let over = over(shapes, landed, (&schedule, &extents), (bed.side, bed.bits));
    let mut laid = vec![NOWHERE; landed.len()];
    let mut columns = Columns::new(&schedule, bed.bits);
    let lay = |tools: &mut Tools, region: &mut Region, place: usize| {
        let (leaf, over) = (&landed[place], over[place]);
        let Some((shape, is_pressed)) = worn(shapes, leaf, over) else { return NOWHERE };
        let new = tools.with(region, extents[place], |tools, patch| match over.least >= BURIES {
            true => bed.bury(patch, shape, leaf),
            false => bed.lay(tools, patch, shape, leaf),
        });
        Laid { is_pressed, ..new }
    };
    columns.each(&schedule, false, lay, |place, new| laid[place] = new);
    let hides = |tools: &mut Tools, region: &mut Region, place: usize| {
        let (leaf, over, laid) = (&landed[place], over[place], &laid[place]);
        let is_open = over.least == 0 || laid.is_buried;
        let worn = worn(shapes, leaf, over).filter(|_| !is_open);
        let is_hidden =
            |(shape, _)| tools.with(region, extents[place], |_, patch| bed.hides(&patch, shape, leaf, laid));
        worn.is_some_and(is_hidden)
    };
    let mut hidden = vec![false; landed.len()];
    columns.each(&schedule, false, hides, |place, is_hidden| hidden[place] = is_hidden);
    laid.iter_mut().zip(hidden).for_each(|(laid, is_hidden)| laid.is_buried |= is_hidden);
    laid
}

/// The shape in which a leaf lies, and whether that is its pressed one.
fn worn<'a>(shapes: &[&'a Shape], leaf: &Landed, over: Over) -> Option<(&'a Shape, bool)> {
    let is_pressed = over.mean >= PRESSES;
    let number = if is_pressed { leaf.pressed } else { leaf.shape };
    Some((shapes.get(number as usize)?, is_pressed))
}
