//! Particles and springs: masses, the mesh's edges with their natural lengths, forces, and the two halves of equation (1).

use crate::base::flat_mesh::FlatMesh;
use crate::base::vector::DVec3;
use crate::deform::paper::force::Force;
use crate::deform::paper::masses;
use crate::deform::settings::Settings;

/// What does not change during a run. SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct System {
    /// Positions at rest, z = 0.
    pub rest: Vec<DVec3>,
    /// Masses, kg.
    pub masses: Vec<f64>,
    /// One over the mass, 0 for a held vertex.
    pub mobility: Vec<f64>,
    /// The ends of each spring.
    pub springs: Vec<[u32; 2]>,
    /// Natural lengths, metres.
    pub lengths: Vec<f64>,
    /// Triangles, for the normals.
    pub triangles: Vec<[u32; 3]>,
    /// Spring constant, N/m.
    pub stiffness: f64,
    /// Drag on a vertex, N s/m.
    pub drag: f64,
    /// Friction along a spring against any relative velocity, N s/m.
    pub friction: f64,
}

/// What changes.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Metres.
    pub positions: Vec<DVec3>,
    /// Metres a second.
    pub velocities: Vec<DVec3>,
}

impl System {
    /// One particle of a kilogram on a spring of a metre along x whose other end is held: w^2 = k / m, w in radians a second.
    pub fn oscillator(frequency: f64) -> Self {
        Self {
            rest: vec![DVec3::zeros(), DVec3::x()],
            masses: vec![1.0, 1.0],
            mobility: vec![0.0, 1.0],
            springs: vec![[0, 1]],
            lengths: vec![1.0],
            triangles: Vec::new(),
            stiffness: frequency * frequency,
            drag: 0.0,
            friction: 0.0,
        }
    }

    /// The system of a flat leaf: constraint steps 1 to 3 of the paper's section 4.2.
    pub fn new(settings: &Settings, mesh: &FlatMesh) -> Self {
        let rest: Vec<DVec3> = mesh.positions.iter().map(|p| DVec3::new(p.x, p.y, 0.0)).collect();
        let unit = settings.mass_unit * 1e-6;
        let masses: Vec<f64> = mesh.greys.iter().map(|&grey| masses::mass(grey) * unit).collect();
        let mut mobility: Vec<f64> = masses.iter().map(|m| 1.0 / m).collect();
        for &v in &mesh.held {
            mobility[v as usize] = 0.0;
        }
        let springs = mesh.edges();
        let lengths = springs.iter().map(|&[a, b]| (rest[b as usize] - rest[a as usize]).norm()).collect();
        let triangles = mesh.triangles.clone();
        let (stiffness, drag, friction) = (settings.stiffness, settings.drag, settings.friction);
        Self { rest, masses, mobility, springs, lengths, triangles, stiffness, drag, friction }
    }

    /// The flat leaf at rest.
    pub fn at_rest(&self) -> State {
        State { positions: self.rest.clone(), velocities: vec![DVec3::zeros(); self.rest.len()] }
    }

    /// The joined forces on every vertex: springs, friction, drag, and the external one.
    pub fn forces(&self, state: &State, force: &Force) -> Vec<DVec3> {
        let mut forces = force.on(&state.positions, &self.triangles);
        for (force, velocity) in forces.iter_mut().zip(&state.velocities) {
            *force -= velocity * self.drag;
        }
        for (&[a, b], length) in self.springs.iter().zip(&self.lengths) {
            let (a, b) = (a as usize, b as usize);
            let side = state.positions[b] - state.positions[a];
            let stretched = side.norm();
            let along = side * (self.stiffness * (1.0 - length / stretched));
            let pull = along + (state.velocities[b] - state.velocities[a]) * self.friction;
            forces[a] += pull;
            forces[b] -= pull;
        }
        forces
    }

    /// First half of equation (1): v(t + dt) = v(t) + dt F(t) / m.
    pub fn accelerate(&self, state: &mut State, forces: &[DVec3], step: f64) {
        for ((velocity, force), mobility) in state.velocities.iter_mut().zip(forces).zip(&self.mobility) {
            *velocity += force * (step * mobility);
        }
    }

    /// Second half: P(t + dt) = P(t) + dt v(t + dt), with the new velocity, which makes it semi-implicit.
    pub fn displace(&self, state: &mut State, step: f64) {
        for (position, velocity) in state.positions.iter_mut().zip(&state.velocities) {
            *position += velocity * step;
        }
    }

    /// Largest stretch of a spring relative to its natural length; NaN or infinite when the leaf flew apart.
    pub fn strain(&self, positions: &[DVec3]) -> f64 {
        let strain = |(&[a, b], length): (&[u32; 2], &f64)| {
            (positions[b as usize] - positions[a as usize]).norm() / length - 1.0
        };
        let larger = |worst: f64, strain: f64| if strain.is_finite() { worst.max(strain) } else { f64::INFINITY };
        self.springs.iter().zip(&self.lengths).map(strain).fold(0.0, larger)
    }
}
