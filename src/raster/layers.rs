//! What a drawing holds beside its picture: what is seen in each pixel, how far it is, which way it faces and what it belongs
//! to, and its light.

use super::last::DrawnTile;
use super::tile::{Pixels, SIDE};
use crate::base::figures::Figures;
use crate::base::picture::Picture;
use crate::base::vector::Vec3;
use rayon::prelude::*;
use std::sync::Arc;

/// What is wanted of a frame beside its picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wanted {
    /// What is seen in each pixel.
    pub sites: bool,
    /// The light of each pixel.
    pub radiance: bool,
    /// The shadow on level ground.
    pub ground_shadow: bool,
    /// That nothing is kept for a next frame.
    pub is_last: bool,
}

/// A frame as it was drawn.
#[derive(Clone, Debug)]
pub struct Drawing {
    /// The picture.
    pub picture: Picture,
    /// What is seen in each pixel, row by row; empty when it is not wanted.
    pub sites: Vec<Site>,
    /// Exposed linear light of each pixel before the tone curve, red, green, blue, and the share that shows anything, row by row;
    /// empty when it is not wanted.
    pub radiance: Vec<[f32; 4]>,
    /// The share of its light that the ground at height 0 loses to what stands on it, 0 to 255, row by row; empty when it is not
    /// wanted.
    pub ground_shadow: Vec<u8>,
    /// What it took.
    pub figures: Figures,
}

/// What most samples of a pixel show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Site {
    /// Number of the instance in the frame, counted on into the ground's cover; none for the sky and level ground.
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

/// What tiles hold for each of their pixels, row by row of the picture.
pub(super) fn assembled<T: Copy + Default + Send + Sync>(
    [width, height]: [usize; 2],
    columns: usize,
    tiles: &[Arc<DrawnTile>],
    of: impl Fn(&Pixels) -> &[T] + Sync,
) -> Vec<T> {
    let mut all = vec![T::default(); width * height];
    all.par_chunks_mut(width.max(1)).enumerate().for_each(|(y, row)| {
        let tiles = &tiles[y / SIDE * columns..][..columns];
        for (part, tile) in row.chunks_mut(SIDE).zip(tiles) {
            part.copy_from_slice(&of(&tile.pixels)[y % SIDE * SIDE..][..part.len()]);
        }
    });
    all
}
