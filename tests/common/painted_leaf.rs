//! A leaf with a known outline, painted on paper: what scans are tested with where there is none to ship.

use leafseason::base::maths::{cos, sincos};
use leafseason::base::picture::Picture;

/// Places are of a scan of this many pixels along a side.
const SIDE: f64 = 640.0;
const JOINT: [f64; 2] = [300.0, 470.0];
const LENGTH: f64 = 400.0;

/// How the scan is taken.
#[derive(Clone, Copy)]
pub struct Scan {
    /// Pixels along a side.
    pub side: u32,
    /// A gap is seen through the blade.
    pub hole: bool,
    /// Another, smaller leaf lies on the sheet.
    pub second: bool,
    /// How far the leaf is moved to the right, 640ths of the side.
    pub shift: f64,
}

impl Default for Scan {
    fn default() -> Self {
        Self { side: 640, hole: false, second: false, shift: 0.0 }
    }
}

/// The outline: five lobes with teeth about a point above the joint, counter-clockwise in the picture's pixels.
pub fn outline(scan: Scan) -> Vec<[f64; 2]> {
    let point = |i: u32| {
        let angle = std::f64::consts::TAU * f64::from(i) / 1440.0;
        let lobes = 0.70 + 0.24 * cos(5.0 * angle) + 0.035 * cos(35.0 * angle);
        let (sine, cosine) = sincos(angle);
        let radius = 0.5 * LENGTH * lobes;
        let unit = f64::from(scan.side) / SIDE;
        let place = [JOINT[0] + scan.shift + radius * sine, JOINT[1] - 0.47 * LENGTH * 0.5 - radius * cosine];
        place.map(|x| x * unit)
    };
    (0..1440).map(point).collect()
}

fn inside(line: &[[f64; 2]], x: f64, y: f64) -> bool {
    let crosses = |(i, a): (usize, &[f64; 2])| {
        let b = line[(i + 1) % line.len()];
        (a[1] > y) != (b[1] > y) && x < a[0] + (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1])
    };
    line.iter().enumerate().filter(|one| crosses(*one)).count() % 2 == 1
}

/// The scan: cream paper that is darker on one side, a green blade with pale main veins, a stalk of 5 pixels.
pub fn painted(scan: Scan) -> Picture {
    let line = outline(Scan { side: SIDE as u32, ..scan });
    let (side, unit) = (scan.side, SIDE / f64::from(scan.side));
    let centre = [JOINT[0] + scan.shift, JOINT[1] - 0.47 * LENGTH * 0.5];
    let colour = |x: f64, y: f64| -> [f64; 3] {
        let shade = 1.0 - 0.1 * x / SIDE;
        let paper = [238.0 * shade, 230.0 * shade, 214.0 * shade];
        let (dx, dy) = (x - centre[0], y - centre[1]);
        if scan.hole && (dx - 14.0) * (dx - 14.0) / 400.0 + (dy + 85.0) * (dy + 85.0) / 900.0 < 1.0 {
            return paper;
        }
        if inside(&line, x, y) {
            let vein = (0..5).any(|lobe| {
                let (sine, cosine) = sincos(std::f64::consts::TAU * f64::from(lobe) / 5.0);
                let (along, across) = (dx * sine - dy * cosine, dx * cosine + dy * sine);
                along > 0.0 && along < 0.42 * LENGTH && across.abs() < 3.0 - along * 0.012
            });
            return if vein { [150.0, 175.0, 95.0] } else { [70.0, 120.0, 45.0] };
        }
        let stalk = dx.abs() < 2.5 && dy > 0.0 && dy < 0.62 * LENGTH;
        let second = scan.second && (x - 560.0) * (x - 560.0) / 1600.0 + (y - 90.0) * (y - 90.0) / 3600.0 < 1.0;
        if stalk || second { [110.0, 100.0, 50.0] } else { paper }
    };
    let pixel = |i: u32| {
        let mut sum = [0.0; 3];
        for tap in 0..4 {
            let place = |cell: u32, tap: u32| (f64::from(cell) + 0.25 + 0.5 * f64::from(tap)) * unit;
            let c = colour(place(i % side, tap % 2), place(i / side, tap / 2));
            sum.iter_mut().zip(c).for_each(|(total, c)| *total += c / 4.0);
        }
        let [r, g, b] = sum.map(|c| (c + 0.5) as u8);
        [r, g, b, 255]
    };
    Picture { width: side, height: side, pixels: (0..side * side).map(pixel).collect() }
}
