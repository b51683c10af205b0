//! Walks a spanned TOML table against the schema before it is deserialised, because serde stops at its first error: every
//! unknown key, wrong type, number out of range or not finite, and list of the wrong length is found at once. What is right
//! is handed on as JSON for the layers; what is wrong is left out of it.

use super::{bounds, schema, spelling};
use crate::base::diagnostic::{Diagnostic, Fault, Place, Source};
use crate::base::limits::Limits;
use crate::base::message::shown;
use crate::base::settings::{Key, Kind, Schema};
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

/// Faults kept of one text.
const MOST_FAULTS: usize = 1000;
/// Entries of a list whose places are kept; faults beyond have their place all the same.
const MOST_ENTRIES: usize = 4096;
/// Places kept of one text in all before those of entries are left out.
const MOST_PLACES: usize = 100_000;
/// Characters of the user's words in a message.
const QUOTED: usize = 60;

/// A fault and the key it belongs to.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Number of the species in whose tables it was found; none for the scene's own.
    pub species: Option<usize>,
    /// Dotted path of the key.
    pub path: String,
    /// The message.
    pub diagnostic: Diagnostic,
}

/// The walk through one text.
pub struct Checker<'a> {
    source: &'a Arc<Source>,
    root: &'a Schema,
    limits: &'a Limits,
    /// What is wrong.
    pub findings: Vec<Finding>,
    /// Dotted key path to place.
    pub places: BTreeMap<String, Place>,
}

/// What a value must be.
struct Wanted<'k> {
    path: String,
    kind: &'k Kind,
    range: Option<(f64, f64)>,
    unit: &'static str,
}

impl<'k> Wanted<'k> {
    fn of(key: &'k Key, path: String) -> Self {
        Self { path, kind: &key.kind, range: key.range, unit: key.unit }
    }

    fn inner(&self, name: &str, kind: &'k Kind) -> Self {
        Self { path: format!("{}.{name}", self.path), kind, range: self.range, unit: self.unit }
    }
}

impl<'a> Checker<'a> {
    /// A walk through `source` against `root`.
    #[must_use]
    pub fn new(source: &'a Arc<Source>, root: &'a Schema, limits: &'a Limits) -> Self {
        Self { source, root, limits, findings: Vec::new(), places: BTreeMap::new() }
    }

    /// Walks the whole text; returns what is right of it.
    pub fn walk(&mut self, table: &DeTable<'_>) -> Value {
        self.table(table, self.root, "")
    }

    fn table(&mut self, table: &DeTable<'_>, schema: &Schema, path: &str) -> Value {
        let mut result = Map::new();
        for (name, value) in table {
            let key = schema.keys.iter().find(|key| key.name == name.get_ref().as_ref());
            let inner = if path.is_empty() { name.get_ref().to_string() } else { format!("{path}.{}", name.get_ref()) };
            let Some(key) = key else {
                self.unknown(name, schema, path, &inner);
                continue;
            };
            self.note(&inner, name, value);
            if let Some(value) = self.value(value, &Wanted::of(key, inner)) {
                result.insert(key.name.to_owned(), value);
            }
        }
        Value::Object(result)
    }

    fn map(&mut self, table: &DeTable<'_>, kind: &Kind, wanted: &Wanted<'_>) -> Value {
        let mut result = Map::new();
        for (name, value) in table {
            let inner = wanted.inner(name.get_ref(), kind);
            self.note(&inner.path, name, value);
            if let Some(value) = self.value(value, &inner) {
                result.insert(name.get_ref().to_string(), value);
            }
        }
        Value::Object(result)
    }

    /// Keeps the place of a key: of its value, or of its name when the value is a table.
    fn note(&mut self, path: &str, name: &Spanned<impl AsRef<str>>, value: &Spanned<DeValue<'_>>) {
        let span = if value.get_ref().is_table() { name.span() } else { value.span() };
        self.places.insert(path.to_owned(), self.place(span));
    }

    fn value(&mut self, value: &Spanned<DeValue<'_>>, wanted: &Wanted<'_>) -> Option<Value> {
        match (wanted.kind, value.get_ref()) {
            (Kind::Table(schema), DeValue::Table(table)) => Some(self.table(table, schema, &wanted.path)),
            (Kind::Map(kind), DeValue::Table(table)) => Some(self.map(table, kind, wanted)),
            (Kind::List(kind, least, most), DeValue::Array(list)) => {
                self.list(list, value.span(), wanted, (kind, *least, *most))
            }
            (Kind::Number, DeValue::Integer(_) | DeValue::Float(_)) => self.number(value, wanted),
            (Kind::Integer, DeValue::Integer(_)) => self.integer(value, wanted),
            (Kind::Boolean, DeValue::Boolean(value)) => Some(Value::from(*value)),
            (Kind::Text, DeValue::String(text)) => Some(Value::from(text.as_ref())),
            // TOML has dates of its own: `date = 2017-10-05` without quotes.
            (Kind::Text, DeValue::Datetime(date)) => Some(Value::from(date.to_string())),
            (Kind::Choice(words), DeValue::String(text)) => self.choice(value.span(), text, words, wanted),
            (Kind::Either(kinds), found) => match kinds.iter().find(|kind| suits(kind, found)) {
                Some(kind) => {
                    let inner = Wanted { path: wanted.path.clone(), kind, range: wanted.range, unit: wanted.unit };
                    self.value(value, &inner)
                }
                None => self.wrong_type(value, wanted),
            },
            _ => self.wrong_type(value, wanted),
        }
    }

    fn list(
        &mut self,
        list: &DeArray<'_>,
        span: Range<usize>,
        wanted: &Wanted<'_>,
        (kind, least, most): (&Kind, usize, usize),
    ) -> Option<Value> {
        if list.len() < least || list.len() > most {
            let count = if least == most { format!("{least}") } else { format!("{least} to {most}") };
            let what = format!("`{}` needs {count} values, here are {}", wanted.path, list.len());
            return self.find(span, wanted, what, format!("write {}", noun(wanted.kind)));
        }
        let mut right = Vec::with_capacity(list.len());
        for (index, value) in list.iter().enumerate() {
            let inner = wanted.inner(&index.to_string(), kind);
            if index < MOST_ENTRIES && self.places.len() < MOST_PLACES {
                self.places.insert(inner.path.clone(), self.place(value.span()));
            }
            right.extend(self.value(value, &inner));
        }
        (right.len() == list.len()).then_some(Value::Array(right))
    }

    fn choice(&mut self, span: Range<usize>, text: &str, words: &[&str], wanted: &Wanted<'_>) -> Option<Value> {
        if words.contains(&text) {
            return Some(Value::from(text));
        }
        let what = format!("`{}` cannot be \"{}\"", wanted.path, shown(text, QUOTED));
        let help = match spelling::nearest(text, words.iter().copied()) {
            Some(word) => format!("write \"{word}\""),
            None => format!("write {}", noun(wanted.kind)),
        };
        self.find(span, wanted, what, help)
    }

    fn number(&mut self, value: &Spanned<DeValue<'_>>, wanted: &Wanted<'_>) -> Option<Value> {
        let number = match value.get_ref() {
            DeValue::Integer(digits) => i128::from_str_radix(digits.as_str(), digits.radix()).ok().map(|n| n as f64),
            DeValue::Float(digits) => digits.as_str().parse().ok(),
            _ => None,
        };
        let number = number.unwrap_or(f64::INFINITY);
        if !number.is_finite() {
            let text = shown(&self.source.text[self.place(value.span()).span], QUOTED);
            let what = format!("`{}` must be a finite number, not {text}", wanted.path);
            return self.find(value.span(), wanted, what, allowed(wanted));
        }
        self.in_range(number, value.span(), wanted)?;
        Some(Value::from(number))
    }

    fn integer(&mut self, value: &Spanned<DeValue<'_>>, wanted: &Wanted<'_>) -> Option<Value> {
        let digits = value.get_ref().as_integer()?;
        let number = i128::from_str_radix(digits.as_str(), digits.radix()).unwrap_or(i128::MAX);
        self.in_range(number as f64, value.span(), wanted)?;
        if let Ok(number) = u64::try_from(number) {
            return Some(Value::from(number));
        }
        if let Ok(number) = i64::try_from(number) {
            return Some(Value::from(number));
        }
        self.find(value.span(), wanted, format!("`{}` is too large", wanted.path), allowed(wanted))
    }

    /// A limit of the operator's comes before the range, so that the message names the flag.
    fn in_range(&mut self, number: f64, span: Range<usize>, wanted: &Wanted<'_>) -> Option<()> {
        if let Err(refusal) = bounds::key(self.limits, &wanted.path, number) {
            let diagnostic = Diagnostic::error(Fault::Limit, refusal.to_string(), refusal.help());
            return self.add(&wanted.path, diagnostic.at(Some(self.place(span))));
        }
        match wanted.range {
            Some((low, high)) if number < low || number > high => {
                let what = format!("`{}` is {number}, outside {} to {}", wanted.path, written(low), written(high));
                self.find(span, wanted, what, allowed(wanted))
            }
            _ => Some(()),
        }
    }

    fn wrong_type<T>(&mut self, value: &Spanned<DeValue<'_>>, wanted: &Wanted<'_>) -> Option<T> {
        let found = value.get_ref();
        let article = if matches!(found, DeValue::Integer(_) | DeValue::Array(_)) { "an" } else { "a" };
        let what = format!("`{}` must be {}, this is {article} {}", wanted.path, noun(wanted.kind), found.type_str());
        let help = match (wanted.kind, found) {
            (Kind::Number | Kind::Integer, DeValue::String(_)) => "write the number without quotes".to_owned(),
            (Kind::Integer, DeValue::Float(_)) => "write it without a decimal point".to_owned(),
            (Kind::Text | Kind::Choice(_), DeValue::Array(_) | DeValue::Table(_)) => "write one string".to_owned(),
            (Kind::Choice(_), DeValue::Boolean(_)) => "write one of them, in quotes".to_owned(),
            (Kind::Text | Kind::Choice(_), _) => "put it in quotes".to_owned(),
            (Kind::Table(_) | Kind::Map(_), _) => format!("write [{}] and its keys below", shown(&wanted.path, QUOTED)),
            _ => format!("write {}", noun(wanted.kind)),
        };
        let span = if found.is_table() { self.heading(&wanted.path, value.span()) } else { value.span() };
        self.find(span, wanted, what, help)
    }

    /// The place of a table's name where it was noted: its value's span may be anywhere when it is written in parts.
    fn heading(&self, path: &str, otherwise: Range<usize>) -> Range<usize> {
        self.places.get(path).map_or(otherwise, |place| place.span.clone())
    }

    fn unknown(&mut self, name: &Spanned<impl AsRef<str>>, schema: &Schema, path: &str, inner: &str) {
        if self.findings.len() >= MOST_FAULTS {
            return;
        }
        let word = name.get_ref().as_ref();
        let table = if path.is_empty() { "here".to_owned() } else { format!("in [{}]", shown(path, QUOTED)) };
        let what = format!("`{}` is not known {table}", shown(word, QUOTED));
        let names = || schema.keys.iter().map(|key| key.name);
        let homes = schema::homes(self.root, word);
        let help = match (spelling::nearest(word, names()), homes.first()) {
            (Some(near), _) => format!("did you mean `{near}`?"),
            (None, Some(home)) => format!("it belongs in [{home}]"),
            (None, None) => format!("known are {}", names().collect::<Vec<_>>().join(", ")),
        };
        let diagnostic = Diagnostic::error(Fault::Scene, what, help).at(Some(self.place(name.span())));
        let _: Option<()> = self.add(inner, diagnostic);
    }

    fn find<T>(&mut self, span: Range<usize>, wanted: &Wanted<'_>, what: String, help: String) -> Option<T> {
        let diagnostic = Diagnostic::error(Fault::Scene, what, help).at(Some(self.place(span)));
        self.add(&wanted.path, diagnostic)
    }

    fn add<T>(&mut self, path: &str, diagnostic: Diagnostic) -> Option<T> {
        if self.findings.len() < MOST_FAULTS {
            self.findings.push(Finding { species: None, path: path.to_owned(), diagnostic });
        }
        None
    }

    /// A span cut to the text: `--set` reads a bare word as if it stood in quotes.
    fn place(&self, span: Range<usize>) -> Place {
        let end = span.end.min(self.source.text.len());
        Place { source: self.source.clone(), span: span.start.min(end)..end }
    }
}

/// Whether a value has the TOML type of a kind.
fn suits(kind: &Kind, value: &DeValue<'_>) -> bool {
    match kind {
        Kind::Number => value.is_integer() || value.is_float(),
        Kind::Integer => value.is_integer(),
        Kind::Boolean => value.is_bool(),
        Kind::Text => value.is_str() || value.is_datetime(),
        Kind::Choice(_) => value.is_str(),
        Kind::List(..) => value.is_array(),
        Kind::Table(_) | Kind::Map(_) => value.is_table(),
        Kind::Either(kinds) => kinds.iter().any(|kind| suits(kind, value)),
    }
}

/// A kind in words.
fn noun(kind: &Kind) -> String {
    match kind {
        Kind::Number => "a number".to_owned(),
        Kind::Integer => "a whole number".to_owned(),
        Kind::Boolean => "true or false".to_owned(),
        Kind::Text => "a string".to_owned(),
        Kind::Choice(words) => words.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(" or "),
        Kind::List(inner, least, most) => {
            let one = noun(inner);
            let count = if least == most { format!("{least} values") } else { "values".to_owned() };
            format!("a list of {count}, each {one}")
        }
        Kind::Either(kinds) => kinds.iter().map(noun).collect::<Vec<_>>().join(" or "),
        Kind::Table(_) | Kind::Map(_) => "a table".to_owned(),
    }
}

/// How to write a number that is allowed.
fn allowed(wanted: &Wanted<'_>) -> String {
    let unit = if wanted.unit.is_empty() { String::new() } else { format!(" {}", wanted.unit) };
    match wanted.range {
        Some((low, high)) => format!("write a number from {} to {}{unit}", written(low), written(high)),
        None if unit.is_empty() => "write a plain number".to_owned(),
        None => format!("write a plain number of{unit}"),
    }
}

/// A bound as a person writes it.
fn written(bound: f64) -> String {
    if bound != 0.0 && bound.abs() < 1e-3 { format!("{bound:e}") } else { format!("{bound}") }
}
