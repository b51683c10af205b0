//! Reads a scene: texts -> checked tables -> layers -> settings -> what the stages say of them. Every fault that can be found
//! is found before it gives up.

use super::calendar::Calendar;
use super::checker::{Checker, Finding};
use super::{
    Places, Planted, Scene, Species, TextFile, assignment, bounds, complaint, document, layers, schema, sheet,
    text_file,
};
use crate::base::diagnostic::{Diagnostic, Diagnostics, Fault, Place, Source};
use crate::base::limits::Limits;
use crate::base::settings::Schema;
use roster::Whole;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

mod calendar;
mod leaf_file;
mod roster;

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
    let (mut above, is_sound) = reader.text(&source, &keys, None);
    let order = sets.iter().map(|set| assignment::source(set)).collect::<Vec<_>>();
    let assigned = reader.assignments(&order, &keys);
    layers::lay(&mut above, assigned);
    let resolved = if is_sound { reader.resolve(&source, above) } else { None };
    match (resolved, reader.findings.is_empty()) {
        (Some(mut scene), true) => {
            scene.name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let warnings = sheet::settle(&mut scene).into_iter().chain(warnings(&scene)).collect();
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
    /// Checks a text against its keys; returns what is right of it, and whether the rest can be judged. `species` is the
    /// number of the species whose text it is.
    fn text(&mut self, source: &Arc<Source>, keys: &Schema, species: Option<usize>) -> (Value, bool) {
        let document = document::parse(source);
        self.findings.extend(document.faults.into_iter().map(unowned));
        if !document.is_sound {
            return (Value::Object(Map::new()), false);
        }
        let mut checker = Checker::new(source, keys, self.limits);
        let value = checker.walk(document.table.get_ref());
        checker.findings.iter_mut().for_each(|finding| finding.species = species);
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
        for finding in checker.findings {
            if !self.findings.iter().any(|known| known.diagnostic == finding.diagnostic) {
                self.findings.push(finding);
            }
        }
        self.places.extend(checker.places);
    }

    /// Resolves a scene, and each cell of its sheet as the scene with the cell's keys laid over it.
    fn resolve(&mut self, source: &Arc<Source>, mut above: Value) -> Option<Scene> {
        let cells = above.as_object_mut().and_then(|above| above.remove("cells"));
        let cells = cells.as_ref().and_then(Value::as_array).cloned().unwrap_or_default();
        let places = self.places.clone();
        let mut scene = self.resolve_one(source, above.clone());
        for (number, cell) in cells.into_iter().enumerate() {
            self.places.clone_from(&places);
            let begin = format!("cells.{number}.");
            let own =
                places.iter().filter_map(|(key, place)| Some((key.strip_prefix(&begin)?.to_owned(), place.clone())));
            self.places.extend(own);
            let mut layered = above.clone();
            layers::lay(&mut layered, cell);
            let known = self.findings.len();
            let cell = self.resolve_one(source, layered);
            // The same key may be at fault in several cells.
            self.findings[known..].iter_mut().for_each(|finding| finding.path.insert_str(0, &begin));
            scene = scene.zip(cell).map(|(mut scene, cell)| {
                scene.cells.push(cell);
                scene
            });
        }
        let mut scene = scene?;
        for complaint in sheet::check(&scene) {
            let (path, diagnostic) = scene.places.diagnostic("", complaint);
            self.complain(source, Finding { species: None, path, diagnostic });
        }
        scene.files = std::mem::take(&mut self.files);
        Some(scene)
    }

    /// Lays the species below, makes settings of all, and asks the stages.
    fn resolve_one(&mut self, source: &Arc<Source>, mut above: Value) -> Option<Scene> {
        let entries = roster::taken(&mut above);
        let above = self.with_leaf_file(above, None);
        let roster = roster::Roster::new(self, source, &above, &entries);
        let own = self.places.clone();
        let mut below = above.clone();
        if let Value::Object(below) = &mut below {
            // the scene's own table of this name is no species' table: it stands beside that, not over it
            below.remove("fall");
        }
        let mut species = Vec::new();
        let mut wholes = Vec::new();
        for (number, named) in roster.species.iter().enumerate() {
            let mut whole = self.species_table(number, named);
            layers::lay(&mut whole.table, below.clone());
            species.push(self.species(source, number, named, &whole));
            wholes.push(whole);
        }
        let species: Vec<Species> = species.into_iter().collect::<Option<_>>()?;
        let trees = self.trees(source, &roster, &entries, &wholes, &species)?;
        self.places = own;
        let calendar = self.calendar(source, &above);
        let mut scene = self.scene(source, &above, calendar, species, trees)?;
        scene.places = Places(std::mem::take(&mut self.places));
        self.judge(source, &scene, &wholes);
        Some(scene)
    }

    /// Asks the stages and the limits what is wrong with well-typed settings.
    fn judge(&mut self, source: &Arc<Source>, scene: &Scene, wholes: &[Whole]) {
        for (table, one) in complaint::of_scene(scene) {
            let (path, diagnostic) = scene.places.diagnostic(&table, one);
            self.complain(source, Finding { species: None, path, diagnostic });
        }
        for (number, (species, whole)) in scene.species.iter().zip(wholes).enumerate() {
            // Without its species' table much is missing that the author did not forget.
            let found = if whole.is_bare { Vec::new() } else { complaint::of_species(species, &scene.weather) };
            for (table, one) in found {
                let (path, diagnostic) = species.places.diagnostic(table, one);
                self.complain(source, Finding { species: Some(number), path, diagnostic });
            }
        }
        for (key, refusal) in bounds::scene(self.limits, scene) {
            let diagnostic = Diagnostic::error(Fault::Limit, refusal.to_string(), refusal.help());
            let diagnostic = diagnostic.at(scene.place(key));
            self.complain(source, Finding { species: None, path: key.to_owned(), diagnostic });
        }
        if let (true, Some((table, one))) = (self.findings.is_empty(), complaint::of_planting(scene)) {
            let (path, diagnostic) = scene.places.diagnostic(&table, one);
            self.complain(source, Finding { species: None, path, diagnostic });
        }
    }

    /// Adds what was found of well-typed settings, unless a fault of the same key, or one around or within it, led to it.
    fn complain(&mut self, source: &Arc<Source>, mut finding: Finding) {
        let covers = |a: &str, b: &str| a == b || b.strip_prefix(a).is_some_and(|rest| rest.starts_with('.'));
        finding.diagnostic.place = finding.diagnostic.place.or_else(|| beginning(source));
        let is_known = |known: &Finding| {
            let same_tables = known.species.is_none() || known.species == finding.species;
            let same_key = covers(&known.path, &finding.path) || covers(&finding.path, &known.path);
            same_tables && same_key || known.diagnostic == finding.diagnostic
        };
        if !self.findings.iter().any(is_known) {
            self.findings.push(finding);
        }
    }

    /// Makes settings of the tables that all trees share.
    fn scene(
        &mut self,
        source: &Arc<Source>,
        above: &Value,
        calendar: Calendar,
        species: Vec<Species>,
        trees: Vec<Planted>,
    ) -> Option<Scene> {
        let seeds: Vec<u64> =
            above.get("seeds").and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_u64).collect();
        let seed = seeds.first().copied().or_else(|| above.get("seed").and_then(Value::as_u64));
        Some(Scene {
            name: String::new(),
            seed: seed.unwrap_or(1),
            seeds,
            cells: Vec::new(),
            weather: calendar.weather,
            time: calendar.time,
            species,
            trees,
            camera: self.settings(source, above, "camera")?,
            light: self.settings(source, above, "light")?,
            image: self.settings(source, above, "image")?,
            ground: self.settings(source, above, "ground")?,
            fall: self.settings(source, above, "fall")?,
            quality: self.settings(source, above, "quality")?,
            output: self.settings(source, above, "output")?,
            files: Vec::new(),
            places: Places::default(),
        })
    }

    /// One table's settings; what the walk let through and serde refuses is told at the table.
    fn settings<T: DeserializeOwned>(&mut self, source: &Arc<Source>, whole: &Value, table: &str) -> Option<T> {
        let value = whole.get(table).cloned().unwrap_or_else(|| Value::Object(Map::new()));
        match serde_json::from_value(value) {
            Ok(settings) => Some(settings),
            Err(error) => {
                let place = self.places.get(table).cloned();
                let diagnostic = Diagnostic::error(Fault::Scene, format!("[{table}]: {error}"), "").at(place);
                self.complain(source, Finding { species: None, path: table.to_owned(), diagnostic });
                None
            }
        }
    }
}

/// A fault that belongs to no key.
fn unowned(diagnostic: Diagnostic) -> Finding {
    Finding { species: None, path: "\0".to_owned(), diagnostic }
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

/// By place: the scene first, then species files in the order in which trees name them, then the assignments in theirs.
fn sorted(findings: Vec<Finding>, scene: &Arc<Source>, sets: &[Arc<Source>]) -> Vec<Diagnostic> {
    let rank = |finding: &Finding| match &finding.diagnostic.place {
        Some(place) if Arc::ptr_eq(&place.source, scene) => (0, 0, place.span.start),
        Some(place) => match sets.iter().position(|set| Arc::ptr_eq(set, &place.source)) {
            Some(index) => (2, index, place.span.start),
            None => (1, finding.species.unwrap_or(0), place.span.start),
        },
        None => (3, 0, 0),
    };
    let mut findings = findings;
    findings.sort_by_key(rank);
    findings.into_iter().map(|finding| finding.diagnostic).collect()
}

/// What is worth knowing of a good scene.
fn warnings(scene: &Scene) -> Vec<Diagnostic> {
    let mut warnings = Vec::new();
    if !scene.output.png && scene.output.gltf.is_none() && scene.output.shares.is_none() {
        let fault =
            Diagnostic::warning("the scene asks for neither pictures nor glTF", "set output.png or output.gltf");
        warnings.push(fault.at(scene.place("output.png")));
    }
    warnings
}
