//! Every leaf's state at every frame as comma-separated values: ground truth for those who make data sets.

use crate::season::LeafStates;
use std::borrow::Cow;
use std::fmt::Write;

/// The first line.
pub const HEADER: &str = "frame,day,leaf,state,since_day\n";

/// A name as a field: quoted when it holds what would end the field (RFC 4180).
fn quoted(name: &str) -> Cow<'_, str> {
    if name.contains([',', '"', '\n', '\r']) {
        Cow::Owned(format!("\"{}\"", name.replace('"', "\"\"")))
    } else {
        Cow::Borrowed(name)
    }
}

/// The lines of one frame; leaves are named by their stable ids in hexadecimal, as nodes of a glTF file are.
pub fn append(text: &mut String, frame: i64, day: f64, leaf_ids: &[u64], states: &LeafStates) {
    for ((id, &state), since) in leaf_ids.iter().zip(&states.states).zip(&states.since) {
        let name = quoted(&states.names[usize::from(state)]);
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{frame},{day},{id:016x},{name},{since}");
    }
}
