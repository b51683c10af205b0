use super::*;
use crate::base::maths::{sin, sincos};
use crate::leaf::polygon;
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

fn spline(places: &[(f64, f64)], corner: f64) -> Spline {
    Spline::through(&places.iter().map(|&(x, y)| DVec2::new(x, y)).collect::<Vec<_>>(), corner)
}

/// A closed curve with these distances from (0, 0), counter-clockwise.
fn star(radii: &[f64], corner: f64) -> Spline {
    let place = |(i, radius): (usize, &f64)| {
        let (sine, cosine) = sincos(TAU * i as f64 / radii.len() as f64);
        (radius * cosine, radius * sine)
    };
    spline(&radii.iter().enumerate().map(place).collect::<Vec<_>>(), corner)
}

/// Five lobes with teeth.
fn lobed() -> Spline {
    let radius = |i: u32| {
        let angle = TAU * f64::from(i) / 60.0;
        1.0 + 0.35 * sin(5.0 * angle) + if i.is_multiple_of(3) { 0.08 } else { 0.0 }
    };
    star(&(0..60).map(radius).collect::<Vec<_>>(), 1.0)
}

fn doubled_area(mesh: &Remesh, triangle: &[u32; 3]) -> f64 {
    let [a, b, c] = triangle.map(|v| mesh.points[v as usize]);
    (b - a).perp(&(c - a))
}

/// Everything that must hold for any mesh.
fn assert_valid(mesh: &Remesh) {
    let Topology { triangles, edges } = &mesh.topology;
    assert!(mesh.points.iter().all(|p| p.x.is_finite() && p.y.is_finite()));
    assert!(triangles.iter().all(|t| doubled_area(mesh, t) > 0.0), "a triangle is folded");
    let euler = mesh.points.len() as i64 - edges.len() as i64 + triangles.len() as i64;
    assert_eq!(euler, 2 - mesh.loops.len() as i64, "Euler's formula");
    let mut sides: Vec<[u32; 2]> = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
    sides.sort_unstable();
    assert!(sides.windows(2).all(|pair| pair[0] != pair[1]), "two triangles lie on one side of an edge");
    let mut rim: Vec<[u32; 2]> = Vec::new();
    for range in &mesh.loops {
        let next = |i: usize| if i + 1 == range.end { range.start } else { i + 1 };
        rim.extend(range.clone().map(|i| [i as u32, next(i) as u32]));
    }
    let open = sides.iter().copied().filter(|&[a, b]| sides.binary_search(&[b, a]).is_err());
    assert!(open.eq(rim), "the open sides are the loops");
    let loops: Vec<Vec<DVec2>> = mesh.loops.iter().map(|range| mesh.points[range.clone()].to_vec()).collect();
    assert!(polygon::crossings(&loops).is_empty(), "the rim is simple");
    let doubled: f64 = triangles.iter().map(|t| doubled_area(mesh, t)).sum();
    let enclosed: f64 = loops.iter().map(|points| polygon::doubled_area(points)).sum();
    assert!((doubled / enclosed - 1.0).abs() < 1e-9, "the triangles fill the loops");
    assert_eq!(mesh.history.len(), mesh.rounds as usize + 1);
    assert_eq!(mesh.history.last(), Some(&mesh.quality));
    assert_eq!(graded(&mesh.points, &mesh.loops, triangles, Sizing::EVEN).excused, mesh.quality.excused);
}

fn assert_count(mesh: &Remesh, wanted: usize) {
    let count = mesh.points.len();
    assert!(count.abs_diff(wanted) * 20 <= wanted, "{count} vertices for {wanted}");
}

#[test]
fn a_lobed_outline_is_meshed_evenly() {
    let outline = [lobed()];
    for (wanted, q_mean, edge_cv) in [(220, 0.97, 0.10), (1000, 0.985, 0.075), (3000, 0.99, 0.055)] {
        let mesh = evened(&outline, wanted, 160).unwrap();
        assert_valid(&mesh);
        assert_count(&mesh, wanted);
        let quality = mesh.quality;
        assert!(quality.q_mean > q_mean && quality.edge_cv < edge_cv, "{wanted}: {quality:?}");
        assert!(quality.min_angle > 0.5, "{wanted}: {quality:?}");
        let area = Curve::new(&outline[0], 1e-3).area();
        assert!((polygon::doubled_area(&mesh.points[mesh.loops[0].clone()]) / (2.0 * area) - 1.0).abs() < 1e-3);
    }
}

#[test]
fn edges_are_as_long_as_asked_about_the_joint() {
    let outline = [lobed()];
    let sizing = Sizing { finest: 0.33, reach: 0.1, end: 0.5 };
    let mesh = sized(&outline, 600, 160, sizing).unwrap();
    assert_valid(&mesh);
    assert_count(&mesh, 600);
    assert!(mesh.quality.q_mean > 0.97 && mesh.quality.edge_cv < 0.1 && mesh.quality.min_angle > 0.5, "{mesh:?}");
    let mean = |from: f64, to: f64| {
        let lengths = mesh.topology.edges.iter().map(|edge| edge.map(|v| mesh.points[v as usize]));
        let there = lengths.filter(|[a, b]| (from..to).contains(&((a + b) * 0.5).norm()));
        let (sum, count) = there.fold((0.0, 0.0), |(sum, count), [a, b]| (sum + (b - a).norm(), count + 1.0));
        sum / count
    };
    let shorter = mean(0.0, 0.1) / mean(0.5, 2.0);
    assert!((shorter / 0.33 - 1.0).abs() < 0.12, "{shorter}");
}

#[test]
fn more_rounds_are_never_worse_and_their_history_tells() {
    let outline = [lobed()];
    let full = evened(&outline, 300, 160).unwrap();
    assert!(full.rounds < 160, "the rounds settle");
    let mut before: Option<Quality> = None;
    for rounds in [0, 1, 2, 5, 10, 20, 40, 160] {
        let mesh = evened(&outline, 300, rounds).unwrap();
        assert_valid(&mesh);
        assert_count(&mesh, 300);
        assert_eq!(mesh.rounds, rounds.min(full.rounds));
        assert_eq!(mesh.history[..], full.history[..=mesh.rounds as usize]);
        assert!(before.is_none_or(|b| mesh.quality.is_no_worse_than(&b)));
        before = Some(mesh.quality);
    }
    assert!(full.quality.q_mean > full.history[0].q_mean + 0.005);
    assert!(full.history.windows(2).all(|pair| pair[1].is_no_worse_than(&pair[0])));
}

#[test]
fn the_bare_triangulation_has_the_rim_alone() {
    let mesh = bare(&[lobed()], 300).unwrap();
    assert_valid(&mesh);
    assert_eq!(mesh.loops, vec![0..mesh.points.len()]);
    assert_eq!(mesh.topology.triangles.len(), mesh.points.len() - 2);
    assert!(mesh.quality.q_mean < 0.6, "long and narrow: {:?}", mesh.quality);
}

#[test]
fn the_first_vertex_is_the_first_key_and_the_rim_follows_the_curve() {
    let outline = [lobed()];
    let mesh = evened(&outline, 1500, 160).unwrap();
    assert!((mesh.points[0] - outline[0].at(0, 0.0)).norm() < 0.02);
    let far = polygon::hausdorff(&mesh.points[mesh.loops[0].clone()], &outline[0].polyline(16));
    assert!(far < 0.02, "{far} with edges of about 0.05");
}

#[test]
fn holes_stay_open() {
    let hole = |x: f64, y: f64, size: f64| {
        let corner = |i: u32| sincos(-TAU * f64::from(i) / 8.0);
        spline(&(0..8).map(corner).map(|(s, c)| (x + size * c, y + size * s)).collect::<Vec<_>>(), PI)
    };
    // The third is smaller than the triangles, the fourth almost touches the rim.
    let loops = [lobed(), hole(0.2, 0.1, 0.2), hole(-0.5, 0.1, 0.01), hole(-0.1, -0.55, 0.06)];
    let mesh = evened(&loops, 600, 160).unwrap();
    assert_valid(&mesh);
    assert_count(&mesh, 600);
    assert_eq!(mesh.loops.len(), 4);
    assert!(mesh.quality.q_mean > 0.95, "{:?}", mesh.quality);
}

#[test]
fn hostile_outlines_give_a_valid_mesh_or_an_error() {
    let needle = spline(&[(0.0, 0.0), (1.0, 0.004), (0.0, 0.008)], 0.5);
    let triangle = spline(&[(0.0, 0.0), (1.0, 0.1), (0.2, 0.9)], 0.5);
    let slit = spline(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.5003, 1.0), (0.5, 0.1), (0.4997, 1.0), (0.0, 1.0)], 0.5);
    let horseshoe = spline(
        &[(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0), (0.0, 0.6), (1.6, 0.6), (1.6, 0.59), (0.0, 0.59)],
        0.5,
    );
    let spiky: Vec<f64> = (0..48).map(|i| if i % 2 == 0 { 1.0 } else { 0.1 }).collect();
    for (name, outline) in [
        ("needle", needle),
        ("triangle", triangle),
        ("slit", slit),
        ("horseshoe", horseshoe),
        ("spiky", star(&spiky, 0.5)),
    ] {
        for wanted in [3, 12, 40, 300] {
            let mesh = evened(std::slice::from_ref(&outline), wanted, 160);
            match mesh {
                Ok(mesh) => assert_valid(&mesh),
                Err(LeafError::Mesh { what }) => println!("{name} with {wanted}: {what}"),
                Err(other) => panic!("{name} with {wanted}: {other}"),
            }
        }
    }
}

#[test]
fn outlines_without_area_or_that_cross_are_refused() {
    let clockwise = spline(&[(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)], 1.0);
    let bow_tie = spline(&[(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 3.0)], 1.0);
    let pair = [lobed(), spline(&[(2.0, 0.0), (0.0, 0.5), (0.0, -0.5)], PI)];
    for loops in [std::slice::from_ref(&clockwise), std::slice::from_ref(&bow_tie), &pair] {
        assert!(matches!(evened(loops, 100, 10), Err(LeafError::Mesh { .. })));
        assert!(matches!(bare(loops, 100), Err(LeafError::Mesh { .. })));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_stars_are_meshed(
        radii in prop::collection::vec(0.3f64..1.0, 5..40),
        wanted in 12usize..500,
        corner in 0.3f64..3.2,
        rounds in 0u32..60,
    ) {
        match evened(&[star(&radii, corner)], wanted, rounds) {
            Ok(mesh) => {
                assert_valid(&mesh);
                // Where the rim leaves room for inner vertices, their number is met.
                if mesh.loops[0].len() * 2 < wanted {
                    assert_count(&mesh, wanted);
                }
                prop_assert!(mesh.history.windows(2).all(|pair| pair[1].is_no_worse_than(&pair[0])));
            }
            Err(LeafError::Mesh { .. }) => {}
            Err(other) => panic!("{other}"),
        }
    }
}
