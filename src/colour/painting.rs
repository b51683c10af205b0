//! Textures of a leaf in each state: pigment fields turned into reflected and transmitted colour.

use super::appearance::{Appearance, Colour, Optics, colour_difference};
use super::contents::{Contents, contents};
use super::matching::{matched, seen};
use super::palette::{Look, Palette, look_in};
use super::pigment_field::Fields;
use super::relief;
use super::scan::Scan;
use super::spectra_table::SpectraTable;
use super::surface::{FAR, Surface, Tissue};
use super::{Detail, Pigments, Settings, Table};
use crate::base::blade::Blade;
use crate::base::encoding::SrgbEncoder;
use crate::base::figures::{ErrorFigure, Figures};
use crate::base::maths::smooth_step;
use crate::base::picture::Picture;
use crate::base::random::{Purpose, Stream, hash};
use rayon::prelude::*;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Pixels from the blade at which the background begins to fade to the mean colour; at [`FAR`] it has.
const FADED: f32 = 2.0;
/// Contents among which those of a scan are sought: chlorophyll, anthocyanins, brown.
const EVERY: [f32; 3] = [80.0, 40.0, 4.0];
/// About as many places are looked at to match a texture's mean.
const MATCHED: usize = 1200;

/// One texture to paint.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Job {
    /// The state; one without pigments in the settings gets the default ones.
    pub state: String,
    /// Which of the state's textures.
    pub variant: u32,
}

/// A painted texture: 8-bit sRGB, laid out by the mesh's texture coordinates, filled with leaf colour beyond the blade.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Painted {
    /// Diffuse reflectance of the upper side, without surface gloss; rows from the top.
    pub reflected: Arc<Vec<[u8; 3]>>,
    /// Diffuse transmittance.
    pub transmitted: Arc<Vec<[u8; 3]>>,
    /// Diffuse reflectance of the lower side, without surface gloss; empty for one that looks as the upper does.
    pub below: Arc<Vec<[u8; 3]>>,
    /// Normals of the upper side, x to the right, y up, z out of the leaf, -1..1 in 0..255; shared by all textures of a
    /// blade. Empty for a smooth one.
    pub relief: Arc<Vec<[u8; 3]>>,
    /// Pixels along each side.
    pub size: u32,
}

/// Scans that states wear, by state: laid out by the mesh's texture coordinates, clear where no leaf is.
pub type Scans = BTreeMap<String, Picture>;

/// What all textures of a blade share: where its margin, veins and areoles are, and its scans.
pub struct Canvas {
    surface: Surface,
    relief: Arc<Vec<[u8; 3]>>,
    /// The tissue that means are matched on.
    matched: Vec<Tissue>,
    encoder: SrgbEncoder,
    /// The scans of states; among them the blade's own one, worn by the state whose colour is nearest.
    scans: BTreeMap<String, Scan>,
}

impl Canvas {
    /// Lays a blade out for painting, at 140 bytes a pixel. A scan of the blade is worn by the state whose colour is nearest to
    /// it, unless that state has a scan of its own in `scans`, and gives its detail to all states without one.
    #[must_use]
    pub fn new(settings: &Settings, blade: &Blade, scans: &Scans) -> Self {
        let mut surface = Surface::new(blade, settings.side());
        let of_state = |(state, picture): (&String, &Picture)| Some((state.clone(), Scan::new(picture, &surface)?));
        let mut scans: BTreeMap<String, Scan> = scans.iter().filter_map(of_state).collect();
        if let Some(scan) = blade.scan.as_ref().and_then(|picture| Scan::new(picture, &surface)) {
            let optics = Optics::new(settings.table);
            let (state, pigments) = nearest(settings, &optics, &scan);
            let table = SpectraTable::new(&optics, pigments.structure, false);
            let palette = Palette::new(&table, &pigments, EVERY, settings.painting.pallor as f32);
            scan.age(&palette, &mut surface.tissue);
            scans.entry(state).or_insert(scan);
        }
        let every = (surface.tissue.len() / MATCHED).max(1);
        Self {
            relief: Arc::new(relief::normals(&surface, settings.painting.relief as f32)),
            matched: surface.tissue.iter().step_by(every).copied().collect(),
            encoder: SrgbEncoder::default(),
            surface,
            scans,
        }
    }
}

/// The state nearest in colour to a scan, among all that the settings know and not only those painted now: a texture must
/// not depend on which others are asked for.
fn nearest(settings: &Settings, optics: &Optics, scan: &Scan) -> (String, Pigments) {
    let of_state = |state: &String| {
        let pigments = contents(settings, optics, state).pigments;
        let far = colour_difference(scan.mean, optics.appearance(&pigments).reflected);
        (far, state.clone(), pigments)
    };
    let nearest = settings.pigments.keys().map(of_state).min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.map_or_else(Default::default, |(_, state, pigments)| (state, pigments))
}

/// What the textures of one state share.
struct Ink<'a> {
    contents: Contents,
    table: SpectraTable<'a>,
    /// The mean that its textures are matched to.
    mean: Look,
}

/// Paints the textures of the jobs, in their order, on a canvas of their own. The settings have passed
/// [`check`](super::check); a texture takes 9 bytes x size^2, to be allowed by the caller with the canvas. It depends
/// on its job, settings, blade and seed only.
///
/// The mean over the blade is the state's colour, without gloss where the leaf is glossy. A state with a scan wears it as it
/// is.
#[must_use]
pub fn paint(settings: &Settings, blade: &Blade, jobs: &[Job], seed: u64) -> (Vec<Painted>, Figures) {
    paint_on(&Canvas::new(settings, blade, &Scans::new()), settings, jobs, seed)
}

/// Paints on a canvas that was made before with the same settings.
#[must_use]
pub fn paint_on(canvas: &Canvas, settings: &Settings, jobs: &[Job], seed: u64) -> (Vec<Painted>, Figures) {
    let optics = Optics::new(settings.table);
    let inks = inks(settings, &optics, jobs);
    let painter = Painter { canvas, settings, seed };
    let painted = |job: &Job| painter.painted(&inks[&job.state], job);
    (jobs.par_iter().map(painted).collect(), figures(settings, &optics, &inks, jobs.len()))
}

fn inks<'a>(settings: &Settings, optics: &'a Optics, jobs: &[Job]) -> BTreeMap<String, Ink<'a>> {
    let mut states: Vec<&String> = jobs.iter().map(|job| &job.state).collect();
    states.sort_unstable();
    states.dedup();
    let ink = |state: &&String| {
        let contents = contents(settings, optics, state);
        let table = SpectraTable::new(optics, contents.pigments.structure, settings.gloss);
        let mean = look_in(&table, &contents.pigments, settings.painting.pallor as f32);
        ((*state).clone(), Ink { mean, contents, table })
    };
    states.par_iter().map(ink).collect::<Vec<_>>().into_iter().collect()
}

/// Paints textures on one canvas.
struct Painter<'a> {
    canvas: &'a Canvas,
    settings: &'a Settings,
    seed: u64,
}

impl Painter<'_> {
    fn painted(&self, ink: &Ink<'_>, job: &Job) -> Painted {
        if self.settings.detail == Detail::Plain {
            return self.finished(&ink.mean, |_| ink.mean);
        }
        let state = job.state.bytes().fold(job.state.len() as u64, |sum, byte| hash(sum, u64::from(byte)));
        // Blades of different lengths are different leaves, whatever their species is called.
        let leaf = hash(state, u64::from(self.canvas.surface.millimetre.to_bits()));
        let mut stream = Stream::new(self.seed, Purpose::Texture, leaf, u64::from(job.variant));
        let Contents { pigments, reference, .. } = &ink.contents;
        let Canvas { surface, matched: tissue, scans, .. } = self.canvas;
        let fields = Fields::new(surface, &self.settings.painting, pigments, *reference, &mut stream);
        let start = fields.amounts(pigments, *reference, tissue);
        let pallor = self.settings.painting.pallor as f32;
        let palette = Palette::new(&ink.table, pigments, fields.most(&start, pigments), pallor);
        let found = matched(&fields, &palette, tissue, start, &ink.mean);
        let scan = scans.get(&job.state);
        let mut mean = ink.mean;
        if let Some(scan) = scan {
            mean[..3].copy_from_slice(&scan.mean.map(|channel| channel as f32));
        }
        self.finished(&mean, |number| {
            let mut look = seen(&palette, &fields.at(&surface.tissue[number], &found.amounts));
            for c in 0..9 {
                look[c] *= found.gains[c];
            }
            if let Some(scan) = scan {
                look[..3].copy_from_slice(&scan.colours[number]);
            }
            look
        })
    }

    /// Lays the blade's looks, by the number of the pixel inside, out over the whole texture: each pixel beyond takes the
    /// nearest one of the blade, fading with the distance to the mean, so that no mip level holds anything but leaf.
    fn finished(&self, mean: &Look, look: impl Fn(usize) -> Look) -> Painted {
        let Canvas { surface, relief, encoder, .. } = self.canvas;
        let mean = mean.map(|channel| encoder.code(channel));
        let even = |side: usize| [mean[3 * side], mean[3 * side + 1], mean[3 * side + 2]];
        let mut sides = [0, 1, 2].map(|side| vec![even(side); surface.inside.len()]);
        for (number, pixel) in surface.pixels().enumerate() {
            let look = look(number);
            for side in 0..3 {
                let texel = &mut sides[side][pixel];
                for c in 0..3 {
                    texel[c] = encoder.code(look[3 * side + c]);
                }
            }
        }
        for &(pixel, source, gap) in &surface.filler {
            let near = 1.0 - smooth_step(FADED, FAR, gap);
            for pixels in &mut sides {
                let (from, far) = (pixels[source as usize], pixels[pixel as usize]);
                let faded =
                    |c: usize| (f32::from(far[c]) + (f32::from(from[c]) - f32::from(far[c])) * near + 0.5) as u8;
                pixels[pixel as usize] = [0, 1, 2].map(faded);
            }
        }
        let [reflected, transmitted, below] = sides.map(Arc::new);
        Painted { reflected, transmitted, below, relief: relief.clone(), size: surface.size as u32 }
    }
}

fn figures(settings: &Settings, optics: &Optics, inks: &BTreeMap<String, Ink<'_>>, jobs: usize) -> Figures {
    let reference = Optics::new(Table::Fine);
    let (mut states, mut worst) = (Map::new(), 0.0f64);
    for (state, ink) in inks {
        let Appearance { reflected, transmitted } = optics.appearance(&ink.contents.pigments);
        let exact = reference.appearance(&ink.contents.pigments);
        let differ = |a: Colour, b: Colour| colour_difference(a, b);
        worst = worst.max(differ(reflected, exact.reflected)).max(differ(transmitted, exact.transmitted));
        let mut figure = json!({ "reflected": reflected, "transmitted": transmitted });
        if let Some(miss) = ink.contents.miss {
            figure["fitted"] = json!({ "pigments": ink.contents.pigments, "dE76": miss });
        }
        states.insert(state.clone(), figure);
    }
    let mut figures = Figures::of(jobs as u64)
        .with("states", Value::Object(states))
        .with("size", settings.side())
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
    use super::super::palette::{Finish, look};
    use super::super::surface::tests::blade;
    use super::*;
    use crate::base::maths::{linear_to_srgb8, srgb_to_linear};

    fn settings() -> Settings {
        #[derive(serde::Deserialize)]
        struct Species {
            colour: Settings,
        }
        let species: Species = toml::from_str(include_str!("../species/red-maple.colour.toml")).unwrap();
        Settings { size: Some(128), ..species.colour }
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

    fn colour(pair: &Look, first: usize) -> Colour {
        std::array::from_fn(|c| f64::from(pair[first + c]))
    }

    #[test]
    fn a_textures_mean_is_its_states_colour() {
        let (settings, blade) = (settings(), blade());
        let inside = Surface::new(&blade, settings.side()).inside;
        let optics = Optics::new(settings.table);
        let jobs = jobs(&settings, 2);
        let (painted, figures) = paint(&settings, &blade, &jobs, 1);
        assert_eq!((painted.len(), figures.items), (14, 14));
        for (job, texture) in jobs.iter().zip(&painted) {
            let wanted = look(&optics, &contents(&settings, &optics, &job.state).pigments, Finish::of(&settings));
            let sides = [&texture.reflected, &texture.transmitted, &texture.below];
            for (number, side) in sides.into_iter().enumerate() {
                let missed = colour_difference(mean_colour(side, &inside), colour(&wanted, 3 * number));
                assert!(missed < 2.0, "{job:?}, side {number}: dE {missed}");
            }
        }
    }

    #[test]
    fn the_error_of_the_coarse_table_is_small_and_that_of_the_fine_one_none() {
        let coarse = Settings { size: Some(16), ..settings() };
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
        let surface = Surface::new(&blade, settings.side());
        let outside: Vec<bool> = surface.inside.iter().map(|leaf| !leaf).collect();
        let (leaf, beyond) =
            (mean_colour(&texture.reflected, &surface.inside), mean_colour(&texture.reflected, &outside));
        assert!(colour_difference(leaf, beyond) < 12.0);
    }

    /// A scan whose halves have these colours, with a dead spot in the middle.
    fn scan(halves: [Colour; 2]) -> Picture {
        let mut picture = Picture::filled(64, 64, [0, 0, 0, 255]);
        for (index, pixel) in picture.pixels.iter_mut().enumerate() {
            let half = halves[usize::from(index % 64 >= 32)].map(|c| c as f32);
            let colour = if is_spot(index, 64) { [0.06, 0.035, 0.025] } else { half };
            *pixel = [0, 1, 2, 3].map(|c| if c < 3 { linear_to_srgb8(colour[c]) } else { 255 });
        }
        picture
    }

    fn is_spot(pixel: usize, size: usize) -> bool {
        let near = |place: usize| place.abs_diff(size / 2) < size / 10;
        near(pixel % size) && near(pixel / size)
    }

    #[test]
    fn a_scan_is_worn_by_the_nearest_state_and_ages_into_the_others() {
        let settings = settings();
        let optics = Optics::new(settings.table);
        let green = contents(&settings, &optics, "green").pigments;
        let halves = [0.5, 1.6].map(|share| {
            optics.appearance(&Pigments { chlorophyll: share * green.chlorophyll, ..green.clone() }).reflected
        });
        let blade = Blade { scan: Some(scan(halves)), ..blade() };
        let jobs = ["green", "yellow"].map(|state| Job { state: state.to_owned(), variant: 0 });
        let painted = paint(&settings, &blade, &jobs, 1).0;
        let inside = Surface::new(&blade, 128).inside;
        let part = |texture: &Painted, picks: &dyn Fn(usize) -> bool| {
            let picked: Vec<bool> = inside.iter().enumerate().map(|(i, leaf)| *leaf && picks(i)).collect();
            mean_colour(&texture.reflected, &picked)
        };
        let left = |pixel: usize| pixel % 128 < 64 && !is_spot(pixel, 128);
        let worn = part(&painted[0], &left);
        assert!(colour_difference(worn, halves[0]) < 1.0, "{worn:?} {halves:?}");
        let yellow = look(&optics, &contents(&settings, &optics, "yellow").pigments, Finish::of(&settings));
        let whole = part(&painted[1], &|_| true);
        assert!(colour_difference(whole, colour(&yellow, 0)) < 2.0);
        // What held less chlorophyll is ahead; what was dead has stayed so.
        let right = |pixel: usize| pixel % 128 >= 64 && !is_spot(pixel, 128);
        let [ahead, behind] = [part(&painted[1], &left), part(&painted[1], &right)];
        assert!(ahead[0] / ahead[1] > 1.03 * behind[0] / behind[1], "{ahead:?} {behind:?}");
        let spot = part(&painted[1], &|pixel| is_spot(pixel, 128));
        assert!(spot[0] < 0.6 * ahead[0], "{spot:?} {ahead:?}");
    }

    #[test]
    fn a_state_wears_its_own_scan() {
        let (settings, blade) = (settings(), blade());
        let scans = Scans::from([("red".to_owned(), Picture::filled(8, 8, [90, 60, 200, 255]))]);
        let canvas = Canvas::new(&settings, &blade, &scans);
        let jobs = ["red", "yellow"].map(|state| Job { state: state.to_owned(), variant: 0 });
        let (painted, _) = paint_on(&canvas, &settings, &jobs, 1);
        assert!(
            painted[0].reflected.iter().all(|pixel| pixel.iter().zip([90, 60, 200]).all(|(a, b)| a.abs_diff(b) < 2))
        );
        assert_eq!(painted[1], paint(&settings, &blade, &jobs[1..], 1).0[0]);
    }
}
