//! The collecting step of a distributed render: is every frame of the folder there, whole, and of one scene and build?

use super::manifest::{FileFault, Key, Manifest, SUFFIX};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;
use std::path::Path;
use thiserror::Error;

/// Something wrong with a folder of frames.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum Fault {
    /// A file of a frame, or a manifest, is not as it was written.
    #[error("{name} {fault}")]
    File {
        /// Its name.
        name: String,
        /// What is wrong.
        fault: FileFault,
    },
    /// Frames without a manifest.
    #[error("{}", missing_text(.scene, *.first, *.last))]
    Missing {
        /// NAME of the scene.
        scene: String,
        /// First of them.
        first: u64,
        /// Last of them.
        last: u64,
    },
    /// A manifest has the name of another frame.
    #[error("{name} is the manifest of frame {frame}, whose name would be {wanted}")]
    Misnamed {
        /// Its name.
        name: String,
        /// The frame it tells of.
        frame: i64,
        /// The name of that frame's manifest.
        wanted: String,
    },
    /// Frames of one name are from different scenes, lengths or builds of the program.
    #[error("{scene}: frame {frame} was drawn from another scene or by another build than frame {other}")]
    Mixed {
        /// NAME of the scene.
        scene: String,
        /// The first frame that differs.
        frame: i64,
        /// The frame it differs from.
        other: i64,
    },
    /// There is no manifest at all.
    #[error("there is no manifest in this folder, so nothing can be verified")]
    Empty,
}

/// What was looked at and what is wrong with it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Verification {
    /// Frames with a manifest.
    pub frames: u64,
    /// Files whose content was read.
    pub files: u64,
    /// All faults, in order of names.
    pub faults: Vec<Fault>,
}

/// Verifies every frame of a folder by its manifests.
///
/// # Errors
/// When the folder cannot be listed.
pub fn verify(folder: &Path) -> io::Result<Verification> {
    let mut found = Verification::default();
    let mut scenes: BTreeMap<String, Vec<Manifest>> = BTreeMap::new();
    for name in manifest_names(folder)? {
        match Manifest::read(&folder.join(&name)) {
            Ok(manifest) => {
                found.look_at(folder, &name, &manifest);
                scenes.entry(manifest.name.clone()).or_default().push(manifest);
            }
            Err(fault) => found.faults.push(Fault::File { name, fault }),
        }
    }
    if found.frames == 0 && found.faults.is_empty() {
        found.faults.push(Fault::Empty);
    }
    for (scene, manifests) in &scenes {
        found.faults.extend(mixed(scene, manifests));
        found.faults.extend(missing(scene, manifests));
    }
    Ok(found)
}

impl Verification {
    fn look_at(&mut self, folder: &Path, name: &str, manifest: &Manifest) {
        self.frames += 1;
        self.files += manifest.files.len() as u64;
        let wanted = Manifest::file_name(&manifest.name, manifest.key.frame, manifest.frames);
        if name != wanted {
            self.faults.push(Fault::Misnamed { name: name.to_owned(), frame: manifest.key.frame, wanted });
        }
        let faults = manifest.faults(folder).into_iter().map(|(name, fault)| Fault::File { name, fault });
        self.faults.extend(faults);
    }
}

/// Names of all manifests, sorted. Names that are not UTF-8 cannot be ours, except by a scene of such a name.
fn manifest_names(folder: &Path) -> io::Result<Vec<String>> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder)? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        if name.ends_with(SUFFIX) {
            names.push(name);
        }
    }
    names.sort();
    Ok(names)
}

fn mixed(scene: &str, manifests: &[Manifest]) -> Option<Fault> {
    let origin = |manifest: &Manifest| {
        let Key { build, scene, .. } = manifest.key.clone();
        (build, scene, manifest.frames)
    };
    let first = manifests.first()?;
    let odd = manifests.iter().find(|manifest| origin(manifest) != origin(first))?;
    Some(Fault::Mixed { scene: scene.to_owned(), frame: odd.key.frame, other: first.key.frame })
}

/// Stretches of frames that have no manifest. Frame counts are read from a file and may be anything, so gaps are found
/// between the frames that are there and never counted out.
fn missing(scene: &str, manifests: &[Manifest]) -> Vec<Fault> {
    let count = manifests.iter().map(|manifest| manifest.frames).max().unwrap_or(0);
    let present = manifests.iter().filter_map(|manifest| u64::try_from(manifest.key.frame).ok());
    let present: BTreeSet<u64> = present.filter(|&frame| frame < count).collect();
    let mut gaps = Vec::new();
    let mut next = 0;
    for frame in present.into_iter().chain([count]) {
        if frame > next {
            gaps.push(Fault::Missing { scene: scene.to_owned(), first: next, last: frame - 1 });
        }
        next = frame.saturating_add(1);
    }
    gaps
}

fn missing_text(scene: &str, first: u64, last: u64) -> String {
    if first == last {
        format!("{scene}: frame {first} is missing; draw it with --frames {first}")
    } else {
        format!("{scene}: frames {first} to {last} are missing; draw them with --frames {first}-{last}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::files;
    use tempfile::tempdir;

    fn put(folder: &Path, frame: i64, frames: u64, scene: &str) {
        let name = format!("{}.png", files::stem("maple", frame, frames));
        let bytes = name.clone().into_bytes();
        files::write(&folder.join(&name), &bytes).unwrap();
        let key = Key { build: "b".to_owned(), scene: scene.to_owned(), frame };
        Manifest::new("maple", frames, key, &[(name, &bytes)]).write(folder).unwrap();
    }

    #[test]
    fn a_whole_folder_has_no_faults() {
        let folder = tempdir().unwrap();
        (-2..4).for_each(|frame| put(folder.path(), frame, 4, "s"));
        assert_eq!(verify(folder.path()).unwrap(), Verification { frames: 6, files: 6, faults: Vec::new() });
        let single = tempdir().unwrap();
        put(single.path(), 0, 1, "s");
        assert_eq!(verify(single.path()).unwrap().faults, []);
    }

    #[test]
    fn gaps_are_named_as_ranges() {
        let folder = tempdir().unwrap();
        [2, 3, 5].into_iter().for_each(|frame| put(folder.path(), frame, 1_000_000_000_000, "s"));
        let gap = |first, last| Fault::Missing { scene: "maple".to_owned(), first, last };
        assert_eq!(verify(folder.path()).unwrap().faults, [gap(0, 1), gap(4, 4), gap(6, 999_999_999_999)]);
        assert!(gap(4, 4).to_string().ends_with("--frames 4"));
    }

    #[test]
    fn damage_mixtures_and_wrong_names_are_found() {
        let folder = tempdir().unwrap();
        (0..3).for_each(|frame| put(folder.path(), frame, 3, if frame == 2 { "t" } else { "s" }));
        fs::write(folder.path().join("maple.0001.png"), b"cut").unwrap();
        fs::copy(folder.path().join("maple.0000.manifest.json"), folder.path().join("oak.manifest.json")).unwrap();
        fs::write(folder.path().join("zelkova.manifest.json"), b"{}").unwrap();
        let faults = verify(folder.path()).unwrap().faults;
        let damaged = Fault::File { name: "maple.0001.png".to_owned(), fault: FileFault::Damaged };
        assert_eq!(faults.len(), 4, "{faults:?}");
        assert_eq!(faults[0], damaged);
        assert!(matches!(&faults[1], Fault::Misnamed { name, frame: 0, .. } if name == "oak.manifest.json"));
        assert!(matches!(&faults[2], Fault::File { fault: FileFault::NotAManifest(_), .. }));
        assert!(matches!(&faults[3], Fault::Mixed { frame: 2, other: 0, .. }));
    }

    #[test]
    fn an_empty_folder_is_a_fault_and_a_missing_one_an_error() {
        let folder = tempdir().unwrap();
        assert_eq!(verify(folder.path()).unwrap().faults, [Fault::Empty]);
        assert!(verify(&folder.path().join("none")).is_err());
    }
}
