//! The alphabet of the turtle and templates of modules: a letter with expressions for its parameters.

use super::cursor::{Cursor, Fault};
use super::expression::Program;
use super::parser::{Names, expression};
use crate::base::random::hash;
use std::collections::BTreeMap;
use std::ops::Range;

/// Parameters that a module may have at most.
pub(super) const PARAMETER_LIMIT: usize = 16;

/// Symbols other than upper-case letters.
const SIGNS: &str = "f+-&^\\/|$![]%{}";

/// A module as a rule or axiom writes it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Template {
    /// The letter or sign, ASCII.
    pub letter: u8,
    /// One program a parameter.
    pub parameters: Vec<Program>,
    /// The bytes it was written in.
    pub span: Range<usize>,
    /// Tells the siblings of one successor apart; see [`number`].
    pub key: u64,
}

/// How many parameters a symbol may have when no rule says so; upper-case letters without a meaning take any number.
pub(super) fn allowed_parameters(letter: u8) -> Range<usize> {
    match letter {
        b'[' | b']' | b'{' | b'}' | b'%' | b'$' | b'|' => 0..1,
        b'!' => 1..2,
        b'F' | b'L' | b'f' | b'+' | b'-' | b'&' | b'^' | b'\\' | b'/' => 0..2,
        _ => 0..PARAMETER_LIMIT + 1,
    }
}

/// Whether rules may rewrite the symbol: brackets and `%` steer the derivation itself.
pub(super) fn may_be_rewritten(letter: u8) -> bool {
    !matches!(letter, b'[' | b']' | b'{' | b'}' | b'%')
}

/// Takes one symbol; an unknown one is noted and `None` returned.
pub(super) fn symbol(cursor: &mut Cursor<'_>, faults: &mut Vec<Fault>) -> Option<(u8, Range<usize>)> {
    let span = cursor.next_range();
    let taken = cursor.take()?;
    if taken.is_ascii_uppercase() || SIGNS.contains(taken) {
        return Some((taken as u8, span));
    }
    let help = format!("modules are upper-case letters or one of {SIGNS}");
    faults.push(Fault::new(span, format!("`{}` is not a symbol", taken.escape_debug()), help));
    None
}

/// Parses modules up to the end of the text.
pub(super) fn modules(
    cursor: &mut Cursor<'_>,
    names: Names<'_>,
    faults: &mut Vec<Fault>,
) -> Result<Vec<Template>, Fault> {
    let mut templates = Vec::new();
    while cursor.peek().is_some() {
        let found = symbol(cursor, faults);
        let parameters = if cursor.accept("(") { arguments(cursor, names, faults)? } else { Vec::new() };
        if let Some((letter, span)) = found {
            let span = span.start..cursor.end();
            if parameters.len() > PARAMETER_LIMIT {
                let help = format!("a module has at most {PARAMETER_LIMIT}");
                faults.push(Fault::new(span.clone(), "too many parameters", help));
            }
            templates.push(Template { letter, parameters, span, key: 0 });
        }
    }
    balance(&templates, faults);
    number(&mut templates);
    Ok(templates)
}

fn arguments(cursor: &mut Cursor<'_>, names: Names<'_>, faults: &mut Vec<Fault>) -> Result<Vec<Program>, Fault> {
    let mut arguments = vec![expression(cursor, names, faults)?];
    while !cursor.accept(")") {
        cursor.expect(",", "separate parameters by commas and close the parenthesis")?;
        arguments.push(expression(cursor, names, faults)?);
    }
    Ok(arguments)
}

/// Notes every bracket without its partner.
fn balance(templates: &[Template], faults: &mut Vec<Fault>) {
    let mut open: Vec<&Template> = Vec::new();
    for template in templates {
        match template.letter {
            b'[' | b'{' => open.push(template),
            b']' | b'}' => {
                let partner = template.letter - 2; // ASCII: '[' and ']', '{' and '}' are two apart
                match open.pop() {
                    Some(opener) if opener.letter == partner => {}
                    _ => faults.push(unbalanced(template, partner)),
                }
            }
            _ => {}
        }
    }
    faults.extend(open.into_iter().map(|opener| unbalanced(opener, opener.letter + 2)));
}

fn unbalanced(template: &Template, partner: u8) -> Fault {
    let (this, partner) = (char::from(template.letter), char::from(partner));
    Fault::new(
        template.span.clone(),
        format!("`{this}` has no `{partner}`"),
        format!("add the `{partner}` or drop this"),
    )
}

/// Gives every module a key that tells it from its siblings and outlives edits beside it: the path of brackets down to it,
/// each by the letters inside and how many equal ones came before, then its letter and how many equal ones came before.
/// Adding a branch, or changing an angle, leaves the keys of the others as they are.
fn number(templates: &mut [Template]) {
    let signatures = signatures(templates);
    let mut path = vec![(0u64, BTreeMap::new())];
    for (template, &signature) in templates.iter_mut().zip(&signatures) {
        let closing = matches!(template.letter, b']' | b'}');
        if closing && path.len() > 1 {
            path.pop();
        }
        let Some((prefix, seen)) = path.last_mut() else { return };
        let count: &mut u64 = seen.entry(signature).or_default();
        template.key = hash(hash(*prefix, signature), *count);
        *count += 1;
        let inner = template.key;
        if matches!(template.letter, b'[' | b'{') {
            path.push((inner, BTreeMap::new()));
        }
    }
}

/// For an opening bracket the hash of the letters inside, for others the letter.
fn signatures(templates: &[Template]) -> Vec<u64> {
    let mut signatures: Vec<u64> = templates.iter().map(|template| u64::from(template.letter)).collect();
    let mut open: Vec<usize> = Vec::new();
    for (index, template) in templates.iter().enumerate() {
        let closed = if matches!(template.letter, b']' | b'}') { open.pop() } else { None };
        let inner = closed.map_or(u64::from(template.letter), |opener| signatures[opener]);
        if let Some(&outer) = open.last() {
            signatures[outer] = hash(signatures[outer], inner);
        }
        if matches!(template.letter, b'[' | b'{') {
            open.push(index);
        }
    }
    signatures
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys(text: &str) -> Vec<(char, u64)> {
        let constants = BTreeMap::new();
        let names = Names { parameters: &[], constants: &constants };
        let templates = modules(&mut Cursor::new(text), names, &mut Vec::new()).unwrap();
        templates.iter().map(|template| (char::from(template.letter), template.key)).collect()
    }

    #[test]
    fn a_new_branch_leaves_the_other_keys() {
        let before = keys("F(1)[+(40)L]F(2)[-L]L");
        let after = keys("F(1)[^FL][+(45)L]F(2)[-L]L");
        for key in &before {
            assert!(after.contains(key), "{key:?} was lost");
        }
        let mut distinct: Vec<u64> = after.iter().map(|key| key.1).collect();
        distinct.sort_unstable();
        distinct.dedup();
        assert_eq!(distinct.len(), after.len());
    }
}
