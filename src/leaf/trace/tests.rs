use super::*;
use crate::base::maths::{cos, sincos};
use crate::leaf::spline::Spline;
use proptest::prelude::*;

#[test]
fn a_pose_goes_there_and_back() {
    let axis = DVec2::new(0.6, -0.8);
    let pose = Pose { joint: DVec2::new(100.0, 200.0), axis, scale: 0.001 };
    let p = DVec2::new(0.01, 0.03);
    assert!((pose.plane(pose.pixel(p)) - p).norm() < 1e-15);
    assert!((pose.plane(pose.joint + axis * 10.0) - DVec2::new(0.0, 0.01)).norm() < 1e-15);
}

#[test]
fn an_upright_leaf_is_not_mirrored() {
    let pose = Pose { joint: DVec2::zeros(), axis: DVec2::new(0.0, -1.0), scale: 1.0 };
    assert!((pose.plane(DVec2::new(1.0, 0.0)) - DVec2::new(1.0, 0.0)).norm() < 1e-15);
}

const SIDE: u32 = 300;
const PAPER: [f64; 3] = [236.0, 232.0, 222.0];
const GREEN: [f64; 3] = [80.0, 120.0, 50.0];

/// A lobed leaf round a centre, its joint below; pixels.
fn lobed(centre: DVec2, radius: f64) -> Vec<[f64; 2]> {
    let point = |i: u32| {
        let angle = std::f64::consts::TAU * f64::from(i) / 720.0;
        let (sine, cosine) = sincos(angle);
        let reach = radius * (1.0 + 0.2 * cos(5.0 * angle));
        [centre.x + reach * sine, centre.y - reach * cosine]
    };
    (0..720).map(point).collect()
}

/// Share of each pixel that lies in a polygon, by 4 x 4 samples.
fn coverage(polygon: &[[f64; 2]], side: u32) -> Vec<f64> {
    let mut shares = vec![0.0; (side * side) as usize];
    for row in 0..4 * side {
        let turns = windings(polygon, (f64::from(row) + 0.5) / 4.0);
        for column in 0..4 * side {
            let x = (f64::from(column) + 0.5) / 4.0;
            let winding: i32 = turns.iter().filter(|turn| turn.0 <= x).map(|turn| turn.1).sum();
            shares[(row / 4 * side + column / 4) as usize] += if winding == 0 { 0.0 } else { 1.0 / 16.0 };
        }
    }
    shares
}

/// A leaf of one colour laid over paper given for each pixel.
fn painted(shares: &[f64], side: u32, colour: [f64; 3], paper: impl Fn(u32, u32) -> [f64; 3]) -> Picture {
    let mut picture = Picture::filled(side, side, [255; 4]);
    for (i, share) in shares.iter().enumerate() {
        let under = paper(i as u32 % side, i as u32 / side);
        let code = |c: usize| (colour[c] * share + under[c] * (1.0 - share)).clamp(0.0, 255.0) as u8;
        picture.pixels[i] = [code(0), code(1), code(2), 255];
    }
    picture
}

fn trace_of(picture: &Picture) -> Result<Trace, LeafError> {
    traced(picture, (0.1, None), None, 1.1)
}

fn message(picture: &Picture) -> String {
    trace_of(picture).map_or_else(|error| error.to_string(), |_| "traced".to_owned())
}

fn middle() -> DVec2 {
    DVec2::repeat(f64::from(SIDE) / 2.0)
}

#[test]
fn papers_and_shadows_do_not_move_the_margin() {
    let truth = lobed(middle(), 90.0);
    let shares = coverage(&truth, SIDE);
    let shaded = coverage(&lobed(middle() + DVec2::new(9.0, 7.0), 90.0), SIDE);
    let scaled = |colour: [f64; 3], light: f64| colour.map(|c| c * light);
    let pictures = [
        ("plain", painted(&shares, SIDE, GREEN, |_, _| PAPER)),
        ("falling light", painted(&shares, SIDE, GREEN, |x, _| scaled(PAPER, 0.6 + 0.4 * f64::from(x) / 300.0))),
        ("blue paper", painted(&shares, SIDE, GREEN, |_, _| [70.0, 130.0, 210.0])),
        (
            "ruled",
            painted(&shares, SIDE, GREEN, |x, y| if y % 24 < 2 || x == 40 { [120.0, 160.0, 220.0] } else { PAPER }),
        ),
        ("shadow", painted(&shares, SIDE, GREEN, |x, y| scaled(PAPER, 1.0 - 0.5 * shaded[(y * SIDE + x) as usize]))),
        ("grey", painted(&shares, SIDE, [60.0; 3], |_, _| [225.0; 3])),
        ("pale on dark", painted(&shares, SIDE, [240.0, 220.0, 60.0], |_, _| [25.0; 3])),
    ];
    for (name, picture) in pictures {
        let trace = trace_of(&picture).unwrap();
        let iou = trace.iou(&truth);
        assert!(iou > 0.985, "{name}: {iou}");
        assert_eq!((trace.gaps, trace.others, trace.petiole.is_some()), (0, 0, false), "{name}");
        assert!(trace.hausdorff <= 1.0, "{name}: {}", trace.hausdorff);
    }
}

#[test]
fn the_largest_leaf_is_taken_and_the_others_are_counted() {
    let truth = lobed(DVec2::new(190.0, 190.0), 75.0);
    let mut shares = coverage(&truth, SIDE);
    for (radius, x) in [(40.0, 60.0), (8.0, 150.0)] {
        let other = coverage(&lobed(DVec2::new(x, 50.0), radius), SIDE);
        shares.iter_mut().zip(other).for_each(|(share, more)| *share = (*share + more).min(1.0));
    }
    let trace = trace_of(&painted(&shares, SIDE, GREEN, |_, _| PAPER)).unwrap();
    assert_eq!(trace.others, 1, "a speck is no leaf");
    assert!(trace.iou(&truth) > 0.985);
}

#[test]
fn a_gap_is_kept_with_its_rim_the_other_way_round() {
    let mut shares = coverage(&lobed(middle(), 90.0), SIDE);
    let gap = coverage(&lobed(DVec2::new(150.0, 130.0), 12.0), SIDE);
    let speck = coverage(&lobed(DVec2::new(150.0, 180.0), 2.5), SIDE);
    shares.iter_mut().zip(gap.iter().zip(&speck)).for_each(|(share, (gap, speck))| *share -= gap + speck);
    let trace = trace_of(&painted(&shares, SIDE, GREEN, |_, _| PAPER)).unwrap();
    assert_eq!((trace.gaps, trace.filled), (1, 1));
    assert_eq!((trace.holes.len(), trace.hole_keys.len()), (1, 1));
    assert!(polygon::doubled_area(&trace.outline) < 0.0 && polygon::doubled_area(&trace.keys) < 0.0);
    let area = gap.iter().sum::<f64>();
    assert!((polygon::doubled_area(&trace.holes[0]) / 2.0 / area - 1.0).abs() < 0.05);
    let open: f64 = shares.iter().sum::<f64>() + speck.iter().sum::<f64>();
    assert!((trace.area() as f64 / open - 1.0).abs() < 0.01);
}

#[test]
fn a_petiole_is_cut_and_its_line_and_width_are_known() {
    let truth = lobed(middle(), 80.0);
    let mut shares = coverage(&truth, SIDE);
    // from the notch of the lower lobes down to the border, 7 px wide
    let strip = [[146.5, 205.0], [153.5, 205.0], [153.5, 300.0], [146.5, 300.0]];
    shares.iter_mut().zip(coverage(&strip, SIDE)).for_each(|(share, more)| *share = share.max(more));
    let trace = trace_of(&painted(&shares, SIDE, GREEN, |_, _| PAPER)).unwrap();
    let petiole = trace.petiole.as_ref().unwrap();
    assert!(trace.iou(&truth) > 0.98);
    // the notch lies at 150 + 80 x 0.8
    assert!((trace.pose.joint - DVec2::new(150.0, 214.0)).norm() < 5.0, "{}", trace.pose.joint);
    assert!((petiole.length() - 82.0).abs() < 8.0, "{}", petiole.length());
    assert!(petiole.line.iter().all(|p| (p.x - 150.0).abs() < 1.0));
    assert!(petiole.line.windows(2).all(|w| w[1].y > w[0].y), "from the joint outward");
    let inner = &petiole.widths[2..petiole.widths.len() - 2];
    assert!(inner.iter().all(|w| (w - 7.0).abs() <= 1.0), "{inner:?}");
    assert!(trace.pose.axis.y < -0.99);
}

#[test]
fn a_leaf_that_the_border_cuts_is_refused_by_its_side() {
    for (x, y, side) in [(60.0, 150.0, "left"), (240.0, 150.0, "right"), (150.0, 40.0, "top"), (150.0, 255.0, "bottom")]
    {
        let shares = coverage(&lobed(DVec2::new(x, y), 90.0), SIDE);
        let scan = painted(&shares, SIDE, GREEN, |_, _| PAPER);
        assert!(message(&scan).contains(&format!("{side} border")), "{}", message(&scan));
        let mut cut_out = scan;
        cut_out.pixels.iter_mut().zip(&shares).for_each(|(pixel, share)| pixel[3] = (share * 255.0) as u8);
        assert!(message(&cut_out).contains(&format!("{side} border")), "{}", message(&cut_out));
    }
}

#[test]
fn what_cannot_be_traced_is_told_with_what_to_do() {
    let told = |width: u32, height: u32, pixel: [u8; 4]| message(&Picture::filled(width, height, pixel));
    assert!(told(1, 1, [9, 9, 9, 255]).contains("at least 16"));
    assert!(told(3, 1000, [9, 9, 9, 255]).contains("3 x 1000"));
    assert!(told(64, 64, [9, 200, 9, 255]).contains("lay the leaf on paper"));
    assert!(told(64, 64, [9, 200, 9, 0]).contains("lay it flat"));
    let mut board = Picture::filled(64, 64, [255; 4]);
    (0..64 * 64).filter(|i| (i + i / 64) % 2 == 0).for_each(|i| board.pixels[i] = [0, 0, 0, 255]);
    assert_ne!(message(&board), "traced");
}

#[test]
fn the_spline_through_millimetres_is_the_one_through_pixels() {
    let shares = coverage(&lobed(middle(), 90.0), SIDE);
    let trace = trace_of(&painted(&shares, SIDE, GREEN, |_, _| PAPER)).unwrap();
    let corner = 1.1;
    let pixels = Spline::through(&trace.keys, corner);
    let plane: Vec<DVec2> = trace.outline_millimetres().into_iter().map(|p| DVec2::from(p) * 1e-3).collect();
    let metres = Spline::through(&plane, corner);
    for key in 0..trace.keys.len() {
        assert_eq!(pixels.is_corner(key), metres.is_corner(key));
        let apart = trace.pose.pixel(metres.at(key, 0.5)) - pixels.at(key, 0.5);
        assert!(apart.norm() < 1e-9, "{apart}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_picture_panics(
        width in 1u32..90,
        height in 1u32..90,
        grain in 1u32..30,
        clear in any::<bool>(),
        seed in any::<u32>(),
    ) {
        let noise = |x: u32, y: u32, c: u32| {
            let mixed = (x / grain * 73 + y / grain * 151 + c * 31).wrapping_mul(2_654_435_761) ^ seed;
            (mixed.wrapping_mul(2_246_822_519) >> 24) as u8
        };
        let mut picture = Picture::filled(width, height, [0, 0, 0, 255]);
        for i in 0..width * height {
            let (x, y) = (i % width, i / width);
            let alpha = if clear { noise(x, y, 3) } else { 255 };
            picture.pixels[i as usize] = [noise(x, y, 0), noise(x, y, 1), noise(x, y, 2), alpha];
        }
        match trace_of(&picture) {
            Ok(trace) => prop_assert!(trace.hausdorff.is_finite() && trace.keys.len() >= 3),
            Err(LeafError::Picture { what }) => prop_assert!(what.contains(';'), "no way to mend: {}", what),
            Err(other) => prop_assert!(false, "{}", other),
        }
    }
}
