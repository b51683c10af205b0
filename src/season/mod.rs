//! The season stage: climate and time -> the state of every leaf, by one event clock a leaf.
//!
//! A leaf is a continuous-time Markov chain whose holding rates are ln 2 over the half-lives of equation (5) and whose
//! targets are the chances X, both interpolated between four corners of the climate. `mode = "exact"` follows each leaf's own
//! waiting times (`clock`); `mode = "paper"` applies equations (4) to (6) once a step. The distribution over states
//! is known in both modes without sampling ([`Transition`]), and the report compares the sample with it.
//!
//! It does not know shapes, colours or where leaves fall. Source: Tang, Wu and Fan 2013, equations (4) to (6).

mod assignment;
mod chain;
mod check;
mod clock;
mod mixture;
mod transition;

pub use assignment::{LeafStates, assign};
pub use chain::{Chain, reachable};
pub use check::check;
pub use mixture::mixed;
pub use transition::Transition;

use crate::base::settings::Corners;
use crate::{choice, settings};
use std::collections::BTreeMap;

choice! {
    /// How the chain is advanced.
    pub enum Mode {
        /// The continuous-time chain, sampled exactly for each leaf.
        Exact = "exact",
        /// Equations (4) to (6) once a step, at most one jump each.
        Paper = "paper",
    }
}

settings! {
    /// The weather around the tree.
    pub struct Climate {
        /// Air temperature.
        temperature: f64 = 12.0, unit "°C", range -60.0 => 60.0;
        /// Relative humidity.
        humidity: f64 = 0.7, range 0.0 => 1.0;
    }
}

settings! {
    /// One state of a leaf: how long it lasts and what follows. Four values stand for wet and cold, wet and warm, dry and
    /// cold, dry and warm.
    pub struct State {
        /// Half-life; absent for a state that lasts.
        half_life: Option<Corners> = None, unit "d";
        /// The states that may follow.
        next: Vec<String> = Vec::new();
        /// Chance of each of `next` where it is wet and cold; sums to 1.
        wet_cold: Vec<f64> = Vec::new(), range 0.0 => 1.0;
        /// Chance of each of `next` where it is wet and warm; sums to 1.
        wet_warm: Vec<f64> = Vec::new(), range 0.0 => 1.0;
        /// Chance of each of `next` where it is dry and cold; sums to 1.
        dry_cold: Vec<f64> = Vec::new(), range 0.0 => 1.0;
        /// Chance of each of `next` where it is dry and warm; sums to 1.
        dry_warm: Vec<f64> = Vec::new(), range 0.0 => 1.0;
    }
}

settings! {
    /// How leaves pass from state to state.
    pub struct Settings {
        /// How the chain is advanced.
        mode: Mode = Mode::Exact;
        /// Step of `mode = "paper"`.
        step: f64 = 1.0, unit "d", range 1e-4 => 1000.0;
        /// State of every leaf at day 0.
        start: String = "green".to_owned();
        /// Temperature of the cold corners.
        cold: f64 = 0.0, unit "°C", range -60.0 => 60.0;
        /// Temperature of the warm corners.
        warm: f64 = 25.0, unit "°C", range -60.0 => 60.0;
        /// Humidity of the dry corners.
        dry: f64 = 0.3, range 0.0 => 1.0;
        /// Humidity of the wet corners.
        wet: f64 = 0.9, range 0.0 => 1.0;
        /// The states by name; leaves in the state `fallen` are no longer on the tree.
        states: BTreeMap<String, State> = BTreeMap::new();
    }
}
