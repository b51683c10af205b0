//! Diagnostics as text: `file:line:column: error: what; how to mend it`, the source line, and a caret.
//!
//! Lines and columns are looked up by codespan-reporting. Its own renderer is not used: it passes control characters and
//! changes of writing direction through to the terminal, prints lines of any length whole, and begins with the message
//! instead of the place that editors and farms look for. No text of the user's begins a line here: a file's line stands
//! behind its number, and a file name that could be read as a command to a farm is written with `./`.

use crate::base::diagnostic::{Diagnostic, Place, Severity};
use codespan_reporting::files::{Files, SimpleFile};
use std::fmt::Write;

/// Longest text of several messages together, in bytes.
pub const LONGEST: usize = 8000;
/// Room for the sentence that counts the messages left out, in bytes.
const CLOSING: usize = 100;
/// Characters of a source line that are shown.
const WINDOW: usize = 100;
/// Characters of the source line shown before the fault when the line is cut.
const BEFORE: usize = 40;
/// Longest name of a file, message and help, in characters.
const LONGEST_NAME: usize = 200;
const LONGEST_MESSAGE: usize = 500;
const LONGEST_HELP: usize = 400;

/// The message as text, ending in a newline.
#[must_use]
pub fn render(diagnostic: &Diagnostic) -> String {
    let word = match diagnostic.severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
    };
    let spot = diagnostic.place.as_ref().map(Spot::of);
    let mut text = String::new();
    if let (Some(spot), Some(place)) = (&spot, &diagnostic.place) {
        let _ = write!(text, "{}:{}:{}: ", file_name(&place.source.name), spot.line, spot.column);
    }
    let _ = write!(text, "{word}: {}", shown(&diagnostic.message, LONGEST_MESSAGE));
    if !diagnostic.help.is_empty() {
        let _ = write!(text, "; {}", shown(&diagnostic.help, LONGEST_HELP));
    }
    text.push('\n');
    if let Some(spot) = spot {
        text.push_str(&spot.excerpt());
    }
    text
}

/// Several messages, at most [`LONGEST`] bytes of them; the rest are counted.
#[must_use]
pub fn render_all(diagnostics: &[Diagnostic]) -> String {
    let mut text = String::new();
    for (index, diagnostic) in diagnostics.iter().enumerate() {
        let next = render(diagnostic);
        if text.len() + next.len() + CLOSING > LONGEST {
            let rest = diagnostics.len() - index;
            let _ = writeln!(text, "{rest} more such messages are not shown");
            break;
        }
        text.push_str(&next);
    }
    text
}

/// The user's text with control characters and changes of writing direction escaped, cut to `longest` characters.
#[must_use]
pub fn shown(text: &str, longest: usize) -> String {
    let mut result = String::new();
    let mut room = longest;
    for character in text.chars() {
        let piece = escaped(character);
        let width = piece.chars().count();
        if width > room {
            result.push('…');
            break;
        }
        room -= width;
        result.push_str(&piece);
    }
    result
}

/// One character, escaped when it would act on the terminal instead of being seen.
fn escaped(character: char) -> String {
    match character {
        '\n' => "\\n".to_owned(),
        '\r' => "\\r".to_owned(),
        '\t' => "\\t".to_owned(),
        _ if character.is_control() || invisible(character) => format!("\\u{{{:x}}}", u32::from(character)),
        _ => character.to_string(),
    }
}

/// Marks of writing direction, line and paragraph separators, zero-width characters (Unicode 16, general categories Cf,
/// Zl and Zp, as far as they change how other text is shown).
fn invisible(character: char) -> bool {
    matches!(u32::from(character), 0x061c | 0x200b..=0x200f | 0x2028..=0x202e | 0x2060..=0x206f | 0xfeff | 0xe0000..=0xe007f)
}

/// A file's name as the beginning of a line: escaped, and never a word that a farm's worker obeys.
fn file_name(name: &str) -> String {
    let shown = shown(name, LONGEST_NAME);
    let plain = shown.starts_with(|c: char| c.is_alphanumeric() || "./-_~".contains(c));
    if plain && !shown.starts_with("openjd") { shown } else { format!("./{shown}") }
}

/// Where a place stands in its text.
struct Spot<'a> {
    /// Line, from 1.
    line: usize,
    /// Column in characters, from 1.
    column: usize,
    /// The line without its end.
    text: &'a str,
    /// Bytes of the line that are meant.
    start: usize,
    end: usize,
}

impl<'a> Spot<'a> {
    fn of(place: &'a Place) -> Self {
        let whole = place.source.text.as_str();
        let at = boundary(whole, place.span.start);
        let file = SimpleFile::new("", whole);
        let index = file.line_index((), at).unwrap_or(0);
        let range = file.line_range((), index).unwrap_or(0..whole.len());
        let text = whole[range.clone()].trim_end_matches(['\n', '\r']);
        let start = (at - range.start).min(text.len());
        let end = boundary(whole, place.span.end).saturating_sub(range.start).clamp(start, text.len());
        Self { line: index + 1, column: file.column_number((), index, at).unwrap_or(1), text, start, end }
    }

    /// The line behind its number, cut to a window around the fault, and carets below.
    fn excerpt(&self) -> String {
        let before = self.text[..self.start].chars().count();
        let from = if self.text.chars().count() > WINDOW { before.saturating_sub(BEFORE) } else { 0 };
        let (mut line, mut caret) = (String::new(), String::new());
        let mut carets = 0;
        if from > 0 {
            line.push('…');
            caret.push(' ');
        }
        let mut characters = self.text.char_indices().skip(from);
        for (at, character) in characters.by_ref().take(WINDOW) {
            let piece = if character == '\t' { "    ".to_owned() } else { escaped(character) };
            let width = piece.chars().count();
            if at < self.start {
                caret.extend(std::iter::repeat_n(' ', width));
            } else if at < self.end {
                carets += width;
            }
            line.push_str(&piece);
        }
        if characters.next().is_some() {
            line.push('…');
        }
        caret.extend(std::iter::repeat_n('^', carets.max(1)));
        let number = self.line.to_string();
        let gutter = " ".repeat(number.len());
        format!("{number} | {line}\n{gutter} | {caret}\n")
    }
}

/// The nearest start of a character at or before `at`.
fn boundary(text: &str, at: usize) -> usize {
    let mut at = at.min(text.len());
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::diagnostic::{Fault, Source};
    use std::sync::Arc;

    fn at(text: &str, span: std::ops::Range<usize>) -> Diagnostic {
        let source = Arc::new(Source { name: "a.toml".to_owned(), text: text.to_owned() });
        Diagnostic::error(Fault::Scene, "what", "mend").at(Some(Place { source, span }))
    }

    #[test]
    fn columns_count_characters_and_carets_stand_below() {
        let text = render(&at("x = 1\nä = \"öö\" # é\n", 11..17));
        assert_eq!(text, "a.toml:2:5: error: what; mend\n2 | ä = \"öö\" # é\n  |     ^^^^\n");
    }

    #[test]
    fn control_characters_and_directions_are_escaped() {
        let mut diagnostic = at("a = \"\u{1b}[2J\u{202e}\"", 4..5);
        diagnostic.message = "line\nopenjd_fail: x\u{7}".to_owned();
        let text = render(&diagnostic);
        assert!(!text.contains(['\u{1b}', '\u{202e}', '\u{7}']));
        assert_eq!(text.lines().count(), 3);
        assert!(text.contains("\\u{1b}[2J\\u{202e}"));
    }

    #[test]
    fn a_long_line_is_cut_around_the_fault_and_the_caret_still_points_at_it() {
        let line = format!("{}X{}", "a".repeat(100_000), "b".repeat(100_000));
        let text = render(&at(&line, 100_000..100_001));
        let lines: Vec<Vec<char>> = text.lines().map(|l| l.chars().collect()).collect();
        let caret = lines[2].iter().position(|c| *c == '^').unwrap();
        assert_eq!(lines[1][caret], 'X');
        assert!(text.len() < 500);
    }

    #[test]
    fn a_place_at_the_end_or_inside_a_character_or_past_the_text_is_taken() {
        assert!(render(&at("", 0..0)).starts_with("a.toml:1:1: "));
        assert!(render(&at("a\n", 2..2)).starts_with("a.toml:2:1: "));
        assert!(render(&at("ä", 1..9)).starts_with("a.toml:1:1: "));
        assert!(render(&at("ab", 70..90)).starts_with("a.toml:1:3: "));
    }

    #[test]
    fn a_file_name_never_begins_with_a_command() {
        let source = Arc::new(Source { name: "openjd_fail: x.toml".to_owned(), text: String::new() });
        let place = Place { source, span: 0..0 };
        let text = render(&Diagnostic::error(Fault::Scene, "w", "").at(Some(place)));
        assert!(text.starts_with("./openjd_fail"));
    }

    #[test]
    fn thousands_of_messages_stay_short_and_are_counted() {
        let one = at(&"\u{1f342}".repeat(1000), 8..16);
        let text = render_all(&vec![one; 5000]);
        assert!(text.len() <= LONGEST);
        let shown = text.matches("error: what").count();
        assert!(shown > 1);
        assert!(text.ends_with(&format!("{} more such messages are not shown\n", 5000 - shown)));
    }

    #[test]
    fn the_largest_single_message_fits() {
        let mut diagnostic = at(&"\u{1f342}".repeat(1000), 8..4000);
        diagnostic.message = "\u{1f342}".repeat(9000);
        diagnostic.help = "\u{1f342}".repeat(9000);
        assert!(render(&diagnostic).len() + CLOSING <= LONGEST);
    }
}
