//! The deformation stage: a flat leaf -> one curled shape for each state and variant that a leaf wears.

use crate::{choice, settings};
use std::collections::BTreeMap;

choice! {
    /// Which mechanics bends the leaf.
    pub enum Model {
        /// The mass-spring system of Tang, Wu and Fan 2013, equations (1) to (3).
        Paper = "paper",
    }
}

settings! {
    /// How a leaf in a state is bent.
    pub struct StateShape {
        /// How dry the leaf is: 0 flat, 1 as curled as the model makes it.
        dryness: f64 = 0.0, range 0.0 => 1.0;
    }
}

settings! {
    /// How leaves curl.
    pub struct Settings {
        /// The mechanics.
        model: Model = Model::Paper;
        /// Time step of equation (1); absent for a stable one chosen from the largest eigenvalue.
        step: Option<f64> = None, unit "s", range 1e-9 => 1.0;
        /// Time steps to the driest shape; a state's shape is the snapshot at its dryness times these.
        steps: u32 = 400, range 1 => 4294967295u32;
        /// Stiffness of the springs.
        stiffness: f64 = 40.0, unit "N/m", range 1e-6 => 1e9;
        /// Largest stretch of a spring relative to its natural length, tau_c of equation (2).
        strain_limit: f64 = 0.1, range 0.0 => 1e6;
        /// External force on each vertex along the leaf's upper normal.
        force: f64 = 0.02, unit "N", range -1e6 => 1e6;
        /// Different shapes made for each state.
        shapes: u32 = 3, range 1 => 64;
        /// The states' shapes by name; a state without an entry is flat.
        states: BTreeMap<String, StateShape> = BTreeMap::new();
    }
}
