//! A TOML text with the place of every value, and the faults of its syntax.

use crate::base::diagnostic::{Diagnostic, Fault, Place, Source};
use std::sync::Arc;
use toml::Spanned;
use toml::de::DeTable;

/// Syntax faults that are told of one text; later ones tend to follow from the first.
const MOST: usize = 20;

/// Bytes of a text in which parsing goes on after a fault; a larger one could hold more faults than memory.
const RECOVERED: usize = 1_000_000;

/// The table of a text and its syntax faults.
pub struct Document<'a> {
    /// What could be read.
    pub table: Spanned<DeTable<'a>>,
    /// Syntax faults, one a line.
    pub faults: Vec<Diagnostic>,
    /// Whether the table can be relied on: the only faults are keys given twice.
    pub is_sound: bool,
}

/// Parses a text.
#[must_use]
pub fn parse(source: &Arc<Source>) -> Document<'_> {
    let (table, errors) = if source.text.len() <= RECOVERED {
        DeTable::parse_recoverable(&source.text)
    } else {
        match DeTable::parse(&source.text) {
            Ok(table) => (table, Vec::new()),
            Err(error) => (Spanned::new(0..0, DeTable::new()), vec![error]),
        }
    };
    let is_whole = source.text.len() <= RECOVERED || errors.is_empty();
    let is_sound = is_whole && errors.iter().all(|error| error.message() == "duplicate key");
    let mut faults: Vec<Diagnostic> = Vec::new();
    let mut last_line = None;
    for error in errors.iter().take(1000) {
        // the crate gives no place to what lies too deep
        let mut span = error.span().unwrap_or(0..0);
        if error.message().contains("escape")
            && source.text.get(..span.start).is_some_and(|before| before.ends_with('\\'))
        {
            // the crate points behind the backslash
            span.start -= 1;
        }
        let line = source.text.as_bytes()[..span.start.min(source.text.len())].iter().filter(|b| **b == b'\n').count();
        if last_line != Some(line) && faults.len() < MOST {
            let message = format!("this is not TOML: {}", error.message());
            let place = Place { source: source.clone(), span };
            faults.push(Diagnostic::error(Fault::Scene, message, help(error.message())).at(Some(place)));
        }
        last_line = Some(line);
    }
    Document { table, faults, is_sound }
}

/// How to mend a syntax fault.
fn help(message: &str) -> &'static str {
    let hints = [
        ("escape", "in \"...\" a backslash begins an escape: write paths in '...' or with /"),
        ("duplicate key", "keep one of the two"),
        ("recursion", "lists and tables lie too deep in one another: at most 80 levels"),
        ("string values must be quoted", "put text in quotes: key = \"text\""),
        ("string", "end the string with the quote it began with, on the same line"),
        ("key with no value", "write `key = value`"),
        ("=", "write `key = value`"),
    ];
    let known = hints.iter().find(|(part, _)| message.contains(part));
    known.map_or("write `key = value` lines below [table] headings", |(_, hint)| hint)
}
