//! Blades without a leaf stage: meshes of any fineness whose outline and mask do not depend on it.
#![allow(dead_code, reason = "each test file uses some of it")]

use leafseason::base::flat_mesh::FlatMesh;
use leafseason::base::limits::Limits;
use leafseason::base::maths::sincos;
use leafseason::base::mesh::Mesh;
use leafseason::base::vector::{DVec2, Vec2, Vec3};
use leafseason::deform::{self, Job, Settings};

/// An ovate blade 80 mm long and 56 mm wide of `rings` rings of triangles about its middle: 1 + 3 n (n + 1) vertices. The mask
/// is white along the midrib and black at the margin; the petiole holds a patch at the base.
pub fn ovate(rings: u32) -> FlatMesh {
    let mut mesh = FlatMesh::default();
    let first = |ring: u32| if ring == 0 { 0 } else { 1 + 3 * ring * (ring - 1) };
    for ring in 0..=rings {
        let radius = f64::from(ring) / f64::from(rings);
        for i in 0..(6 * ring).max(1) {
            let (sine, cosine) = sincos(std::f64::consts::TAU * f64::from(i) / f64::from((6 * ring).max(1)));
            let width = 0.028 * (1.0 - 0.25 * radius * sine);
            mesh.positions.push(DVec2::new(radius * cosine * width, 0.04 + 0.04 * radius * sine));
        }
    }
    for ring in 1..=rings {
        let (outer, inner) = (6 * ring, 6 * (ring - 1));
        let out = |i: u32| first(ring) + i % outer;
        let within = |i: u32| if inner == 0 { 0 } else { first(ring - 1) + i % inner };
        for sector in 0..6 {
            for i in 0..ring {
                let (o, n) = (sector * ring + i, sector * (ring - 1) + i);
                mesh.triangles.push([out(o), out(o + 1), within(n)]);
                if i + 1 < ring {
                    mesh.triangles.push([within(n), out(o + 1), within(n + 1)]);
                }
            }
        }
    }
    let grey = |p: &DVec2| 255.0 * (1.0 - (p.x / 0.028).abs()).clamp(0.0, 1.0);
    mesh.greys = mesh.positions.iter().map(grey).collect();
    mesh.uvs = mesh.positions.iter().map(|p| Vec2::new(p.x as f32, p.y as f32)).collect();
    let rim = first(rings)..first(rings + 1);
    mesh.rim = rim.collect();
    mesh.held = (0..mesh.positions.len() as u32).filter(|&v| mesh.positions[v as usize].y < 0.0058).collect();
    mesh
}

pub fn jobs(drynesses: &[f64]) -> Vec<Job> {
    drynesses.iter().map(|&dryness| Job { state: "brown".to_owned(), variant: 0, dryness }).collect()
}

/// Shapes at some drynesses, and a figure of the run by its name.
pub fn shapes(settings: &Settings, mesh: &FlatMesh, drynesses: &[f64]) -> (Vec<Mesh>, impl Fn(&str) -> f64 + use<>) {
    let made = deform::deform(settings, mesh, &jobs(drynesses), 1, &Limits::default());
    let (shapes, figures) = made.unwrap_or_else(|error| panic!("{error}"));
    assert!(shapes.iter().all(|shape| shape.check().is_ok()));
    (shapes, move |name: &str| figures.values[name].as_f64().expect("a number"))
}

/// Root of the mean square distance between the vertices of two shapes.
pub fn distance(a: &[Vec3], b: &[Vec3]) -> f64 {
    let squares: f64 = a.iter().zip(b).map(|(p, q)| f64::from((p - q).norm_squared())).sum();
    (squares / a.len() as f64).sqrt()
}

/// The flat blade's vertices in space.
pub fn flat(mesh: &FlatMesh) -> Vec<Vec3> {
    mesh.positions.iter().map(|p| Vec3::new(p.x as f32, p.y as f32, 0.0)).collect()
}
