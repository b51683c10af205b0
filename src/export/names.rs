//! Names that every glTF reader takes: `[a-z0-9_-]`, a letter first, none twice. Engines make file and variable names of
//! them, and Blender renames doubles by itself.

use std::collections::BTreeSet;

/// The names given so far, of one kind of object.
#[derive(Debug, Default)]
pub(super) struct Names(BTreeSet<String>);

impl Names {
    /// The wanted name, mended where it breaks the rules, with a number behind it when it is taken.
    pub(super) fn give(&mut self, wanted: &str) -> String {
        let plain = plain(wanted);
        let numbered = (2u64..).map(|number| format!("{plain}_{number}"));
        let free = std::iter::once(plain.clone()).chain(numbered).find(|name| !self.0.contains(name));
        let name = free.unwrap_or(plain);
        self.0.insert(name.clone());
        name
    }
}

fn plain(wanted: &str) -> String {
    let allowed = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_' || c == '-';
    let kept: String =
        wanted.chars().map(|c| c.to_ascii_lowercase()).map(|c| if allowed(c) { c } else { '_' }).collect();
    if kept.starts_with(|c: char| c.is_ascii_lowercase()) { kept } else { format!("n_{kept}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_mended_and_never_repeat() {
        let mut names = Names::default();
        let given: Vec<String> =
            ["leaf_red-0", "Late Green", "leaf_red-0", "0", "", "leaf_red-0_2"].iter().map(|n| names.give(n)).collect();
        assert_eq!(given, ["leaf_red-0", "late_green", "leaf_red-0_2", "n_0", "n_", "leaf_red-0_2_2"]);
    }
}
