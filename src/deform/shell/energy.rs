//! Energy of a bent sheet, its gradient and its exact Hessian, in units of the bending stiffness (and the extent).

use super::fold::Fold;
use super::sheet::{Plate, RIM, Sheet, Spring};
use crate::base::vector::{DMat3, DVec3};
use crate::deform::cholesky::{Block, Matrix, NOWHERE};

/// What the sheet would be without the bonds between its parts, and what weighs on it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rest {
    /// Rest length of each spring.
    pub lengths: Vec<f64>,
    /// Rest folds of each triangle.
    pub folds: Vec<[f64; 3]>,
    /// Weight of a unit of area, towards -z.
    pub weight: f64,
}

/// Energy of the sheet at positions. Not finite where a triangle has no area.
pub fn energy(sheet: &Sheet, rest: &Rest, positions: &[DVec3]) -> f64 {
    let folds: Vec<f64> = sheet.hinges.iter().map(|hinge| Fold::value(points(hinge, positions))).collect();
    let bending = |(plate, folds0): (&Plate, &[f64; 3])| {
        let r = differences(plate, folds0, |hinge| folds[hinge]);
        0.5 * r.dot(&(plate.form * r))
    };
    let mut sum: f64 = sheet.plates.iter().zip(&rest.folds).map(bending).sum();
    for (spring, length) in sheet.springs.iter().zip(&rest.lengths) {
        let stretch = (positions[spring.ends[1] as usize] - positions[spring.ends[0] as usize]).norm() - length;
        sum += 0.5 * spring.stiffness * stretch * stretch;
    }
    if rest.weight != 0.0 {
        sum += rest.weight * positions.iter().zip(&sheet.areas).map(|(p, area)| p.z * area).sum::<f64>();
    }
    sum
}

/// The stretch of each spring after a move, to first order in the move.
pub fn stretches(sheet: &Sheet, rest: &Rest, from: &[DVec3], to: &[DVec3]) -> Vec<f64> {
    let stretch = |(spring, length): (&Spring, &f64)| {
        let [a, b] = spring.ends.map(|v| v as usize);
        let side = from[b] - from[a];
        side.dot(&(to[b] - to[a])) / side.norm() - length
    };
    sheet.springs.iter().zip(&rest.lengths).map(stretch).collect()
}

/// The folds of a sheet with their derivatives, from which gradient and Hessian are made.
pub struct Bent<'a> {
    sheet: &'a Sheet,
    rest: &'a Rest,
    positions: &'a [DVec3],
    folds: Vec<Fold>,
    /// Derivative of the energy by each fold.
    moments: Vec<f64>,
}

impl<'a> Bent<'a> {
    /// Of a sheet at positions.
    pub fn new(sheet: &'a Sheet, rest: &'a Rest, positions: &'a [DVec3]) -> Self {
        let folds: Vec<Fold> = sheet.hinges.iter().map(|hinge| Fold::new(points(hinge, positions))).collect();
        let mut moments = vec![0.0; folds.len()];
        for (plate, folds0) in sheet.plates.iter().zip(&rest.folds) {
            let moment = plate.form * differences(plate, folds0, |hinge| folds[hinge].value);
            for (i, &hinge) in plate.hinges.iter().enumerate().filter(|(_, hinge)| **hinge != RIM) {
                moments[hinge as usize] += moment[i];
            }
        }
        Self { sheet, rest, positions, folds, moments }
    }

    /// Where a vertex is.
    pub fn position(&self, vertex: u32) -> DVec3 {
        self.positions[vertex as usize]
    }

    /// The springs' own stretches.
    pub fn stretches(&self) -> Vec<f64> {
        stretches(self.sheet, self.rest, self.positions, self.positions)
    }

    /// Gradient of the energy.
    pub fn gradient(&self) -> Vec<DVec3> {
        let mut gradient: Vec<DVec3> =
            self.sheet.areas.iter().map(|area| DVec3::z() * (area * self.rest.weight)).collect();
        for ((hinge, fold), moment) in self.sheet.hinges.iter().zip(&self.folds).zip(&self.moments) {
            for (&v, g) in hinge.iter().zip(&fold.gradient) {
                gradient[v as usize] += g * *moment;
            }
        }
        for (spring, length) in self.sheet.springs.iter().zip(&self.rest.lengths) {
            let [a, b] = spring.ends.map(|v| v as usize);
            let side = self.positions[b] - self.positions[a];
            let pull = side * (spring.stiffness * (1.0 - length / side.norm()));
            gradient[a] -= pull;
            gradient[b] += pull;
        }
        gradient
    }

    /// Fills the matrix with the Hessian. The springs' geometric part is that of the given stretches (with their own it is
    /// exact). `tamed` leaves out what can make it indefinite: pressed springs' geometric part and the folds' second derivatives.
    pub fn hessian(&self, places: &Places, matrix: &mut Matrix, stretches: &[f64], tamed: bool) {
        matrix.clear();
        for (number, (spring, place)) in self.sheet.springs.iter().zip(&places.springs).enumerate() {
            let [a, b] = spring.ends.map(|v| v as usize);
            let side = self.positions[b] - self.positions[a];
            let stretched = side.norm();
            let along = side / stretched;
            let stretch = if tamed { stretches[number].max(0.0) } else { stretches[number] };
            let ratio = 1.0 - stretch / stretched;
            let block = DMat3::identity() * (1.0 - ratio) + along * along.transpose() * ratio;
            let [first, second] = spring.ends.map(|v| places.numbers[v as usize]);
            let block = flat(&(block * spring.stiffness));
            matrix.add(place[0], [first, first], &block, false);
            matrix.add(place[1], [second, second], &block, false);
            matrix.add(place[2], [first, second], &block.map(|x| -x), false);
        }
        for (plate, place) in self.sheet.plates.iter().zip(&places.plates) {
            self.add_plate(plate, place, places, matrix);
        }
        for (hinge, fold) in self.folds.iter().enumerate().filter(|_| !tamed) {
            self.add_turning(hinge, fold, places, matrix);
        }
    }

    /// Adds the products of fold gradients within a triangle.
    fn add_plate(&self, plate: &Plate, place: &[u32; 21], places: &Places, matrix: &mut Matrix) {
        let mut gradients = [[DVec3::zeros(); 6]; 3];
        for i in 0..3 {
            if plate.hinges[i] == RIM {
                continue;
            }
            let fold = &self.folds[plate.hinges[i] as usize];
            for (slot, g) in slots(i, plate.second[i]).into_iter().zip(&fold.gradient) {
                gradients[i][slot] = *g;
            }
        }
        let vertices = vertices(plate);
        let mut at = 0;
        for p in 0..6 {
            for q in 0..=p {
                let mut block = DMat3::zeros();
                for i in 0..3 {
                    let weighed: DVec3 = (0..3).map(|j| gradients[j][q] * plate.form[(i, j)]).sum();
                    block += gradients[i][p] * weighed.transpose();
                }
                let pair = [vertices[p], vertices[q]].map(|v| places.numbers[v as usize]);
                matrix.add(place[at], pair, &flat(&block), p != q);
                at += 1;
            }
        }
    }

    /// Adds the second derivatives of a fold, times the moment on it.
    fn add_turning(&self, hinge: usize, fold: &Fold, places: &Places, matrix: &mut Matrix) {
        let numbers = self.sheet.hinges[hinge].map(|v| places.numbers[v as usize]);
        let hessian = fold.hessian();
        let mut at = 0;
        for i in 0..4 {
            for j in 0..=i {
                let block = flat(&(hessian[i][j] * self.moments[hinge]));
                matrix.add(places.hinges[hinge][at], [numbers[i], numbers[j]], &block, i != j);
                at += 1;
            }
        }
    }
}

/// Where the parts' blocks lie in the matrix.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Places {
    /// Elimination number of each vertex; [`NOWHERE`] for a held one.
    pub numbers: Vec<u32>,
    springs: Vec<[u32; 3]>,
    plates: Vec<[u32; 21]>,
    hinges: Vec<[u32; 10]>,
}

impl Places {
    /// For a sheet whose vertices have these elimination numbers, in a matrix whose pattern has all couplings.
    pub fn new(sheet: &Sheet, numbers: Vec<u32>, matrix: &Matrix) -> Self {
        let place = |a: u32, b: u32| matrix.place(numbers[a as usize], numbers[b as usize]);
        let springs = sheet.springs.iter().map(|s| s.ends).map(|[a, b]| [place(a, a), place(b, b), place(a, b)]);
        let springs = springs.collect();
        let plates = sheet.plates.iter().map(|plate| pairs(&vertices(plate), place)).collect();
        let hinges = sheet.hinges.iter().map(|hinge| pairs(hinge, place)).collect();
        Self { numbers, springs, plates, hinges }
    }
}

/// The couplings of a sheet: all pairs of vertices whose folds meet in a triangle.
pub fn couplings(sheet: &Sheet) -> impl Iterator<Item = [u32; 2]> + '_ {
    let plates = sheet.plates.iter().flat_map(|plate| {
        let vertices = vertices(plate);
        (0..6).flat_map(move |p| (0..p).map(move |q| [vertices[p], vertices[q]]))
    });
    plates.chain(sheet.springs.iter().map(|spring| spring.ends))
}

/// Corners and vertices across of a triangle; its first corner where there is none across.
fn vertices(plate: &Plate) -> [u32; 6] {
    let [a, b, c] = plate.corners;
    let across = [0, 1, 2].map(|i| if plate.hinges[i] == RIM { a } else { plate.across[i] });
    [a, b, c, across[0], across[1], across[2]]
}

/// Among corners (0 to 2) and vertices across (3 to 5), the vertices a, b, c, d of the hinge at edge `i`.
fn slots(i: usize, second: bool) -> [usize; 4] {
    let (j, k) = ((i + 1) % 3, (i + 2) % 3);
    if second { [j, i, 3 + i, k] } else { [i, j, k, 3 + i] }
}

/// Something for each pair (i, j <= i), row by row.
fn pairs<const N: usize, const M: usize>(vertices: &[u32; N], place: impl Fn(u32, u32) -> u32) -> [u32; M] {
    let mut made = [NOWHERE; M];
    let all = (0..N).flat_map(|p| (0..=p).map(move |q| (p, q)));
    for (slot, (p, q)) in made.iter_mut().zip(all) {
        *slot = place(vertices[p], vertices[q]);
    }
    made
}

fn points(hinge: &[u32; 4], positions: &[DVec3]) -> [DVec3; 4] {
    hinge.map(|v| positions[v as usize])
}

fn differences(plate: &Plate, folds0: &[f64; 3], fold: impl Fn(usize) -> f64) -> DVec3 {
    let difference = |i: usize| if plate.hinges[i] == RIM { 0.0 } else { fold(plate.hinges[i] as usize) - folds0[i] };
    DVec3::new(difference(0), difference(1), difference(2))
}

/// A block of a matrix.
pub fn flat(m: &DMat3) -> Block {
    // nalgebra keeps columns together.
    let mut block = [0.0; 9];
    for i in 0..3 {
        for j in 0..3 {
            block[3 * i + j] = m[(i, j)];
        }
    }
    block
}
