//! Ticks at even numbers, as many as there is room for.

use super::Scale;
use super::dates;
use super::mapping::{Mapping, log10};
use crate::base::maths::pow;

/// A labelled tick.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    /// Where, in the axis' unit.
    pub(super) value: f64,
    /// Where the label stands: there too, or in the middle of a month that begins there.
    pub(super) label_at: f64,
    /// May be empty.
    pub(super) label: String,
}

impl Tick {
    pub(super) fn new(value: f64, label: String) -> Self {
        Self { value, label_at: value, label }
    }
}

/// All ticks of an axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Ticks {
    pub(super) major: Vec<Tick>,
    pub(super) minor: Vec<f64>,
}

/// The room that an axis gives to its labels.
pub(super) struct Room<'a> {
    /// Of the axis, in pixels.
    pub(super) length: f64,
    /// Of a label along the axis, in pixels.
    pub(super) extent: &'a dyn Fn(&str) -> f64,
    /// Between two labels, in pixels.
    pub(super) gap: f64,
    /// The most steps that even numbers are made for.
    pub(super) most: u32,
}

/// The densest ticks whose labels stay apart; of the sparsest, when none do, those that stay apart from the first on.
pub(super) fn choose(axis: &Mapping, room: &Room) -> Ticks {
    let mut sparsest = Ticks::default();
    for candidate in candidates(axis, room) {
        if candidate.major.is_empty() {
            continue;
        }
        if apart(&candidate, axis, room).iter().all(|&is_apart| is_apart) {
            return candidate;
        }
        sparsest = candidate;
    }
    let kept = apart(&sparsest, axis, room);
    let mut kept = kept.iter();
    sparsest.major.retain(|_| kept.next().copied().unwrap_or(false));
    sparsest
}

/// Of each label, whether it stays apart from the last one before it that does.
fn apart(ticks: &Ticks, axis: &Mapping, room: &Room) -> Vec<bool> {
    let mut free = f64::NEG_INFINITY;
    let mut is_apart = |tick: &Tick| {
        let Some(share) = axis.share(tick.label_at) else { return false };
        if tick.label.is_empty() {
            return true;
        }
        let half = (room.extent)(&tick.label) / 2.0;
        let fits = share * room.length - half >= free;
        if fits {
            free = share * room.length + half + room.gap;
        }
        fits
    };
    ticks.major.iter().map(&mut is_apart).collect()
}

/// From the densest to the sparsest.
fn candidates(axis: &Mapping, room: &Room) -> Vec<Ticks> {
    match axis.scale {
        Scale::Linear => linear(axis.range, room.most),
        Scale::Log => logarithmic(axis.range, room),
        Scale::Dates { origin } => {
            let shares = |days: f64| days / (axis.range[1] - axis.range[0]) * room.length;
            let fits = |label: &str, days: f64| (room.extent)(label) <= shares(days);
            let found = dates::candidates(origin, axis.range, &fits);
            if found.iter().all(|ticks| ticks.major.is_empty()) { linear(axis.range, room.most) } else { found }
        }
    }
}

/// `mantissa` 10^`exponent`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Step {
    pub(super) mantissa: i64,
    pub(super) exponent: i32,
}

impl Step {
    pub(super) fn value(self) -> f64 {
        decimal(self.mantissa, self.exponent)
    }
}

/// The least of 1, 2 and 5 times a power of ten that is not below `raw` (above 0).
pub(super) fn nice_step(raw: f64) -> Step {
    let below = log10(raw).floor() as i32 - 1;
    for exponent in below..=below + 2 {
        for mantissa in [1, 2, 5] {
            if decimal(mantissa, exponent) >= raw * (1.0 - 1.0e-9) {
                return Step { mantissa, exponent };
            }
        }
    }
    Step { mantissa: 1, exponent: below + 3 }
}

/// `mantissa` 10^`exponent`, rounded once where the power is exact.
fn decimal(mantissa: i64, exponent: i32) -> f64 {
    let power = pow(10.0, f64::from(exponent.abs()));
    if exponent < 0 { mantissa as f64 / power } else { mantissa as f64 * power }
}

fn linear(range: [f64; 2], most: u32) -> Vec<Ticks> {
    let counts = [10, 8, 6, 5, 4, 3, 2, 1].into_iter().filter(|&count| count <= most.max(1));
    let mut steps: Vec<Step> = counts.map(|count| nice_step((range[1] - range[0]) / f64::from(count))).collect();
    steps.dedup();
    steps.into_iter().map(|step| Ticks { major: multiples(step, range), minor: vec![] }).collect()
}

fn multiples(step: Step, [low, high]: [f64; 2]) -> Vec<Tick> {
    let first = (low / step.value() - 1.0e-9).ceil() as i64;
    let last = (high / step.value() + 1.0e-9).floor() as i64;
    let largest = low.abs().max(high.abs());
    let is_short = largest < 1.0e6 && step.exponent >= -6 && largest >= 1.0e-3;
    let tick = |count: i64| {
        let mantissa = count * step.mantissa;
        let label = if is_short { plain(mantissa, step.exponent) } else { scientific(mantissa, step.exponent) };
        Tick::new(decimal(mantissa, step.exponent), label)
    };
    (first..=last).map(tick).collect()
}

/// `mantissa` 10^`exponent` with as many decimals as the exponent says.
pub(super) fn plain(mantissa: i64, exponent: i32) -> String {
    let sign = if mantissa < 0 { "\u{2212}" } else { "" };
    let decimals = usize::try_from(-exponent).unwrap_or(0);
    let zeros = if mantissa == 0 { 0 } else { usize::try_from(exponent).unwrap_or(0) };
    let digits = format!("{:0>least$}{}", mantissa.unsigned_abs(), "0".repeat(zeros), least = decimals + 1);
    let (whole, part) = digits.split_at(digits.len() - decimals);
    let point = if decimals > 0 { "." } else { "" };
    format!("{sign}{whole}{point}{part}")
}

/// `2.5×10^7`, `10^−3`, `0`.
fn scientific(mut mantissa: i64, mut exponent: i32) -> String {
    if mantissa == 0 {
        return "0".to_owned();
    }
    while mantissa % 10 == 0 {
        mantissa /= 10;
        exponent += 1;
    }
    let decimals = mantissa.unsigned_abs().to_string().len() as i32 - 1;
    let power = power_of_ten(exponent + decimals);
    match mantissa {
        1 => power,
        -1 => format!("\u{2212}{power}"),
        _ => format!("{}×{power}", plain(mantissa, -decimals)),
    }
}

fn power_of_ten(exponent: i32) -> String {
    format!("10^{}", plain(i64::from(exponent), 0))
}

/// Every decade, or every second, third...; within fewer than two decades also their parts.
fn logarithmic(range: [f64; 2], room: &Room) -> Vec<Ticks> {
    let [low, high] = range.map(log10);
    let (first, last) = ((low - 1.0e-9).ceil() as i32, (high + 1.0e-9).floor() as i32);
    if last - first < 1 {
        return parts_of_decades(range, first - 1, last, room.most);
    }
    let is_plain = first >= -3 && last <= 4;
    let label = |k: i32| if is_plain { plain(1.max(decimal(1, k) as i64), k.min(0)) } else { power_of_ten(k) };
    let minor_of_one = if room.length / (high - low) >= 40.0 { parts(range, first - 1, last, 2..=9) } else { vec![] };
    let with_step = |&step: &i32| {
        let is_major = |k: &i32| k.rem_euclid(step) == 0;
        let major = (first..=last).filter(is_major).map(|k| Tick::new(decimal(1, k), label(k))).collect();
        let between = || (first..=last).filter(|k| !is_major(k)).map(|k| decimal(1, k)).collect();
        Ticks { major, minor: if step == 1 { minor_of_one.clone() } else { between() } }
    };
    [1, 2, 3, 5, 10, 20, 50, 100, 200].iter().map(with_step).collect()
}

fn parts_of_decades(range: [f64; 2], first: i32, last: i32, most: u32) -> Vec<Ticks> {
    let minor = parts(range, first, last, 2..=9);
    let ticks = |mantissas: &[i64]| {
        let all = (first..=last).flat_map(|k| mantissas.iter().map(move |&m| (m, k)));
        let inside = all.filter(|&(m, k)| is_inside(decimal(m, k), range));
        let label = |m, k| if (-3..=4).contains(&k) { plain(m, k) } else { scientific(m, k) };
        Ticks { major: inside.map(|(m, k)| Tick::new(decimal(m, k), label(m, k))).collect(), minor: minor.clone() }
    };
    let mut found: Vec<Ticks> = [&[1, 2, 3, 5, 7][..], &[1, 2, 5], &[1, 3], &[1]].map(ticks).into();
    // Between two such numbers the logarithm is nearly straight.
    if found[0].major.len() < 3 {
        found.splice(0..0, linear(range, most));
    }
    found
}

fn parts(range: [f64; 2], first: i32, last: i32, mantissas: std::ops::RangeInclusive<i64>) -> Vec<f64> {
    let all = (first..=last).flat_map(|k| mantissas.clone().map(move |m| decimal(m, k)));
    all.filter(|&value| is_inside(value, range)).collect()
}

fn is_inside(value: f64, [low, high]: [f64; 2]) -> bool {
    value >= low * (1.0 - 1.0e-9) && value <= high * (1.0 + 1.0e-9)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(scale: Scale, range: [f64; 2], length: f64) -> Vec<String> {
        let room = Room { length, extent: &|label| 8.0 * label.chars().count() as f64, gap: 10.0, most: 10 };
        choose(&Mapping { scale, range }, &room).major.into_iter().map(|tick| tick.label).collect()
    }

    #[test]
    fn linear_ticks_are_even_numbers() {
        assert_eq!(labels(Scale::Linear, [0.0, 1.0], 150.0), ["0.0", "0.5", "1.0"]);
        assert_eq!(labels(Scale::Linear, [-7.0, 12.0], 200.0), ["\u{2212}5", "0", "5", "10"]);
        assert_eq!(labels(Scale::Linear, [0.0, 3.0e7], 300.0), ["0", "10^7", "2×10^7", "3×10^7"]);
        assert_eq!(labels(Scale::Linear, [0.0, 0.0005], 210.0), ["0", "2×10^\u{2212}4", "4×10^\u{2212}4"]);
        assert_eq!(labels(Scale::Linear, [995.0, 1005.0], 150.0), ["995", "1000", "1005"]);
    }

    #[test]
    fn logarithmic_ticks_are_decades() {
        assert_eq!(labels(Scale::Log, [1.0, 1000.0], 400.0), ["1", "10", "100", "1000"]);
        assert_eq!(labels(Scale::Log, [0.008, 20.0], 400.0), ["0.01", "0.1", "1", "10"]);
        let far = labels(Scale::Log, [1.0e-12, 1.0], 300.0);
        assert_eq!(far, ["10^\u{2212}12", "10^\u{2212}9", "10^\u{2212}6", "10^\u{2212}3", "10^0"]);
        assert_eq!(labels(Scale::Log, [1.5, 8.0], 400.0), ["2", "3", "5", "7"]);
        assert_eq!(labels(Scale::Log, [10.1, 10.3], 300.0), ["10.10", "10.15", "10.20", "10.25", "10.30"]);
    }

    #[test]
    fn decades_have_eight_parts() {
        let room = Room { length: 500.0, extent: &|_| 20.0, gap: 10.0, most: 10 };
        let ticks = choose(&Mapping { scale: Scale::Log, range: [1.0, 100.0] }, &room);
        assert_eq!((ticks.major.len(), ticks.minor.len()), (3, 16));
    }

    #[test]
    fn steps_are_1_2_or_5_and_the_least_that_reach() {
        for exponent in -290..290 {
            for raw in [1.0, 1.5, 2.0, 3.0, 5.0, 7.0].map(|mantissa| mantissa * pow(10.0, f64::from(exponent))) {
                let step = nice_step(raw);
                assert!([1, 2, 5].contains(&step.mantissa));
                assert!(step.value() >= raw * 0.999_999 && step.value() <= 2.5 * raw, "{raw}");
            }
        }
    }

    #[test]
    fn labels_stay_apart_at_every_length() {
        for length in 1..300 {
            for scale in [Scale::Linear, Scale::Log] {
                let axis = Mapping { scale, range: [1.0e-3, 1.0e4] };
                let room =
                    Room { length: f64::from(length), extent: &|label| 8.0 * label.len() as f64, gap: 10.0, most: 10 };
                let ends = choose(&axis, &room).major.into_iter().map(|tick| {
                    let middle = axis.share(tick.label_at).unwrap() * room.length;
                    [middle - 4.0 * tick.label.len() as f64, middle + 4.0 * tick.label.len() as f64]
                });
                let ends: Vec<[f64; 2]> = ends.collect();
                assert!(!ends.is_empty());
                assert!(ends.windows(2).all(|pair| pair[1][0] - pair[0][1] > 9.999), "{scale:?} {length}");
            }
        }
    }
}
