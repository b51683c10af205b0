//! Small pictures of a frame, to see what samples and enlargements come to.

use super::super::enlargement;
use super::super::still::Still;
use crate::base::diagnostic::Diagnostics;
use crate::base::maths::{pow, srgb_to_linear};
use crate::base::picture::Picture;
use crate::frame::Frame;
use crate::scene::Scene;
use crate::scene::image::SAMPLES;

/// Pixels of a small picture, and of the smaller one beside it.
const PIXELS: f64 = 24_000.0;
/// How much larger in each direction the picture is drawn that others are held against.
const REFERENCE: u32 = 6;
/// Enlargements that are tried.
const ENLARGED: [u32; 4] = [1, 2, 3, 4];
/// Of the exponent by which the error falls from a smaller picture to a larger one, the share that is counted on, and its most.
const COUNTED_ON: f64 = 0.5;
const STEEPEST: f64 = 0.5;

/// Samples of a pattern in a picture that is drawn larger.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampling {
    /// Samples of the pattern.
    pub samples: u32,
    /// How many times as large in each direction.
    pub enlarged: u32,
}

impl Sampling {
    /// The ways, cheapest first: by the work of their pixels and samples.
    fn all() -> Vec<Self> {
        let mut all: Vec<Self> = ENLARGED
            .iter()
            .flat_map(|&enlarged| SAMPLES.iter().map(move |&samples| Self { samples, enlarged }))
            .collect();
        all.sort_by(|a, b| a.work().total_cmp(&b.work()));
        all
    }

    /// Work in that of a pixel with one sample: a pixel's shading costs as much as some thirty samples.
    fn work(self) -> f64 {
        f64::from(self.enlarged * self.enlarged) * (30.0 + f64::from(self.samples))
    }
}

/// What a frame's small pictures tell.
pub struct Probe {
    /// Error of each way, in the picture's own size.
    errors: Vec<(Sampling, f64)>,
    /// Root mean square change of the picture from a pixel to the next.
    steepness: f64,
    /// Root mean square pixels that a metre covers at the leaves of each species; 0 without leaves.
    pixels_per_metre: Vec<f64>,
}

impl Probe {
    /// Of a moment.
    ///
    /// # Errors
    /// What stops a run of the scene.
    pub fn new(still: &Still, scene: &Scene) -> Result<Self, Diagnostics> {
        let (frame, _) = still.frame()?;
        let share = (PIXELS / scene.image.pixels()).sqrt().min(1.0);
        let large = sized(&frame, share);
        let (errors, steepness) = measured(&large);
        let errors = if share < 1.0 {
            let small = sized(&frame, share * 0.5);
            let (smaller, _) = measured(&small);
            let times = frame.view.width as f64 / f64::from(large.view.width);
            errors.iter().zip(smaller).map(|(&(way, e), (_, s))| (way, grown(e, s, times))).collect()
        } else {
            errors
        };
        let pixels_per_metre = (0..scene.species.len()).map(|number| pixels_per_metre(&frame, still, number)).collect();
        Ok(Self { errors, steepness, pixels_per_metre })
    }

    /// Root mean square change of the picture for each metre that the leaves of a species are off.
    pub fn sensitivity(&self, species: usize) -> f64 {
        self.steepness * self.pixels_per_metre.get(species).copied().unwrap_or(0.0)
    }
}

/// The cheapest way that stays within an error in all frames, and its error; the best when none does.
pub fn cheapest(probes: &[&Probe], room: f64, fits: impl Fn(u32) -> bool) -> (Sampling, f64) {
    let worst = |at: usize| probes.iter().map(|probe| probe.errors[at].1).fold(0.0, f64::max);
    let ways: Vec<(Sampling, f64)> =
        Sampling::all().into_iter().enumerate().map(|(at, way)| (way, worst(at))).collect();
    let ways: Vec<(Sampling, f64)> =
        ways.into_iter().filter(|(way, _)| way.enlarged == 1 || fits(way.enlarged)).collect();
    let good = ways.iter().find(|(_, error)| *error <= room);
    let best = || ways.iter().min_by(|a, b| a.1.total_cmp(&b.1));
    good.or_else(best).copied().unwrap_or((Sampling { samples: SAMPLES[0], enlarged: 1 }, f64::INFINITY))
}

/// The error of a picture `times` as large as one of error `error`, given that of one half as large. It falls by half of what
/// it fell from the one to the other, so that what is foreseen is rather too large.
fn grown(error: f64, smaller: f64, times: f64) -> f64 {
    let exponent = if error > 0.0 && smaller > error { libm::log2(smaller / error).min(STEEPEST) } else { 0.0 };
    error * pow(times, -exponent * COUNTED_ON)
}

/// A frame's picture in another size.
fn sized(frame: &Frame, share: f64) -> Frame {
    let mut small = frame.clone();
    let side = |pixels: u32| ((f64::from(pixels) * share).round() as u32).max(1);
    small.view.width = side(frame.view.width);
    small.view.height = side(frame.view.height);
    small
}

/// The error of every way against a much larger picture, and the picture's steepness.
fn measured(frame: &Frame) -> (Vec<(Sampling, f64)>, f64) {
    let drawn = |way: Sampling| {
        let mut frame = frame.clone();
        frame.view.samples = way.samples;
        linear(&enlargement::drawn(&frame, way.enlarged).0)
    };
    let most = SAMPLES.iter().copied().max().unwrap_or(1).min(16);
    let exact = drawn(Sampling { samples: most, enlarged: REFERENCE });
    let errors = Sampling::all().into_iter().map(|way| (way, distance(&drawn(way), &exact))).collect();
    (errors, steepness(&exact, frame.view.width as usize))
}

fn linear(picture: &Picture) -> Vec<[f32; 3]> {
    let table: [f32; 256] = std::array::from_fn(|code| srgb_to_linear(code as f32 / 255.0));
    picture.pixels.iter().map(|pixel| [0, 1, 2].map(|k| table[usize::from(pixel[k])])).collect()
}

fn distance(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    let square = |(p, q): (&[f32; 3], &[f32; 3])| (0..3).map(|k| f64::from(p[k] - q[k])).map(|d| d * d).sum::<f64>();
    (a.iter().zip(b).map(square).sum::<f64>() / (3.0 * a.len().max(1) as f64)).sqrt()
}

/// Root mean square change along either axis.
fn steepness(pixels: &[[f32; 3]], width: usize) -> f64 {
    let square = |p: &[f32; 3], q: &[f32; 3]| (0..3).map(|k| f64::from(p[k] - q[k])).map(|d| d * d).sum::<f64>() / 3.0;
    let across: f64 = pixels.chunks(width).flat_map(|row| row.windows(2)).map(|pair| square(&pair[0], &pair[1])).sum();
    let down: f64 = pixels.iter().zip(pixels.iter().skip(width)).map(|(p, q)| square(p, q)).sum();
    ((across + down) / (2.0 * pixels.len().max(1) as f64)).sqrt()
}

/// Root mean square pixels that a metre covers at the leaves of a species, counted by what stands in the frame.
fn pixels_per_metre(frame: &Frame, still: &Still, species: usize) -> f64 {
    let camera = &frame.camera;
    let forward = (camera.target - camera.position).normalize();
    let focal = f64::from(frame.view.height) * 0.5 / libm::tan(f64::from(camera.field_of_view) * 0.5);
    let of = still.species_of_leaves();
    let squares = frame.instances.iter().filter_map(|instance| {
        let leaf = instance.leaf?;
        let is_own = of.get(&leaf).is_none_or(|&own| own == species);
        let depth = f64::from((instance.transform.translation - camera.position).dot(&forward));
        let size = f64::from(instance.transform.linear.column(0).norm());
        (is_own && depth > f64::from(camera.near)).then(|| {
            let scale = focal * size / depth;
            scale * scale
        })
    });
    let (sum, count) = squares.fold((0.0, 0u64), |(sum, count), square| (sum + square, count + 1));
    if count > 0 { (sum / count as f64).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cheapest_way_within_the_error_is_taken_and_else_the_best() {
        let ways = Sampling::all();
        assert!(ways.windows(2).all(|pair| pair[0].work() <= pair[1].work()));
        let errors =
            ways.iter().map(|&way| (way, 1.0 / f64::from(way.samples * way.enlarged * way.enlarged))).collect();
        let probe = Probe { errors, steepness: 1.0, pixels_per_metre: vec![2.0] };
        let found = cheapest(&[&probe], 0.13, |_| true).0;
        assert_eq!(found, Sampling { samples: 8, enlarged: 1 });
        assert_eq!(cheapest(&[&probe], 1e-9, |_| false).0, Sampling { samples: 16, enlarged: 1 });
        assert_eq!(cheapest(&[&probe], 1e-9, |_| true).0, Sampling { samples: 16, enlarged: 4 });
        assert_eq!([probe.sensitivity(0), probe.sensitivity(7)], [2.0, 0.0]);
    }

    #[test]
    fn larger_pictures_are_foreseen_with_caution() {
        assert_eq!(grown(0.1, 0.1, 4.0), 0.1);
        let foreseen = grown(0.1, 0.1 * 2f64.sqrt(), 4.0);
        assert!(foreseen > 0.05 && foreseen < 0.1, "{foreseen}");
        assert_eq!(grown(0.1, 0.05, 4.0), 0.1);
    }
}
