//! The deformation stage: a flat leaf -> one curled shape for each state and variant that a leaf wears.
//!
//! Two models: [`shell`] (a sheet that dries, solved for its shape of least energy) and `paper` (the mass-spring system of
//! Tang, Wu and Fan 2013, snapshots of a run). [`integrators`] has other ways to the shell's shapes, for comparison.

mod cholesky;
pub mod integrators;
mod paper;
mod settings;
pub mod shell;

use crate::base::blade::Blade;
use crate::base::figures::Figures;
use crate::base::flat_mesh::FlatMesh;
use crate::base::limits::{Limits, Refusal};
use crate::base::mesh::Mesh;
use crate::base::picture::Picture;
use crate::base::settings::Complaint;
use crate::base::vector::{DVec3, Vec3};
pub use paper::masses::mass;
pub use paper::springs::Springs;
pub use settings::{Automatic, Field, Model, Settings, StateShape, Step};
use thiserror::Error;

/// A shape to make.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    /// The state that wears it.
    pub state: String,
    /// Which of the state's shapes, from 0; jobs of one variant are snapshots of one run.
    pub variant: u32,
    /// How dry the leaf is, 0 to 1.
    pub dryness: f64,
}

/// Why shapes could not be made.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum DeformError {
    /// The given step cannot be stable on this mesh.
    #[error("deform.step = {step:e} s blows up on this mesh; take at most {safe:.3e} s, or leave it out")]
    Unstable {
        /// The step asked for, seconds.
        step: f64,
        /// The largest stable one, seconds.
        safe: f64,
    },
    /// The numbers overflowed.
    #[error("the leaf flew apart at step {step}: deform.force is too large for deform.stiffness")]
    Diverged {
        /// When, in steps.
        step: u64,
    },
    /// The strain bound of equation (2) could not be held.
    #[error("springs stretch by {strain:.3} although deform.strain_limit is {limit}: deform.force is too large")]
    Stretched {
        /// The largest strain of any spring.
        strain: f64,
        /// The bound asked for.
        limit: f64,
    },
    /// The shell found no shape of least energy.
    #[error(
        "the leaf does not settle at a dryness of {dryness:.4} after {iterations} iterations (residual {residual:.1e})"
    )]
    NotSettled {
        /// Where on the way from flat to dry.
        dryness: f64,
        /// Iterations of the last try.
        iterations: u64,
        /// Largest force left on a vertex, in bending stiffness over extent.
        residual: f64,
    },
    /// There is nothing to bend.
    #[error("the leaf has no triangles")]
    Empty,
    /// A triangle has no area to speak of.
    #[error("triangle {triangle} of the leaf is degenerate: it has no area, or a coordinate is not a number")]
    Degenerate {
        /// Its number.
        triangle: usize,
    },
    /// A limit refused it.
    #[error(transparent)]
    Refused(#[from] Refusal),
}

/// Everything wrong with well-typed settings that can be seen without a mesh.
#[must_use]
pub fn check(settings: &Settings) -> Vec<Complaint> {
    match settings.model {
        Model::Shell => Vec::new(),
        Model::Paper => paper::check(settings),
    }
}

/// A leaf to be bent.
#[derive(Clone, Copy, Debug)]
pub struct Flat<'a> {
    /// Its mesh.
    pub mesh: &'a FlatMesh,
    /// Its mask, by the mesh's texture coordinates; without one, greys between the vertices are taken from theirs.
    pub mask: Option<&'a Picture>,
}

impl<'a> From<&'a FlatMesh> for Flat<'a> {
    fn from(mesh: &'a FlatMesh) -> Self {
        Self { mesh, mask: None }
    }
}

impl<'a> From<&'a Blade> for Flat<'a> {
    fn from(blade: &'a Blade) -> Self {
        let whole = blade.mask.width > 0 && blade.mask.height > 0;
        Self { mesh: &blade.mesh, mask: whole.then_some(&blade.mask) }
    }
}

/// Makes a shape for each job, in the jobs' order. The same jobs give the same bytes on any thread count and in any company.
///
/// # Errors
/// [`DeformError`] when the settings do not suit the mesh, or a limit refuses the work.
pub fn deform<'a>(
    settings: &Settings,
    leaf: impl Into<Flat<'a>>,
    jobs: &[Job],
    seed: u64,
    limits: &Limits,
) -> Result<(Vec<Mesh>, Figures), DeformError> {
    let flat = leaf.into();
    let mesh = flat.mesh;
    sound(mesh)?;
    let (shapes, figures) = match settings.model {
        Model::Shell => shell::shapes(&settings.shell, &flat, jobs, seed, limits)?,
        Model::Paper => paper::shapes(settings, mesh, jobs, seed, limits)?,
    };
    Ok((shapes.iter().map(|positions| shape(mesh, positions)).collect(), figures))
}

/// Smallest area of a triangle, as a share of the square on its longest edge: thinner ones carry no curvature in double
/// precision, and their springs no length.
const THINNEST: f64 = 1e-6;

/// Whether there are triangles, all with an area.
fn sound(mesh: &FlatMesh) -> Result<(), DeformError> {
    if mesh.triangles.is_empty() {
        return Err(DeformError::Empty);
    }
    let degenerate = |&triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|v| mesh.positions[v as usize]);
        let longest = (b - a).norm_squared().max((c - b).norm_squared()).max((a - c).norm_squared());
        // Written so that NaN counts as degenerate.
        !(mesh.doubled_area(triangle) > 2.0 * THINNEST * longest && longest < f64::INFINITY)
    };
    match mesh.triangles.iter().position(degenerate) {
        Some(triangle) => Err(DeformError::Degenerate { triangle }),
        None => Ok(()),
    }
}

fn shape(flat: &FlatMesh, positions: &[DVec3]) -> Mesh {
    let mut mesh = Mesh {
        positions: positions.iter().map(|p| Vec3::new(p.x as f32, p.y as f32, p.z as f32)).collect(),
        uvs: flat.uvs.clone(),
        triangles: flat.triangles.clone(),
        normals: Vec::new(),
    };
    mesh.recompute_normals();
    mesh
}
