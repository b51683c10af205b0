//! The leaf stage: outline (given or traced from a scan) -> closed B-spline -> Delaunay -> even mesh; veins and mask.
//!
//! ```text
//! scan ─segmentation→ blade's pixels ─trace→ outline, key points, gaps, petiole, pose ─┐
//! key points of the scene ─outline→ checked and cleaned ──────────────────────────────┴─spline→ curves ─remesh→ mesh
//! scan, or outline alone ─veins→ veins;   outline, veins, mesh ─mask→ mask map;   all of it ─show→ texture, charts, preview
//! ```
//!
//! Sections 3 and 4.2 of Tang, Wu and Fan 2013. Where the paper asks a user, this decides: key points by an error bound in
//! pixels, the mask from veins, margin, tips and petiole. It does not bend the leaf, paint it, or read files.

mod check;
mod field;
mod file;
mod fringe;
mod grid;
mod mask;
mod outline;
mod polygon;
mod raster;
mod remesh;
mod segmentation;
mod settings;
mod show;
mod spline;
mod strip;
mod teeth;
mod trace;
mod truth;
mod veins;

use crate::base::blade::{Blade, Vein};
use crate::base::figures::{ErrorFigure, Figures};
use crate::base::flat_mesh::{BLADE_UV_MARGIN, FlatMesh};
use crate::base::limits::{Limit, Limits, Refusal};
use crate::base::picture::Picture;
use crate::base::settings::Complaint;
use crate::base::vector::DVec2;
pub use check::check;
pub use file::{MASK, TEXTURE, text as file_text};
pub use fringe::Fringe;
pub use mask::Mask;
use remesh::Remesh;
pub use segmentation::petiole::Petiole;
pub use settings::{Meshing, Settings, VeinLine, Venation};
pub use show::chart::Chart;
use spline::Spline;
pub use teeth::Teeth;
use thiserror::Error;
pub use trace::{Pose, Trace};
pub use truth::Truth;

/// The steps of the stage one by one: for benches and studies.
pub mod steps {
    pub use super::remesh::{Remesh, evened};
    pub use super::segmentation::{Segment, segmented};
    pub use super::spline::Spline;
    pub use super::trace::contour::outlined;
    pub use super::trace::key_points::{chosen, spline};
    pub use super::veins::scanned;
    pub use super::veins::score::{Agreement, agreement, distance_correlation};
}

/// The pictures that the settings name, already read.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pictures<'a> {
    /// The scan of `Settings::picture`.
    pub picture: Option<&'a Picture>,
    /// The mask of `Settings::mask`, laid out by the mesh's texture coordinates.
    pub mask: Option<&'a Picture>,
    /// The blade's upper side of `Settings::texture`, laid out likewise.
    pub texture: Option<&'a Picture>,
}

/// A scan that was traced, with the blade made of it.
#[derive(Clone, Debug)]
pub struct Traced {
    /// The settings with the outline, gaps and petiole that were found: what a file of the leaf holds.
    pub settings: Settings,
    /// What was found in the picture.
    pub trace: Trace,
    /// The blade.
    pub blade: Blade,
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

/// Traces a scan without meshing it.
///
/// # Errors
/// [`LeafError`] when there is no leaf in the picture, or a limit refuses its size.
pub fn trace(settings: &Settings, picture: &Picture, limits: &Limits) -> Result<Trace, LeafError> {
    limits.allow(Limit::PicturePixels, "leaf.picture", f64::from(picture.width) * f64::from(picture.height))?;
    let joint = settings.joint.map(DVec2::from);
    trace::traced(picture, (settings.length * 1e-3, joint), settings.tolerance_px, settings.corner.to_radians())
}

/// Traces a scan and makes the blade, with everything that is worth a file. A truth adds its figures.
///
/// # Errors
/// [`LeafError`] as of [`model`].
pub fn traced(
    settings: &Settings,
    picture: &Picture,
    truth: Option<&Truth>,
    limits: &Limits,
) -> Result<(Traced, Figures), LeafError> {
    limits.allow(Limit::Vertices, "leaf.vertices", f64::from(settings.vertices))?;
    let trace = trace(settings, picture, limits)?;
    let settings = outlined(settings, picture, &trace);
    let pictures = Pictures { picture: Some(picture), ..Pictures::default() };
    let (blade, mut figures) = blade(&settings, pictures, Some(&trace))?;
    if let Some(truth) = truth {
        figures = truth.compared(&trace, &blade, figures);
    }
    let settings = Settings { mask: Some(MASK.to_owned()), texture: Some(TEXTURE.to_owned()), ..settings };
    Ok((Traced { settings, trace, blade }, figures))
}

/// Makes the blade.
///
/// # Errors
/// [`LeafError`] when there is no outline, it is at fault, the scan cannot be traced, or a limit refuses it.
pub fn model(settings: &Settings, pictures: Pictures, limits: &Limits) -> Result<(Blade, Figures), LeafError> {
    limits.allow(Limit::Vertices, "leaf.vertices", f64::from(settings.vertices))?;
    match pictures.picture {
        Some(picture) => {
            let trace = trace(settings, picture, limits)?;
            blade(&outlined(settings, picture, &trace), pictures, Some(&trace))
        }
        None => blade(settings, pictures, None),
    }
}

/// A picture of a blade by its texture coordinates.
#[must_use]
pub fn chart(chart: Chart, blade: &Blade) -> Picture {
    show::chart::drawn(chart, blade)
}

/// What was made of a scan, side by side.
#[must_use]
pub fn preview(picture: &Picture, traced: &Traced) -> Picture {
    show::preview::drawn(picture, &traced.trace, &traced.blade)
}

/// What a trace leaves for the person to know.
fn notes(trace: &Trace) -> Option<String> {
    let leaves = match trace.others {
        0 => return None,
        1 => "another leaf lies".to_owned(),
        others => format!("{others} other leaves lie"),
    };
    Some(format!("{leaves} on the sheet of leaf.picture; the largest was taken"))
}

/// Settings with what was found in the picture in its place, rounded as in a file.
fn outlined(settings: &Settings, picture: &Picture, trace: &Trace) -> Settings {
    let millimetres = |p: DVec2| -> [f64; 2] { (p * 1e3).map(file::rounded).into() };
    let plane = |p: DVec2| millimetres(trace.pose.plane(p));
    let line = |points: &Vec<DVec2>| points.iter().map(|&p| plane(p)).collect::<Vec<_>>();
    let stalk = trace.petiole.iter().flat_map(|petiole| petiole.line.iter().zip(&petiole.widths));
    let width = |width: f64| file::rounded(width * trace.pose.scale * 1e3);
    let station = |(&p, &w): (&DVec2, &f64)| {
        let [x, y] = plane(p);
        [x, y, width(w)]
    };
    let vein = |vein: Vein| VeinLine {
        order: u32::from(vein.order),
        points: vein.points.into_iter().map(millimetres).collect(),
        width: file::rounded(vein.width * 1e3),
        end_width: file::rounded(vein.end_width * 1e3),
    };
    let veins = if settings.veins.is_empty() {
        veins::scanned(picture, trace).0.into_iter().map(vein).collect()
    } else {
        settings.veins.clone()
    };
    Settings {
        picture: None,
        veins,
        outline: Some(line(&trace.keys)),
        // A trace has its teeth already.
        teeth: Teeth::default(),
        holes: trace.hole_keys.iter().map(line).collect(),
        petiole: stalk.map(station).collect(),
        joint: Some(trace.pose.joint.into()),
        ..settings.clone()
    }
}

/// Makes the blade of an outline; a trace adds what only its picture knows.
fn blade(settings: &Settings, pictures: Pictures, trace: Option<&Trace>) -> Result<(Blade, Figures), LeafError> {
    if let Some(complaint) = check(settings).into_iter().next() {
        let what = || format!("what was traced cannot be used: leaf.{}: {}", complaint.key, complaint.message);
        return Err(trace.map_or(LeafError::Settings(complaint.clone()), |_| LeafError::Picture { what: what() }));
    }
    let mut shape = Shape::of(settings)?;
    let outlines: Vec<Vec<DVec2>> = shape.loops.iter().map(|spline| dense(spline, settings.length * 1e-3)).collect();
    let vertices = settings.vertices as usize;
    let mesh = match settings.meshing {
        Meshing::Even => remesh::sized(&shape.loops, vertices, settings.iterations, joint_sizing(settings))?,
        Meshing::Delaunay => remesh::bare(&shape.loops, vertices)?,
    };
    let mut figures = figures(&mesh, &outlines, shape.keys.len(), trace);
    let mut flat = laid_out(&mesh, &outlines, settings.length * 1e-3);
    let scanned = pictures.picture.zip(trace);
    let (veins, source) = match (shape.veins.is_empty(), trace.is_some()) {
        (true, true) => (veins::grown(&outlines[0], settings.venation), "outline, none seen in the scan"),
        (true, false) => (veins::grown(&outlines[0], settings.venation), "outline"),
        (false, true) => (std::mem::take(&mut shape.veins), "scan"),
        (false, false) => (std::mem::take(&mut shape.veins), "given"),
    };
    figures = figures.with("veins", source);
    let mask = match pictures.mask {
        Some(picture) => picture.clone(),
        None => {
            let holes: Vec<&[DVec2]> = outlines[1..].iter().map(Vec::as_slice).collect();
            mask::drawn(&flat, &outlines[0], &holes, &veins, &settings.mask_law)
        }
    };
    flat.greys = flat.uvs.iter().map(|uv| show::texture::grey_at(&mask, *uv)).collect();
    let scan = match (pictures.texture, scanned) {
        (Some(texture), _) if texture.pixels.iter().all(|pixel| pixel[3] < 128) => {
            let complaint = Complaint::new("texture", "this picture is clear everywhere", "give it the leaf's colours");
            return Err(LeafError::Settings(complaint));
        }
        (Some(texture), _) => Some(show::texture::read_back(texture)),
        (None, scanned) => scanned.map(|(picture, trace)| show::texture::laid_out(picture, trace, &flat)),
    };
    let mut outlines = outlines.into_iter();
    let plain = outlines.next().unwrap_or_default();
    // Veins, mask and mesh are those of the key points: what bends does not know of small teeth.
    let outline = shape.margin.as_ref().map_or(plain, |margin| dense(margin, settings.length * 1e-3));
    let Shape { petiole, keys, .. } = shape;
    let petiole = strip::strip(&petiole);
    if let Some(strip) = &petiole {
        figures = figures.with("petiole_mm", strip::length(strip) * 1e3);
    }
    let blade = Blade { mesh: flat, outline, holes: outlines.collect(), keys, veins, mask, petiole, scan };
    Ok((blade, figures))
}

/// A blade's lines in metres, the joint at the origin.
struct Shape {
    /// The outline, counter-clockwise, then the gaps, clockwise.
    loops: Vec<Spline>,
    /// The key points of all of them.
    keys: Vec<DVec2>,
    /// The petiole's centre line with its widths.
    petiole: Vec<(DVec2, f64)>,
    /// The veins, when they are known.
    veins: Vec<Vein>,
    /// The outline with its teeth, when they are more than its key points.
    margin: Option<Spline>,
}

impl Shape {
    fn of(settings: &Settings) -> Result<Self, LeafError> {
        let points = settings.outline.as_deref().ok_or(LeafError::Shapeless)?;
        let corner = settings.corner.to_radians();
        let length = settings.length * 1e-3;
        let scale = outline::scale(points, length);
        let mut lines = vec![outline::cleaned(points, length)];
        lines.extend(settings.holes.iter().map(|hole| outline::cleaned_hole(hole, scale)));
        let stalk = |&[x, y, width]: &[f64; 3]| (DVec2::new(x, y) * scale, width * scale);
        let vein = |vein: &VeinLine| Vein {
            points: vein.points.iter().map(|&p| DVec2::from(p) * scale).collect(),
            width: vein.width * scale,
            end_width: vein.end_width * scale,
            order: vein.order as u8,
        };
        Ok(Self {
            margin: teeth::margin(&lines[0], corner, &settings.teeth),
            veins: settings.veins.iter().filter(|vein| vein.points.len() > 1).map(vein).collect(),
            petiole: settings.petiole.iter().map(stalk).collect(),
            loops: lines.iter().map(|keys| Spline::through(keys, corner)).collect(),
            keys: lines.concat(),
        })
    }
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

/// The mesh by the contract of [`FlatMesh`], of outlines without small teeth; greys are left out. Texture coordinates are laid
/// out by the outline, which hardly depends on the mesh: vertices that are set off from it reach a little beyond.
fn laid_out(mesh: &Remesh, outlines: &[Vec<DVec2>], length: f64) -> FlatMesh {
    let rim = &mesh.points[mesh.loops[0].clone()];
    let low = outlines[0].iter().chain(rim).fold(rim[0], |low, p| low.inf(p));
    let high = outlines[0].iter().chain(rim).fold(rim[0], |high, p| high.sup(p));
    let (middle, size) = ((low + high) * 0.5, (high - low).max());
    let uv_scale = (1.0 - 2.0 * BLADE_UV_MARGIN) / size;
    let uv_origin = DVec2::new(0.5 - uv_scale * middle.x, 0.5 + uv_scale * middle.y);
    let mut flat = FlatMesh {
        positions: mesh.points.clone(),
        triangles: mesh.topology.triangles.clone(),
        rim: (0..mesh.loops[0].end as u32).collect(),
        lines: outlines.to_vec(),
        held: held(mesh, length),
        uv_scale,
        uv_origin,
        ..FlatMesh::default()
    };
    flat.uvs = flat.positions.iter().map(|&p| flat.uv(p)).collect();
    flat
}

/// Edges are short about the joint up to the first distance, and as long as elsewhere from the second on, in lengths of the blade. An
/// edge that is not short against the clamp turns the whole blade by up to a degree.
const JOINT_REACH: [f64; 2] = [0.03, 0.11];

/// Meshes of fewer vertices are even: their edges are as long as that reach, and would have to grow too fast.
const JOINT_VERTICES: u32 = 400;

/// The lengths of a blade's edges.
fn joint_sizing(settings: &Settings) -> remesh::Sizing {
    if settings.vertices < JOINT_VERTICES {
        return remesh::Sizing::EVEN;
    }
    let [reach, end] = JOINT_REACH.map(|lengths| lengths * settings.length * 1e-3);
    remesh::Sizing { finest: settings.joint_edges, reach, end }
}

/// Distance from the joint, in lengths of the blade, within which the petiole holds vertices.
const HELD: f64 = 0.04;

/// The vertices that the petiole holds: those near the joint, the nearest and those joined to it in any case, which is enough
/// to hold the blade's direction.
fn held(mesh: &Remesh, length: f64) -> Vec<u32> {
    let distance = |&v: &usize| mesh.points[v].norm();
    let joint = (0..mesh.points.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0);
    let beside = mesh.topology.edges.iter().filter(|edge| edge.contains(&(joint as u32))).flatten().copied();
    let near = (0..mesh.points.len()).filter(|v| distance(v) <= HELD * length).map(|v| v as u32);
    let mut held: Vec<u32> = beside.chain(near).chain([joint as u32]).collect();
    held.sort_unstable();
    held.dedup();
    held
}

fn figures(mesh: &Remesh, outlines: &[Vec<DVec2>], keys: usize, trace: Option<&Trace>) -> Figures {
    let rings: Vec<&[DVec2]> = mesh.loops.iter().map(|ring| &mesh.points[ring.clone()]).collect();
    let farthest = |lines: &[Vec<DVec2>]| {
        rings.iter().zip(lines).map(|(ring, line)| polygon::hausdorff(ring, line)).fold(0.0, f64::max)
    };
    let doubled_area = |lines: &mut dyn Iterator<Item = &[DVec2]>| lines.map(polygon::doubled_area).sum::<f64>();
    let area = doubled_area(&mut outlines.iter().map(Vec::as_slice));
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
        .with("holes", rings.len() - 1)
        .with("rounds", mesh.rounds)
        .with("quality_by_round", by_round(mesh))
        .with("area_error", doubled_area(&mut rings.iter().copied()) / area - 1.0);
    if let Some(trace) = trace {
        let plane = |line: &Vec<DVec2>| line.iter().map(|&p| trace.pose.plane(p)).collect::<Vec<DVec2>>();
        let traced: Vec<Vec<DVec2>> = std::iter::once(&trace.outline).chain(&trace.holes).map(plane).collect();
        figures = figures
            .with("outline_hausdorff_px", trace.hausdorff)
            .with("boundary_hausdorff_px", farthest(&traced) / trace.pose.scale)
            .with("joint_px", [trace.pose.joint.x, trace.pose.joint.y].to_vec())
            .with("filled_gaps", trace.filled)
            .with("other_leaves", trace.others);
        figures.notes.extend(notes(trace));
    }
    figures.error = Some(ErrorFigure {
        metric: "Hausdorff distance of the mesh's rim from the outline".to_owned(),
        value: farthest(outlines) * 1e3,
        unit: "mm".to_owned(),
        bound: None,
        how: "measured both ways at the corners and three points of each side".to_owned(),
    });
    figures
}

/// The figures of the mesh if there had been fewer rounds, where they are those of the paper's Figure 2, and the last.
fn by_round(mesh: &Remesh) -> serde_json::Value {
    let last = mesh.history.len().saturating_sub(1);
    let rounds = [0, 10, 40, 160].map(|round: usize| round.min(last));
    let row = |&round: &usize| {
        let quality = &mesh.history[round];
        serde_json::json!({
            "round": round,
            "q_mean": quality.q_mean,
            "min_angle_deg": quality.min_angle.to_degrees(),
            "edge_cv": quality.edge_cv,
        })
    };
    let mut rounds: Vec<usize> = rounds.into_iter().filter(|_| !mesh.history.is_empty()).collect();
    rounds.dedup();
    rounds.iter().map(row).collect()
}

#[cfg(test)]
mod tests;
