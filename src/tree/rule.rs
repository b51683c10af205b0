//! One rewriting rule. The grammar of its text, spaces being free:
//!
//! ```text
//! rule        = predecessor [ ":" condition [ ":" weight ] ] "->" successor
//! predecessor = symbol [ "(" name { "," name } ")" ]
//! condition   = "*" | expression          "*" holds always
//! weight      = expression                relative chance, at least 0
//! successor   = { symbol [ "(" expression { "," expression } ")" ] }
//! ```
//!
//! Rules are tried in their order; the first whose condition holds is taken. If that one has a weight, one of all weighted
//! rules of the symbol whose conditions hold is drawn instead. A symbol that no rule takes stays as it is.

use super::cursor::{Cursor, Fault};
use super::expression::Program;
use super::parser::{Names, expression};
use super::symbol::{Template, may_be_rewritten, modules, symbol};
use std::collections::BTreeMap;
use std::ops::Range;

/// A rule ready to be applied.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Rule {
    /// The symbol it rewrites.
    pub letter: u8,
    /// Number of its parameters.
    pub arity: usize,
    /// Bytes of the predecessor.
    pub span: Range<usize>,
    /// Absent when it always holds.
    pub condition: Option<Program>,
    /// Absent for a rule that is not drawn.
    pub weight: Option<Program>,
    /// What it writes.
    pub successor: Vec<Template>,
}

impl Rule {
    /// Parses a rule; what is wrong goes to `faults`, and `None` comes back when nothing can be made of it.
    pub fn parse(text: &str, constants: &BTreeMap<String, f64>, faults: &mut Vec<Fault>) -> Option<Self> {
        Self::read(&mut Cursor::new(text), constants, faults).map_err(|fault| faults.push(fault)).ok().flatten()
    }

    fn read(
        cursor: &mut Cursor<'_>,
        constants: &BTreeMap<String, f64>,
        faults: &mut Vec<Fault>,
    ) -> Result<Option<Self>, Fault> {
        let found = symbol(cursor, faults);
        let parameters = if cursor.accept("(") { parameter_names(cursor, faults)? } else { Vec::new() };
        let end = cursor.end();
        let names = Names { parameters: &parameters, constants };
        let (mut condition, mut weight) = (None, None);
        if cursor.accept(":") {
            condition = if cursor.accept("*") { None } else { Some(expression(cursor, names, faults)?) };
            weight = if cursor.accept(":") { Some(expression(cursor, names, faults)?) } else { None };
        }
        cursor.expect("->", "a rule reads `predecessor : condition : weight -> successor`")?;
        let successor = modules(cursor, names, faults)?;
        let Some((letter, span)) = found else { return Ok(None) };
        if !may_be_rewritten(letter) {
            let help = "rules rewrite letters and turns, not brackets or `%`";
            faults.push(Fault::new(span.clone(), format!("`{}` cannot be rewritten", char::from(letter)), help));
        }
        Ok(Some(Self { letter, arity: parameters.len(), span: span.start..end, condition, weight, successor }))
    }
}

fn parameter_names(cursor: &mut Cursor<'_>, faults: &mut Vec<Fault>) -> Result<Vec<String>, Fault> {
    let mut names: Vec<String> = Vec::new();
    loop {
        let (name, span) = cursor.run(|c| c.is_ascii_alphanumeric() || c == '_');
        if name.is_empty() || name.starts_with(|c: char| c.is_ascii_digit()) {
            let here = if name.is_empty() { cursor.next_range() } else { span };
            return Err(Fault::new(here, "a parameter's name is missing here", "write a name such as `l`"));
        }
        if names.iter().any(|known| known == name) {
            faults.push(Fault::new(span, format!("`{name}` stands here twice"), "give each parameter its own name"));
        }
        names.push(name.to_owned());
        if cursor.accept(")") {
            return Ok(names);
        }
        cursor.expect(",", "separate parameters by commas and close the parenthesis")?;
    }
}
