//! What the families look at in a scene of the user's: its first species' blade, chain and shape, at its first frame.

use super::chain;
use super::deform::{self, Problem};
use super::desk::Desk;
use crate::base::diagnostic::Diagnostics;
use crate::base::limits::Limits;
use crate::base::vector::DVec2;
use crate::deform::Model;
use crate::leaf::{self, Pictures};
use crate::run::still::Still;
use crate::scene::{Scene, Species};

/// Most pixels of a picture of the user's in a study: references have many times as many.
const PIXELS: f64 = 120_000.0;
const FEW_PIXELS: f64 = 24_000.0;

/// Width and height of a scene's picture in a study.
#[must_use]
pub fn sides(scene: &Scene, quick: bool) -> [u32; 2] {
    let most = if quick { FEW_PIXELS } else { PIXELS };
    let share = (most / scene.image.pixels()).sqrt().min(1.0);
    [scene.image.width, scene.image.height].map(|side| ((f64::from(side) * share) as u32).max(1))
}

/// A scene as a study draws it: its first cell if it is a sheet, no larger than a study can afford, and nothing but the picture.
#[must_use]
pub fn pictured(scene: &Scene, quick: bool) -> Scene {
    let [width, height] = sides(scene, quick);
    let mut own = if scene.cell_count() > 0 { scene.cell(0, [width, height]) } else { scene.clone() };
    (own.image.width, own.image.height) = (width, height);
    (own.output.png, own.output.gltf, own.output.inset) = (true, None, false);
    own
}

/// The parts of a scene that can be studied; what cannot is told in the report.
#[derive(Default)]
pub struct Own {
    /// Its chain.
    pub chain: Option<chain::Own>,
    /// Its blade.
    pub blade: Option<(String, leaf::Settings)>,
    /// How the blade bends.
    pub bending: Option<Problem>,
}

impl Own {
    /// The parts of a scene.
    ///
    /// # Errors
    /// What the trees' rules or the limits refuse.
    pub fn of(desk: &mut Desk<'_>, scene: &Scene) -> Result<Self, Diagnostics> {
        let still = Still::new(scene, 0, &desk.request.limits)?;
        let Some(species) = still.scene().species.first() else { return Ok(Self::default()) };
        let name = species.label().to_owned();
        let has_seasons = !species.season.states.is_empty();
        let chain = has_seasons.then(|| chain::Own {
            name: name.clone(),
            settings: species.season.clone(),
            weather: still.scene().weather.clone(),
            day: still.scene().time.at(0),
        });
        let is_drawn = species.leaf.outline.is_some() && !species.assets.contains_key("leaf.picture");
        let blade = is_drawn.then(|| (name.clone(), species.leaf.clone()));
        let bending = blade.as_ref().filter(|_| species.deform.model == Model::Shell).and_then(|_| bending(species));
        for (part, is_there, why) in [
            ("chain", chain.is_some(), "its first species has no seasons"),
            ("mesh", blade.is_some(), "its leaf is a scan, or it has none: trace it first and give leaf.outline"),
            ("deform", bending.is_some(), "its leaf has no outline, or is not bent by the model \"shell\""),
        ] {
            if !is_there {
                desk.section(&format!("Left out: {part}"), &format!("The scene gives nothing to study here: {why}."));
            }
        }
        Ok(Self { chain, blade, bending })
    }
}

/// The blade of a species, bent as it dries.
fn bending(species: &Species) -> Option<Problem> {
    let (blade, _) = leaf::model(&species.leaf, Pictures::default(), &Limits::default()).ok()?;
    let first = *blade.mesh.positions.first()?;
    let ends = |(low, high): (DVec2, DVec2), p: &DVec2| (low.inf(p), high.sup(p));
    let (low, high) = blade.mesh.positions.iter().fold((first, first), ends);
    let settings = species.deform.shell.clone();
    let ways = deform::ways_around(settings.tolerance);
    Some(Problem { name: species.label().to_owned(), mesh: blade.mesh, extent: (high - low).max(), settings, ways })
}
