//! Where each key stands in the user's files, and complaints as messages that point there.

use crate::base::diagnostic::{Diagnostic, Fault, Place};
use crate::base::settings::Complaint;
use std::collections::BTreeMap;
use std::ops::Range;

/// Places by dotted path; entries of lists are `tree.rules.0`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Places(pub(super) BTreeMap<String, Place>);

impl Places {
    /// The place of a key, or of the nearest table around it.
    #[must_use]
    pub fn of(&self, path: &str) -> Option<Place> {
        self.nearest(path).map(|(_, place)| place.clone())
    }

    /// The nearest known key at or above a path.
    fn nearest<'a>(&'a self, path: &'a str) -> Option<(&'a str, &'a Place)> {
        let mut path = path;
        loop {
            if let Some(place) = self.0.get(path) {
                return Some((path, place));
            }
            path = path.rsplit_once('.')?.0;
        }
    }

    /// A complaint about `table` (empty for the scene itself) as a message, with its dotted path.
    #[must_use]
    pub fn diagnostic(&self, table: &str, complaint: Complaint) -> (String, Diagnostic) {
        let key = dotted(&complaint.key);
        let parts = [table, &key].into_iter().filter(|part| !part.is_empty());
        let path = parts.collect::<Vec<_>>().join(".");
        let found = self.nearest(&path);
        let is_exact = found.is_some_and(|(known, _)| known == path);
        let message = if is_exact { complaint.message } else { format!("`{path}`: {}", complaint.message) };
        let place = found.map(|(_, place)| match complaint.within {
            Some(within) if is_exact => inside(place, &within),
            _ => place.clone(),
        });
        (path, Diagnostic::error(Fault::Scene, message, complaint.help).at(place))
    }
}

/// `rules[3]` as `rules.3`.
fn dotted(key: &str) -> String {
    key.replace('[', ".").replace(']', "")
}

/// The part `within` of a string's value, as a place: past its quote, and past escapes that are longer than what they mean.
fn inside(place: &Place, within: &Range<usize>) -> Place {
    let raw = &place.source.text[place.span.clone()];
    let (opening, escapes) = opening(raw);
    let at = |wanted: usize| place.span.start + opening + raw_offset(&raw[opening..], wanted, escapes);
    let (start, end) = (at(within.start), at(within.end));
    Place { source: place.source.clone(), span: start..end.max(start) }
}

/// Bytes of the opening quote (with the line break that TOML drops after it), and whether the string has escapes.
fn opening(raw: &str) -> (usize, bool) {
    for (quote, escapes) in [("\"\"\"", true), ("'''", false)] {
        if let Some(rest) = raw.strip_prefix(quote) {
            let newline = if rest.starts_with("\r\n") { 2 } else { usize::from(rest.starts_with('\n')) };
            return (3 + newline, escapes);
        }
    }
    (usize::from(raw.starts_with(['"', '\''])), raw.starts_with('"'))
}

/// The byte of the raw text at which byte `wanted` of the value begins.
fn raw_offset(raw: &str, wanted: usize, escapes: bool) -> usize {
    let (mut offset, mut decoded) = (0, 0);
    while offset < raw.len() {
        let (consumed, meant) = unit(&raw[offset..], escapes);
        if decoded >= wanted && meant > 0 {
            break;
        }
        offset += consumed;
        decoded += meant;
    }
    offset.min(raw.len())
}

/// Bytes of the next character or escape, and bytes of what it means.
fn unit(raw: &str, escapes: bool) -> (usize, usize) {
    let first = raw.chars().next().map_or(1, char::len_utf8);
    if !escapes || !raw.starts_with('\\') {
        return (first, first);
    }
    let after = raw[1..].chars().next().unwrap_or('\\');
    let digits = match after {
        'x' => 2,
        'u' => 4,
        'U' => 8,
        _ if after.is_whitespace() => {
            let folded = raw[1..].len() - raw[1..].trim_start().len();
            return (1 + folded, 0);
        }
        _ => return (1 + after.len_utf8(), 1),
    };
    let code = raw.get(2..2 + digits).and_then(|hex| u32::from_str_radix(hex, 16).ok()).and_then(char::from_u32);
    (2 + digits, code.map_or(1, char::len_utf8))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::diagnostic::Source;
    use std::sync::Arc;

    fn part(raw: &str, within: Range<usize>) -> String {
        let source = Arc::new(Source { name: String::new(), text: format!("k = {raw}") });
        let place = inside(&Place { source, span: 4..4 + raw.len() }, &within);
        place.source.text[place.span].to_owned()
    }

    #[test]
    fn parts_of_strings_are_found_behind_quotes_and_escapes() {
        assert_eq!(part("\"A -> F[F\"", 5..9), "F[F\"");
        assert_eq!(part("\"A -> F[F\"", 6..7), "[");
        assert_eq!(part("'A -> F[F'", 6..7), "[");
        assert_eq!(part("\"\\u00e9\\t[\"", 3..4), "[");
        assert_eq!(part("\"\"\"\nab\\\n  [\"\"\"", 2..3), "[");
        assert_eq!(part("word", 1..2), "o");
    }

    #[test]
    fn the_nearest_known_table_stands_in_for_an_absent_key() {
        let source = Arc::new(Source { name: String::new(), text: "[tree]".to_owned() });
        let places = Places(BTreeMap::from([("tree".to_owned(), Place { source, span: 1..5 })]));
        let (path, diagnostic) = places.diagnostic("tree", Complaint::new("rules[2]", "open bracket", "close it"));
        assert_eq!(path, "tree.rules.2");
        assert_eq!(diagnostic.message, "`tree.rules.2`: open bracket");
        assert_eq!(diagnostic.place.map(|place| place.span), Some(1..5));
        assert_eq!(Places::default().nearest("a.b"), None);
    }
}
