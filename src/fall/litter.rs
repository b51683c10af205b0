//! Leaves that lie on one another.
//!
//! They are laid in the order in which they landed, ties by id, each on the ground and on what lies there: rigid, on three
//! contacts about its middle, down to the first contact (`contact`). A leaf rests on nothing that landed after it, but what
//! lies over it presses it: leaves with others over them lie in their pressed shapes, and those under several whole covers
//! (`layers`) are not laid one by one but add a soft layer. The litter of any day can be made by itself, and the list of its
//! leaves may come in any order.

use super::contact::Bed;
use super::layers::{Over, over};
use super::shape::{Shape, Side};
use super::{Fallen, Ground};
use crate::base::random::{Purpose, Stream};
use crate::base::vector::{DVec2, DVec3};
use nalgebra::UnitQuaternion;
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
    let mut order: Vec<usize> = (0..landed.len()).collect();
    order.sort_unstable_by(|&a, &b| {
        landed[a].day.total_cmp(&landed[b].day).then(landed[a].leaf.cmp(&landed[b].leaf)).then(a.cmp(&b))
    });
    let over = over(shapes, landed, &order);
    let mut bed = Bed::new(ground, landed);
    let nowhere =
        Laid { middle: DVec3::zeros(), attitude: UnitQuaternion::identity(), is_pressed: false, is_buried: false };
    let mut laid = vec![nowhere; landed.len()];
    for &place in &order {
        let (leaf, over) = (&landed[place], over[place]);
        if let Some((shape, is_pressed)) = worn(shapes, leaf, over) {
            let is_buried = over.least >= BURIES;
            let new = if is_buried { bed.bury(shape, leaf) } else { bed.lay(shape, leaf) };
            laid[place] = Laid { is_pressed, ..new };
        }
    }
    for (place, leaf) in landed.iter().enumerate().filter(|(place, _)| over[*place].least > 0) {
        if let Some((shape, _)) = worn(shapes, leaf, over[place]).filter(|_| !laid[place].is_buried) {
            laid[place].is_buried = bed.hides(shape, leaf, &laid[place]);
        }
    }
    laid
}

/// The shape in which a leaf lies, and whether that is its pressed one.
fn worn<'a>(shapes: &[&'a Shape], leaf: &Landed, over: Over) -> Option<(&'a Shape, bool)> {
    let is_pressed = over.mean >= PRESSES;
    let number = if is_pressed { leaf.pressed } else { leaf.shape };
    Some((shapes.get(number as usize)?, is_pressed))
}
