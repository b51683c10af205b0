//! Neighbours of a module, for rules that look at them (Prusinkiewicz and Lindenmayer 1990, section 1.8). To the left stands
//! what carries the module: brackets of other branches are passed over and that of its own is left. To the right stands what
//! follows on its own axis: side branches are passed over, and the end of the branch is the end. Contexts that name a side
//! branch, as `G[H]M` in the book, are not here.

use super::modules::Module;
use super::rule::{Pattern, Rule};

/// No neighbour.
const NONE: u32 = u32::MAX;

/// The neighbours of every module of a string.
#[derive(Debug, Default)]
pub(super) struct Neighbours {
    left: Vec<u32>,
    right: Vec<u32>,
}

impl Neighbours {
    /// Finds them in one pass to each side; `passed` are the symbols that count for nothing.
    pub fn find(&mut self, list: &[Module], passed: &[bool; 128]) {
        let counts = |letter: u8| !matches!(letter, b'[' | b']') && !passed[usize::from(letter)];
        self.left.clear();
        let (mut last, mut saved) = (NONE, Vec::new());
        for (index, module) in list.iter().enumerate() {
            match module.letter {
                b'[' => saved.push(last),
                b']' => last = saved.pop().unwrap_or(NONE),
                _ => {}
            }
            self.left.push(last);
            if counts(module.letter) {
                last = index as u32;
            }
        }
        self.right.clear();
        self.right.resize(list.len(), NONE);
        (last, saved) = (NONE, Vec::new());
        for (index, module) in list.iter().enumerate().rev() {
            match module.letter {
                b']' => saved.push(std::mem::replace(&mut last, NONE)),
                b'[' => last = saved.pop().unwrap_or(NONE),
                _ => {}
            }
            self.right[index] = last;
            if counts(module.letter) {
                last = index as u32;
            }
        }
    }

    /// Finds the neighbours that the rule names for the module at `index`, nearest first to each side, and notes where they
    /// stand in the order of the rule's text.
    pub fn found(&self, rule: &Rule, list: &[Module], index: usize, places: &mut Vec<usize>) -> bool {
        places.clear();
        let fit = |next: u32, pattern: &Pattern| list.get(next as usize).is_some_and(|module| fits(pattern, module));
        let mut at = index;
        for pattern in rule.left.iter().rev() {
            let next = self.left[at];
            if !fit(next, pattern) {
                return false;
            }
            at = next as usize;
            places.push(at);
        }
        places.reverse();
        at = index;
        for pattern in &rule.right {
            let next = self.right[at];
            if !fit(next, pattern) {
                return false;
            }
            at = next as usize;
            places.push(at);
        }
        true
    }
}

/// A pattern without names stands for any number of parameters.
fn fits(pattern: &Pattern, module: &Module) -> bool {
    pattern.letter == module.letter && (pattern.arity == 0 || pattern.arity == module.count())
}
