//! Files that a scene names: where they may lie, what they contain, and pictures among them.
//!
//! A path is relative to the scene's folder; what is not found there is looked for below each asset root. Absolute paths,
//! paths that climb out, links that lead out, devices and folders are refused: a scene from a stranger must not read
//! the rest of the disk into a picture.

use super::spelling;
use crate::base::diagnostic::{Diagnostic, Fault, Place};
use crate::base::limits::{Limit, Limits};
use crate::base::message::shown;
use serde::Serializer;
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

mod jpeg;
mod picture;
pub use picture::read_picture;

/// Keys whose text is the path of a picture, or of a file that names pictures.
const KEYS: [&str; 4] = ["leaf.picture", "leaf.mask", "leaf.texture", "leaf.file"];
/// A table whose every text is the path of a picture.
const SCANS: &str = "colour.scans";
/// Bytes of a file for each pixel that a picture may have: more than an uncompressed PNG of 8 bits a channel takes.
const BYTES_PER_PIXEL: f64 = 5.0;
/// Characters of a path in a message.
const QUOTED: usize = 120;
/// Entries of a folder among which a similar name is sought.
const MOST_NEIGHBOURS: usize = 10_000;

/// A file that the scene names.
#[derive(Clone, Debug, PartialEq)]
pub struct Asset {
    /// The path as the scene gives it.
    pub name: String,
    /// Where it was found.
    pub path: PathBuf,
    /// SHA-256 of its content in hexadecimal digits.
    pub sha256: String,
    /// Where the scene names it.
    pub place: Option<Place>,
}

impl Asset {
    /// A file that the command line names: any path, its content not hashed.
    #[must_use]
    pub fn outside(path: &Path) -> Self {
        let name = path.to_string_lossy().into_owned();
        Self { name, path: path.to_owned(), sha256: String::new(), place: None }
    }
}

/// The paths that a resolved table names, with their keys.
pub(super) fn named(whole: &Value) -> Vec<(String, String)> {
    let at = |key: &str| whole.pointer(&format!("/{}", key.replace('.', "/")));
    let text = |key: &str| at(key).and_then(Value::as_str).map(|name| (key.to_owned(), name.to_owned()));
    let scans = at(SCANS).and_then(Value::as_object).into_iter().flatten();
    let scan =
        |(state, name): (&String, &Value)| name.as_str().map(|name| (format!("{SCANS}.{state}"), name.to_owned()));
    KEYS.into_iter().filter_map(text).chain(scans.filter_map(scan)).collect()
}

/// Only the hashes, by key: two names of one content are the same scene.
pub(super) fn hashes<S: Serializer>(assets: &BTreeMap<String, Asset>, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(assets.iter().map(|(key, asset)| (key, &asset.sha256)))
}

/// Finds a file and hashes its content.
pub(super) fn find(name: &str, folder: &Path, roots: &[PathBuf], limits: &Limits) -> Result<Asset, Diagnostic> {
    let path = locate(name, folder, roots)?;
    let length = fs::metadata(&path).map_err(|error| unreadable(name, &error))?.len();
    allow_bytes(name, length, limits)?;
    let mut hash = Sha256::new();
    let file = File::open(&path).map_err(|error| unreadable(name, &error))?;
    io::copy(&mut file.take(length), &mut hash).map_err(|error| unreadable(name, &error))?;
    Ok(Asset { name: name.to_owned(), path, sha256: hexadecimal(&hash.finalize()), place: None })
}

/// Finds a file below the scene's folder or one of the roots.
///
/// # Errors
/// [`Fault::Asset`], without a place: the path may not be used, or there is no such file.
pub fn locate(name: &str, scene_folder: &Path, roots: &[PathBuf]) -> Result<PathBuf, Diagnostic> {
    let relative = relative(name)?;
    let folders: Vec<&Path> = std::iter::once(scene_folder).chain(roots.iter().map(PathBuf::as_path)).collect();
    for folder in &folders {
        if let Some(path) = below(folder, &relative, name)? {
            return Ok(path);
        }
    }
    let tried = shown(&folders[0].join(&relative).to_string_lossy(), QUOTED);
    let more = if roots.is_empty() { String::new() } else { format!(", nor below {} asset root(s)", roots.len()) };
    let what = format!("there is no file \"{}\": looked for {tried}{more}", shown(name, QUOTED));
    let help = match folders.iter().find_map(|folder| neighbour(&folder.join(&relative))) {
        Some(near) => format!("did you mean \"{}\"?", shown(&near, QUOTED)),
        None => "paths are relative to the scene's folder; name other folders with --asset-root".to_owned(),
    };
    Err(Diagnostic::error(Fault::Asset, what, help))
}

/// The path as a chain of names, if it stays below where it begins.
fn relative(name: &str) -> Result<PathBuf, Diagnostic> {
    let refused = |why: &str| {
        let help = "paths are relative to the scene's folder; name other folders with --asset-root";
        Err(Diagnostic::error(Fault::Asset, format!("\"{}\" {why}", shown(name, QUOTED)), help))
    };
    let mut path = PathBuf::new();
    for component in Path::new(name).components() {
        match component {
            Component::Normal(part) => path.push(part),
            Component::CurDir => {}
            Component::ParentDir if path.pop() => {}
            Component::ParentDir => return refused("climbs out of its folder"),
            Component::RootDir | Component::Prefix(_) => return refused("is an absolute path"),
        }
    }
    if path.as_os_str().is_empty() { refused("names no file") } else { Ok(path) }
}

/// The file below one folder; none when it is not there.
fn below(folder: &Path, relative: &Path, name: &str) -> Result<Option<PathBuf>, Diagnostic> {
    let path = folder.join(relative);
    let (root, real) = match (fs::canonicalize(folder), fs::canonicalize(&path)) {
        (Ok(root), Ok(real)) => (root, real),
        (_, Err(error)) if !is_absent(&error) => return Err(unreadable(name, &error)),
        _ => return Ok(None),
    };
    let refused = |why: &str, help: &str| {
        Err(Diagnostic::error(Fault::Asset, format!("\"{}\" {why}", shown(name, QUOTED)), help))
    };
    if !real.starts_with(&root) {
        return refused("is a link that leads out of its folder", "put the file itself there");
    }
    match fs::metadata(&real) {
        Ok(metadata) if metadata.is_file() => Ok(Some(path)),
        Ok(_) => refused("is no file but a folder or device", "name a file"),
        Err(error) => Err(unreadable(name, &error)),
    }
}

fn is_absent(error: &io::Error) -> bool {
    use io::ErrorKind::{InvalidFilename, InvalidInput, NotADirectory, NotFound};
    matches!(error.kind(), NotFound | NotADirectory | InvalidInput | InvalidFilename)
}

/// A similar name in the folder where the file should be.
fn neighbour(path: &Path) -> Option<String> {
    let wrong = path.file_name()?.to_str()?;
    let entries = fs::read_dir(path.parent()?).ok()?;
    let mut names: Vec<String> =
        entries.take(MOST_NEIGHBOURS).filter_map(|entry| entry.ok()?.file_name().into_string().ok()).collect();
    names.sort();
    spelling::nearest(wrong, names.iter().map(String::as_str)).map(str::to_owned)
}

/// Asks whether a file of so many bytes may be read.
fn allow_bytes(name: &str, length: u64, limits: &Limits) -> Result<(), Diagnostic> {
    let pixels = length as f64 / BYTES_PER_PIXEL;
    let what = format!("\"{}\" ({} MB)", shown(name, QUOTED), length / 1_000_000);
    let allowed = limits.allow(Limit::PicturePixels, &what, pixels);
    allowed.map_err(|refusal| Diagnostic::error(Fault::Limit, refusal.to_string(), refusal.help()))
}

fn unreadable(name: &str, error: &io::Error) -> Diagnostic {
    let what = format!("cannot read \"{}\": {error}", shown(name, QUOTED));
    Diagnostic::error(Fault::Asset, what, "let the file be readable")
}

/// Bytes as hexadecimal digits.
pub(super) fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
