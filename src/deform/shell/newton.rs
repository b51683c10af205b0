//! Newton's method for the shape of least energy: exact Hessian, sparse Cholesky, line search. Where the Hessian is not
//! positive definite it is shifted by a multiple of the vertices' areas, just enough; where that happens at rest, the shape
//! is a saddle, and a push along the direction of falling energy leaves it. The last step is always one with the exact
//! Hessian positive definite: what is handed out is a minimum.

use super::energy::{Bent, Places, Rest, couplings, energy};
use super::sheet::Sheet;
use crate::base::limits::{Limit, Limits, Refusal};
use crate::base::vector::{DVec2, DVec3};
use crate::deform::cholesky::{Factor, Matrix, NOWHERE, Symbolic};

/// Share of the largest number on the diagonal that is added to all of it: keeps motions that cost nothing (of a free leaf)
/// from dividing by nought.
const FLOOR: f64 = 1e-10;
/// Longest way of a vertex in one step, extents.
const LONGEST: f64 = 0.3;
/// Least decrease of the energy, as a share of what the gradient promises (Armijo 1966).
const DECREASE: f64 = 1e-4;
/// First shift, in bending stiffness over the fourth power of the extent: below the slowest vibration of a blade.
const FIRST_SHIFT: f64 = 1.0;
/// A shift beyond which nothing is left of the Hessian.
const LAST_SHIFT: f64 = 1e16;
/// Factor between shifts.
const GRADE: f64 = 8.0;
/// Length of the push off a saddle, extents.
const PUSH: f64 = 3e-3;

/// The solver of one sheet.
pub struct Solver<'a> {
    sheet: &'a Sheet,
    places: Places,
    /// The vertex of each elimination number.
    vertices: Vec<u32>,
    /// Areas by elimination number.
    areas: Vec<f64>,
    matrix: Matrix,
    factor: Factor,
}

/// How a shape was reached.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outcome {
    /// Steps taken, each with a factorisation that held.
    pub iterations: u64,
    /// Factorisations, with those that did not hold.
    pub factorisations: u64,
    /// Saddles left.
    pub saddles: u64,
    /// Energy, in bending stiffnesses.
    pub energy: f64,
    /// Largest force left on a vertex, in bending stiffness over extent.
    pub residual: f64,
    /// Length of the last step, extents.
    pub step: f64,
}

/// The shape was not reached; the outcome so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NotReached(pub Outcome);

/// What a sheet's solver does once: order, pattern and places in it.
#[derive(Clone, Debug)]
pub struct Plan {
    symbolic: Symbolic,
    vertices: Vec<u32>,
}

impl Plan {
    /// Of a sheet.
    pub fn new(sheet: &Sheet) -> Self {
        let free: Vec<u32> = (0..sheet.places.len() as u32).filter(|&v| !sheet.held[v as usize]).collect();
        let mut among = vec![NOWHERE; sheet.places.len()];
        free.iter().enumerate().for_each(|(i, &v)| among[v as usize] = i as u32);
        let places: Vec<DVec2> = free.iter().map(|&v| sheet.places[v as usize]).collect();
        let pairs = couplings(sheet).map(|pair| pair.map(|v| among[v as usize]));
        let symbolic = Symbolic::new(&places, pairs.filter(|pair| !pair.contains(&NOWHERE)));
        let mut vertices = vec![0; free.len()];
        for (&v, &number) in free.iter().zip(&symbolic.numbers) {
            vertices[number as usize] = v;
        }
        Self { symbolic, vertices }
    }

    /// Allows the memory of `solvers` at a time, or refuses it.
    ///
    /// # Errors
    /// A [`Refusal`].
    pub fn allow(&self, solvers: usize, limits: &Limits) -> Result<(), Refusal> {
        limits.allow(Limit::Memory, "leaf.vertices", self.symbolic.bytes() * solvers as f64)
    }
}

impl<'a> Solver<'a> {
    /// The solver of a sheet by its plan.
    pub fn new(sheet: &'a Sheet, plan: &Plan) -> Self {
        let vertices = plan.vertices.clone();
        let mut numbers = vec![NOWHERE; sheet.places.len()];
        vertices.iter().enumerate().for_each(|(number, &v)| numbers[v as usize] = number as u32);
        let pairs = couplings(sheet).map(|pair| pair.map(|v| numbers[v as usize]));
        let matrix = Matrix::new(vertices.len(), pairs.filter(|pair| !pair.contains(&NOWHERE)));
        let places = Places::new(sheet, numbers, &matrix);
        let areas = vertices.iter().map(|&v| sheet.areas[v as usize]).collect();
        Self { sheet, places, vertices, areas, matrix, factor: Factor::new(plan.symbolic.clone()) }
    }

    /// Moves the positions to a shape of least energy near them.
    ///
    /// # Errors
    /// [`NotReached`] after `most` steps, or when no step lowers the energy; the positions are then of no use.
    pub fn settle(
        &mut self,
        rest: &Rest,
        positions: &mut [DVec3],
        tolerance: f64,
        most: u32,
    ) -> Result<Outcome, NotReached> {
        let mut outcome = Outcome { energy: energy(self.sheet, rest, positions), ..Outcome::default() };
        if self.vertices.is_empty() {
            return Ok(outcome);
        }
        let mut shift = 0.0;
        while outcome.iterations < u64::from(most) && outcome.energy.is_finite() {
            let bent = Bent::new(self.sheet, rest, positions);
            let gradient = self.gathered(&bent.gradient());
            outcome.residual = longest(&gradient);
            bent.hessian(&self.places, &mut self.matrix);
            shift = self.factored(shift, &mut outcome).ok_or(NotReached(outcome))?;
            let mut step: Vec<[f64; 3]> = gradient.iter().map(|g| g.map(|x| -x)).collect();
            self.factor.solve(&mut step);
            outcome.iterations += 1;
            outcome.step = longest(&step);
            if outcome.step <= tolerance && shift > 0.0 {
                self.leave_saddle(&gradient, positions, outcome.saddles);
                outcome.saddles += 1;
                outcome.energy = energy(self.sheet, rest, positions);
                continue;
            }
            let done = outcome.step <= tolerance;
            match self.searched(rest, positions, &gradient, &step, outcome) {
                Some(energy) => outcome.energy = energy,
                // At the rounding of the energy no step lowers it any more.
                None if done => {}
                None => return Err(NotReached(outcome)),
            }
            if done {
                outcome.residual = longest(&self.gathered(&Bent::new(self.sheet, rest, positions).gradient()));
                return Ok(outcome);
            }
            shift = if shift > FIRST_SHIFT { shift / GRADE } else { 0.0 };
        }
        Err(NotReached(outcome))
    }

    /// Factors the Hessian with the least shift, from `shift` up, that makes it definite; gives that shift.
    fn factored(&mut self, shift: f64, outcome: &mut Outcome) -> Option<f64> {
        let floor = self.matrix.largest_diagonal() * FLOOR;
        let ones = vec![1.0; self.areas.len()];
        self.matrix.shift(&ones, floor);
        self.matrix.shift(&self.areas, shift);
        let mut shift = shift;
        loop {
            outcome.factorisations += 1;
            if self.factor.compute(&self.matrix).is_ok() {
                return Some(shift);
            }
            let next = (shift * GRADE).max(FIRST_SHIFT);
            if next > LAST_SHIFT {
                return None;
            }
            self.matrix.shift(&self.areas, next - shift);
            shift = next;
        }
    }

    /// Goes along a step as far as it lowers the energy enough, and gives the energy there.
    fn searched(
        &self,
        rest: &Rest,
        positions: &mut [DVec3],
        gradient: &[[f64; 3]],
        step: &[[f64; 3]],
        outcome: Outcome,
    ) -> Option<f64> {
        let promise: f64 = gradient.iter().zip(step).map(|(g, s)| g[0] * s[0] + g[1] * s[1] + g[2] * s[2]).sum();
        let before = outcome.energy;
        let mut share = (LONGEST / outcome.step).min(1.0);
        while share > 1e-10 {
            let mut moved = positions.to_vec();
            self.move_by(&mut moved, step, share);
            let after = energy(self.sheet, rest, &moved);
            if after <= before + DECREASE * share * promise + 1e-15 * before.abs() {
                positions.copy_from_slice(&moved);
                return Some(after);
            }
            share *= 0.5;
        }
        None
    }

    /// Pushes the positions along the direction in which the energy falls most, found by inverse iteration with the shifted
    /// factor. The start of the iteration is fixed, rough, and other at each saddle.
    fn leave_saddle(&self, gradient: &[[f64; 3]], positions: &mut [DVec3], number: u64) {
        let rough = |i: usize, k: usize| {
            let hash = crate::base::random::hash(i as u64 * 3 + k as u64, number);
            (hash >> 11) as f64 / (1u64 << 53) as f64 - 0.3
        };
        let mut push: Vec<[f64; 3]> =
            self.areas.iter().enumerate().map(|(i, a)| [0, 1, 2].map(|k| rough(i, k) * a)).collect();
        for _ in 0..3 {
            self.factor.solve(&mut push);
            let size = longest(&push).max(1e-300);
            push.iter_mut().zip(&self.areas).for_each(|(p, area)| *p = p.map(|x| x / size * area));
        }
        self.factor.solve(&mut push);
        let rise: f64 = gradient.iter().zip(&push).map(|(g, s)| g[0] * s[0] + g[1] * s[1] + g[2] * s[2]).sum();
        let size = longest(&push).max(1e-300);
        self.move_by(positions, &push, if rise > 0.0 { -PUSH } else { PUSH } / size);
    }

    fn move_by(&self, positions: &mut [DVec3], step: &[[f64; 3]], share: f64) {
        for (&v, s) in self.vertices.iter().zip(step) {
            positions[v as usize] += DVec3::from(*s) * share;
        }
    }

    /// The free vertices' part of a vector, in the order of elimination.
    fn gathered(&self, all: &[DVec3]) -> Vec<[f64; 3]> {
        self.vertices.iter().map(|&v| all[v as usize].into()).collect()
    }
}

/// Length of the longest of some vectors; infinite if one is not finite.
fn longest(vectors: &[[f64; 3]]) -> f64 {
    let squared = |v: &[f64; 3]| v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    let larger = |worst: f64, v: &[f64; 3]| if squared(v) <= worst { worst } else { squared(v) };
    let worst = vectors.iter().fold(0.0, larger);
    if worst.is_nan() { f64::INFINITY } else { worst.sqrt() }
}
