//! `--set KEY=VALUE`: one line of TOML above the scene. A value that is not TOML is taken as a word, so that a shell's
//! quotes need no quoting: `--set leaf.picture=grape.jpg`.

use super::checker::Checker;
use super::document;
use crate::base::diagnostic::{Diagnostic, Fault, Place, Source};
use crate::base::limits::Limits;
use crate::base::message::shown;
use crate::base::settings::Schema;
use serde_json::Value;
use std::sync::Arc;

/// Reads one assignment: what is right of it, and the checker with its places and faults.
///
/// # Errors
/// It is not an assignment.
pub fn read<'a>(
    source: &'a Arc<Source>,
    schema: &'a Schema,
    limits: &'a Limits,
) -> Result<(Value, Checker<'a>), Vec<Diagnostic>> {
    let text = source.text.as_str();
    let fault = |what: &str, help: &str| {
        let place = Place { source: source.clone(), span: 0..text.len() };
        vec![Diagnostic::error(Fault::Scene, what, help).at(Some(place))]
    };
    let Some((key, value)) = text.split_once('=') else {
        let what = format!("--set {} has no value", shown(text, 60));
        return Err(vec![Diagnostic::error(Fault::Usage, what, "write --set KEY=VALUE")]);
    };
    if text.contains('\n') {
        return Err(fault("an assignment is one line", "give each key a --set of its own"));
    }
    if value.trim().is_empty() {
        return Err(fault("there is no value", "write KEY=VALUE; an empty text is KEY=''"));
    }
    let mut checker = Checker::new(source, schema, limits);
    let plain = document::parse(source);
    if plain.faults.is_empty() {
        return Ok((checker.walk(plain.table.get_ref()), checker));
    }
    let quoted = if is_word(value) { quote(key, value) } else { None };
    let Some(quoted) = quoted else { return Err(plain.faults) };
    let quoted = Arc::new(Source { name: source.name.clone(), text: quoted });
    let worded = document::parse(&quoted);
    if !worded.faults.is_empty() {
        return Err(plain.faults);
    }
    Ok((checker.walk(worded.table.get_ref()), checker))
}

/// A source for an assignment.
#[must_use]
pub fn source(assignment: &str) -> Arc<Source> {
    Arc::new(Source { name: format!("--set {assignment}"), text: assignment.to_owned() })
}

/// Whether a value may be a bare word: it does not begin like a string, list or table of TOML.
fn is_word(value: &str) -> bool {
    !value.trim_start().starts_with(['"', '\'', '[', '{', '=']) && !value.chars().any(char::is_control)
}

/// The assignment with its value as a literal string, in which nothing is escaped; places up to the value stay.
fn quote(key: &str, value: &str) -> Option<String> {
    let word = value.trim();
    let indent = &value[..value.len() - value.trim_start().len()];
    (!word.contains('\'')).then(|| format!("{key}={indent}'{word}'"))
}
