//! What a stage tells of its work: the report's rows are made of these.

use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;

/// How wrong a result is, and how that is known.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ErrorFigure {
    /// What is measured, for example `total variation`.
    pub metric: String,
    /// The error that was made.
    pub value: f64,
    /// Unit of `value`.
    pub unit: String,
    /// The bound that was asked for, if any.
    pub bound: Option<f64>,
    /// How the error was measured or estimated.
    pub how: String,
}

/// The figures of one run of a stage.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Figures {
    /// How many things were made: leaves, shapes, textures, pixels.
    pub items: u64,
    /// The error of an approximating stage.
    pub error: Option<ErrorFigure>,
    /// Further figures by name.
    pub values: BTreeMap<String, Value>,
    /// What the person should know of the result.
    pub notes: Vec<String>,
}

impl Figures {
    /// Figures with a count and nothing else.
    #[must_use]
    pub fn of(items: u64) -> Self {
        Self { items, ..Self::default() }
    }

    /// Adds a named figure. Numbers that are not finite become null in JSON.
    #[must_use]
    pub fn with(mut self, name: &str, value: impl Into<Value>) -> Self {
        self.values.insert(name.to_owned(), value.into());
        self
    }
}
