//! Derivation: all modules are rewritten in parallel, once a step, as in Prusinkiewicz and Lindenmayer, "The Algorithmic
//! Beauty of Plants" (1990), chapter 1.
//!
//! Every module has an identity, the hash of its parent's identity and its key among its siblings. It does not depend on
//! where the module stands in the string or on how many steps follow, so a leaf keeps its id when the tree grows older.

use super::context::Neighbours;
use super::draws::Draws;
use super::expression::{Program, Scope};
use super::grammar::Grammar;
use super::growth::extrapolated;
use super::modules::{Module, Modules};
use super::rule::Rule;
use super::shedding::Shedding;
use super::symbol::{PARAMETER_LIMIT, Template};
use super::{Settings, TreeError};
use crate::base::limits::{Limit, Limits, Refusal};
use crate::base::random::hash;

/// Derives the grammar's string; shaded shoots are shed on the way when the settings ask for it.
pub(super) fn derive(grammar: &Grammar, settings: &Settings, seed: u64, limits: &Limits) -> Result<Modules, TreeError> {
    let steps = settings.steps();
    let mut rewriter = Rewriter::new(grammar, seed, limits);
    for template in &grammar.axiom {
        rewriter.write(template, None, None)?;
    }
    let mut shedding = Shedding::new(settings);
    for step in 1..=steps {
        rewriter.step(step, steps)?;
        if settings.shade > 0.0 {
            shedding.shed(&mut rewriter.next)?;
        }
    }
    Ok(rewriter.next)
}

/// Symbols that are written between two looks at the limits: few beside any limit.
const LOOK_AGAIN: usize = 1000;

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
    /// The rules that hold and their weights, kept for its memory.
    weighted: Vec<(usize, f64)>,
    next: Modules,
    /// The string of the step before, kept for its memory.
    last: Vec<Module>,
    open: Vec<Open>,
    /// Depth below the branch that `%` cut off, while it is being left out.
    cut: Option<usize>,
    /// Neighbours in the last string, when any rule looks at them.
    neighbours: Neighbours,
    /// Where the neighbours stand that the rule at hand looks at, and all parameters that it may read.
    places: Vec<usize>,
    seen: Vec<f64>,
    /// Which symbols no rule rewrites and no branch begins or ends with.
    inert: [bool; 128],
    /// The length of the string at which the limits are looked at again.
    room: usize,
    step: u32,
    steps: u32,
    /// Share of the last string that has been rewritten and its length, to say how much more there would be.
    done: (usize, usize),
}

impl<'a> Rewriter<'a> {
    fn new(grammar: &'a Grammar, seed: u64, limits: &'a Limits) -> Self {
        let inert = |letter: usize| grammar.by_letter[letter].is_empty() && !matches!(letter as u8, b'[' | b']' | b'%');
        Self {
            grammar,
            limits,
            seed,
            draws: Draws::new(seed, 0, 0),
            stack: Vec::new(),
            weighted: Vec::new(),
            next: Modules::default(),
            last: Vec::new(),
            open: Vec::new(),
            cut: None,
            neighbours: Neighbours::default(),
            places: Vec::new(),
            seen: Vec::new(),
            inert: std::array::from_fn(inert),
            room: 0,
            step: 0,
            steps: 0,
            done: (0, 0),
        }
    }

    fn step(&mut self, step: u32, steps: u32) -> Result<(), TreeError> {
        std::mem::swap(&mut self.next.list, &mut self.last);
        self.next.list.clear();
        let last = std::mem::take(&mut self.last);
        (self.step, self.steps, self.cut) = (step, steps, None);
        self.open.clear();
        self.room = 0;
        if self.grammar.rules.iter().any(Rule::looks) {
            self.neighbours.find(&last, &self.grammar.ignored);
        }
        for (index, module) in last.iter().enumerate() {
            if self.inert[usize::from(module.letter)] && self.cut.is_none() && self.next.list.len() < self.room {
                self.keep_inert(module);
                continue;
            }
            self.done = (index + 1, last.len());
            let rule = if self.grammar.by_letter[usize::from(module.letter)].is_empty() {
                None
            } else {
                self.draws = Draws::new(self.seed, module.id, step);
                self.choose(&last, index)?
            };
            match rule {
                Some(rule) => self.apply(rule, module)?,
                None => self.keep(module)?,
            }
        }
        self.last = last;
        self.next.sweep();
        Ok(())
    }

    fn apply(&mut self, rule: usize, module: &Module) -> Result<(), TreeError> {
        let grammar = self.grammar;
        for template in &grammar.rules[rule].successor {
            self.write(template, Some(rule), Some(module))?;
        }
        Ok(())
    }

    /// The number of the rule that rewrites the module at `index` of the last string, if any does.
    fn choose(&mut self, last: &[Module], index: usize) -> Result<Option<usize>, TreeError> {
        let (grammar, module) = (self.grammar, &last[index]);
        self.weighted.clear();
        for &number in &grammar.by_letter[usize::from(module.letter)] {
            let rule: &Rule = &grammar.rules[number];
            if rule.weight.is_none() && !self.weighted.is_empty() || rule.looks() && !self.look(rule, last, index) {
                continue;
            }
            let holds = match &rule.condition {
                Some(condition) => self.evaluate(condition, Some(number), Some(module))? != 0.0,
                None => true,
            };
            match &rule.weight {
                None if holds => return Ok(Some(number)),
                Some(weight) if holds => {
                    let weight = self.evaluate(weight, Some(number), Some(module))?.max(0.0);
                    self.weighted.push((number, weight));
                }
                _ => {}
            }
        }
        let total: f64 = self.weighted.iter().map(|choice| choice.1).sum();
        if total <= 0.0 {
            return Ok(None);
        }
        let mut left = self.draws.choice() * total;
        let drawn = self.weighted.iter().find(|choice| {
            left -= choice.1;
            left < 0.0
        });
        let last_resort = || self.weighted.iter().rfind(|choice| choice.1 > 0.0);
        let rule = drawn.or_else(last_resort).map(|choice| choice.0);
        if let Some(rule) = rule.map(|rule| &grammar.rules[rule]).filter(|rule| rule.looks()) {
            self.look(rule, last, index); // others have looked since
        }
        Ok(rule)
    }

    /// Whether the module has the neighbours that the rule names; their parameters are ready for its programs then.
    fn look(&mut self, rule: &Rule, last: &[Module], index: usize) -> bool {
        if !self.neighbours.found(rule, last, index, &mut self.places) {
            return false;
        }
        self.seen.clear();
        let (left, right) = self.places.split_at(rule.left.len());
        let patterns = rule.left.iter().chain([&rule.own]).chain(&rule.right);
        for (pattern, &place) in patterns.zip(left.iter().chain([&index]).chain(right)) {
            self.seen.extend_from_slice(&self.next.parameters(&last[place])[..pattern.arity]);
        }
        true
    }

    /// The value of a program of a rule (`None` for the axiom) that rewrites `module`.
    #[inline]
    fn evaluate(&mut self, program: &Program, rule: Option<usize>, module: Option<&Module>) -> Result<f64, TreeError> {
        let looks = rule.is_some_and(|number| self.grammar.rules[number].looks());
        let parameters = match module {
            Some(_) if looks => &self.seen,
            Some(module) => self.next.parameters(module),
            None => &[],
        };
        let age = f64::from(self.step);
        let mut scope = Scope { parameters, age, draws: &mut self.draws, stack: &mut self.stack };
        program.evaluate(&mut scope).map_err(|within| {
            let key = rule.map_or_else(|| "axiom".to_owned(), |number| format!("rules.{number}"));
            TreeError::Undefined { key, within }
        })
    }

    /// Writes a module of a rule (`None` for the axiom) in the place of `module`.
    fn write(&mut self, template: &Template, rule: Option<usize>, module: Option<&Module>) -> Result<(), TreeError> {
        if !self.enter(template.letter)? {
            return Ok(());
        }
        let id = hash(module.map_or(0, |module| module.id), template.key);
        // Wood that a rule only lengthens or thickens stays as old as it was.
        let same = module.filter(|module| module.letter == b'F' && template.letter == b'F');
        let birth = same.map_or(self.step, |module| module.birth);
        match &template.parameters[..] {
            [] => self.next.push(template.letter, id, birth, &[]),
            [parameter] => {
                let value = self.evaluate(parameter, rule, module)?;
                self.next.push(template.letter, id, birth, &[value]);
            }
            parameters => {
                let mut values = [0.0; PARAMETER_LIMIT];
                for (value, parameter) in values.iter_mut().zip(parameters) {
                    *value = self.evaluate(parameter, rule, module)?;
                }
                self.next.push(template.letter, id, birth, &values[..parameters.len()]);
            }
        }
        self.leave(template.letter);
        Ok(())
    }

    /// As [`Self::keep`], for a symbol that needs no account of brackets nor a look at the limits.
    #[inline]
    fn keep_inert(&mut self, module: &Module) {
        self.next.list.push(*module);
        if self.grammar.lasting[usize::from(module.letter)]
            && let Some(open) = self.open.last_mut()
        {
            open.lasting = true;
        }
    }

    fn keep(&mut self, module: &Module) -> Result<(), TreeError> {
        if self.enter(module.letter)? {
            self.next.list.push(*module);
            self.leave(module.letter);
        }
        Ok(())
    }

    /// Whether the symbol is to be written: not when it is, or stands behind, a `%`.
    #[inline]
    fn enter(&mut self, letter: u8) -> Result<bool, TreeError> {
        if self.cut.is_some() || letter == b'%' {
            return Ok(self.leave_out(letter));
        }
        if self.next.list.len() >= self.room {
            self.make_room()?;
        }
        Ok(true)
    }

    /// Looks whether the limits allow one more symbol, and says when to look again.
    #[cold]
    fn make_room(&mut self) -> Result<(), Refusal> {
        let (symbols, written) = (self.limits.get(Limit::Symbols), self.next.list.len() + 1);
        if written as f64 > symbols {
            let wanted = extrapolated(written, self.done, self.steps - self.step);
            return Err(Refusal { limit: Limit::Symbols, what: "tree.rules".to_owned(), wanted, allowed: symbols });
        }
        // Two strings stand in memory while one is rewritten.
        self.limits.allow(Limit::Memory, "tree.rules", 2.0 * self.next.bytes(written) as f64)?;
        self.room = (written + LOOK_AGAIN).min(symbols as usize);
        Ok(())
    }

    /// Keeps account of brackets behind a `%`; true when the branch that it cut off ends with this symbol.
    fn leave_out(&mut self, letter: u8) -> bool {
        self.cut = match (self.cut, letter) {
            (None, _) => Some(0),
            (Some(0), b']') => None,
            (Some(depth), b'[') => Some(depth + 1),
            (Some(depth), b']') => Some(depth - 1),
            (depth, _) => depth,
        };
        self.cut.is_none()
    }

    /// Keeps account of brackets; a branch in which nothing can ever grow or be drawn is taken back.
    #[inline]
    fn leave(&mut self, letter: u8) {
        if letter == b'[' {
            self.open.push(Open { start: self.next.list.len() - 1, lasting: false });
            return;
        }
        let lasting = if letter == b']' {
            let Some(closed) = self.open.pop() else { return };
            if !closed.lasting {
                self.next.list.truncate(closed.start);
            }
            closed.lasting
        } else {
            self.grammar.lasting[usize::from(letter)]
        };
        if let Some(open) = self.open.last_mut() {
            open.lasting |= lasting;
        }
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
        modules.list.iter().map(|module| char::from(module.letter)).collect()
    }

    #[test]
    fn algae_grow_as_fibonacci() {
        let rules = ["A -> AB", "B -> A"];
        assert_eq!(text(&derived("A", &rules, 4)), "ABAABABA");
        assert_eq!(derived("A", &rules, 20).list.len(), 17711);
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
            (modules.count(b'X'), modules.list.iter().map(|module| module.id).collect::<Vec<_>>())
        };
        let rules = ["B : n < 13 -> BB", "B : * : 1 -> X", "B : * : 3 -> Y"];
        let (drawn, ids) = count(&rules);
        assert!((drawn as f64 / 4096.0 - 0.25).abs() < 0.03, "{drawn}");
        assert_eq!(count(&["B : n < 13 -> BB", "C -> F", "B : * : 1 -> X", "B : * : 3 -> Y"]), (drawn, ids));
    }

    /// The strings of Figure 1.30: a signal that runs up a branch, and one that runs down.
    #[test]
    fn signals_run_acropetally_and_basipetally() {
        let acropetal = ["J[+I]I[-I]I[+I]I", "J[+J]J[-I]I[+I]I", "J[+J]J[-J]J[+I]I", "J[+J]J[-J]J[+J]J"];
        let basipetal = ["I[+I]I[-I]I[+I]J", "I[+I]I[-I]J[+I]J", "I[+I]J[-I]J[+I]J", "J[+I]J[-I]J[+I]J"];
        for (strings, rule) in [(acropetal, "J < I -> J"), (basipetal, "I > J -> J")] {
            for (steps, wanted) in strings.into_iter().enumerate() {
                assert_eq!(text(&derived(strings[0], &[rule], steps as u32)), wanted);
            }
        }
    }

    #[test]
    fn neighbours_give_their_parameters() {
        // Both neighbours over turns and side branches; the nearest of two on the left.
        let rules = ["P(a)Q(b) < A(x) > R(c) : c > a -> F(a+10*b+100*x+1000*c)", "A(x) -> F(0)"];
        let lengths = |axiom: &str| {
            let modules = derived(axiom, &rules, 1);
            let lengths = modules.list.iter().filter(|module| module.letter == b'F').map(Module::argument);
            lengths.flatten().collect::<Vec<_>>()
        };
        assert_eq!(lengths("P(1)+Q(2)[-(3)R(9)]A(3)[&Q(7)]/R(4)"), [4321.0]);
        assert_eq!(lengths("P(1)[Q(2)[A(3)R(4)]R(1)]"), [4321.0]);
        assert_eq!(lengths("P(1)Q(2)A(3)R(1)"), [0.0], "the condition fails");
        assert_eq!(lengths("P(1)Q(2)[A(3)]R(4)"), [0.0], "the branch ends before R");
        assert_eq!(lengths("P(1)[Q(2)]A(3)R(4)"), [0.0], "Q carries nothing");
        assert_eq!(lengths("P(1)Q(2,3)A(3)R(4)"), [0.0], "this Q has another number of parameters");
        // The drawn one of several weighted rules reads its own neighbours' parameters.
        let rules = ["P(a) < A > R(c) : * : 1 -> F(a)", "A > R(c) : * : 0 -> F(c)"];
        assert_eq!(derived("P(1)AR(2)", &rules, 1).list[1].argument(), Some(1.0));
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
