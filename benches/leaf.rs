//! How long the steps of the leaf stage take on a scan of 1,600 pixels, and how the mesh of 1,000 vertices compares with
//! spade's refinement of the same rim: `cargo bench --bench leaf`. Everything runs on one thread.

#[path = "../tests/common/painted_leaf.rs"]
mod painted_leaf;
mod timing;

use leafseason::base::limits::Limits;
use leafseason::base::picture::Picture;
use leafseason::base::vector::DVec2;
use leafseason::leaf::steps::{Remesh, Spline, chosen, evened, outlined, scanned, segmented, spline};
use leafseason::leaf::{self, Settings, Trace};
use leafseason::scene::{self, Asset};
use painted_leaf::{Scan, painted};
use spade::{AngleLimit, ConstrainedDelaunayTriangulation, Point2, RefinementParameters, Triangulation};
use std::path::Path;
use timing::{case, consume, report, timed};

/// What ratios are taken to.
const UNIT: &str = "spade refine";
const VERTICES: usize = 1000;
/// Bound of the key points, pixels, and the turn of sharp ones, radians.
const TOLERANCE: f64 = 1.0;
const CORNER: f64 = 65.0 * std::f64::consts::PI / 180.0;

fn main() {
    let rounds = timing::rounds();
    bench("a painted leaf of 1,600 px", &painted(Scan { side: 1600, hole: true, ..Scan::default() }), rounds);
    // Real scans lie beside the repository, if anywhere.
    let scan = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/leaves/grape_palmate_a.jpg");
    if let Ok(picture) = scene::read_picture(&Asset::outside(&scan), &Limits::default()) {
        bench("a grape leaf of 1,582 x 1,600 px", &picture, rounds);
    }
}

fn bench(what: &str, picture: &Picture, rounds: usize) {
    let settings = Settings { tolerance_px: Some(TOLERANCE), vertices: VERTICES as u32, ..Settings::default() };
    let trace = leaf::trace(&settings, picture, &Limits::default()).expect("a trace");
    let segment = segmented(picture).expect("a blade");
    let loops = loops(&trace);
    let mesh = evened(&loops, VERTICES, 160).expect("a mesh");
    let cases = [
        case("segmentation", || consume(segmented(picture))),
        case("outline", || consume(outlined(&segment.blade))),
        case("key points", || consume(chosen(&trace.outline, TOLERANCE, CORNER))),
        case("mesh", || consume(evened(&loops, VERTICES, 160))),
        case(UNIT, || consume(refined(&mesh))),
        case("veins", || consume(scanned(picture, &trace))),
        case("all of it", || consume(leaf::traced(&settings, picture, None, &Limits::default()))),
    ];
    report(&format!("{what}, {} vertices", mesh.points.len()), UNIT, &timed(&cases, rounds));
}

/// The outline and the gaps in the blade's plane.
fn loops(trace: &Trace) -> Vec<Spline> {
    let plane = |line: &[DVec2], is_rim: bool| -> Spline {
        let mut points: Vec<DVec2> = line.iter().map(|&p| trace.pose.plane(p)).collect();
        let doubled_area: f64 = (0..points.len()).map(|i| points[i].perp(&points[(i + 1) % points.len()])).sum();
        if (doubled_area > 0.0) != is_rim {
            points.reverse();
        }
        spline(&points, &(0..points.len()).collect::<Vec<usize>>(), CORNER)
    };
    let holes = trace.hole_keys.iter().map(|hole| plane(hole, false));
    std::iter::once(plane(&trace.keys, true)).chain(holes).collect()
}

/// spade's own refinement of a mesh's rim to triangles of the same size.
fn refined(mesh: &Remesh) -> usize {
    let point = |p: &DVec2| Point2::new(p.x, p.y);
    let rims = mesh.loops.clone();
    let last = rims.last().map_or(0, |ring| ring.end);
    let edges = rims.iter().flat_map(|ring| {
        ring.clone().map(|i| [i, if i + 1 == ring.end { ring.start } else { i + 1 }]).collect::<Vec<[usize; 2]>>()
    });
    let points = mesh.points[..last].iter().map(point).collect();
    let mut web =
        ConstrainedDelaunayTriangulation::<Point2<f64>>::bulk_load_cdt(points, edges.collect()).expect("a rim");
    let area: f64 = mesh
        .topology
        .triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|v| mesh.points[v as usize]);
            (b - a).perp(&(c - a)) * 0.5
        })
        .sum();
    let largest = 1.35 * area / mesh.topology.triangles.len() as f64;
    let parameters = RefinementParameters::new()
        .with_angle_limit(AngleLimit::from_deg(30.0))
        .with_max_allowed_area(largest)
        .exclude_outer_faces(true)
        .keep_constraint_edges()
        .with_max_additional_vertices(20 * VERTICES);
    web.refine(parameters);
    web.num_vertices()
}
