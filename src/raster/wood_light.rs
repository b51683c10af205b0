//! The light of the distant wood: crowns in sun and sky under the horizons of their neighbours, stems and twigs.

use super::Prepared;
use super::distant_wood::Look;
use super::phase::phase;
use crate::base::maths::{mix, smooth_step};
use crate::base::vector::Vec3;
use std::f32::consts::PI;

/// Share of the sky's light that reaches the deepest shade between crowns through other leaves (judged).
const DEEP: f32 = 0.80;
/// Reflectance of a crown over what its leaves scatter (judged; two streams in a deep layer give 0.3 for green leaves, 0.5 for
/// red ones).
const CROWN: f32 = 0.40;
/// Share of the sunlight off the crowns around that comes to one which is in their shade (judged).
const AMONG: f32 = 0.35;
/// How far around its rim sunlight creeps over a crown, whose leaves lie all ways (judged).
const AROUND: f32 = 0.15;
/// Share of single scattering that leaves a crown again from between its leaves, with what is scattered more than once (judged).
const OUT: f32 = 1.35;
/// Sine over which the edge of a crown's shadow is soft: crowns are ragged.
const SOFT: f32 = 0.36;
/// Share of the light that bare wood leaves for its stems.
const WOOD_LIGHT: f32 = 0.80;
/// Reflectances of wood, of the trees that turn last and first (linear, judged).
const BARE: [[f32; 3]; 2] = [[0.104, 0.086, 0.074], [0.142, 0.112, 0.086]];

impl Prepared<'_> {
    /// Radiance of a crown's piece with the parts of its normal to the right and up, under its horizons to the left, above and to
    /// the right: single scattering in a deep layer of leaves that lie all ways, 2 mu0 / (mu0 + mu) times their phase function
    /// (Ross 1981).
    pub(super) fn lit_crown(
        &self,
        look: &Look,
        [right, up]: [f32; 2],
        (kind, light): (f32, f32),
        horizons: [f32; 3],
    ) -> [f32; 3] {
        let (reflected, transmitted) = self.atmosphere.wood.leaves(kind);
        let towards = look.towards();
        let facing = (1.0 - right * right - up * up).max(0.06).sqrt();
        let normal = (Vec3::y().cross(&towards) * right + Vec3::y() * up + towards * facing).normalize();
        let sun = self.frame.sun.direction;
        let in_cosine = ((1.0 - AROUND) * normal.dot(&sun) + AROUND).max(0.0);
        let out_cosine = normal.dot(&towards).max(0.15);
        let [sent_back, let_through] = phase(sun, look.direction);
        let scattered = OUT * 2.0 * in_cosine / (in_cosine + out_cosine) / PI * light;
        let scattered = scattered * self.sunlit(towards, horizons);
        let disc = self.frame.sun.irradiance.map(|e| e * self.atmosphere.sun_share());
        let ambient = self.atmosphere.open.irradiance(normal);
        let open = light * seen_sky(horizons);
        let albedo: [f32; 3] = std::array::from_fn(|k| reflected[k] + transmitted[k]);
        let largest = albedo.into_iter().fold(1e-6, f32::max);
        std::array::from_fn(|k| {
            let of_sun = (reflected[k] * sent_back + transmitted[k] * let_through) * (disc[k] * scattered);
            // Where no sky is seen, light comes from leaves, in their colour.
            let met = ambient[k] * (open + (1.0 - open) * DEEP * albedo[k] / largest);
            let crown = CROWN * albedo[k];
            (of_sun + crown * (met + crown * (disc[k] * AMONG * light))) / PI
        })
    }

    /// Radiance of stems and twigs under the horizons of the crowns about them; they stand upright and are round.
    pub(super) fn lit_wood(&self, look: &Look, kind: f32, horizons: [f32; 3]) -> [f32; 3] {
        let towards = look.towards();
        let (sun, normal) = (self.frame.sun.direction, (towards + Vec3::y() * 0.1).normalize());
        let front = (0.75 * normal.dot(&sun) + 0.25).max(0.0) * self.atmosphere.sun_share();
        let front = front * self.sunlit(towards, horizons);
        let (ambient, open) = (self.atmosphere.open.irradiance(normal), seen_sky(horizons));
        let share = (kind * 3.7).abs().fract();
        std::array::from_fn(|k| {
            let bark = mix(BARE[0][k], BARE[1][k], share);
            bark * WOOD_LIGHT * (self.frame.sun.irradiance[k] * front + ambient[k] * open) / PI
        })
    }

    /// Share of the sun's light that comes to a place of the edge under its horizons; `towards` is level, from it to the eye.
    fn sunlit(&self, towards: Vec3, horizons: [f32; 3]) -> f32 {
        let sun = self.frame.sun.direction;
        sunlit([sun.dot(&Vec3::y().cross(&towards)), sun.y, sun.dot(&towards)], horizons)
    }
}

/// Share of the sun's light that comes to a place under its horizons; the sun's direction along the edge, up and towards the eye.
fn sunlit([along, up, towards]: [f32; 3], [left, above, right]: [f32; 3]) -> f32 {
    let aside = if along < 0.0 { left } else { right };
    let (along, up) = (along * along, up * up);
    let horizon = (aside * along + above * up) / (along + up).max(1e-6);
    // A sun from behind the wood shines through what stands alone before the sky.
    let from_behind = smooth_step(-0.05, -0.25, towards);
    let front = smooth_step(horizon - SOFT, horizon + SOFT, towards);
    mix(front, 1.0 - smooth_step(0.2, 0.8, above), from_behind)
}

/// Share of the open sky's light that comes to a place under its horizons.
fn seen_sky([left, above, right]: [f32; 3]) -> f32 {
    let free = |sine: f32| 1.0 - sine;
    0.25 * free(left) + 0.5 * free(above) + 0.25 * free(right)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_crown_in_the_open_is_lit_and_one_under_others_is_not() {
        let front = [0.3, 0.5, 0.8];
        assert_eq!(sunlit(front, [0.0; 3]), 1.0);
        assert_eq!(sunlit([0.6, 0.79, 0.1], [0.95; 3]), 0.0);
        // The horizon counts on whose side the sun stands.
        let low = [0.8, 0.2, 0.5];
        assert!(sunlit(low, [0.9, 0.0, 0.0]) > 0.9 && sunlit(low, [0.0, 0.0, 0.9]) < 0.1);
        let high = [0.2, 0.9, 0.4];
        assert!(sunlit(high, [0.9, 0.0, 0.9]) > 0.9 && sunlit(high, [0.0, 0.9, 0.0]) < 0.1);
    }

    #[test]
    fn a_sun_behind_the_wood_shines_through_its_tops_alone() {
        let behind = [0.3, 0.5, -0.8];
        assert_eq!((sunlit(behind, [0.0; 3]), sunlit(behind, [0.0, 0.8, 0.0])), (1.0, 0.0));
    }

    #[test]
    fn a_place_sees_less_of_the_sky_the_higher_others_stand() {
        assert_eq!((seen_sky([0.0; 3]), seen_sky([1.0; 3])), (1.0, 0.0));
        assert!(seen_sky([0.0, 0.5, 0.0]) < seen_sky([0.5, 0.0, 0.0]));
    }
}
