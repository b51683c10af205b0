//! Blades of grass, and the palette that they read: how much lighter or darker than the sward as a whole each is.

use crate::base::encoding::SrgbEncoder;
use crate::base::maths::{cos, mix, sin};
use crate::base::mesh::Mesh;
use crate::base::random::Stream;
use crate::base::vector::{Vec2, Vec3};
use crate::frame::{GroundPart, Material, Texture};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Name of the material of blades.
const NAME: &str = "grass";
/// What the palette's whites stand for: the lightest that a blade may be, over the sward's mean.
const LIGHTEST: f32 = 3.0;
/// Blades over the sward's mean, from dark green to straw (linear; judged).
const HUES: [[f32; 3]; 8] = [
    [0.66, 0.72, 0.66],
    [0.86, 0.88, 0.80],
    [0.98, 1.00, 0.92],
    [1.10, 1.12, 0.96],
    [0.80, 0.84, 0.86],
    [1.28, 1.22, 1.10],
    [1.62, 1.40, 1.50],
    [2.05, 1.60, 2.00],
];
/// Steps of the palette from a blade's tip to its root, and how light these are: roots stand in the shade of all others.
const ROWS: u32 = 8;
const TIP: f32 = 1.55;
const ROOT: f32 = 0.60;

/// The palette: a column a hue, a row a height.
pub(super) fn palette() -> Texture {
    let encoder = SrgbEncoder::default();
    let shade = |row: u32| mix(TIP, ROOT, row as f32 / (ROWS - 1) as f32) / LIGHTEST;
    let row = |row: u32| HUES.map(|hue| hue.map(|light| encoder.code(light * shade(row))));
    let pixels = Arc::new((0..ROWS).flat_map(row).collect());
    Texture { name: NAME.to_owned(), width: HUES.len() as u32, height: ROWS, pixels, repeat: false }
}

/// The material of blades that read a palette.
pub(super) fn material(palette: u32) -> Material {
    Material {
        reflected: Some(palette),
        two_sided: true,
        ground: GroundPart::Blades,
        ..Material::matte(NAME, [LIGHTEST; 3])
    }
}

/// Adds a blade of a height (metres), a hue (0 to 1, green to straw) and half a width (metres).
pub(super) fn add(mesh: &mut Mesh, random: &mut Stream, foot: [f64; 2], [height, hue, half]: [f64; 3]) {
    let foot = Vec3::new(foot[0] as f32, 0.0, foot[1] as f32);
    let lean = random.range(0.1, 0.8) * height;
    let (towards, across) = (random.range(0.0, TAU), random.range(0.0, TAU));
    let tip = foot + Vec3::new((lean * cos(towards)) as f32, height as f32, (lean * sin(towards)) as f32);
    let half = Vec3::new((half * cos(across)) as f32, 0.0, (half * sin(across)) as f32);
    let u = ((hue.clamp(0.0, 0.999) * HUES.len() as f64).floor() as f32 + 0.5) / HUES.len() as f32;
    let first = mesh.positions.len() as u32;
    mesh.positions.extend([foot - half, foot + half, tip]);
    mesh.uvs.extend([Vec2::new(u, 0.94), Vec2::new(u, 0.94), Vec2::new(u, 0.06)]);
    mesh.normals.extend([Vec3::y(); 3]);
    mesh.triangles.push([first, first + 1, first + 2]);
}
