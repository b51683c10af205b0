//! Letters with marks over them, as European languages write them: a letter of the font and the strokes of a mark.

use super::letters::{Point, glyph, strokes};

/// Letters, the font's own below each, and the mark's strokes as it stands over a small letter of the middle's width.
#[rustfmt::skip]
const MARKED: &[(&str, &str, &str)] = &[
    ("äëïöüÿÄËÏÖÜŸ", "aeıouyAEIOUY", "4g 4h;8g 8h"),
    ("áéíóúýćńśźÁÉÍÓÚÝĆŃŚŹ", "aeıouycnszAEIOUYCNSZ", "5g 8j"),
    ("àèìòùÀÈÌÒÙ", "aeıouAEIOU", "7g 4j"),
    ("âêîôûÂÊÎÔÛ", "aeıouAEIOU", "3g 6j 9g"),
    ("čěňřšžČĚŇŘŠŽ", "cenrszCENRSZ", "3j 6g 9j"),
    ("ãñõÃÑÕ", "anoANO", "2g ~4k 6h ~8e aj"),
    ("åůÅŮ", "auAU", "6k ~8k 8i ~8g 6g ~4g 4i ~4k 6k"),
    ("āēīōūĀĒĪŌŪ", "aeıouAEIOU", "3h 9h"),
];
/// The middle of a mark, and how much higher it stands over a capital, units.
const MIDDLE: i16 = 6;
const HIGHER: i16 = 4;

/// The letter of the font below a marked one, and the mark.
fn parted(letter: char) -> Option<(char, &'static str)> {
    let known = |(letters, bases, mark): &(&str, &'static str, &'static str)| {
        let at = letters.chars().position(|known| known == letter)?;
        Some((bases.chars().nth(at)?, *mark))
    };
    MARKED.iter().find_map(known)
}

/// The letter that stands for this one in the font.
pub(super) fn base(letter: char) -> char {
    parted(letter).map_or(letter, |(base, _)| base)
}

/// The strokes of a letter, its mark's among them.
pub(super) fn marked_strokes(letter: char) -> Vec<Vec<Point>> {
    let (advance, table) = glyph(base(letter));
    let mut all = strokes(table);
    if let Some((base, mark)) = parted(letter) {
        let aside = advance as i16 / 2 - MIDDLE;
        let up = if base.is_uppercase() { HIGHER } else { 0 };
        let moved = |at: u8, by: i16| (i16::from(at) + by).clamp(0, 35) as u8;
        let place = |point: Point| Point { x: moved(point.x, aside), y: moved(point.y, up), ..point };
        all.extend(strokes(mark).into_iter().map(|stroke| stroke.into_iter().map(place).collect()));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_marked_letter_has_a_base_in_the_font_and_its_mark_above_it() {
        let unknown = glyph('\u{4e2d}').1;
        for (letters, bases, _) in MARKED {
            assert_eq!(letters.chars().count(), bases.chars().count(), "{letters}");
            for (letter, base) in letters.chars().zip(bases.chars()) {
                assert!(glyph(base).1 != unknown, "{base}");
                let (plain, marked) = (marked_strokes(base), marked_strokes(letter));
                assert!(marked.len() > plain.len());
                let top = plain.iter().flatten().map(|point| point.y).max().unwrap();
                let lowest =
                    marked[plain.len()..].iter().flatten().filter(|p| !p.is_control).map(|point| point.y).min();
                assert!(lowest.unwrap() > top, "{letter}");
            }
        }
        assert_eq!(marked_strokes('x'), strokes(glyph('x').1));
    }
}
