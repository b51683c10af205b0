//! Weather and days: the series that the scene names, and the day of a moment.

use super::super::calendar::{self, Calendar};
use super::super::checker::Finding;
use super::super::time::Time;
use super::super::{Scene, asset, text_file, time};
use super::Reader;
use crate::base::diagnostic::{Diagnostic, Fault, Place, Source};
use crate::base::settings::Complaint;
use crate::season::series::{self, Series};
use crate::season::{self, Climate};
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

    /// Finds the day of the scene's moment for its first species, once all else is known to be right.
    pub(super) fn find_moment(&mut self, source: &Arc<Source>, moment: Option<season::Moment>, scene: &mut Scene) {
        let Some(moment) = moment.filter(|_| self.findings.is_empty()) else { return };
        match season::day_of(&scene.species[0].season, &scene.weather, moment, scene.weather.first().max(0) as f64) {
            Some(day) => scene.time = Time::one(day),
            None => {
                let what = "this moment does not come in this weather";
                let complaint = Complaint::new("moment", what, "give a series that reaches over it, or a `date`");
                self.complain_of(source, "time", complaint);
            }
        }
    }

    fn complain_of(&mut self, source: &Arc<Source>, table: &str, complaint: Complaint) {
        let (path, diagnostic) = super::super::Places(self.places.clone()).diagnostic(table, complaint);
        self.complain(source, Finding { species: None, path, diagnostic });
    }
}
