//! Reads a scene: texts -> checked tables -> layers -> settings -> what the stages say of them. Every fault that can be found
//! is found before it gives up.

use super::checker::{Checker, Finding};
use super::{
    Scene, TextFile, asset, assignment, bounds, complaint, document, layers, schema, spelling, text_file, time,
};
use crate::base::diagnostic::{Diagnostic, Diagnostics, Fault, Place, Source};
use crate::base::limits::Limits;
use crate::base::message::shown;
use crate::base::settings::Schema;
use crate::species;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Reads and resolves a scene. `sets` are the arguments of `--set`, `roots` those of `--asset-root`. Beside the scene come
/// warnings.
///
/// # Errors
/// Every fault of the scene, its species file, the assignments and the files they name, sorted by place.
pub fn read(
    path: &Path,
    sets: &[String],
    roots: &[PathBuf],
    limits: &Limits,
) -> Result<(Scene, Vec<Diagnostic>), Diagnostics> {
    let mut reader = Reader {
        folder: folder(path),
        roots,
        limits,
        findings: Vec::new(),
        places: BTreeMap::new(),
        files: Vec::new(),
    };
    let (source, file) = text_file::read(path, &path.to_string_lossy())?;
    reader.files.push(file);
    let keys = schema::scene();
    let (mut above, is_sound) = reader.text(&source, &keys);
    let order = sets.iter().map(|set| assignment::source(set)).collect::<Vec<_>>();
    let assigned = reader.assignments(&order, &keys);
    layers::lay(&mut above, assigned);
    let resolved = if is_sound { reader.resolve(&source, above) } else { None };
    match (resolved, reader.findings.is_empty()) {
        (Some(mut scene), true) => {
            scene.name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let warnings = warnings(&scene);
            Ok((scene, warnings))
        }
        _ => Err(Diagnostics(sorted(reader.findings, &source, &order))),
    }
}

/// What has been found so far.
struct Reader<'a> {
    folder: PathBuf,
    roots: &'a [PathBuf],
    limits: &'a Limits,
    findings: Vec<Finding>,
    places: BTreeMap<String, Place>,
    files: Vec<TextFile>,
}

impl Reader<'_> {
    /// Checks a text against its keys; returns what is right of it, and whether the rest can be judged.
    fn text(&mut self, source: &Arc<Source>, keys: &Schema) -> (Value, bool) {
        let document = document::parse(source);
        self.findings.extend(document.faults.into_iter().map(unowned));
        if !document.is_sound {
            return (Value::Object(Map::new()), false);
        }
        let mut checker = Checker::new(source, keys, self.limits);
        let value = checker.walk(document.table.get_ref());
        self.take(checker);
        (value, true)
    }

    fn assignments(&mut self, sources: &[Arc<Source>], keys: &Schema) -> Value {
        let mut all = Value::Object(Map::new());
        for source in sources {
            match assignment::read(source, keys, self.limits) {
                Ok((value, checker)) => {
                    self.take(checker);
                    layers::lay(&mut all, value);
                }
                Err(faults) => self.findings.extend(faults.into_iter().map(unowned)),
            }
        }
        all
    }

    fn take(&mut self, checker: Checker<'_>) {
        self.findings.extend(checker.findings);
        self.places.extend(checker.places);
    }

    /// Lays the species below, makes settings of all, and asks the stages.
    fn resolve(&mut self, source: &Arc<Source>, above: Value) -> Option<Scene> {
        let name = above.get("species").and_then(Value::as_str).map(str::to_owned);
        let mut whole = self.species(source, name.as_deref(), &above);
        layers::lay(&mut whole, above);
        let mut scene = self.scene(source, &whole)?;
        self.name_assets(&mut scene, &whole);
        // Without its species a scene lacks much that its author did not forget.
        let is_bare = self.findings.iter().any(|finding| finding.path == "species");
        let from_species = |table: &str| matches!(table, "season" | "tree" | "leaf" | "deform" | "colour");
        for (table, one) in complaint::complaints(&scene).into_iter().filter(|one| !is_bare || !from_species(one.0)) {
            let (path, diagnostic) = complaint::diagnostic(&self.places, table, one);
            self.complain(source, path, diagnostic);
        }
        for (key, refusal) in bounds::scene(self.limits, &scene) {
            let diagnostic = Diagnostic::error(Fault::Limit, refusal.to_string(), refusal.help());
            let place = complaint::nearest(&self.places, key).map(|(_, place)| place.clone());
            self.complain(source, key.to_owned(), diagnostic.at(place));
        }
        scene.files = std::mem::take(&mut self.files);
        scene.places = std::mem::take(&mut self.places);
        Some(scene)
    }

    /// Adds what was found of well-typed settings, unless a fault of the same key, or one around or within it, led to it.
    fn complain(&mut self, source: &Arc<Source>, path: String, mut diagnostic: Diagnostic) {
        let covers = |a: &str, b: &str| a == b || b.strip_prefix(a).is_some_and(|rest| rest.starts_with('.'));
        let is_known = |finding: &Finding| covers(&finding.path, &path) || covers(&path, &finding.path);
        if !self.findings.iter().any(is_known) {
            diagnostic.place = diagnostic.place.or_else(|| beginning(source));
            self.findings.push(Finding { path, diagnostic });
        }
    }

    /// The species' table; empty without one.
    fn species(&mut self, scene: &Arc<Source>, name: Option<&str>, above: &Value) -> Value {
        let empty = Value::Object(Map::new());
        let Some(name) = name else {
            let is_whole = above.as_object().is_some_and(layers::is_whole_tree);
            if !is_whole {
                let what = "the scene names no species";
                let help = "write species = \"red-maple\" (`leafseason species` lists them), or a whole [tree] with axiom and rules";
                let fault = Diagnostic::error(Fault::Scene, what, help);
                self.complain(scene, "species".to_owned(), fault.at(None));
            }
            return empty;
        };
        let place = self.places.get("species").cloned();
        match self.species_text(name) {
            Ok(source) => {
                let mut own = std::mem::take(&mut self.places);
                let (mut table, _) = self.text(&source, &schema::species());
                // what the scene says stands before what the species says
                self.places.append(&mut own);
                if let Value::Object(table) = &mut table {
                    table.retain(|key, _| key != "name" && key != "description");
                }
                table
            }
            Err(fault) => {
                let place = fault.place.clone().or(place);
                self.findings.push(Finding { path: "species".to_owned(), diagnostic: fault.at(place) });
                empty
            }
        }
    }

    fn species_text(&mut self, name: &str) -> Result<Arc<Source>, Diagnostic> {
        if let Some(text) = species::text(name) {
            let name = format!("built-in species {name}");
            return Ok(Arc::new(Source { name, text: text.to_owned() }));
        }
        if Path::new(name).extension().is_none_or(|ending| ending != "toml") {
            let what = format!("there is no built-in species \"{}\"", shown(name, 60));
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

    /// Makes settings of the tables.
    fn scene(&mut self, source: &Arc<Source>, whole: &Value) -> Option<Scene> {
        let mut time: time::Time = self.settings(source, whole, "time")?;
        if time == time::Time::default() {
            time.day = Some(time::DEFAULT_DAY);
        }
        Some(Scene {
            name: String::new(),
            species: whole.get("species").and_then(Value::as_str).map(str::to_owned),
            seed: whole.get("seed").and_then(Value::as_u64).unwrap_or(1),
            climate: self.settings(source, whole, "climate")?,
            time,
            season: self.settings(source, whole, "season")?,
            tree: self.settings(source, whole, "tree")?,
            leaf: self.settings(source, whole, "leaf")?,
            deform: self.settings(source, whole, "deform")?,
            colour: self.settings(source, whole, "colour")?,
            camera: self.settings(source, whole, "camera")?,
            light: self.settings(source, whole, "light")?,
            image: self.settings(source, whole, "image")?,
            ground: self.settings(source, whole, "ground")?,
            output: self.settings(source, whole, "output")?,
            assets: BTreeMap::new(),
            files: Vec::new(),
            places: BTreeMap::new(),
        })
    }

    /// One table's settings; what the walk let through and serde refuses is told at the table.
    fn settings<T: DeserializeOwned>(&mut self, source: &Arc<Source>, whole: &Value, table: &str) -> Option<T> {
        let value = whole.get(table).cloned().unwrap_or_else(|| Value::Object(Map::new()));
        match serde_json::from_value(value) {
            Ok(settings) => Some(settings),
            Err(error) => {
                let place = self.places.get(table).cloned();
                let fault = Diagnostic::error(Fault::Scene, format!("[{table}]: {error}"), "").at(place);
                self.complain(source, table.to_owned(), fault);
                None
            }
        }
    }

    /// Finds and hashes the files that the settings name.
    fn name_assets(&mut self, scene: &mut Scene, whole: &Value) {
        for (key, name) in asset::named(whole) {
            match asset::find(&name, &self.folder, self.roots, self.limits) {
                Ok(mut found) => {
                    found.place = self.places.get(key).cloned();
                    scene.assets.insert(key.to_owned(), found);
                }
                Err(fault) => {
                    let place = self.places.get(key).cloned();
                    self.findings.push(Finding { path: key.to_owned(), diagnostic: fault.at(place) });
                }
            }
        }
    }
}

/// A fault that belongs to no key.
fn unowned(diagnostic: Diagnostic) -> Finding {
    Finding { path: "\0".to_owned(), diagnostic }
}

fn beginning(source: &Arc<Source>) -> Option<Place> {
    Some(Place { source: source.clone(), span: 0..0 })
}

fn folder(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if parent != Path::new("") => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// By place: the scene first, then a species file, then the assignments in their order.
fn sorted(findings: Vec<Finding>, scene: &Arc<Source>, sets: &[Arc<Source>]) -> Vec<Diagnostic> {
    let rank = |diagnostic: &Diagnostic| match &diagnostic.place {
        Some(place) if Arc::ptr_eq(&place.source, scene) => (0, place.span.start),
        Some(place) => match sets.iter().position(|set| Arc::ptr_eq(set, &place.source)) {
            Some(index) => (2 + index, place.span.start),
            None => (1, place.span.start),
        },
        None => (usize::MAX, 0),
    };
    let mut diagnostics: Vec<Diagnostic> = findings.into_iter().map(|finding| finding.diagnostic).collect();
    diagnostics.sort_by_key(rank);
    diagnostics
}

/// What is worth knowing of a good scene.
fn warnings(scene: &Scene) -> Vec<Diagnostic> {
    let mut warnings = Vec::new();
    if !scene.output.png && scene.output.gltf.is_none() {
        let fault =
            Diagnostic::warning("the scene asks for neither pictures nor glTF", "set output.png or output.gltf");
        warnings.push(fault.at(scene.place("output.png")));
    }
    warnings
}
