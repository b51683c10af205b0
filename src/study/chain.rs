//! The chain of the seasons: how far the paper's step and a sample lie from the exact law, and what each costs.

use super::chains::{KNOWN, Known, STEPPED_HAZARDS, leaves, steady, with_hazards};
use super::chart::{self, Curve};
use super::desk::Desk;
use super::numbers::{shown, slope, total_variation};
use super::table::{Field, Table};
use super::timing::{Case, Effort, digest, measured};
use crate::base::diagnostic::Diagnostics;
use crate::season::{Settings, Transition, Weather};

const COLUMNS: [&str; 10] = [
    "chain",
    "t",
    "method",
    "steps",
    "leaves",
    "tv_error",
    "max_abs_error",
    "row_sum_error",
    "cpu_us",
    "ratio_to_exact",
];
/// Steps into which the time is cut.
const STEPS: [u32; 9] = [1, 2, 4, 8, 16, 32, 64, 128, 256];
/// Exceeded by a sample of the branching chain (three degrees of freedom) once in a million.
const CRITICAL: f64 = 30.664_849;
/// Seeds of the samples that are tested.
const SEEDS: [u64; 3] = [1, 2, 3];

/// The leaves of a scene's species, in its weather.
#[derive(Clone, Debug)]
pub struct Own {
    /// Its name.
    pub name: String,
    /// How its leaves pass from state to state.
    pub settings: Settings,
    /// The weather.
    pub weather: Weather,
    /// The day that is looked at.
    pub day: f64,
}

/// Runs the family.
///
/// # Errors
/// Files that cannot be written.
pub fn study(desk: &mut Desk<'_>, own: Option<Own>) -> Result<(), Diagnostics> {
    let mut table = Table::new(&COLUMNS);
    let curves = match own {
        Some(own) => own_rows(desk, &own, &mut table),
        None => known_rows(desk, &mut table),
    };
    desk.write_table("chain.csv", &table)?;
    let frame = chart::Frame {
        title: "Shares of states: total variation from the exact law against work",
        x: ["steps, or leaves", ""],
        y: ["total variation", ""],
        orders: &[-1.0, -0.5],
        floor: Some(1e-13),
        left_out: &["the exact law itself: its error is of the size of rounding (see the table)"],
    };
    desk.write_chart("chain", &chart::chart(&frame, &curves))?;
    let text = format!(
        "`paper` is equations (4) to (6) applied `steps` times, at most one jump each; `exact` is the law exp(Q t) that \
         the program samples leaves from; `sampled` counts leaves.\n\n![total variation](chain.png)\n\n{}",
        table.markdown(&["chain", "t", "method", "steps", "leaves", "tv_error", "max_abs_error", "row_sum_error"])
    );
    desk.section("Seasons: the chain", &text);
    Ok(())
}

/// A row's own figures.
fn push(table: &mut Table, [chain, method]: [&str; 2], t: f64, [steps, count]: [u32; 2], found: &[f64], exact: &[f64]) {
    let most = found.iter().zip(exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let sum = (found.iter().sum::<f64>() - 1.0).abs();
    let count_or_none = |n: u32| if n > 0 { Field::from(n) } else { Field::Number(None) };
    table.push(vec![
        chain.into(),
        t.into(),
        method.into(),
        count_or_none(steps),
        count_or_none(count),
        total_variation(found, exact).into(),
        most.into(),
        sum.into(),
    ]);
}

fn exact(known: &Known, t: f64) -> Vec<f64> {
    let rates = known.rates();
    Transition::exact(&rates, &known.moves(), t).row(rates.len(), 0, t)
}

fn stepped(known: &Known, t: f64, steps: u32) -> Vec<f64> {
    let (rates, count) = (known.rates(), f64::from(steps));
    Transition::stepped(&rates, &known.moves(), t / count, count).row(rates.len(), 0, count)
}

/// The chains whose values are known.
fn known_rows(desk: &mut Desk<'_>, table: &mut Table) -> Vec<Curve> {
    let mut worst: f64 = 0.0;
    for known in &KNOWN {
        for &(t, values) in known.values {
            let program = leaves(&known.settings(), &steady(), 1, 1).laws(&[t])[0].expected.clone();
            worst = program.iter().zip(values).map(|(a, b)| (a - b).abs()).fold(worst, f64::max);
            push(table, [known.name, "exact"], t, [0, 0], &program, values);
            for steps in [1, 8, 64] {
                push(table, [known.name, "paper"], t, [steps, 0], &stepped(known, t, steps), values);
            }
        }
        desk.tell(&format!("chain {}: largest difference so far {}", known.name, shown(worst)));
    }
    worst = worst.max(changing_hazards(table));
    desk.tell(&format!("chain M7, M8: largest difference so far {}", shown(worst)));
    let curve = steps_of_three(desk, table, worst);
    let short_times = short_times(table);
    time_rows(desk, table);
    vec![curve, short_times, sampled(desk, table)]
}

/// Chains M7 and M8, whose rates change from day to day: the largest difference.
fn changing_hazards(table: &mut Table) -> f64 {
    // For the last ten days M7 has no hazard: its shares on day 30 are those on day 20.
    let stepped: Vec<f64> = (0..20).map(|day| [1.0, 3.0][day / 10]).collect();
    let rising: Vec<f64> = (0..30).map(|day| f64::from(2 * day + 1) / 30.0).collect();
    let cases = [
        ("M7", &stepped, [1.0, 3.0], STEPPED_HAZARDS),
        ("M8", &rising, [1.0 / 30.0, 59.0 / 30.0], [0.5, 0.15, 0.108_75, 0.241_25]),
    ];
    let mut worst: f64 = 0.0;
    for (name, factors, range, values) in cases {
        let Some((settings, weather)) = with_hazards(factors, range) else { return f64::INFINITY };
        let days = factors.len() as f64;
        let law = leaves(&settings, &weather, 1, 1).laws(&[days])[0].expected.clone();
        worst = law.iter().zip(values).map(|(a, b)| (a - b).abs()).fold(worst, f64::max);
        push(table, [name, "exact"], 30.0, [0, 0], &law, &values);
    }
    worst
}

/// The paper's step on three states in line over four half-lives: its order.
fn steps_of_three(desk: &mut Desk<'_>, table: &mut Table, worst: f64) -> Curve {
    let (known, t) = (&KNOWN[2], 20.0);
    let values = exact(known, t);
    let mut points = Vec::new();
    for steps in STEPS {
        let found = stepped(known, t, steps);
        push(table, ["M3, order", "paper"], t, [steps, 0], &found, &values);
        points.push([f64::from(steps), total_variation(&found, &values)]);
    }
    let orders: Vec<f64> = points.windows(2).skip(5).filter_map(slope).map(|slope| -slope).collect();
    let (least, most) = orders.iter().fold((f64::INFINITY, 0.0f64), |(a, b), &order| (a.min(order), b.max(order)));
    let passes = worst <= 1e-12 && least >= 0.95 && most <= 1.05;
    let asked = "the exact law within 1e-12 on M1 to M8; the paper's step has order 0.95 to 1.05 from 32 steps on";
    desk.judge("P7", passes, asked, format!("{}; order {least:.3} to {most:.3}", shown(worst)));
    Curve::new("paper's steps, three states in line, t = 4 half-lives", points)
}

/// One step of the paper's over times from a thousandth of a half-life to a thousand.
fn short_times(table: &mut Table) -> Curve {
    let (known, mut points) = (&KNOWN[2], Vec::new());
    for power in -12..=12 {
        let share = libm::pow(10.0, f64::from(power) / 4.0);
        let t = share * known.half_lives[0];
        let (found, values) = (stepped(known, t, 1), exact(known, t));
        push(table, ["M3, one step", "paper"], t, [1, 0], &found, &values);
        points.push([1.0 / share, total_variation(&found, &values)]);
    }
    Curve::new("one step, against half-lives in its length", points)
}

/// Samples of rising size, and three of 100,000 leaves against their law.
fn sampled(desk: &mut Desk<'_>, table: &mut Table) -> Curve {
    let (known, t) = (&KNOWN[4], 30.0);
    let values = known.values[1].1;
    let most: u32 = if desk.request.quick { 5 } else { 6 };
    let shares = |seed: u64, count: u32| {
        let sample = leaves(&known.settings(), &steady(), seed, u64::from(count)).at(t);
        let share = |state: usize| sample.states.iter().filter(|&&s| usize::from(s) == state).count() as f64;
        (0..values.len()).map(|state| share(state) / f64::from(count)).collect::<Vec<f64>>()
    };
    let mut points = Vec::new();
    for power in 2..=most {
        let count = 10u32.pow(power);
        let found = shares(1, count);
        push(table, ["M5", "sampled"], t, [0, count], &found, values);
        points.push([f64::from(count), total_variation(&found, values)]);
        desk.tell(&format!("chain M5, {count} leaves: total variation {}", shown(points[points.len() - 1][1])));
    }
    let chi_square = |seed: u64| {
        let count = 1e5;
        let found = shares(seed, 100_000);
        found.iter().zip(values).map(|(share, p)| count * (share - p) * (share - p) / p).sum::<f64>()
    };
    let statistics = SEEDS.map(chi_square);
    let worst = statistics.iter().copied().fold(0.0, f64::max);
    let asked = "chi-square of 100,000 leaves below its critical value at one in a million (30.66), three seeds";
    desk.judge("P8", worst < CRITICAL, asked, statistics.map(|value| format!("{value:.2}")).join(", "));
    Curve::new("leaves sampled, branching chain", points)
}

/// What the law of one time costs, exactly and in steps.
fn time_rows(desk: &mut Desk<'_>, table: &mut Table) {
    let (known, t) = (&KNOWN[4], 30.0);
    let values = exact(known, t);
    let mut cases = vec![Case::new(move || digest(&exact(known, t)))];
    cases.extend(STEPS.map(|steps| Case::new(move || digest(&stepped(known, t, steps)))));
    cases.push(Case::new(move || {
        let sample = leaves(&known.settings(), &steady(), 1, 10_000).at(t);
        sample.states.iter().fold(0, |sum, state| crate::base::random::hash(sum, u64::from(*state)))
    }));
    let times = measured(&cases, Effort::of(desk.request.quick));
    for (number, times) in times.iter().enumerate() {
        let (method, steps, count, found) = match number {
            0 => ("exact", 0, 0, exact(known, t)),
            _ if number <= STEPS.len() => ("paper", STEPS[number - 1], 0, stepped(known, t, STEPS[number - 1])),
            _ => {
                let sample = leaves(&known.settings(), &steady(), 1, 10_000).at(t);
                let share = |state: usize| sample.states.iter().filter(|&&s| usize::from(s) == state).count();
                ("sampled", 0, 10_000, (0..values.len()).map(|state| share(state) as f64 / 1e4).collect())
            }
        };
        push(table, ["M5, timed", method], t, [steps, count], &found, &values);
        if let Some(row) = table.rows.last_mut() {
            row[8] = (times.seconds[1] * 1e6).into();
            row[9] = times.ratio[1].into();
        }
        desk.steady(&format!("chain M5 {method} {steps}"), times.is_same);
        desk.tell(&format!("chain M5 {method} {steps}: {} us", shown(times.seconds[1] * 1e6)));
    }
}

/// The scene's own chain: steps of several lengths up to its day, and samples.
fn own_rows(desk: &mut Desk<'_>, own: &Own, table: &mut Table) -> Vec<Curve> {
    let law = leaves(&Settings { coherence: 0.0, ..own.settings.clone() }, &own.weather, 1, 1);
    let values = law.laws(&[own.day])[0].expected.clone();
    push(table, [&own.name, "exact"], own.day, [0, 0], &values, &values);
    let (mut stepped, mut sampled) = (Vec::new(), Vec::new());
    for step in [16.0, 8.0, 4.0, 2.0, 1.0, 0.5, 0.25, 0.125] {
        let settings = Settings { mode: crate::season::Mode::Paper, step, coherence: 0.0, ..own.settings.clone() };
        let error = leaves(&settings, &own.weather, 1, 1).step_error(own.day).unwrap_or(f64::NAN);
        let steps = (own.day / step).floor().max(0.0);
        let mut row = vec![own.name.as_str().into(), own.day.into(), "paper".into(), (steps as u64).into()];
        row.extend([Field::Number(None), error.into()]);
        table.push(row);
        stepped.push([steps, error]);
        desk.tell(&format!("chain {}, steps of {step} d: total variation {}", own.name, shown(error)));
    }
    for power in 2..=5u32 {
        let count = 10u32.pow(power);
        let mut leaves = leaves(&own.settings, &own.weather, 1, u64::from(count));
        let (sample, law) = (leaves.at(own.day), leaves.laws(&[own.day])[0].expected.clone());
        let share = |state: usize| sample.states.iter().filter(|&&s| usize::from(s) == state).count();
        let found: Vec<f64> = (0..law.len()).map(|state| share(state) as f64 / f64::from(count)).collect();
        push(table, [&own.name, "sampled"], own.day, [0, count], &found, &law);
        sampled.push([f64::from(count), total_variation(&found, &law)]);
    }
    vec![Curve::new("paper's steps", stepped), Curve::new("leaves sampled", sampled)]
}
