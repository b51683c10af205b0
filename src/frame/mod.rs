//! The waist of the program: everything a picture or a glTF file needs, resolved. No scene file, seed, species or
//! probability is known from here on; the rasteriser and the exporter see nothing else. Types only.
//!
//! Metres, right-handed, +Y up; the ground is at height 0, and a tree by itself stands at the origin.

use crate::base::mesh::Mesh;
use crate::base::vector::{Affine, Vec3};
use std::sync::Arc;

/// A picture that materials read: 8-bit sRGB (normals: plain numbers), opaque, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Unique name, `[a-z0-9_-]`.
    pub name: String,
    /// Pixels in a row, a power of two.
    pub width: u32,
    /// Rows, a power of two.
    pub height: u32,
    /// Red, green and blue of each pixel; shared with what they were painted for.
    pub pixels: Arc<Vec<[u8; 3]>>,
    /// Whether the picture repeats beyond 0..1 (else its rim continues).
    pub repeat: bool,
}

/// How a surface answers light.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Unique name, `[a-z0-9_-]`.
    pub name: String,
    /// Diffuse reflectance, linear sRGB 0..1; multiplies `reflected`.
    pub colour: [f32; 3],
    /// Number of the texture of diffuse reflectance.
    pub reflected: Option<u32>,
    /// Diffuse transmittance, linear sRGB 0..1; multiplies `transmitted`. Zero for an opaque surface.
    pub transmission: [f32; 3],
    /// Number of the texture of diffuse transmittance.
    pub transmitted: Option<u32>,
    /// Reflectance of the side turned away from the normals, relative to the texture that is read for it.
    pub back_gain: f32,
    /// Number of the texture of diffuse reflectance of the side turned away from the normals; that of the front when absent.
    /// Multiplied by `colour` like the front's.
    pub behind: Option<u32>,
    /// Number of the texture of normals, if the surface is not smooth: x along u, y against v, z out of the front, -1..1 in
    /// 0..255, and no sRGB.
    pub relief: Option<u32>,
    /// Fresnel reflectance at normal incidence of the gloss lobe; 0 for none.
    pub gloss: f32,
    /// Roughness of the gloss lobe, 0..1 (GGX alpha is its square).
    pub roughness: f32,
    /// Whether both sides are drawn.
    pub two_sided: bool,
    /// Whether the surface shows its reflectance as it is, whatever light there is: charts, not leaves.
    pub unlit: bool,
    /// What of the ground it is.
    pub ground: GroundPart,
}

/// What of a frame's ground a surface is, which then looks as the ground does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GroundPart {
    /// Nothing of it: the surface looks as its material says.
    #[default]
    None,
    /// Its own surface where it is uneven.
    Surface,
    /// Blades of grass: `colour` and `reflected` are how much lighter they are than the sward as a whole.
    Blades,
}

impl Material {
    /// A dull, opaque surface of one colour (linear sRGB), drawn from the front.
    #[must_use]
    pub fn matte(name: &str, colour: [f32; 3]) -> Self {
        Self {
            name: name.to_owned(),
            colour,
            reflected: None,
            transmission: [0.0; 3],
            transmitted: None,
            back_gain: 1.0,
            behind: None,
            relief: None,
            gloss: 0.0,
            roughness: 0.95,
            two_sided: false,
            unlit: false,
            ground: GroundPart::None,
        }
    }
}

/// One mesh in one material.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Part {
    /// Number of the mesh.
    pub mesh: u32,
    /// Number of the material.
    pub material: u32,
}

/// Meshes that are placed together.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Unique name, `[a-z0-9_-]`: `trunk`, `leaf_red_0`.
    pub name: String,
    /// What it is made of.
    pub parts: Vec<Part>,
}

/// A model at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// Number of the model.
    pub model: u32,
    /// From the model's to the world's coordinates; no shear, one positive scale.
    pub transform: Affine,
    /// The leaf's stable id, unlike that of any other leaf in the frame; `None` for wood.
    pub leaf: Option<u64>,
}

/// A pinhole camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The eye, metres.
    pub position: Vec3,
    /// The point in the middle of the picture, metres.
    pub target: Vec3,
    /// Angle from the picture's lower to its upper rim, radians.
    pub field_of_view: f32,
    /// Nearest distance along the viewing axis that is drawn, metres, positive.
    pub near: f32,
    /// Farthest distance along the viewing axis that is drawn, metres; the ground and the sky have no end.
    pub far: f32,
}

/// The sun: parallel light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// Unit vector towards the sun.
    pub direction: Vec3,
    /// Irradiance on a surface that faces it, linear sRGB; zero for no sun.
    pub irradiance: [f32; 3],
}

/// Light from the whole hemisphere: what is even around the horizon, and over it a clear sky about the sun.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sky {
    /// Radiance at the zenith, linear sRGB; between it and the horizon radiance grows with the sine of the height, so that an
    /// overcast sky (CIE S 011, type 1) has three times the horizon's here.
    pub zenith: [f32; 3],
    /// Radiance at the horizon, linear sRGB.
    pub horizon: [f32; 3],
    /// A clear sky whose radiance is added.
    pub clear: Option<ClearSky>,
    /// Clouds that are seen before it.
    pub clouds: Option<Clouds>,
}

/// Clear sky by the formula of Hosek and Wilkie 2012, for the frame's sun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClearSky {
    /// The coefficients A to I of each channel.
    pub coefficients: [[f32; 9]; 3],
    /// Factor on the formula of each channel: radiance, linear sRGB.
    pub radiance: [f32; 3],
}

/// Clouds on a plane overhead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clouds {
    /// Number of the texture: red is how dense they are, green how much of the sun reaches them; repeats.
    pub texture: u32,
    /// Share of the sky that they cover, 0..1.
    pub cover: f32,
    /// Radiance of a cloud in full sun, linear sRGB.
    pub lit: [f32; 3],
    /// Radiance of a cloud's shaded base, linear sRGB.
    pub shaded: [f32; 3],
}

/// What is seen where nothing stands. Light comes from the sky whatever is seen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Background {
    /// The sky, and the ground if there is one.
    #[default]
    Sky,
    /// One colour, as it is displayed, linear sRGB.
    Plain([f32; 3]),
    /// Nothing: straight alpha.
    Transparent,
}

/// The edge of a wood that closes a meadow off: what it looks like unrolled, seen from the meadow. Plain numbers, -1..1 in
/// 0..255 as in reliefs; rows from the tops to the ground; repeats along the edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wood {
    /// Number of the texture of what leaves cover in summer (0..1) and of their normal's parts to the right and up.
    pub form: u32,
    /// Number of the texture of the tree's kind (0..1 from the last to turn and shed to the first, -1 for what stays green), of
    /// the share of light that comes to its leaves (0..1), and of what wood covers behind them (0..1).
    pub crowns: u32,
    /// Number of the texture of how high other crowns stand before a place: the sines of their horizons over the edge's plane to
    /// the left, above and to the right, 0..1.
    pub horizons: u32,
    /// Distance of the edge, metres.
    pub distance: f32,
    /// Height that the textures span, metres.
    pub height: f32,
    /// How often they repeat around the whole horizon.
    pub repeats: u32,
    /// Share of the leaves that have fallen or are not out yet, 0..1.
    pub bareness: f32,
}

/// The ground, level at height 0 and drawn to the horizon but for what stands on it. Not part of an exported asset.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ground {
    /// Number of the texture of diffuse reflectance; repeats.
    pub texture: u32,
    /// Metres that one repeat of the texture covers.
    pub tile: f32,
    /// Distance at which haze hides all but 1/e of the ground, metres.
    pub haze: f32,
    /// The edge of a distant wood around it; none for an open horizon.
    pub wood: Option<Wood>,
    /// How much of what is seen of it are upright blades, 0 for bare soil to 1 for grass.
    pub blades: f32,
    /// How far grass has gone into its winter rest, 0 for a summer's meadow to 1.
    pub dormant: f32,
    /// The feet of trunks: x, z and radius, metres. They keep light off the ground about them.
    pub feet: Vec<[f32; 3]>,
    /// Whether the cover holds the ground's own surface: the level ground then lies behind all that stands.
    pub is_uneven: bool,
    /// Models that belong to the ground: grass, and itself where it is uneven. They cast no shadow.
    pub cover: Vec<Instance>,
}

/// How radiance becomes a displayed colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToneMap {
    /// Khronos PBR Neutral.
    Neutral,
    /// AgX: a wide range of light, colours that pale as they brighten.
    Agx,
    /// Clipping only: for tests of colour.
    None,
}

/// The white balance that changes nothing.
pub const UNBALANCED: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Lines over the edges of every triangle but those of the ground's cover.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wireframe {
    /// Width of a line, pixels, positive. An edge at a mesh's rim shows the half of it that lies on the surface.
    pub width: f32,
    /// Colour of the lines as it is displayed, linear sRGB.
    pub colour: [f32; 3],
}

/// The picture to draw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Samples a pixel: 1, 4, 8, 16, 32, 64, 128 or 256.
    pub samples: u32,
    /// Distance in pixels that a coarser mesh may lie from the full one where it stands; 0 for full meshes.
    pub lod_error: f32,
    /// Pixels along one side of the sun's shadow map; 0 for no shadow.
    pub shadow_size: u32,
    /// Factor on radiance before tone mapping.
    pub exposure: f32,
    /// Whether the exposure is measured from the picture instead.
    pub metered: bool,
    /// White balance: a map of linear sRGB, applied after the exposure; its rows.
    pub balance: [[f32; 3]; 3],
    /// The curve after it.
    pub tone_map: ToneMap,
    /// Lines over the meshes, if asked for; meshes are drawn in full then, whatever their distance.
    pub wireframe: Option<Wireframe>,
}

/// A resolved moment: what the two outputs are made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Meshes, each stored once; frames of a run share them.
    pub meshes: Vec<Arc<Mesh>>,
    /// Textures, each stored once; frames of a run share them.
    pub textures: Vec<Arc<Texture>>,
    /// Materials.
    pub materials: Vec<Material>,
    /// Models.
    pub models: Vec<Model>,
    /// Everything in the scene: the wood of each tree first, then the leaves, tree by tree, then those that have fallen.
    pub instances: Vec<Instance>,
    /// How many of the last instances have fallen: they are no part of the crowns, whose light and extent they leave alone.
    pub fallen: usize,
    /// The camera.
    pub camera: Camera,
    /// The sun.
    pub sun: Sun,
    /// The sky.
    pub sky: Sky,
    /// The ground, if there is one.
    pub ground: Option<Ground>,
    /// What is seen where nothing stands.
    pub background: Background,
    /// The picture.
    pub view: View,
}

impl Frame {
    /// The instances that stand: wood, and leaves on their twigs.
    #[must_use]
    pub fn standing(&self) -> &[Instance] {
        &self.instances[..self.instances.len().saturating_sub(self.fallen)]
    }
}
