//! What a finished frame is made of: a small JSON file beside it, `NAME.0000.manifest.json`. A frame counts as finished if
//! this says that it was drawn by the same build from the same scene, and the content of its files is what was written
//! then. Names, sizes and dates are never trusted. It holds no time, host or thread count, so it too is the same every time.

use super::files::{self, WriteError};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// The program that this is: a hash of its source, lock file and features, made when it was built.
pub const BUILD: &str = env!("LEAFSEASON_BUILD_ID");

/// How manifests end.
pub const SUFFIX: &str = ".manifest.json";

/// A manifest takes less than a kilobyte; what is larger is not one.
const LARGEST: u64 = 1 << 20;

/// What decides every byte of a frame.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Key {
    /// Build id of the program that drew it.
    pub build: String,
    /// Hash of the resolved scene and the content of every file it names.
    pub scene: String,
    /// Number of the frame; negative before the scene's start.
    pub frame: i64,
}

/// A file of a frame.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Entry {
    /// Its name, without folders.
    pub name: String,
    /// SHA-256 of its content in hexadecimal.
    pub sha256: String,
}

/// A frame's manifest.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// NAME of the scene, as the frames' names begin.
    pub name: String,
    /// Frames of the whole scene, so that missing ones are noticed.
    pub frames: u64,
    /// What was drawn.
    pub key: Key,
    /// Its files.
    pub files: Vec<Entry>,
}

/// What is wrong with one file of a frame, or with its manifest.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum FileFault {
    /// It is not there.
    #[error("is missing")]
    Missing,
    /// It is a folder, a link or a device.
    #[error("is not a plain file")]
    NotAFile,
    /// It cannot be read.
    #[error("cannot be read: {0}")]
    Unreadable(String),
    /// The content is not what was written.
    #[error("is damaged: its content is not what was written")]
    Damaged,
    /// The manifest names a file in another folder.
    #[error("is named with a folder")]
    Elsewhere,
    /// The manifest is not one.
    #[error("is not a manifest: {0}")]
    NotAManifest(String),
}

impl Manifest {
    /// The manifest of a frame whose files are about to be written.
    #[must_use]
    pub fn new(name: &str, frames: u64, key: Key, files: &[(String, &[u8])]) -> Self {
        let entry = |(name, bytes): &(String, &[u8])| Entry { name: name.clone(), sha256: hash(bytes) };
        Self { name: name.to_owned(), frames, key, files: files.iter().map(entry).collect() }
    }

    /// The file name of the manifest of a frame.
    #[must_use]
    pub fn file_name(name: &str, frame: i64, frames: u64) -> String {
        format!("{}{SUFFIX}", files::stem(name, frame, frames))
    }

    /// Writes it beside its frame. To be done last: until then the frame does not count.
    ///
    /// # Errors
    /// [`WriteError`] as for any file.
    pub fn write(&self, folder: &Path) -> Result<PathBuf, WriteError> {
        let path = folder.join(Self::file_name(&self.name, self.key.frame, self.frames));
        let failed = |error: serde_json::Error| WriteError::System { path: path.clone(), source: error.into() };
        let mut text = serde_json::to_vec_pretty(self).map_err(failed)?;
        text.push(b'\n');
        files::write(&path, &text)?;
        Ok(path)
    }

    /// Reads a manifest.
    ///
    /// # Errors
    /// The [`FileFault`] of the manifest itself; its files are not looked at.
    pub fn read(path: &Path) -> Result<Self, FileFault> {
        let mut text = Vec::new();
        let unreadable = |error: io::Error| FileFault::Unreadable(error.to_string());
        plain_file(path)?.take(LARGEST).read_to_end(&mut text).map_err(unreadable)?;
        serde_json::from_slice(&text).map_err(|error| FileFault::NotAManifest(error.to_string()))
    }

    /// Every fault among its files, with the file's name.
    #[must_use]
    pub fn faults(&self, folder: &Path) -> Vec<(String, FileFault)> {
        self.files.iter().filter_map(|entry| Some((entry.name.clone(), entry.fault(folder)?))).collect()
    }
}

impl Entry {
    fn fault(&self, folder: &Path) -> Option<FileFault> {
        if Path::new(&self.name).file_name() != Some(self.name.as_ref()) {
            return Some(FileFault::Elsewhere);
        }
        match hash_file(&folder.join(&self.name)) {
            Ok(hash) => (hash != self.sha256).then_some(FileFault::Damaged),
            Err(fault) => Some(fault),
        }
    }
}

/// Whether a frame is finished: its manifest has the key, frame count and names (in this order) that are wanted now, and
/// every file has the content that was written.
#[must_use]
pub fn is_done(folder: &Path, name: &str, frames: u64, key: &Key, wanted: &[String]) -> bool {
    let path = folder.join(Manifest::file_name(name, key.frame, frames));
    let Ok(manifest) = Manifest::read(&path) else { return false };
    let same = manifest.name == name && manifest.frames == frames && manifest.key == *key;
    same && manifest.files.iter().map(|entry| &entry.name).eq(wanted) && manifest.faults(folder).is_empty()
}

/// SHA-256 in hexadecimal.
#[must_use]
pub fn hash(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

fn hash_file(path: &Path) -> Result<String, FileFault> {
    let mut file = plain_file(path)?;
    let mut hash = Sha256::new();
    io::copy(&mut file, &mut hash).map_err(|error| FileFault::Unreadable(error.to_string()))?;
    Ok(hexadecimal(&hash.finalize()))
}

/// Opens a plain file. A link is none: the frame is to lie here. A pipe would block.
fn plain_file(path: &Path) -> Result<File, FileFault> {
    let fault = |error: io::Error| match error.kind() {
        io::ErrorKind::NotFound => FileFault::Missing,
        _ => FileFault::Unreadable(error.to_string()),
    };
    if !fs::symlink_metadata(path).map_err(fault)?.is_file() {
        return Err(FileFault::NotAFile);
    }
    File::open(path).map_err(fault)
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use tempfile::{TempDir, tempdir};

    fn key(frame: i64) -> Key {
        Key { build: BUILD.to_owned(), scene: "s".to_owned(), frame }
    }

    fn finished(frame: i64) -> (TempDir, Vec<String>) {
        let folder = tempdir().unwrap();
        let names = ["png", "glb"].map(|end| format!("{}.{end}", files::stem("maple", frame, 5))).to_vec();
        let contents: Vec<(String, &[u8])> = names.iter().map(|name| (name.clone(), name.as_bytes())).collect();
        contents.iter().for_each(|(name, bytes)| files::write(&folder.path().join(name), bytes).unwrap());
        Manifest::new("maple", 5, key(frame), &contents).write(folder.path()).unwrap();
        (folder, names)
    }

    #[test]
    fn the_hash_is_sha256() {
        assert_eq!(hash(b"abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    }

    #[test]
    fn a_finished_frame_is_done_under_its_own_key_only() {
        let (folder, names) = finished(3);
        let done = |key: &Key, names: &[String]| is_done(folder.path(), "maple", 5, key, names);
        assert!(done(&key(3), &names));
        assert!(!done(&key(2), &names));
        assert!(!done(&Key { build: "other".to_owned(), ..key(3) }, &names));
        assert!(!done(&Key { scene: "other".to_owned(), ..key(3) }, &names));
        assert!(!done(&key(3), &names[..1]));
        assert!(!is_done(folder.path(), "maple", 6, &key(3), &names));
        assert!(folder.path().join("maple.0003.manifest.json").is_file());
    }

    #[test]
    fn every_kind_of_damage_is_noticed() {
        type Damage = fn(&Path);
        let damages: [(Damage, FileFault); 5] = [
            (|path| fs::write(path, b"maple.0003.pn").unwrap(), FileFault::Damaged),
            (|path| fs::write(path, b"maple.0003.pnG").unwrap(), FileFault::Damaged),
            (|path| fs::write(path, b"").unwrap(), FileFault::Damaged),
            (|path| fs::remove_file(path).unwrap(), FileFault::Missing),
            (
                |path| {
                    fs::remove_file(path).unwrap();
                    fs::create_dir(path).unwrap();
                },
                FileFault::NotAFile,
            ),
        ];
        for (damage, wanted) in damages {
            let (folder, names) = finished(3);
            damage(&folder.path().join(&names[0]));
            assert!(!is_done(folder.path(), "maple", 5, &key(3), &names));
            let manifest = Manifest::read(&folder.path().join("maple.0003.manifest.json")).unwrap();
            assert_eq!(manifest.faults(folder.path()), [(names[0].clone(), wanted)]);
        }
    }

    #[test]
    fn a_manifest_cannot_point_out_of_its_folder() {
        let folder = tempdir().unwrap();
        for name in ["../x", "/etc/passwd", "a/b", "..", ""] {
            let entry = Entry { name: name.to_owned(), sha256: String::new() };
            assert_eq!(entry.fault(folder.path()), Some(FileFault::Elsewhere), "{name:?}");
        }
    }

    #[test]
    fn a_damaged_manifest_makes_the_frame_undone() {
        let (folder, names) = finished(3);
        let path = folder.path().join("maple.0003.manifest.json");
        let text = fs::read(&path).unwrap();
        for length in [0, 1, text.len() / 2, text.len() - 3] {
            fs::write(&path, &text[..length]).unwrap();
            assert!(!is_done(folder.path(), "maple", 5, &key(3), &names));
            assert!(matches!(Manifest::read(&path), Err(FileFault::NotAManifest(_))));
        }
        fs::write(&path, &text).unwrap();
        assert!(is_done(folder.path(), "maple", 5, &key(3), &names));
    }
}
