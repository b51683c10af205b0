//! What the tree stands on.

use crate::base::settings::Complaint;
use crate::fall::HeightMap;
use crate::{choice, settings};
use std::sync::Arc;

choice! {
    /// What covers the ground.
    pub enum Cover {
        /// A meadow, fading into the distance.
        Grass = "grass",
        /// Bare soil.
        Soil = "soil",
        /// Nothing: the tree stands before the sky.
        None = "none",
    }
}

settings! {
    /// The ground.
    pub struct Ground {
        /// What covers it.
        kind: Cover = Cover::Grass;
        /// Whether a wood closes it off in the distance.
        wood: bool = true;
        /// Heights of uneven ground in metres, row by row from the far side to the near as the default camera sees them, each row from
        /// left to right, about the place in the middle. Smooth between them, level at 0 around them. They cast no shadow, and glTF files hold no ground.
        heights: Vec<Vec<f64>> = Vec::new(), unit "m";
        /// Distance between heights.
        step: f64 = 4.0, unit "m", range 0.25 => 100.0;
    }
}

/// Most heights along a side, and how far one may lie from 0, metres.
const MOST: usize = 256;
const HIGHEST: f64 = 100.0;

impl Ground {
    /// The smoothed heights of uneven ground; none of level ground and without any.
    #[must_use]
    pub fn map(&self) -> Option<Arc<HeightMap>> {
        let map = (self.kind != Cover::None).then(|| HeightMap::smoothed(&self.heights, self.step)).flatten();
        map.map(Arc::new)
    }
}

/// What is wrong with a well-typed ground.
#[must_use]
pub fn check(ground: &Ground) -> Vec<Complaint> {
    let rows = &ground.heights;
    let complaint = |what: String, help: &str| vec![Complaint::new("heights", what, help)];
    let width = rows.first().map_or(0, Vec::len);
    if let Some(row) = rows.iter().position(|row| row.len() != width || row.is_empty()) {
        let what = format!("row {} has {} heights, the first has {width}", row + 1, rows[row].len());
        return complaint(what, "give all rows as many heights, at least one");
    }
    if rows.len().max(width) > MOST {
        let what = format!("{} rows of {width} heights are too many", rows.len());
        return complaint(what, "give at most 256 along each side, farther apart (`step`)");
    }
    // A height that is no number is out of range too.
    match rows.iter().flatten().find(|height| !(-HIGHEST..=HIGHEST).contains(*height)) {
        Some(height) => complaint(format!("a height of {height} m"), "give heights of -100 to 100 m"),
        None => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn complaints(heights: Vec<Vec<f64>>) -> Vec<String> {
        check(&Ground { heights, ..Ground::default() }).into_iter().map(|complaint| complaint.message).collect()
    }

    #[test]
    fn heights_are_a_table_of_numbers_in_range() {
        assert!(complaints(vec![vec![0.0, 1.0], vec![2.0, 3.0]]).is_empty() && complaints(Vec::new()).is_empty());
        assert_eq!(complaints(vec![vec![0.0, 1.0], vec![2.0]]), ["row 2 has 1 heights, the first has 2"]);
        assert_eq!(complaints(vec![Vec::new()]), ["row 1 has 0 heights, the first has 0"]);
        assert_eq!(complaints(vec![vec![f64::NAN]]), ["a height of NaN m"]);
        assert_eq!(complaints(vec![vec![0.0; 300]]), ["1 rows of 300 heights are too many"]);
    }

    #[test]
    fn no_ground_has_no_heights() {
        let heights = vec![vec![1.0]];
        assert!(Ground { heights: heights.clone(), ..Ground::default() }.map().is_some());
        assert!(Ground { heights, kind: Cover::None, ..Ground::default() }.map().is_none());
    }
}
