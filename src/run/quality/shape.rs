//! How far a leaf's mesh of some vertices is from a finer one, flat and bent.

use crate::base::blade::Blade;
use crate::base::diagnostic::Diagnostics;
use crate::base::flat_mesh::FlatMesh;
use crate::base::mesh::Mesh;
use crate::base::vector::{DVec2, DVec3};
use crate::deform::{self, Job};
use crate::run::fault;
use crate::run::still::Still;
use crate::run::wardrobe;
use crate::scene::Species;

/// Vertices that are tried, each about 1.7 times the one before.
const VERTICES: [u32; 8] = [40, 70, 120, 200, 350, 600, 1000, 1700];
/// How many rungs finer a mesh is that one is held against.
const FINER: usize = 2;
/// States of which shapes are compared at most: the driest, and one between.
const MOST_STATES: usize = 2;

/// The fewest vertices whose mesh is within some metres of finer ones, and how far it is, root mean square. The finest when
/// none is.
///
/// # Errors
/// What stops a run of the scene.
pub fn coarsest(still: &Still, number: usize, metres: f64) -> Result<(u32, f64), Diagnostics> {
    let species = &still.scene().species[number];
    if species.leaf.picture.is_some() || species.assets.contains_key("leaf.picture") {
        // A scan is traced anew for each mesh; its author's vertices stay.
        return Ok((species.leaf.vertices, 0.0));
    }
    let jobs = jobs(species);
    let mut made: Vec<(Blade, Vec<Mesh>)> = Vec::new();
    for rung in 0..VERTICES.len() {
        while made.len() <= (rung + FINER).min(VERTICES.len() - 1) {
            made.push(bent(still, number, VERTICES[made.len()], &jobs)?);
        }
        let finest = made.len() - 1;
        if rung >= finest {
            break;
        }
        let apart = apart(&made[rung], &made[finest.min(rung + FINER)]);
        if apart <= metres || rung + 1 == finest {
            return Ok((VERTICES[rung], apart));
        }
    }
    Ok((VERTICES[VERTICES.len() - 1], metres))
}

/// A shape of each of the driest states.
fn jobs(species: &Species) -> Vec<Job> {
    let mut states: Vec<(&String, f64)> =
        species.deform.states.iter().map(|(state, shape)| (state, shape.dryness)).collect();
    states.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(b.0)));
    let job = |(state, dryness): &(&String, f64)| Job { state: (*state).clone(), variant: 0, dryness: *dryness };
    states.iter().step_by((states.len() / MOST_STATES).max(1)).take(MOST_STATES).map(job).collect()
}

fn bent(still: &Still, number: usize, vertices: u32, jobs: &[Job]) -> Result<(Blade, Vec<Mesh>), Diagnostics> {
    let mut species = still.scene().species[number].clone();
    species.leaf.vertices = vertices;
    let blade = wardrobe::plain_blade(&species, still.limits())?;
    let made = deform::deform(&species.deform, &blade, jobs, still.scene().seed, still.limits());
    let (shapes, _) = made.map_err(|error| fault::deform(&species, &error))?;
    Ok((blade, shapes))
}

/// The larger of what two meshes differ by, root mean square over the area: where their shapes have the same point of the
/// blade, and the gap between rim and outline.
fn apart((coarse, a): &(Blade, Vec<Mesh>), (fine, b): &(Blade, Vec<Mesh>)) -> f64 {
    let mut areas = vec![0.0; coarse.mesh.positions.len()];
    for &triangle in &coarse.mesh.triangles {
        triangle.iter().for_each(|&v| areas[v as usize] += coarse.mesh.doubled_area(triangle));
    }
    let all: f64 = areas.iter().sum();
    let places: Vec<([usize; 3], [f64; 3])> = coarse.mesh.positions.iter().map(|&p| place(&fine.mesh, p)).collect();
    let square = |(a, b): (&Mesh, &Mesh)| -> f64 {
        let far = |v: usize| {
            let (corners, shares) = places[v];
            let q: DVec3 = corners.iter().zip(shares).map(|(&c, share)| b.positions[c].cast::<f64>() * share).sum();
            (a.positions[v].cast::<f64>() - q).norm_squared() * areas[v]
        };
        (0..areas.len()).map(far).sum::<f64>() / all
    };
    let bent = a.iter().zip(b).map(square).fold(0.0, f64::max);
    (bent + gap(&coarse.mesh, &coarse.outline)).sqrt()
}

/// The corners and shares of a point of the blade in a mesh: of its triangle, or the one that it is least outside of.
fn place(mesh: &FlatMesh, p: DVec2) -> ([usize; 3], [f64; 3]) {
    let mut best = ([0; 3], [0.0; 3], f64::NEG_INFINITY);
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|v| mesh.positions[v as usize]);
        let area = (b - a).perp(&(c - a));
        let shares = [(c - b).perp(&(p - b)) / area, (a - c).perp(&(p - c)) / area, (b - a).perp(&(p - a)) / area];
        let least = shares.into_iter().fold(f64::INFINITY, f64::min);
        if least > best.2 {
            best = (triangle.map(|v| v as usize), shares, least);
        }
        if least >= 0.0 {
            break;
        }
    }
    (best.0, best.1)
}

/// Mean square distance of the outline from the rim, square metres.
fn gap(mesh: &FlatMesh, outline: &[DVec2]) -> f64 {
    let rim: Vec<DVec2> = mesh.rim.iter().map(|&v| mesh.positions[v as usize]).collect();
    let sides = || rim.iter().zip(rim.iter().cycle().skip(1));
    let distance = |p: &DVec2| {
        let of = |(a, b): (&DVec2, &DVec2)| {
            let side = b - a;
            let along = ((p - a).dot(&side) / side.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            (p - (a + side * along)).norm_squared()
        };
        sides().map(of).fold(f64::INFINITY, f64::min)
    };
    outline.iter().map(distance).sum::<f64>() / outline.len().max(1) as f64
}
