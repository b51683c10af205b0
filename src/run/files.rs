//! The one way to write a file: whole or not at all. A hidden temporary in the same folder is written, synced and renamed,
//! and the folder synced; whoever sees the final name sees the whole content, also after a power cut.

use std::ffi::OsStr;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, SystemTime};
use thiserror::Error;

/// Temporaries of machines that cannot be asked are taken for leftovers after this time; writing one takes seconds.
const FOREIGN_AGE: Duration = Duration::from_secs(24 * 60 * 60);

/// Why a file could not be written. Retrying may help: the exit code is that of outputs.
#[derive(Debug, Error)]
pub enum WriteError {
    /// A folder has the file's name.
    #[error("cannot write {}: a folder of that name is in the way", .path.display())]
    FolderInTheWay {
        /// The path.
        path: PathBuf,
    },
    /// The path does not end in a file name.
    #[error("cannot write {}: it does not name a file", .path.display())]
    NoName {
        /// The path.
        path: PathBuf,
    },
    /// The folder is not there.
    #[error("cannot write {}: its folder is not there", .path.display())]
    NoFolder {
        /// The path.
        path: PathBuf,
    },
    /// The system refused.
    #[error("cannot write {}: {source}", .path.display())]
    System {
        /// The path of the file that was to be written.
        path: PathBuf,
        /// Its reason.
        source: io::Error,
    },
}

/// Writes a file whole. A link at the final name is replaced, not followed; a device or a pipe that stands there is written
/// to, never replaced.
///
/// # Errors
/// [`WriteError`]; the temporary is removed and the final name is as it was.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    check(path)?;
    let folder = folder_of(path);
    let failed = |source| WriteError::System { path: path.to_owned(), source };
    if fs::symlink_metadata(path).is_ok_and(|found| !found.is_file() && !found.is_symlink()) {
        let device = OpenOptions::new().write(true).open(path);
        return device.and_then(|mut device| device.write_all(bytes)).map_err(failed);
    }
    let (temporary, file) = open_temporary(folder).map_err(failed)?;
    let written = fill(file, bytes).and_then(|()| fs::rename(&temporary, path));
    if let Err(source) = written {
        // Nothing more can be done if this fails too; the next run cleans up.
        let _ = fs::remove_file(&temporary);
        return Err(failed(source));
    }
    sync_folder(folder).map_err(failed)
}

/// Whether a file could be written there, as far as that can be told without writing: worth asking before hours of work.
///
/// # Errors
/// [`WriteError`] as from [`write()`].
pub fn check(path: &Path) -> Result<(), WriteError> {
    let own = || path.to_owned();
    if path.file_name().is_none() {
        return Err(WriteError::NoName { path: own() });
    }
    if fs::symlink_metadata(path).is_ok_and(|found| found.is_dir()) {
        return Err(WriteError::FolderInTheWay { path: own() });
    }
    if folder_of(path).is_dir() { Ok(()) } else { Err(WriteError::NoFolder { path: own() }) }
}

/// Removes the temporaries of processes that no longer run. Those of living processes stay, also this one's; those of
/// another machine or container on a shared disk stay for a day, since its processes cannot be seen from here. What cannot
/// be read or removed is left for another time. Returns how many were removed.
pub fn clean(folder: &Path) -> usize {
    let Ok(entries) = fs::read_dir(folder) else { return 0 };
    let leftover = |entry: &fs::DirEntry| {
        let owner = Owner::parse(&entry.file_name());
        owner.is_some_and(|owner| owner.is_gone(entry)) && entry.file_type().is_ok_and(|kind| kind.is_file())
    };
    entries.flatten().filter(leftover).filter(|entry| fs::remove_file(entry.path()).is_ok()).count()
}

/// The name of an output without its extension: `NAME` for the only frame of a scene, else `NAME.0000`; a frame before the
/// start is `NAME.-0003`.
#[must_use]
pub fn stem(name: &str, frame: i64, frames: u64) -> String {
    match (frames, frame) {
        (1, 0) => name.to_owned(),
        (_, frame) if frame < 0 => format!("{name}.-{:04}", frame.unsigned_abs()),
        (_, frame) => format!("{name}.{frame:04}"),
    }
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

fn open_temporary(folder: &Path) -> io::Result<(PathBuf, File)> {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let owner = Owner::this_process();
    loop {
        let path = folder.join(owner.file_name(COUNT.fetch_add(1, Ordering::Relaxed)));
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Ok(file) => return Ok((path, file)),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
}

fn fill(mut file: File, bytes: &[u8]) -> io::Result<()> {
    file.write_all(bytes)?;
    file.sync_all()
}

#[cfg(unix)]
fn sync_folder(folder: &Path) -> io::Result<()> {
    match File::open(folder)?.sync_all() {
        // Some network and user-space file systems cannot sync a folder; the file itself is safe by then.
        Err(error) if matches!(error.kind(), io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported) => Ok(()),
        result => result,
    }
}

#[cfg(not(unix))]
fn sync_folder(_: &Path) -> io::Result<()> {
    Ok(())
}

/// Whose temporary it is: the machine (or container), the process and the moment it started, since numbers of processes
/// are used again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Owner {
    machine: u64,
    process: u32,
    start: u64,
}

const PREFIX: &str = ".leafseason-";
const SUFFIX: &str = ".tmp";

impl Owner {
    fn this_process() -> Self {
        let process = std::process::id();
        Self { machine: machine(), process, start: start_of(process).unwrap_or(0) }
    }

    fn file_name(self, number: u64) -> String {
        format!("{PREFIX}{:016x}-{}-{}-{number}{SUFFIX}", self.machine, self.process, self.start)
    }

    fn parse(file_name: &OsStr) -> Option<Self> {
        let middle = file_name.to_str()?.strip_prefix(PREFIX)?.strip_suffix(SUFFIX)?;
        let mut parts = middle.split('-');
        let machine = u64::from_str_radix(parts.next()?, 16).ok()?;
        let (process, start) = (parts.next()?.parse().ok()?, parts.next()?.parse().ok()?);
        parts.next()?.parse::<u64>().ok()?;
        parts.next().is_none().then_some(Self { machine, process, start })
    }

    fn is_gone(self, entry: &fs::DirEntry) -> bool {
        if self == Self::this_process() {
            return false;
        }
        if self.machine == machine() && Path::new("/proc/self/stat").exists() {
            return start_of(self.process) != Some(self.start);
        }
        let written = entry.metadata().and_then(|found| found.modified());
        written.is_ok_and(|then| SystemTime::now().duration_since(then).is_ok_and(|age| age > FOREIGN_AGE))
    }
}

/// Tells apart machines, boots and containers, within which the numbers of processes have a meaning.
fn machine() -> u64 {
    use sha2::{Digest, Sha256};
    let boot = fs::read("/proc/sys/kernel/random/boot_id").unwrap_or_default();
    let container = fs::read_link("/proc/self/ns/pid").unwrap_or_default();
    let hash = Sha256::new().chain_update(boot).chain_update(container.as_os_str().as_encoded_bytes()).finalize();
    hash.iter().take(8).fold(0, |sum, &byte| sum << 8 | u64::from(byte))
}

/// When a process started, in clock ticks since boot (field 22 of /proc/PID/stat; the name before it may hold anything,
/// brackets too). `None` when it does not run; a zombie no longer writes and counts as gone.
fn start_of(process: u32) -> Option<u64> {
    let text = fs::read(format!("/proc/{process}/stat")).ok()?;
    let text = String::from_utf8_lossy(&text);
    let mut fields = text.rsplit_once(')')?.1.split_whitespace();
    let state = fields.next()?;
    if state == "Z" { None } else { fields.nth(18)?.parse().ok() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tempfile::tempdir;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[cfg(unix)]
    #[test]
    fn what_is_no_file_is_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("socket");
        let _socket = std::os::unix::net::UnixListener::bind(&path).unwrap();
        assert!(write(&path, b"gone").is_err(), "a socket cannot be opened for writing");
        assert!(!fs::symlink_metadata(&path).unwrap().is_file());
    }

    #[test]
    fn a_file_is_written_and_replaced_and_nothing_else_stays() {
        let folder = tempdir().unwrap();
        let path = folder.path().join("a.png");
        write(&path, b"one").unwrap();
        write(&path, b"two").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"two");
        assert_eq!(names(folder.path()), ["a.png"]);
    }

    #[test]
    fn a_folder_in_the_way_is_named_and_left_alone() {
        let folder = tempdir().unwrap();
        let path = folder.path().join("a.png");
        fs::create_dir(&path).unwrap();
        let error = write(&path, b"one").unwrap_err();
        assert!(matches!(error, WriteError::FolderInTheWay { .. }) && error.to_string().contains("a.png"));
        assert_eq!(names(folder.path()), ["a.png"]);
    }

    #[test]
    fn a_missing_folder_is_an_error_that_names_the_file() {
        let folder = tempdir().unwrap();
        let error = write(&folder.path().join("none/a.png"), b"one").unwrap_err();
        assert!(matches!(error, WriteError::NoFolder { .. }) && error.to_string().contains("none/a.png"));
        assert!(matches!(write(Path::new("/"), b""), Err(WriteError::NoName { .. })));
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_replaced_and_what_it_names_is_kept() {
        let folder = tempdir().unwrap();
        let (precious, link) = (folder.path().join("precious"), folder.path().join("a.png"));
        fs::write(&precious, b"precious").unwrap();
        std::os::unix::fs::symlink(&precious, &link).unwrap();
        write(&link, b"one").unwrap();
        assert_eq!(fs::read(&precious).unwrap(), b"precious");
        assert!(fs::symlink_metadata(&link).unwrap().is_file());
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn leftovers_of_the_dead_go_and_those_of_the_living_stay() {
        let folder = tempdir().unwrap();
        let mut child = std::process::Command::new("sleep").arg("60").spawn().unwrap();
        let living = Owner { process: child.id(), start: start_of(child.id()).unwrap(), ..Owner::this_process() };
        let own = Owner::this_process();
        // The same number, but the process that had it started earlier.
        let reused = Owner { start: living.start - 1, ..living };
        let dead = Owner { process: u32::MAX, start: 5, ..own };
        let elsewhere = Owner { machine: !own.machine, ..dead };
        for owner in [living, own, reused, dead, elsewhere] {
            fs::write(folder.path().join(owner.file_name(0)), b"x").unwrap();
        }
        fs::write(folder.path().join(".leafseason-mine.tmp"), b"x").unwrap();
        assert_eq!(clean(folder.path()), 2);
        let mut kept = [living, own, elsewhere].map(|owner| owner.file_name(0)).to_vec();
        kept.push(".leafseason-mine.tmp".to_owned());
        kept.sort();
        assert_eq!(names(folder.path()), kept);
        child.kill().unwrap();
        child.wait().unwrap();
        assert_eq!(clean(folder.path()), 1);
    }

    #[test]
    fn the_frame_count_decides_the_form_of_names() {
        assert_eq!(stem("maple", 0, 1), "maple");
        assert_eq!(stem("maple", 0, 2), "maple.0000");
        assert_eq!(stem("maple", 12_345, 20_000), "maple.12345");
        assert_eq!(stem("maple", -3, 10), "maple.-0003");
        assert_eq!(stem("maple", -3, 1), "maple.-0003");
    }
}
