//! From flat to dry: the shapes of one variant on a ladder of drynesses, each the start of the next, and each job from the rung
//! below its own dryness. A job's shape is so the same whichever others are asked for.

use super::coarse::Return;
use super::drying::Drying;
use super::energy::Rest;
use super::level::Level;
use super::newton::{NotReached, Outcome, Plan, Solver};
use super::settings::Settings;
use super::sheet::{Sheet, Spring};
use crate::base::vector::DVec3;
use crate::deform::DeformError;

/// Rungs of the ladder.
const RUNGS: u32 = 8;
/// Most steps from a coarser mesh's shape before the way from flat is taken instead.
const MOST_FROM_COARSE: u32 = 25;
/// How often a step that fails is halved.
const HALVINGS: u32 = 6;

/// Dryness, and share of the weight that presses.
type Load = (f64, f64);

/// A variant on its way.
pub struct Path<'a> {
    settings: &'a Settings,
    drying: &'a Drying<'a>,
    solver: Solver<'a>,
    /// The same variant on a coarser mesh, and the way here from there.
    coarse: Option<(Box<Path<'a>>, &'a Return)>,
    /// Positions at the rungs reached so far and how they were reached, the flat (but loaded) blade first.
    rungs: Vec<(Vec<DVec3>, Outcome)>,
    /// The work done on all of them.
    pub work: Outcome,
}

/// A shape was not reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stuck {
    /// The dryness at which the solver came to nothing.
    pub dryness: f64,
    /// How far it came.
    pub outcome: Outcome,
}

impl From<Stuck> for DeformError {
    fn from(Stuck { dryness, outcome }: Stuck) -> Self {
        Self::NotSettled { dryness, iterations: outcome.iterations, residual: outcome.residual }
    }
}

impl<'a> Path<'a> {
    /// At its start.
    ///
    /// # Errors
    /// [`Stuck`] when the blade does not settle under its weight.
    pub fn new(settings: &'a Settings, sheet: &'a Sheet, drying: &'a Drying<'a>, plan: &Plan) -> Result<Self, Stuck> {
        let flat = sheet.places.iter().map(|p| DVec3::new(p.x, p.y, 0.0)).collect();
        let solver = Solver::new(sheet, plan);
        let rungs = vec![(flat, Outcome::default())];
        let mut path = Self { settings, drying, solver, coarse: None, rungs, work: Outcome::default() };
        if settings.gravity != 0.0 {
            let mut start = path.rungs[0].0.clone();
            let outcome = path.advance((0.0, 0.0), (0.0, 1.0), &mut start, HALVINGS)?;
            path.rungs[0] = (start, outcome);
        }
        Ok(path)
    }

    /// At its start, on the finest of some levels, each of which starts from the next.
    ///
    /// # Errors
    /// [`Stuck`] when the blade does not settle under its weight.
    pub fn over(settings: &'a Settings, levels: &'a [Level], dryings: &'a [Drying<'a>]) -> Result<Self, Stuck> {
        let mut path = Self::new(settings, &levels[0].sheet, &dryings[0], &levels[0].plan)?;
        if let Some(way) = &levels[0].way {
            path.coarse = Some((Box::new(Self::over(settings, &levels[1..], &dryings[1..])?), way));
        }
        Ok(path)
    }

    /// The work on this and all coarser levels.
    pub fn all_work(&self) -> Outcome {
        let mut work = self.work;
        if let Some((coarse, _)) = &self.coarse {
            work.add(coarse.all_work());
        }
        work
    }

    /// The positions at a dryness, and how the last step ended.
    ///
    /// # Errors
    /// [`Stuck`] when the solver does not get there.
    pub fn at(&mut self, dryness: f64) -> Result<(Vec<DVec3>, Outcome), Stuck> {
        if dryness > 0.0
            && let Some(reached) = self.refined(dryness)
        {
            return Ok(reached);
        }
        self.along(dryness)
    }

    /// The positions at a dryness, from those of the coarser mesh; `None` without one, or when they lead nowhere.
    fn refined(&mut self, dryness: f64) -> Option<(Vec<DVec3>, Outcome)> {
        let (coarse, way) = self.coarse.as_mut()?;
        let mut positions = way.carried(&coarse.at(dryness).ok()?.0);
        let sheet = self.solver.sheet();
        for (v, place) in sheet.places.iter().enumerate().filter(|(v, _)| sheet.held[*v]) {
            positions[v] = DVec3::new(place.x, place.y, 0.0);
        }
        let rest = self.drying.rest(dryness, 1.0);
        // What the way back stretches is no tension: the first step foresees none.
        let length = |spring: &Spring| {
            let [a, b] = spring.ends.map(|v| positions[v as usize]);
            (b - a).norm()
        };
        let before = Rest { lengths: sheet.springs.iter().map(length).collect(), ..rest.clone() };
        let most = self.settings.iterations.min(MOST_FROM_COARSE);
        let settled = self.solver.settle((&before, &rest), &mut positions, self.settings.tolerance, most);
        let (Ok(outcome) | Err(NotReached(outcome))) = settled;
        self.work.add(outcome);
        settled.ok().map(|outcome| (positions, outcome))
    }

    /// The positions at a dryness, from rung to rung.
    fn along(&mut self, dryness: f64) -> Result<(Vec<DVec3>, Outcome), Stuck> {
        let rung = |number: usize| number as f64 / f64::from(RUNGS);
        let below = (dryness * f64::from(RUNGS)).floor().clamp(0.0, f64::from(RUNGS)) as usize;
        while self.rungs.len() <= below {
            let last = self.rungs.len() - 1;
            let mut positions = self.rungs[last].0.clone();
            let outcome = self.advance((rung(last), 1.0), (rung(last + 1), 1.0), &mut positions, HALVINGS)?;
            self.rungs.push((positions, outcome));
        }
        let (mut positions, mut outcome) = self.rungs[below].clone();
        if dryness > rung(below) {
            outcome = self.advance((rung(below), 1.0), (dryness, 1.0), &mut positions, HALVINGS)?;
        }
        Ok((positions, outcome))
    }

    /// Moves a shape from one load to another, by halves where it does not settle at once.
    fn advance(&mut self, from: Load, to: Load, positions: &mut Vec<DVec3>, halvings: u32) -> Result<Outcome, Stuck> {
        let start = positions.clone();
        let (before, rest) = (self.drying.rest(from.0, from.1), self.drying.rest(to.0, to.1));
        let settled =
            self.solver.settle((&before, &rest), positions, self.settings.tolerance, self.settings.iterations);
        let (Ok(outcome) | Err(NotReached(outcome))) = settled;
        self.work.add(outcome);
        if settled.is_ok() {
            return Ok(outcome);
        }
        if halvings == 0 || from == to {
            return Err(Stuck { dryness: to.0, outcome });
        }
        *positions = start;
        let middle = (0.5 * (from.0 + to.0), 0.5 * (from.1 + to.1));
        self.advance(from, middle, positions, halvings - 1)?;
        self.advance(middle, to, positions, halvings - 1)
    }
}
