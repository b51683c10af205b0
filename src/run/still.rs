//! One moment of a scene as a resolved frame, without a file: what is drawn in several ways, to see how far they are apart.

use super::leaf_falls;
use super::preparation::{self, Asked, Prepared};
use super::wardrobe::{self, Atelier};
use crate::base::diagnostic::{Diagnostic, Diagnostics, Fault};
use crate::base::limits::Limits;
use crate::compose::{Falls, Stock};
use crate::frame::Frame;
use crate::plan;
use crate::report::Report;
use crate::scene::camera::Subject;
use crate::scene::{Scene, Species};
use crate::season::LeafStates;
use std::collections::BTreeMap;

/// A scene at a moment: its trees have grown and every leaf's state is drawn.
pub struct Still {
    prepared: Prepared,
    states: Option<LeafStates>,
    falls: Option<Falls>,
    index: i64,
    limits: Limits,
}

impl Still {
    /// The moment of a frame. Of a contact sheet the first cell is taken.
    ///
    /// # Errors
    /// What the trees' rules or the limits refuse.
    pub fn new(scene: &Scene, index: i64, limits: &Limits) -> Result<Self, Diagnostics> {
        let mut cells = super::cells(scene);
        cells.truncate(1);
        let asked = Asked { frames: &[index], limits, leave_out: true, states_frames: 0, enlarged: 1, stop: &|| false };
        let mut report = Report::default();
        let prepared = preparation::prepare(cells, &asked, &mut report)?.into_iter().next();
        let nothing = || Diagnostic::error(Fault::Bug, "a scene without a cell", "please report it");
        let mut prepared = prepared.ok_or_else(nothing)?;
        let states = prepared.assigned(index, &mut report);
        let falls = states.as_ref().and_then(|states| {
            let Prepared { scene, stand, ways, .. } = &mut prepared;
            leaf_falls::falls((scene, stand), states, index, ways)
        });
        Ok(Self { prepared, states, falls, index, limits: limits.clone() })
    }

    /// The scene, its moment resolved to a day.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.prepared.scene
    }

    /// The limits in force.
    #[must_use]
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// The number of the species of each leaf, by its id.
    #[must_use]
    pub fn species_of_leaves(&self) -> BTreeMap<u64, usize> {
        let stand = &self.prepared.stand;
        stand.leaf_ids.iter().copied().zip(stand.species_of_leaves()).collect()
    }

    /// The species, whose leaves may be made otherwise; what decides trees and states must stay as it is.
    pub fn species_mut(&mut self) -> &mut [Species] {
        &mut self.prepared.scene.species
    }

    /// The frame, with the report of the stages that made it.
    ///
    /// # Errors
    /// As those of a run: pictures, outlines, shapes that do not settle, limits.
    pub fn frame(&self) -> Result<(Frame, Report), Diagnostics> {
        let mut report = Report::default();
        let Prepared { scene, stand, plan, .. } = &self.prepared;
        let wardrobe = wardrobe::wardrobe(&self.prepared, &self.limits, &mut Atelier::default(), &mut report)?;
        let stock = Stock::new(scene, stand, &wardrobe);
        let worn = self.states.as_ref().map_or_else(Vec::new, |states| plan::garments(scene, stand, states));
        let trees = stock.frame(scene, stand, &worn);
        let leaf = (scene.camera.subject == Subject::Leaf).then(|| stock.specimen(scene, &worn, &trees));
        let mut frame = leaf.flatten().unwrap_or(trees);
        stock.aim(scene, stand, self.index, &mut frame);
        let frame = match &self.falls {
            Some(falls) if plan.has("fall") => stock.strewn(scene, stand, falls, frame).0,
            _ => frame,
        };
        Ok((frame, report))
    }
}
