//! The leaf stage: outline (given or traced from a scan) -> closed B-spline -> Delaunay -> even mesh; veins and mask.
//!
//! Sections 3 and 4.2 of Tang, Wu and Fan 2013. Where the paper asks a user, this decides: key points by an error bound in
//! pixels, the mask from veins, margin, tips and petiole. It does not bend the leaf, paint it, or read files.

mod contour;
mod field;
mod grid;
mod key_points;
pub mod mask;
mod outline;
mod polygon;
mod quality;
mod raster;
mod remesh;
mod ring;
mod scan;
mod segmentation;
mod spline;
mod trace;
mod triangulation;
pub mod veins;

use crate::base::blade::Blade;
use crate::base::figures::{ErrorFigure, Figures};
use crate::base::flat_mesh::{BLADE_UV_MARGIN, FlatMesh};
use crate::base::limits::{Limit, Limits, Refusal};
use crate::base::picture::Picture;
use crate::base::settings::Complaint;
use crate::base::vector::DVec2;
use crate::{choice, settings};
pub use mask::Mask;
use remesh::Remesh;
use spline::Spline;
use thiserror::Error;
pub use trace::{Pose, Trace};

choice! {
    /// How the main veins of a blade are laid out.
    pub enum Venation {
        /// Palmate if at least three lobes stand out from the joint, else pinnate.
        Auto = "auto",
        /// One midrib with secondaries, whatever the lobes: oaks, birch, beech.
        Pinnate = "pinnate",
        /// Equal veins that fork again and again from the joint, no midrib: ginkgo.
        Forking = "forking",
    }
}

settings! {
    /// The blade's shape and its mesh.
    pub struct Settings {
        /// Key points of the outline in order, the joint of the petiole at the origin, the tip towards +y.
        outline: Option<Vec<[f64; 2]>> = None, unit "mm", range -2000.0 => 2000.0;
        /// A scan from which outline and texture are taken; wins over `outline`.
        picture: Option<String> = None;
        /// A grey picture over the blade: white stays, black moves most. Derived from veins and margin when absent.
        mask: Option<String> = None;
        /// The law by which a mask is derived.
        mask_law: Mask = Mask::default();
        /// Length of the blade from the joint to the farthest tip, to which an outline or a scan is scaled.
        length: f64 = 75.0, unit "mm", range 1.0 => 2000.0;
        /// How the veins are laid out when they are drawn from the outline.
        venation: Venation = Venation::Auto;
        /// Vertices of the mesh.
        vertices: u32 = 220, range 12 => 20000;
        /// Most rounds of relocation and reconnection after triangulation; they end when the triangles have settled.
        iterations: u32 = 160, range 0 => 10000;
        /// Largest distance between a traced outline and the spline.
        tolerance: f64 = 1.5, unit "px", range 0.25 => 50.0;
        /// Key points at which the outline turns by more than this stay sharp; 180 keeps none.
        corner: f64 = 65.0, unit "degrees", range 0.0 => 180.0;
    }
}

/// The pictures that the settings name, already read.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pictures<'a> {
    /// The scan of `Settings::picture`.
    pub picture: Option<&'a Picture>,
    /// The mask of `Settings::mask`, laid out by the mesh's texture coordinates.
    pub mask: Option<&'a Picture>,
}

/// Why a leaf could not be made.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum LeafError {
    /// The scan cannot be traced.
    #[error("{what}")]
    Picture {
        /// What is wrong, and how to mend it.
        what: String,
    },
    /// The outline cannot be meshed.
    #[error("{what}")]
    Mesh {
        /// What is wrong.
        what: String,
    },
    /// There is neither a scan nor an outline.
    #[error("the leaf has neither an outline nor a picture")]
    Shapeless,
    /// The settings are at fault; [`check`] names every fault.
    #[error("leaf.{}: {}; {}", .0.key, .0.message, .0.help)]
    Settings(Complaint),
    /// A limit refused it.
    #[error(transparent)]
    Refused(#[from] Refusal),
}

impl LeafError {
    fn picture(what: &str) -> Self {
        Self::Picture { what: what.to_owned() }
    }
}

/// Everything wrong with well-typed settings. A clockwise outline is no fault.
#[must_use]
pub fn check(settings: &Settings) -> Vec<Complaint> {
    let outline = settings.outline.as_deref().filter(|_| settings.picture.is_none());
    outline.map(|points| outline::complaints(points, settings.corner.to_radians())).unwrap_or_default()
}

/// Traces a scan without meshing it: for a `leaf.toml` of key points and for comparison with a truth.
///
/// # Errors
/// [`LeafError`] when there is no leaf in the picture, or a limit refuses its size.
pub fn trace(settings: &Settings, picture: &Picture, limits: &Limits) -> Result<Trace, LeafError> {
    limits.allow(Limit::PicturePixels, "leaf.picture", f64::from(picture.width) * f64::from(picture.height))?;
    trace::traced(picture, settings.length * 1e-3, settings.tolerance, settings.corner.to_radians())
}

/// Makes the blade.
///
/// # Errors
/// [`LeafError`] when there is no outline, it is at fault, the scan cannot be traced, or a limit refuses it.
pub fn model(settings: &Settings, pictures: Pictures, limits: &Limits) -> Result<(Blade, Figures), LeafError> {
    limits.allow(Limit::Vertices, "leaf.vertices", f64::from(settings.vertices))?;
    let trace = pictures.picture.map(|picture| trace(settings, picture, limits)).transpose()?;
    let keys = keys(settings, trace.as_ref())?;
    let spline = Spline::through(&keys, settings.corner.to_radians());
    let outline = dense(&spline, settings.length * 1e-3);
    let mesh = remesh::evened(&outline, settings.vertices as usize, settings.iterations)?;
    let figures = figures(&mesh, &outline, keys.len(), trace.as_ref());
    let (veins, source) = veins::found(&outline, settings.venation, pictures.picture.zip(trace.as_ref()));
    let figures = figures.with("veins", source.word());
    let mut flat = laid_out(&mesh);
    let derived = pictures.mask.is_none().then(|| mask::drawn(&flat, &outline, &[], &veins, &settings.mask_law));
    flat.greys = match pictures.mask.or(derived.as_ref()) {
        Some(picture) => flat.uvs.iter().map(|uv| scan::grey_at(picture, *uv)).collect(),
        None => Vec::new(),
    };
    let scan = match (pictures.picture, &trace) {
        (Some(picture), Some(trace)) => Some(scan::laid_out(picture, trace, &flat)),
        _ => None,
    };
    Ok((Blade { mesh: flat, outline, veins, scan }, figures))
}

/// Key points in metres, counter-clockwise, the joint first.
fn keys(settings: &Settings, trace: Option<&Trace>) -> Result<Vec<DVec2>, LeafError> {
    let length = settings.length * 1e-3;
    if let Some(trace) = trace {
        let points: Vec<[f64; 2]> = trace.keys.iter().map(|&p| trace.pose.plane(p).into()).collect();
        return Ok(outline::cleaned(&points, length));
    }
    if let Some(complaint) = check(settings).into_iter().next() {
        return Err(LeafError::Settings(complaint));
    }
    let points = settings.outline.as_deref().ok_or(LeafError::Shapeless)?;
    Ok(outline::cleaned(points, length))
}

/// The spline as a polygon no coarser than a four-hundredth of the blade.
fn dense(spline: &Spline, length: f64) -> Vec<DVec2> {
    let spacing = length / 400.0;
    let span = |i: usize| {
        let rough: f64 =
            (0..8).map(|k| (spline.at(i, f64::from(k + 1) / 8.0) - spline.at(i, f64::from(k) / 8.0)).norm()).sum();
        let count = ((rough / spacing).ceil() as usize).max(4);
        (0..count).map(move |k| (i, k as f64 / count as f64))
    };
    (0..spline.spans()).flat_map(span).map(|(i, t)| spline.at(i, t)).collect()
}

/// The mesh by the contract of [`FlatMesh`]; greys are left out.
fn laid_out(mesh: &Remesh) -> FlatMesh {
    let rim = &mesh.points[..mesh.rim];
    let low = rim.iter().fold(rim[0], |low, p| low.inf(p));
    let high = rim.iter().fold(rim[0], |high, p| high.sup(p));
    let (middle, size) = ((low + high) * 0.5, (high - low).max());
    let uv_scale = (1.0 - 2.0 * BLADE_UV_MARGIN) / size;
    let uv_origin = DVec2::new(0.5 - uv_scale * middle.x, 0.5 + uv_scale * middle.y);
    let mut flat = FlatMesh {
        positions: mesh.points.clone(),
        triangles: mesh.topology.triangles.clone(),
        rim: (0..mesh.rim as u32).collect(),
        held: held(mesh),
        uv_scale,
        uv_origin,
        ..FlatMesh::default()
    };
    flat.uvs = flat.positions.iter().map(|&p| flat.uv(p)).collect();
    flat
}

/// The vertex nearest the joint and those joined to it: enough to hold the blade's direction.
fn held(mesh: &Remesh) -> Vec<u32> {
    let distance = |&v: &usize| mesh.points[v].norm();
    let joint = (0..mesh.points.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0) as u32;
    let beside = mesh.topology.edges.iter().filter_map(|&[a, b]| match joint {
        v if v == a => Some(b),
        v if v == b => Some(a),
        _ => None,
    });
    let mut held: Vec<u32> = beside.chain([joint]).collect();
    held.sort_unstable();
    held
}

fn figures(mesh: &Remesh, outline: &[DVec2], keys: usize, trace: Option<&Trace>) -> Figures {
    let rim = &mesh.points[..mesh.rim];
    let reached = polygon::hausdorff(rim, outline);
    let quality = mesh.quality;
    let mut figures = Figures::of(1)
        .with("vertices", mesh.points.len())
        .with("triangles", mesh.topology.triangles.len())
        .with("min_angle_deg", quality.min_angle.to_degrees())
        .with("excused_triangles", quality.excused)
        .with("edge_cv", quality.edge_cv)
        .with("q_mean", quality.q_mean)
        .with("q_p05", quality.q_p05)
        .with("key_points", keys)
        .with("rounds", mesh.rounds)
        .with("area_error", polygon::doubled_area(rim) / polygon::doubled_area(outline) - 1.0);
    if let Some(trace) = trace {
        let plane: Vec<DVec2> = trace.outline.iter().map(|&p| trace.pose.plane(p)).collect();
        let pixels = polygon::hausdorff(rim, &plane) / trace.pose.scale;
        figures = figures.with("outline_hausdorff_px", trace.hausdorff).with("boundary_hausdorff_px", pixels);
    }
    figures.error = Some(ErrorFigure {
        metric: "Hausdorff distance of the mesh's rim from the outline".to_owned(),
        value: reached * 1e3,
        unit: "mm".to_owned(),
        bound: None,
        how: "measured both ways at the corners and three points of each side".to_owned(),
    });
    figures
}

#[cfg(test)]
mod tests;
