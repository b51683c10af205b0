//! The font: letters as strokes on a grid.
//!
//! A glyph is its advance and its strokes, parted by `;`. A point is two digits to the base 36, x to the right and y up.
//! `~` before a point makes it a control point: the quadratic curve from the point before it to the point after it. A
//! control at the corner of a box joins the middles of two sides by nearly a quarter of an ellipse, a little fuller.
//!
//! The base line is at y = 4, small letters reach 14 (`e`), capitals 18 (`i`), descenders 0. The proportions are those of
//! the common grotesques (advances within a tenth of theirs), so that what is laid out for one font fits the other.

/// Grid units in a font size of 1.
pub(super) const UNITS: f64 = 21.5;
/// The width of a stroke in units.
pub(super) const STROKE: f64 = 1.7;
/// What is added to every advance, in units.
pub(super) const TRACKING: f64 = 0.6;
/// Heights of the strokes that should fall on whole pixels: descender, base line, bar of `e`, bar of `H`, `x`, `H`.
pub(super) const LINES: [f64; 6] = [0.0, 4.0, 9.0, 11.0, 14.0, 18.0];
/// The base line among them.
pub(super) const BASE: f64 = 4.0;

/// A point of a stroke.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Point {
    /// In units.
    pub(super) x: u8,
    /// In units from the descenders' depth upwards.
    pub(super) y: u8,
    pub(super) is_control: bool,
}

/// The advance in units and the strokes of a letter; a box for one that is not in the table.
pub(super) fn glyph(letter: char) -> (f64, &'static str) {
    let found = GLYPHS.iter().find(|(known, _, _)| *known == letter);
    found.map_or((12.0, "25 2h ah a5 25"), |&(_, advance, strokes)| (f64::from(advance), strokes))
}

/// The strokes of a table entry, each a row of points.
pub(super) fn strokes(table: &str) -> Vec<Vec<Point>> {
    let mut strokes: Vec<Vec<Point>> = vec![];
    for stroke in table.split(';').filter(|stroke| !stroke.is_empty()) {
        strokes.push(stroke.split_whitespace().filter_map(point).collect());
    }
    strokes
}

fn point(token: &str) -> Option<Point> {
    let is_control = token.starts_with('~');
    let mut digits = token.chars().filter_map(|c| c.to_digit(36)).map(|digit| digit as u8);
    Some(Point { x: digits.next()?, y: digits.next()?, is_control })
}

#[rustfmt::skip]
const GLYPHS: &[(char, u8, &str)] = &[
    (' ', 6, ""),
    ('0', 12, "6i ~ai ab ~a4 64 ~24 2b ~2i 6i"),
    ('1', 12, "3f 7i 74"),
    ('2', 12, "2e ~2i 6i ~ai ae ~ab 24 a4"),
    ('3', 12, "2f ~3i 6i ~9i 9e ~9b 5b ~ab a7 ~a4 64 ~34 27"),
    ('4', 12, "84 8i 18 b8"),
    ('5', 12, "9i 3i 2b ~4d 6d ~ad a8 ~a4 64 ~34 27"),
    ('6', 12, "9g ~8i 6i ~2i 2a ~24 64 ~a4 a8 ~ad 6d ~2d 29"),
    ('7', 12, "2i ai ~6c 54"),
    ('8', 12, "6i ~9i 9e ~9b 6b ~3b 3e ~3i 6i;6b ~ab a7 ~a4 64 ~24 27 ~2b 6b"),
    ('9', 12, "36 ~44 64 ~a4 ac ~ai 6i ~2i 2e ~29 69 ~a9 ad"),
    ('A', 14, "14 7i d4;39 b9"),
    ('B', 14, "24 2i 7i ~bi be ~bb 7b 2b;7b ~cb c7 ~c4 74 24"),
    ('C', 15, "df ~bi 8i ~2i 2b ~24 84 ~b4 d7"),
    ('D', 15, "24 2i 7i ~di db ~d4 74 24"),
    ('E', 13, "bi 2i 24 b4;2b ab"),
    ('F', 12, "bi 2i 24;2b 9b"),
    ('G', 16, "df ~bi 8i ~2i 2b ~24 84 ~e4 eb 9b"),
    ('H', 15, "2i 24;di d4;2b db"),
    ('I', 6, "3i 34"),
    ('J', 10, "8i 88 ~84 54 ~24 28"),
    ('K', 14, "2i 24;bi 29;5c c4"),
    ('L', 12, "2i 24 a4"),
    ('M', 18, "24 2i 96 gi g4"),
    ('N', 15, "24 2i d4 di"),
    ('O', 16, "8i ~ei eb ~e4 84 ~24 2b ~2i 8i"),
    ('P', 13, "24 2i 7i ~ci ce ~ca 7a 2a"),
    ('Q', 16, "8i ~ei eb ~e4 84 ~24 2b ~2i 8i;a7 f3"),
    ('R', 14, "24 2i 7i ~ci ce ~ca 7a 2a;7a c4"),
    ('S', 13, "bf ~ai 6i ~2i 2e ~2c 6b ~ba b7 ~b4 64 ~24 27"),
    ('T', 12, "1i bi;6i 64"),
    ('U', 14, "2i 29 ~24 74 ~c4 c9 ci"),
    ('V', 14, "1i 74 di"),
    ('W', 20, "1i 54 ai f4 ji"),
    ('X', 14, "2i c4;ci 24"),
    ('Y', 14, "1i 7b di;7b 74"),
    ('Z', 13, "2i bi 24 b4"),
    ('a', 12, "2c ~3e 6e ~9e 9a 94;9a 6a ~2a 27 ~24 54 ~94 98"),
    ('b', 12, "2i 24;29 ~2e 6e ~ae a9 ~a4 64 ~24 29"),
    ('c', 11, "9c ~8e 6e ~2e 29 ~24 64 ~84 96"),
    ('d', 12, "ai a4;a9 ~ae 6e ~2e 29 ~24 64 ~a4 a9"),
    ('e', 12, "29 a9 ~ae 6e ~2e 29 ~24 64 ~94 a6"),
    ('f', 7, "6i ~3i 3f 34;1e 6e"),
    ('g', 12, "ae a4 ~a0 60 ~30 22;a9 ~ae 6e ~2e 29 ~24 64 ~a4 a9"),
    ('h', 12, "2i 24;2a ~2e 6e ~ae aa a4"),
    ('i', 4, "2e 24;2i 2j"),
    ('j', 5, "3e 32 ~30 10;3i 3j"),
    ('k', 11, "2i 24;9e 28;5b a4"),
    ('l', 4, "2i 24"),
    ('m', 18, "2e 24;2a ~2e 6e ~9e 9a 94;9a ~9e de ~ge ga g4"),
    ('n', 12, "2e 24;2a ~2e 6e ~ae aa a4"),
    ('o', 12, "6e ~ae a9 ~a4 64 ~24 29 ~2e 6e"),
    ('p', 12, "2e 20;29 ~2e 6e ~ae a9 ~a4 64 ~24 29"),
    ('q', 12, "ae a0;a9 ~ae 6e ~2e 29 ~24 64 ~a4 a9"),
    ('r', 8, "2e 24;29 ~2e 7e"),
    ('s', 11, "9c ~8e 5e ~2e 2b ~2a 59 ~98 97 ~94 54 ~24 26"),
    ('t', 7, "3h 37 ~34 64;1e 6e"),
    ('u', 12, "2e 28 ~24 64 ~a4 a8;ae a4"),
    ('v', 10, "1e 54 9e"),
    ('w', 14, "1e 44 7e a4 de"),
    ('x', 10, "1e 94;9e 14"),
    ('y', 10, "1e 54;9e 30"),
    ('z', 10, "1e 9e 14 94"),
    ('.', 5, "24 25"),
    (',', 5, "25 24 12"),
    (':', 5, "24 25;2c 2d"),
    (';', 5, "25 24 12;2c 2d"),
    ('!', 5, "2i 29;24 25"),
    ('?', 11, "2f ~2i 5i ~9i 9f ~9c 5a 58;54 55"),
    ('\'', 4, "2i 2f"),
    ('"', 7, "2i 2f;5i 5f"),
    ('-', 7, "19 69"),
    ('\u{2212}', 12, "29 a9"),
    ('\u{2013}', 12, "19 b9"),
    ('+', 12, "29 a9;6d 65"),
    ('=', 12, "27 a7;2b ab"),
    ('\u{d7}', 12, "36 9c;3c 96"),
    ('\u{b7}', 5, "29 2a"),
    ('%', 19, "5i ~8i 8f ~8c 5c ~2c 2f ~2i 5i;ea ~ha h7 ~h4 e4 ~b4 b7 ~ba ea;ei 54"),
    ('\u{b0}', 8, "4i ~6i 6g ~6e 4e ~2e 2g ~2i 4i"),
    ('(', 7, "6k ~2g 2a ~24 60"),
    (')', 7, "1k ~5g 5a ~54 10"),
    ('[', 7, "5j 2j 21 51"),
    (']', 7, "2j 5j 51 21"),
    ('/', 7, "12 6i"),
    ('\\', 7, "1i 62"),
    ('|', 5, "2j 20"),
    ('\u{2014}', 18, "19 h9"),
    ('ı', 4, "2e 24"),
    ('ß', 12, "24 2f ~2i 6i ~9i 9f ~9c 6b ~ab a7 ~a4 54"),
    ('ø', 12, "6e ~ae a9 ~a4 64 ~24 29 ~2e 6e;24 ae"),
    ('Ø', 16, "8i ~ei eb ~e4 84 ~24 2b ~2i 8i;34 di"),
    ('æ', 18, "2c ~3e 6e ~9e 9a 94;9a 6a ~2a 27 ~24 54 ~94 98;99 g9 ~ge de ~9e 9a;98 ~94 d4 ~f4 g6"),
    ('ç', 11, "9c ~8e 6e ~2e 29 ~24 64 ~84 96;64 62 ~71 50"),
    ('Ç', 15, "df ~bi 8i ~2i 2b ~24 84 ~b4 d7;84 82 ~91 70"),
    ('_', 12, "01 c1"),
    ('^', 12, "2c 6i ac"),
    ('~', 12, "29 ~4d 6a ~87 ab"),
    ('*', 9, "4i 4c;1h 7d;7h 1d"),
    ('#', 12, "42 6i;82 ai;27 b7;2d bd"),
    ('<', 12, "a5 29 ad"),
    ('>', 12, "25 a9 2d"),
    ('&', 15, "d4 4e ~3i 6i ~9i 8e ~8d 5b ~2a 27 ~24 64 ~a4 cb"),
    ('\u{b2}', 9, "1f ~1i 4i ~7i 7f ~7d 19 79"),
    ('\u{b3}', 9, "1g ~2i 4i ~6i 6g ~6e 3e ~7e 7b ~79 49 ~19 1b"),
    ('\u{2026}', 14, "24 25;74 75;c4 c5"),
    ('\u{b5}', 12, "2e 20;28 ~24 64 ~a4 a8;ae a4"),
    ('\u{394}', 14, "14 7i d4 14"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_stroke_begins_and_ends_on_the_curve_within_its_advance() {
        for &(letter, advance, table) in GLYPHS {
            for stroke in strokes(table) {
                assert!(stroke.len() > 1, "{letter}");
                assert!(!stroke[0].is_control && !stroke[stroke.len() - 1].is_control, "{letter}");
                assert!(stroke.windows(2).all(|pair| !(pair[0].is_control && pair[1].is_control)), "{letter}");
                assert!(stroke.iter().all(|point| point.x <= advance && point.y <= 20), "{letter}");
            }
            let points: usize = strokes(table).iter().map(Vec::len).sum();
            assert_eq!(points, table.replace(';', " ").split_whitespace().count(), "{letter}: each token is a point");
        }
    }

    #[test]
    fn letters_stand_once_and_differ() {
        for (at, one) in GLYPHS.iter().enumerate() {
            for other in &GLYPHS[at + 1..] {
                assert!(one.0 != other.0 && one.2 != other.2, "{} {}", one.0, other.0);
            }
        }
    }

    #[test]
    fn all_that_labels_need_is_there() {
        let needed = ('0'..='9').chain('a'..='z').chain('A'..='Z').chain(" .,-+%°()/:=²×^−…".chars());
        let missing: String = needed.filter(|&letter| !GLYPHS.iter().any(|(known, _, _)| *known == letter)).collect();
        assert_eq!(missing, "");
    }
}
