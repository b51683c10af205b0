//! The tables `[climate]` and `[season]`.

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

choice! {
    /// What holds the autumn back while a year's days are long.
    pub enum Gate {
        /// Rates grow with the hours by which a day is shorter than `day_length`; none before the longest day.
        DayLength = "day-length",
        /// Nothing: weather alone, as in the paper.
        None = "none",
    }
}

settings! {
    /// The weather around the tree: the same every day (`temperature`, `humidity`), a daily `series`, or the mean year of a
    /// `latitude`.
    pub struct Climate {
        /// Air temperature of every day; 12 when neither `series` nor `latitude` nor `time.moment` is given.
        temperature: Option<f64> = None, unit "°C", range -60.0 => 60.0;
        /// Relative humidity of every day, also of a series without `rh_pct`; 0.7 when absent, except in the mean year of a
        /// latitude, whose own it replaces.
        humidity: Option<f64> = None, range 0.0 => 1.0;
        /// A file of daily weather: comma-separated, with a header that names `date` (2017-08-15), `tmean_c` (or `tmin_c` and
        /// `tmax_c`), and perhaps `rh_pct` and `daylength_h`; other columns are passed over. Day 0 is its first day.
        series: Option<String> = None;
        /// Degrees north of the equator (south below 0): for day lengths of a series without them, or alone for the mean year
        /// of the place, whose day 0 is 1 January. 45 when `time.moment` stands without weather.
        latitude: Option<f64> = None, unit "°", range -66.0 => 66.0;
    }
}

settings! {
    /// One state of a leaf: how long it lasts and what follows. Four values stand for wet and cold, wet and warm, dry and
    /// cold, dry and warm.
    pub struct State {
        /// Half-life; absent for a state that lasts.
        half_life: Option<Corners> = None, unit "d";
        /// Hidden stages of equal rate that a leaf passes within the state; with more of them leaves leave it more nearly together.
        /// The half-life is that of all stages together. 1 is the paper's chain.
        stages: u32 = 1, range 1 => 64;
        /// Whether the state waits for short days and follows its leaf's own speed; false for those of spring.
        gate: bool = true;
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
    /// The species' crown as leaves feel it, and how leaves differ within it. A leaf's exposure is 0 low and inside, 1 at the top
    /// and outside of this crown, whatever the tree at hand looks like, so that no leaf depends on another.
    pub struct NominalCrown {
        /// Height of an old tree; 0 when the crown is not known, and every leaf's exposure is one half.
        height: f64 = 0.0, unit "m", range 0.0 => 150.0;
        /// Radius of its crown.
        radius: f64 = 5.0, unit "m", range 0.01 => 100.0;
        /// Height of its lowest leaves.
        base: f64 = 0.0, unit "m", range 0.0 => 150.0;
        /// Age at which a tree has 63 % of that height; radius and base grow in proportion.
        years: f64 = 30.0, unit "years", range 0.1 => 1000.0;
        /// Logarithm of how many times faster the most exposed leaf passes its states than the least; below 0 the inside
        /// goes first.
        rate: f64 = 0.0, range -4.0 => 4.0;
        /// Spread of the logarithm of speed from limb to limb.
        limb: f64 = 0.0, range 0.0 => 2.0;
        /// Spread of the logarithm of speed from shoot to shoot.
        shoot: f64 = 0.0, range 0.0 => 2.0;
        /// For each state that may follow another: logarithm of the ratio of its odds between the most and the least exposed leaf.
        odds: BTreeMap<String, f64> = BTreeMap::new(), range -8.0 => 8.0;
    }
}

settings! {
    /// How leaves pass from state to state.
    pub struct Settings {
        /// How the chain is advanced.
        mode: Mode = Mode::Exact;
        /// Step of `mode = "paper"`.
        step: f64 = 1.0, unit "d", range 1e-4 => 1000.0;
        /// State of every leaf at day 0. Where there are buds, a year's weather that begins in winter begins in bud.
        start: String = "green".to_owned();
        /// Temperature of the cold corners.
        cold: f64 = 0.0, unit "°C", range -60.0 => 60.0;
        /// Temperature of the warm corners.
        warm: f64 = 25.0, unit "°C", range -60.0 => 60.0;
        /// Humidity of the dry corners.
        dry: f64 = 0.3, range 0.0 => 1.0;
        /// Humidity of the wet corners.
        wet: f64 = 0.9, range 0.0 => 1.0;
        /// What holds the autumn back in a year's weather; a constant climate has no gate.
        gate: Gate = Gate::DayLength;
        /// Length of the day below which leaves begin to leave their gated states.
        day_length: f64 = 13.1, unit "h", range 0.0 => 24.0;
        /// A day shorter than `day_length` by so much has rates as the half-lives say.
        day_length_span: f64 = 3.0, unit "h", range 0.1 => 24.0;
        /// How much `day_length` grows for each kelvin by which May to August are warmer than `summer_normal` (at most 3 K count).
        summer_advance: f64 = 0.0, unit "h/K", range -2.0 => 2.0;
        /// Mean temperature of a usual May to August.
        summer_normal: f64 = 17.5, unit "°C", range -20.0 => 40.0;
        /// Sum of daily temperatures above `flush_base` from the spring equinox on at which buds begin to open.
        flush_degree_days: f64 = 285.0, unit "K d", range 0.0 => 10000.0;
        /// Temperature above which spring warmth counts.
        flush_base: f64 = 0.0, unit "°C", range -20.0 => 30.0;
        /// Spread of `day_length` from tree to tree of `[[trees]]`.
        tree_spread: f64 = 0.45, unit "h", range 0.0 => 6.0;
        /// How much leaves differ within a crown, by exposure, limb and shoot: 1 as [season.crown] says, 0 not at all, which
        /// is the plain chain.
        coherence: f64 = 0.0, range 0.0 => 1.0;
        /// The crown and the differences within it.
        crown: NominalCrown = NominalCrown::default();
        /// The states by name; leaves in the state `fallen` are no longer on the tree, `bud` are not yet.
        states: BTreeMap<String, State> = BTreeMap::new();
    }
}

impl State {
    /// A state with the same half-life (days) and chances in every climate; it lasts without targets.
    #[must_use]
    pub fn in_any_climate(half_life: f64, next: &[(&str, f64)]) -> Self {
        let row: Vec<f64> = next.iter().map(|(_, chance)| *chance).collect();
        Self {
            half_life: (!next.is_empty()).then_some(Corners::Same(half_life)),
            next: next.iter().map(|(name, _)| (*name).to_owned()).collect(),
            wet_cold: row.clone(),
            wet_warm: row.clone(),
            dry_cold: row.clone(),
            dry_warm: row,
            ..Self::default()
        }
    }
}

impl Settings {
    /// A season with these states, which begins in the first.
    #[must_use]
    pub fn of_states(states: &[(&str, State)]) -> Self {
        Self {
            start: states.first().map_or_else(String::new, |(name, _)| (*name).to_owned()),
            states: states.iter().map(|(name, state)| ((*name).to_owned(), state.clone())).collect(),
            ..Self::default()
        }
    }
}
