//! Pictures of what is seen in each pixel, for data sets: depth, normal, leaf and state.

use crate::compose::Stand;
use crate::export::{self, ExportError};
use crate::frame::Frame;
use crate::raster::Site;
use crate::season::{self, LeafStates};
use std::collections::BTreeMap;

/// The kinds of layers, as their files' names have them.
pub const KINDS: [&str; 4] = ["depth", "normal", "leaf", "state"];
/// Depths are in these units a metre.
const MILLIMETRES: f32 = 1000.0;
/// The depth of what is farther away than the unit below it, and of the sky.
const FAR: u16 = u16::MAX;

/// What the layers of a frame are made from.
pub struct Seen<'a> {
    /// The frame that was drawn.
    pub frame: &'a Frame,
    /// What is seen in each of its pixels.
    pub sites: &'a [Site],
    /// Its trees.
    pub stand: &'a Stand,
    /// The states of their leaves, where they have seasons.
    pub states: Option<&'a LeafStates>,
}

/// The files of the layers, in the order of [`KINDS`].
///
/// # Errors
/// When a picture cannot be encoded.
pub fn layers(seen: &Seen<'_>) -> Result<Vec<Vec<u8>>, ExportError> {
    let (width, height) = (seen.frame.view.width, seen.frame.view.height);
    let depths: Vec<u16> = seen.sites.iter().map(|site| millimetres(site.depth)).collect();
    let normals: Vec<[u8; 3]> = seen.sites.iter().map(|site| <[f32; 3]>::from(site.normal).map(coded)).collect();
    let leaves = Leaves::new(seen);
    let of_sites: Vec<Option<Leaf>> = seen.sites.iter().map(|site| leaves.of(site)).collect();
    let numbers: Vec<[u8; 3]> =
        of_sites.iter().map(|leaf| in_three_bytes(leaf.map_or(0, |leaf| leaf.number))).collect();
    let states: Vec<u8> = of_sites.iter().map(|leaf| leaf.map_or(0, |leaf| leaf.state)).collect();
    Ok(vec![
        export::grey_16(width, height, &depths)?,
        export::plain(width, height, &normals)?,
        export::plain(width, height, &numbers)?,
        export::grey_8(width, height, &states)?,
    ])
}

fn millimetres(depth: f32) -> u16 {
    // Casts saturate, and the sky is infinitely far.
    ((depth * MILLIMETRES + 0.5) as u32).min(FAR.into()) as u16
}

/// A coordinate of a unit vector, -1..1 in 1..=255; 128 is 0.
fn coded(coordinate: f32) -> u8 {
    (coordinate * 127.0 + 128.5) as u8
}

fn in_three_bytes(number: u32) -> [u8; 3] {
    [(number >> 16) as u8, (number >> 8) as u8, number as u8]
}

#[derive(Clone, Copy)]
struct Leaf {
    /// From 1, in the order of the file of states.
    number: u32,
    /// From 1, in the order of the report's states; 0 without seasons.
    state: u8,
}

/// The leaves of a frame's instances.
struct Leaves<'a> {
    seen: &'a Seen<'a>,
    numbers: BTreeMap<u64, u32>,
    fallen: u8,
}

impl<'a> Leaves<'a> {
    fn new(seen: &'a Seen<'a>) -> Self {
        let numbers = seen.stand.leaf_ids.iter().zip(1..).map(|(&id, number)| (id, number)).collect();
        let place = seen.states.and_then(|states| states.names.iter().position(|name| name == season::FALLEN));
        Self { seen, numbers, fallen: place.map_or(0, |place| place as u8 + 1) }
    }

    fn of(&self, site: &Site) -> Option<Leaf> {
        let place = site.instance? as usize;
        let id = self.seen.frame.instances.get(place)?.leaf?;
        let number = self.numbers.get(&id).copied().unwrap_or(0);
        if place >= self.seen.frame.standing().len() {
            return Some(Leaf { number, state: self.fallen });
        }
        let state = self.seen.states.zip((number as usize).checked_sub(1));
        let state = state.and_then(|(states, leaf)| states.states.get(leaf));
        Some(Leaf { number, state: state.map_or(0, |&state| u8::try_from(state + 1).unwrap_or(u8::MAX)) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depths_are_millimetres_and_end_at_the_last_code() {
        assert_eq!([0.0, 1.2345, 65.534, 70.0, f32::INFINITY].map(millimetres), [0, 1235, 65534, FAR, FAR]);
    }

    #[test]
    fn normals_and_numbers_are_read_back() {
        assert_eq!([-1.0, 0.0, 1.0].map(coded), [1, 128, 255]);
        assert_eq!(in_three_bytes(0x01_02_03), [1, 2, 3]);
    }
}
