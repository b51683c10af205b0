//! Materials and the pictures they read.
//!
//! Base colour is the reflectance, so that a reader of core glTF shows the right tree. Light through the leaf goes into
//! `KHR_materials_diffuse_transmission`, which such a reader ignores. The extension splits diffuse light: a share (the
//! factor) passes, tinted by the transmission colour, and only the rest is reflected. The share is therefore the largest
//! transmittance that the material reaches, the least that can carry it: what passes is exact, and a reader that knows the
//! extension reflects less by that share. Normals go into the core's normal texture, whose frame readers take from the
//! texture coordinates. A lower side of its own cannot be said in glTF without a second copy of every leaf, so leaves wear
//! their upper side on both. Charts are `KHR_materials_unlit`; readers without it show them lit.

use super::document::{Document, Shown};
use super::{ExportError, png};
use crate::base::maths::{linear_to_srgb8, srgb_to_linear};
use crate::frame::{self, Material};
use gltf_json::extensions::material::Material as Extensions;
use gltf_json::image::MimeType;
use gltf_json::material::{NormalTexture, PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor};
use gltf_json::texture::{Info, MagFilter, MinFilter, Sampler, WrappingMode};
use gltf_json::validation::Checked::Valid;
use gltf_json::{Image, Index, Texture, Value};
use serde_json::json;

const DIFFUSE_TRANSMISSION: &str = "KHR_materials_diffuse_transmission";
const UNLIT: &str = "KHR_materials_unlit";

impl Document<'_> {
    /// The glTF material of a material of the frame.
    pub(super) fn material(&mut self, number: u32) -> Result<Index<gltf_json::Material>, ExportError> {
        if let Some(&known) = self.materials.get(&number) {
            return Ok(known);
        }
        let material = &self.frame.materials[number as usize];
        let reflected = material.reflected.map(|t| self.texture(Shown::Reflected(t))).transpose()?;
        let relief = material.relief.filter(|_| !material.unlit);
        let normal_texture = relief.map(|t| self.texture(Shown::Relief(t))).transpose()?.map(|index| NormalTexture {
            index,
            scale: 1.0,
            tex_coord: 0,
            extensions: None,
            extras: Default::default(),
        });
        let extensions = if material.unlit { Some(self.unlit()) } else { self.transmission(number, material)? };
        let [r, g, b] = material.colour.map(|x| x.clamp(0.0, 1.0));
        let written = gltf_json::Material {
            double_sided: material.two_sided,
            name: Some(self.material_names.give(&material.name)),
            pbr_metallic_roughness: PbrMetallicRoughness {
                base_color_factor: PbrBaseColorFactor([r, g, b, 1.0]),
                base_color_texture: reflected.map(info),
                metallic_factor: StrengthFactor(0.0),
                roughness_factor: StrengthFactor(material.roughness.clamp(0.0, 1.0)),
                ..PbrMetallicRoughness::default()
            },
            normal_texture,
            extensions,
            ..gltf_json::Material::default()
        };
        let index = self.root.push(written);
        self.materials.insert(number, index);
        Ok(index)
    }

    fn unlit(&mut self) -> Extensions {
        self.extensions.insert(UNLIT);
        let mut extensions = Extensions::default();
        extensions.others.insert(UNLIT.to_owned(), json!({}));
        extensions
    }

    fn transmission(&mut self, number: u32, material: &Material) -> Result<Option<Extensions>, ExportError> {
        let texture = material.transmitted.map(|t| self.frame.textures[t as usize].as_ref());
        let share = largest_transmittance(material, texture);
        if share <= 0.0 {
            return Ok(None);
        }
        self.extensions.insert(DIFFUSE_TRANSMISSION);
        let mut value = json!({ "diffuseTransmissionFactor": share });
        if let Some(texture) = material.transmitted {
            let index = self.texture(Shown::Transmitted(texture, number))?;
            value["diffuseTransmissionColorTexture"] = json!({ "index": index.value() });
        } else {
            let tint = material.transmission.map(|x| (x / share).clamp(0.0, 1.0));
            value["diffuseTransmissionColorFactor"] = Value::from(tint.map(f64::from).to_vec());
        }
        let mut extensions = Extensions::default();
        extensions.others.insert(DIFFUSE_TRANSMISSION.to_owned(), value);
        Ok(Some(extensions))
    }

    fn texture(&mut self, shown: Shown) -> Result<Index<Texture>, ExportError> {
        if let Some(&known) = self.textures.get(&shown) {
            return Ok(known);
        }
        let (Shown::Reflected(number) | Shown::Transmitted(number, _) | Shown::Relief(number)) = shown;
        let texture = &self.frame.textures[number as usize];
        let (name, file) = match shown {
            Shown::Reflected(_) | Shown::Relief(_) => (texture.name.clone(), encoded(texture, &texture.pixels)?),
            Shown::Transmitted(_, material) => {
                let material = &self.frame.materials[material as usize];
                (format!("{}_through_{}", texture.name, material.name), encoded(texture, &tint(material, texture))?)
            }
        };
        let source = self.image(&name, &file);
        let sampler = Some(self.sampler(texture.repeat));
        let (extensions, extras) = (None, Default::default());
        let index = self.root.push(Texture { name: None, sampler, source, extensions, extras });
        self.textures.insert(shown, index);
        Ok(index)
    }

    fn image(&mut self, name: &str, file: &[u8]) -> Index<Image> {
        let view = self.buffer.view(&mut self.root, file, None);
        self.root.push(Image {
            buffer_view: Some(view),
            mime_type: Some(MimeType("image/png".to_owned())),
            name: Some(self.texture_names.give(name)),
            uri: None,
            extensions: None,
            extras: Default::default(),
        })
    }

    fn sampler(&mut self, repeat: bool) -> Index<Sampler> {
        let root = &mut self.root;
        *self.samplers.entry(repeat).or_insert_with(|| {
            let wrap = || Valid(if repeat { WrappingMode::Repeat } else { WrappingMode::ClampToEdge });
            root.push(Sampler {
                mag_filter: Some(Valid(MagFilter::Linear)),
                min_filter: Some(Valid(MinFilter::LinearMipmapLinear)),
                wrap_s: wrap(),
                wrap_t: wrap(),
                ..Sampler::default()
            })
        })
    }
}

fn info(index: Index<Texture>) -> Info {
    Info { index, tex_coord: 0, extensions: None, extras: Default::default() }
}

fn encoded(texture: &frame::Texture, pixels: &[[u8; 3]]) -> Result<Vec<u8>, ExportError> {
    png::opaque(texture.width, texture.height, pixels)
}

/// The largest transmittance of any texel and channel, 0..1.
fn largest_transmittance(material: &Material, texture: Option<&frame::Texture>) -> f32 {
    let brightest = texture.map_or([255; 3], |texture| {
        texture.pixels.iter().fold([0; 3], |most, pixel| [0, 1, 2].map(|c: usize| most[c].max(pixel[c])))
    });
    let channel = |c: usize| material.transmission[c] * linear(brightest[c]);
    channel(0).max(channel(1)).max(channel(2)).clamp(0.0, 1.0)
}

/// Transmittance divided by the largest, as 8-bit sRGB.
fn tint(material: &Material, texture: &frame::Texture) -> Vec<[u8; 3]> {
    let share = largest_transmittance(material, Some(texture));
    let code = |c: usize, x: u8| linear_to_srgb8(linear(x) * material.transmission[c] / share);
    let tables: [Vec<u8>; 3] = [0, 1, 2].map(|c| (0..=255).map(|x| code(c, x)).collect());
    texture.pixels.iter().map(|pixel| [0, 1, 2].map(|c: usize| tables[c][usize::from(pixel[c])])).collect()
}

fn linear(code: u8) -> f32 {
    srgb_to_linear(f32::from(code) / 255.0)
}
