//! What the frames of a run share: meshes cut and simplified, textures halved, tiles in which nothing changes.

use super::cluster::ClusteredMesh;
use super::last::Last;
use super::layers::{Drawing, Wanted};
use super::of_plain_numbers;
use super::texture::{Codes, MipMap};
use crate::base::mesh::Mesh;
use crate::frame::{Frame, Texture};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Draws frame after frame, and keeps what a frame needs of meshes and textures for the next as long as someone else keeps
/// them too; what it drew last, as long as it draws.
#[derive(Default)]
pub struct Renderer {
    meshes: Shelf<Mesh, ClusteredMesh>,
    textures: Shelf<Texture, MipMap>,
    /// The frame that was drawn last.
    pub(super) last: Option<Last>,
}

/// Things made of others, found by where those lie in memory. That they are held here keeps the place theirs.
struct Shelf<From, Made>(BTreeMap<usize, (Arc<From>, Arc<Made>)>);

impl<From, Made> Default for Shelf<From, Made> {
    fn default() -> Self {
        Self(BTreeMap::new())
    }
}

fn place<T>(of: &Arc<T>) -> usize {
    Arc::as_ptr(of).addr()
}

impl<From: Send + Sync, Made: Send + Sync> Shelf<From, Made> {
    /// What was made of each; what is not there, or does not serve, is made now.
    fn all(
        &mut self,
        wanted: &[Arc<From>],
        serves: impl Fn(usize, &Made) -> bool,
        make: impl Fn(usize, &From) -> Made + Sync,
    ) -> Vec<Arc<Made>> {
        let missing = |(number, from): &(usize, &Arc<From>)| {
            !self.0.get(&place(from)).is_some_and(|(_, made)| serves(*number, made))
        };
        let missing: Vec<(usize, &Arc<From>)> = wanted.iter().enumerate().filter(missing).collect();
        let made: Vec<Arc<Made>> = missing.par_iter().map(|(number, from)| Arc::new(make(*number, from))).collect();
        for ((_, from), made) in missing.into_iter().zip(made) {
            self.0.insert(place(from), (from.clone(), made));
        }
        let all = wanted.iter().map(|from| self.0[&place(from)].1.clone()).collect();
        self.0.retain(|_, (from, _)| Arc::strong_count(from) > 1);
        all
    }
}

impl Renderer {
    /// Draws a frame that is none of the run's: what is kept of the last of those stays.
    #[must_use]
    pub fn draw_apart(&mut self, frame: &Frame, wanted: Wanted) -> Drawing {
        let last = self.last.take();
        let drawing = self.draw_wanted(frame, Wanted { is_last: true, ..wanted });
        self.last = last;
        drawing
    }

    /// The meshes of a frame, cut into clusters.
    pub(super) fn meshes(&mut self, frame: &Frame) -> Vec<Arc<ClusteredMesh>> {
        self.meshes.all(&frame.meshes, |_, _| true, |_, mesh| ClusteredMesh::new(mesh))
    }

    /// The textures of a frame, each halved at least as often as is said; those that hold plain numbers as
    /// such.
    pub(super) fn textures(&mut self, frame: &Frame, halvings: &[u32]) -> Vec<Arc<MipMap>> {
        let reliefs = frame.materials.iter().filter_map(|material| material.relief);
        let plain: BTreeSet<u32> = reliefs.chain(of_plain_numbers(frame)).collect();
        let codes = |number: usize| if plain.contains(&(number as u32)) { Codes::Plain } else { Codes::Colour };
        let serves = |number: usize, map: &MipMap| map.first() <= halvings[number] && map.codes() == codes(number);
        self.textures
            .all(&frame.textures, serves, |number, texture| MipMap::new(texture, codes(number), halvings[number]))
    }
}
