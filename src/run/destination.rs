//! Whether what a run writes has a place, asked before the work: hours of drawing should not end at a misspelt folder.
//! Nothing is made yet, since a run that fails leaves nothing behind.

use super::manifest::Manifest;
use super::{fault, files};
use crate::base::diagnostic::{Diagnostic, Diagnostics, Fault};
use crate::base::message;
use crate::scene::Scene;
use std::path::Path;

/// Longest name of a file on every common file system, bytes.
const LONGEST_NAME: usize = 255;

/// Checks the folder for the frames, the length of their names, and the file of states.
///
/// # Errors
/// What could not be written.
pub fn check(scene: &Scene, out: &Path, states: Option<&Path>) -> Result<(), Diagnostics> {
    folder(out)?;
    names(scene)?;
    states.map_or(Ok(()), file)
}

/// Checks a single file, such as the report.
///
/// # Errors
/// Its folder is not there, or a folder has its name.
pub fn file(path: &Path) -> Result<(), Diagnostics> {
    files::check(path).map_err(|error| fault::written(&error))
}

/// Whether a folder for output is there or could be made.
///
/// # Errors
/// Something else has its name, or that of a folder above it.
pub fn folder(out: &Path) -> Result<(), Diagnostics> {
    let there = out.ancestors().find(|path| std::fs::symlink_metadata(path).is_ok());
    match there.filter(|path| !path.is_dir()) {
        Some(path) => {
            let shown = |path: &Path| message::shown(&path.to_string_lossy(), 200);
            let what = format!("cannot make the folder {}: {} is not a folder", shown(out), shown(path));
            Err(Diagnostic::error(Fault::Output, what, "name another folder with --out").into())
        }
        None => Ok(()),
    }
}

/// Whether the names of the files will be taken: a manifest that cannot be written beside its picture would leave half a
/// frame.
fn names(scene: &Scene) -> Result<(), Diagnostics> {
    let frames = scene.time.count() as u64;
    let length = Manifest::file_name(&scene.name, -(1 << 31), frames).len();
    if length <= LONGEST_NAME {
        return Ok(());
    }
    let what = format!("names of files would be {length} bytes long, the most is {LONGEST_NAME}");
    Err(Diagnostic::error(Fault::Output, what, "give the scene file a shorter name").into())
}
