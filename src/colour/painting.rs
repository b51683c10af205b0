//! Textures of a leaf in each state: pigment fields turned into reflected and transmitted colour.

use super::appearance::{Appearance, Colour, Optics, colour_difference};
use super::palette::{Pair, Palette, pair};
use super::pigment_field::pigment_field;
use super::scan::Scan;
use super::surface::Surface;
use super::{Pigments, Settings, Table};
use crate::base::blade::Blade;
use crate::base::encoding::SrgbEncoder;
use crate::base::figures::{ErrorFigure, Figures};
use crate::base::maths::{mix, smooth_step};
use crate::base::random::{Purpose, Stream, hash};
use rayon::prelude::*;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

/// Rounds of matching a texture's mean to its state's colour; each undoes what clipping took in the one before.
const MATCHING_ROUNDS: usize = 4;
/// Pixels from the blade at which the background begins to fade to the mean colour, and at which it has.
const FADE: (f32, f32) = (2.0, 14.0);

/// One texture to paint.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Job {
    /// The state; one without pigments in the settings gets the default ones.
    pub state: String,
    /// Which of the state's textures.
    pub variant: u32,
}

/// A painted texture: 8-bit sRGB, laid out by the mesh's texture coordinates, filled with leaf colour beyond the blade.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Painted {
    /// Diffuse reflectance of the upper side, without surface gloss; rows from the top.
    pub reflected: Vec<[u8; 3]>,
    /// Diffuse transmittance.
    pub transmitted: Vec<[u8; 3]>,
    /// Pixels along each side.
    pub size: u32,
}

/// What the textures of one state share.
struct Ink {
    pigments: Pigments,
    palette: Palette,
    /// The mean that its textures are matched to.
    mean: Pair,
    /// Whether the scan itself is worn: its own colours are nearest to this state's.
    wears_scan: bool,
}

/// Paints the textures of the jobs, in their order. The settings have passed [`check`](super::check); a job takes
/// about 100 bytes x size^2 while it is painted and 6 bytes x size^2 for its result, to be allowed by the
/// caller. A texture depends on its job, settings, blade and seed only.
///
/// The mean over the blade is the state's colour without gloss. With a scan, the scan's detail is worn in the
/// state's colour; the state whose colour is nearest to the scan's mean wears the scan as it is.
#[must_use]
pub fn paint(settings: &Settings, blade: &Blade, jobs: &[Job], seed: u64) -> (Vec<Painted>, Figures) {
    let optics = Optics::new(settings.table);
    let surface = Surface::new(blade, settings.size);
    let scan = blade.scan.as_ref().and_then(|picture| Scan::new(picture, &surface));
    let inks = inks(settings, &optics, jobs, scan.as_ref());
    let painted = |job: &Job| {
        let ink = &inks[&job.state];
        let colours = match &scan {
            Some(scan) => scanned(scan, ink),
            None => pigmented(&surface, ink, job, seed),
        };
        finished(&surface, &colours)
    };
    (jobs.par_iter().map(painted).collect(), figures(settings, &optics, &inks, jobs.len()))
}

fn inks(settings: &Settings, optics: &Optics, jobs: &[Job], scan: Option<&Scan>) -> BTreeMap<String, Ink> {
    let mut states: Vec<&String> = jobs.iter().map(|job| &job.state).collect();
    states.sort_unstable();
    states.dedup();
    let ink = |state: &&String| {
        let pigments = settings.pigments.get(*state).cloned().unwrap_or_default();
        let palette = Palette::new(optics, &pigments);
        ((*state).clone(), Ink { mean: pair(optics, &pigments), palette, pigments, wears_scan: false })
    };
    let mut inks: BTreeMap<String, Ink> = states.par_iter().map(ink).collect::<Vec<_>>().into_iter().collect();
    if let Some(scan) = scan {
        wear_scan(settings, optics, scan, &mut inks);
    }
    inks
}

/// Marks the state nearest in colour to the scan, among all that the settings know and not only those painted now: a
/// texture must not depend on which others are asked for.
fn wear_scan(settings: &Settings, optics: &Optics, scan: &Scan, inks: &mut BTreeMap<String, Ink>) {
    let difference = |pigments: &Pigments| colour_difference(scan.mean, optics.appearance(pigments).reflected);
    let nearest = settings.pigments.iter().map(|(state, pigments)| (difference(pigments), state));
    let nearest = nearest.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, state)| state);
    if let Some(ink) = nearest.and_then(|state| inks.get_mut(state)) {
        ink.wears_scan = true;
        ink.mean[..3].copy_from_slice(&scan.mean.map(|channel| channel as f32));
    }
}

/// Colours from pigments, of the pixels inside.
fn pigmented(surface: &Surface, ink: &Ink, job: &Job, seed: u64) -> Vec<Pair> {
    let state = job.state.bytes().fold(job.state.len() as u64, |sum, byte| hash(sum, u64::from(byte)));
    let mut stream = Stream::new(seed, Purpose::Texture, state, u64::from(job.variant));
    let samples = pigment_field(surface, &ink.pigments, &mut stream);
    let colour = |sample: &super::pigment_field::Sample| {
        let pair = ink.palette.at(sample.contents);
        std::array::from_fn(|c| pair[c] * if c < 3 { sample.reflected } else { sample.transmitted })
    };
    let mut colours: Vec<Pair> = samples.iter().map(colour).collect();
    match_mean(&mut colours, &ink.mean);
    colours
}

/// Colours from a scan, of the pixels inside.
fn scanned(scan: &Scan, ink: &Ink) -> Vec<Pair> {
    let colour = |pixel: usize| -> Pair {
        let detail = scan.detail(pixel);
        let worn = scan.colours[pixel];
        std::array::from_fn(|c| if c < 3 && ink.wears_scan { worn[c] } else { ink.mean[c] * detail[c % 3] })
    };
    let mut colours: Vec<Pair> = (0..scan.colours.len()).map(colour).collect();
    match_mean(&mut colours, &ink.mean);
    colours
}

/// Scales each channel until its mean, clipped to 0..1, is that wanted.
fn match_mean(colours: &mut [Pair], wanted: &Pair) {
    for _ in 0..MATCHING_ROUNDS {
        let found = mean(colours);
        let gains: Pair = std::array::from_fn(|c| wanted[c] / found[c].max(1e-9));
        for colour in colours.iter_mut() {
            *colour = std::array::from_fn(|c| (colour[c] * gains[c]).min(1.0));
        }
    }
}

fn mean(colours: &[Pair]) -> Pair {
    let count = colours.len().max(1) as f64;
    std::array::from_fn(|c| (colours.iter().map(|colour| f64::from(colour[c])).sum::<f64>() / count) as f32)
}

/// Lays the blade's colours out over the whole texture: each pixel beyond takes the nearest one of the blade, fading
/// with the distance to the mean, so that no mip level holds anything but leaf.
fn finished(surface: &Surface, colours: &[Pair]) -> Painted {
    let mean = mean(colours);
    let mut number = vec![0usize; surface.inside.len()];
    let inside = (0..surface.inside.len()).filter(|&pixel| surface.inside[pixel]);
    inside.enumerate().for_each(|(index, pixel)| number[pixel] = index);
    let encoder = SrgbEncoder::default();
    let code = |&(source, gap): &(u32, f32)| {
        let near = &colours[number[source as usize]];
        let faded = smooth_step(FADE.0, FADE.1, gap);
        let codes: [u8; 6] = std::array::from_fn(|c| encoder.code(mix(near[c], mean[c], faded)));
        codes
    };
    let codes: Vec<[u8; 6]> = surface.filler.iter().map(code).collect();
    Painted {
        reflected: codes.iter().map(|c| [c[0], c[1], c[2]]).collect(),
        transmitted: codes.iter().map(|c| [c[3], c[4], c[5]]).collect(),
        size: surface.size as u32,
    }
}

fn figures(settings: &Settings, optics: &Optics, inks: &BTreeMap<String, Ink>, jobs: usize) -> Figures {
    let reference = Optics::new(Table::Fine);
    let (mut states, mut worst) = (Map::new(), 0.0f64);
    for (state, ink) in inks {
        let Appearance { reflected, transmitted } = optics.appearance(&ink.pigments);
        let exact = reference.appearance(&ink.pigments);
        let differ = |a: Colour, b: Colour| colour_difference(a, b);
        worst = worst.max(differ(reflected, exact.reflected)).max(differ(transmitted, exact.transmitted));
        states.insert(state.clone(), json!({ "reflected": reflected, "transmitted": transmitted }));
    }
    let mut figures = Figures::of(jobs as u64)
        .with("states", Value::Object(states))
        .with("size", settings.size)
        .with("gloss", optics.gloss().to_vec());
    figures.error = Some(ErrorFigure {
        metric: "dE76".to_owned(),
        value: worst,
        unit: String::new(),
        bound: None,
        how: "colours of the states by the table in use against those by the 5 nm table, the largest".to_owned(),
    });
    figures
}

#[cfg(test)]
mod tests {
    use super::super::surface::tests::blade;
    use super::*;
    use crate::base::maths::{linear_to_srgb8, srgb_to_linear};
    use crate::base::picture::Picture;

    fn settings() -> Settings {
        #[derive(serde::Deserialize)]
        struct Species {
            colour: Settings,
        }
        let species: Species = toml::from_str(include_str!("../species/red-maple.colour.toml")).unwrap();
        Settings { size: 128, ..species.colour }
    }

    fn jobs(settings: &Settings, variants: u32) -> Vec<Job> {
        let states = settings.pigments.keys();
        states.flat_map(|state| (0..variants).map(|variant| Job { state: state.clone(), variant })).collect()
    }

    fn mean_colour(pixels: &[[u8; 3]], inside: &[bool]) -> Colour {
        let picked: Vec<&[u8; 3]> = pixels.iter().zip(inside).filter(|(_, leaf)| **leaf).map(|(p, _)| p).collect();
        let linear = |code: u8| f64::from(srgb_to_linear(f32::from(code) / 255.0));
        std::array::from_fn(|c| picked.iter().map(|p| linear(p[c])).sum::<f64>() / picked.len() as f64)
    }

    fn colour(pair: &Pair, first: usize) -> Colour {
        std::array::from_fn(|c| f64::from(pair[first + c]))
    }

    #[test]
    fn a_textures_mean_is_its_states_colour() {
        let (settings, blade) = (settings(), blade());
        let inside = Surface::new(&blade, settings.size).inside;
        let optics = Optics::new(settings.table);
        let jobs = jobs(&settings, 2);
        let (painted, figures) = paint(&settings, &blade, &jobs, 1);
        assert_eq!((painted.len(), figures.items), (14, 14));
        for (job, texture) in jobs.iter().zip(&painted) {
            let wanted = pair(&optics, &settings.pigments[&job.state]);
            let reflected = colour_difference(mean_colour(&texture.reflected, &inside), colour(&wanted, 0));
            let transmitted = colour_difference(mean_colour(&texture.transmitted, &inside), colour(&wanted, 3));
            assert!(reflected < 2.0 && transmitted < 2.0, "{job:?}: dE {reflected} and {transmitted}");
        }
    }

    #[test]
    fn the_error_of_the_coarse_table_is_small_and_that_of_the_fine_one_none() {
        let coarse = Settings { size: 16, ..settings() };
        let fine = Settings { table: Table::Fine, ..coarse.clone() };
        let error = |settings: &Settings| paint(settings, &blade(), &jobs(settings, 1), 1).1.error.unwrap().value;
        assert!((1e-4..0.5).contains(&error(&coarse)), "{}", error(&coarse));
        assert_eq!(error(&fine), 0.0);
    }

    #[test]
    fn a_job_is_painted_alike_alone_and_in_company_on_any_number_of_threads() {
        let (settings, blade) = (settings(), blade());
        let jobs = jobs(&settings, 1);
        let on = |threads: usize, jobs: &[Job]| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| paint(&settings, &blade, jobs, 7).0)
        };
        let together = on(3, &jobs);
        assert_eq!(on(1, &jobs), together);
        assert_eq!(on(1, &jobs[4..5])[0], together[4]);
    }

    #[test]
    fn seed_and_variant_change_a_texture() {
        let (settings, blade) = (settings(), blade());
        let red = |variant| [Job { state: "red".to_owned(), variant }];
        let one = paint(&settings, &blade, &red(0), 1).0;
        assert_ne!(one, paint(&settings, &blade, &red(1), 1).0);
        assert_ne!(one, paint(&settings, &blade, &red(0), 2).0);
    }

    #[test]
    fn the_background_is_leaf() {
        let (settings, blade) = (settings(), blade());
        let texture = &paint(&settings, &blade, &[Job { state: "red".to_owned(), variant: 0 }], 1).0[0];
        let surface = Surface::new(&blade, settings.size);
        let outside: Vec<bool> = surface.inside.iter().map(|leaf| !leaf).collect();
        let (leaf, beyond) =
            (mean_colour(&texture.reflected, &surface.inside), mean_colour(&texture.reflected, &outside));
        assert!(colour_difference(leaf, beyond) < 12.0);
    }

    /// A scan of one colour whose left half is 1.5 times as light as its right one.
    fn scan(colour: [f32; 3]) -> Picture {
        let mut picture = Picture::filled(64, 64, [0, 0, 0, 255]);
        for (index, pixel) in picture.pixels.iter_mut().enumerate() {
            let light = if index % 64 < 32 { 1.2 } else { 0.8 };
            *pixel = [0, 1, 2, 3].map(|c| if c < 3 { linear_to_srgb8(colour[c] * light) } else { 255 });
        }
        picture
    }

    #[test]
    fn a_scan_gives_detail_in_the_states_colour_and_is_worn_by_the_nearest_state() {
        let settings = settings();
        let green = Optics::new(settings.table).appearance(&settings.pigments["green"]).reflected;
        let blade = Blade { scan: Some(scan(green.map(|c| c as f32))), ..blade() };
        let jobs = ["green", "red"].map(|state| Job { state: state.to_owned(), variant: 0 });
        let painted = paint(&settings, &blade, &jobs, 1).0;
        let half = |first: usize| -> Vec<bool> {
            let inside = Surface::new(&blade, 128).inside;
            inside.iter().enumerate().map(|(i, leaf)| *leaf && (i % 128) / 64 == first).collect()
        };
        let worn = mean_colour(&painted[0].reflected, &half(0));
        let other = [mean_colour(&painted[1].reflected, &half(0)), mean_colour(&painted[1].reflected, &half(1))];
        assert!(colour_difference(worn, green.map(|c| c * 1.2)) < 3.0, "{worn:?} {green:?}");
        assert!((other[0][0] / other[1][0] - 1.5).abs() < 0.06);
        assert!(other[0][0] > 2.0 * other[0][1]);
    }
}
