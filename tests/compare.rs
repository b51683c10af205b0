//! The comparison of pictures against values of the reference implementation of FLIP (the Python package `flip-evaluator`
//! 1.7, `evaluate(reference, test, "LDR")` at its default of 67.02 pixels a degree), on pictures that both can compute.

use leafseason::base::picture::Picture;
use leafseason::compare::compare;

/// A picture of integer formulas.
fn picture(width: u32, height: u32, colour: impl Fn(u32, u32) -> [u32; 3]) -> Picture {
    let pixel = |x, y| {
        let [r, g, b] = colour(x, y).map(|v| (v % 256) as u8);
        [r, g, b, 255]
    };
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| pixel(x, y)).collect();
    Picture { width, height, pixels }
}

fn pattern() -> Picture {
    picture(96, 64, |x, y| [x * 2 + y, x * y / 7, (x / 8 + y / 8) % 2 * 150 + 40])
}

#[test]
fn flip_agrees_with_the_reference_implementation() {
    let shifted = picture(96, 64, |x, y| [x * 2 + y, (x + 1) * y / 7, (x / 8 + y / 8) % 2 * 140 + 40]);
    let dark = picture(96, 64, |x, y| [(x * 2 + y) % 256 / 2, x * y / 7 % 256 / 2, (x / 8 + y / 8) % 2 * 75 + 20]);
    let noisy = picture(96, 64, |x, y| {
        let n = (x * 7919 + y * 104_729) % 31;
        [(x * 2 + y) % 256 * 8 / 10 + n, x * y / 7 % 256 * 8 / 10 + n, (x / 8 + y / 8) % 2 * 150 + 40 + n]
    });
    for (other, reference) in [(shifted, REFERENCE[0]), (dark, REFERENCE[1]), (noisy, REFERENCE[2])] {
        let found = compare(&pattern(), &other).unwrap().flip;
        assert!((found - reference).abs() < 1e-3, "{found} {reference}");
    }
}

/// Mean errors that the reference implementation returns, in single precision.
const REFERENCE: [f64; 3] = [0.198_385_97, 0.786_249_34, 0.386_027_43];

#[test]
fn the_figures_go_into_json() {
    let json = serde_json::to_value(compare(&pattern(), &pattern()).unwrap()).unwrap();
    assert_eq!(json, serde_json::json!({"max_difference": 0, "differing_pixels": 0, "rmse": 0.0, "flip": 0.0}));
}

#[test]
fn the_order_of_the_pictures_does_not_matter() {
    let other = picture(96, 64, |x, y| [x * 3, y * 3, x + y]);
    assert_eq!(compare(&pattern(), &other), compare(&other, &pattern()));
}
