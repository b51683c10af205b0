//! The vertices of leaves by what is seen of them: pictures with leaves of some vertices against pictures with finer ones.

use super::probe::Probe;
use crate::base::diagnostic::Diagnostics;
use crate::frame::Frame;
use crate::run::still::Still;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// Vertices that are tried.
const VERTICES: [u32; 6] = [40, 80, 160, 320, 640, 1280];
/// How many times the vertices have those that leaves are held against.
const FINER: u32 = 2;
/// Pixels along the sides of the textures that they wear: it is meshes that are looked at.
const TEXTURE: u32 = 64;
/// The error of a mesh over its distance from the finer one (measured: 1.0 to 1.4 on leaves, twigs and trees).
const FARTHER: f64 = 1.25;

/// What was drawn and measured of a species' leaves so far, by their vertices.
#[derive(Default)]
pub struct Worn {
    frames: BTreeMap<u32, Frame>,
    errors: BTreeMap<u32, f64>,
}

impl Worn {
    /// The fewest vertices of a species' leaves with which pictures of a moment stay within an error, and the error they have;
    /// the most there are when none does. Outlines that have no mesh of so few vertices need more.
    ///
    /// # Errors
    /// What stops a run of the scene.
    pub fn fewest(
        &mut self,
        (still, probe): (&mut Still, &mut Probe),
        number: usize,
        allowed: f64,
    ) -> Result<(u32, f64), Diagnostics> {
        let [fewer @ .., most] = VERTICES;
        for vertices in fewer {
            if let Ok(error) = self.error(still, probe, number, vertices)
                && error <= allowed
            {
                return Ok((vertices, error));
            }
        }
        Ok((most, self.error(still, probe, number, most)?))
    }

    /// The error that the picture has with leaves of some vertices.
    fn error(
        &mut self,
        still: &mut Still,
        probe: &mut Probe,
        number: usize,
        vertices: u32,
    ) -> Result<f64, Diagnostics> {
        if let Some(error) = self.errors.get(&vertices) {
            return Ok(*error);
        }
        let mut finer = self.frame(still, number, vertices * FINER)?.clone();
        let own = self.frame(still, number, vertices)?;
        // The spots of a leaf fall elsewhere on another mesh, and a camera may follow its rim: neither is an error.
        if finer.textures.len() == own.textures.len() {
            finer.textures.clone_from(&own.textures);
        }
        finer.camera = own.camera;
        let error = probe.apart(own, &finer) * FARTHER;
        self.errors.insert(vertices, error);
        Ok(error)
    }

    fn frame(&mut self, still: &mut Still, number: usize, vertices: u32) -> Result<&Frame, Diagnostics> {
        match self.frames.entry(vertices) {
            Entry::Occupied(known) => Ok(known.into_mut()),
            Entry::Vacant(place) => {
                let species = &mut still.species_mut()[number];
                let before = (species.leaf.vertices, species.colour.size);
                (species.leaf.vertices, species.colour.size) = (vertices, Some(TEXTURE));
                let made = still.frame();
                let species = &mut still.species_mut()[number];
                (species.leaf.vertices, species.colour.size) = before;
                Ok(place.insert(made?.0))
            }
        }
    }
}
