//! Names and captions as they may be written: cleaned, measured, cut to a width, with raised powers.

use super::letters::{TRACKING, UNITS, glyph};
use super::marks;

/// The size of a power in relation to the letters that it stands at.
pub(super) const POWER_SIZE: f64 = 0.72;
/// How far a power is raised, in sizes of those letters.
pub(super) const POWER_RISE: f64 = 0.36;
/// How much wider than our own a reader's font may be.
const RESERVE: f64 = 1.1;

/// Part of a text: letters on the base line, or a power above it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Run {
    pub(super) text: String,
    pub(super) is_power: bool,
}

/// A name on one line: what is no letter (control characters, line ends, marks of direction, characters that XML forbids)
/// becomes a blank, and blanks are not repeated.
pub(super) fn cleaned(name: &str) -> String {
    let is_letter = |c: char| !c.is_control() && !c.is_whitespace() && !is_unseen(c);
    name.split(|c| !is_letter(c)).filter(|word| !word.is_empty()).collect::<Vec<_>>().join(" ")
}

fn is_unseen(c: char) -> bool {
    matches!(c, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}')
        || u32::from(c) & 0xfffe == 0xfffe
}

/// The runs of a text: `^` before a whole number, with or without a sign, raises it.
pub(super) fn runs(text: &str) -> Vec<Run> {
    let mut runs: Vec<Run> = vec![];
    let mut rest = text;
    while let Some(at) = rest.find('^') {
        let (before, after) = (&rest[..at], &rest[at + 1..]);
        let power = power_length(after);
        let kept = if power == 0 { &rest[..=at] } else { before };
        runs.push(Run { text: kept.to_owned(), is_power: false });
        runs.push(Run { text: after[..power].to_owned(), is_power: true });
        rest = &after[power..];
    }
    runs.push(Run { text: rest.to_owned(), is_power: false });
    runs.retain(|run| !run.text.is_empty());
    runs
}

/// Bytes of the whole number that a text begins with; 0 when it does not.
fn power_length(text: &str) -> usize {
    let sign = text.chars().next().filter(|c| matches!(c, '-' | '\u{2212}')).map_or(0, char::len_utf8);
    let digits = text[sign..].bytes().take_while(u8::is_ascii_digit).count();
    if digits == 0 { 0 } else { sign + digits }
}

/// The width of a text in our font, in pixels.
pub(super) fn width(text: &str, size: f64) -> f64 {
    let run_width = |run: &Run| {
        let units: f64 = run.text.chars().map(|letter| glyph(marks::base(letter)).0 + TRACKING).sum();
        units * if run.is_power { POWER_SIZE } else { 1.0 }
    };
    runs(text).iter().map(run_width).sum::<f64>() * size / UNITS
}

/// The width to keep free for a text in whatever font, in pixels.
pub(super) fn room(text: &str, size: f64) -> f64 {
    width(text, size) * RESERVE
}

/// The text, or as much of its beginning as `limit` pixels hold with an ellipsis; nothing when not even that fits.
pub(super) fn cut(text: &str, size: f64, limit: f64) -> String {
    if room(text, size) <= limit {
        return text.to_owned();
    }
    let letters: Vec<char> = text.chars().collect();
    let shortened = |kept: usize| letters[..kept].iter().collect::<String>().trim_end().to_owned() + "\u{2026}";
    // Bisection: the width grows with the letters, but for a caret that becomes a power, which only makes it shorter.
    let (mut fits, mut over) = (0, letters.len().min(4096));
    while over - fits > 1 {
        let middle = usize::midpoint(fits, over);
        if room(&shortened(middle), size) <= limit { fits = middle } else { over = middle }
    }
    if room(&shortened(fits), size) <= limit { shortened(fits) } else { String::new() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_one_line_of_letters() {
        assert_eq!(cleaned(" a\u{0}b\n\tc\u{202e}d\u{ffff} <é> "), "a b c d <é>");
        assert_eq!(cleaned("\u{7}\n"), "");
    }

    #[test]
    fn carets_raise_whole_numbers_only() {
        let of = |text| runs(text).into_iter().map(|run| (run.text, run.is_power)).collect::<Vec<_>>();
        let run = |text: &str, is_power| (text.to_owned(), is_power);
        assert_eq!(of("2×10^\u{2212}12 s"), [run("2×10", false), run("\u{2212}12", true), run(" s", false)]);
        assert_eq!(of("^2"), [run("2", true)]);
        assert_eq!(of("a^b^"), [run("a^", false), run("b^", false)]);
        assert_eq!(of("x^-"), [run("x^", false), run("-", false)]);
    }

    #[test]
    fn what_is_cut_fits_and_is_as_long_as_it_can_be() {
        let name = "a name that no legend of this world has the room to write out";
        for limit in [0.0, 5.0, 40.0, 100.0, 1000.0] {
            let cut = cut(name, 14.0, limit);
            assert!(room(&cut, 14.0) <= limit.max(0.0));
            assert_eq!(cut == name, room(name, 14.0) <= limit);
        }
        assert_eq!(cut("abcdef", 14.0, room("abc\u{2026}", 14.0)), "abc\u{2026}");
    }
}
