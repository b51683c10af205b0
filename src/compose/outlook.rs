//! What of the ground a camera looks out on, as far as what grows there is laid before it.

use std::f64::consts::TAU;

/// Eyes above this look down on a meadow and see none of its blades, metres.
const HIGH: f64 = 12.0;

/// Where a camera stands and looks, seen from above.
pub(super) struct Outlook {
    /// The eye, metres.
    pub eye: [f64; 3],
    /// Direction of the axis from -z towards x, radians.
    heading: f64,
    /// How far to each side the picture shows, radians.
    half_width: f64,
}

impl Outlook {
    /// That of an eye, the axis of its picture and half its width, radians.
    pub(super) fn new(eye: [f64; 3], axis: [f64; 3], half_width: f64) -> Self {
        Self { eye, heading: libm::atan2(axis[0], -axis[2]), half_width }
    }

    /// The squares of a lattice of this side about the eye, to `reach` from it (metres), by column and row; none below an eye
    /// that is high.
    pub(super) fn squares(&self, side: f64, reach: f64) -> impl Iterator<Item = (i64, i64)> + use<> {
        let reach = if self.eye[1] > HIGH { -1 } else { (reach / side) as i64 };
        let [column, row] = [self.eye[0], self.eye[2]].map(|place| (place / side).floor() as i64);
        (row - reach..=row + reach).flat_map(move |z| (column - reach..=column + reach).map(move |x| (x, z)))
    }

    /// How far a place (x, z) lies from the eye along the ground, metres, if the picture may show what stands within `margin`
    /// of it.
    pub(super) fn distance(&self, [x, z]: [f64; 2], margin: f64) -> Option<f64> {
        let (across, along) = (x - self.eye[0], z - self.eye[2]);
        let distance = libm::hypot(across, along);
        let aside = libm::atan2(across, -along) - self.heading;
        let off = (aside - TAU * (aside / TAU).round()).abs();
        let is_seen = distance <= margin || off < self.half_width + libm::asin(margin / distance);
        is_seen.then_some(distance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_within_the_width_is_seen_and_a_margin_beside_it() {
        let outlook = Outlook::new([1.0, 1.6, 20.0], [0.0, 0.0, -1.0], 0.5);
        let at = |angle: f64| [1.0 + 10.0 * libm::sin(angle), 20.0 - 10.0 * libm::cos(angle)];
        for angle in [-0.49, 0.0, 0.49] {
            assert!((outlook.distance(at(angle), 0.0).unwrap() - 10.0).abs() < 1e-9);
        }
        assert_eq!(outlook.distance(at(0.55), 0.0), None);
        assert!(outlook.distance(at(0.55), 1.0).is_some());
        // Behind, on either side of the turn.
        assert_eq!([3.1, -3.1].map(|angle| outlook.distance(at(angle), 1.0)), [None, None]);
    }

    #[test]
    fn squares_lie_about_the_eye_unless_it_is_high() {
        let squares = |height: f64| Outlook::new([-3.0, height, 5.0], [0.0, 0.0, -1.0], 0.5).squares(2.0, 5.0).count();
        assert_eq!((squares(1.6), squares(40.0)), (25, 0));
    }
}
