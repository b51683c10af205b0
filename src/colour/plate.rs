//! The leaf as a pile of plates: PROSPECT-D, from contents to the share of light reflected and transmitted at one wavelength.
//!
//! Sources: Allen, Gausman, Richardson and Thomas 1969 and Allen, Gausman and Richardson 1973 (a plate and a pile of N
//! plates), Stern 1964 (mean transmittance of a face), Stokes 1862 (the pile in closed form), Feret et al. 2017
//! (pigments). Not a model of single cells, and not of scattering towards a direction: both faces are taken as diffuse.

use super::Pigments;
use super::exponential_integral::exponential_integral;
use super::spectrum::Wavelength;
use crate::base::maths::{exp, ln, pow, sin};

/// Half angle of the cone in which light reaches the upper face, radians (40 degrees, Feret et al.).
const ENTRY_ANGLE: f64 = 0.698_131_700_797_731_8;
/// A plate that keeps less than this share of the light is taken as lossless: Stokes' form divides by the loss.
const LOSSLESS: f64 = 1e-12;

/// What the two kinds of faces let through at one wavelength.
#[derive(Clone, Copy, Debug)]
pub(super) struct Faces {
    /// Transmittance of the upper face for light from the entry cone.
    pub entry: f64,
    /// Transmittance into leaf material for diffuse light.
    inward: f64,
    /// Transmittance out of leaf material for diffuse light.
    outward: f64,
}

impl Faces {
    pub(super) fn new(index: f64) -> Self {
        let inward = face_transmittance(sin(ENTRY_ANGLE), index, false);
        let diffuse = face_transmittance(1.0, index, true);
        Self { entry: inward, inward: diffuse, outward: diffuse / (index * index) }
    }
}

/// Mean Fresnel transmittance of a smooth face for unpolarised light from a cone whose half angle has the given sine
/// (Stern 1964 in the form of Allen 1973). `index` is above 1.
fn face_transmittance(sine: f64, index: f64, hemisphere: bool) -> f64 {
    let square = index * index;
    let (plus, minus) = (square + 1.0, square - 1.0);
    let (plus3, minus2) = (plus * plus * plus, minus * minus);
    let a = 0.5 * (index + 1.0) * (index + 1.0);
    let k = -0.25 * minus2;
    let sine2 = sine * sine;
    let b2 = sine2 - 0.5 * plus;
    // At 90 degrees b1 vanishes; computed, it would be the root of a rounding error.
    let b1 = if hemisphere { 0.0 } else { (b2 * b2 + k).max(0.0).sqrt() };
    let b = b1 - b2;
    let across = |x: f64| k * k / (6.0 * x * x * x) + k / x - 0.5 * x;
    let perpendicular = across(b) - across(a);
    let (along_b, along_a) = (2.0 * plus * b - minus2, 2.0 * plus * a - minus2);
    let parallel = -2.0 * square * (b - a) / (plus * plus) - 2.0 * square * plus * ln(b / a) / minus2
        + 0.5 * square * (1.0 / b - 1.0 / a)
        + 16.0 * square * square * (square * square + 1.0) * ln(along_b / along_a) / (plus3 * minus2)
        + 16.0 * square * square * square * (1.0 / along_b - 1.0 / along_a) / plus3;
    (perpendicular + parallel) / (2.0 * sine2)
}

/// Share of diffuse light that crosses a layer of optical depth `depth` without being absorbed.
fn layer_transmittance(depth: f64) -> f64 {
    if depth <= 0.0 {
        return 1.0;
    }
    ((1.0 - depth) * exp(-depth) + depth * depth * exponential_integral(depth)).clamp(0.0, 1.0)
}

/// A share of light sent back and a share let through.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shares {
    pub reflected: f64,
    pub transmitted: f64,
}

/// A plate whose upper face lets in `entry` of the light.
fn plate(faces: &Faces, entry: f64, layer: f64) -> Shares {
    let inside = 1.0 - faces.outward;
    let around = inside * layer;
    let transmitted = entry * layer * faces.outward / (1.0 - around * around);
    Shares { reflected: 1.0 - entry + around * transmitted, transmitted }
}

/// A pile of `count` plates (0 or more, not only whole numbers), by Stokes' closed form, written with the inverse of his
/// b so that a black plate needs no case of its own.
fn pile(one: Shares, count: f64) -> Shares {
    let (r, t) = (one.reflected, one.transmitted);
    if r + t >= 1.0 - LOSSLESS {
        let transmitted = t / (t + (1.0 - t) * count);
        return Shares { reflected: 1.0 - transmitted, transmitted };
    }
    let root = ((1.0 + r + t) * (1.0 + r - t) * (1.0 - r + t) * (1.0 - r - t)).sqrt();
    let a = (1.0 + r * r - t * t + root) / (2.0 * r);
    let fading = pow(2.0 * t / (1.0 - r * r + t * t + root), count);
    let (a2, fading2) = (a * a, fading * fading);
    let below = a2 - fading2;
    Shares { reflected: a * (1.0 - fading2) / below, transmitted: fading * (a2 - 1.0) / below }
}

/// Optical depth of a whole leaf at one wavelength: the sum of what each content absorbs.
pub(super) fn depth(wavelength: &Wavelength, pigments: &Pigments) -> f64 {
    let [chlorophyll, carotenoids, anthocyanins, brown, water, dry_matter] = wavelength.absorption;
    pigments.chlorophyll * chlorophyll
        + pigments.carotenoids * carotenoids
        + pigments.anthocyanins * anthocyanins
        + pigments.brown * brown
        + pigments.water * water
        + pigments.dry_matter * dry_matter
}

/// Shares of the light that a leaf reflects and transmits at one wavelength.
pub(super) fn leaf(wavelength: &Wavelength, faces: &Faces, pigments: &Pigments) -> Shares {
    leaf_of_depth(faces, depth(wavelength, pigments), pigments.structure)
}

/// The same for a leaf of `structure` plates and an optical depth.
pub(super) fn leaf_of_depth(faces: &Faces, depth: f64, structure: f64) -> Shares {
    let layer = layer_transmittance(depth / structure);
    let first = plate(faces, faces.entry, layer);
    let further = plate(faces, faces.inward, layer);
    let rest = pile(further, structure - 1.0);
    let between = 1.0 - rest.reflected * further.reflected;
    Shares {
        reflected: first.reflected + first.transmitted * rest.reflected * further.transmitted / between,
        transmitted: first.transmitted * rest.transmitted / between,
    }
}

#[cfg(test)]
mod tests {
    use super::super::spectrum::WAVELENGTHS;
    use super::*;
    use proptest::prelude::*;

    fn contents(values: [f64; 7]) -> Pigments {
        let [structure, chlorophyll, carotenoids, anthocyanins, brown, water, dry_matter] = values;
        Pigments { structure, chlorophyll, carotenoids, anthocyanins, brown, water, dry_matter }
    }

    fn shares(values: [f64; 7]) -> Vec<Shares> {
        let pigments = contents(values);
        WAVELENGTHS.iter().map(|w| leaf(w, &Faces::new(w.index), &pigments)).collect()
    }

    #[test]
    fn an_empty_leaf_loses_no_light() {
        for structure in [1.0, 1.5, 4.0] {
            for s in shares([structure, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]) {
                assert!((s.reflected + s.transmitted - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_black_leaf_keeps_only_its_surface_reflection() {
        for structure in [1.0, 2.5] {
            let pigments = contents([structure, 1e9, 1e9, 0.0, 0.0, 0.0, 0.0]);
            let first = &WAVELENGTHS[0];
            let faces = Faces::new(first.index);
            let black = leaf(first, &faces, &pigments);
            assert!((black.reflected - (1.0 - faces.entry)).abs() < 1e-12 && black.transmitted == 0.0);
        }
    }

    #[test]
    fn diffuse_light_meets_the_same_face_both_ways() {
        // Face transmittance at a right angle tends to Fresnel's 4n/(n+1)^2.
        let n = 1.5;
        assert!((face_transmittance(1e-3, n, false) - 4.0 * n / ((n + 1.0) * (n + 1.0))).abs() < 1e-6);
    }

    #[test]
    fn two_plates_follow_from_one_by_adding_their_echoes() {
        let one = Shares { reflected: 0.3, transmitted: 0.5 };
        let echo = 1.0 - 0.3 * 0.3;
        let two = pile(one, 2.0);
        assert!((two.transmitted - 0.25 / echo).abs() < 1e-14);
        assert!((two.reflected - (0.3 + 0.25 * 0.3 / echo)).abs() < 1e-14);
    }

    proptest! {
        #[test]
        fn no_leaf_makes_light(values in [1.0..4.0, 0.0..200.0, 0.0..60.0, 0.0..100.0, 0.0..10.0, 0.0..0.2, 0.0..0.1]) {
            for s in shares(values) {
                prop_assert!(s.reflected > 0.0 && s.transmitted >= 0.0);
                prop_assert!(s.reflected + s.transmitted <= 1.0 + 1e-12);
            }
        }

        #[test]
        fn more_pigment_never_brightens(chlorophyll in 0.0..100.0, more in 0.1..50.0) {
            let less = shares([1.5, chlorophyll, 5.0, 1.0, 0.1, 0.01, 0.005]);
            let more = shares([1.5, chlorophyll + more, 5.0, 1.0, 0.1, 0.01, 0.005]);
            for (less, more) in less.iter().zip(&more) {
                prop_assert!(more.reflected <= less.reflected + 1e-14);
                prop_assert!(more.transmitted <= less.transmitted + 1e-14);
            }
        }
    }
}
