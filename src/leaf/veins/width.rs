//! Widths of veins measured in a scan: where the mean tone across a stretch of vein has fallen half way to the blade's.

use super::ridge::Polarity;
use crate::base::vector::DVec2;
use crate::leaf::grid::Grid;

/// Half the length of the profiles across a vein, and where the blade's own tone begins in them, shares of the size.
const SPAN: f64 = 0.024;
const BESIDE: f64 = 0.016;
/// Half the width in which the vein's tone is sought, share of the size.
const CENTRE: f64 = 0.003;

/// Width of a line (cells) at its thick and at its thin end; `None` where no vein stands out. `size` in cells.
pub fn widths(tone: &Grid<f32>, line: &[DVec2], polarity: Polarity, size: f64) -> [Option<f64>; 2] {
    let third = (line.len() / 3).max(2).min(line.len());
    let stretches = [&line[..third], &line[line.len() - third..]];
    stretches.map(|stretch| width(&profile(tone, stretch, polarity, size), size))
}

/// Mean tone at every half cell from one side of the line to the other, veins upwards.
fn profile(tone: &Grid<f32>, line: &[DVec2], polarity: Polarity, size: f64) -> Vec<f64> {
    let reach = (SPAN * size * 2.0).ceil() as i64;
    let sign = if polarity == Polarity::Bright { 1.0 } else { -1.0 };
    let mut sums = vec![0.0; (2 * reach + 1) as usize];
    for ends in line.windows(2) {
        let along = (ends[1] - ends[0]).try_normalize(0.0).unwrap_or_default();
        let (middle, across) = ((ends[0] + ends[1]) * 0.5, DVec2::new(-along.y, along.x));
        for (sum, offset) in sums.iter_mut().zip(-reach..) {
            *sum += sign * f64::from(bilinear(tone, middle + across * (offset as f64 * 0.5)));
        }
    }
    sums.iter().map(|sum| sum / (line.len() - 1).max(1) as f64).collect()
}

/// Full width at half height, cells.
fn width(profile: &[f64], size: f64) -> Option<f64> {
    let middle = profile.len() / 2;
    let beside: Vec<f64> =
        (0..profile.len()).filter(|&i| i.abs_diff(middle) as f64 * 0.5 > BESIDE * size).map(|i| profile[i]).collect();
    let ground = beside.iter().sum::<f64>() / beside.len().max(1) as f64;
    let near = (CENTRE * size * 2.0).ceil() as usize;
    let centre = middle.saturating_sub(near)..=(middle + near).min(profile.len() - 1);
    let top = centre.max_by(|&a, &b| profile[a].total_cmp(&profile[b])).filter(|&top| profile[top] > ground)?;
    let half = 0.5 * (profile[top] + ground);
    let fall = |values: &mut dyn Iterator<Item = f64>| {
        let mut last = profile[top];
        let mut steps = 0.0;
        for value in values {
            if value <= half {
                return steps + (last - half) / (last - value);
            }
            (steps, last) = (steps + 1.0, value);
        }
        steps
    };
    let right = fall(&mut profile[top + 1..].iter().copied());
    let left = fall(&mut profile[..top].iter().rev().copied());
    Some(0.5 * (left + right))
}

/// The value at a place in cells (middle of the first at 0.5), the rim continued.
fn bilinear(grid: &Grid<f32>, place: DVec2) -> f32 {
    let clamp = |x: f64, count: usize| (x - 0.5).clamp(0.0, count.saturating_sub(1) as f64);
    let (x, y) = (clamp(place.x, grid.width), clamp(place.y, grid.height));
    let (left, top) = (x.floor() as usize, y.floor() as usize);
    let (right, below) = ((left + 1).min(grid.width - 1), (top + 1).min(grid.height - 1));
    let (s, t) = ((x - x.floor()) as f32, (y - y.floor()) as f32);
    let row = |y: usize| grid.at(left, y) * (1.0 - s) + grid.at(right, y) * s;
    row(top) * (1.0 - t) + row(below) * t
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bar of a width along x in the middle of 200 x 100 cells, of tone 10 on 50 or the other way round.
    fn bar(width: f64, polarity: Polarity) -> Grid<f32> {
        let sign = if polarity == Polarity::Bright { 10.0 } else { -10.0 };
        let tone = |i: usize| {
            let off = ((i / 200) as f64 + 0.5 - 50.0).abs();
            50.0 + sign * (0.5 * width + 0.5 - off).clamp(0.0, 1.0) as f32
        };
        Grid { width: 200, height: 100, cells: (0..20_000).map(tone).collect() }
    }

    #[test]
    fn the_width_of_a_bar_is_measured() {
        let line: Vec<DVec2> = (0..20).map(|i| DVec2::new(20.0 + 8.0 * f64::from(i), 50.0)).collect();
        for polarity in [Polarity::Bright, Polarity::Dark] {
            for wide in [4.0, 7.0] {
                for found in widths(&bar(wide, polarity), &line, polarity, 500.0) {
                    assert!((found.unwrap() - wide).abs() < 0.3, "{found:?} for {wide}");
                }
            }
        }
    }

    #[test]
    fn an_even_tone_has_no_width() {
        let plain = Grid { width: 50, height: 50, cells: vec![7.0f32; 2500] };
        let line = [DVec2::new(5.0, 25.0), DVec2::new(45.0, 25.0)];
        assert_eq!(widths(&plain, &line, Polarity::Bright, 100.0), [None, None]);
        assert_eq!(widths(&plain, &line[..1], Polarity::Bright, 100.0), [None, None]);
    }
}
