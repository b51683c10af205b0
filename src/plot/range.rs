//! The ends of an axis that names none: what the data need.

use super::mapping::log10;
use super::ticks::nice_step;
use super::{Along, Axis, Band, Guide, Panel, Scale};
use crate::base::maths::pow;

/// Values beyond are drawn at this distance: their differences are still numbers.
const LARGEST: f64 = 1.0e300;
/// Values below are 0, on a logarithmic axis the least that is drawn.
const SMALLEST: f64 = 1.0e-290;
/// A spread below this part of the values is noise of their rounding: they count as constant.
const NOISE: f64 = 1.0e-12;

/// The ends of the `x` axis that these panels share: as asked, or those of their data.
pub(super) fn shared(panels: &[Panel]) -> [f64; 2] {
    let Some(axis) = panels.first().map(|panel| &panel.x) else { return [0.0, 1.0] };
    asked(axis).unwrap_or_else(|| {
        let found = spread(panels.iter().flat_map(|panel| needed(panel, Along::X)), axis.scale);
        if axis.scale == Scale::Log { padded_decades(found) } else { found }
    })
}

/// The ends of a panel's `y` axis: as asked, or those of its data (and `stacked`, the tops of its stack), moved out to
/// even numbers.
pub(super) fn upright(panel: &Panel, stacked: &[f64]) -> [f64; 2] {
    asked(&panel.y).unwrap_or_else(|| {
        let values = needed(panel, Along::Y).chain(stacked.iter().copied());
        let found = spread(values, panel.y.scale);
        if panel.y.scale == Scale::Log { padded_decades(found) } else { rounded_out(found) }
    })
}

fn asked(axis: &Axis) -> Option<[f64; 2]> {
    let [one, other] = axis.range?;
    let ends = [one.min(other), one.max(other)].map(|end| end.clamp(-LARGEST, LARGEST));
    let is_shown = |end: &f64| end.is_finite() && (axis.scale != Scale::Log || *end >= SMALLEST);
    (one.is_finite() && other.is_finite() && ends.iter().all(is_shown) && !is_constant(ends)).then_some(ends)
}

fn is_constant([low, high]: [f64; 2]) -> bool {
    high - low <= NOISE * low.abs().max(high.abs()) || high - low < SMALLEST
}

/// All values that should be seen along one axis.
fn needed(panel: &Panel, along: Along) -> impl Iterator<Item = f64> {
    let of = move |point: &[f64; 2]| if along == Along::X { point[0] } else { point[1] };
    // Areas have their heights counted in the stack.
    let is_counted = move |style| along == Along::X || style != super::Style::Area;
    let series = panel.series.iter().filter(move |series| is_counted(series.style));
    let points = series.clone().flat_map(move |series| series.points.iter().map(of));
    let diverged = series.flat_map(|series| series.diverged.iter().copied()).filter(move |_| along == Along::X);
    let guides = panel.guides.iter().filter_map(move |guide| match *guide {
        Guide::Level { y, .. } if along == Along::Y => Some(y),
        Guide::Upright { x, .. } if along == Along::X => Some(x),
        _ => None,
    });
    let bands = panel.bands.iter().filter(move |band| band.along == along).flat_map(|band: &Band| [band.from, band.to]);
    points.chain(diverged).chain(guides).chain(bands)
}

/// The least and the greatest value that the scale shows, apart from each other; 0 and 1 without any.
fn spread(values: impl Iterator<Item = f64>, scale: Scale) -> [f64; 2] {
    let is_log = scale == Scale::Log;
    let shown = values.filter(|value| value.is_finite() && (!is_log || *value >= SMALLEST));
    let [low, high] = shown.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
        let value = value.clamp(-LARGEST, LARGEST);
        [low.min(value), high.max(value)]
    });
    match (low > high, is_log) {
        (true, true) => [1.0, 10.0],
        (true, false) => [0.0, 1.0],
        (false, false) if is_constant([low, high]) => around(low),
        (false, _) => [low, high],
    }
}

fn around(value: f64) -> [f64; 2] {
    let reach = value.abs() / 2.0;
    if reach < SMALLEST { [0.0, 1.0] } else { [value - reach, value + reach] }
}

fn rounded_out([low, high]: [f64; 2]) -> [f64; 2] {
    let step = nice_step((high - low) / 5.0).value();
    [(low / step + 1.0e-9).floor() * step, (high / step - 1.0e-9).ceil() * step]
}

/// A tenth of a decade to spare at both ends, and at least one decade in all.
fn padded_decades([low, high]: [f64; 2]) -> [f64; 2] {
    let [low, high] = [log10(low) - 0.1, log10(high) + 0.1];
    let lacking = ((1.0 - (high - low)) / 2.0).max(0.0);
    [pow(10.0, low - lacking), pow(10.0, high + lacking)]
}

#[cfg(test)]
mod tests {
    use super::super::{Series, Style};
    use super::*;

    fn of(values: &[f64], scale: Scale) -> [f64; 2] {
        let points = values.iter().map(|&value| [value, value]).collect();
        let axis = Axis { scale, ..Axis::default() };
        let panel =
            Panel { x: axis.clone(), y: axis, series: vec![Series::new("", Style::Line, points)], ..Panel::default() };
        upright(&panel, &[])
    }

    #[test]
    fn data_get_even_ends() {
        assert_eq!(of(&[0.3, 9.7], Scale::Linear), [0.0, 10.0]);
        assert_eq!(of(&[0.0, 10.0], Scale::Linear), [0.0, 10.0]);
        assert_eq!(of(&[-3.2, 27.0], Scale::Linear), [-10.0, 30.0]);
        assert_eq!(of(&[4.0, 4.0], Scale::Linear), [2.0, 6.0]);
    }

    #[test]
    fn nothing_and_the_unshowable_give_a_range_all_the_same() {
        assert_eq!(of(&[], Scale::Linear), [0.0, 1.0]);
        assert_eq!(of(&[f64::NAN, f64::INFINITY], Scale::Linear), [0.0, 1.0]);
        let decades = of(&[-1.0, 0.0], Scale::Log);
        assert!(0.5 < decades[0] && decades[1] < 20.0);
        for values in [[-f64::MAX, f64::MAX], [f64::MIN_POSITIVE, 5e-324], [1e15, 1e15 + 0.125], [0.0, -0.0]] {
            for scale in [Scale::Linear, Scale::Log] {
                let [low, high] = of(&values, scale);
                assert!(low.is_finite() && high.is_finite() && low < high, "{values:?} {scale:?}");
            }
        }
    }

    #[test]
    fn a_range_that_is_asked_for_is_kept_and_nonsense_is_not() {
        let axis = |range, scale| Axis { range: Some(range), scale, ..Axis::default() };
        assert_eq!(asked(&axis([5.0, 1.0], Scale::Linear)), Some([1.0, 5.0]));
        assert_eq!(asked(&axis([0.0, 1.0], Scale::Log)), None);
        assert_eq!(asked(&axis([2.0, 2.0], Scale::Linear)), None);
        assert_eq!(asked(&axis([f64::NAN, 2.0], Scale::Linear)), None);
    }
}
