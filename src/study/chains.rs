//! Chains whose exact shares are known: reference values of 50-digit arithmetic, and the settings that make the program's own
//! chain one of them.

use crate::base::calendar::Date;
use crate::base::settings::Corners;
use crate::season::{Day, Gate, Population, Position, Settings, State, Weather};

/// A chain: half-lives (0 for a state that lasts), and the chances of what follows each state.
#[derive(Clone, Debug)]
pub struct Known {
    /// Its name in the tables.
    pub name: &'static str,
    /// Half-life of each state, days.
    pub half_lives: &'static [f64],
    /// For each state: the states that follow, with their chances.
    pub targets: &'static [&'static [(u16, f64)]],
    /// Days, and the shares of the states then of leaves that began in the first.
    pub values: &'static [(f64, &'static [f64])],
}

/// Four states with branches.
const BRANCHING: &[&[(u16, f64)]] = &[&[(1, 0.6), (2, 0.3), (3, 0.1)], &[(2, 0.7), (3, 0.3)], &[(3, 1.0)], &[]];
const LINE: &[&[(u16, f64)]] = &[&[(1, 1.0)], &[(2, 1.0)], &[]];

/// The chains in a constant climate.
pub const KNOWN: [Known; 6] = [
    Known {
        name: "M1",
        half_lives: &[10.0, 0.0],
        targets: &[&[(1, 1.0)], &[]],
        values: &[
            (1.0, &[0.933_032_991_536_8, 0.066_967_008_463_19]),
            (10.0, &[0.5, 0.5]),
            (100.0, &[0.000_976_562_5, 0.999_023_437_5]),
        ],
    },
    Known {
        name: "M2",
        half_lives: &[4.0, 12.0],
        targets: &[&[(1, 1.0)], &[(0, 1.0)]],
        values: &[
            (1.0, &[0.845_275_394_488_1, 0.154_724_605_511_9]),
            (10.0, &[0.324_409_424_311, 0.675_590_575_689]),
            (1000.0, &[0.25, 0.75]),
        ],
    },
    Known {
        name: "M3",
        half_lives: &[5.0, 5.0, 0.0],
        targets: LINE,
        values: &[
            (1.0, &[0.870_550_563_296_1, 0.120_683_933_696_7, 0.008_765_503_007_16]),
            (5.0, &[0.5, 0.346_573_590_28, 0.153_426_409_72]),
            (20.0, &[0.0625, 0.173_286_795_14, 0.764_213_204_86]),
        ],
    },
    Known {
        name: "M4",
        half_lives: &[5.0, 20.0, 0.0],
        targets: LINE,
        values: &[
            (1.0, &[0.870_550_563_296_1, 0.127_181_020_838_3, 0.002_268_415_865_581]),
            (5.0, &[0.5, 0.454_528_553_671_6, 0.045_471_446_328_38]),
            (20.0, &[0.0625, 0.583_333_333_333_3, 0.354_166_666_666_7]),
        ],
    },
    Known {
        name: "M5",
        half_lives: &[30.0, 15.0, 10.0, 0.0],
        targets: BRANCHING,
        values: &[
            (7.0, &[0.850_667_160_950_9, 0.076_219_525_338_4, 0.043_231_697_818_59, 0.029_881_615_892_15]),
            (30.0, &[0.5, 0.15, 0.108_75, 0.241_25]),
            (90.0, &[0.125, 0.065_625, 0.058_652_343_75, 0.750_722_656_25]),
        ],
    },
    Known {
        name: "M6",
        half_lives: &[1e-3, 1.0, 1e3, 0.0],
        targets: &[&[(1, 1.0)], &[(2, 1.0)], &[(3, 1.0)], &[]],
        values: &[
            (1e-3, &[0.5, 0.499_806_899_890_3, 0.000_193_100_062_586_2, 4.707_089_438_651e-11]),
            (1.0, &[0.0, 0.500_500_500_500_5, 0.499_306_898_696_7, 0.000_192_600_802_758_4]),
            (100.0, &[0.0, 7.896_505_557_768e-31, 0.933_967_892_463_2, 0.066_032_107_536_8]),
        ],
    },
];

/// Shares after 30 days of M5 with its hazards times 1, 3 and 0 for ten days each.
pub const STEPPED_HAZARDS: [f64; 4] =
    [0.396_850_262_992, 0.143_616_079_053_1, 0.110_787_939_666_5, 0.348_745_718_288_3];

impl Known {
    /// Rate at which each state is left, 1/day.
    #[must_use]
    pub fn rates(&self) -> Vec<f64> {
        let rate = |&half_life: &f64| if half_life > 0.0 { std::f64::consts::LN_2 / half_life } else { 0.0 };
        self.half_lives.iter().map(rate).collect()
    }

    /// What follows each state.
    #[must_use]
    pub fn moves(&self) -> Vec<Vec<(u16, f64)>> {
        self.targets.iter().map(|targets| targets.to_vec()).collect()
    }

    /// The same chain as the settings of a season.
    #[must_use]
    pub fn settings(&self) -> Settings {
        const NAMES: [&str; 4] = ["a", "b", "c", "d"];
        let next = |targets: &[(u16, f64)]| -> Vec<(&str, f64)> {
            targets.iter().map(|&(target, chance)| (NAMES[usize::from(target) % 4], chance)).collect()
        };
        let states = self.half_lives.iter().zip(self.targets).zip(NAMES);
        let states: Vec<(&str, State)> = states
            .map(|((half_life, targets), name)| (name, State::in_any_climate(*half_life, &next(targets))))
            .collect();
        Settings::of_states(&states)
    }
}

/// The same weather every day.
#[must_use]
pub fn steady() -> Weather {
    Weather::constant(12.0, 0.7)
}

/// Leaves 0 to `count` of a season, all alike.
#[must_use]
pub fn leaves(settings: &Settings, weather: &Weather, seed: u64, count: u64) -> Population {
    let mut population = Population::new(settings, weather, seed);
    let place = |id: u64| (id, Position { height: 5.0, distance: 2.0, limb: id % 13, shoot: id / 8 });
    population.add(None, None, (0..count).map(place));
    population
}

/// M5 in a weather by whose temperature its hazards are those of its own times a factor for each day. The factors lie from
/// `least` to `most`.
#[must_use]
pub fn with_hazards(factors: &[f64], [least, most]: [f64; 2]) -> Option<(Settings, Weather)> {
    let mut settings = Settings { gate: Gate::None, ..KNOWN[4].settings() };
    for state in settings.states.values_mut() {
        if let Some(base) = state.half_life.map(|half_life| half_life.values()[0]) {
            state.half_life = Some(Corners::Each([base / least, base / most, base / least, base / most]));
        }
    }
    // Half-lives are linear in the temperature: 1 / factor lies so far from 1 / least to 1 / most.
    let warmth = |factor: f64| (1.0 / least - 1.0 / factor) / (1.0 / least - 1.0 / most);
    let temperature = |factor: f64| settings.cold + warmth(factor) * (settings.warm - settings.cold);
    let day = |&factor: &f64| Day { temperature: temperature(factor), humidity: 0.6, day_length: Some(10.0) };
    let weather = Weather::series(Date::new(2017, 9, 1)?, factors.iter().map(day).collect(), None)?;
    Some((settings, weather))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chances_sum_to_one_and_values_too() {
        for known in &KNOWN {
            assert_eq!(known.half_lives.len(), known.targets.len());
            for targets in known.targets.iter().filter(|targets| !targets.is_empty()) {
                assert!((targets.iter().map(|target| target.1).sum::<f64>() - 1.0).abs() < 1e-15);
            }
            for (_, values) in known.values {
                assert!((values.iter().sum::<f64>() - 1.0).abs() < 1e-11, "{}", known.name);
            }
        }
    }
}
