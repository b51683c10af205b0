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
    let lasting =
        |letter: u8| matches!(letter, b'F' | b'f' | b'L') || !grammar.by_letter[usize::from(letter)].is_empty();
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
        certain |= rule.condition.is_none() && rule.weight.is_none();
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
