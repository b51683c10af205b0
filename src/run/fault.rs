//! What went wrong in a stage, as messages with places in the user's files.

use super::files::WriteError;
use super::frame_list::ExpansionFault;
use crate::base::diagnostic::{Diagnostic, Diagnostics, Fault};
use crate::base::limits::{Limit, Refusal};
use crate::base::settings::Complaint;
use crate::deform::DeformError;
use crate::export::ExportError;
use crate::leaf::LeafError;
use crate::scene::{Places, Species};
use crate::tree::TreeError;

/// A limit that refused a table of the scene.
pub fn refused(places: &Places, table: &str, refusal: &Refusal) -> Diagnostics {
    let place = places.of(&refusal.what).or_else(|| places.of(table));
    Diagnostic::error(Fault::Limit, refusal.to_string(), refusal.help()).at(place).into()
}

/// A moment that does not come to the leaves of a scene.
pub fn no_moment(places: &Places) -> Diagnostics {
    let help = "give a series that reaches over it, or a `date`";
    Diagnostic::error(Fault::Scene, "this moment does not come in this weather", help)
        .at(places.of("time.moment"))
        .into()
}

/// The system has less memory left than the scene needs.
pub fn out_of_memory(places: &Places, table: &str, wanted: f64) -> Diagnostics {
    let what = format!("the scene needs {} MB of memory, which the system does not give", (wanted / 1e6).ceil());
    let help = "ask for less, or run it where more memory is free";
    Diagnostic::error(Fault::Limit, what, help).at(places.of(table)).into()
}

/// A fault of the tree.
pub fn tree(species: &Species, error: &TreeError) -> Diagnostics {
    match error {
        TreeError::Settings(complaints) => {
            let diagnostic = |complaint: &Complaint| species.places.diagnostic("tree", complaint.clone()).1;
            Diagnostics(complaints.iter().map(diagnostic).collect())
        }
        TreeError::Undefined { key, within } => {
            let mut complaint = Complaint::new(
                key.clone(),
                "a value of this expression is not a number",
                "guard the division or root with a condition, `A(x) : x > 0 -> ...`",
            );
            complaint.within = Some(within.clone());
            species.places.diagnostic("tree", complaint).1.into()
        }
        TreeError::Length { .. } | TreeError::Width { .. } | TreeError::Leaf { .. } | TreeError::Far => {
            Diagnostic::error(Fault::Scene, error.to_string(), "check the arguments of F, ! and L in the tree's rules")
                .at(species.places.of("tree.rules"))
                .into()
        }
        TreeError::Height { .. } => {
            Diagnostic::error(Fault::Scene, error.to_string(), "ask for less, or give tree.age in place of a height")
                .at(species.places.of("tree.height"))
                .into()
        }
        TreeError::Refused(refusal) => refused(&species.places, "tree.rules", refusal),
    }
}

/// A fault of the leaf's model. A scan that cannot be traced is named; its place is the key that names it.
pub fn leaf(species: &Species, error: &LeafError) -> Diagnostics {
    match error {
        LeafError::Picture { what } => {
            let name = species.leaf.picture.as_deref().unwrap_or_default();
            let message = format!("{name}: {what}");
            Diagnostic::error(
                Fault::Asset,
                message,
                "give a scan of one whole leaf on a plain background, or an outline",
            )
            .at(species.places.of("leaf.picture"))
            .into()
        }
        LeafError::Mesh { what } => {
            Diagnostic::error(Fault::Scene, what.clone(), "mend leaf.outline, or change leaf.vertices")
                .at(species.places.of("leaf.outline"))
                .into()
        }
        LeafError::Shapeless => {
            let help = "name a species, or give leaf.outline or leaf.picture";
            Diagnostic::error(Fault::Scene, error.to_string(), help).at(species.places.of("leaf")).into()
        }
        LeafError::Settings(complaint) => species.places.diagnostic("leaf", complaint.clone()).1.into(),
        LeafError::Refused(refusal) => refused(&species.places, "leaf.vertices", refusal),
    }
}

/// A fault of the deformation.
pub fn deform(species: &Species, error: &DeformError) -> Diagnostics {
    let (key, help) = match error {
        DeformError::Unstable { .. } => ("deform.step", "leave deform.step out to have a stable one chosen"),
        DeformError::Diverged { .. } | DeformError::Stretched { .. } => {
            ("deform.force", "lower deform.force or raise deform.stiffness")
        }
        DeformError::NotSettled { .. } => {
            ("deform.shell", "lower deform.shell.curl, or raise deform.shell.thickness or deform.shell.iterations")
        }
        DeformError::Empty | DeformError::Degenerate { .. } => {
            ("leaf", "give the leaf another outline or other vertices")
        }
        DeformError::Refused(refusal) => {
            let key = if refusal.limit == Limit::Memory { "leaf.vertices" } else { "deform.steps" };
            return refused(&species.places, key, refusal);
        }
    };
    Diagnostic::error(Fault::Scene, error.to_string(), help).at(species.places.of(key)).into()
}

/// A file that could not be written.
pub fn written(error: &WriteError) -> Diagnostics {
    let help = match error {
        WriteError::FolderInTheWay { .. } => "name another file",
        WriteError::NoName { .. } => "end the path with a file's name",
        WriteError::NoFolder { .. } => "make the folder first, or name another place",
        WriteError::System { .. } => "free space there, or name another place",
    };
    Diagnostic::error(Fault::Output, error.to_string(), help).into()
}

/// An output that could not be encoded.
pub fn export(error: &ExportError) -> Diagnostics {
    Diagnostic::error(Fault::Bug, error.to_string(), "please report it with the scene").into()
}

/// A list of frames that cannot be drawn.
pub fn frame_list(error: &ExpansionFault) -> Diagnostics {
    match error {
        ExpansionFault::Limit(refusal) => Diagnostic::error(Fault::Limit, refusal.to_string(), refusal.help()).into(),
        ExpansionFault::Twice { .. } => Diagnostic::error(Fault::Usage, error.to_string(), "").into(),
    }
}
