//! Blades of grass about the foot of the tree, so that the trunk stands in the meadow and not on it, and tufts before the
//! camera. Farther away the ground's texture is enough.

use super::outlook::Outlook;
use crate::base::maths::{cos, mix, sin, sincos};
use crate::base::mesh::Mesh;
use crate::base::noise::Fractal;
use crate::base::random::{Purpose, Stream, hash};
use crate::base::vector::{Affine, Mat3, Vec2, Vec3};
use crate::frame::Texture;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Sides of the square cells that are sown, metres; a cell's blades follow one another in the mesh.
const CELL: f64 = 0.25;
/// Cells from the foot to the rim of the sward.
const REACH: i32 = 26;
/// Blades in a cell at the foot.
const DENSEST: f64 = 60.0;
/// Name of the material of blades.
pub(super) const NAME: &str = "sward";
/// What winter does to the colours of blades: bleached, less green (judged).
const BLEACHED: [f32; 3] = [1.95, 1.32, 2.15];
/// Blades in the ring about a trunk's foot that no mower and few feet reach, and how far it goes, metres.
const RING: u64 = 2100;
const RING_REACH: f64 = 0.85;
/// Radius of the trunk that the ring is made for, metres.
const RING_TRUNK: f32 = 0.14;
/// Colours of blades, from green to straw (linear sRGB, of the order of measured grass; judged).
const COLOURS: [[u8; 3]; 8] = [
    [62, 84, 30],
    [78, 98, 36],
    [92, 108, 40],
    [70, 92, 34],
    [104, 112, 48],
    [120, 116, 58],
    [144, 130, 74],
    [160, 142, 92],
];

/// The palette that the blades read: a column a colour, dark at the root and light at the tip.
pub(super) fn palette() -> Texture {
    const ROWS: u32 = 8;
    let width = COLOURS.len() as u32;
    let shade = |colour: u8, row: u32| (f32::from(colour) * (0.52 + 0.40 * row as f32 / (ROWS - 1) as f32)) as u8;
    let pixels = Arc::new((0..ROWS).flat_map(|row| COLOURS.map(|c| c.map(|v| shade(v, ROWS - 1 - row)))).collect());
    Texture { name: "sward".to_owned(), width, height: ROWS, pixels, repeat: false }
}

/// Factor on the colours of blades, for how far grass has gone into its winter rest, 0..1.
pub(super) fn tint(dormant: f32) -> [f32; 3] {
    BLEACHED.map(|full| mix(1.0, full, dormant))
}

/// Least distance between the middles of two swards, metres: nearer trees share one, whose blades reach all of their feet.
const APART: f64 = 4.0;

/// Most swards of a scene: each is some ten thousand blades.
const MOST: usize = 400;

/// Where swards lie about trees at these places (x, z): each at a tree's foot, turned so that none looks like the last.
pub(super) fn places(trees: &[[f64; 2]]) -> Vec<Affine> {
    let mut taken: Vec<[f64; 2]> = Vec::new();
    for &tree in trees {
        let is_apart = |other: &[f64; 2]| libm::hypot(tree[0] - other[0], tree[1] - other[1]) >= APART;
        if taken.iter().all(is_apart) {
            taken.push(tree);
        }
        if taken.len() == MOST {
            break;
        }
    }
    let place = |(number, [x, z]): (usize, [f64; 2])| {
        let (sine, cosine) = sincos(number as f64 * GOLDEN_ANGLE);
        let (sine, cosine) = (sine as f32, cosine as f32);
        Affine {
            linear: Mat3::new(cosine, 0.0, sine, 0.0, 1.0, 0.0, -sine, 0.0, cosine),
            translation: Vec3::new(x as f32, 0.0, z as f32),
        }
    };
    taken.into_iter().enumerate().map(place).collect()
}

/// Turn between successive swards, radians.
pub(super) const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;

/// Side of a patch of meadow, metres, tufts on it and blades in a tuft: what shows above the sward as a whole.
pub(super) const PATCH: f64 = 2.5;
const TUFTS: u64 = 90;
const BLADES: u64 = 14;
/// How far from the eye patches of meadow are laid, metres; beyond, a blade is thinner than a third of a pixel.
const MEADOW: f64 = 26.0;

/// Where patches of meadow lie before a camera: on the squares of a lattice that its picture may show, each turned by
/// quarters.
pub(super) fn meadow_places(outlook: &Outlook) -> Vec<Affine> {
    let place = |(x, z): (i64, i64)| {
        let middle = [x, z].map(|square| (square as f64 + 0.5) * PATCH);
        let distance = outlook.distance(middle, PATCH)?;
        let quarter = hash(x as u64, z as u64) & 3;
        let (sine, cosine) = [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][quarter as usize];
        let translation = Vec3::new(middle[0] as f32, 0.0, middle[1] as f32);
        let linear = Mat3::new(cosine, 0.0, sine, 0.0, 1.0, 0.0, -sine, 0.0, cosine);
        (distance > 0.5 * outlook.eye[1] && distance < MEADOW).then_some(Affine { linear, translation })
    };
    outlook.squares(PATCH, MEADOW).filter_map(place).collect()
}

/// Tufts of grass on a patch of meadow about the origin.
pub(super) fn meadow(seed: u64) -> Mesh {
    let mut mesh = Mesh::default();
    for tuft in 0..TUFTS {
        let mut random = Stream::new(seed, Purpose::Surroundings, tuft, 2);
        let middle = [random.range(-0.5, 0.5) * PATCH, random.range(-0.5, 0.5) * PATCH];
        let tall = random.range(0.035, 0.10);
        let hue = random.uniform();
        for _ in 0..BLADES {
            let spread = 0.05 + 0.5 * tall;
            let foot = middle.map(|place| place + spread * random.normal().clamp(-2.0, 2.0));
            let height = tall * random.range(0.5, 1.2);
            let own = (0.6 * hue + 0.5 * random.uniform()).min(0.999);
            // Most blades are green.
            let own = own * own;
            blade(&mut mesh, &mut random, foot, [height, own, 0.0016]);
        }
    }
    mesh
}

/// The blades, thinning out from the tree's foot.
pub(super) fn mesh(seed: u64) -> Mesh {
    let mut mesh = Mesh::default();
    let tufts = Fractal::new(9, 9, 3, hash(seed, 3));
    for (row, column) in (-REACH..REACH).flat_map(|row| (-REACH..REACH).map(move |column| (row, column))) {
        let distance = libm::hypot(f64::from(row) + 0.5, f64::from(column) + 0.5) / f64::from(REACH);
        if distance < 1.0 {
            sow(&mut mesh, &tufts, seed, [row, column], DENSEST * (1.0 - distance) * (1.0 - distance));
        }
    }
    mesh
}

/// Where rings of long grass stand about trunks (x, z, radius), as large as the trunks are thick; none about a shoot.
pub(super) fn ring_places(feet: &[[f32; 3]]) -> Vec<Affine> {
    let place = |(number, [x, z, radius]): (usize, &[f32; 3])| {
        let (sine, cosine) = sincos(number as f64 * GOLDEN_ANGLE);
        let scale = (radius / RING_TRUNK).min(1.5);
        let (sine, cosine) = (sine as f32 * scale, cosine as f32 * scale);
        let linear = Mat3::new(cosine, 0.0, sine, 0.0, scale, 0.0, -sine, 0.0, cosine);
        (scale > 0.3).then_some(Affine { linear, translation: Vec3::new(*x, 0.0, *z) })
    };
    feet.iter().enumerate().filter_map(place).take(MOST).collect()
}

/// Long grass about a trunk's foot, in tufts that grow shorter and fewer outwards.
pub(super) fn ring(seed: u64) -> Mesh {
    const IN_A_TUFT: u64 = 15;
    let mut mesh = Mesh::default();
    for tuft in 0..RING / IN_A_TUFT {
        let mut random = Stream::new(seed, Purpose::Surroundings, tuft, 3);
        let out = random.uniform();
        let (away, turn) = (0.10 + (RING_REACH - 0.10) * out * out.sqrt(), random.range(0.0, TAU));
        let tall = random.range(0.12, 0.30) * (1.0 - 0.55 * out);
        let hue = random.uniform();
        for _ in 0..IN_A_TUFT {
            let foot = [cos(turn), sin(turn)].map(|side| away * side + 0.05 * random.normal().clamp(-2.0, 2.0));
            let own = (0.7 * hue + 0.4 * random.uniform()).min(0.999);
            let height = tall * random.range(0.45, 1.0);
            blade(&mut mesh, &mut random, foot, [height, own * own, 0.0032]);
        }
    }
    mesh
}

fn sow(mesh: &mut Mesh, tufts: &Fractal, seed: u64, [row, column]: [i32; 2], count: f64) {
    let id = ((row + REACH) * 2 * REACH + column + REACH) as u64;
    let mut random = Stream::new(seed, Purpose::Surroundings, id, 1);
    let (u, v) = (column as f32 / (2 * REACH) as f32 + 0.5, row as f32 / (2 * REACH) as f32 + 0.5);
    let tuft = f64::from(tufts.at(u, v));
    for _ in 0..(count * (0.3 + 1.4 * tuft)) as usize {
        let foot = [f64::from(column), f64::from(row)].map(|place| (place + random.uniform()) * CELL);
        let height = random.range(0.03, 0.11) * (0.5 + tuft);
        let hue = random.uniform();
        let hue = (hue * hue).min(0.999);
        blade(mesh, &mut random, foot, [height, hue, 0.002]);
    }
}

/// Adds a blade of a height (metres), a hue (0 to 1, green to straw) and half a width (metres).
pub(super) fn blade(mesh: &mut Mesh, random: &mut Stream, foot: [f64; 2], [height, hue, half]: [f64; 3]) {
    let foot = Vec3::new(foot[0] as f32, 0.0, foot[1] as f32);
    let lean = random.range(0.1, 0.8) * height;
    let (towards, across) = (random.range(0.0, TAU), random.range(0.0, TAU));
    let tip = foot + Vec3::new((lean * cos(towards)) as f32, height as f32, (lean * sin(towards)) as f32);
    let half = Vec3::new((half * cos(across)) as f32, 0.0, (half * sin(across)) as f32);
    let u = ((hue * COLOURS.len() as f64).floor() as f32 + 0.5) / COLOURS.len() as f32;
    let first = mesh.positions.len() as u32;
    mesh.positions.extend([foot - half, foot + half, tip]);
    mesh.uvs.extend([Vec2::new(u, 0.94), Vec2::new(u, 0.94), Vec2::new(u, 0.06)]);
    // Grass as a whole faces the sky, its single blades a little to their own side. A triangle for each side keeps that.
    let normal = Vec3::new((0.45 * sin(across)) as f32, 1.0, (-0.45 * cos(across)) as f32).normalize();
    mesh.normals.extend([normal; 3]);
    mesh.triangles.extend([[first, first + 1, first + 2], [first + 1, first, first + 2]]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tree_by_itself_has_the_sward_as_it_is_and_near_trees_share_one() {
        assert_eq!(places(&[[0.0; 2]]), [Affine::identity()]);
        let found = places(&[[0.0, 0.0], [3.0, 0.0], [6.0, 0.0]]);
        assert_eq!(found.iter().map(|place| place.translation.x).collect::<Vec<_>>(), [0.0, 6.0]);
    }

    #[test]
    fn blades_stand_on_the_ground_and_stay_short() {
        let sward = mesh(1);
        assert_eq!(sward.check(), Ok(()));
        assert!((5_000..160_000).contains(&sward.triangles.len()), "{}", sward.triangles.len());
        assert!(sward.positions.iter().all(|p| (0.0..0.2).contains(&p.y)));
    }

    #[test]
    fn long_grass_grows_with_the_trunk_and_leaves_shoots_alone() {
        let ring = ring(1);
        assert_eq!(ring.check(), Ok(()));
        assert!(ring.positions.iter().all(|p| (0.0..0.31).contains(&p.y)));
        let places = ring_places(&[[0.0, 0.0, 0.004], [2.0, 1.0, 0.07], [5.0, 0.0, 2.0]]);
        let scales: Vec<f32> = places.iter().map(|place| place.linear.column(0).norm()).collect();
        assert_eq!(places.len(), 2);
        assert!((scales[0] - 0.5).abs() < 1e-5 && (scales[1] - 1.5).abs() < 1e-5, "{scales:?}");
    }

    #[test]
    fn a_meadow_lies_before_the_camera_and_not_behind_it() {
        let places = meadow_places(&Outlook::new([1.0, 1.6, 20.0], [0.0, 0.0, -1.0], 0.3));
        assert!((20..120).contains(&places.len()), "{}", places.len());
        for place in &places {
            let (across, along) = (f64::from(place.translation.x) - 1.0, 20.0 - f64::from(place.translation.z));
            assert!(along > -PATCH && libm::hypot(across, along) < MEADOW, "{place:?}");
        }
        assert!(meadow_places(&Outlook::new([0.0, 40.0, 0.0], [0.0, 0.0, -1.0], 0.3)).is_empty());
        let patch = meadow(1);
        assert_eq!(patch.check(), Ok(()));
        assert_eq!(patch.triangles.len() as u64, 2 * TUFTS * BLADES);
    }
}
