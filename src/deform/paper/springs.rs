//! The mass-spring system by itself, step by step: what studies of its stability and of its orders look at.

use super::force::Force;
use super::system::{State, System};
use super::{projection, stability};
use crate::base::flat_mesh::FlatMesh;
use crate::base::vector::DVec3;
use crate::deform::settings::Settings;

/// Masses and springs in motion. SI units.
#[derive(Clone, Debug)]
pub struct Springs {
    system: System,
    state: State,
    force: Force,
}

impl Springs {
    /// A leaf at rest under no force, with the settings' stiffness, drag and friction.
    #[must_use]
    pub fn new(settings: &Settings, mesh: &FlatMesh) -> Self {
        let system = System::new(settings, mesh);
        let state = system.at_rest();
        Self { system, state, force: Force::Constant(DVec3::zeros()) }
    }

    /// One particle of a kilogram on a spring of a metre along x whose other end is held: its frequency in radians a second.
    #[must_use]
    pub fn oscillator(frequency: f64) -> Self {
        let system = System::oscillator(frequency);
        let state = system.at_rest();
        Self { system, state, force: Force::Constant(DVec3::zeros()) }
    }

    /// Gives each particle another mass, kg; held ones stay held.
    pub fn weigh(&mut self, mass: impl Fn(usize) -> f64) {
        for number in 0..self.system.masses.len() {
            self.system.masses[number] = mass(number);
            if self.system.mobility[number] > 0.0 {
                self.system.mobility[number] = 1.0 / mass(number);
            }
        }
    }

    /// Moves each particle by the vector that `way` gives for its number and place.
    pub fn displace(&mut self, way: impl Fn(usize, DVec3) -> DVec3) {
        self.state.positions.iter_mut().enumerate().for_each(|(number, p)| *p += way(number, *p));
    }

    /// Gives each particle the velocity that `velocity` gives for its number and place.
    pub fn stir(&mut self, velocity: impl Fn(usize, DVec3) -> DVec3) {
        let moved = |(number, p): (usize, &DVec3)| velocity(number, *p);
        self.state.velocities = self.state.positions.iter().enumerate().map(moved).collect();
    }

    /// Pulls at every particle with the same force, N.
    pub fn pull(&mut self, force: DVec3) {
        self.force = Force::Constant(force);
    }

    /// Twice the inverse of the fastest undamped frequency, seconds: equation (1) is stable below it.
    #[must_use]
    pub fn critical_step(&self) -> f64 {
        2.0 / stability::fastest(&self.system).sqrt()
    }

    /// One step of equation (1); with a `limit` the strains are bounded by equation (2).
    pub fn advance(&mut self, step: f64, limit: Option<f64>) {
        let forces = self.system.forces(&self.state, &self.force);
        self.system.accelerate(&mut self.state, &forces, step);
        if let Some(limit) = limit {
            projection::bound(&self.system, &mut self.state, step, limit);
        }
        self.system.displace(&mut self.state, step);
    }

    /// Positions, metres.
    #[must_use]
    pub fn positions(&self) -> &[DVec3] {
        &self.state.positions
    }

    /// Velocities, metres a second.
    #[must_use]
    pub fn velocities(&self) -> &[DVec3] {
        &self.state.velocities
    }

    /// Masses, kg.
    #[must_use]
    pub fn masses(&self) -> &[f64] {
        &self.system.masses
    }

    /// Kinetic energy and that of the stretched springs, joules.
    #[must_use]
    pub fn energy(&self) -> f64 {
        let State { positions, velocities } = &self.state;
        let kinetic: f64 = self.system.masses.iter().zip(velocities).map(|(m, v)| 0.5 * m * v.norm_squared()).sum();
        let stretch = |(&[a, b], length): (&[u32; 2], &f64)| {
            let stretch = (positions[b as usize] - positions[a as usize]).norm() - length;
            0.5 * self.system.stiffness * stretch * stretch
        };
        kinetic + self.system.springs.iter().zip(&self.system.lengths).map(stretch).sum::<f64>()
    }

    /// Momentum, kg m/s.
    #[must_use]
    pub fn momentum(&self) -> DVec3 {
        self.system.masses.iter().zip(&self.state.velocities).map(|(m, v)| v * *m).sum()
    }

    /// Angular momentum about the origin, kg m2/s.
    #[must_use]
    pub fn angular_momentum(&self) -> DVec3 {
        let State { positions, velocities } = &self.state;
        let one = |((m, p), v): ((&f64, &DVec3), &DVec3)| p.cross(v) * *m;
        self.system.masses.iter().zip(positions).zip(velocities).map(one).sum()
    }

    /// Largest stretch of a spring relative to its natural length; infinite when the leaf flew apart.
    #[must_use]
    pub fn strain(&self) -> f64 {
        self.system.strain(&self.state.positions)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_oscillator_swings_and_blows_up_beyond_its_critical_step() {
        let mut springs = Springs::oscillator(3.0);
        springs.displace(|number, _| DVec3::x() * 0.01 * number as f64);
        let critical = springs.critical_step();
        assert!((critical - 2.0 / 3.0).abs() < 1e-12);
        let reach = |share: f64| {
            let mut springs = springs.clone();
            (0..500).for_each(|_| springs.advance(share * critical, None));
            (springs.positions()[1].x - 1.0).abs()
        };
        assert!(reach(0.99) < 0.2 && reach(1.01).partial_cmp(&1.0) != Some(std::cmp::Ordering::Less));
    }

    #[test]
    fn a_constant_pull_gives_its_impulse() {
        let mut springs = Springs::oscillator(0.0);
        springs.weigh(|_| 2.0);
        springs.pull(DVec3::z());
        (0..10).for_each(|_| springs.advance(0.1, None));
        assert!((springs.momentum().z - 1.0).abs() < 1e-12 && (springs.energy() - 0.25).abs() < 1e-12);
    }
}
