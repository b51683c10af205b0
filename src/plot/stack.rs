//! Areas on top of one another.

use super::mapping::Mapping;
use super::{Panel, Series, Style};

/// The lower and upper edge of each area of a panel, over one row of `x`.
#[derive(Clone, Debug, Default)]
pub(super) struct Stack {
    /// Rising.
    pub(super) at: Vec<f64>,
    /// The edges from the lowest, one more than areas, each as long as `at`.
    pub(super) edges: Vec<Vec<f64>>,
}

impl Stack {
    /// Stacks the areas of a panel in their order. `x` is its lower axis.
    pub(super) fn new(panel: &Panel, x: &Mapping) -> Self {
        let areas: Vec<Vec<[f64; 2]>> =
            panel.series.iter().filter(|s| s.style == Style::Area).map(|s| rising(s, x)).collect();
        let mut at: Vec<f64> = areas.iter().flatten().map(|point| point[0]).collect();
        at.sort_by(f64::total_cmp);
        at.dedup();
        let mut edges = vec![vec![0.0; at.len()]];
        for area in &areas {
            let heights = heights(area, &at);
            let top = edges[edges.len() - 1].iter().zip(&heights).map(|(below, height)| below + height).collect();
            edges.push(top);
        }
        Self { at, edges }
    }
}

/// The points that can be drawn, by rising `x`.
fn rising(series: &Series, x: &Mapping) -> Vec<[f64; 2]> {
    let mut points = series.points.clone();
    points.retain(|point| x.scaled(point[0]).is_finite() && point[1].is_finite());
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    points
}

/// The heights of an area at the places `at`, which rise and hold all of its own.
fn heights(area: &[[f64; 2]], at: &[f64]) -> Vec<f64> {
    let mut next = 0;
    let mut height = |&x: &f64| {
        while next < area.len() && area[next][0] < x {
            next += 1;
        }
        match (next.checked_sub(1).map(|before| area[before]), area.get(next)) {
            (_, Some(&[there, height])) if there == x => height,
            (Some(a), Some(&b)) => a[1] + (b[1] - a[1]) * ((x - a[0]) / (b[0] - a[0])),
            _ => 0.0,
        }
    };
    at.iter().map(&mut height).collect()
}

#[cfg(test)]
mod tests {
    use super::super::Scale;
    use super::*;

    #[test]
    fn areas_are_added_over_all_places() {
        let area = |points: &[[f64; 2]]| Series::new("", Style::Area, points.to_vec());
        let series = vec![
            area(&[[4.0, 4.0], [0.0, 0.0], [2.0, f64::NAN]]),
            Series::new("", Style::Line, vec![[9.0, 9.0]]),
            area(&[[1.0, 10.0], [3.0, 10.0]]),
        ];
        let panel = Panel { series, ..Panel::default() };
        let stack = Stack::new(&panel, &Mapping { scale: Scale::Linear, range: [0.0, 4.0] });
        assert_eq!(stack.at, [0.0, 1.0, 3.0, 4.0]);
        assert_eq!(stack.edges, [vec![0.0; 4], vec![0.0, 1.0, 3.0, 4.0], vec![0.0, 11.0, 13.0, 4.0]]);
    }
}
