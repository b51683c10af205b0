//! The edge of a wood on the horizon: what closes a meadow off. Read from the unrolled edge that the frame brings, lit by
//! the frame's sun and sky, in the colours of the frame's own foliage; scenery that casts no shadow.

use super::Prepared;
use super::texture::{MipMap, optics};
use crate::base::maths::{atan2f, expf, mix, smooth_step};
use crate::base::noise::{Lattice, Nodes};
use crate::base::vector::{Vec2, Vec3};
use crate::frame::{Frame, Wood};
use std::f32::consts::PI;
use std::sync::Arc;

/// How much farther a second wood stands behind the first, on rising ground.
const FAR: f32 = 3.4;
/// Height of the hills that it stands on, metres.
const HILLS: f32 = 34.0;
/// How much of a distant crown's colour is that of all leaves of the frame, the rest that of one state.
const SHARED: f32 = 0.40;
/// Share of the leaves of all trees, in the order in which they turn, over which the colour of one tree is taken to either side.
const TURNING: f32 = 0.10;
/// Share of the fall of all leaves during which a tree sheds its own.
const SHEDDING: f32 = 0.45;
/// Heights by which the meadow rises before the wood's foot, metres, and how often they come around the horizon: the rise
/// and fall of the ground, thickets of tall grass and herbs, single ones.
const HEM: [(f32, u32); 5] = [(2.2, 29), (1.2, 83), (0.5, 467), (0.40, 1300), (0.35, 3900)];
/// How far the meadow lies lower at the wood's foot, metres.
const SUNKEN: f32 = 0.9;
/// Height over which the meadow's grass gives way to what stands behind, metres.
const FEATHER: f32 = 0.10;
/// Nodes around the horizon between which the trees' heights and kinds vary, so that no repeat looks like the last.
const VARIED: u32 = 89;
/// Least height of trees over that of the texture.
const LOWEST: f32 = 0.74;
/// How high crowns stand before others when their leaves are gone, over how high they stood.
const THIN: f32 = 0.35;
/// Reflectance of conifers' crowns (linear, judged).
const EVERGREEN: [f32; 3] = [0.062, 0.082, 0.030];
/// Tints of the kinds of trees, on the frame's own foliage.
const TINTS: [[f32; 3]; 3] = [[0.80, 0.88, 0.86], [1.06, 1.03, 0.82], [1.34, 1.14, 0.72]];
/// Parts of all leaves by which their states are told.
const PARTS: u64 = 256;
/// Steps between the kinds whose colours are kept.
const STEPS: usize = 64;

/// The nodes of all that varies around the horizon, about the last look at it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Noises {
    /// Of the meadow's rises before the wood's foot.
    hem: [Nodes; HEM.len()],
    /// Of the ground that the second wood stands on.
    hills: [Nodes; 2],
    /// Of what closes its slope.
    closed: [Nodes; 2],
    /// Of the trees' heights and kinds.
    varied: Nodes,
}

/// Reflectance and transmittance.
pub(super) type Optics = ([f32; 3], [f32; 3]);

/// Reflectance and transmittance of the crowns of a season, and how many of the leaves have fallen.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Palette {
    /// By the kind of tree, evenly from 0 to 1.
    kinds: Vec<Optics>,
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
        let worn = frame.materials.iter().zip(&by_material).filter(|(_, count)| **count > 0);
        let leaves: Vec<(u64, Optics)> = worn.map(|(material, &count)| (count, optics(material, textures))).collect();
        let wood = frame.ground.as_ref().and_then(|ground| ground.wood);
        // The last leaves of all tell nothing of a wood that has none.
        if wood.is_some_and(|wood| wood.bareness < 1.0) { Self::of_leaves(&leaves) } else { Self::default() }
    }

    /// The colours of trees among which leaves of these numbers are spread, in the order in which trees turn. They are told by
    /// parts of all leaves, so that a wood stays as it is on days on which hardly a leaf turns.
    fn of_leaves(leaves: &[(u64, Optics)]) -> Self {
        let total = leaves.iter().map(|(count, _)| count).sum::<u64>().max(1);
        let mut below = 0;
        let range = |&(count, own): &(u64, Optics)| {
            below += count;
            let end = |leaves: u64| ((leaves * PARTS + total / 2) / total) as f32 / PARTS as f32;
            (end(below - count), end(below), own)
        };
        let ranges: Vec<(f32, f32, Optics)> = leaves.iter().map(range).collect();
        let mean = mean_between(&ranges, 0.0, 1.0);
        let kinds = (0..=STEPS).map(|step| {
            let kind = step as f32 / STEPS as f32;
            // A tree wears leaves of many states at once.
            let own = mean_between(&ranges, kind - TURNING, kind + TURNING);
            let tint = tint(kind);
            let tinted = |own: [f32; 3], all: [f32; 3]| std::array::from_fn(|k| mix(own[k], all[k], SHARED) * tint[k]);
            (tinted(own.0, mean.0), tinted(own.1, mean.1))
        });
        Self { kinds: if leaves.is_empty() { Vec::new() } else { kinds.collect() } }
    }

    /// Reflectance and transmittance of leaves of a kind, 0..1, and of what stays green, -1.
    pub(super) fn leaves(&self, kind: f32) -> Optics {
        let place = kind.clamp(0.0, 1.0) * STEPS as f32;
        let first = (place as usize).min(STEPS - 1);
        let evergreen = smooth_step(0.15, 0.45, -kind);
        let [Some(low), Some(high)] = [first, first + 1].map(|step| self.kinds.get(step)) else {
            return (EVERGREEN, [0.0; 3]);
        };
        let part = place - first as f32;
        let reflected = std::array::from_fn(|k| mix(mix(low.0[k], high.0[k], part), EVERGREEN[k], evergreen));
        (reflected, std::array::from_fn(|k| mix(low.1[k], high.1[k], part) * (1.0 - evergreen)))
    }
}

/// The mean of what ranges of 0..1 have, over the part of an interval that lies in them.
fn mean_between(ranges: &[(f32, f32, Optics)], low: f32, high: f32) -> Optics {
    let mut sums = ([0.0; 3], [0.0; 3]);
    let whole = (high.min(1.0) - low.max(0.0)).max(1e-6);
    for (from, to, own) in ranges {
        let share = (to.min(high) - from.max(low)).max(0.0) / whole;
        for k in 0..3 {
            sums.0[k] += own.0[k] * share;
            sums.1[k] += own.1[k] * share;
        }
    }
    sums
}

/// Factor on the colours of a kind of tree.
fn tint(kind: f32) -> [f32; 3] {
    let place = folded(kind * 7.31) * (TINTS.len() - 1) as f32;
    let first = (place as usize).min(TINTS.len() - 2);
    std::array::from_fn(|k| mix(TINTS[first][k], TINTS[first + 1][k], place - first as f32))
}

/// Share of its leaves that a tree of a kind still has when this share of all leaves has fallen: those that turn first shed
/// first; what stays green (-1) sheds none.
fn hanging(kind: f32, bareness: f32) -> f32 {
    let begins = (1.0 - kind.max(0.0)) * (1.0 - SHEDDING);
    let shed = ((bareness - begins) / SHEDDING).clamp(0.0, 1.0);
    1.0 - shed * (1.0 - smooth_step(0.15, 0.45, -kind))
}

/// Share of a place's leaves that is seen when a tree has a share of its own; `order` tells the places that are bare last (0)
/// from the first (1). What is seen goes slower than the leaves, which hide one another: by Beer's law in a crown of four layers
/// of leaves.
fn left(hanging: f32, order: f32) -> f32 {
    const LAYERS: f32 = 2.0;
    let seen = (1.0 - expf(-LAYERS * hanging)) / (1.0 - expf(-LAYERS));
    smooth_step(order - 0.40, order + 0.40, mix(-0.41, 1.41, seen))
}

/// Where a place is in the order in which a crown grows bare, 0..1: tuft by tuft, told from how it is turned and lit.
fn order([right, up]: [f32; 2], light: f32) -> f32 {
    folded((2.6 * right + 1.9 * up + 3.0 * light).abs())
}

/// A ray towards the horizon.
pub(super) struct Look {
    pub direction: Vec3,
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
        let height = slope * wood.distance + self.projection.eye.y;
        if height > wood.height {
            return behind;
        }
        self.reads.borrow_mut().wood = true;
        let around = atan2f(direction.x, -direction.z) / (2.0 * PI) + 0.5;
        let look = Look { direction, around, slope, pixel: 1.0 / self.projection.pixels_per_metre };
        let free = above_hem(&mut self.horizon.borrow_mut().hem, around, height, look.pixel * wood.distance);
        let trees = if free > 0.0 { self.trees(wood, &look, behind) } else { behind };
        if free >= 1.0 {
            return trees;
        }
        // Below the eye's level the meadow goes on as it is; what rises over it is tall grass.
        let tall = smooth_step(-0.2, 1.0, slope * wood.distance + 0.8);
        let patch = Lattice::periodic(61, [700, 0]).value(around * 700.0, 1.3 * height);
        let meadow = if tall > 0.0 { self.far_meadow(direction, wood.distance, patch) } else { behind };
        std::array::from_fn(|k| mix(mix(behind[k], meadow[k], tall), trees[k], free))
    }

    /// The two rows of trees over what lies beyond.
    fn trees(&self, wood: &Wood, look: &Look, behind: [f32; 3]) -> [f32; 3] {
        let near = self.row(wood, look, [wood.distance, 1.0, 0.0]);
        if near.0 >= 0.999 {
            return near.1;
        }
        if look.slope <= 0.0 {
            return std::array::from_fn(|k| mix(behind[k], near.1[k], near.0));
        }
        let hills = hills(&mut self.horizon.borrow_mut().hills, look.around);
        let far = self.row(wood, look, [wood.distance * FAR, 3.0, hills]);
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
        let varied = around(&mut self.horizon.borrow_mut().varied, 41, VARIED, look.around);
        let height = height / mix(LOWEST, 1.0, varied);
        // On rising ground there are crowns below crowns: bands of them, each beside the last.
        let closed = if is_far { closed(&mut self.horizon.borrow_mut().closed, look.around) } else { 0.0 };
        let band = (closed - height / wood.height).max(0.0) * 5.0;
        let lowest = wood.height * (closed - 0.2 * band.fract()).max(0.01);
        let height = if is_far { height.max(lowest) } else { height };
        if height > wood.height || height < 0.0 {
            return (0.0, [0.0; 3]);
        }
        // The textures repeat up as well: their rims are kept out of sight.
        let down = (1.0 - height / wood.height).clamp(0.03, 0.994);
        let uv = Vec2::new(look.around * wood.repeats as f32 * times + 0.37 * (times + band.floor()), down);
        // The texture's own width to height, since a footprint is one number for both.
        let wide = look.pixel / (2.0 * PI) * wood.repeats as f32 * times;
        let footprint = (blur / wood.height * wide).sqrt();
        let [leaves, right, up] = self.textures[wood.form as usize].sample(uv, footprint);
        let [kind, light, bare] = self.textures[wood.crowns as usize].sample(uv, footprint);
        let light = light.clamp(0.0, 1.0);
        let kind = if kind > 0.0 { folded(kind + 0.9 * varied) } else { kind };
        let closed = smooth_step(0.0, 0.2, band);
        let hanging = hanging(kind, wood.bareness);
        let leaves = smooth_step(0.06, 0.94, leaves) * left(hanging, order([right, up], light));
        let leaves = leaves.max(closed * hanging);
        let bare = bare.max(closed * smooth_step(0.0, 0.4, wood.bareness));
        // Twigs end among their leaves; trunks show between crowns.
        let bare = mix(smooth_step(0.55, 0.95, bare), bare, smooth_step(0.0, 0.6, 1.0 - hanging));
        let covered = leaves + bare.max(0.0) * (1.0 - leaves);
        if covered <= 0.002 {
            return (0.0, [0.0; 3]);
        }
        let horizons = self.textures[wood.horizons as usize].sample(uv, footprint);
        let horizons = horizons.map(|sine| sine.clamp(0.0, 1.0) * mix(THIN, 1.0, hanging));
        let crown = if leaves > 0.0 { self.lit_crown(look, [right, up], (kind, light), horizons) } else { [0.0; 3] };
        let stems = if leaves < 0.99 { self.lit_wood(look, kind, horizons) } else { [0.0; 3] };
        let lit = std::array::from_fn(|k| mix(stems[k], crown[k], leaves / covered));
        (covered, self.atmosphere.hazed(lit, look.direction * distance))
    }
}

impl Look {
    /// The level direction from the wood to the eye.
    pub(super) fn towards(&self) -> Vec3 {
        Vec3::new(-self.direction.x, 0.0, -self.direction.z).normalize()
    }
}

/// How much of the wood shows over the tall grass and the rises before it, at a height in metres.
fn above_hem(kept: &mut [Nodes; HEM.len()], at: f32, height: f32, blur: f32) -> f32 {
    let highest = HEM.iter().map(|(tall, _)| tall).sum::<f32>() - SUNKEN;
    if height > highest + FEATHER + blur {
        return 1.0;
    }
    let part =
        |((number, kept), (tall, nodes)): ((u64, &mut Nodes), (f32, u32))| tall * around(kept, number, nodes, at);
    let hem = (31..).zip(kept).zip(HEM).map(part).sum::<f32>() - SUNKEN;
    smooth_step(hem - FEATHER - blur, hem + FEATHER + blur, height)
}

/// Share of the wood's height up to which crowns close a slope: an outline of crowns a few metres wide.
fn closed([wide, narrow]: &mut [Nodes; 2], at: f32) -> f32 {
    0.08 + 0.30 * around(wide, 51, 310, at) + 0.18 * around(narrow, 51, 1130, at)
}

/// Height of the ground that the second wood stands on, metres.
fn hills([wide, narrow]: &mut [Nodes; 2], at: f32) -> f32 {
    (0.8 * around(wide, 11, 17, at) + 0.2 * around(narrow, 11, 61, at)) * HILLS
}

/// Noise in 0..1 with so many nodes around the horizon, at a share of the way around.
fn around(kept: &mut Nodes, salt: u64, nodes: u32, at: f32) -> f32 {
    Lattice::periodic(salt, [nodes, 0]).value_by(kept, at * nodes as f32, 0.5)
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

    const GREEN: Optics = ([0.05, 0.10, 0.03], [0.04, 0.12, 0.02]);
    const RED: Optics = ([0.20, 0.04, 0.02], [0.15, 0.02, 0.01]);

    #[test]
    fn what_stays_green_has_its_own_colour() {
        let summer = Palette::of_leaves(&[(1, GREEN)]);
        assert_eq!(summer.leaves(-1.0), (EVERGREEN, [0.0; 3]));
        let (reflected, transmitted) = summer.leaves(0.5);
        assert!(reflected[1] > reflected[0] && transmitted[1] > 0.0);
        assert_eq!(Palette::of_leaves(&[]).leaves(0.5), (EVERGREEN, [0.0; 3]));
    }

    #[test]
    fn each_tree_turns_over_some_days_and_one_after_another() {
        // One leaf in a hundred turns a day.
        let palettes: Vec<Palette> =
            (0..=100).map(|red| Palette::of_leaves(&[(100 - red, GREEN), (red, RED)])).collect();
        for kind in [0.0, 0.2, 0.5, 0.77, 1.0] {
            let reds: Vec<f32> = palettes.iter().map(|palette| palette.leaves(kind).0[0] / tint(kind)[0]).collect();
            let largest = reds.windows(2).map(|days| days[1] - days[0]).fold(0.0, f32::max);
            assert!(reds.windows(2).all(|days| days[1] > days[0] - 1e-4), "{kind}");
            assert!(largest < 0.15 * (RED.0[0] - GREEN.0[0]), "{kind}: {largest}");
        }
        // A leaf among thousands changes nothing, and there is no wood without leaves to have a colour.
        assert_eq!(Palette::of_leaves(&[(20_000, GREEN), (9, RED)]), Palette::of_leaves(&[(20_000, GREEN), (1, RED)]));
        let half = &palettes[50];
        assert!(half.leaves(0.9).0[0] > 1.5 * half.leaves(0.1).0[0]);
    }

    #[test]
    fn trees_shed_one_after_another_and_none_in_a_day() {
        for kind in [0.0f32, 0.3, 0.6, 1.0] {
            assert_eq!((hanging(kind, 0.0), hanging(kind, 1.0)), (1.0, 0.0));
            let shares: Vec<f32> = (0..=100).map(|day| hanging(kind, day as f32 / 100.0)).collect();
            assert!(shares.windows(2).all(|days| (0.0..0.03).contains(&(days[0] - days[1]))), "{kind}");
        }
        assert!(hanging(0.9, 0.4) < hanging(0.1, 0.4));
        assert_eq!(hanging(-1.0, 1.0), 1.0);
        // The wood as a whole has lost about what the frame's trees have lost.
        for bareness in [0.2f32, 0.5, 0.8] {
            let mean = (0..200).map(|step| hanging(step as f32 / 199.0, bareness)).sum::<f32>() / 200.0;
            assert!((mean - (1.0 - bareness)).abs() < 0.125, "{bareness}: {mean}");
        }
        for order in [0.0, 0.5, 1.0] {
            assert_eq!((left(1.0, order), left(0.0, order)), (1.0, 0.0));
        }
    }

    #[test]
    fn the_meadow_s_far_rim_rises_and_falls_and_closes_the_circle() {
        let above = |around: f32, height: f32, blur: f32| above_hem(&mut Default::default(), around, height, blur);
        let rim =
            |around: f32| (0..400).map(|step| step as f32 * 0.01).find(|height| above(around, *height, 0.0) > 0.5);
        let rims: Vec<f32> = (0..300).filter_map(|step| rim(step as f32 / 300.0)).collect();
        assert_eq!(rims.len(), 300);
        let (low, high) = rims.iter().fold((f32::MAX, 0.0f32), |(low, high), rim| (low.min(*rim), high.max(*rim)));
        assert!(high - low > 1.0, "{low} {high}");
        assert!((rim(0.0).unwrap_or(9.0) - rim(1.0).unwrap_or(0.0)).abs() < 0.02);
        assert_eq!(above(0.3, 10.0, 0.1), 1.0);
    }
}
