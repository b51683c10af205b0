//! How long petioles are along a shoot: lower leaves hold their blades out past those above, so that a shoot's blades lie
//! side by side and not on one another (leaf mosaic; Kerner von Marilaun, "The Natural History of Plants", 1895).

use super::skeleton::Skeleton;

/// How much longer than the mean the lowest petiole of a year's shoot is, and how much shorter the highest.
const REACH: f64 = 0.32;

/// For the end of each segment the length of a petiole there over the species' mean: from the place among the segments that
/// grew in the same year on the same axis.
pub(super) fn lengths(skeleton: &Skeleton) -> Vec<f64> {
    let segments = &skeleton.segments;
    let lower = |number: usize| {
        let segment = &segments[number];
        let parent = segment.parent.map(|parent| parent as usize);
        parent.filter(|&parent| segments[parent].axis == segment.axis && segments[parent].birth == segment.birth)
    };
    let mut below = vec![0.0f64; segments.len()];
    for number in 0..segments.len() {
        below[number] = lower(number).map_or(0.0, |parent| below[parent] + 1.0);
    }
    let mut above = vec![0.0f64; segments.len()];
    for number in (0..segments.len()).rev() {
        if let Some(parent) = lower(number) {
            above[parent] = above[number] + 1.0;
        }
    }
    below.iter().zip(above).map(|(below, above)| 1.0 + REACH * (above - below) / (above + below).max(1.0)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{Settings, grow};
    use super::*;
    use crate::base::limits::Limits;

    #[test]
    fn petioles_shorten_along_each_years_shoot() {
        let rules = vec!["A -> F(0.1)[+F(0.02)]F(0.1)F(0.1)A".to_owned()];
        let settings = Settings { axiom: "A".to_owned(), rules, iterations: 2, ..Settings::default() };
        let skeleton = grow(&settings, 1, &Limits::default()).unwrap().0.skeleton;
        let lengths = lengths(&skeleton);
        // Each year: the lowest internode, its side shoot of one segment, the middle, the highest.
        let year = [1.0 + REACH, 1.0, 1.0, 1.0 - REACH];
        assert_eq!(lengths, [year, year].concat());
    }
}
