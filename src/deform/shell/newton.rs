//! Newton's method for the shape of least energy: exact Hessian, sparse Cholesky, line search.
//!
//! A step that turns parts of a sheet stretches them to second order, and stretching is dear: the true energy rises, a line
//! search cuts the step, and a Hessian with the springs' true tension finds a taut sheet that hardly bends. So the geometric
//! part of the Hessian takes the tension that the last step foresaw to first order, as a mixed formulation has it (Magisano,
//! Leonetti and Garcea 2017), and the energy may rise for a few steps. Measured: 5 steps a state instead of 12. At rest the
//! two tensions agree, and the convergence is quadratic.
//!
//! Where that matrix is not positive definite, the step is taken with a tamed one that is; where that happens at rest, the
//! shape is a saddle, and a push along a soft direction leaves it. The last steps are always with the whole Hessian positive
//! definite: what is handed out is a minimum.

use super::energy::{Bent, Places, Rest, couplings, energy, flat, stretches};
use super::sheet::Sheet;
use crate::base::vector::{DMat3, DVec2, DVec3};
use crate::deform::cholesky::{Factor, Matrix, NOWHERE, Symbolic};

/// Share of the largest number on the diagonal that is added to all of it: keeps motions that cost nothing (of a free leaf)
/// from dividing by nought.
const FLOOR: f64 = 1e-10;
/// Longest way of a vertex in one step, extents.
const LONGEST: f64 = 0.3;
/// Least decrease of the energy, as a share of what the gradient promises.
const DECREASE: f64 = 1e-4;
/// First shift of a tamed Hessian that is still not definite, in bending stiffness over the fourth power of the extent, the
/// factor to the next, and the shift beyond which nothing is left of the Hessian.
const FIRST_SHIFT: f64 = 1.0;
const GRADE: f64 = 10.0;
const LAST_SHIFT: f64 = 1e16;
/// Most steps uphill before the solver goes back (the watchdog of Chamberlain and others 1982).
const ASTRAY: u32 = 3;
/// A step of no more than this, extents, may be the last but one.
const NEAR: f64 = 0.02;
/// Share of the energy that is not worth a step: along a motion that costs next to nothing (a round blade that may roll about
/// any axis) steps may stay long.
const NEGLIGIBLE: f64 = 1e-9;
/// Pushes in vain, each in another direction, after which a saddle passes for a valley's floor.
const IDLE: u32 = 5;
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
    /// Three vertices far apart, by elimination number, of a sheet that nothing holds.
    anchors: Option<[u32; 3]>,
}

/// A place to come back to, with the step from it and what it promised.
struct Mark {
    positions: Vec<DVec3>,
    step: Vec<[f64; 3]>,
    length: f64,
    energy: f64,
    /// Slope of the energy along the step.
    slope: f64,
}

impl Mark {
    fn new(positions: Vec<DVec3>, step: Vec<[f64; 3]>, gradient: &[[f64; 3]], outcome: Outcome) -> Self {
        Self { positions, slope: product(gradient, &step), step, length: outcome.step, energy: outcome.energy }
    }

    /// The share of the step that is no longer than a step may be.
    fn longest_share(&self) -> f64 {
        (LONGEST / self.length).min(1.0)
    }

    /// Whether an energy after a share of the step is low enough (Armijo 1966).
    fn is_left_by(&self, share: f64, energy: f64) -> bool {
        energy <= self.energy + DECREASE * share * self.slope + 1e-15 * self.energy.abs()
    }
}

/// What the solver remembers from step to step.
#[derive(Default)]
struct Trail {
    /// The last place of falling energy, while the solver goes uphill.
    mark: Option<Mark>,
    /// Steps gone since.
    astray: u32,
    /// Stretches of the springs as the last step foresaw them.
    stretches: Vec<f64>,
}

/// How a shape was reached.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outcome {
    /// Steps taken, each with a factorisation that held.
    pub iterations: u64,
    /// Factorisations, with those that did not hold.
    pub factorisations: u64,
    /// Saddles that were reached and left behind.
    pub saddles: u64,
    /// Energy, in bending stiffnesses.
    pub energy: f64,
    /// Largest force left on a vertex, in bending stiffness over extent.
    pub residual: f64,
    /// Length of the last step, extents.
    pub step: f64,
}

impl Outcome {
    /// Adds the work of another.
    pub fn add(&mut self, other: Self) {
        self.iterations += other.iterations;
        self.factorisations += other.factorisations;
        self.saddles += other.saddles;
    }
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

    /// Bytes that a factor takes.
    pub fn bytes(&self) -> f64 {
        self.symbolic.bytes()
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
        let anchors = anchors(sheet).map(|anchors| anchors.map(|v| plan.symbolic.numbers[v as usize]));
        Self { sheet, places, vertices, areas, matrix, factor: Factor::new(plan.symbolic.clone()), anchors }
    }

    /// Moves the positions, at rest under the load `before`, to a shape of least energy near them.
    ///
    /// # Errors
    /// [`NotReached`] after `most` steps, or when no step lowers the energy; the positions are then of no use.
    pub fn settle(
        &mut self,
        (before, rest): (&Rest, &Rest),
        positions: &mut Vec<DVec3>,
        tolerance: f64,
        most: u32,
    ) -> Result<Outcome, NotReached> {
        let mut outcome = Outcome { energy: energy(self.sheet, rest, positions), ..Outcome::default() };
        if self.vertices.is_empty() {
            return Ok(outcome);
        }
        let mut trail = Trail { stretches: self.stretches(before, positions, positions), ..Trail::default() };
        let (mut last_saddle, mut idle) = (f64::INFINITY, 0);
        while outcome.iterations < u64::from(most) && outcome.energy.is_finite() {
            let bent = Bent::new(self.sheet, rest, positions);
            let gradient = self.gathered(&bent.gradient());
            let whole = self.factored(&bent, &trail.stretches, &mut outcome).ok_or(NotReached(outcome))?;
            let mut step: Vec<[f64; 3]> = gradient.iter().map(|g| g.map(|x| -x)).collect();
            self.factor.solve(&mut step);
            outcome.iterations += 1;
            (outcome.step, outcome.residual) = (longest(&step), longest(&gradient));
            if !whole && outcome.step <= tolerance {
                idle = if last_saddle - outcome.energy <= NEGLIGIBLE * outcome.energy { idle + 1 } else { 0 };
                if idle > IDLE {
                    return Ok(outcome);
                }
                last_saddle = outcome.energy;
                let push = self.push(&bent, &trail, &gradient, outcome.saddles);
                self.move_by(positions, &push, 1.0);
                outcome.saddles += 1;
                outcome.energy = energy(self.sheet, rest, positions);
                trail = Trail { stretches: self.stretches(rest, positions, positions), ..Trail::default() };
                continue;
            }
            let near = whole && outcome.step <= NEAR.max(tolerance);
            let mark = Mark::new(positions.clone(), step, &gradient, outcome);
            if whole && -mark.slope <= NEGLIGIBLE * outcome.energy * outcome.step.min(1.0) {
                return Ok(outcome);
            }
            match self.gone(rest, mark, &mut trail) {
                Some((moved, energy)) => (*positions, outcome.energy) = (moved, energy),
                // At the rounding of the energy no step lowers it any more.
                None if near => {}
                None => return Err(NotReached(outcome)),
            }
            if near && self.polished(rest, positions, tolerance, &mut outcome) {
                return Ok(outcome);
            }
        }
        Err(NotReached(outcome))
    }

    /// Takes one more step with the factor at hand if it is no longer than the tolerance: its length is the error that the last
    /// step left, and it takes most of that away for a fraction of a factorisation. False when it is longer.
    fn polished(&self, rest: &Rest, positions: &mut Vec<DVec3>, tolerance: f64, outcome: &mut Outcome) -> bool {
        let gradient = self.gathered(&Bent::new(self.sheet, rest, positions).gradient());
        let mut step: Vec<[f64; 3]> = gradient.iter().map(|g| g.map(|x| -x)).collect();
        self.factor.solve(&mut step);
        let length = longest(&step);
        if length.is_nan() || length > tolerance {
            return false;
        }
        let moved = self.moved(positions, &step, 1.0);
        let after = energy(self.sheet, rest, &moved);
        if after <= outcome.energy {
            (*positions, outcome.energy) = (moved, after);
        }
        outcome.step = length;
        outcome.residual = longest(&self.gathered(&Bent::new(self.sheet, rest, positions).gradient()));
        true
    }

    /// Goes on from a mark: the whole step, even uphill for a while; after too long a while back to the last good mark, and from there no further than the energy falls.
    fn gone(&self, rest: &Rest, here: Mark, trail: &mut Trail) -> Option<(Vec<DVec3>, f64)> {
        let share = here.longest_share();
        let moved = self.moved(&here.positions, &here.step, share);
        let after = energy(self.sheet, rest, &moved);
        let lower = trail.mark.as_ref().map_or(here.is_left_by(share, after), |mark| mark.is_left_by(0.0, after));
        if lower || (trail.astray < ASTRAY && after.is_finite()) {
            trail.stretches = self.stretches(rest, &here.positions, &moved);
            if lower {
                (trail.mark, trail.astray) = (None, 0);
            } else {
                trail.mark.get_or_insert(here);
                trail.astray += 1;
            }
            return Some((moved, after));
        }
        let mark = trail.mark.take().unwrap_or(here);
        trail.astray = 0;
        let (moved, after) = self.searched(rest, &mark)?;
        trail.stretches = self.stretches(rest, &mark.positions, &moved);
        Some((moved, after))
    }

    /// The springs' stretches after a move, to first order.
    fn stretches(&self, rest: &Rest, from: &[DVec3], to: &[DVec3]) -> Vec<f64> {
        stretches(self.sheet, rest, from, to)
    }

    /// Factors the Hessian: whole if it is positive definite (true), else tamed, and if need be shifted (false).
    fn factored(&mut self, bent: &Bent, stretches: &[f64], outcome: &mut Outcome) -> Option<bool> {
        let ones = vec![1.0; self.areas.len()];
        for tamed in [false, true] {
            bent.hessian(&self.places, &mut self.matrix, stretches, tamed);
            self.anchor(bent);
            let floor = self.matrix.largest_diagonal() * FLOOR;
            self.matrix.shift(&ones, floor);
            outcome.factorisations += 1;
            if self.factor.compute(&self.matrix).is_ok() {
                return Some(!tamed);
            }
        }
        self.shifted().then_some(false)
    }

    /// Ties a sheet that nothing holds at the six freedoms of its anchors that are its rigid motions. Its forces neither push
    /// nor turn it, so that the ties carry nothing: they only choose the step that does not move it as a whole.
    fn anchor(&mut self, bent: &Bent) {
        let Some(anchors) = self.anchors else { return };
        let [a, b, c] = anchors.map(|number| bent.position(self.vertices[number as usize]));
        let along = (b - a).normalize();
        let normal = along.cross(&(c - a)).normalize();
        let whole = DMat3::identity();
        let tie = self.matrix.largest_diagonal();
        let ties = [whole, whole - along * along.transpose(), normal * normal.transpose()];
        for (number, block) in anchors.into_iter().zip(ties) {
            if block.iter().all(|x| x.is_finite()) {
                let place = self.matrix.place(number, number);
                self.matrix.add(place, [number, number], &flat(&(block * tie)), false);
            }
        }
    }

    /// Factors the matrix with the least shift that makes it definite; false when none does.
    fn shifted(&mut self) -> bool {
        let mut shift = FIRST_SHIFT;
        while shift < LAST_SHIFT {
            self.matrix.shift(&self.areas, shift);
            if self.factor.compute(&self.matrix).is_ok() {
                return true;
            }
            shift *= GRADE;
        }
        false
    }

    /// Goes from a mark along its step, as far as that lowers the energy enough; `None` when it nowhere does.
    fn searched(&self, rest: &Rest, mark: &Mark) -> Option<(Vec<DVec3>, f64)> {
        let mut share = mark.longest_share() * 0.5;
        while share > 1e-10 {
            let moved = self.moved(&mark.positions, &mark.step, share);
            let after = energy(self.sheet, rest, &moved);
            if mark.is_left_by(share, after) {
                return Some((moved, after));
            }
            share *= 0.5;
        }
        None
    }

    /// A push along the direction in which the energy curves down most, found by inverse iteration with the whole Hessian
    /// shifted until it is definite. The start of the iteration is fixed, rough, and other at each saddle.
    fn push(&mut self, bent: &Bent, trail: &Trail, gradient: &[[f64; 3]], number: u64) -> Vec<[f64; 3]> {
        bent.hessian(&self.places, &mut self.matrix, &trail.stretches, false);
        self.anchor(bent);
        let _ = self.shifted();
        let rough = |i: usize, k: usize| {
            let hash = crate::base::random::hash(i as u64 * 3 + k as u64, number);
            (hash >> 11) as f64 / (1u64 << 53) as f64 - 0.3
        };
        let mut push: Vec<[f64; 3]> =
            self.areas.iter().enumerate().map(|(i, a)| [0, 1, 2].map(|k| rough(i, k) * a)).collect();
        for _ in 0..6 {
            self.factor.solve(&mut push);
            let size = longest(&push).max(1e-300);
            push.iter_mut().zip(&self.areas).for_each(|(p, area)| *p = p.map(|x| x / size * area));
        }
        self.factor.solve(&mut push);
        let size = longest(&push).max(1e-300) * if product(gradient, &push) > 0.0 { -1.0 } else { 1.0 };
        push.iter().map(|p| p.map(|x| x * PUSH / size)).collect()
    }

    fn moved(&self, positions: &[DVec3], step: &[[f64; 3]], share: f64) -> Vec<DVec3> {
        let mut moved = positions.to_vec();
        self.move_by(&mut moved, step, share);
        moved
    }

    /// The sheet.
    pub fn sheet(&self) -> &'a Sheet {
        self.sheet
    }

    /// Solves (K + inertia M) d = right with the tamed Hessian and the areas as masses; held vertices get nought.
    pub fn solve_tamed(&mut self, bent: &Bent, inertia: f64, right: &[DVec3]) -> Option<Vec<DVec3>> {
        bent.hessian(&self.places, &mut self.matrix, &bent.stretches(), true);
        let floor = self.matrix.largest_diagonal() * FLOOR;
        self.matrix.shift(&vec![1.0; self.areas.len()], floor);
        self.matrix.shift(&self.areas, inertia);
        self.factor.compute(&self.matrix).ok()?;
        let mut solution = self.gathered(right);
        self.factor.solve(&mut solution);
        Some(self.moved(&vec![DVec3::zeros(); right.len()], &solution, 1.0))
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

/// Three vertices of a sheet that nothing holds: one, that farthest from it, and that farthest from the line of both. `None`
/// when it is held, or is no more than a line.
fn anchors(sheet: &Sheet) -> Option<[u32; 3]> {
    let first = sheet.places.first().filter(|_| !sheet.held.contains(&true))?;
    let farthest = |distance: &dyn Fn(DVec2) -> f64| {
        let distance = |v: usize| distance(sheet.places[v] - first);
        let last = (0..sheet.places.len()).max_by(|&u, &v| distance(u).total_cmp(&distance(v)).then(v.cmp(&u)))?;
        (distance(last) > 0.0).then_some(last)
    };
    let second = farthest(&|way| way.norm_squared())?;
    let third = farthest(&|way| way.perp(&(sheet.places[second] - first)).abs())?;
    Some([0, second as u32, third as u32])
}

fn product(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a[0] * b[0] + a[1] * b[1] + a[2] * b[2]).sum()
}

/// Length of the longest of some vectors; infinite if one is not finite.
fn longest(vectors: &[[f64; 3]]) -> f64 {
    let squared = |v: &[f64; 3]| v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    let larger = |worst: f64, v: &[f64; 3]| if squared(v) <= worst { worst } else { squared(v) };
    let worst = vectors.iter().fold(0.0, larger);
    if worst.is_nan() { f64::INFINITY } else { worst.sqrt() }
}
