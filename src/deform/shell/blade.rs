//! The shell as its comparison integrators see it: sheet, rest states, linear solves and the solver's own result.

use super::drying::{Drying, Irregularity};
use super::energy::{Bent, Rest, energy};
use super::newton::{Plan, Solver};
use super::path::Path;
use super::settings::Settings;
use super::sheet::Sheet;
use super::tissue::Tissue;
use crate::base::vector::DVec3;
use crate::deform::integrators::Run;
use crate::deform::{DeformError, Flat};

/// Rounds of inverse iteration for the slowest vibration.
const ROUNDS: u32 = 12;

/// A blade's sheet and tissue.
pub struct Blade {
    sheet: Sheet,
    tissue: Tissue,
    plan: Plan,
}

impl Blade {
    /// Of a leaf.
    ///
    /// # Errors
    /// [`DeformError`] for a broken mesh.
    pub fn new(settings: &Settings, flat: &Flat) -> Result<Self, DeformError> {
        crate::deform::sound(flat.mesh)?;
        let tissue = Tissue::new(settings, flat);
        let sheet = Sheet::new(settings, flat.mesh, tissue.extent, &tissue.ribs);
        let plan = Plan::new(&sheet);
        Ok(Self { sheet, tissue, plan })
    }

    /// Its sheet.
    pub fn sheet(&self) -> &Sheet {
        &self.sheet
    }

    /// How a variant of it dries.
    pub fn drying<'a>(&'a self, settings: &'a Settings, seed: u64, variant: u32) -> Drying<'a> {
        Drying::new(settings, &self.sheet, &self.tissue, &Irregularity::new(settings, seed, variant))
    }

    /// Its vertices when flat.
    pub fn flat(&self) -> Vec<DVec3> {
        self.sheet.places.iter().map(|p| DVec3::new(p.x, p.y, 0.0)).collect()
    }

    /// Its energy.
    pub fn energy(&self, rest: &Rest, positions: &[DVec3]) -> f64 {
        energy(&self.sheet, rest, positions)
    }

    /// Its largest strain.
    pub fn strain(&self, rest: &Rest, positions: &[DVec3]) -> f64 {
        super::strain(&self.sheet, &rest.lengths, positions)
    }

    /// A solver of linear systems with its Hessian.
    pub fn linear(&self) -> Solver<'_> {
        Solver::new(&self.sheet, &self.plan)
    }

    /// The slowest vibration of the flat blade, radians over the unit of time at unit density.
    pub fn slowest_frequency(&self, drying: &Drying) -> f64 {
        let rest = Rest { weight: 0.0, ..drying.rest(0.0, 0.0) };
        let (flat, areas) = (self.flat(), &self.sheet.areas);
        let mut linear = self.linear();
        let rough = |v: usize| DVec3::new(0.0, 0.0, 1.0 + ((v * 7919) % 13) as f64 / 13.0);
        let mut mode: Vec<DVec3> = (0..flat.len()).map(rough).collect();
        let mut squared = 1.0;
        for _ in 0..ROUNDS {
            let size = mode.iter().zip(areas).map(|(m, area)| m.norm_squared() * area).sum::<f64>().sqrt();
            let load: Vec<DVec3> = mode.iter().zip(areas).map(|(m, area)| m * (area / size)).collect();
            let Some(next) = linear.solved(&rest, &flat, 0.0, &load) else { break };
            squared = 1.0 / next.iter().zip(areas).map(|(m, area)| m.norm_squared() * area).sum::<f64>().sqrt();
            mode = next;
        }
        if squared > 0.0 { squared.sqrt() } else { 1.0 }
    }

    /// The shapes of the shell's own solver.
    ///
    /// # Errors
    /// [`DeformError`] when it does not settle.
    pub fn newton(&self, settings: &Settings, drying: &Drying, drynesses: &[f64]) -> Result<Run, DeformError> {
        let mut path = Path::new(settings, &self.sheet, drying, &self.plan)?;
        let mut run = Run::default();
        for &dryness in drynesses {
            let (positions, outcome) = path.at(dryness)?;
            run.energies.push(outcome.energy);
            run.strains.push(self.strain(&drying.rest(dryness, 1.0), &positions));
            run.shapes.push(positions);
        }
        run.steps = path.work.iterations;
        run.factorisations = path.work.factorisations;
        Ok(run)
    }
}

impl Solver<'_> {
    /// Solves (K + inertia M) d = load - g at positions, K the tamed Hessian, g the gradient, M the areas; held vertices get
    /// nought. `None` when the matrix is not positive definite.
    pub fn solved(&mut self, rest: &Rest, positions: &[DVec3], inertia: f64, load: &[DVec3]) -> Option<Vec<DVec3>> {
        let bent = Bent::new(self.sheet(), rest, positions);
        let right: Vec<DVec3> = load.iter().zip(bent.gradient()).map(|(load, g)| load - g).collect();
        self.solve_tamed(&bent, inertia, &right)
    }
}
