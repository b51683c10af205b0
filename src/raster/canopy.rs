//! The crown as a coarse volume of leaf area, and the light inside it.
//!
//! A ray through foliage of density u (leaf area a volume) with leaves in all directions meets a leaf with probability
//! 1 - exp(-u s / 2) over a length s (Beer and Lambert with the spherical leaf angle distribution, Monsi and Saeki 1953).
//! Light is followed along the 26 directions to a cell's neighbours, one sweep over the volume each (discrete ordinates,
//! Chandrasekhar 1960): each cell sees its neighbour's light dimmed by the leaves between, and what these scatter. A second
//! round scatters the light of the first, so shade takes on the colour of the foliage around it. The result is smooth by
//! nature; sharp shadows come from the shadow map.

use super::atmosphere::{Ambient, Atmosphere, directions, steps};
use super::cluster::ClusteredMesh;
use super::texture::{MipMap, optics};
use crate::base::maths::expf;
use crate::base::vector::Vec3;
use crate::frame::{Frame, Material};
use rayon::prelude::*;
use std::f32::consts::PI;
use std::sync::Arc;

/// Cells along the longest side of the crown, or of the largest tree of several.
const CELLS: f32 = 22.0;
/// Most cells of the volume about several trees; beyond it cells grow. Light gathers over a few metres of foliage, so a cell
/// may be half a metre wide before crowns look flat.
const MOST_CELLS: f32 = 120_000.0;
/// Rounds of scattering.
const ROUNDS: usize = 2;
/// Directions that are swept at once; fixed, so that sums have one order on any machine.
const TOGETHER: usize = 4;
/// Share of leaf area that a ray meets: the projection of a spherical leaf angle distribution.
const PROJECTION: f32 = 0.5;

#[derive(Clone, Copy, Debug, Default)]
struct Cell {
    /// Leaf area a volume, 1/m.
    density: f32,
    /// The same of the leaves whose colours it has, 1/m.
    coloured: f32,
    /// Reflectance plus transmittance of the leaves, area-weighted.
    scattering: [f32; 3],
    /// Transmittance of the leaves, area-weighted.
    transmission: [f32; 3],
}

/// The sun's light at a cell, as a share of what comes in from above.
#[derive(Clone, Copy)]
struct Beam {
    /// All that comes straight or through leaves.
    all: [f32; 3],
    /// What has come through leaves.
    through: [f32; 3],
}

/// The light inside a crown.
pub(super) struct Canopy {
    low: Vec3,
    size: f32,
    counts: [usize; 3],
    /// Height of the ground, metres.
    floor: f32,
    cells: Vec<Cell>,
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
        let beams: Vec<Beam> = (0..canopy.cells.len()).into_par_iter().map(|cell| canopy.beam(cell, frame)).collect();
        let strength = frame.sun.irradiance.map(|e| e * atmosphere.sun_share());
        let mut mean: Vec<[f32; 3]> = canopy.cells.iter().map(|cell| guessed(cell, atmosphere)).collect();
        for _ in 0..ROUNDS {
            let sent: Vec<[f32; 3]> = canopy
                .cells
                .iter()
                .zip(&beams)
                .zip(&mean)
                .map(|((cell, beam), mean)| sent(cell, beam, strength, mean))
                .collect();
            canopy.ambient = canopy.gathered(atmosphere, &sent);
            mean = canopy.ambient.iter().map(|ambient| ambient.mean).collect();
        }
        for (ambient, beam) in canopy.ambient.iter_mut().zip(&beams) {
            // A narrow beam counts as its irradiance over 4 pi of the sphere's mean radiance.
            let through = std::array::from_fn(|k| strength[k] * beam.through[k] / (4.0 * PI));
            ambient.add(frame.sun.direction, through, 1.0);
        }
        Some(canopy)
    }

    fn around(frame: &Frame, meshes: &[Arc<ClusteredMesh>]) -> Option<Self> {
        let mut leaves = frame.standing().iter().filter(|i| i.leaf.is_some()).map(|i| i.transform.translation);
        let first = leaves.next()?;
        let (low, high) = leaves.fold((first, first), |(low, high), p| (low.inf(&p), high.sup(&p)));
        // The volume reaches down to the ground, where the crown's shade falls: to the lowest foot of a tree.
        let feet = frame.standing().iter().filter(|i| i.leaf.is_none()).map(|i| i.transform.translation.y);
        let floor = feet.reduce(f32::min).unwrap_or(0.0);
        let low = Vec3::new(low.x, low.y.min(floor), low.z);
        let extent = high - low;
        let size = match largest_of_several(frame, meshes) {
            Some(tree) => bounded((tree / CELLS).max(0.05), extent),
            None => (extent.max() / CELLS).max(0.05),
        };
        let low = low - Vec3::repeat(2.0 * size);
        let counts = ((high - low) / size).map(|cells| cells.ceil() as usize + 3);
        let counts = [counts.x, counts.y, counts.z];
        let cells = vec![Cell::default(); counts.iter().product()];
        Some(Self { low, size, counts, floor, cells, ambient: Vec::new() })
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
        let mut all = Cell::default();
        for cell in &self.cells {
            all.coloured += cell.coloured;
            for k in 0..3 {
                all.scattering[k] += cell.scattering[k];
                all.transmission[k] += cell.transmission[k];
            }
        }
        for cell in &mut self.cells {
            // A cell that has only a share of its neighbours' leaves takes the colour of all.
            let of = if cell.coloured > 0.0 { *cell } else { all };
            cell.scattering = of.scattering.map(|s| s / of.coloured.max(1e-12));
            cell.transmission = of.transmission.map(|t| t / of.coloured.max(1e-12));
        }
    }

    /// Spreads a leaf's area over the eight cells around it; its colour goes to the cell that it lies in.
    fn splat(&mut self, at: Vec3, density: f32, scattering: [f32; 3], transmission: [f32; 3]) {
        let mut nearest = (0, 0.0);
        for (index, weight) in self.corners(at) {
            self.cells[index].density += density * weight;
            if weight > nearest.1 {
                nearest = (index, weight);
            }
        }
        let cell = &mut self.cells[nearest.0];
        cell.coloured += density;
        for k in 0..3 {
            cell.scattering[k] += scattering[k] * density;
            cell.transmission[k] += transmission[k] * density;
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
        (0..longest).map(point).take_while(|point| point.y >= self.floor).map_while(|point| self.cell_at(point))
    }

    /// The sun's beam at a cell.
    fn beam(&self, cell: usize, frame: &Frame) -> Beam {
        let mut depth = 0.0;
        let mut coloured = [0.0f32; 3];
        for index in self.cells_along(self.centre(cell), frame.sun.direction) {
            let cell = &self.cells[index];
            if cell.density > 0.0 {
                let step = PROJECTION * cell.density * self.size;
                depth += step;
                for k in 0..3 {
                    coloured[k] += step * (1.0 - cell.transmission[k]);
                }
            }
        }
        let all = coloured.map(|c| expf(-c));
        let straight = expf(-depth);
        Beam { all, through: all.map(|all| (all - straight).max(0.0)) }
    }

    /// The light that comes to every cell along all directions, given what the leaves of each send on.
    fn gathered(&self, atmosphere: &Atmosphere, sent: &[[f32; 3]]) -> Vec<Ambient> {
        let mut ambient = vec![Ambient::default(); self.cells.len()];
        let directions: Vec<([i32; 3], (Vec3, f32))> = steps().zip(directions()).collect();
        // Half of a cell's leaves, along a step to a face, an edge and a corner.
        let halves: Vec<[f32; 3]> = self.cells.iter().map(|cell| half_passed(cell.density * self.size)).collect();
        for some in directions.chunks(TOGETHER) {
            let swept: Vec<Vec<[f32; 3]>> = some
                .par_iter()
                .map(|(step, (d, _))| self.swept(*step, atmosphere.radiance(*d), &halves, sent))
                .collect();
            ambient.par_iter_mut().enumerate().for_each(|(cell, ambient)| {
                for ((_, (direction, share)), light) in some.iter().zip(&swept) {
                    ambient.add(*direction, light[cell], *share);
                }
            });
        }
        ambient
    }

    /// The light that comes to every cell from one side, where `beyond` comes from outside: cell by cell away from it.
    fn swept(&self, step: [i32; 3], beyond: [f32; 3], halves: &[[f32; 3]], sent: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let mut light = vec![beyond; self.cells.len()];
        let length = step.iter().map(|s| s.unsigned_abs() as usize).sum::<usize>() - 1;
        let places = |k: usize| -> Vec<usize> {
            let count = self.counts[k];
            let first = usize::from(step[k] < 0);
            let last = if step[k] > 0 { count - 1 } else { count };
            // What lies towards the light comes first.
            if step[k] > 0 { (first..last).rev().collect() } else { (first..last).collect() }
        };
        let [columns, rows, layers] = [places(0), places(1), places(2)];
        let strides = [1, self.counts[0] as isize, (self.counts[0] * self.counts[1]) as isize];
        let offset: isize = (0..3).map(|k| step[k] as isize * strides[k]).sum();
        // Below the ground nothing is met: what the ground sends comes from there.
        let ground = (-self.low.y / self.size) as usize;
        for &z in &layers {
            for &y in rows.iter().filter(|&&y| y.saturating_add_signed(step[1] as isize) >= ground) {
                for &x in &columns {
                    let cell = self.index([x, y, z]);
                    let before = cell.wrapping_add_signed(offset);
                    let (near, far) = (halves[cell][length], halves[before][length]);
                    if near == 1.0 && far == 1.0 {
                        light[cell] = light[before];
                        continue;
                    }
                    light[cell] = std::array::from_fn(|k| {
                        let come = light[before][k] * far + (1.0 - far) * sent[before][k];
                        come * near + (1.0 - near) * sent[cell][k]
                    });
                }
            }
        }
        light
    }

    /// Side of the cells that the light is gathered in, metres.
    pub(super) fn cell_size(&self) -> f32 {
        self.size
    }

    /// Whether another has its cells in the same places.
    pub(super) fn has_extent_of(&self, other: &Self) -> bool {
        let extent = |canopy: &Self| (canopy.low, canopy.size, canopy.counts);
        extent(self) == extent(other)
    }

    /// The light from all sides at a point; none far outside the volume, where it is that of the open.
    pub(super) fn ambient(&self, at: Vec3, atmosphere: &Atmosphere) -> Option<Ambient> {
        let outside = self.distance_outside(at) / (3.0 * self.size);
        if outside >= 1.0 {
            return None;
        }
        let mut ambient = Ambient::default();
        for (index, weight) in self.corners(at) {
            ambient.add_weighted(&self.ambient[index], weight * (1.0 - outside));
        }
        ambient.add_weighted(&atmosphere.open, outside);
        Some(ambient)
    }

    fn distance_outside(&self, at: Vec3) -> f32 {
        let high = self.low + Vec3::from(self.counts.map(|count| count as f32)) * self.size;
        let gap = (self.low - at).sup(&(at - high)).sup(&Vec3::zeros());
        gap.norm()
    }
}

/// What the leaves of a cell send on: the beam meets half of their area, each side sends half of what is scattered; light from
/// all sides is scattered as if it came evenly.
fn sent(cell: &Cell, beam: &Beam, strength: [f32; 3], mean: &[f32; 3]) -> [f32; 3] {
    std::array::from_fn(|k| cell.scattering[k] * (strength[k] * beam.all[k] * 0.25 / PI + mean[k]))
}

/// The light that scattering starts from: none for dark leaves; leaves that scatter all light leave it as it is in the open.
fn guessed(cell: &Cell, atmosphere: &Atmosphere) -> [f32; 3] {
    std::array::from_fn(|k| {
        let scattered = cell.scattering[k];
        scattered * scattered * scattered * atmosphere.open.mean[k]
    })
}

/// Share of light that passes half of a cell of this depth on the way to a face, an edge and a corner.
fn half_passed(depth: f32) -> [f32; 3] {
    if depth <= 0.0 {
        return [1.0; 3];
    }
    [1.0f32, 2.0, 3.0].map(|squared| expf(-0.5 * PROJECTION * depth * squared.sqrt()))
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
    let (reflected, transmitted) = optics(material, textures);
    (std::array::from_fn(|k| reflected[k] + transmitted[k]), transmitted)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cube of foliage of a density in a volume of cells half a metre wide.
    fn canopy(density: f32, scattering: f32) -> Canopy {
        let counts = [17usize; 3];
        let low = Vec3::new(-4.25, 2.0, -4.25);
        let mut canopy = Canopy {
            low,
            size: 0.5,
            counts,
            floor: 0.0,
            cells: vec![Cell::default(); 17 * 17 * 17],
            ambient: Vec::new(),
        };
        for (x, (y, z)) in (3..14).flat_map(|x| (3..14).flat_map(move |y| (3..14).map(move |z| (x, (y, z))))) {
            let index = canopy.index([x, y, z]);
            canopy.cells[index] =
                Cell { density, coloured: density, scattering: [scattering; 3], transmission: [0.0; 3] };
        }
        canopy
    }

    fn even() -> Atmosphere {
        Atmosphere::even([1.0; 3])
    }

    fn middle(canopy: &Canopy) -> usize {
        canopy.index([8, 8, 8])
    }

    #[test]
    fn leaves_that_scatter_all_light_are_lost_in_an_even_sky() {
        // A white furnace: radiance 1 from everywhere, outside and within.
        let canopy = canopy(2.0, 1.0);
        let sent: Vec<[f32; 3]> = canopy.cells.iter().map(|cell| guessed(cell, &even())).collect();
        for ambient in canopy.gathered(&even(), &sent) {
            assert!((ambient.mean[1] - 1.0).abs() < 1e-4 && ambient.lean[1].norm() < 1e-4, "{ambient:?}");
        }
    }

    #[test]
    fn black_leaves_dim_an_even_sky_by_the_law_of_beer_and_lambert() {
        let canopy = canopy(0.8, 0.0);
        let dark = vec![[0.0; 3]; canopy.cells.len()];
        let found = canopy.gathered(&even(), &dark)[middle(&canopy)].mean[0];
        // From the middle of a cube of 11 cells there are 5.5 to a face, an edge or a corner, each longer than the last.
        let way = |squared: f32| expf(-PROJECTION * 0.8 * 0.5 * 5.5 * squared.sqrt());
        let expected = 6.0 / 21.0 * way(1.0) + 12.0 * 4.0 / 105.0 * way(2.0) + 8.0 * 9.0 / 280.0 * way(3.0);
        assert!((found / expected - 1.0).abs() < 0.02, "{found} {expected}");
    }

    #[test]
    fn light_inside_is_symmetric_and_falls_inwards() {
        let canopy = canopy(1.5, 0.2);
        let dark = vec![[0.0; 3]; canopy.cells.len()];
        let ambient = canopy.gathered(&even(), &dark);
        let at = |x, y, z| ambient[canopy.index([x, y, z])].mean[0];
        for (a, b) in [(at(4, 8, 8), at(12, 8, 8)), (at(4, 8, 8), at(8, 8, 4)), (at(5, 6, 8), at(8, 10, 5))] {
            assert!((a / b - 1.0).abs() < 1e-4, "{a} {b}");
        }
        assert!(at(3, 8, 8) > at(5, 8, 8) && at(5, 8, 8) > at(8, 8, 8));
    }
}
