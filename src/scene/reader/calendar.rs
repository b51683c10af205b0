//! Weather and days: the series that the scene names, and the day of a moment.

use super::super::calendar::{self, Calendar};
use super::super::checker::Finding;
use super::super::{asset, text_file, time};
use super::Reader;
use crate::base::diagnostic::{Diagnostic, Fault, Place, Source};
use crate::base::settings::Complaint;
use crate::season::Climate;
use crate::season::series::{self, Series};
use serde_json::Value;
use std::sync::Arc;

impl Reader<'_> {
    /// The weather and days of a scene; a constant climate where it has faults, so that the rest can be judged.
    pub(super) fn calendar(&mut self, source: &Arc<Source>, above: &Value) -> Calendar {
        self.resolved_calendar(source, above).unwrap_or_else(Calendar::constant)
    }

    fn resolved_calendar(&mut self, source: &Arc<Source>, above: &Value) -> Option<Calendar> {
        let climate: Climate = self.settings(source, above, "climate")?;
        let time: time::Settings = self.settings(source, above, "time")?;
        let series = match &climate.series {
            Some(name) => Some(self.series(name)?),
            None => None,
        };
        match calendar::resolve(&climate, &time, series) {
            Ok(calendar) => Some(calendar),
            Err(complaints) => {
                complaints.into_iter().for_each(|(table, complaint)| self.complain_of(source, table, complaint));
                None
            }
        }
    }

    fn series(&mut self, name: &str) -> Option<Series> {
        let read = asset::locate(name, &self.folder, self.roots).and_then(|path| text_file::read(&path, name));
        let (text, file) = match read {
            Ok(read) => read,
            Err(fault) => {
                self.refuse("climate.series", None, fault);
                return None;
            }
        };
        self.files.push(file);
        match series::read(&text.text) {
            Ok(series) => Some(series),
            Err(faults) => {
                for fault in faults {
                    let place = Place { source: text.clone(), span: fault.span };
                    let diagnostic = Diagnostic::error(Fault::Scene, fault.message, fault.help).at(Some(place));
                    self.refuse("climate.series", None, diagnostic);
                }
                None
            }
        }
    }

    fn complain_of(&mut self, source: &Arc<Source>, table: &str, complaint: Complaint) {
        let (path, diagnostic) = super::super::Places(self.places.clone()).diagnostic(table, complaint);
        self.complain(source, Finding { species: None, path, diagnostic });
    }
}
