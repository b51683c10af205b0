//! How fast a leaf comes down.
//!
//! A body with quadratic drag that starts at rest has dv/dt = g (1 - (v/V)^2), hence v(t) = V tanh(g t / V) and, integrated,
//! s(t) = V^2/g ln cosh(g t / V). The inverse is t(s) = V/g arcosh(exp(g s / V^2)). All three are exact.

use crate::base::maths::{exp, expm1, log1p, tan};

/// Acceleration of free fall, m/s2.
pub(super) const GRAVITY: f64 = 9.81;
/// Density of air at 10 degrees, kg/m3.
pub(super) const AIR: f64 = 1.2;
/// Drag coefficient over the blade's area of a leaf that flutters or tumbles: that of a disc face on (1.1 to 1.2; most leaves
/// settle like discs, Biviano and Jensen 2024).
const DRAG: f64 = 1.2;
/// Slowest and fastest leaf, m/s.
const SPEEDS: [f64; 2] = [0.4, 2.5];

/// Terminal speed of a leaf, m/s, for its mass over area in g/m2: weight equals drag, V = sqrt(2 (m/A) g / (rho Cd)),
/// held between 0.4 and 2.5 m/s.
#[must_use]
pub fn terminal_speed(mass_per_area: f64) -> f64 {
    let speed = (2.0 * mass_per_area.max(0.0) * 1e-3 * GRAVITY / (AIR * DRAG)).sqrt();
    speed.clamp(SPEEDS[0], SPEEDS[1])
}

/// Froude number of a falling plate: the time to fall its own length over that to swing, for a leaf sqrt((m/A) / (rho
/// length)); strips flutter below 0.67 +- 0.05 and tumble above (Belmonte, Eisenberg and Moses 1998). `length` in metres.
#[must_use]
pub fn froude(mass_per_area: f64, length: f64) -> f64 {
    (mass_per_area.max(0.0) * 1e-3 / (AIR * length.max(1e-4))).sqrt()
}

/// A descent from rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Descent {
    /// Terminal speed, m/s.
    pub speed: f64,
}

impl Descent {
    /// Metres fallen after so many seconds.
    #[must_use]
    pub fn fallen(&self, seconds: f64) -> f64 {
        let x = GRAVITY * seconds.max(0.0) / self.speed;
        // ln cosh x = x - ln 2 + ln(1 + e^-2x); the first form keeps the digits of small x
        let ln_cosh = if x < 1e-3 {
            0.5 * x * x * (1.0 - x * x / 6.0)
        } else {
            x - std::f64::consts::LN_2 + log1p(exp(-2.0 * x))
        };
        self.speed * self.speed / GRAVITY * ln_cosh
    }

    /// Seconds until so many metres have been fallen.
    #[must_use]
    pub fn seconds(&self, metres: f64) -> f64 {
        let u = GRAVITY * metres.max(0.0) / (self.speed * self.speed);
        // arcosh(e^u) = u + ln(1 + sqrt(1 - e^-2u))
        self.speed / GRAVITY * (u + log1p((-expm1(-2.0 * u)).sqrt()))
    }

    /// Speed after so many seconds, m/s.
    #[must_use]
    pub fn speed_at(&self, seconds: f64) -> f64 {
        let e = exp(-2.0 * GRAVITY * seconds.max(0.0) / self.speed);
        self.speed * (1.0 - e) / (1.0 + e)
    }
}

/// The tangent of an angle in degrees.
pub(super) fn slope(degrees: f64) -> f64 {
    tan(degrees.to_radians())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_are_those_of_the_formula() {
        // V for 45, 60, 90 and 150 g/m2 (computed by hand from the formula).
        for (mass, speed) in [(45.0, 0.783), (60.0, 0.904), (90.0, 1.107), (150.0, 1.430)] {
            assert!((terminal_speed(mass) - speed).abs() < 1e-3, "{mass}");
        }
        assert_eq!((terminal_speed(0.0), terminal_speed(1e9)), (0.4, 2.5));
        assert!((froude(45.0, 0.08) - 0.6847).abs() < 1e-3);
    }

    #[test]
    fn the_way_is_the_integral_of_the_speed_and_its_inverse_comes_back() {
        for speed in [0.4, 1.0, 2.5] {
            let descent = Descent { speed };
            let (mut sum, step) = (0.0, 1e-3);
            for number in 0..4000 {
                sum += descent.speed_at((f64::from(number) + 0.5) * step) * step;
            }
            assert!((sum - descent.fallen(4.0)).abs() < 1e-6, "{sum}");
            for metres in [1e-9, 1e-4, 0.02, 0.5, 3.0, 40.0, 1e4] {
                let back = descent.fallen(descent.seconds(metres));
                assert!((back - metres).abs() <= 1e-7 * metres, "{metres} {back}");
            }
        }
    }

    #[test]
    fn it_starts_in_free_fall() {
        let descent = Descent { speed: 1.0 };
        assert!((descent.fallen(1e-3) - 0.5 * GRAVITY * 1e-6).abs() < 1e-9);
        assert_eq!((descent.fallen(0.0), descent.seconds(0.0), descent.fallen(-1.0)), (0.0, 0.0, 0.0));
    }
}
