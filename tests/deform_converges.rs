//! The shape of a real leaf hardly depends on its mesh: 600 vertices against 4,000 of the built-in species, each with the mask
//! of its own veins, held at the petiole.

use leafseason::base::blade::Blade;
use leafseason::base::flat_mesh::FlatMesh;
use leafseason::base::limits::Limits;
use leafseason::base::vector::{DVec2, DVec3};
use leafseason::deform::{self, Job};
use leafseason::leaf::{self, Pictures};
use leafseason::species;

/// The blade of a species with so many vertices, and how it dries.
fn leaf(name: &str, vertices: u32) -> (Blade, deform::Settings) {
    let table: toml::Table = toml::from_str(species::text(name).expect("a species")).expect("TOML");
    let settings: leaf::Settings = table["leaf"].clone().try_into().expect("a leaf");
    let settings = leaf::Settings { vertices, ..settings };
    let (blade, _) = leaf::model(&settings, Pictures::default(), &Limits::default()).expect("a blade");
    (blade, table["deform"].clone().try_into().expect("a shape"))
}

/// The shapes at some drynesses, metres.
fn shapes(blade: &Blade, settings: &deform::Settings, drynesses: &[f64]) -> Vec<Vec<DVec3>> {
    let job = |&dryness: &f64| Job { state: "brown".to_owned(), variant: 0, dryness };
    let jobs: Vec<Job> = drynesses.iter().map(job).collect();
    let (made, _) = deform::deform(settings, blade, &jobs, 1, &Limits::default()).expect("shapes");
    let wide = |p: &leafseason::base::vector::Vec3| DVec3::new(p.x.into(), p.y.into(), p.z.into());
    made.iter().map(|mesh| mesh.positions.iter().map(wide).collect()).collect()
}

/// Where a shape of a mesh has a point of the flat blade: by its triangle, or the one that it is least outside of.
fn carried(mesh: &FlatMesh, shape: &[DVec3], p: DVec2) -> DVec3 {
    let shares = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|v| mesh.positions[v as usize]);
        let area = (b - a).perp(&(c - a));
        [(c - b).perp(&(p - b)) / area, (a - c).perp(&(p - c)) / area, (b - a).perp(&(p - a)) / area]
    };
    let least = |triangle: &[u32; 3]| shares(triangle).into_iter().fold(f64::INFINITY, f64::min);
    let inside = mesh.triangles.iter().max_by(|a, b| least(a).total_cmp(&least(b))).expect("a triangle");
    inside.iter().zip(shares(inside)).map(|(&v, share)| shape[v as usize] * share).sum()
}

/// Difference of two shapes of a blade, over the deformation: roots of the mean squares over the area.
fn difference(coarse: (&FlatMesh, &[DVec3]), fine: (&FlatMesh, &[DVec3])) -> f64 {
    let mut areas = vec![0.0; coarse.0.positions.len()];
    for &triangle in &coarse.0.triangles {
        triangle.iter().for_each(|&v| areas[v as usize] += coarse.0.doubled_area(triangle));
    }
    let (mut apart, mut moved) = (0.0, 0.0);
    for ((&place, p), area) in coarse.0.positions.iter().zip(coarse.1).zip(areas) {
        let q = carried(fine.0, fine.1, place);
        apart += area * (p - q).norm_squared();
        moved += area * (q - DVec3::new(place.x, place.y, 0.0)).norm_squared();
    }
    f64::sqrt(apart / moved)
}

/// The differences of meshes of some numbers of vertices from one of 4,000, by dryness.
fn differences(name: &str, vertices: &[u32], drynesses: &[f64]) -> Vec<Vec<f64>> {
    let (fine, settings) = leaf(name, 4000);
    let reference = shapes(&fine, &settings, drynesses);
    let one = |&vertices: &u32| {
        let (coarse, _) = leaf(name, vertices);
        let made = shapes(&coarse, &settings, drynesses);
        made.iter().zip(&reference).map(|(a, b)| difference((&coarse.mesh, a), (&fine.mesh, b))).collect()
    };
    vertices.iter().map(one).collect()
}

/// From hardly dry to nearly as dry as can be.
const DRYNESSES: &[f64] = &[0.3, 0.5, 0.7, 0.9];

fn assert_converged(name: &str) {
    for (difference, dryness) in differences(name, &[600], DRYNESSES)[0].iter().zip(DRYNESSES) {
        assert!(*difference < 0.02, "{name} at {dryness}: {difference}");
    }
}

#[test]
fn a_beech_of_600_vertices_is_that_of_4000() {
    assert_converged("beech");
}

#[test]
fn an_english_oak_of_600_vertices_is_that_of_4000() {
    assert_converged("english-oak");
}

#[test]
fn a_ginkgo_of_600_vertices_is_that_of_4000() {
    assert_converged("ginkgo");
}

#[test]
fn a_japanese_maple_of_600_vertices_is_that_of_4000() {
    assert_converged("japanese-maple");
}

#[test]
fn a_norway_maple_of_600_vertices_is_that_of_4000() {
    assert_converged("norway-maple");
}

#[test]
fn a_quaking_aspen_of_600_vertices_is_that_of_4000() {
    assert_converged("quaking-aspen");
}

#[test]
fn a_red_maple_of_600_vertices_is_that_of_4000() {
    assert_converged("red-maple");
}

#[test]
fn a_red_oak_of_600_vertices_is_that_of_4000() {
    assert_converged("red-oak");
}

#[test]
fn a_silver_birch_of_600_vertices_is_that_of_4000() {
    assert_converged("silver-birch");
}

#[test]
fn a_sugar_maple_of_600_vertices_is_that_of_4000() {
    assert_converged("sugar-maple");
}

#[test]
fn a_sweetgum_of_600_vertices_is_that_of_4000() {
    assert_converged("sweetgum");
}

#[test]
fn a_finer_mesh_is_nearer() {
    let [coarse, fine] = [300, 1200].map(|vertices| differences("silver-birch", &[vertices], &[0.5])[0][0]);
    assert!(fine < 0.6 * coarse, "{coarse} {fine}");
}
