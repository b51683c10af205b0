//! A line of words in the corner of a picture.

use super::lettering;
use super::primitive::{Anchor, Pen, Text};
use super::raster::stroke;
use super::words::{cleaned, width};
use crate::base::picture::Picture;
use tiny_skia::{LineCap, Pixmap};

/// Size of the letters over the picture's height, and its bounds in pixels.
const SIZE: f64 = 0.045;
const SIZES: [f64; 2] = [11.0, 72.0];
/// Distance of the words from the picture's edges, in sizes.
const MARGIN: f64 = 0.6;
/// How much wider than the strokes the dark around them is, in sizes.
const RIM: f64 = 0.24;
const INK: [u8; 3] = [250, 250, 246];
const DARK: [u8; 3] = [24, 26, 22];

/// Writes words into the lower left corner of a picture, light on dark so that they can be read on anything; smaller where they
/// would not fit.
pub fn label(picture: &mut Picture, words: &str) {
    let words = cleaned(words);
    let wanted = (SIZE * f64::from(picture.height)).clamp(SIZES[0], SIZES[1]);
    let fits = f64::from(picture.width) / (width(&words, 1.0) + 2.0 * MARGIN);
    let size = wanted.min(fits).min(f64::from(picture.height) / (1.0 + 2.0 * MARGIN));
    let strip = ((1.0 + 2.0 * MARGIN) * size).ceil() as u32;
    let Some(mut pixels) = Pixmap::new(picture.width, strip.min(picture.height)) else { return };
    let at = [MARGIN * size, f64::from(pixels.height()) - MARGIN * size];
    let lettering = lettering::letter(&Text::plain(at, words, size, Anchor::Start, INK));
    for (colour, width) in [(DARK, lettering.stroke + RIM * size), (INK, lettering.stroke)] {
        stroke(&lettering.lines, &Pen { colour, width, dashes: None }, LineCap::Round, &mut pixels);
    }
    let first = picture.pixels.len() - pixels.pixels().len();
    for (below, over) in picture.pixels[first..].iter_mut().zip(pixels.pixels()) {
        *below = laid_over(*below, [over.red(), over.green(), over.blue(), over.alpha()]);
    }
}

/// A premultiplied colour over one of straight alpha.
fn laid_over(below: [u8; 4], over: [u8; 4]) -> [u8; 4] {
    let part = |code: u8| f32::from(code) / 255.0;
    let kept = part(below[3]) * (1.0 - part(over[3]));
    let alpha = part(over[3]) + kept;
    if over[3] == 0 || alpha <= 0.0 {
        return below;
    }
    let channel = |k: usize| ((part(over[k]) + part(below[k]) * kept) / alpha * 255.0 + 0.5) as u8;
    [channel(0), channel(1), channel(2), (alpha * 255.0 + 0.5) as u8]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labelled(width: u32, height: u32, colour: [u8; 4], words: &str) -> Picture {
        let mut picture = Picture::filled(width, height, colour);
        label(&mut picture, words);
        picture
    }

    #[test]
    fn words_stand_in_the_lower_left_corner_light_and_dark() {
        for colour in [[255, 255, 255, 255], [0, 0, 0, 255], [120, 130, 90, 0]] {
            let picture = labelled(400, 300, colour, "Sugar maple, summer");
            let changed = |x: u32, y: u32| picture.at(x, y) != colour;
            let places = || (0..300u32).flat_map(|y| (0..400u32).map(move |x| (x, y)));
            assert!(places().filter(|&(x, y)| changed(x, y)).all(|(x, y)| x < 220 && y > 260));
            let is_like = |own: [u8; 4], ink: [u8; 3]| (0..3).all(|k| own[k].abs_diff(ink[k]) < 12) && own[3] == 255;
            for ink in [INK, DARK] {
                assert!(places().any(|(x, y)| is_like(picture.at(x, y), ink)), "{colour:?} {ink:?}");
            }
        }
    }

    #[test]
    fn any_words_fit_into_any_picture() {
        for (width, height) in [(1, 1), (16, 16), (30, 400), (400, 12)] {
            for words in
                ["", "a", "\u{0}\n ", "words that are by far too long for so few pixels, but are written all the same"]
            {
                let picture = labelled(width, height, [9; 4], words);
                // The margins stay as they were.
                assert!(
                    words.len() > 2 || width < 24 || (0..height).all(|y| picture.at(width - 1, y) == [9; 4]),
                    "{width} x {height}: {words}"
                );
            }
        }
        assert_eq!(labelled(80, 60, [9; 4], ""), Picture::filled(80, 60, [9; 4]));
    }

    #[test]
    fn an_opaque_colour_covers_and_half_of_one_is_mixed() {
        assert_eq!(laid_over([10, 20, 30, 255], [200, 100, 50, 255]), [200, 100, 50, 255]);
        assert_eq!(laid_over([0, 0, 0, 255], [128, 128, 128, 128]), [128, 128, 128, 255]);
        assert_eq!(laid_over([90, 90, 90, 0], [64, 64, 64, 128]), [128, 128, 128, 128]);
    }
}
