//! What light a seen point sends to the eye.
//!
//! Leaves reflect and transmit diffusely on both sides, L = (rho E_front + tau E_back) / pi, with a gloss lobe of
//! microfacets on top (GGX, Walter et al. 2007; Schlick's Fresnel term); wood and ground only reflect.

use super::Prepared;
use super::atmosphere::Ambient;
use super::texture::{MipMap, Taps};
use super::tile::Visible;
use super::wireframe;
use crate::base::random::hash;
use crate::base::vector::{Affine, Vec2, Vec3};
use crate::frame::{GroundPart, Material};
use std::f32::consts::PI;

/// A point of a surface as the eye sees it.
struct Point {
    position: Vec3,
    /// Unit normal on the side of the eye.
    normal: Vec3,
    /// Whether the eye sees the side that the mesh's normals point away from.
    behind: bool,
    uv: Vec2,
    /// Width of a pixel on the surface, texture units.
    footprint: f32,
    /// Unit vector to the eye.
    to_eye: Vec3,
    salt: u64,
}

impl Prepared<'_> {
    /// Light from all sides at a point, without the sun's straight beam.
    pub(super) fn ambient(&self, at: Vec3) -> Ambient {
        let within = self.canopy.as_ref().and_then(|canopy| canopy.ambient(at, &self.atmosphere));
        let mut reads = self.reads.borrow_mut();
        (reads.crowns, reads.open) = (reads.crowns || within.is_some(), reads.open || within.is_none());
        within.unwrap_or(self.atmosphere.open)
    }

    /// Radius up to which the light from all sides is even over a leaf, metres.
    fn ambient_detail(&self) -> f32 {
        self.canopy.as_ref().map_or(f32::INFINITY, |canopy| canopy.cell_size() * 0.5)
    }

    /// The share of the sun's disc that a point sees past what stands before it.
    pub(super) fn shade(&self, point: Vec3, normal: Vec3, salt: u64) -> f32 {
        let mut reads = self.reads.borrow_mut();
        reads.sun = true;
        self.shadow.as_ref().map_or(1.0, |map| map.lit(point, normal, salt, &mut reads))
    }

    /// The sun's irradiance on a surface that faces it, after shadow.
    fn sun(&self, point: Vec3, normal: Vec3, salt: u64) -> [f32; 3] {
        let lit = self.shade(point, normal, salt) * self.atmosphere.sun_share();
        self.frame.sun.irradiance.map(|e| e * lit)
    }
}

/// What textures show at a point; places are found once for all that are laid out alike.
struct Looks<'a> {
    prepared: &'a Prepared<'a>,
    uv: Vec2,
    footprint: f32,
    taps: Option<(&'a MipMap, Taps)>,
}

impl<'a> Looks<'a> {
    fn new(prepared: &'a Prepared<'a>, point: &Point) -> Self {
        Self { prepared, uv: point.uv, footprint: point.footprint, taps: None }
    }

    /// A texture with where to read it.
    #[inline(always)]
    fn taps(&mut self, texture: u32) -> (&'a MipMap, &Taps) {
        let map: &MipMap = &self.prepared.textures[texture as usize];
        if self.taps.as_ref().is_some_and(|(other, _)| !map.is_laid_out_like(other)) {
            self.taps = None;
        }
        let (uv, footprint) = (self.uv, self.footprint);
        let (_, taps) = self.taps.get_or_insert_with(|| (map, map.taps(uv, footprint)));
        (map, taps)
    }

    fn read(&mut self, texture: u32) -> [f32; 3] {
        let (map, taps) = self.taps(texture);
        map.read(taps)
    }

    /// The normal that a relief shows, where it is not as good as upright.
    fn relief(&mut self, texture: u32) -> Option<[f32; 3]> {
        let (map, taps) = self.taps(texture);
        (!map.is_flat(taps)).then(|| map.read(taps))
    }

    fn colour(&mut self, factor: [f32; 3], texture: Option<u32>) -> [f32; 3] {
        let Some(number) = texture else { return factor };
        let texel = self.read(number);
        std::array::from_fn(|k| factor[k] * texel[k])
    }
}

/// Light from all sides at a point of an item. Over a leaf that is small against the cells that the light was gathered in it
/// hardly changes, so that it is looked up once.
fn ambient(prepared: &Prepared, visible: &mut Visible, point: &Point) -> Ambient {
    let Visible { cluster, instance, scale, .. } = *visible;
    if instance.leaf.is_none() || cluster.radius * scale > prepared.ambient_detail() {
        return prepared.ambient(point.position);
    }
    *visible.ambient.get_or_insert_with(|| prepared.ambient(instance.transform.point(cluster.centre)))
}

/// A colour seen through the air before it. Over an item that is small in the picture the air is the same.
fn through_air(prepared: &Prepared, visible: &mut Visible, point: &Point, colour: [f32; 3]) -> [f32; 3] {
    let eye = prepared.projection.eye;
    if !visible.item.is_small {
        return prepared.atmosphere.hazed(colour, point.position - eye);
    }
    let middle = || visible.instance.transform.point(visible.cluster.centre);
    let air = visible.air.get_or_insert_with(|| prepared.atmosphere.air(middle() - eye));
    std::array::from_fn(|k| colour[k] * air[k][0] + air[k][1])
}

/// The normal on the side of the eye, turned by what the surface's relief says.
fn in_relief([across, up, out]: [f32; 3], visible: &Visible, triangle: u16, point: &Point) -> Vec3 {
    let side = if point.behind { -1.0 } else { 1.0 };
    let along = along(visible, triangle);
    // What is a groove above is a ridge below.
    let turned = point.normal * out + (along[0] * across + along[1] * up) * side;
    turned.try_normalize(1e-6).unwrap_or(point.normal)
}

/// Radiance of a triangle of a visible item at a point of the picture, with the lines of its edges where they are asked for.
pub(super) fn surface(prepared: &Prepared, visible: &mut Visible, triangle: u16, at: [f32; 2]) -> [f32; 3] {
    let lit = lit(prepared, visible, triangle, at);
    match prepared.frame.view.wireframe {
        Some(lines) => wireframe::over(prepared, visible, triangle, at, lines, lit),
        None => lit,
    }
}

/// The unit normal of a triangle of a visible item on the side of the eye at a point of the picture.
pub(super) fn normal(prepared: &Prepared, visible: &Visible, triangle: u16, at: [f32; 2]) -> Vec3 {
    point(prepared, visible, triangle, at).normal
}

/// Radiance of a triangle of an item at a point of the picture.
#[inline(always)]
fn lit(prepared: &Prepared, visible: &mut Visible, triangle: u16, at: [f32; 2]) -> [f32; 3] {
    let material = visible.material;
    if material.ground == GroundPart::Blades {
        return blades(prepared, visible, triangle, at);
    }
    let mut point = point(prepared, visible, triangle, at);
    if material.ground == GroundPart::Surface {
        return prepared.uneven_ground(point.position, point.normal, point.salt);
    }
    let seen = if point.behind { material.behind.or(material.reflected) } else { material.reflected };
    let mut looks = Looks::new(prepared, &point);
    let mut reflected = looks.colour(material.colour, seen);
    if material.unlit {
        return reflected.map(|r| r / prepared.frame.view.exposure);
    }
    if point.behind {
        reflected = reflected.map(|r| (r * material.back_gain).min(0.95));
    }
    if let Some(relief) = material.relief.and_then(|number| looks.relief(number)) {
        point.normal = in_relief(relief, visible, triangle, &point);
    }
    let ambient = ambient(prepared, visible, &point);
    let sun_direction = prepared.frame.sun.direction;
    let facing = point.normal.dot(&sun_direction);
    let lit_side = if facing >= 0.0 { point.normal } else { -point.normal };
    let sun = prepared.sun(point.position, lit_side, point.salt).map(|e| e * facing.abs());
    let front = ambient.irradiance(point.normal);
    let mut colour: [f32; 3] = std::array::from_fn(|k| reflected[k] * front[k] / PI);
    if material.transmission.iter().any(|&t| t > 0.0) {
        let transmitted = looks.colour(material.transmission, material.transmitted);
        let back = ambient.irradiance(-point.normal);
        for k in 0..3 {
            colour[k] += transmitted[k] * back[k] / PI;
        }
        if facing < 0.0 {
            for k in 0..3 {
                colour[k] += transmitted[k] * sun[k] / PI;
            }
        }
    }
    if facing > 0.0 {
        for k in 0..3 {
            colour[k] += reflected[k] * sun[k] / PI;
        }
    }
    if material.gloss > 0.0 {
        let lobe = if facing > 0.0 { gloss(material, &point, sun_direction) } else { 0.0 };
        // The surroundings in the gloss: as Fresnel's term would mirror the light on that side, softened by roughness.
        let mirror =
            schlick(material.gloss, point.normal.dot(&point.to_eye).max(0.0)) * (1.0 - 0.5 * material.roughness);
        for k in 0..3 {
            let beam = if facing > 0.0 { sun[k] / facing.max(1e-3) * lobe * facing } else { 0.0 };
            colour[k] += beam + mirror * front[k] / PI;
        }
    }
    if prepared.frame.ground.is_some() { through_air(prepared, visible, &point, colour) } else { colour }
}

/// Radiance of a blade of grass, as that of the sward in which it stands: found once for a cluster of blades, over which it hardly
/// changes.
fn blades(prepared: &Prepared, visible: &mut Visible, triangle: u16, at: [f32; 2]) -> [f32; 3] {
    let Visible { cluster, instance, material, salt: known_by, .. } = *visible;
    let Met { position, uv, .. } = met(visible, triangle, at);
    let share = Looks { prepared, uv, footprint: 0.0, taps: None }.colour(material.colour, material.reflected);
    let sward = visible.sward.get_or_insert_with(|| {
        let Affine { linear, .. } = &instance.transform;
        prepared.sward_about(instance.transform.point(cluster.centre), linear.column(1).normalize())
    });
    sward.radiance(share, prepared.shade(position, sward.normal, salt(known_by, at)))
}

/// Barycentric coordinates of what a triangle, mapped to the picture, shows at a point of it: homogeneous ones (Olano and Greer
/// 1997), which need no clipping.
fn weights([a, b, c]: [Vec3; 3], at: [f32; 2]) -> [f32; 3] {
    let ray = Vec3::new(at[0], at[1], 1.0);
    let weights = [b.cross(&c).dot(&ray), c.cross(&a).dot(&ray), a.cross(&b).dot(&ray)];
    let sum = weights[0] + weights[1] + weights[2];
    if sum == 0.0 { [1.0 / 3.0; 3] } else { inside(weights.map(|w| w / sum)) }
}

fn blended(values: [Vec3; 3], weights: [f32; 3]) -> Vec3 {
    values[0] * weights[0] + values[1] * weights[1] + values[2] * weights[2]
}

/// What turns the grain of shadows at a point of the picture, by what an instance is known by.
fn salt(known_by: u64, at: [f32; 2]) -> u64 {
    hash(known_by, (at[0] as u64) << 32 | at[1] as u64)
}

/// What of a triangle is met behind a point of the picture.
struct Met {
    /// Numbers of the triangle's vertices in its cluster.
    numbers: [usize; 3],
    /// Barycentric coordinates.
    weights: [f32; 3],
    position: Vec3,
    uv: Vec2,
}

#[inline(always)]
fn met(visible: &Visible, triangle: u16, at: [f32; 2]) -> Met {
    let Visible { cluster, instance, map, .. } = visible;
    let numbers = cluster.triangles[usize::from(triangle)].map(usize::from);
    let corners = numbers.map(|v| cluster.positions[v]);
    let weights = weights(corners.map(|p| map.point(p)), at);
    let position = instance.transform.point(blended(corners, weights));
    let [p, q, r] = numbers.map(|v| cluster.uvs[v]);
    Met { numbers, weights, position, uv: p * weights[0] + q * weights[1] + r * weights[2] }
}

/// Finds the point of a triangle behind a point of the picture.
#[inline(always)]
fn point(prepared: &Prepared, visible: &Visible, triangle: u16, at: [f32; 2]) -> Point {
    let Met { numbers, weights, position, uv } = met(visible, triangle, at);
    let Visible { cluster, instance, scale, uv_per_metre, .. } = visible;
    let linear = &instance.transform.linear;
    let corners = numbers.map(|v| cluster.positions[v]);
    let flat = linear * (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
    let smooth = linear * blended(numbers.map(|v| cluster.normals[v]), weights);
    let offset = prepared.projection.eye - position;
    let distance = offset.norm();
    let to_eye = offset / distance.max(1e-6);
    let behind = flat.dot(&to_eye) < 0.0;
    let smooth = smooth.try_normalize(1e-12).unwrap_or(to_eye);
    let normal = if behind { -smooth } else { smooth };
    let slant = normal.dot(&to_eye).abs().max(0.25);
    let footprint = distance / prepared.projection.pixels_per_metre * uv_per_metre / (scale.max(1e-12) * slant.sqrt());
    let salt = salt(visible.salt, at);
    Point { position, normal, behind, uv, footprint, to_eye, salt }
}

/// Unit vectors in which u and -v grow on a triangle; zero where the texture has no direction.
fn along(visible: &Visible, triangle: u16) -> [Vec3; 2] {
    let Visible { cluster, instance, scale, .. } = visible;
    let numbers = cluster.triangles[usize::from(triangle)].map(usize::from);
    let [p, q, r] = numbers.map(|v| cluster.positions[v]);
    let [t, u, v] = numbers.map(|v| cluster.uvs[v]);
    let (sides, [a, b]) = ([q - p, r - p], [u - t, v - t]);
    let doubled = a.x * b.y - a.y * b.x;
    let linear = &instance.transform.linear;
    let unit = |v: Vec3| linear * (v.try_normalize(1e-20).unwrap_or_default() * doubled.signum()) / scale.max(1e-12);
    [unit(sides[0] * b.y - sides[1] * a.y), unit(sides[0] * b.x - sides[1] * a.x)]
}

/// Weights moved into the triangle: the middle of the samples that a cluster owns may lie beside this triangle.
fn inside(weights: [f32; 3]) -> [f32; 3] {
    let clamped = weights.map(|w| if w.is_finite() { w.clamp(0.0, 1.0) } else { 1.0 / 3.0 });
    let sum = (clamped[0] + clamped[1] + clamped[2]).max(1e-6);
    clamped.map(|w| w / sum)
}

/// The gloss lobe's share of the irradiance that is sent to the eye, without the cosine at the surface.
fn gloss(material: &Material, point: &Point, light: Vec3) -> f32 {
    let half = (light + point.to_eye).normalize();
    let (n_h, n_v, n_l) = (
        point.normal.dot(&half).max(0.0),
        point.normal.dot(&point.to_eye).max(0.05),
        point.normal.dot(&light).max(0.05),
    );
    let alpha = (material.roughness * material.roughness).max(1e-3);
    let squared = alpha * alpha;
    let denominator = n_h * n_h * (squared - 1.0) + 1.0;
    let distribution = squared / (PI * denominator * denominator);
    let masking = |c: f32| c + (squared + (1.0 - squared) * c * c).sqrt();
    distribution * schlick(material.gloss, half.dot(&light).max(0.0)) / (masking(n_v) * masking(n_l))
}

fn schlick(normal_incidence: f32, cosine: f32) -> f32 {
    let grazing = 1.0 - cosine.min(1.0);
    let square = grazing * grazing;
    normal_incidence + (1.0 - normal_incidence) * square * square * grazing
}
