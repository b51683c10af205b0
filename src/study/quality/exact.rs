//! What a scene should look like: leaves, samples and levels of detail as fine as can be.

use crate::base::diagnostic::Diagnostics;
use crate::frame::Frame;
use crate::report::Reached;
use crate::run::still::Still;
use crate::scene::Scene;
use crate::study::desk::Desk;
use crate::study::linear::{Linear, reference};

/// How much larger the references are drawn, and another that they are held against.
const SIDES: [u32; 2] = [12, 9];
const FEW_SIDES: [u32; 2] = [6, 5];
/// Vertices (and those of a quick study) and tolerance of the references' leaves.
pub const VERTICES: u32 = 4000;
const FEW_VERTICES: u32 = 2000;
const TOLERANCE: f64 = 1e-5;

/// What a scene should look like with the textures that go with some vertices, and how far another reference is from that.
pub struct Exact {
    vertices: Vec<Option<u32>>,
    /// The picture.
    pub picture: Linear,
    /// Root mean square distance of the other reference.
    pub floor: f64,
}

/// The references of a scene.
pub struct References {
    still: Still,
    /// The frame with leaves as fine as can be, made once.
    fine: Option<Frame>,
    known: Vec<Exact>,
}

impl References {
    /// None yet.
    ///
    /// # Errors
    /// What stops a run of the scene.
    pub fn new(desk: &Desk<'_>, scene: &Scene) -> Result<Self, Diagnostics> {
        Ok(Self { still: Still::new(scene, 0, &desk.request.limits)?, fine: None, known: Vec::new() })
    }

    /// The picture with everything as fine as can be. Textures and camera are those that go with the vertices chosen: the spots
    /// of a leaf fall elsewhere on another mesh, and a camera that is fitted to a leaf follows its rim, which is no error.
    ///
    /// # Errors
    /// What stops a run of the scene.
    pub fn of(&mut self, desk: &mut Desk<'_>, name: &str, told: &Reached) -> Result<&Exact, Diagnostics> {
        // Nothing is chosen for a species of which no leaf is seen.
        let of = |label: &str| told.leaves.iter().find(|leaf| leaf.species == label).map(|leaf| leaf.vertices);
        let vertices: Vec<Option<u32>> = self.still.scene().species.iter().map(|one| of(one.label())).collect();
        let known = self.known.iter().position(|exact| exact.vertices == vertices);
        let at = match known {
            Some(at) => at,
            None => {
                desk.tell(&format!("quality {name}: reference"));
                let made = self.made(desk.request.quick, vertices)?;
                self.known.push(made);
                self.known.len() - 1
            }
        };
        Ok(&self.known[at])
    }

    fn made(&mut self, quick: bool, vertices: Vec<Option<u32>>) -> Result<Exact, Diagnostics> {
        let mut frame = match self.fine.take() {
            Some(frame) => frame,
            None => {
                let finest = if quick { FEW_VERTICES } else { VERTICES };
                self.frame(&vec![Some(finest); vertices.len()], Some(TOLERANCE))?
            }
        };
        self.fine = Some(frame.clone());
        let chosen = self.frame(&vertices, None)?;
        if frame.textures.len() == chosen.textures.len() {
            frame.textures = chosen.textures;
        }
        frame.camera = chosen.camera;
        let sides = if quick { FEW_SIDES } else { SIDES };
        let picture = reference(&frame, sides[0], 16);
        let floor = reference(&frame, sides[1], 8).distance(&picture).rmse;
        Ok(Exact { vertices, picture, floor })
    }

    /// The frame with leaves of some vertices, and of the tolerance given, else the scene's own.
    fn frame(&mut self, vertices: &[Option<u32>], tolerance: Option<f64>) -> Result<Frame, Diagnostics> {
        let own = self.still.scene().species.clone();
        for (species, &vertices) in self.still.species_mut().iter_mut().zip(vertices) {
            species.leaf.vertices = vertices.unwrap_or(species.leaf.vertices);
            species.deform.shell.tolerance = tolerance.unwrap_or(species.deform.shell.tolerance);
        }
        let made = self.still.frame();
        self.still.species_mut().clone_from_slice(&own);
        Ok(made?.0)
    }
}
