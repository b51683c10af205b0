//! The season stage: weather and time -> the state of every leaf, by one event clock a leaf.
//!
//! A leaf is a continuous-time Markov chain whose holding rates are ln 2 over the half-lives of equation (5) and whose
//! targets are the chances X, both interpolated between four corners of the climate. In a year's weather the rates change from
//! day to day, wait for short days (`gate`), and buds open again each spring. `mode = "exact"` follows each leaf's own waiting
//! times; `mode = "paper"` applies equations (4) to (6) once a step. The distribution over states in
//! continuous time is known without sampling, and the report compares the sample with it.
//!
//! Inside: `weather` (with `series`, `sine_year`, `day_length`) is what the days are like; `chain` is rates and chances at
//! one climate; `course` is a chain through all days; `exposure` is how leaves differ within a crown; `clock` is one leaf;
//! `law` is all leaves without sampling; `population` is the leaves of a species; `moment` names days by what is seen.
//! The stage does not know shapes, colours or where leaves fall. Source: Tang, Wu and Fan 2013, equations (4) to (6).

mod chain;
mod check;
mod clock;
mod course;
mod day_length;
mod exposure;
mod law;
mod moment;
mod population;
mod propagation;
mod sample;
pub mod series;
mod settings;
mod sine_year;
mod stages;
#[cfg(test)]
mod tests;
mod transition;
mod weather;

pub use chain::Chain;
pub use check::check;
pub use day_length::hours as day_length;
pub use exposure::{Crown, Position};
pub use law::Law;
pub use moment::{MOST_DAYS, Moment};
pub use population::{Leaf, Population};
pub use sample::{LeafStates, Sample, figures};
pub use settings::{Climate, Gate, Mode, NominalCrown, Settings, State};
pub use transition::Transition;
pub use weather::{Day, Weather};

/// Name of the state of a leaf that is still in its bud.
pub const BUD: &str = "bud";
/// Name of the state of a leaf that has left the tree.
pub const FALLEN: &str = "fallen";
