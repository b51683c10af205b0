//! A place in the text of a rule or axiom, and the faults found there. Bytes are counted, so that a message can point at them.

use std::ops::Range;

/// Something wrong in a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Fault {
    /// The bytes meant.
    pub within: Range<usize>,
    /// What is wrong.
    pub message: String,
    /// How to mend it.
    pub help: String,
}

impl Fault {
    pub fn new(within: Range<usize>, message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { within, message: message.into(), help: help.into() }
    }
}

/// Reads a text from left to right; spaces between tokens are skipped.
#[derive(Clone, Debug)]
pub(super) struct Cursor<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Cursor<'a> {
    pub fn new(text: &'a str) -> Self {
        Self { text, at: 0 }
    }

    /// The byte where the next token starts.
    pub fn place(&mut self) -> usize {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
        self.at
    }

    /// The byte after the last token taken.
    pub fn end(&self) -> usize {
        self.at
    }

    /// The next character that is not a space.
    pub fn peek(&mut self) -> Option<char> {
        let start = self.place();
        self.text[start..].chars().next()
    }

    pub fn take(&mut self) -> Option<char> {
        let next = self.peek()?;
        self.at += next.len_utf8();
        Some(next)
    }

    /// Whether `token` comes next.
    pub fn sees(&mut self, token: &str) -> bool {
        let start = self.place();
        self.text[start..].starts_with(token)
    }

    /// Takes `token` if it comes next.
    pub fn accept(&mut self, token: &str) -> bool {
        let seen = self.sees(token);
        if seen {
            self.at += token.len();
        }
        seen
    }

    /// Takes `token` or says that it is missing.
    pub fn expect(&mut self, token: &str, why: &str) -> Result<(), Fault> {
        if self.accept(token) {
            return Ok(());
        }
        let here = self.next_range();
        Err(Fault::new(here, format!("`{token}` is missing here"), why))
    }

    /// The range of the next character, empty at the end of the text.
    pub fn next_range(&mut self) -> Range<usize> {
        let start = self.place();
        start..start + self.peek().map_or(0, char::len_utf8)
    }

    /// The longest run of characters that `wanted` accepts.
    pub fn run(&mut self, wanted: impl Fn(char) -> bool) -> (&'a str, Range<usize>) {
        let start = self.place();
        let rest = &self.text[start..];
        let length = rest.find(|c| !wanted(c)).unwrap_or(rest.len());
        self.at = start + length;
        (&rest[..length], start..start + length)
    }

    /// A number without sign: digits, a point, an exponent. Nothing is taken when there is none.
    pub fn number(&mut self) -> Option<(f64, Range<usize>)> {
        let start = self.place();
        let bytes = &self.text.as_bytes()[start..];
        let digits = |from: usize| bytes[from..].iter().take_while(|b| b.is_ascii_digit()).count();
        let mut length = digits(0);
        if bytes.get(length) == Some(&b'.') {
            length += 1 + digits(length + 1);
        }
        if matches!(bytes.get(length), Some(b'e' | b'E')) {
            let sign = usize::from(matches!(bytes.get(length + 1), Some(b'+' | b'-')));
            let exponent = digits((length + 1 + sign).min(bytes.len()));
            length += if exponent > 0 { 1 + sign + exponent } else { 0 };
        }
        let value = self.text[start..start + length].parse().ok()?;
        self.at = start + length;
        Some((value, start..start + length))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stop_where_they_end() {
        let mut cursor = Cursor::new(" 1.5e3x 2e+ .5 .");
        assert_eq!(cursor.number(), Some((1500.0, 1..6)));
        assert_eq!(cursor.number(), None);
        assert_eq!(cursor.take(), Some('x'));
        assert_eq!(cursor.number(), Some((2.0, 8..9)));
        assert_eq!(cursor.run(|c| c.is_ascii_alphabetic()).0, "e");
        assert!(cursor.accept("+"));
        assert_eq!(cursor.number(), Some((0.5, 12..14)));
        assert_eq!(cursor.number(), None);
    }
}
