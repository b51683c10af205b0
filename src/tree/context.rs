//! Neighbours of a module, for rules that look at them (Prusinkiewicz and Lindenmayer 1990, section 1.8). To the left stands
//! what carries the module: brackets of other branches are passed over and that of its own is left. To the right stands what
//! follows on its own axis: side branches are passed over, and the end of the branch is the end. Contexts that name a side
//! branch, as `G[H]M` in the book, are not here.

use super::modules::Module;
use super::rule::{Pattern, Rule};

/// Finds the neighbours that the rule names for the module at `index`, nearest first to each side, and notes where they stand
/// in the order of the rule's text. `passed` are the symbols that count for nothing.
pub(super) fn found(rule: &Rule, list: &[Module], index: usize, passed: &[bool; 128], places: &mut Vec<usize>) -> bool {
    places.clear();
    let mut at = index;
    for pattern in rule.left.iter().rev() {
        match before(list, at, passed) {
            Some(place) if fits(pattern, &list[place]) => at = place,
            _ => return false,
        }
        places.push(at);
    }
    places.reverse();
    at = index;
    for pattern in &rule.right {
        match after(list, at, passed) {
            Some(place) if fits(pattern, &list[place]) => at = place,
            _ => return false,
        }
        places.push(at);
    }
    true
}

/// A pattern without names stands for any number of parameters.
fn fits(pattern: &Pattern, module: &Module) -> bool {
    pattern.letter == module.letter && (pattern.arity == 0 || pattern.arity == module.count())
}

fn before(list: &[Module], mut at: usize, passed: &[bool; 128]) -> Option<usize> {
    let mut depth = 0u32;
    loop {
        at = at.checked_sub(1)?;
        match list[at].letter {
            b']' => depth += 1,
            b'[' => depth = depth.saturating_sub(1),
            letter if depth == 0 && !passed[usize::from(letter)] => return Some(at),
            _ => {}
        }
    }
}

fn after(list: &[Module], mut at: usize, passed: &[bool; 128]) -> Option<usize> {
    let mut depth = 0u32;
    loop {
        at += 1;
        match list.get(at)?.letter {
            b'[' => depth += 1,
            b']' => depth = depth.checked_sub(1)?,
            letter if depth == 0 && !passed[usize::from(letter)] => return Some(at),
            _ => {}
        }
    }
}
