//! The operator's limits on what a scene asks for, as far as they can be judged from the scene alone.

use super::Scene;
use crate::base::limits::{Limit, Limits, Refusal};

/// Keys whose number a limit bounds by itself.
const KEYS: [(&str, Limit); 4] = [
    ("image.width", Limit::Pixels),
    ("image.height", Limit::Pixels),
    ("leaf.vertices", Limit::Vertices),
    ("deform.steps", Limit::Steps),
];

/// Judges one number.
///
/// # Errors
/// The limit that refuses it.
pub fn key(limits: &Limits, path: &str, number: f64) -> Result<(), Refusal> {
    match KEYS.iter().find(|(key, _)| *key == path) {
        Some((_, limit)) => limits.allow(*limit, &format!("`{path}`"), number),
        None => Ok(()),
    }
}

/// Judges what several keys ask for together: the refusals with the keys to which they belong.
#[must_use]
pub fn scene(limits: &Limits, scene: &Scene) -> Vec<(&'static str, Refusal)> {
    // the larger side is the one to mend
    let side = if scene.image.width > scene.image.height { "image.width" } else { "image.height" };
    let asked = [
        (side, Limit::Pixels, "the picture", scene.image.pixels()),
        ("time.to", Limit::Frames, "time", scene.time.count()),
    ];
    let refused = asked
        .into_iter()
        .filter_map(|(key, limit, what, wanted)| limits.allow(limit, what, wanted).err().map(|refusal| (key, refusal)));
    refused.collect()
}
