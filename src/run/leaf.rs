//! `leafseason leaf`: traces a scan and writes what was found, for a scene to use or a person to paint over.

use super::stopwatch::{self, timed};
use super::{fault, files};
use crate::base::diagnostic::{Diagnostic, Diagnostics, Fault};
use crate::base::limits::{Limit, Limits};
use crate::base::message::shown;
use crate::base::picture::Picture;
use crate::export;
use crate::leaf::{self, LeafError, Truth};
use crate::report::Report;
use crate::scene::{self, Asset};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Memory for each pixel of a scan while it is traced, bytes (measured: 35).
pub(super) const TRACED_BYTES: f64 = 40.0;
/// Largest file of a truth, bytes.
const LARGEST_TRUTH: u64 = 64_000_000;

/// What is to be traced, and where to.
#[derive(Clone, Debug)]
pub struct Job {
    /// The scan.
    pub picture: PathBuf,
    /// The folder for what is found.
    pub out: PathBuf,
    /// A hand-traced outline and veins to compare with.
    pub truth: Option<PathBuf>,
    /// How the leaf is traced and meshed.
    pub settings: leaf::Settings,
    /// The limits in force.
    pub limits: Limits,
}

/// Traces the scan and writes `leaf.toml`, `mask.png`, `texture.png` and `preview.png`.
///
/// # Errors
/// The scan cannot be read or traced, the truth is wrong, a limit refuses it, or the folder cannot be written.
pub fn trace(job: &Job) -> Result<Report, Diagnostics> {
    let start = Instant::now();
    let asset = Asset::outside(&job.picture);
    let mut report = Report::begun(&shown(&asset.name, 200));
    let truth = job.truth.as_deref().map(read_truth).transpose()?;
    super::destination::folder(&job.out)?;
    let picture = scene::read_picture(&asset, &job.limits)?;
    let failed = |error: &LeafError| failure(&asset.name, error);
    allow(&picture, &job.limits).map_err(|refusal| failed(&LeafError::Refused(refusal)))?;
    if let (Some(truth), Some(path)) = (&truth, &job.truth) {
        truth.check(&picture).map_err(|what| truth_fault(path, &what))?;
    }
    let traced = timed(&mut report, "leaf", || leaf::traced(&job.settings, &picture, truth.as_ref(), &job.limits));
    let traced = traced.map_err(|error| failed(&error))?;
    let blade = &traced.blade;
    let preview = leaf::preview(&picture, &traced);
    let texture = blade.scan.as_ref().unwrap_or(&picture);
    let name = job.picture.file_name().unwrap_or_default().to_string_lossy();
    let encoded = |picture: &Picture| export::png(picture).map_err(|error| fault::export(&error));
    let files = [
        (leaf::MASK, encoded(&blade.mask)?),
        (leaf::TEXTURE, encoded(texture)?),
        ("preview.png", encoded(&preview)?),
        ("leaf.toml", leaf::file_text(&traced.settings, &name).into_bytes()),
    ];
    write(&job.out, &files)?;
    report.seconds = start.elapsed().as_secs_f64();
    report.peak_memory_bytes = stopwatch::peak_memory();
    Ok(report)
}

/// Asks for the memory that tracing takes.
pub(super) fn allow(picture: &Picture, limits: &Limits) -> Result<(), crate::base::limits::Refusal> {
    let wanted = f64::from(picture.width) * f64::from(picture.height) * TRACED_BYTES;
    limits.allow(Limit::Memory, "leaf.picture", wanted)
}

/// The pictures first and the text that names them last: whoever sees it finds them all.
fn write(out: &Path, files: &[(&str, Vec<u8>)]) -> Result<(), Diagnostics> {
    std::fs::create_dir_all(out).map_err(|error| {
        let what = format!("cannot make the folder {}: {error}", shown(&out.to_string_lossy(), 200));
        Diagnostic::error(Fault::Output, what, "name another folder with --out")
    })?;
    for (name, bytes) in files {
        files::write(&out.join(name), bytes).map_err(|error| fault::written(&error))?;
    }
    Ok(())
}

fn failure(name: &str, error: &LeafError) -> Diagnostics {
    let name = shown(name, 200);
    let diagnostic = match error {
        LeafError::Refused(refusal) => Diagnostic::error(Fault::Limit, refusal.to_string(), refusal.help()),
        LeafError::Mesh { what } => Diagnostic::error(
            Fault::Asset,
            format!("{name}: {what}"),
            "change leaf.vertices or leaf.tolerance_px with --set",
        ),
        error => {
            let help = "give a scan of one whole leaf on a plain background";
            Diagnostic::error(Fault::Asset, format!("{name}: {error}"), help)
        }
    };
    diagnostic.into()
}

fn read_truth(path: &Path) -> Result<Truth, Diagnostics> {
    let name = || shown(&path.to_string_lossy(), 200);
    let unreadable = |error: &dyn std::fmt::Display| {
        Diagnostic::error(Fault::Asset, format!("cannot read {}: {error}", name()), "name a file of JSON with --truth")
    };
    let file = std::fs::File::open(path).map_err(|error| unreadable(&error))?;
    let mut text = String::new();
    file.take(LARGEST_TRUTH).read_to_string(&mut text).map_err(|error| unreadable(&error))?;
    serde_json::from_str(&text).map_err(|error| truth_fault(path, &error.to_string()).into())
}

fn truth_fault(path: &Path, what: &str) -> Diagnostic {
    let help = "a truth has \"blade\" and maybe \"veins\", each a list of [x, y] in pixels of the scan";
    Diagnostic::error(Fault::Scene, format!("{}: {}", shown(&path.to_string_lossy(), 200), shown(what, 200)), help)
}
