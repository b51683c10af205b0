//! The whole L-system: axiom and rules, checked against each other.

use super::Settings;
use super::cursor::{Cursor, Fault};
use super::parser::Names;
use super::rule::Rule;
use super::symbol::{Template, allowed_parameters, modules};
use crate::base::settings::Complaint;

/// An L-system ready to be derived.
#[derive(Clone, Debug)]
pub(super) struct Grammar {
    pub axiom: Vec<Template>,
    pub rules: Vec<Rule>,
    /// Numbers of the rules of each ASCII symbol.
    pub by_letter: Vec<Vec<usize>>,
    /// Which symbols are drawn, can become something that is, or are looked for by rules; branches without any are dropped.
    pub lasting: [bool; 128],
    /// Which symbols are passed over when rules look at neighbours.
    pub ignored: [bool; 128],
}

impl Grammar {
    /// Parses axiom and rules.
    ///
    /// # Errors
    /// Everything that is wrong, in the order axiom, `rules.0`, `rules.1`...
    pub fn new(settings: &Settings) -> Result<Self, Vec<Complaint>> {
        let mut complaints = Vec::new();
        let mut faults = Vec::new();
        let names = Names { parameters: &[], constants: &settings.constants };
        let parsed = modules(&mut Cursor::new(&settings.axiom), names, &mut faults);
        let axiom = parsed.map_err(|fault| faults.push(fault)).unwrap_or_default();
        let mut rules: Vec<Option<Rule>> = Vec::new();
        let mut rule_faults: Vec<Vec<Fault>> = Vec::new();
        for text in &settings.rules {
            let mut faults = Vec::new();
            rules.push(Rule::parse(text, &settings.constants, &mut faults));
            rule_faults.push(faults);
        }
        let arities = arities(&rules, &mut rule_faults);
        count_neighbours(&rules, &arities, &mut rule_faults);
        count_parameters(&axiom, &arities, &mut faults);
        complain("axiom", faults, &mut complaints);
        for (index, (rule, mut faults)) in rules.iter().zip(rule_faults).enumerate() {
            if let Some(rule) = rule {
                count_parameters(&rule.successor, &arities, &mut faults);
            }
            complain(&format!("rules.{index}"), faults, &mut complaints);
        }
        if !complaints.is_empty() {
            return Err(complaints);
        }
        let rules: Vec<Rule> = rules.into_iter().flatten().collect();
        let of = |letter: u8| (0..rules.len()).filter(|&rule| rules[rule].own.letter == letter).collect();
        let by_letter: Vec<Vec<usize>> = (0..128).map(of).collect();
        let looked_for = |letter: u8| {
            let mut patterns = rules.iter().flat_map(|rule| rule.left.iter().chain(&rule.right));
            patterns.any(|pattern| pattern.letter == letter)
        };
        let lasting = std::array::from_fn(|index| {
            let letter = index as u8;
            matches!(letter, b'F' | b'f' | b'L') || !by_letter[index].is_empty() || looked_for(letter)
        });
        let mut ignored = [false; 128];
        settings.ignored.bytes().filter(u8::is_ascii).for_each(|letter| ignored[usize::from(letter)] = true);
        Ok(Self { axiom, rules, by_letter, lasting, ignored })
    }

    /// Whether any module can be cut off by `%`.
    pub fn cuts(&self) -> bool {
        self.writes(b'%')
    }

    /// Whether there can be a leaf.
    pub fn bears_leaves(&self) -> bool {
        self.writes(b'L')
    }

    fn writes(&self, letter: u8) -> bool {
        let mut templates = self.axiom.iter().chain(self.rules.iter().flat_map(|rule| &rule.successor));
        templates.any(|template| template.letter == letter)
    }
}

fn complain(key: &str, faults: Vec<Fault>, complaints: &mut Vec<Complaint>) {
    complaints.extend(faults.into_iter().map(|fault| Complaint {
        key: key.to_owned(),
        within: Some(fault.within),
        message: fault.message,
        help: fault.help,
    }));
}

/// The number of parameters that the first rule of each symbol gives it; other rules must agree.
fn arities(rules: &[Option<Rule>], faults: &mut [Vec<Fault>]) -> [Option<usize>; 128] {
    let mut arities = [None; 128];
    for (rule, faults) in rules.iter().zip(faults) {
        let Some(Rule { own, .. }) = rule else { continue };
        let arity = *arities[usize::from(own.letter)].get_or_insert(own.arity);
        let allowed = allowed_parameters(own.letter);
        if arity != own.arity {
            let message = format!("an earlier rule gives `{}` {}", char::from(own.letter), parameters(arity));
            faults.push(Fault::new(own.span.clone(), message, "a symbol has one number of parameters"));
        } else if own.arity > 0 && !allowed.contains(&own.arity) {
            let message = format!("`{}` cannot have {}", char::from(own.letter), parameters(own.arity));
            faults.push(Fault::new(own.span.clone(), message, format!("it takes {}", span_in_words(&allowed))));
        }
    }
    arities
}

/// Notes neighbours that are looked for with another number of parameters than they have.
fn count_neighbours(rules: &[Option<Rule>], arities: &[Option<usize>; 128], faults: &mut [Vec<Fault>]) {
    for (rule, faults) in rules.iter().zip(faults) {
        for pattern in rule.iter().flat_map(|rule| rule.left.iter().chain(&rule.right)) {
            let wanted = arities[usize::from(pattern.letter)];
            let allowed = wanted.map_or(allowed_parameters(pattern.letter), |arity| arity..arity + 1);
            if pattern.arity > 0 && !allowed.contains(&pattern.arity) {
                let message = format!("`{}` cannot have {}", char::from(pattern.letter), parameters(pattern.arity));
                let help = format!("it takes {}; without parentheses any are met", span_in_words(&allowed));
                faults.push(Fault::new(pattern.span.clone(), message, help));
            }
        }
    }
}

fn parameters(count: usize) -> String {
    if count == 1 { "1 parameter".to_owned() } else { format!("{count} parameters") }
}

fn span_in_words(allowed: &std::ops::Range<usize>) -> String {
    match (allowed.start, allowed.end - 1) {
        (low, high) if low == high => format!("{low}"),
        (low, high) => format!("{low} to {high}"),
    }
}

/// Notes modules with missing or extra parameters.
fn count_parameters(templates: &[Template], arities: &[Option<usize>; 128], faults: &mut Vec<Fault>) {
    for template in templates {
        let count = template.parameters.len();
        let wanted = arities[usize::from(template.letter)];
        let allowed = wanted.map_or(allowed_parameters(template.letter), |arity| arity..arity + 1);
        if !allowed.contains(&count) {
            let message = format!("`{}` has {}", char::from(template.letter), parameters(count));
            let source = if wanted.is_some() { ", as its rules have" } else { "" };
            let help = format!("it takes {}{source}", span_in_words(&allowed));
            faults.push(Fault::new(template.span.clone(), message, help));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn complaints(axiom: &str, rules: &[&str]) -> Vec<(String, std::ops::Range<usize>)> {
        let rules = rules.iter().map(|&rule| rule.to_owned()).collect();
        let settings = Settings { axiom: axiom.to_owned(), rules, ..Settings::default() };
        let found = Grammar::new(&settings).err().unwrap_or_default();
        found.into_iter().map(|complaint| (complaint.key, complaint.within.unwrap())).collect()
    }

    #[test]
    fn every_fault_is_reported_at_its_bytes() {
        let found = complaints("A(1)]", &["A(l,w) : l > x -> F(l)[A(l,w)", "B -> #F(1,2)", "A(l,w) -> ("]);
        let wanted = [
            ("axiom", 4..5),
            ("axiom", 0..4),
            ("rules.0", 13..14),
            ("rules.0", 22..23),
            ("rules.1", 5..6),
            ("rules.1", 6..12),
            ("rules.2", 10..11),
        ];
        let wanted: Vec<_> = wanted.into_iter().map(|(key, within)| (key.to_owned(), within)).collect();
        assert_eq!(found, wanted);
    }

    #[test]
    fn sound_rules_pass() {
        let rules = ["A(l) : * : 0.3 -> F(l)[+(20)A(l*0.7)]", "A(l) : l > 1 : 2 -> %", "F(l) -> F(l*1.1)", "C ->"];
        assert_eq!(complaints("A(1)F(2)Q(1,2,3)", &rules), vec![]);
    }

    #[test]
    fn characters_of_several_bytes_are_pointed_at_whole() {
        assert_eq!(complaints("Aé", &["Ä -> A", "A : é -> A"]).len(), 3);
        assert_eq!(complaints("é", &[]), vec![("axiom".to_owned(), 0..2)]);
    }
}
