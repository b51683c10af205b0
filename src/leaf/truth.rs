//! What a person traced by hand, and how far a trace is from it.

use crate::base::blade::Blade;
use crate::base::figures::Figures;
use crate::base::picture::Picture;
use crate::base::vector::DVec2;
use crate::leaf::Trace;
use crate::leaf::veins::score::{agreement, distance_correlation};
use serde::Deserialize;

/// How far a vein may lie beside a hand-traced one and still be it, share of the square root of the blade's area.
const VEIN_TOLERANCE: f64 = 0.01;

/// A hand-traced leaf, in pixels of its scan. Lines may cross themselves where lobes overlap: they are filled by the
/// non-zero rule. Other keys of the file are ignored.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct Truth {
    /// The outline of the blade.
    pub blade: Vec<[f64; 2]>,
    /// One closed line round the whole tree of major veins; empty when they were not traced.
    #[serde(default)]
    pub veins: Vec<[f64; 2]>,
    /// Width and height of the scan.
    #[serde(default)]
    pub size: Option<[u32; 2]>,
}

impl Truth {
    /// Whether this can be the truth of a picture.
    ///
    /// # Errors
    /// What is wrong.
    pub fn check(&self, picture: &Picture) -> Result<(), String> {
        let [width, height] = self.size.unwrap_or([picture.width, picture.height]);
        if (width, height) != (picture.width, picture.height) {
            return Err(format!(
                "it was traced on {width} x {height} pixels, the scan has {} x {}",
                picture.width, picture.height
            ));
        }
        if self.blade.len() < 3 {
            return Err("`blade` has fewer than 3 points".to_owned());
        }
        Ok(())
    }

    /// Adds how far a trace and its blade are from this.
    #[must_use]
    pub(in crate::leaf) fn compared(&self, trace: &Trace, blade: &Blade, figures: Figures) -> Figures {
        let figures = figures.with("iou", trace.iou(&self.blade));
        if self.veins.is_empty() {
            return figures;
        }
        let [width, height] = trace.picture_size().map(|size| size as u32);
        let size = (width, height);
        let tolerance = VEIN_TOLERANCE * (trace.area() as f64).sqrt();
        let veins = agreement(&blade.veins, &trace.pose, &self.veins, size, tolerance);
        let outline: Vec<DVec2> = self.blade.iter().map(|&p| DVec2::from(p)).collect();
        let correlation = distance_correlation(&blade.veins, &trace.pose, &self.veins, &outline, size);
        figures
            .with("vein_f1", veins.f1())
            .with("vein_precision", veins.precision)
            .with("vein_recall", veins.recall)
            .with("vein_distance_correlation", correlation)
    }
}
