//! Derivation: all modules are rewritten in parallel, once a step, as in Prusinkiewicz and Lindenmayer, "The Algorithmic
//! Beauty of Plants" (1990), chapter 1. Context-free.
//!
//! Every module has an identity, the hash of its parent's identity and its key among its siblings. It does not depend on
//! where the module stands in the string or on how many steps follow, so a leaf keeps its id when the tree grows older.

use super::draws::Draws;
use super::expression::{Program, Scope};
use super::grammar::Grammar;
use super::growth::extrapolated;
use super::rule::Rule;
use super::shedding;
use super::symbol::Template;
use super::{Settings, TreeError};
use crate::base::limits::{Limit, Limits, Refusal};
use crate::base::random::hash;

/// A string of modules, by column.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Modules {
    pub letters: Vec<u8>,
    pub ids: Vec<u64>,
    /// The derivation step that wrote the module; 0 for the axiom.
    pub births: Vec<u32>,
    /// Where each module's parameters end in `values`.
    ends: Vec<usize>,
    values: Vec<f64>,
}

impl Modules {
    pub fn len(&self) -> usize {
        self.letters.len()
    }

    pub fn parameters(&self, module: usize) -> &[f64] {
        let start = if module == 0 { 0 } else { self.ends[module - 1] };
        &self.values[start..self.ends[module]]
    }

    pub fn count(&self, letter: u8) -> usize {
        self.letters.iter().filter(|&&found| found == letter).count()
    }

    /// Keeps only the modules marked.
    pub fn retain(&mut self, kept: &[bool]) {
        let mut left = 0;
        let mut values = 0;
        for module in (0..self.len()).filter(|&module| kept[module]) {
            let start = if module == 0 { 0 } else { self.ends[module - 1] };
            let range = start..self.ends[module];
            self.values.copy_within(range.clone(), values);
            values += range.len();
            self.letters[left] = self.letters[module];
            self.ids[left] = self.ids[module];
            self.births[left] = self.births[module];
            self.ends[left] = values;
            left += 1;
        }
        self.truncate(left);
    }

    fn push(&mut self, letter: u8, id: u64, birth: u32) {
        self.letters.push(letter);
        self.ids.push(id);
        self.births.push(birth);
        self.ends.push(self.values.len());
    }

    fn truncate(&mut self, length: usize) {
        self.letters.truncate(length);
        self.ids.truncate(length);
        self.births.truncate(length);
        self.ends.truncate(length);
        self.values.truncate(self.ends.last().copied().unwrap_or(0));
    }
}

/// Derives the grammar's string; shaded shoots are shed on the way when the settings ask for it.
pub(super) fn derive(grammar: &Grammar, settings: &Settings, seed: u64, limits: &Limits) -> Result<Modules, TreeError> {
    let steps = settings.steps();
    let mut rewriter = Rewriter::new(grammar, seed, limits);
    for template in &grammar.axiom {
        rewriter.write(template, &"axiom", &[], 0)?;
    }
    for step in 1..=steps {
        rewriter.step(step, steps)?;
        if shedding::due(settings, step, steps) {
            shedding::shed(&mut rewriter.next, settings)?;
        }
    }
    Ok(rewriter.next)
}

/// A bracket that is open in the string being written.
struct Open {
    /// Where it stands.
    start: usize,
    /// Whether anything inside can ever matter; branches without are dropped.
    lasting: bool,
}

struct Rewriter<'a> {
    grammar: &'a Grammar,
    limits: &'a Limits,
    seed: u64,
    draws: Draws,
    stack: Vec<f64>,
    next: Modules,
    /// The string of the step before, kept for its memory.
    last: Modules,
    open: Vec<Open>,
    /// Depth below the branch that `%` cut off, while it is being left out.
    cut: Option<usize>,
    step: u32,
    steps: u32,
    /// Share of the last string that has been rewritten and its length, to say how much more there would be.
    done: (usize, usize),
}

impl<'a> Rewriter<'a> {
    fn new(grammar: &'a Grammar, seed: u64, limits: &'a Limits) -> Self {
        let draws = Draws::new(seed, 0, 0);
        let (stack, next, last, open) = (Vec::new(), Modules::default(), Modules::default(), Vec::new());
        Self { grammar, limits, seed, draws, stack, next, last, open, cut: None, step: 0, steps: 0, done: (0, 0) }
    }

    fn step(&mut self, step: u32, steps: u32) -> Result<(), TreeError> {
        std::mem::swap(&mut self.next, &mut self.last);
        self.next.truncate(0);
        let last = std::mem::take(&mut self.last);
        (self.step, self.steps, self.cut) = (step, steps, None);
        self.open.clear();
        for module in 0..last.len() {
            self.done = (module + 1, last.len());
            let (letter, id) = (last.letters[module], last.ids[module]);
            if self.grammar.by_letter[usize::from(letter)].is_empty() {
                self.keep(&last, module)?;
                continue;
            }
            let parameters = last.parameters(module);
            self.draws = Draws::new(self.seed, id, step);
            match self.choose(letter, parameters)? {
                Some(rule) => self.apply(rule, parameters, id)?,
                None => self.keep(&last, module)?,
            }
        }
        self.last = last;
        Ok(())
    }

    fn apply(&mut self, rule: usize, parameters: &[f64], parent: u64) -> Result<(), TreeError> {
        let grammar = self.grammar;
        for template in &grammar.rules[rule].successor {
            self.write(template, &rule, parameters, parent)?;
        }
        Ok(())
    }

    /// The number of the rule that rewrites the module, if any does.
    fn choose(&mut self, letter: u8, parameters: &[f64]) -> Result<Option<usize>, TreeError> {
        let grammar = self.grammar;
        let mut weighted: Vec<(usize, f64)> = Vec::new();
        for &number in &grammar.by_letter[usize::from(letter)] {
            let rule: &Rule = &grammar.rules[number];
            if rule.weight.is_none() && !weighted.is_empty() {
                continue;
            }
            let holds = match &rule.condition {
                Some(condition) => self.evaluate(condition, parameters, &number)? != 0.0,
                None => true,
            };
            match &rule.weight {
                None if holds => return Ok(Some(number)),
                Some(weight) if holds => weighted.push((number, self.evaluate(weight, parameters, &number)?.max(0.0))),
                _ => {}
            }
        }
        let total: f64 = weighted.iter().map(|choice| choice.1).sum();
        if total <= 0.0 {
            return Ok(None);
        }
        let mut left = self.draws.choice() * total;
        for &(rule, weight) in &weighted {
            left -= weight;
            if left < 0.0 {
                return Ok(Some(rule));
            }
        }
        Ok(weighted.iter().rfind(|choice| choice.1 > 0.0).map(|choice| choice.0))
    }

    fn evaluate(&mut self, program: &Program, parameters: &[f64], key: &dyn Key) -> Result<f64, TreeError> {
        let age = f64::from(self.step);
        let mut scope = Scope { parameters, age, draws: &mut self.draws, stack: &mut self.stack };
        program.evaluate(&mut scope).map_err(|within| TreeError::Undefined { key: key.key(), within })
    }

    fn write(&mut self, template: &Template, key: &dyn Key, values: &[f64], parent: u64) -> Result<(), TreeError> {
        if !self.enter(template.letter)? {
            return Ok(());
        }
        for parameter in &template.parameters {
            let value = self.evaluate(parameter, values, key)?;
            self.next.values.push(value);
        }
        self.next.push(template.letter, hash(parent, template.key), self.step);
        self.leave(template.letter);
        Ok(())
    }

    fn keep(&mut self, last: &Modules, module: usize) -> Result<(), TreeError> {
        let letter = last.letters[module];
        if self.enter(letter)? {
            self.next.values.extend_from_slice(last.parameters(module));
            self.next.push(letter, last.ids[module], last.births[module]);
            self.leave(letter);
        }
        Ok(())
    }

    /// Whether the symbol is to be written: not when it is, or stands behind, a `%`.
    fn enter(&mut self, letter: u8) -> Result<bool, TreeError> {
        match (self.cut, letter) {
            (None, b'%') => self.cut = Some(0),
            (Some(0), b']') => self.cut = None,
            (Some(depth), b'[') => self.cut = Some(depth + 1),
            (Some(depth), b']') => self.cut = Some(depth - 1),
            _ => {}
        }
        if self.cut.is_some() {
            return Ok(false);
        }
        let written = self.next.len() + 1;
        let bytes = written * 29 + (self.next.values.len() + self.stack.len()) * 8;
        if written as f64 > self.limits.get(Limit::Symbols) {
            let wanted = extrapolated(written, self.done, self.steps - self.step);
            let allowed = self.limits.get(Limit::Symbols);
            return Err(Refusal { limit: Limit::Symbols, what: "tree.rules".to_owned(), wanted, allowed }.into());
        }
        self.limits.allow(Limit::Memory, "tree.rules", 2.0 * bytes as f64)?;
        Ok(true)
    }

    /// Keeps account of brackets; a branch in which nothing can ever grow or be drawn is taken back.
    fn leave(&mut self, letter: u8) {
        let end = self.next.len();
        if letter == b'[' {
            self.open.push(Open { start: end - 1, lasting: false });
            return;
        }
        let lasting = if letter == b']' {
            let Some(closed) = self.open.pop() else { return };
            if !closed.lasting {
                self.next.truncate(closed.start);
            }
            closed.lasting
        } else {
            matches!(letter, b'F' | b'f' | b'L') || !self.grammar.by_letter[usize::from(letter)].is_empty()
        };
        if let Some(open) = self.open.last_mut() {
            open.lasting |= lasting;
        }
    }
}

/// The settings key that a program came from, spelt out only for a message.
trait Key {
    fn key(&self) -> String;
}

impl Key for usize {
    fn key(&self) -> String {
        format!("rules.{self}")
    }
}

impl Key for &str {
    fn key(&self) -> String {
        (*self).to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn derived(axiom: &str, rules: &[&str], steps: u32) -> Modules {
        let rules = rules.iter().map(|&rule| rule.to_owned()).collect();
        let settings = Settings { axiom: axiom.to_owned(), rules, iterations: steps, ..Settings::default() };
        derive(&Grammar::new(&settings).unwrap(), &settings, 5, &Limits::default()).unwrap()
    }

    fn text(modules: &Modules) -> String {
        String::from_utf8(modules.letters.clone()).unwrap()
    }

    #[test]
    fn algae_grow_as_fibonacci() {
        let rules = ["A -> AB", "B -> A"];
        assert_eq!(text(&derived("A", &rules, 4)), "ABAABABA");
        assert_eq!(derived("A", &rules, 20).len(), 17711);
    }

    #[test]
    fn a_cut_drops_the_rest_of_its_branch_only() {
        assert_eq!(text(&derived("F[FX[+F]F]F", &["X -> %"], 1)), "F[F]F");
        assert_eq!(text(&derived("F[FX[+F]FX]", &["X -> F%F"], 1)), "F[FF]");
    }

    #[test]
    fn branches_without_substance_are_dropped() {
        assert_eq!(text(&derived("F[+L][/(3)[L]]F", &["L ->"], 1)), "FF");
    }

    #[test]
    fn weights_are_met_and_do_not_depend_on_other_rules() {
        let count = |rules: &[&str]| {
            let modules = derived("B", rules, 13);
            (modules.count(b'X'), modules.ids.clone())
        };
        let rules = ["B : n < 13 -> BB", "B : * : 1 -> X", "B : * : 3 -> Y"];
        let (drawn, ids) = count(&rules);
        assert!((drawn as f64 / 4096.0 - 0.25).abs() < 0.03, "{drawn}");
        assert_eq!(count(&["B : n < 13 -> BB", "C -> F", "B : * : 1 -> X", "B : * : 3 -> Y"]), (drawn, ids));
    }

    #[test]
    fn undefined_values_name_rule_and_bytes() {
        let settings = Settings {
            axiom: "A(1)".to_owned(),
            rules: vec!["B -> F".to_owned(), "A(l) -> F(1)A(1/(l-1))".to_owned()],
            ..Settings::default()
        };
        let error = derive(&Grammar::new(&settings).unwrap(), &settings, 1, &Limits::default()).unwrap_err();
        assert_eq!(error, TreeError::Undefined { key: "rules.1".to_owned(), within: 14..21 });
    }
}
