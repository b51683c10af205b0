//! The crown as a coarse volume of leaf area, and the light inside it.
//!
//! A ray through foliage of density u (leaf area a volume) with leaves in all directions meets a leaf with probability
//! 1 - exp(-u s / 2) over a length s (Beer and Lambert with the spherical leaf angle distribution, Monsi and Saeki 1953).
//! From each cell 26 rays gather what the open sky and ground send and what the leaves on the way scatter; scattering is
//! followed for two rounds, so shade takes on the colour of the foliage around it. The result is smooth by nature; sharp
//! shadows come from the shadow map.

use super::atmosphere::{Ambient, Atmosphere, directions};
use super::cluster::ClusteredMesh;
use super::texture::MipMap;
use crate::base::maths::expf;
use crate::base::vector::Vec3;
use crate::frame::{Frame, Material};
use rayon::prelude::*;
use std::f32::consts::PI;
use std::sync::Arc;

/// Cells along the longest side of the crown, or of the largest tree of several.
const CELLS: f32 = 24.0;
/// Most cells of the volume about several trees; beyond it cells grow. Light gathers over a few metres of foliage, so a cell
/// may be half a metre wide before crowns look flat.
const MOST_CELLS: f32 = 300_000.0;
/// Share of leaf area that a ray meets: the projection of a spherical leaf angle distribution.
const PROJECTION: f32 = 0.5;

#[derive(Clone, Copy, Debug, Default)]
struct Cell {
    /// Leaf area a volume, 1/m.
    density: f32,
    /// Reflectance plus transmittance of the leaves, area-weighted.
    scattering: [f32; 3],
    /// Transmittance of the leaves, area-weighted.
    transmission: [f32; 3],
}

/// The light inside a crown.
pub(super) struct Canopy {
    low: Vec3,
    size: f32,
    counts: [usize; 3],
    cells: Vec<Cell>,
    /// Share of light that passes each cell straight.
    passed: Vec<f32>,
    /// Light from all sides but the sun's straight beam.
    ambient: Vec<Ambient>,
}

impl Canopy {
    /// Gathers the leaves of a frame; `None` without leaves.
    pub(super) fn new(
        frame: &Frame,
        meshes: &[Arc<ClusteredMesh>],
        textures: &[Arc<MipMap>],
        atmosphere: &Atmosphere,
    ) -> Option<Self> {
        let mut canopy = Self::around(frame, meshes)?;
        canopy.fill(frame, meshes, textures);
        let depth = PROJECTION * canopy.size;
        canopy.passed = canopy.cells.iter().map(|cell| expf(-depth * cell.density)).collect();
        let dark = vec![Ambient::default(); canopy.cells.len()];
        let first = canopy.gather(frame, atmosphere, &dark);
        canopy.ambient = canopy.gather(frame, atmosphere, &first);
        Some(canopy)
    }

    fn around(frame: &Frame, meshes: &[Arc<ClusteredMesh>]) -> Option<Self> {
        let mut leaves = frame.standing().iter().filter(|i| i.leaf.is_some()).map(|i| i.transform.translation);
        let first = leaves.next()?;
        let (low, high) = leaves.fold((first, first), |(low, high), p| (low.inf(&p), high.sup(&p)));
        // The volume reaches down to the ground, where the crown's shade falls.
        let low = Vec3::new(low.x, low.y.min(0.0), low.z);
        let extent = high - low;
        let size = match largest_of_several(frame, meshes) {
            Some(tree) => bounded((tree / CELLS).max(0.05), extent),
            None => (extent.max() / CELLS).max(0.05),
        };
        let low = low - Vec3::repeat(2.0 * size);
        let counts = ((high - low) / size).map(|cells| cells.ceil() as usize + 3);
        let counts = [counts.x, counts.y, counts.z];
        let cells = vec![Cell::default(); counts.iter().product()];
        Some(Self { low, size, counts, cells, passed: Vec::new(), ambient: Vec::new() })
    }

    fn fill(&mut self, frame: &Frame, meshes: &[Arc<ClusteredMesh>], textures: &[Arc<MipMap>]) {
        let optics: Vec<([f32; 3], [f32; 3])> = frame.materials.iter().map(|m| mean_optics(m, textures)).collect();
        let volume = self.size * self.size * self.size;
        for instance in frame.standing().iter().filter(|instance| instance.leaf.is_some()) {
            let scale = instance.transform.linear.column(0).norm();
            for part in &frame.models[instance.model as usize].parts {
                let mesh = &meshes[part.mesh as usize];
                let middle = mesh.full().first().map_or_else(Vec3::zeros, |cluster| cluster.centre);
                let density = mesh.area * scale * scale / volume;
                let (scattering, transmission) = optics[part.material as usize];
                self.splat(instance.transform.point(middle), density, scattering, transmission);
            }
        }
        for cell in self.cells.iter_mut().filter(|cell| cell.density > 0.0) {
            cell.scattering = cell.scattering.map(|s| s / cell.density);
            cell.transmission = cell.transmission.map(|t| t / cell.density);
        }
    }

    /// Spreads a leaf over the eight cells around it.
    fn splat(&mut self, at: Vec3, density: f32, scattering: [f32; 3], transmission: [f32; 3]) {
        for (index, weight) in self.corners(at) {
            let cell = &mut self.cells[index];
            let density = density * weight;
            cell.density += density;
            for k in 0..3 {
                cell.scattering[k] += scattering[k] * density;
                cell.transmission[k] += transmission[k] * density;
            }
        }
    }

    /// The eight cells around a point (clamped to the volume) with their trilinear weights.
    fn corners(&self, at: Vec3) -> [(usize, f32); 8] {
        let place = (at - self.low) / self.size - Vec3::repeat(0.5);
        let mut first = [0usize; 3];
        let mut part = [0.0f32; 3];
        for k in 0..3 {
            let inside = place[k].clamp(0.0, (self.counts[k] - 1) as f32 - 1e-3);
            first[k] = inside as usize;
            part[k] = inside - first[k] as f32;
        }
        std::array::from_fn(|corner| {
            let step = [corner & 1, corner >> 1 & 1, corner >> 2];
            let weight: f32 = (0..3).map(|k| if step[k] == 1 { part[k] } else { 1.0 - part[k] }).product();
            (self.index([first[0] + step[0], first[1] + step[1], first[2] + step[2]]), weight)
        })
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.counts[1] + y) * self.counts[0] + x
    }

    fn centre(&self, index: usize) -> Vec3 {
        let [nx, ny, _] = self.counts;
        let place = Vec3::new((index % nx) as f32, (index / nx % ny) as f32, (index / (nx * ny)) as f32);
        self.low + (place + Vec3::repeat(0.5)) * self.size
    }

    fn cell_at(&self, point: Vec3) -> Option<usize> {
        let place = (point - self.low) / self.size;
        let inside = (0..3).all(|k| place[k] >= 0.0 && place[k] < self.counts[k] as f32);
        inside.then(|| self.index([place.x as usize, place.y as usize, place.z as usize]))
    }

    /// The cells that a ray passes, a step of one cell's side after another, until it leaves the volume or meets the ground.
    fn cells_along(&self, from: Vec3, direction: Vec3) -> impl Iterator<Item = usize> {
        let longest = self.counts.iter().sum::<usize>();
        let point = move |step: usize| from + direction * ((step as f32 + 0.5) * self.size);
        (0..longest).map(point).take_while(|point| point.y >= 0.0).map_while(|point| self.cell_at(point))
    }

    /// Optical depth from a point towards the sun: in all, and of what leaves take out by not letting it through.
    fn sun_depth(&self, from: Vec3, sun: Vec3) -> (f32, [f32; 3]) {
        let mut depth = 0.0;
        let mut coloured = [0.0f32; 3];
        for index in self.cells_along(from, sun) {
            let cell = &self.cells[index];
            let step = PROJECTION * cell.density * self.size;
            depth += step;
            for k in 0..3 {
                coloured[k] += step * (1.0 - cell.transmission[k]);
            }
        }
        (depth, coloured)
    }

    /// One round of gathering at every cell, with the ambient light of the round before.
    fn gather(&self, frame: &Frame, atmosphere: &Atmosphere, before: &[Ambient]) -> Vec<Ambient> {
        let sun = frame.sun.direction;
        let strength = frame.sun.irradiance.map(|e| e * atmosphere.sun_share());
        let beams: Vec<(f32, [f32; 3])> =
            (0..self.cells.len()).into_par_iter().map(|index| self.sun_depth(self.centre(index), sun)).collect();
        // What the leaves of each cell send on: the beam meets half of their area, each side sends half of what is
        // scattered; ambient light is scattered as if it came evenly.
        let sent: Vec<[f32; 3]> = (0..self.cells.len())
            .map(|index| {
                let cell = &self.cells[index];
                std::array::from_fn(|k| {
                    let beam = strength[k] * expf(-beams[index].1[k]) * 0.25 / PI;
                    cell.scattering[k] * (beam + before[index].mean[k])
                })
            })
            .collect();
        (0..self.cells.len())
            .into_par_iter()
            .map(|index| {
                let mut ambient = Ambient::default();
                for (direction, share) in directions() {
                    ambient.add(direction, self.along(self.centre(index), direction, atmosphere, &sent), share);
                }
                let (depth, coloured) = beams[index];
                // The sun's light that has come through leaves: a narrow beam counts as its irradiance over 4 pi of the
                // sphere's mean radiance.
                let through: [f32; 3] =
                    std::array::from_fn(|k| strength[k] * (expf(-coloured[k]) - expf(-depth)).max(0.0));
                ambient.add(sun, through.map(|e| e / (4.0 * PI)), 1.0);
                ambient
            })
            .collect()
    }

    fn along(&self, from: Vec3, direction: Vec3, atmosphere: &Atmosphere, sent: &[[f32; 3]]) -> [f32; 3] {
        let mut clear = 1.0f32;
        let mut light = [0.0f32; 3];
        for index in self.cells_along(from, direction) {
            let passed = self.passed[index];
            if passed < 1.0 {
                let met = clear * (1.0 - passed);
                for k in 0..3 {
                    light[k] += met * sent[index][k];
                }
                clear *= passed;
                if clear < 1e-3 {
                    return light;
                }
            }
        }
        let beyond = atmosphere.radiance(direction);
        std::array::from_fn(|k| light[k] + clear * beyond[k])
    }

    /// Side of the cells that the light is gathered in, metres.
    pub(super) fn cell_size(&self) -> f32 {
        self.size
    }

    /// The light from all sides at a point; far outside the volume that of the open.
    pub(super) fn ambient(&self, at: Vec3, atmosphere: &Atmosphere) -> Ambient {
        let outside = self.distance_outside(at) / (3.0 * self.size);
        if outside >= 1.0 {
            return atmosphere.open;
        }
        let mut ambient = Ambient::default();
        for (index, weight) in self.corners(at) {
            ambient.add_weighted(&self.ambient[index], weight * (1.0 - outside));
        }
        ambient.add_weighted(&atmosphere.open, outside);
        ambient
    }

    fn distance_outside(&self, at: Vec3) -> f32 {
        let high = self.low + Vec3::from(self.counts.map(|count| count as f32)) * self.size;
        let gap = (self.low - at).sup(&(at - high)).sup(&Vec3::zeros());
        gap.norm()
    }
}

/// The longest side of the largest tree, metres, where several pieces of wood stand; `None` for a tree by itself.
fn largest_of_several(frame: &Frame, meshes: &[Arc<ClusteredMesh>]) -> Option<f32> {
    let wood: Vec<u32> = frame.standing().iter().filter(|i| i.leaf.is_none()).map(|i| i.model).collect();
    let mut models = wood.clone();
    models.sort_unstable();
    models.dedup();
    let extent = |model: &u32| {
        let parts = frame.models[*model as usize].parts.iter();
        let clusters = parts.flat_map(|part| meshes[part.mesh as usize].full());
        let boxes = clusters.map(|c| (c.centre - Vec3::repeat(c.radius), c.centre + Vec3::repeat(c.radius)));
        boxes.reduce(|(low, high), (l, h)| (low.inf(&l), high.sup(&h))).map(|(low, high)| (high - low).max())
    };
    models.iter().filter(|_| wood.len() > 1).filter_map(extent).reduce(f32::max)
}

/// A cell's side that is large enough for the volume to hold no more than the most cells.
fn bounded(size: f32, extent: Vec3) -> f32 {
    let mut size = size;
    while extent.iter().map(|side| side / size + 6.0).product::<f32>() > MOST_CELLS {
        size *= 1.05;
    }
    size
}

/// Mean reflectance plus transmittance, and mean transmittance, of a material.
fn mean_optics(material: &Material, textures: &[Arc<MipMap>]) -> ([f32; 3], [f32; 3]) {
    let mean = |factor: [f32; 3], texture: Option<u32>| -> [f32; 3] {
        let colour = texture.map_or([1.0; 3], |number| textures[number as usize].mean());
        std::array::from_fn(|k| factor[k] * colour[k])
    };
    let reflected = mean(material.colour, material.reflected);
    let transmitted = mean(material.transmission, material.transmitted);
    (std::array::from_fn(|k| reflected[k] + transmitted[k]), transmitted)
}
