//! The edge of a wood on the horizon: what closes a meadow off. Read from the unrolled edge that the frame brings, lit by
//! the frame's sun and sky, in the colours of the frame's own foliage; scenery that casts no shadow.

use super::Prepared;
use super::texture::MipMap;
use crate::base::maths::{atan2f, mix, smooth_step};
use crate::base::noise::Lattice;
use crate::base::vector::{Vec2, Vec3};
use crate::frame::{Frame, Material, Wood};
use std::f32::consts::PI;
use std::sync::Arc;

/// Share of the sky's light that reaches the deepest shade between crowns (judged).
const DEEP: f32 = 0.30;

/// How much farther a second wood stands behind the first, on rising ground.
const FAR: f32 = 3.4;
/// Height of the hills that it stands on, metres.
const HILLS: f32 = 34.0;
/// Share of a leaf's reflectance that a crown has: light is caught between its leaves (judged; canopies reflect 0.03 to 0.06
/// of green light where leaves reflect 0.1).
const CAUGHT: f32 = 1.0;
/// How much of a distant crown's colour is that of all leaves of the frame, the rest that of one state.
const SHARED: f32 = 0.55;
/// Heights that the meadow's tall grass hides of the wood's foot, metres, and how often they come around the horizon: the rise
/// and fall of the ground, thickets of herbs, single ones.
const HEM: [(f32, u32); 3] = [(0.75, 71), (0.45, 467), (0.40, 2600)];
/// Height over which the meadow's grass gives way to what stands behind, metres.
const FEATHER: f32 = 0.16;
/// Nodes around the horizon between which the trees' heights and kinds vary, so that no repeat looks like the last.
const VARIED: u32 = 89;
/// Least height of trees over that of the texture.
const LOWEST: f32 = 0.74;
/// Reflectances of bare crowns (linear, judged).
const BARE: [[f32; 3]; 2] = [[0.092, 0.081, 0.075], [0.135, 0.110, 0.090]];
/// Reflectance of conifers' crowns, and of bark (linear, judged).
const EVERGREEN: [f32; 3] = [0.064, 0.078, 0.035];
const BARK: [f32; 3] = [0.115, 0.102, 0.090];
/// Tints of the kinds of trees, on the frame's own foliage.
const TINTS: [[f32; 3]; 3] = [[0.82, 0.90, 0.84], [1.04, 1.00, 0.92], [1.30, 1.16, 0.86]];

/// Reflectance and transmittance of the crowns of a season.
#[derive(Default)]
pub(super) struct Palette {
    /// Colours with the share of the crowns that have less of a kind; ascending, the last is 1.
    kinds: Vec<(f32, [f32; 3], [f32; 3])>,
}

impl Palette {
    /// The foliage that stands in a frame.
    pub(super) fn of(frame: &Frame, textures: &[Arc<MipMap>]) -> Self {
        let mut counts = vec![0u64; frame.models.len()];
        for instance in frame.standing().iter().filter(|instance| instance.leaf.is_some()) {
            counts[instance.model as usize] += 1;
        }
        let mut by_material = vec![0u64; frame.materials.len()];
        for (model, count) in frame.models.iter().zip(counts) {
            if let Some(part) = model.parts.first() {
                by_material[part.material as usize] += count;
            }
        }
        let total: u64 = by_material.iter().sum();
        let mean = mean_of(frame, textures, &by_material);
        let mut kinds = Vec::new();
        let mut below = 0;
        for (material, count) in frame.materials.iter().zip(&by_material).filter(|(_, count)| **count > 0) {
            below += count;
            let (reflected, transmitted) = optics(material, textures);
            // A tree wears leaves of many states at once.
            let shared = |own: [f32; 3], of_all: [f32; 3]| std::array::from_fn(|k| mix(own[k], of_all[k], SHARED));
            kinds.push((below as f32 / total as f32, shared(reflected, mean.0), shared(transmitted, mean.1)));
        }
        let is_bare = frame.ground.as_ref().and_then(|ground| ground.wood).is_some_and(|wood| wood.is_bare);
        if is_bare || kinds.is_empty() {
            kinds = vec![(0.5, BARE[0], [0.0; 3]), (1.0, BARE[1], [0.0; 3])];
        }
        Self { kinds }
    }

    /// Reflectance and transmittance of what a texel shows: leaves of a kind (0..1), what stays green (-1), wood (thin -1).
    fn seen(&self, kind: f32, thin: f32) -> ([f32; 3], [f32; 3]) {
        let (mut reflected, mut transmitted) = self.at(kind.clamp(0.0, 1.0));
        let (evergreen, wood) = ((-1.5 * kind).clamp(0.0, 1.0), (-thin).clamp(0.0, 1.0));
        for k in 0..3 {
            // Of bare crowns the kind tells the colour of the twigs.
            let bark = mix(BARK[k], reflected[k], if self.kinds[0].1 == BARE[0] { 0.7 } else { 0.0 });
            reflected[k] = mix(mix(reflected[k], EVERGREEN[k], evergreen), bark, wood);
            transmitted[k] *= (1.0 - evergreen) * (1.0 - wood);
        }
        (reflected, transmitted)
    }

    /// Reflectance and transmittance of a kind of tree, 0..1.
    fn at(&self, kind: f32) -> ([f32; 3], [f32; 3]) {
        let found = self.kinds.iter().find(|(below, ..)| kind <= *below).or(self.kinds.last());
        let (_, reflected, transmitted) = found.copied().unwrap_or_default();
        let place = (kind * 7.31).fract() * (TINTS.len() - 1) as f32;
        let first = (place as usize).min(TINTS.len() - 2);
        let tint: [f32; 3] = std::array::from_fn(|k| mix(TINTS[first][k], TINTS[first + 1][k], place - first as f32));
        let tinted = |colour: [f32; 3]| std::array::from_fn(|k| colour[k] * tint[k] * CAUGHT);
        (tinted(reflected), tinted(transmitted))
    }
}

/// Reflectance and transmittance of all leaves, by how many wear each material.
fn mean_of(frame: &Frame, textures: &[Arc<MipMap>], counts: &[u64]) -> ([f32; 3], [f32; 3]) {
    let (mut sums, total) = (([0.0; 3], [0.0; 3]), counts.iter().sum::<u64>().max(1) as f32);
    for (material, &count) in frame.materials.iter().zip(counts).filter(|(_, count)| **count > 0) {
        let (reflected, transmitted) = optics(material, textures);
        for k in 0..3 {
            sums.0[k] += reflected[k] * (count as f32 / total);
            sums.1[k] += transmitted[k] * (count as f32 / total);
        }
    }
    sums
}

fn optics(material: &Material, textures: &[Arc<MipMap>]) -> ([f32; 3], [f32; 3]) {
    let mean = |factor: [f32; 3], texture: Option<u32>| -> [f32; 3] {
        let colour = texture.map_or([1.0; 3], |number| textures[number as usize].mean());
        std::array::from_fn(|k| factor[k] * colour[k])
    };
    (mean(material.colour, material.reflected), mean(material.transmission, material.transmitted))
}

/// A ray towards the horizon.
struct Look {
    direction: Vec3,
    /// Share of the way around the horizon.
    around: f32,
    /// Rise over level distance.
    slope: f32,
    /// Angle that a pixel spans.
    pixel: f32,
}

impl Prepared<'_> {
    /// What a ray shows over `behind`, which lies beyond the wood.
    pub(super) fn before_wood(&self, wood: &Wood, direction: Vec3, behind: [f32; 3]) -> [f32; 3] {
        let level = (direction.x * direction.x + direction.z * direction.z).sqrt().max(1e-6);
        let slope = direction.y / level;
        if slope * wood.distance + self.projection.eye.y > wood.height {
            return behind;
        }
        let around = atan2f(-direction.x, -direction.z) / (2.0 * PI) + 0.5;
        let look = Look { direction, around, slope, pixel: 1.0 / self.projection.pixels_per_metre };
        let near = self.row(wood, &look, [wood.distance, 1.0, 0.0]);
        if near.0 >= 0.999 {
            return near.1;
        }
        let rise = |nodes: u32| Lattice::periodic(11, [nodes, 0]).value(around * nodes as f32, 0.5);
        let hills = (0.8 * rise(17) + 0.2 * rise(61)) * HILLS;
        if slope <= 0.0 {
            return std::array::from_fn(|k| mix(behind[k], near.1[k], near.0));
        }
        let far = self.row(wood, &look, [wood.distance * FAR, 3.0, hills]);
        let beyond: [f32; 3] = std::array::from_fn(|k| mix(behind[k], far.1[k], far.0));
        std::array::from_fn(|k| mix(beyond[k], near.1[k], near.0))
    }

    /// Coverage and radiance of a row of trees at a distance, `times` as many repeats around, on ground of a height.
    fn row(&self, wood: &Wood, look: &Look, [distance, times, ground]: [f32; 3]) -> (f32, [f32; 3]) {
        let (is_far, blur) = (ground > 0.0, look.pixel * distance);
        let height = self.projection.eye.y + look.slope * distance - ground;
        // Above all crowns there is nothing to look for; below, rising ground goes on.
        if height > wood.height || (height < 0.0 && !is_far) {
            return (0.0, [0.0; 3]);
        }
        let free = if is_far { 1.0 } else { self.above_hem(look.around, height, blur) };
        let varied = Lattice::periodic(41, [VARIED, 0]).value(look.around * VARIED as f32, 0.5);
        let height = height / mix(LOWEST, 1.0, varied);
        // On rising ground there are crowns below crowns: bands of them, each beside the last.
        let closed = if is_far { closed(look.around) } else { 0.0 };
        let band = (closed - height / wood.height).max(0.0) * 5.0;
        let height = if is_far { height.max(wood.height * (closed - 0.2 * band.fract())) } else { height };
        if height > wood.height || height < 0.0 || free <= 0.0 {
            return (0.0, [0.0; 3]);
        }
        // The textures repeat up as well: their rims are kept out of sight.
        let down = (1.0 - height / wood.height).clamp(0.03, 0.994);
        let uv = Vec2::new(look.around * wood.repeats as f32 * times + 0.37 * (times + band.floor()), down);
        // The texture's own width to height, since a footprint is one number for both.
        let wide = look.pixel / (2.0 * PI) * wood.repeats as f32 * times;
        let footprint = (blur / wood.height * wide).sqrt();
        let [covered, right, up] = self.textures[wood.form as usize].sample(uv, footprint);
        // Leaves close a pixel that they mostly cover; twigs do not.
        let crowns = if wood.is_bare { covered.clamp(0.0, 1.0) } else { smooth_step(0.12, 0.88, covered) };
        let covered = free * crowns.max(smooth_step(0.0, 0.2, band));
        if covered <= 0.002 {
            return (0.0, [0.0; 3]);
        }
        let [kind, light, thin] = self.textures[wood.crowns as usize].sample(uv, footprint);
        let kind = if kind > 0.0 { folded(kind + 0.9 * varied) } else { kind };
        let lit = self.lit_crown(look, [right, up], [kind, light, thin]);
        (covered, self.atmosphere.hazed(lit, look.direction * distance))
    }

    /// How much of the wood shows over the tall grass and the rises before it, at a height in metres.
    fn above_hem(&self, around: f32, height: f32, blur: f32) -> f32 {
        // What is higher than the eye stands before the sky.
        let highest = 0.8 * self.projection.eye.y;
        if height > highest + FEATHER + blur {
            return 1.0;
        }
        let part = |(number, (tall, nodes)): (usize, (f32, u32))| {
            tall * Lattice::periodic(31 + number as u64, [nodes, 0]).value(around * nodes as f32, 0.5)
        };
        let hem = HEM.into_iter().enumerate().map(part).sum::<f32>().min(highest);
        smooth_step(hem - FEATHER - blur, hem + FEATHER + blur, height)
    }

    /// Radiance of a crown's piece with the parts of its normal to the right and up.
    fn lit_crown(&self, look: &Look, [right, up]: [f32; 2], [kind, light, thin]: [f32; 3]) -> [f32; 3] {
        let (reflected, transmitted) = self.atmosphere.wood.seen(kind, thin);
        let (light, thin) = (light.clamp(0.0, 1.0), thin.max(0.0));
        let towards = Vec3::new(-look.direction.x, 0.0, -look.direction.z).normalize();
        let aside = Vec3::y().cross(&towards);
        let facing = (1.0 - right * right - up * up).max(0.05).sqrt();
        let normal = (aside * right + Vec3::y() * up + towards * facing).normalize();
        let cosine = normal.dot(&self.frame.sun.direction);
        // Leaves lie all ways under a crown's surface, so the light goes around it a little; from behind it comes through.
        let front = (0.75 * cosine + 0.25).max(0.0) * light;
        let through = 0.3 * (0.5 - 0.5 * cosine) * thin * light;
        let sun = self.frame.sun.irradiance.map(|e| e * self.atmosphere.sun_share());
        let ambient = self.atmosphere.open.irradiance(normal);
        // What is dark is lit by leaves: sky light that has come through and off others, in their colour.
        let inside = DEEP * (1.0 - light);
        std::array::from_fn(|k| {
            let sent_on = reflected[k] + transmitted[k];
            let of_sky = reflected[k] * ambient[k] * light + sent_on * ambient[k] * inside;
            (reflected[k] * sun[k] * front + transmitted[k] * sun[k] * through + of_sky) / PI
        })
    }
}

/// Share of the wood's height up to which crowns close a slope: an outline of crowns a few metres wide.
fn closed(around: f32) -> f32 {
    let part = |nodes: u32| Lattice::periodic(51, [nodes, 0]).value(around * nodes as f32, 0.5);
    0.22 + 0.16 * part(310) + 0.14 * part(1130)
}

/// A number folded into 0..1 as a strip of paper is.
fn folded(x: f32) -> f32 {
    let rest = (0.5 * x).fract() * 2.0;
    if rest > 1.0 { 2.0 - rest } else { rest }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folding_keeps_the_range_and_has_no_steps() {
        let folded: Vec<f32> = (0..400).map(|step| folded(step as f32 * 0.01)).collect();
        assert!(folded.iter().all(|x| (0.0..=1.0).contains(x)));
        assert!(folded.windows(2).all(|pair| (pair[0] - pair[1]).abs() < 0.0101));
        assert!((folded[150] - 0.5).abs() < 1e-5 && (folded[30] - 0.3).abs() < 1e-5);
    }

    #[test]
    fn what_stays_green_and_wood_have_their_own_colours() {
        let summer = Palette { kinds: vec![(1.0, [0.05, 0.10, 0.03], [0.04, 0.12, 0.02])] };
        assert_eq!(summer.seen(-1.0, 0.5), (EVERGREEN, [0.0; 3]));
        assert_eq!(summer.seen(0.5, -1.0), (BARK, [0.0; 3]));
        let (reflected, transmitted) = summer.seen(0.5, 0.3);
        assert!(reflected[1] > reflected[0] && transmitted[1] > 0.0);
    }
}
