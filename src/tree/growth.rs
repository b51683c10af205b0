//! How long the string must become, before it is written: a lower bound from the growth matrix of the rules (Prusinkiewicz
//! and Lindenmayer 1990, section 1.9), so that a bomb is refused at once and nothing sound is ever refused.

use super::grammar::Grammar;
use crate::base::limits::{Limit, Limits, Refusal};

/// Letters are ASCII.
const LETTERS: usize = 128;

/// Refuses a grammar whose string is certain to pass a limit.
pub(super) fn allow(grammar: &Grammar, steps: u32, limits: &Limits) -> Result<(), Refusal> {
    let Some(counts) = least_counts(grammar, steps) else { return Ok(()) };
    limits.allow(Limit::Symbols, "tree.rules", counts.iter().sum::<f64>().min(f64::MAX))?;
    limits.allow(Limit::Leaves, "tree.rules", counts[usize::from(b'L')].min(f64::MAX))
}

/// The least number of each symbol after `steps` steps, counting only symbols that are sure to stay; `None` when `%` may cut
/// anything off.
fn least_counts(grammar: &Grammar, steps: u32) -> Option<Vec<f64>> {
    if grammar.cuts() {
        return None;
    }
    // Turns and brackets may be dropped with an empty branch, so only what lasts is counted.
    let lasting = |letter: u8| grammar.lasting[usize::from(letter)];
    let mut counts = vec![0.0; LETTERS];
    for template in grammar.axiom.iter().filter(|template| lasting(template.letter)) {
        counts[usize::from(template.letter)] += 1.0;
    }
    let matrix: Vec<Vec<(usize, f64)>> =
        (0..LETTERS).map(|letter| least_successor(grammar, letter, &lasting)).collect();
    for _ in 0..steps {
        let mut next = vec![0.0; LETTERS];
        for (letter, row) in matrix.iter().enumerate().filter(|(letter, _)| counts[*letter] > 0.0) {
            for &(child, count) in row {
                next[child] += count * counts[letter];
            }
        }
        counts = next;
    }
    Some(counts)
}

/// For each symbol the least number that any rule of `letter` writes, and the letter itself if no rule need apply.
fn least_successor(grammar: &Grammar, letter: usize, lasting: &dyn Fn(u8) -> bool) -> Vec<(usize, f64)> {
    let mut least: Option<Vec<f64>> = None;
    let mut lower = |counts: Vec<f64>| {
        let pairs = |old: Vec<f64>| old.iter().zip(&counts).map(|(a, b)| a.min(*b)).collect();
        least = Some(least.take().map_or(counts.clone(), pairs));
    };
    let mut certain = false;
    for &number in &grammar.by_letter[letter] {
        let rule = &grammar.rules[number];
        let mut counts = vec![0.0; LETTERS];
        for template in rule.successor.iter().filter(|template| lasting(template.letter)) {
            counts[usize::from(template.letter)] += 1.0;
        }
        lower(counts);
        certain |= rule.condition.is_none() && rule.weight.is_none() && !rule.looks();
        if certain {
            break;
        }
    }
    if !certain {
        let mut itself = vec![0.0; LETTERS];
        itself[letter] = 1.0;
        lower(itself);
    }
    let counts = least.unwrap_or_default();
    counts.into_iter().enumerate().filter(|(_, count)| *count > 0.0).collect()
}

/// What the string would come to after `left` more steps that grow as the present one does, whose share `done` (modules
/// rewritten, modules in all) has given `written` symbols.
pub(super) fn extrapolated(written: usize, done: (usize, usize), left: u32) -> f64 {
    let (rewritten, all) = (done.0.max(1) as f64, done.1.max(1) as f64);
    let step = written as f64 / rewritten;
    let mut wanted = step * all;
    for _ in 0..left {
        wanted = (wanted * step.max(1.0)).min(f64::MAX);
    }
    wanted.max(written as f64).ceil()
}

#[cfg(test)]
mod tests {
    use super::super::{Settings, TreeError, grow};
    use super::*;

    fn settings(rules: &[&str], iterations: u32) -> Settings {
        let rules = rules.iter().map(|&rule| rule.to_owned()).collect();
        Settings { axiom: "F".to_owned(), rules, iterations, ..Settings::default() }
    }

    fn refusal(rules: &[&str], iterations: u32) -> Option<Limit> {
        let mut limits = Limits::default();
        limits.set(Limit::Symbols, 1e5);
        match grow(&settings(rules, iterations), 1, &limits) {
            Err(TreeError::Refused(refusal)) => Some(refusal.limit),
            _ => None,
        }
    }

    #[test]
    fn the_bound_is_the_count_of_deterministic_rules() {
        let grammar = Grammar::new(&settings(&["F -> F[+F]LA", "A -> AF"], 0)).unwrap();
        let counts = least_counts(&grammar, 5).unwrap();
        // F' = 2F + A, A' = A + F, from F = 1: 1, 2, 5, 13, 34, 89.
        assert_eq!(counts[usize::from(b'F')], 89.0);
        let symbols = settings(&["F -> F[+F]LA", "A -> AF"], 5);
        assert_eq!(grow(&symbols, 1, &Limits::default()).unwrap().0.skeleton.segments.len(), 89);
    }

    #[test]
    fn bombs_are_refused_before_and_while_they_grow() {
        assert_eq!(refusal(&["F -> FFFFFFFFFF"], 40), Some(Limit::Symbols));
        assert!(allow(&Grammar::new(&settings(&["F -> FFFFFFFFFF"], 40)).unwrap(), 40, &Limits::default()).is_err());
        assert_eq!(refusal(&["F : n < 9 || n > 8 -> FFFFFFFFFF"], 40), Some(Limit::Symbols));
        assert_eq!(refusal(&["F : * : 1 -> FF", "F : * : 1 -> FFF"], 200), Some(Limit::Symbols));
        assert_eq!(refusal(&["F -> FFFF%"], 200), None);
        assert_eq!(refusal(&["F : n < 3 -> FF"], 40), None);
    }

    #[test]
    fn too_many_leaves_are_refused() {
        let mut limits = Limits::default();
        limits.set(Limit::Leaves, 100.0);
        let error = grow(&settings(&["F -> FF[L]"], 7), 1, &limits).unwrap_err();
        assert!(
            matches!(error, TreeError::Refused(refusal) if refusal.limit == Limit::Leaves && refusal.wanted == 127.0)
        );
    }
}
