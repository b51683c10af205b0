//! The vertices of leaves by what is seen of them: pictures with leaves of some vertices against pictures with finer ones.

use super::probe::Probe;
use crate::base::diagnostic::Diagnostics;
use crate::frame::Frame;
use crate::run::still::Still;
use std::collections::BTreeMap;

/// Vertices that are tried.
const VERTICES: [u32; 6] = [40, 80, 160, 320, 640, 1280];
/// How many times the vertices have those that leaves are held against.
const FINER: u32 = 2;
/// The error of a mesh over its distance from the finer one (measured: 1.0 to 1.4 on leaves, twigs and trees).
const FARTHER: f64 = 1.25;

/// The fewest vertices of a species' leaves with which pictures stay within an error, and the error they have; the most there
/// are when none does. The search begins near those that the species has.
///
/// # Errors
/// What stops a run of the scene.
pub fn fewest(
    (still, probe): (&mut Still, &mut Probe),
    number: usize,
    allowed: f64,
) -> Result<(u32, f64), Diagnostics> {
    let usual = still.scene().species[number].leaf.vertices;
    let mut worn = Worn { still, probe, number, frames: BTreeMap::new() };
    let last = VERTICES.len() - 1;
    let mut rung = VERTICES.iter().position(|&vertices| vertices >= usual).unwrap_or(last);
    let mut error = worn.error(VERTICES[rung])?;
    while error > allowed && rung < last {
        rung += 1;
        error = worn.error(VERTICES[rung])?;
        if error <= allowed {
            return Ok((VERTICES[rung], error));
        }
    }
    while error <= allowed && rung > 0 {
        let coarser = worn.error(VERTICES[rung - 1])?;
        if coarser > allowed {
            break;
        }
        (rung, error) = (rung - 1, coarser);
    }
    Ok((VERTICES[rung], error))
}

/// A moment whose leaves of one species change.
struct Worn<'a> {
    still: &'a mut Still,
    probe: &'a mut Probe,
    number: usize,
    /// By the vertices of those leaves.
    frames: BTreeMap<u32, Frame>,
}

impl Worn<'_> {
    /// The error that the picture has with leaves of some vertices.
    fn error(&mut self, vertices: u32) -> Result<f64, Diagnostics> {
        let own = self.frame(vertices)?;
        let mut finer = self.frame(vertices * FINER)?;
        // The spots of a leaf fall elsewhere on another mesh, and a camera may follow its rim: neither is an error.
        if finer.textures.len() == own.textures.len() {
            finer.textures.clone_from(&own.textures);
        }
        finer.camera = own.camera.clone();
        Ok(self.probe.apart(&own, &finer) * FARTHER)
    }

    fn frame(&mut self, vertices: u32) -> Result<Frame, Diagnostics> {
        if let Some(frame) = self.frames.get(&vertices) {
            return Ok(frame.clone());
        }
        let before = self.still.scene().species[self.number].leaf.vertices;
        self.still.species_mut()[self.number].leaf.vertices = vertices;
        let made = self.still.frame();
        self.still.species_mut()[self.number].leaf.vertices = before;
        let (frame, _) = made?;
        self.frames.insert(vertices, frame.clone());
        Ok(frame)
    }
}
