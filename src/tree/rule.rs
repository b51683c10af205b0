//! One rewriting rule. The grammar of its text, spaces being free:
//!
//! ```text
//! rule        = predecessor [ ":" condition [ ":" weight ] ] "->" successor
//! predecessor = [ patterns "<" ] pattern [ ">" patterns ]
//! patterns    = pattern { pattern }
//! pattern     = symbol [ "(" name { "," name } ")" ]
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

/// A symbol that a rule looks for, with the number of names it gives to its parameters.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Pattern {
    pub letter: u8,
    pub arity: usize,
    /// The bytes it was written in.
    pub span: Range<usize>,
}

/// A rule ready to be applied. Its programs number the parameters of the left neighbours first, then its own, then those of
/// the right neighbours.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Rule {
    /// The symbol it rewrites.
    pub own: Pattern,
    /// The symbols that must stand before it, in the order of the text.
    pub left: Vec<Pattern>,
    /// The symbols that must follow.
    pub right: Vec<Pattern>,
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

    /// Whether it looks at neighbours.
    pub fn looks(&self) -> bool {
        !self.left.is_empty() || !self.right.is_empty()
    }

    fn read(
        cursor: &mut Cursor<'_>,
        constants: &BTreeMap<String, f64>,
        faults: &mut Vec<Fault>,
    ) -> Result<Option<Self>, Fault> {
        let mut parameters = Vec::new();
        let first = patterns(cursor, &mut parameters, faults)?;
        let looks_left = cursor.accept("<");
        let (left, middle) =
            if looks_left { (first, patterns(cursor, &mut parameters, faults)?) } else { (Vec::new(), first) };
        let looks_right = middle.len() < 2 && cursor.accept(">");
        let right = if looks_right { patterns(cursor, &mut parameters, faults)? } else { Vec::new() };
        if let Some(second) = middle.get(1) {
            let help = "a rule rewrites one symbol: `left < symbol > right : condition : weight -> successor`";
            return Err(Fault::new(second.span.clone(), "`->` is missing here", help));
        }
        let names = Names { parameters: &parameters, constants };
        let (mut condition, mut weight) = (None, None);
        if cursor.accept(":") {
            condition = if cursor.accept("*") { None } else { Some(expression(cursor, names, faults)?) };
            weight = if cursor.accept(":") { Some(expression(cursor, names, faults)?) } else { None };
        }
        cursor.expect("->", "a rule reads `predecessor : condition : weight -> successor`")?;
        let successor = modules(cursor, names, faults)?;
        let Some(own) = middle.into_iter().next() else { return Ok(None) };
        for pattern in left.iter().chain([&own]).chain(&right) {
            if !may_be_rewritten(pattern.letter) {
                let (verb, help) =
                    ("rewritten or looked for", "rules are about letters and turns, not brackets or `%`");
                let message = format!("`{}` cannot be {verb}", char::from(pattern.letter));
                faults.push(Fault::new(pattern.span.clone(), message, help));
            }
        }
        Ok(Some(Self { own, left, right, condition, weight, successor }))
    }
}

/// Takes symbols with the names of their parameters up to what follows them in a predecessor; at least one is taken.
fn patterns(cursor: &mut Cursor<'_>, names: &mut Vec<String>, faults: &mut Vec<Fault>) -> Result<Vec<Pattern>, Fault> {
    let mut patterns = Vec::new();
    loop {
        if cursor.sees("->") {
            let here = cursor.next_range();
            return Err(Fault::new(here, "a symbol is missing here", "write the symbol that the rule is about"));
        }
        let found = symbol(cursor, faults);
        let known = names.len();
        if cursor.accept("(") {
            parameter_names(cursor, names, faults)?;
        }
        if let Some((letter, span)) = found {
            patterns.push(Pattern { letter, arity: names.len() - known, span: span.start..cursor.end() });
        }
        if cursor.sees("->") || matches!(cursor.peek(), None | Some(':' | '<' | '>')) {
            return Ok(patterns);
        }
    }
}

fn parameter_names(cursor: &mut Cursor<'_>, names: &mut Vec<String>, faults: &mut Vec<Fault>) -> Result<(), Fault> {
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
            return Ok(());
        }
        cursor.expect(",", "separate parameters by commas and close the parenthesis")?;
    }
}
