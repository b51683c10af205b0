//! The sward before a camera: patches of grass on a quadtree, whose blades are wider and fewer the farther away they stand, so
//! that a blade is about as wide as a pixel wherever there are any. Beyond them the ground's texture is enough.

use super::blades;
use super::outlook::Outlook;
use super::upright::upright;
use crate::base::mesh::Mesh;
use crate::base::noise::Fractal;
use crate::base::random::{Purpose, Stream, hash};
use crate::base::vector::Affine;

/// Side of a patch of the finest level, metres; that of each coarser one is twice as long.
const PATCH: f64 = 1.25;
/// Tufts on a patch and blades in a tuft.
const TUFTS: u64 = 340;
const BLADES: u64 = 18;
/// Half the width of a blade of the finest level, metres.
const HALF: f64 = 0.00095;
/// Heights of tufts over the mean course, metres.
const HEIGHTS: [f64; 2] = [0.035, 0.10];
/// How far from the eye grass is laid, metres: farther away it is two or three pixels high.
const REACH: f64 = 110.0;
/// Pixels across a blade where the next level begins, and bounds of how far away that may be, metres.
const WIDTH: f64 = 0.85;
const NEAREST: [f64; 2] = [2.0, 20.0];
/// Half the diagonal of a square over its side, with what blades reach beyond.
const HALF_DIAGONAL: f64 = 0.75;
/// Most levels.
const LEVELS: usize = 7;

/// A patch of a level at its place.
pub(super) struct Patch {
    /// Number of its level.
    pub level: usize,
    /// Where it lies.
    pub place: Affine,
}

/// How the sward is divided for a picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Division {
    /// Distance at which the second level begins, metres.
    near: f64,
    /// Number of the levels.
    pub levels: usize,
}

impl Division {
    /// For a picture whose pixels span this angle, radians.
    pub(super) fn new(pixel: f64) -> Self {
        let near = (2.0 * HALF / (WIDTH * pixel)).clamp(NEAREST[0], NEAREST[1]);
        let levels = (1..LEVELS).find(|&level| near * f64::from(1 << level) >= REACH).map_or(LEVELS, |last| last + 1);
        Self { near, levels }
    }

    /// The patches before a camera; one that does not lie on its ground gives way to four of the level below.
    pub(super) fn patches(self, outlook: &Outlook, lies: impl Fn(&Patch) -> Option<Affine>) -> Vec<Patch> {
        let coarsest = self.levels - 1;
        let mut open: Vec<(usize, usize, [i64; 2])> = outlook
            .squares(side(coarsest), REACH + side(coarsest))
            .map(|(column, row)| (coarsest, coarsest, [column, row]))
            .collect();
        let mut laid = Vec::new();
        while let Some((level, wanted, square)) = open.pop() {
            let middle = square.map(|number| (number as f64 + 0.5) * side(level));
            let Some(distance) = outlook.distance(middle, HALF_DIAGONAL * side(level)) else { continue };
            let nearest = distance - HALF_DIAGONAL * side(level);
            if nearest > REACH || level == 0 && distance < 0.5 * outlook.eye[1] {
                continue;
            }
            let is_near = level > 0 && nearest < self.near * f64::from(1 << (level - 1));
            if !is_near {
                let patch = Patch { level, place: turned(middle, square) };
                if let Some(place) = lies(&patch) {
                    laid.push(Patch { place, ..patch });
                    continue;
                }
            }
            let wanted = if is_near { level - 1 } else { wanted };
            if level > 0 && level + 1 > wanted {
                let [column, row] = square.map(|number| 2 * number);
                open.extend([(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, z)| (level - 1, wanted, [column + x, row + z])));
            }
        }
        laid
    }
}

/// Side of the patches of a level, metres.
fn side(level: usize) -> f64 {
    PATCH * f64::from(1 << level)
}

/// A patch's place, turned by quarters so that neighbours do not look alike.
fn turned(middle: [f64; 2], [column, row]: [i64; 2]) -> Affine {
    let quarter = hash(column as u64, row as u64) & 3;
    upright(middle, [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][quarter as usize], 1.0)
}

/// The grass of a patch of a level, about the origin.
pub(super) fn mesh(seed: u64, level: usize) -> Mesh {
    let (mut mesh, courses) = (Mesh::default(), Fractal::new(5, 5, 2, hash(seed, 3)));
    let coarser = f64::from(1 << level);
    for tuft in 0..TUFTS {
        let mut random = Stream::new(seed, Purpose::Surroundings, tuft, 2);
        let middle = [random.uniform(), random.uniform()];
        let course = f64::from(courses.at(middle[0] as f32, middle[1] as f32));
        let tall = random.range(HEIGHTS[0], HEIGHTS[1]) * (0.45 + 1.1 * course);
        let hue = random.uniform();
        let spread = (0.05 + 0.5 * tall) * coarser;
        for _ in 0..BLADES {
            let foot = middle.map(|place| (place - 0.5) * side(level) + spread * random.normal().clamp(-2.0, 2.0));
            let height = tall * random.range(0.5, 1.2);
            let own = (0.6 * hue + 0.5 * random.uniform()).min(0.999);
            // Most blades are green.
            blades::add(&mut mesh, &mut random, foot, [height, own * own, HALF * coarser]);
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::maths::{cos, sin};

    /// What lies before an eye that looks along -z, half a radian to each side.
    fn before(eye: [f64; 3]) -> Outlook {
        Outlook::new(eye, [0.0, 0.0, -1.0], 0.5)
    }

    /// Whether a patch's square holds a place (x, z).
    fn holds(patch: &Patch, [x, z]: [f64; 2]) -> bool {
        let half = 0.5 * side(patch.level);
        [x - f64::from(patch.place.translation.x), z - f64::from(patch.place.translation.z)]
            .iter()
            .all(|off| (-half..half).contains(off))
    }

    #[test]
    fn patches_cover_what_is_seen_once_and_are_coarser_farther_away() {
        let eye = [1.3, 1.6, 20.7];
        for pixel in [3e-4, 6.3e-4, 2e-3] {
            let division = Division::new(pixel);
            let patches = division.patches(&before(eye), |patch| Some(patch.place));
            for step in 0..400u32 {
                let distance = 1.5 + f64::from(step) * 0.27;
                let aside = 0.98 * f64::from(step % 41) / 41.0 - 0.49;
                let place = [eye[0] + distance * sin(aside), eye[2] - distance * cos(aside)];
                let found: Vec<&Patch> = patches.iter().filter(|patch| holds(patch, place)).collect();
                assert_eq!(found.len(), 1, "{pixel} {distance} {aside}");
                // A blade is never two pixels wide, nor thinner than a fifth of one.
                let width = 2.0 * HALF * f64::from(1 << found[0].level) / (distance * pixel);
                assert!(found[0].level == 0 || (0.2..1.75).contains(&width), "{width} at {distance}");
            }
            // None lies behind, but for squares that reach before the eye.
            let is_seen = |patch: &Patch| f64::from(patch.place.translation.z) < eye[2] + side(patch.level);
            assert!(patches.iter().all(is_seen));
        }
        assert!(Division::new(3e-4).patches(&before([0.0, 40.0, 0.0]), |patch| Some(patch.place)).is_empty());
    }

    #[test]
    fn a_patch_that_does_not_lie_gives_way_to_its_quarters() {
        let (division, outlook) = (Division::new(3e-4), before([0.0, 1.6, 0.0]));
        let whole = division.patches(&outlook, |patch| Some(patch.place));
        let torn = division.patches(&outlook, |patch| (patch.level < 3).then_some(patch.place));
        assert!(whole.iter().any(|patch| patch.level == 3) && torn.iter().all(|patch| patch.level < 3));
        // What is nearer is as it was; places that were of the third level have a patch of the second.
        let count = |patches: &[Patch], level: usize| patches.iter().filter(|patch| patch.level == level).count();
        assert_eq!(count(&whole, 1), count(&torn, 1));
        assert!(count(&torn, 2) > count(&whole, 2) + count(&whole, 3));
        assert!(division.patches(&outlook, |_| None).is_empty());
    }

    #[test]
    fn levels_hold_as_many_blades_of_one_height_and_cover_as_much_of_a_patch() {
        let meshes: Vec<Mesh> = (0..3).map(|level| mesh(1, level)).collect();
        for (level, mesh) in meshes.iter().enumerate() {
            assert_eq!(mesh.check(), Ok(()));
            assert_eq!(mesh.triangles.len() as u64, TUFTS * BLADES);
            let reach = (0.5 + 2.0 * 0.2) * side(level) as f32;
            assert!(mesh.positions.iter().all(|p| p.x.abs() < reach && p.z.abs() < reach && (0.0..0.2).contains(&p.y)));
            let tips = |mesh: &Mesh| mesh.positions.iter().map(|p| p.y).sum::<f32>();
            assert_eq!(tips(mesh), tips(&meshes[0]));
        }
    }
}
