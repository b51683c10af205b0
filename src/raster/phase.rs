//! How leaves and blades that lie all ways scatter light once.

use crate::base::maths::acosf;
use crate::base::vector::Vec3;
use std::f32::consts::PI;

/// The phase functions of reflection and of transmission of leaves that lie all ways (Ross 1981, spherical leaf angles), each times
/// 3 pi / 8: of light from the unit direction `sun` that is seen along the unit direction `ray`. Sent back, they are pi and 0;
/// going on, 0 and pi.
pub(super) fn phase(sun: Vec3, ray: Vec3) -> [f32; 2] {
    // The angle between the ways that light comes and goes: 0 for light that goes on, pi for light sent back.
    let cosine = -sun.dot(&ray).clamp(-1.0, 1.0);
    let angle = PI - acosf(cosine);
    let sine = (1.0 - cosine * cosine).sqrt();
    [sine + angle * cosine, sine - (PI - angle) * cosine]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_sent_back_is_reflected_and_light_that_goes_on_has_come_through() {
        let near = |[a, b]: [f32; 2], [x, y]: [f32; 2]| (a - x).abs() < 1e-5 && (b - y).abs() < 1e-5;
        let sun = Vec3::new(0.6, 0.8, 0.0);
        assert!(near(phase(sun, -sun), [PI, 0.0]), "{:?}", phase(sun, -sun));
        assert!(near(phase(sun, sun), [0.0, PI]), "{:?}", phase(sun, sun));
        assert!(near(phase(sun, Vec3::z()), [1.0, 1.0]), "{:?}", phase(sun, Vec3::z()));
    }
}
