//! The species that a scene's trees name, each read once, and the trees themselves.

use super::super::checker::Finding;
use super::super::planting::Planting;
use super::super::{Places, Planted, Species, asset, layers, schema, spelling, text_file};
use super::Reader;
use crate::base::diagnostic::{Diagnostic, Fault, Source};
use crate::base::message::shown;
use crate::species;
use crate::tree;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// Most species of a scene: each may be a file of some megabytes.
const MOST_SPECIES: usize = 64;
/// Characters of a species' name in a message.
const QUOTED: usize = 60;

/// A species as the scene names it, and the key that does so first.
pub(super) struct Named {
    name: Option<String>,
    key: String,
}

/// The tables of a species, laid below those of the scene.
pub(super) struct Whole {
    pub table: Value,
    /// Whether there is no species whose table could lie below.
    pub is_bare: bool,
    places: Places,
}

/// Who stands in the scene.
pub(super) struct Roster {
    /// Each species once, in the order in which trees name them.
    pub species: Vec<Named>,
    /// The number of each entry's species.
    of_entries: Vec<usize>,
}

/// Takes the entries of `[[trees]]` out of a scene's table, in which they would lie over the species' own.
pub(super) fn taken(above: &mut Value) -> Vec<Map<String, Value>> {
    let trees = above.as_object_mut().and_then(|above| above.remove("trees"));
    let entries = match trees {
        Some(Value::Array(entries)) => entries,
        _ => Vec::new(),
    };
    entries.into_iter().filter_map(|entry| if let Value::Object(entry) = entry { Some(entry) } else { None }).collect()
}

impl Roster {
    pub(super) fn new(
        reader: &mut Reader<'_>,
        source: &Arc<Source>,
        above: &Value,
        entries: &[Map<String, Value>],
    ) -> Self {
        let scene_name = above.get("species").and_then(Value::as_str);
        let is_whole = above.as_object().is_some_and(layers::is_whole_tree);
        let mut roster = Self { species: Vec::new(), of_entries: Vec::new() };
        for (number, entry) in entries.iter().enumerate() {
            let own = entry.get("species").and_then(Value::as_str);
            let key = if own.is_some() { format!("trees.{number}.species") } else { "species".to_owned() };
            let name = own.or(scene_name);
            if name.is_none() && !is_whole {
                let what = format!("tree {number} of [[trees]] has no species");
                let help = "write species = \"red-maple\" here, or at the top for all trees";
                reader.miss(source, &format!("trees.{number}.species"), &what, help);
            }
            let species = roster.number(name, key);
            roster.of_entries.push(species);
        }
        if entries.is_empty() {
            if scene_name.is_none() && !is_whole {
                let help = "write species = \"red-maple\" (`leafseason species` lists them), or a whole [tree] with axiom and rules";
                reader.miss(source, "species", "the scene names no species", help);
            }
            roster.number(scene_name, "species".to_owned());
        } else if let Some(name) =
            scene_name.filter(|name| !roster.species.iter().any(|s| s.name.as_deref() == Some(name)))
        {
            // No tree is of the scene's own species, but its name is checked like any other.
            if let Err(fault) = reader.species_text(name) {
                reader.refuse("species", None, fault);
            }
        }
        if let Some(first) = roster.species.get(MOST_SPECIES) {
            let what = format!("with this the scene has more than {MOST_SPECIES} species");
            let place = reader.places.get(&first.key).cloned();
            reader.refuse(
                &first.key,
                None,
                Diagnostic::error(Fault::Scene, what, "write a scene for each part").at(place),
            );
            roster.species.truncate(MOST_SPECIES);
        }
        roster
    }

    /// The number of a species, which it gets when it is named first.
    fn number(&mut self, name: Option<&str>, key: String) -> usize {
        let known = self.species.iter().position(|species| species.name.as_deref() == name);
        known.unwrap_or_else(|| {
            self.species.push(Named { name: name.map(str::to_owned), key });
            self.species.len() - 1
        })
    }
}

impl Reader<'_> {
    /// Complains of a key that is not there.
    fn miss(&mut self, source: &Arc<Source>, key: &str, what: &str, help: &str) {
        let parent = key.rsplit_once('.').map_or("", |(parent, _)| parent);
        let diagnostic = Diagnostic::error(Fault::Scene, what, help).at(self.places.get(parent).cloned());
        self.complain(source, Finding { species: None, path: key.to_owned(), diagnostic });
    }

    pub(super) fn refuse(&mut self, key: &str, species: Option<usize>, fault: Diagnostic) {
        let place = fault.place.clone().or_else(|| self.places.get(key).cloned());
        let finding = Finding { species, path: key.to_owned(), diagnostic: fault.at(place) };
        // Cells of a sheet share what they name.
        if !self.findings.iter().any(|known| known.diagnostic == finding.diagnostic) {
            self.findings.push(finding);
        }
    }

    /// The table of a species: empty without one, or when it cannot be read.
    pub(super) fn species_table(&mut self, number: usize, named: &Named) -> Whole {
        let scene = Places(self.places.clone());
        let empty = || Value::Object(Map::new());
        let Some(name) = named.name.as_deref() else {
            let is_bare = self.findings.iter().any(|finding| finding.path.ends_with("species"));
            return Whole { table: empty(), is_bare, places: scene };
        };
        match self.species_text(name) {
            Ok(source) => {
                let own = std::mem::take(&mut self.places);
                let (table, _) = self.text(&source, &schema::species(), Some(number));
                let mut table = self.with_leaf_file(table, Some(number));
                let mut places = std::mem::replace(&mut self.places, own.clone());
                // what the scene says stands before what the species says
                places.extend(own);
                if let Value::Object(table) = &mut table {
                    table.retain(|key, _| key != "name" && key != "description");
                }
                Whole { table, is_bare: false, places: Places(places) }
            }
            Err(fault) => {
                self.refuse(&named.key, None, fault);
                Whole { table: empty(), is_bare: true, places: scene }
            }
        }
    }

    fn species_text(&mut self, name: &str) -> Result<Arc<Source>, Diagnostic> {
        if let Some(text) = species::text(name) {
            let name = format!("built-in species {name}");
            return Ok(Arc::new(Source { name, text: text.to_owned() }));
        }
        if Path::new(name).extension().is_none_or(|ending| ending != "toml") {
            let what = format!("there is no built-in species \"{}\"", shown(name, QUOTED));
            let names: Vec<&str> = species::names().collect();
            let help = match spelling::nearest(name, names.iter().copied()) {
                Some(near) => format!("did you mean \"{near}\"?"),
                None => format!("built in are {}; a species file's name ends in .toml", names.join(", ")),
            };
            return Err(Diagnostic::error(Fault::Scene, what, help));
        }
        let path = asset::locate(name, &self.folder, self.roots)?;
        let (source, file) = text_file::read(&path, name)?;
        self.files.push(file);
        Ok(source)
    }

    /// Makes settings of a species' tables, and finds the files that they name.
    pub(super) fn species(
        &mut self,
        source: &Arc<Source>,
        number: usize,
        named: &Named,
        whole: &Whole,
    ) -> Option<Species> {
        let own = std::mem::replace(&mut self.places, whole.places.0.clone());
        let table = &whole.table;
        let species = (|| {
            Some(Species {
                name: named.name.clone(),
                season: self.settings(source, table, "season")?,
                tree: self.settings(source, table, "tree")?,
                leaf: self.settings(source, table, "leaf")?,
                deform: self.settings(source, table, "deform")?,
                colour: self.settings(source, table, "colour")?,
                fall: self.settings(source, table, "fall")?,
                assets: self.assets(source, number, table),
                places: whole.places.clone(),
            })
        })();
        self.places = own;
        species
    }

    /// Finds and hashes the files that a species' tables name.
    fn assets(&mut self, source: &Arc<Source>, number: usize, table: &Value) -> BTreeMap<String, asset::Asset> {
        let mut assets = BTreeMap::new();
        for (key, name) in asset::named(table) {
            let place = self.places.get(&key).cloned();
            match asset::find(&name, &self.folder, self.roots, self.limits) {
                Ok(found) => {
                    assets.insert(key, asset::Asset { place, ..found });
                }
                Err(fault) => {
                    let diagnostic = fault.at(place);
                    self.complain(source, Finding { species: Some(number), path: key, diagnostic });
                }
            }
        }
        assets
    }

    /// Makes the trees of the entries; one at the origin without any.
    pub(super) fn trees(
        &mut self,
        source: &Arc<Source>,
        roster: &Roster,
        entries: &[Map<String, Value>],
        wholes: &[Whole],
        species: &[Species],
    ) -> Option<Vec<Planted>> {
        let grown: Vec<Arc<tree::Settings>> = species.iter().map(|species| Arc::new(species.tree.clone())).collect();
        if entries.is_empty() {
            return Some(vec![Planted {
                species: 0,
                age: None,
                tree: grown[0].clone(),
                planting: Planting::default(),
            }]);
        }
        // Entries of one species and age share their settings.
        let mut aged: BTreeMap<(usize, String), Arc<tree::Settings>> = BTreeMap::new();
        let mut trees = Vec::new();
        for (entry, &number) in entries.iter().zip(&roster.of_entries) {
            let mut entry = entry.clone();
            let age = entry.remove("age");
            // Its number says it; the same species named in another place is the same tree.
            entry.remove("species");
            let planting = self.settings(source, &json!({ "trees": entry }), "trees")?;
            let tree = match &age {
                None => grown.get(number)?.clone(),
                Some(age) => {
                    let key = (number, age.to_string());
                    if !aged.contains_key(&key) {
                        let mut table = wholes.get(number)?.table.clone();
                        layers::lay(&mut table, json!({ "tree": { "age": age } }));
                        aged.insert(key.clone(), Arc::new(self.settings(source, &table, "tree")?));
                    }
                    aged[&key].clone()
                }
            };
            trees.push(Planted { species: number, age, tree, planting });
        }
        Some(trees)
    }
}
