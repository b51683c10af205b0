//! The built-in species: TOML that stands in the program, a file for each stage, together of the same form as a user's
//! species file. They hold settings of the stages and nothing else. Species that branch alike share the rules of a habit;
//! their `tree` files add the figures to it.

use serde::Deserialize;

/// A species' text: its heading, the rules of its habit of growth with its own figures, and the tables of the other stages.
macro_rules! species {
    ($name:literal grows $habit:literal) => {
        (
            $name,
            concat!(
                include_str!(concat!($name, ".toml")),
                "\n[tree]\n",
                include_str!(concat!("habit/", $habit, ".toml")),
                "\n",
                include_str!(concat!($name, ".tree.toml")),
                "\n",
                include_str!(concat!($name, ".leaf.toml")),
                "\n",
                include_str!(concat!($name, ".deform.toml")),
                "\n",
                include_str!(concat!($name, ".season.toml")),
                "\n",
                include_str!(concat!($name, ".colour.toml")),
            ),
        )
    };
}

/// Name and text of each, sorted by name.
const BUILT_IN: [(&str, &str); 11] = [
    species!("beech" grows "alternate"),
    species!("english-oak" grows "clustered"),
    species!("ginkgo" grows "short-shoots"),
    species!("japanese-maple" grows "decussate"),
    species!("norway-maple" grows "decussate"),
    species!("quaking-aspen" grows "alternate"),
    species!("red-maple" grows "decussate"),
    species!("red-oak" grows "clustered"),
    species!("silver-birch" grows "alternate"),
    species!("sugar-maple" grows "decussate"),
    species!("sweetgum" grows "alternate"),
];

/// The names of the built-in species, sorted.
pub fn names() -> impl Iterator<Item = &'static str> {
    BUILT_IN.iter().map(|(name, _)| *name)
}

/// The text of a built-in species.
#[must_use]
pub fn text(name: &str) -> Option<&'static str> {
    BUILT_IN.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

/// The built-in species, each with its line of description.
#[must_use]
pub fn list() -> Vec<(&'static str, String)> {
    BUILT_IN.iter().map(|(name, text)| (*name, description(text))).collect()
}

/// What a species says of itself.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Heading {
    description: String,
}

fn description(text: &str) -> String {
    toml::from_str::<Heading>(text).unwrap_or_default().description
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_species_says_what_it_is_and_they_are_sorted() {
        assert!(list().iter().all(|(_, description)| !description.is_empty() && !description.contains('\n')));
        assert!(names().is_sorted());
        assert!(names().all(|name| text(name).is_some()));
        assert_eq!(text("triffid"), None);
    }
}
