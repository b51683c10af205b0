use super::scanned::{Evidence, scanned};
use super::*;
use crate::base::blade::Vein;
use crate::base::limits::Limits;
use crate::base::maths::{cos, sincos};
use crate::base::picture::Picture;
use crate::base::random::hash;
use crate::base::vector::DVec2;
use crate::leaf::{Settings, Venation, mask, polygon, trace};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, TAU};

const PAPER: [u8; 4] = [235, 228, 215, 255];

/// A picture of a round leaf with a stalk below, a midrib and four secondaries; what they are painted in is told by `tone`.
fn painted(side: u32, blade: [u8; 4], vein: [u8; 4]) -> Picture {
    let unit = f64::from(side) / 400.0;
    let mut picture = Picture::filled(side, side, PAPER);
    let secondaries = [(60.0, 1.0), (60.0, -1.0), (130.0, 1.0), (130.0, -1.0)];
    for (i, pixel) in picture.pixels.iter_mut().enumerate() {
        let (column, row) = (i % side as usize, i / side as usize);
        // Up from the joint, in four-hundredths of the picture.
        let (x, y) = ((column as f64 + 0.5) / unit - 200.0, 330.0 - (row as f64 + 0.5) / unit);
        let inside = x * x + (y - 130.0) * (y - 130.0) < 130.0 * 130.0;
        let stalk = x.abs() < 3.0 && (-50.0..2.0).contains(&y);
        let branch = |&(start, side): &(f64, f64)| {
            let out = x * side;
            (0.0..95.0).contains(&out) && (y - start - out).abs() < 2.8
        };
        let on_vein = x.abs() < 2.0 || secondaries.iter().any(branch);
        if inside || stalk {
            // A texture, so that the blade is no silhouette.
            let grain = hash(column as u64, row as u64) % 5;
            *pixel = if on_vein && inside { vein } else { blade.map(|c| c.saturating_add(grain as u8)) };
            pixel[3] = 255;
        }
    }
    picture
}

fn seen(picture: &Picture) -> (Vec<Vein>, Evidence) {
    let trace = trace(&Settings { length: 100.0, ..Settings::default() }, picture, &Limits::default()).unwrap();
    scanned(picture, &trace)
}

#[test]
fn painted_veins_are_seen_whether_bright_or_dark() {
    let cases = [([40, 90, 30, 255], [120, 150, 80, 255]), ([170, 190, 80, 255], [110, 120, 50, 255])];
    for (blade, vein) in cases {
        let (veins, evidence) = seen(&painted(600, blade, vein));
        assert!(evidence.suffices(), "{evidence:?}");
        let tip = |v: &&Vein| v.points[v.points.len() - 1].y > 95e-3;
        assert!(veins.iter().filter(|v| v.order <= score::MAJOR).any(|v| tip(&v)));
        assert_eq!(veins[0].order, 1);
        // The painted secondaries end 95 units aside and 155 or 225 up, of 260 on a blade 100 mm long.
        for (x, y) in [(-95.0, 155.0), (95.0, 155.0), (-95.0, 225.0), (95.0, 225.0)] {
            let end = DVec2::new(x, y) * (0.1 / 260.0);
            let near = |v: &Vein| (v.points[v.points.len() - 1] - end).norm() < 8e-3;
            assert!(veins.iter().any(near), "{end}");
        }
        // Painted 4 of 260 units wide on a blade 100 mm long; two cells of the grid that veins are sought on are 0.44 mm.
        assert!((veins[0].width * 1e3 - 1.54).abs() < 0.44, "{}", veins[0].width);
    }
}

#[test]
fn a_leaf_without_veins_and_a_silhouette_show_none() {
    let plain = [40, 90, 30, 255];
    assert!(!seen(&painted(400, plain, plain)).1.suffices());
    let mut silhouette = painted(400, plain, plain);
    silhouette.pixels.iter_mut().filter(|p| **p != PAPER).for_each(|p| *p = [0, 0, 0, 255]);
    let (veins, evidence) = seen(&silhouette);
    assert!(veins.is_empty() && evidence.even > 0.9, "{evidence:?}");
}

#[test]
fn the_same_veins_are_seen_in_a_picture_of_half_the_size() {
    let (blade, vein) = ([40, 90, 30, 255], [120, 150, 80, 255]);
    let (whole, half) = (seen(&painted(1200, blade, vein)).0, seen(&painted(600, blade, vein)).0);
    // Grain may show in one and not in the other, but the painted veins show in both.
    let ends = |veins: &[Vein]| -> Vec<DVec2> {
        let long = veins.iter().filter(|v| v.order <= score::MAJOR).map(|v| v.points[v.points.len() - 1]);
        long.filter(|p| p.y > 50e-3).collect()
    };
    let (whole, half) = (ends(&whole), ends(&half));
    let met = whole.iter().filter(|a| half.iter().any(|b| (*a - b).norm() < 4e-3)).count();
    assert!(met >= 5, "{whole:?} {half:?}");
}

#[test]
fn tiny_pictures_do_no_harm() {
    for side in [24, 30, 48, 75] {
        let picture = painted(side, [40, 90, 30, 255], [120, 150, 80, 255]);
        if let Ok(trace) = trace(&Settings::default(), &picture, &Limits::default()) {
            let (veins, evidence) = scanned(&picture, &trace);
            assert!(evidence.gain.is_finite() && veins.iter().all(|v| v.points.len() >= 2 && v.width > 0.0));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn odd_blades_do_no_harm(
        rays in 0.0f64..12.0, depth in 0.0f64..0.95, count in 12u32..300, shift in -0.05f64..0.05, squeeze in 0.05f64..1.0,
    ) {
        let radius = |a: f64| 0.04 * (1.0 - depth + depth * cos(rays * (a - FRAC_PI_2)));
        let point = |i: u32| {
            let a = TAU * f64::from(i) / f64::from(count);
            let (sine, cosine) = sincos(a);
            DVec2::new(cosine * squeeze, sine) * radius(a) + DVec2::new(0.0, shift)
        };
        let outline: Vec<DVec2> = (0..count).map(point).collect();
        for venation in [Venation::Auto, Venation::Pinnate, Venation::Forking] {
            let veins = grown(&outline, venation);
            prop_assert!(veins.iter().all(|v| v.points.len() >= 2 && v.points.iter().all(|p| p.x.is_finite() && p.y.is_finite())));
            prop_assert_eq!(&veins, &grown(&outline, venation));
        }
        let area = polygon::doubled_area(&outline);
        let mesh = crate::base::flat_mesh::FlatMesh { uv_scale: 6.0, uv_origin: DVec2::new(0.5, 0.5), ..Default::default() };
        let drawn = mask::drawn(&mesh, &outline, &[], &grown(&outline, Venation::Auto), &mask::Mask::default());
        prop_assert!(area <= 1e-5 || drawn.pixels.iter().any(|p| p[0] > 0));
    }
}
