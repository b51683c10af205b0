//! The settings of a leaf from `--set leaf.KEY=VALUE` alone, for the command that traces a scan.

use super::{assignment, layers, places::Places, schema};
use crate::base::diagnostic::{Diagnostic, Diagnostics, Fault};
use crate::base::limits::Limits;
use crate::leaf::{self, Settings};
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// Keys that name another leaf, or pictures of one: the command's own argument is the scan.
const OTHERS: [&str; 7] = ["outline", "holes", "petiole", "picture", "mask", "texture", "file"];

/// Reads assignments as settings of `[leaf]`.
///
/// # Errors
/// Every fault of every assignment.
pub fn leaf_settings(sets: &[String], limits: &Limits) -> Result<Settings, Diagnostics> {
    let mut keys = schema::leaf_file();
    let mut table = Value::Object(Map::new());
    let (mut faults, mut places) = (Vec::new(), BTreeMap::new());
    if let Some(crate::base::settings::Kind::Table(inner)) = keys.keys.first_mut().map(|key| &mut key.kind) {
        inner.keys.retain(|key| !OTHERS.contains(&key.name));
    }
    let sources: Vec<_> = sets.iter().map(|set| assignment::source(set)).collect();
    for source in &sources {
        match assignment::read(source, &keys, limits) {
            Ok((value, checker)) => {
                faults.extend(checker.findings.into_iter().map(|finding| finding.diagnostic));
                places.extend(checker.places);
                layers::lay(&mut table, value);
            }
            Err(found) => faults.extend(found),
        }
    }
    let leaf = table.get("leaf").cloned().unwrap_or_else(|| Value::Object(Map::new()));
    match serde_json::from_value::<Settings>(leaf) {
        Ok(settings) if faults.is_empty() => {
            let places = Places(places);
            let complaints = leaf::check(&settings).into_iter();
            let faults: Vec<Diagnostic> = complaints.map(|one| places.diagnostic("leaf", one).1).collect();
            if faults.is_empty() { Ok(settings) } else { Err(Diagnostics(faults)) }
        }
        Err(error) if faults.is_empty() => Err(Diagnostic::error(Fault::Scene, format!("[leaf]: {error}"), "").into()),
        _ => Err(Diagnostics(faults)),
    }
}
