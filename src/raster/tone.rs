//! From radiance to 8-bit sRGB: white balance, tone curve, encoding.

use super::tile::plain;
use crate::base::encoding::SrgbEncoder;
use crate::base::maths::{linear_to_srgb, log2f, powf};
use crate::frame::{Frame, ToneMap, UNBALANCED, View};
use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f32x8};
use rayon::prelude::*;

/// A tone curve with its encoding.
pub(super) struct Tone {
    map: ToneMap,
    balance: Option<[[f32; 3]; 3]>,
    encoder: SrgbEncoder,
    /// AgX's curve at even steps of its logarithmic range.
    curve: Vec<f32>,
    /// What is added to a pixel's channels, in steps of a code, by its row and column in a square of pixels.
    thresholds: [[f32; LANES]; LANES],
}

/// Pixels of a row that are encoded at once.
pub(super) const LANES: usize = 8;
/// The colours of such pixels, channel by channel.
pub(super) type Colours = [[f32; LANES]; 3];

impl Tone {
    /// Tabulates the encoding.
    pub(super) fn new(view: &View) -> Self {
        let balance = Some(view.balance).filter(|balance| *balance != UNBALANCED);
        let place = |step: usize| step as f32 / (AGX_STEPS - 1) as f32;
        let curve = match view.tone_map {
            ToneMap::Agx => (0..AGX_STEPS).map(|step| agx_curve(place(step))).collect(),
            _ => Vec::new(),
        };
        let thresholds = std::array::from_fn(|y| std::array::from_fn(|x| threshold(x, y)));
        Self { map: view.tone_map, balance, encoder: SrgbEncoder::default(), curve, thresholds }
    }

    /// The codes of exposed linear colours in row `y` of the picture, from a column on that is a multiple of their number: with
    /// a threshold from an ordered pattern instead of a half, so that slow gradients have no bands. Without a tone curve codes
    /// are for measuring, and are rounded. What is shown is laid over a plain colour by its share of each pixel.
    #[inline(always)]
    pub(super) fn codes<W: Simd>(
        &self,
        simd: W,
        colours: &Colours,
        (share, plain): (&[f32; LANES], Option<[f32; 3]>),
        y: usize,
    ) -> [[u8; 3]; LANES] {
        let shown = self.shown(simd, colours, (share, plain));
        let mut thresholds = f32x8::from_slice(simd, &self.thresholds[y % LANES]);
        if plain.is_some() {
            thresholds *= f32x8::from_slice(simd, share);
        }
        let mut codes = [[0; 3]; LANES];
        for k in 0..3 {
            let dithered =
                if self.map == ToneMap::None { shown[k] } else { shown[k] + thresholds * step(simd, shown[k]) };
            let places = self.encoder.places(simd, dithered);
            for lane in 0..LANES {
                codes[lane][k] = self.encoder.code_at(places[lane]);
            }
        }
        codes
    }

    /// What is shown of exposed linear colours, laid over a plain colour by their share of each pixel.
    #[inline(always)]
    fn shown<W: Simd>(
        &self,
        simd: W,
        [red, green, blue]: &Colours,
        (share, plain): (&[f32; LANES], Option<[f32; 3]>),
    ) -> [f32x8<W>; 3] {
        let load = |channel: &[f32; LANES]| f32x8::from_slice(simd, channel);
        let mut shown = self.mapped(simd, [load(red), load(green), load(blue)]);
        if let Some(colour) = plain {
            let share = load(share);
            let rest = f32x8::splat(simd, 1.0) - share;
            for k in 0..3 {
                shown[k] = shown[k] * share + rest * colour[k];
            }
        }
        shown
    }

    #[inline(always)]
    fn mapped<W: Simd>(&self, simd: W, [red, green, blue]: [f32x8<W>; 3]) -> [f32x8<W>; 3] {
        let colour = match &self.balance {
            Some(rows) => {
                let row = |[r, g, b]: [f32; 3]| {
                    let sum = red * r + green * g + blue * b;
                    sum.simd_gt(0.0).select(sum, f32x8::splat(simd, 0.0))
                };
                [row(rows[0]), row(rows[1]), row(rows[2])]
            }
            None => [red, green, blue],
        };
        match self.map {
            ToneMap::Neutral => neutral(simd, colour),
            ToneMap::Agx => self.agx(simd, colour),
            ToneMap::None => colour,
        }
    }

    /// AgX (Sobotka 2022): into a narrower gamut, a sigmoid over the logarithm, and back.
    fn agx<W: Simd>(&self, simd: W, [red, green, blue]: [f32x8<W>; 3]) -> [f32x8<W>; 3] {
        let mut channels: Colours = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            let inset = times(&AGX_INSET, [red[lane], green[lane], blue[lane]].map(|c| c.max(0.0)));
            let curved = inset.map(|c| {
                let stops = (log2f(c.max(1e-10)) - AGX_RANGE[0]) / (AGX_RANGE[1] - AGX_RANGE[0]);
                let place = stops.clamp(0.0, 1.0) * (AGX_STEPS - 1) as f32;
                let first = (place as usize).min(AGX_STEPS - 2);
                self.curve[first] + (self.curve[first + 1] - self.curve[first]) * (place - first as f32)
            });
            for (channel, value) in channels.iter_mut().zip(times(&AGX_OUTSET, curved)) {
                channel[lane] = powf(value.max(0.0), 2.2);
            }
        }
        channels.map(|channel| f32x8::from_slice(simd, &channel))
    }
}

/// The codes of 16 bits of a frame's exposed linear colours with their alpha: what its white balance and tone curve make of
/// them, over its plain background, in sRGB. Slow gradients need no dither in so many steps.
#[must_use]
pub fn developed(frame: &Frame, radiance: &[[f32; 4]]) -> Vec<[u16; 4]> {
    let tone = Tone::new(&frame.view);
    let plain = plain(frame);
    let eight = |pixels: &[[f32; 4]]| {
        let (mut colours, mut share): (Colours, _) = ([[0.0; LANES]; 3], [0.0; LANES]);
        for (lane, pixel) in pixels.iter().enumerate() {
            (0..3).for_each(|k| colours[k][lane] = pixel[k]);
            share[lane] = pixel[3];
        }
        let shown = dispatch!(Level::new(), simd => {
            let [red, green, blue] = tone.shown(simd, &colours, (&share, plain));
            [<[f32; LANES]>::from(red), green.into(), blue.into()]
        });
        let code = |value: f32| (value.clamp(0.0, 1.0) * 65535.0 + 0.5) as u16;
        let codes = |lane: usize| {
            let [red, green, blue] = shown.map(|channel| code(linear_to_srgb(channel[lane])));
            [red, green, blue, if plain.is_some() { u16::MAX } else { code(share[lane]) }]
        };
        (0..pixels.len()).map(codes).collect::<Vec<_>>()
    };
    radiance.par_chunks(LANES).flat_map_iter(eight).collect()
}

/// Steps of the table of AgX's curve.
const AGX_STEPS: usize = 1024;
/// Stops about middle grey's 0.18 that the curve spans: log2 of linear values (Sobotka's -10 to +6.5).
const AGX_RANGE: [f32; 2] = [-12.473_93, 4.026_069];
/// Sobotka's inset of linear sRGB and the way back, rows.
const AGX_INSET: [[f32; 3]; 3] = [
    [0.842_479, 0.078_433_6, 0.079_223_7],
    [0.042_328_2, 0.878_468_6, 0.079_166_1],
    [0.042_375_7, 0.078_433_6, 0.879_142_6],
];
const AGX_OUTSET: [[f32; 3]; 3] = [
    [1.196_879, -0.098_020_9, -0.099_029_7],
    [-0.052_896_9, 1.151_903_1, -0.098_961_2],
    [-0.052_971_6, -0.098_043_4, 1.151_073_7],
];

/// AgX's sigmoid through middle grey (Sobotka 2022): slope 2.4 there, powers 1.5 of toe and shoulder.
fn agx_curve(x: f32) -> f32 {
    const SLOPE: f32 = 2.4;
    const POWER: f32 = 1.5;
    const PIVOT: [f32; 2] = [10.0 / 16.5, 0.5];
    // Each half is s t / (1 + |t|^p)^(1/p), t = slope (x - pivot) / s, with s such that the end is met.
    let (end_x, end_y) = if x < PIVOT[0] { (0.0, 0.0) } else { (1.0, 1.0) };
    let (run, rise) = ((PIVOT[0] - end_x).abs(), (PIVOT[1] - end_y).abs());
    let scale = powf(powf(SLOPE * run, -POWER) * (powf(SLOPE * run / rise, POWER) - 1.0), -1.0 / POWER);
    let t = SLOPE * (x - PIVOT[0]).abs() / scale;
    let half = scale * t / powf(1.0 + powf(t, POWER), 1.0 / POWER);
    if x < PIVOT[0] { PIVOT[1] - half } else { PIVOT[1] + half }
}

fn times(rows: &[[f32; 3]; 3], [r, g, b]: [f32; 3]) -> [f32; 3] {
    rows.map(|row| row[0] * r + row[1] * g + row[2] * b)
}

/// Linear light of about one 8-bit step at a linear value: the slope of sRGB's curve, 2.4 / 1.055 of the power law's.
#[inline(always)]
fn step<W: Simd>(simd: W, linear: f32x8<W>) -> f32x8<W> {
    let root = linear.simd_gt(0.0).select(linear, f32x8::splat(simd, 0.0)).sqrt();
    // The power 1.4 / 2.4, to some percent over what is displayed.
    let step = root * 0.008_92 * (root.sqrt() * 0.37 + 0.63);
    let least = f32x8::splat(simd, 1.0 / (255.0 * 12.92));
    step.simd_gt(least).select(step, least)
}

/// -0.5 to 0.5 by an 8 x 8 pattern of even thresholds (Bayer 1973), from the bits of x ^ y and y interleaved.
fn threshold(x: usize, y: usize) -> f32 {
    let (mixed, y) = (x ^ y, y);
    let bit = |value: usize, place: usize| value >> place & 1;
    let rank = (0..3).fold(0, |rank, place| rank << 2 | bit(mixed, place) << 1 | bit(y, place));
    (rank as f32 + 0.5) / 64.0 - 0.5
}

/// Where Khronos PBR Neutral begins to compress, and how fast it pales.
const START: f32 = 0.8 - 0.04;
const DESATURATION: f32 = 0.15;

/// Khronos PBR Neutral (KhronosGroup/ToneMapping): takes off the usual 4 % surface reflection, keeps colours below 0.76 and
/// rolls what is brighter off towards white.
#[inline(always)]
fn neutral<W: Simd>(simd: W, [red, green, blue]: [f32x8<W>; 3]) -> [f32x8<W>; 3] {
    let lesser = |a: f32x8<W>, b: f32x8<W>| a.simd_lt(b).select(a, b);
    let greater = |a: f32x8<W>, b: f32x8<W>| a.simd_gt(b).select(a, b);
    let least = lesser(lesser(red, green), blue);
    let offset = least.simd_lt(0.08).select(least - least * least * 6.25, f32x8::splat(simd, 0.04));
    let (red, green, blue) = (red - offset, green - offset, blue - offset);
    let peak = greater(greater(red, green), blue);
    let is_below = peak.simd_lt(START);
    let room = 1.0 - START;
    let one = f32x8::splat(simd, 1.0);
    let new_peak = one - f32x8::splat(simd, room * room) / (peak + (room - START));
    let weight = one - one / ((peak - new_peak) * DESATURATION + 1.0);
    let (gain, pale) = ((new_peak / peak) * (one - weight), new_peak * weight);
    let rolled = |channel: f32x8<W>| is_below.select(channel, channel * gain + pale);
    [rolled(red), rolled(green), rolled(blue)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::maths::linear_to_srgb8;

    fn tone(tone_map: ToneMap) -> Tone {
        let view = View {
            width: 1,
            height: 1,
            samples: 1,
            lod_error: 0.3,
            shadow_size: 0,
            exposure: 1.0,
            metered: false,
            balance: UNBALANCED,
            tone_map,
            wireframe: None,
        };
        Tone::new(&view)
    }

    /// The code of a colour at a column and row.
    fn code(tone: &Tone, colour: [f32; 3], [x, y]: [usize; 2]) -> [u8; 3] {
        let colours = colour.map(|value| [value; LANES]);
        dispatch!(Level::new(), simd => tone.codes(simd, &colours, (&[1.0; LANES], None), y))[x % LANES]
    }

    /// What a curve makes of a colour.
    fn mapped(tone: &Tone, colour: [f32; 3]) -> [f32; 3] {
        dispatch!(Level::new(), simd => tone.mapped(simd, colour.map(|value| f32x8::splat(simd, value))).map(|c| c[3]))
    }

    #[test]
    fn without_a_curve_codes_are_those_of_srgb() {
        let tone = tone(ToneMap::None);
        for step in 0..=1000u16 {
            let value = f32::from(step) / 1000.0;
            let code = code(&tone, [value; 3], [3, 5])[0];
            assert!(code.abs_diff(linear_to_srgb8(value)) <= 1, "{value}");
        }
        assert_eq!(code(&tone, [-1.0, 2.0, f32::INFINITY], [3, 5]), [0, 255, 255]);
    }

    #[test]
    fn the_neutral_curve_keeps_the_middle_and_stays_below_white() {
        let tone = tone(ToneMap::Neutral);
        let middle = mapped(&tone, [0.5, 0.3, 0.2]);
        assert!((middle[0] - 0.46).abs() < 1e-6 && (middle[2] - 0.16).abs() < 1e-6);
        for bright in [1.0, 4.0, 100.0] {
            let mapped = mapped(&tone, [bright, bright * 0.5, 0.1]);
            assert!(mapped.iter().all(|c| (0.0..=1.0).contains(c)));
        }
        assert!(mapped(&tone, [2.0; 3])[0] < mapped(&tone, [3.0; 3])[0]);
    }

    #[test]
    fn agx_keeps_grey_grey_and_middle_grey_in_the_middle_and_never_clips() {
        let tone = tone(ToneMap::Agx);
        let middle = mapped(&tone, [0.18; 3]);
        // 0.5 of the encoded range by definition.
        assert!((middle[1] - powf(0.5, 2.2)).abs() < 2e-3 && (middle[0] - middle[2]).abs() < 1e-3, "{middle:?}");
        let mut last = -1.0;
        for stop in -12..5 {
            let value = mapped(&tone, [libm::exp2f(stop as f32); 3])[1];
            assert!(value > last && value <= 1.0001, "{stop} {value}");
            last = value;
        }
        assert!((agx_curve(1.0) - 1.0).abs() < 1e-4 && agx_curve(0.0).abs() < 1e-4);
    }

    #[test]
    fn what_is_laid_over_a_colour_keeps_its_share_of_what_is_shown() {
        let tone = tone(ToneMap::Neutral);
        let grey = mapped(&tone, [0.5; 3])[0];
        for share in [0.0, 0.25, 1.0] {
            let colours = [[0.5; LANES]; 3];
            let laid = (&[share; LANES], Some([1.0, 1.0, 1.0]));
            let [code, ..] = dispatch!(Level::new(), simd => tone.codes(simd, &colours, laid, 0));
            let exact = crate::base::maths::linear_to_srgb(grey * share + 1.0 - share) * 255.0;
            assert!((f32::from(code[0]) - exact).abs() < 1.25, "{share}: {code:?} is not {exact}");
        }
        let white = (&[0.0; LANES], Some([1.0; 3]));
        let codes = dispatch!(Level::new(), simd => tone.codes(simd, &[[0.0; LANES]; 3], white, 3));
        assert_eq!(codes, [[255; 3]; LANES], "a plain colour has no dither");
    }

    #[test]
    fn a_dithered_gradient_has_its_mean_and_no_code_is_more_than_one_off() {
        let tone = tone(ToneMap::Neutral);
        for step in 1..60 {
            let value = step as f32 * 0.0113;
            let (mut sum, exact) = (0.0, crate::base::maths::linear_to_srgb(mapped(&tone, [value; 3])[0]) * 255.0);
            for (x, y) in (0..8).flat_map(|x| (0..8).map(move |y| (x, y))) {
                let code = f32::from(code(&tone, [value; 3], [x, y])[0]);
                assert!((code - exact).abs() < 1.25, "{value}: {code} {exact}");
                sum += code;
            }
            assert!((sum / 64.0 - exact).abs() < 0.15, "{value}: {} {exact}", sum / 64.0);
        }
    }
}
