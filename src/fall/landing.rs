//! Where the way down of a leaf meets uneven ground.
//!
//! In the mean wind a leaf comes down along a straight line, whatever it falls through: so far aside a metre. The ground is
//! looked at along that line from the twig on, in steps of the map's squares, to the first place that is above the line, and
//! between this and the place before by halves. Gusts and the leaf's own motions depend a little on how far it falls, so the
//! line is drawn anew through the end of the way that was found, until both agree; where ground is so steep that lines overshoot,
//! by halves between a flight that ends above the ground and one that ends in it.

use super::heights::HeightMap;
use super::{Fallen, Flight, Wind};
use crate::base::vector::DVec2;

/// How far the height of a flight may be off that of the ground where it ends, metres: of no account against its sways.
const CLOSE: f64 = 0.01;
/// Most lines that are drawn.
const MOST_LINES: usize = 24;
/// Most steps along a line, and how often the last of them is halved.
const MOST_STEPS: f64 = 1024.0;
const HALVINGS: usize = 12;

/// Ground of a height map as leaves come down on it.
#[derive(Clone, Copy, Debug)]
pub struct Slopes<'a> {
    map: &'a HeightMap,
    /// The lowest height, metres.
    lowest: f64,
}

impl<'a> Slopes<'a> {
    /// The ground of a map.
    #[must_use]
    pub fn new(map: &'a HeightMap) -> Self {
        Self { map, lowest: map.heights.iter().copied().fold(f64::INFINITY, f64::min) }
    }

    /// The flight of a leaf and how far aside it lands, metres: where its way first meets the ground.
    #[must_use]
    pub fn landing(&self, leaf: &Fallen, seed: u64, wind: &Wind) -> (Flight, DVec2) {
        let below = DVec2::new(leaf.twig.x, leaf.twig.z);
        let flown = |height: f64| {
            let flight = Flight::new(leaf, seed, leaf.twig.y - height);
            (flight, flight.aside(wind, flight.seconds))
        };
        let mut found = flown(leaf.twig.y - self.map.at(below));
        // Flights of no height end above the ground, those to the lowest place in it.
        let (mut low, mut high) = (0.0, (leaf.twig.y - self.lowest).max(0.0));
        for _ in 1..MOST_LINES {
            let (flight, aside) = found;
            let height = self.first(below, leaf.twig.y, aside / flight.height);
            if (height - flight.height).abs() <= CLOSE || high - low <= 0.1 * CLOSE {
                break;
            }
            if height > flight.height {
                low = flight.height.max(low);
            } else {
                high = flight.height.min(high);
            }
            found = flown(if low < height && height < high { height } else { 0.5 * (low + high) });
        }
        found
    }

    /// How far the line from a height over a place falls until it meets the ground, so far `aside` a metre.
    fn first(&self, below: DVec2, top: f64, aside: DVec2) -> f64 {
        let over = |fallen: f64| top - fallen - self.map.at(below + aside * fallen);
        let deepest = top - self.lowest;
        if over(0.0) <= 0.0 || deepest <= 0.0 {
            return 0.0;
        }
        let steps = (aside.norm() * deepest / self.map.step).ceil().clamp(1.0, MOST_STEPS);
        let (mut low, mut high) = (0.0, deepest);
        for number in 1..=steps as u32 {
            high = deepest * f64::from(number) / steps;
            if over(high) <= 0.0 {
                break;
            }
            low = high;
        }
        // within a square the ground is nearly a plane, so the line between both ends is near enough to begin with
        for halving in 0..HALVINGS {
            let (above, under) = (over(low), over(high));
            if high - low <= 0.1 * CLOSE || under >= 0.0 {
                break;
            }
            let share = if halving % 2 == 0 { (above / (above - under)).clamp(0.02, 0.98) } else { 0.5 };
            let middle = low + (high - low) * share;
            if over(middle) > 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        high
    }
}

#[cfg(test)]
mod tests {
    use super::super::Settings;
    use super::super::tests::leaf;
    use super::*;

    /// A wall across the wind with a hollow before it.
    fn wall(height: f64) -> HeightMap {
        let rows: Vec<Vec<f64>> =
            (0..5).map(|_| vec![0.0, 0.0, 0.0, -2.0, -2.0, 0.5 * height, height, height, 0.0]).collect();
        HeightMap::smoothed(&rows, 4.0).expect("heights")
    }

    #[test]
    fn flights_end_on_the_ground_also_where_it_is_higher_than_the_twig() {
        let (settings, map) = (Settings { wind: 2.0, direction: Some(0.0), ..Settings::default() }, wall(30.0));
        let wind = Wind::new(&settings, 3);
        let (mut beyond, mut off, mut through, mut least) = (0, 0, 0, f64::INFINITY);
        for id in 0..2000 {
            let leaf = leaf(id, 8.0);
            let (flight, aside) = Slopes::new(&map).landing(&leaf, 3, &wind);
            let level = Flight::new(&leaf, 3, 0.0);
            beyond += u32::from(map.at(level.aside(&wind, level.seconds)) > leaf.twig.y);
            // the line to its end passes through nothing, and it does not drop from its twig
            let over = |share: f64| leaf.twig.y - share * flight.height - map.at(aside * share);
            through += u32::from((1..19).any(|k| over(f64::from(k) * 0.05) < -0.1));
            least = flight.height.min(least);
            off += u32::from((leaf.twig.y - flight.height - map.at(aside)).abs() > 0.5);
        }
        // gusts that turn a leaf round make a line where its way was a bow
        assert!(beyond > 500 && off < 60 && through < 20 && least > 0.1, "{beyond} {off} {through} {least}");
    }

    #[test]
    fn the_first_of_several_meetings_counts() {
        // A ridge that rises to 3 m between 4 and 8 m from the twig: a line that falls 1 m in 2 is under it at its end.
        let rows: Vec<Vec<f64>> = (0..3).map(|_| vec![0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0]).collect();
        let map = HeightMap::smoothed(&rows, 4.0).expect("heights");
        let slopes = Slopes::new(&map);
        let line = |top: f64, aside: f64| slopes.first(DVec2::new(-6.0, 0.0), top, DVec2::new(aside, 0.0));
        let met = line(4.0, 2.0);
        assert!(met > 1.0 && met < 3.0 && (4.0 - met - map.at(DVec2::new(2.0 * met - 6.0, 0.0))).abs() < 2e-3);
        // what passes over the ridge comes down behind it
        let over = line(12.0, 2.0);
        assert!((over - 12.0 + map.at(DVec2::new(2.0 * over - 6.0, 0.0))).abs() < 2e-3 && over > 8.0);
        assert!(line(-1.0, 0.0) == 0.0 && (line(2.0, 0.0) - 2.0 + map.at(DVec2::new(-6.0, 0.0))).abs() < 2e-3);
    }

    #[test]
    fn over_level_ground_it_is_the_flight_over_that() {
        let map = HeightMap { origin: DVec2::zeros(), step: 1.0, columns: 2, heights: vec![0.7; 4] };
        let wind = Wind::new(&Settings::default(), 3);
        for id in 0..50 {
            let (flight, aside) = Slopes::new(&map).landing(&leaf(id, 5.0), 3, &wind);
            let level = Flight::new(&leaf(id, 5.0), 3, 0.7);
            assert!(flight.seconds == level.seconds && aside == level.aside(&wind, level.seconds));
        }
    }
}
