//! Small pictures of a frame, to see what samples and enlargements come to.

use super::super::enlargement;
use super::super::still::Still;
use crate::base::diagnostic::Diagnostics;
use crate::base::encoding::linear_values;
use crate::base::maths::pow;
use crate::base::picture::Picture;
use crate::frame::Frame;
use crate::raster::{Renderer, Wanted};
use crate::scene::Scene;
use crate::scene::camera::Subject;
use crate::scene::image::SAMPLES;

/// Pixels of a small picture, and of the smaller one beside it.
const PIXELS: f64 = 24_000.0;
/// How much larger in each direction the picture is drawn that others are held against, and another that it is held against.
const REFERENCE: u32 = 8;
const OTHER: u32 = 5;
/// The reference's own error over its distance from the other: both miss by themselves, as the width of their pixels.
const OF_OTHER: f64 = 0.53;
/// Enlargements that are tried.
const ENLARGED: [u32; 4] = [1, 2, 3, 4];
/// Of the exponent by which the error falls from a smaller picture to a larger one, the share that is counted on, and its most.
const COUNTED_ON: f64 = 0.5;
const STEEPEST: f64 = 0.5;

/// Errors in pixels that levels of detail may make, the finest first, and the number of the usual one.
const LOD_ERRORS: [f32; 4] = [0.0, 0.3, 0.6, 1.2];
const USUAL: usize = 1;
/// Work of a picture with the finest levels over that with the usual ones (measured on trees).
const FINEST_WORK: f64 = 1.2;
/// Where more samples leave more than this share of the error, yet more are not tried: what is left is not theirs.
const STALLED: f64 = 0.95;
/// What pictures of leaves are drawn with to tell meshes apart.
const OF_MESHES: Sampling = Sampling { samples: 8, enlarged: 4, lod: 0 };

/// Samples of a pattern in a picture that is drawn larger, and levels of detail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampling {
    /// Samples of the pattern.
    pub samples: u32,
    /// How many times as large in each direction.
    pub enlarged: u32,
    /// Number of the error of levels of detail.
    lod: usize,
}

impl Sampling {
    /// Distance in pixels that a coarser mesh may lie from the full one.
    pub fn lod_error(self) -> f32 {
        LOD_ERRORS[self.lod]
    }

    /// The ways with the usual and finer levels of detail, cheapest first: by the work of their pixels and samples.
    fn all() -> Vec<Self> {
        let with = |lod: usize| {
            ENLARGED
                .iter()
                .flat_map(move |&enlarged| SAMPLES.iter().map(move |&samples| Self { samples, enlarged, lod }))
        };
        let mut all: Vec<Self> = (0..=USUAL).flat_map(with).collect();
        all.sort_by(|a, b| a.work().total_cmp(&b.work()));
        all
    }

    /// Work in that of a pixel with one sample: a pixel's shading costs as much as some thirty samples, for each sixteen of them.
    fn work(self) -> f64 {
        let shadings = f64::from(self.samples.div_ceil(16));
        let levels = if self.lod < USUAL { FINEST_WORK } else { 1.0 };
        levels * f64::from(self.enlarged * self.enlarged) * (30.0 * shadings + f64::from(self.samples))
    }

    /// Whether it differs from another way in samples alone.
    fn is_of_row(self, other: Self) -> bool {
        (self.enlarged, self.lod) == (other.enlarged, other.lod)
    }
}

/// A small picture of a frame, and what it should look like.
struct Small {
    frame: Frame,
    exact: Vec<[f32; 3]>,
    /// How far that is from what it should be.
    own: f64,
}

/// A frame's small pictures: the larger, and where it is smaller than the frame itself one of half its sides.
pub struct Probe {
    pictures: Vec<Small>,
    /// Sides of the first over those of the frame.
    share: f64,
    /// How much larger in each direction the frame is than the first.
    times: f64,
    renderer: Renderer,
    /// What was measured so far.
    known: Vec<(Sampling, f64)>,
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
        let shares = if share < 1.0 { vec![share, 0.5 * share] } else { vec![1.0] };
        let mut renderer = Renderer::default();
        let pictures: Vec<Small> =
            shares.iter().map(|&share| Small::new(&mut renderer, sized(&frame, share))).collect();
        let first = &pictures[0];
        let steepness = steepness(&first.exact, first.frame.view.width as usize);
        let times = f64::from(frame.view.width) / f64::from(first.frame.view.width);
        let pixels_per_metre = (0..scene.species.len()).map(|number| pixels_per_metre(&frame, still, number)).collect();
        Ok(Self { pictures, share, times, renderer, known: Vec::new(), steepness, pixels_per_metre })
    }

    /// Root mean square change of the picture for each metre that the leaves of a species are off.
    pub fn sensitivity(&self, species: usize) -> f64 {
        self.steepness * self.pixels_per_metre.get(species).copied().unwrap_or(0.0)
    }

    /// How far two frames are apart when they are drawn in the frame's own size. Rims that are a little apart cover a share of
    /// the picture that falls as its sides grow, by steps that grow as they do: together as the root of its sides.
    pub fn apart(&mut self, a: &Frame, b: &Frame) -> f64 {
        let [a, b] = [a, b].map(|frame| drawn(&mut self.renderer, &sized(frame, self.share), OF_MESHES));
        distance(&a, &b) * self.times.sqrt()
    }

    /// The error of a way, foreseen of the frame in its own size.
    fn error(&mut self, way: Sampling) -> f64 {
        if let Some((_, error)) = self.known.iter().find(|(known, _)| *known == way) {
            return *error;
        }
        let renderer = &mut self.renderer;
        let errors: Vec<f64> = self.pictures.iter().map(|small| small.error(renderer, way)).collect();
        let error = match errors.as_slice() {
            [own, smaller] => grown(*own, *smaller, self.times),
            _ => errors.first().copied().unwrap_or(f64::INFINITY),
        };
        self.known.push((way, error));
        error
    }
}

impl Small {
    fn new(renderer: &mut Renderer, frame: Frame) -> Self {
        let most = SAMPLES.iter().copied().max().unwrap_or(1).min(16);
        let [exact, other] = [REFERENCE, OTHER].map(|enlarged| {
            let way = Sampling { samples: most, enlarged, lod: 0 };
            drawn(renderer, &frame, way)
        });
        let own = OF_OTHER * distance(&other, &exact);
        Self { frame, exact, own }
    }

    fn error(&self, renderer: &mut Renderer, way: Sampling) -> f64 {
        let found = distance(&drawn(renderer, &self.frame, way), &self.exact);
        (found * found + self.own * self.own).sqrt()
    }
}

/// The picture that a way makes of a frame.
fn drawn(renderer: &mut Renderer, frame: &Frame, way: Sampling) -> Vec<[f32; 3]> {
    let mut frame = frame.clone();
    frame.view.samples = way.samples;
    frame.view.lod_error = way.lod_error();
    linear(&enlargement::drawn(renderer, &frame, way.enlarged, Wanted::default()).picture)
}

/// The cheapest way that stays within an error in all frames, and its error; the best of those tried when none does.
pub fn cheapest(probes: &mut [&mut Probe], room: f64, fits: impl Fn(u32) -> bool) -> (Sampling, f64) {
    let mut worst = |way: Sampling| probes.iter_mut().map(|probe| probe.error(way)).fold(0.0, f64::max);
    let mut best = (Sampling { samples: SAMPLES[0], enlarged: 1, lod: USUAL }, f64::INFINITY);
    let mut tried: Vec<(Sampling, f64)> = Vec::new();
    for way in Sampling::all().into_iter().filter(|way| way.enlarged == 1 || fits(way.enlarged)) {
        let mut row = tried.iter().rev().filter(|(other, _)| way.is_of_row(*other)).map(|(_, error)| error);
        if let (Some(last), Some(before)) = (row.next(), row.next())
            && *last > STALLED * before
        {
            continue;
        }
        let error = worst(way);
        tried.push((way, error));
        if error < best.1 {
            best = (way, error);
        }
        if error <= room {
            break;
        }
    }
    // Coarser levels where they fit too.
    let coarser = if best.0.lod == USUAL { USUAL + 1..LOD_ERRORS.len() } else { 0..0 };
    for lod in coarser.rev() {
        let coarser = Sampling { lod, ..best.0 };
        let error = worst(coarser);
        if error <= room {
            return (coarser, error);
        }
    }
    best
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

fn linear(picture: &Picture) -> Vec<[f32; 3]> {
    let table = linear_values();
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
    // A leaf by itself is no leaf of a tree: then everything in the picture is its own.
    let has_leaves = frame.instances.iter().any(|instance| instance.leaf.is_some());
    let squares = frame.instances.iter().filter_map(|instance| {
        let is_own = match instance.leaf {
            Some(leaf) => of.get(&leaf).is_none_or(|&own| own == species),
            None => !has_leaves && still.scene().camera.subject == Subject::Leaf,
        };
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

    fn probe(error: impl Fn(Sampling) -> f64) -> Probe {
        let ways = Sampling::all().into_iter();
        let known = ways.flat_map(|way| (0..LOD_ERRORS.len()).map(move |lod| Sampling { lod, ..way }));
        let known = known.map(|way| (way, error(way))).collect();
        let (pictures, renderer) = (Vec::new(), Renderer::default());
        Probe { pictures, share: 1.0, times: 1.0, renderer, known, steepness: 1.0, pixels_per_metre: vec![2.0] }
    }

    #[test]
    fn the_cheapest_way_within_the_error_is_taken_and_else_the_best() {
        let ways = Sampling::all();
        assert!(ways.windows(2).all(|pair| pair[0].work() <= pair[1].work()));
        // Levels of detail beyond the usual add a tenth each.
        let error = |way: Sampling| {
            1.0 / f64::from(way.samples * way.enlarged * way.enlarged) + 0.1 * way.lod.saturating_sub(USUAL) as f64
        };
        let found = |room: f64, fits: bool| {
            let way = cheapest(&mut [&mut probe(error)], room, |_| fits).0;
            (way.samples, way.enlarged, way.lod_error())
        };
        assert_eq!(found(0.13, true), (8, 1, 0.3));
        assert_eq!(found(0.3, true), (4, 1, 0.3));
        assert_eq!(found(0.36, true), (4, 1, 0.6));
        assert_eq!(found(1e-9, false), (256, 1, 0.3));
        assert_eq!(found(1e-9, true), (256, 4, 0.3));
        assert_eq!([probe(error).sensitivity(0), probe(error).sensitivity(7)], [2.0, 0.0]);
    }

    #[test]
    fn larger_pictures_are_foreseen_with_caution() {
        assert_eq!(grown(0.1, 0.1, 4.0), 0.1);
        let foreseen = grown(0.1, 0.1 * 2f64.sqrt(), 4.0);
        assert!(foreseen > 0.05 && foreseen < 0.1, "{foreseen}");
        assert_eq!(grown(0.1, 0.05, 4.0), 0.1);
    }
}
