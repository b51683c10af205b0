//! Charts of error against work on two logarithmic axes.

use crate::plot::{Along, Axis, Band, Guide, Mark, Panel, Plot, Scale, Series, Style};

/// The points of one method.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// The method.
    pub name: String,
    /// Work and error of each setting.
    pub points: Vec<[f64; 2]>,
    /// Work of settings that diverged.
    pub diverged: Vec<f64>,
}

impl Curve {
    /// A curve without diverged settings.
    #[must_use]
    pub fn new(name: impl Into<String>, points: Vec<[f64; 2]>) -> Self {
        Self { name: name.into(), points, diverged: Vec::new() }
    }
}

/// What stands around the curves.
#[derive(Clone, Debug, Default)]
pub struct Frame<'a> {
    /// The title.
    pub title: &'a str,
    /// The lower axis: quantity and unit.
    pub x: [&'a str; 2],
    /// The left axis: quantity and unit.
    pub y: [&'a str; 2],
    /// Slopes to compare with.
    pub orders: &'a [f64],
    /// The reference's own error: what lies below it says nothing.
    pub floor: Option<f64>,
    /// Methods that are not in the chart, each with its reason.
    pub left_out: &'a [&'a str],
}

/// The chart.
#[must_use]
pub fn chart(frame: &Frame<'_>, curves: &[Curve]) -> Plot {
    let axis = |[label, unit]: [&str; 2]| Axis {
        label: label.to_owned(),
        unit: unit.to_owned(),
        scale: Scale::Log,
        range: None,
    };
    let series = |(number, curve): (usize, &Curve)| {
        let style = Style::Marked(Mark::ALL[number % Mark::ALL.len()]);
        let mut points = curve.points.clone();
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let mut series = Series::new(curve.name.clone(), style, points);
        series.diverged = curve.diverged.clone();
        series
    };
    // Guides go through the upper left of what is drawn, where curves begin.
    let all = || curves.iter().flat_map(|curve| &curve.points).filter(|point| point.iter().all(|v| *v > 0.0));
    let left = all().map(|point| point[0]).fold(f64::INFINITY, f64::min);
    let top = all().map(|point| point[1]).fold(0.0, f64::max);
    let guide = |&order: &f64| Guide::Slope { order, through: [left, top], label: String::new() };
    let has_points = left.is_finite() && top > 0.0;
    let floor = frame.floor.filter(|floor| *floor > 0.0);
    let band = floor.map(|to| Band { along: Along::Y, from: 0.0, to, label: "error of the reference".to_owned() });
    let panel = Panel {
        x: axis(frame.x),
        y: axis(frame.y),
        series: curves.iter().enumerate().map(series).collect(),
        guides: if has_points { frame.orders.iter().map(guide).collect() } else { Vec::new() },
        bands: band.into_iter().collect(),
        ..Panel::default()
    };
    let notes = frame.left_out.iter().map(|line| format!("left out: {line}")).collect();
    Plot { title: frame.title.to_owned(), panels: vec![panel], notes, ..Plot::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chart_has_its_curves_guides_floor_crosses_and_what_is_left_out() {
        let mut curve = Curve::new("ours", vec![[10.0, 0.1], [100.0, 0.01]]);
        curve.diverged.push(50.0);
        let frame = Frame {
            title: "t",
            orders: &[-1.0],
            floor: Some(1e-3),
            left_out: &["another, which diverged"],
            ..Frame::default()
        };
        let plot = chart(&frame, &[curve]);
        let panel = &plot.panels[0];
        assert_eq!((panel.guides.len(), panel.bands.len(), panel.series[0].diverged.len()), (1, 1, 1));
        assert_eq!(plot.notes, ["left out: another, which diverged"]);
        assert_eq!(panel.guides[0], Guide::Slope { order: -1.0, through: [10.0, 0.1], label: String::new() });
        assert!(chart(&frame, &[]).panels[0].guides.is_empty());
    }
}
