//! What is seen in each pixel, for data sets: how far it is, which way it faces and what it belongs to.

use super::tile::{Pixels, SIDE};
use crate::base::vector::Vec3;

/// What most samples of a pixel show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Site {
    /// Number of the instance in the frame, counted on into the ground's cover; none for sky and ground.
    pub instance: Option<u32>,
    /// Distance along the viewing axis, metres; infinite for the sky.
    pub depth: f32,
    /// Unit normal on the side of the eye, world coordinates; zero for the sky.
    pub normal: Vec3,
}

impl Default for Site {
    /// The sky.
    fn default() -> Self {
        Self { instance: None, depth: f32::INFINITY, normal: Vec3::zeros() }
    }
}

/// The sites of a picture, row by row, of those of its tiles.
pub(super) fn assembled(width: usize, height: usize, columns: usize, tiles: &[Pixels]) -> Vec<Site> {
    let site = |x: usize, y: usize| tiles[y / SIDE * columns + x / SIDE].sites[y % SIDE * SIDE + x % SIDE];
    (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| site(x, y)).collect()
}
