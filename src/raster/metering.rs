//! Exposure measured from the picture itself, as a camera's averaging meter does.

use super::Renderer;
use super::layers::Wanted;
use crate::base::encoding::{self, linear_values};
use crate::base::maths::{expf, lnf};
use crate::frame::{Frame, ToneMap, UNBALANCED};

/// What the mean is brought to: middle grey.
const MIDDLE: f32 = 0.18;
/// Share of the picture's width and height that is measured with.
const SMALLER: u32 = 8;
/// Exposures that are tried, darkest first, so that neither bright nor dark parts leave the range of the codes.
const ROUNDS: usize = 3;

/// The frame with its exposure such that the mean of the logarithm of its picture's luminance is middle grey's; what the
/// frame's exposure was is left out of account.
pub(super) fn metered(frame: &Frame, renderer: &mut Renderer) -> Frame {
    let mut small = frame.clone();
    small.view.metered = false;
    small.view.wireframe = None;
    small.view.tone_map = ToneMap::None;
    small.view.balance = UNBALANCED;
    small.view.samples = 1;
    small.view.width = (frame.view.width / SMALLER).max(frame.view.width.min(32));
    small.view.height = (frame.view.height / SMALLER).max(frame.view.height.min(32));
    for _ in 0..ROUNDS {
        let factor = MIDDLE / mean(&small, renderer);
        small.view.exposure *= factor.clamp(1.0 / 64.0, 64.0);
    }
    let mut metered = frame.clone();
    metered.view.metered = false;
    metered.view.exposure = small.view.exposure;
    metered
}

/// The geometric mean of the luminance of a frame's picture.
fn mean(frame: &Frame, renderer: &mut Renderer) -> f32 {
    let picture = renderer.draw_apart(frame, Wanted::default()).picture;
    let linear = linear_values();
    let luminance = |pixel: &[u8; 4]| encoding::luminance([0, 1, 2].map(|k| linear[usize::from(pixel[k])]));
    // The darkest code but one bounds what black counts for.
    let sum: f32 = picture.pixels.iter().map(|pixel| lnf(luminance(pixel).max(3e-4))).sum();
    expf(sum / picture.pixels.len().max(1) as f32)
}
