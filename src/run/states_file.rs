//! Every leaf's state at every frame as comma-separated values: ground truth for those who make data sets.

use crate::compose::Stand;
use crate::season::LeafStates;
use std::borrow::Cow;
use std::fmt::Write;

/// The first line. The number of the tree (from 0, in the order in which the scene plants them) is a column where several
/// trees stand, seed or cell where the scene is a contact sheet (`of_sheet` is that column's name): files of one tree stay as
/// they are.
pub fn header(with_tree: bool, of_sheet: Option<&str>) -> String {
    let tree = if with_tree { ",tree" } else { "" };
    let of_sheet = of_sheet.map_or_else(String::new, |name| format!(",{name}"));
    format!("frame,day,leaf,state,since_day{tree}{of_sheet}\n")
}

/// A name as a field: quoted when it holds what would end the field (RFC 4180).
fn quoted(name: &str) -> Cow<'_, str> {
    if name.contains([',', '"', '\n', '\r']) {
        Cow::Owned(format!("\"{}\"", name.replace('"', "\"\"")))
    } else {
        Cow::Borrowed(name)
    }
}

/// The lines of one frame and day; leaves are named by their stable ids in hexadecimal, as nodes of a glTF file are. A leaf
/// without seasons has no line.
pub fn append(text: &mut String, (frame, day): (i64, f64), stand: &Stand, states: &LeafStates, of_sheet: Option<u64>) {
    let names: Vec<Cow<'_, str>> = states.names.iter().map(|name| quoted(name)).collect();
    let trees = stand.standing().enumerate().flat_map(|(tree, (form, _))| form.sites.iter().map(move |_| tree));
    let leaves = trees.zip(&stand.leaf_ids).zip(states.states.iter().zip(&states.since));
    for ((tree, id), (&state, since)) in leaves {
        let Some(name) = names.get(usize::from(state)) else { continue };
        // Writing to a string cannot fail.
        let _ = write!(text, "{frame},{day},{id:016x},{name},{since}");
        if stand.trees.len() > 1 {
            let _ = write!(text, ",{tree}");
        }
        if let Some(value) = of_sheet {
            let _ = write!(text, ",{value}");
        }
        text.push('\n');
    }
}
