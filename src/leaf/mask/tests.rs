use super::*;
use crate::base::flat_mesh::BLADE_UV_MARGIN;
use crate::base::maths::sincos;
use crate::leaf::show::texture::grey_at;
use std::f64::consts::TAU;

/// An oval 60 x 80 mm with its joint below, two triangles wide: enough for the layout.
fn oval() -> (FlatMesh, Vec<DVec2>) {
    let point = |i: u32| sincos(TAU * f64::from(i) / 400.0);
    let outline: Vec<DVec2> = (0..400).map(point).map(|(s, c)| DVec2::new(0.03 * c, 0.04 * (s + 1.0))).collect();
    let mut mesh = FlatMesh {
        positions: vec![DVec2::zeros(), DVec2::new(0.03, 0.04), DVec2::new(0.0, 0.08), DVec2::new(-0.03, 0.04)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        uv_scale: (1.0 - 2.0 * BLADE_UV_MARGIN) / 0.08,
        ..FlatMesh::default()
    };
    mesh.uv_origin = DVec2::new(0.5, 0.5 + mesh.uv_scale * 0.04);
    (mesh, outline)
}

fn at(mesh: &FlatMesh, mask: &Picture, x: f64, y: f64) -> f64 {
    grey_at(mask, mesh.uv(DVec2::new(x, y)))
}

fn only(change: impl Fn(&mut Mask)) -> Mask {
    let zero = Mask { lamina: 0.0, margin: 0.0, tips: 0.0, petiole: 0.0, distance: 0.0, blur: 0.0, ..Mask::default() };
    let mut law = zero;
    change(&mut law);
    law
}

#[test]
fn without_weights_nothing_moves() {
    let (mesh, outline) = oval();
    let mask = drawn(&mesh, &outline, &[], &[], &only(|_| ()));
    assert_eq!(at(&mesh, &mask, 0.0, 0.04), 255.0);
    assert_eq!(at(&mesh, &mask, 0.0, 0.001), 255.0);
    assert_eq!(mask.pixels[0], [0, 0, 0, 255], "black where there is no blade");
}

#[test]
fn each_weight_has_its_closed_form() {
    let (mesh, outline) = oval();
    let grey = |law: &Mask, x: f64, y: f64| at(&mesh, &drawn(&mesh, &outline, &[], &[], law), x, y);
    let lamina = only(|law| law.lamina = 0.4);
    assert_eq!(grey(&lamina, 0.0, 0.04), 153.0);
    // On the short axis the margin is the nearest: e = 1/3 at 10 mm from it, the deepest place being 30 mm below it.
    let margin = only(|law| law.margin = 0.6);
    let curl = 0.6 * (2.0f64 / 3.0) * (2.0f64 / 3.0).sqrt();
    assert!((grey(&margin, 0.02, 0.04) - 255.0 * (1.0 - curl)).abs() < 3.0);
    assert!((grey(&margin, 0.0, 0.04) - 255.0).abs() < 3.0);
    // Straight up the axis the way is 60 of 80 mm.
    let distance = only(|law| law.distance = 0.8);
    assert!((grey(&distance, 0.0, 0.06) - 255.0 * (1.0 - 0.8 * 0.75 * 0.75)).abs() < 5.0);
    let petiole = only(|law| law.petiole = 0.5);
    assert!((grey(&petiole, 0.0, 0.001) - 127.5).abs() < 3.0 && grey(&petiole, 0.0, 0.06) > 254.0);
    // No half of a disc lies outside a blade this round.
    assert!(grey(&only(|law| law.tips = 1.0), 0.0, 0.075) > 230.0);
}

#[test]
fn veins_are_white_and_their_ends_move() {
    let (mesh, outline) = oval();
    let points = (0..=80).map(|i| DVec2::new(0.0, f64::from(i) * 1e-3)).collect();
    let midrib = Vein { points, width: 1e-3, end_width: 1e-3, order: 1 };
    let law = Mask { blur: 0.0, lamina: 0.5, ..Mask::default() };
    let with = drawn(&mesh, &outline, &[], std::slice::from_ref(&midrib), &law);
    let without = drawn(&mesh, &outline, &[], &[], &law);
    assert!(at(&mesh, &with, 0.0, 0.04) > 254.0 && at(&mesh, &without, 0.0, 0.04) < 150.0);
    assert!(at(&mesh, &with, 0.0, 0.0795) < 60.0);
    let ignored = Mask { veins: 0.0, ..law.clone() };
    assert_eq!(drawn(&mesh, &outline, &[], std::slice::from_ref(&midrib), &ignored), without);
    let third = Vein { order: 3, ..midrib };
    assert_eq!(drawn(&mesh, &outline, &[], &[third], &law), without, "the third order holds nothing");
}

#[test]
fn a_hole_s_rim_is_margin() {
    let (mesh, outline) = oval();
    let hole = [(-0.004, 0.036), (0.004, 0.036), (0.004, 0.044), (-0.004, 0.044)].map(|(x, y)| DVec2::new(x, y));
    let law = only(|law| law.margin = 0.6);
    let whole = drawn(&mesh, &outline, &[], &[], &law);
    let mut reversed = hole;
    reversed.reverse();
    let holed = drawn(&mesh, &outline, &[&hole], &[], &law);
    assert_eq!(holed, drawn(&mesh, &outline, &[&reversed], &[], &law));
    assert!(at(&mesh, &holed, 0.0, 0.045) < 130.0 && at(&mesh, &whole, 0.0, 0.045) > 220.0);
}

#[test]
fn a_mirrored_blade_has_the_mirrored_mask() {
    let (mesh, outline) = oval();
    let points = (0..=30).map(|i| DVec2::new(f64::from(i) * 5e-4, 0.02 + f64::from(i) * 1e-3)).collect();
    let vein = Vein { points, width: 1e-3, end_width: 1e-3, order: 2 };
    let mirror = |p: &DVec2| DVec2::new(-p.x, p.y);
    let other = Vein { points: vein.points.iter().map(mirror).collect(), ..vein.clone() };
    let law = Mask { vein_reach: 0.3, ..Mask::default() };
    let one = drawn(&mesh, &outline, &[], &[vein], &law);
    let two = drawn(&mesh, &outline.iter().map(mirror).collect::<Vec<_>>(), &[], &[other], &law);
    let differ = (0..SIDE * SIDE).filter(|i| {
        let across = i / SIDE * SIDE + SIDE - 1 - i % SIDE;
        i32::from(one.pixels[*i][0]).abs_diff(i32::from(two.pixels[across][0])) > 1
    });
    let count = differ.count();
    assert!(count * 500 < SIDE * SIDE, "{count}");
}

#[test]
fn blades_of_nothing_do_no_harm() {
    let mask = drawn(&FlatMesh::default(), &[], &[&[]], &[], &Mask::default());
    assert_eq!(mask.pixels.len(), SIDE * SIDE);
    let speck = [DVec2::zeros(), DVec2::new(1e-9, 0.0), DVec2::new(0.0, 1e-9)];
    let (mesh, _) = oval();
    assert_eq!(drawn(&mesh, &speck, &[], &[], &Mask::default()).pixels.len(), SIDE * SIDE);
}
