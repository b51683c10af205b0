//! Messages for the person who wrote the scene: what is wrong, where, and how to mend it.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

/// Whose fault it is; decides the exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Fault {
    /// A wrong flag or argument.
    Usage,
    /// A scene, species or series file is wrong.
    Scene,
    /// A picture is missing, unreadable, damaged or outside the roots.
    Asset,
    /// An output could not be written.
    Output,
    /// A limit refused it.
    Limit,
    /// The program is wrong.
    Bug,
}

impl Fault {
    /// The exit code of the command line's contract.
    #[must_use]
    pub fn exit_code(self) -> u8 {
        match self {
            Self::Usage => 2,
            Self::Scene => 3,
            Self::Asset => 4,
            Self::Output => 5,
            Self::Limit => 6,
            Self::Bug => 70,
        }
    }
}

/// A text that places refer to.
#[derive(Debug, PartialEq, Eq)]
pub struct Source {
    /// The name to print: the path as the user gave it, or the `--set` argument.
    pub name: String,
    /// The whole text.
    pub text: String,
}

/// A range of bytes in a source.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The text.
    pub source: Arc<Source>,
    /// The bytes meant.
    pub span: Range<usize>,
}

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// Nothing is drawn.
    Error,
    /// Worth knowing; the run goes on.
    Warning,
}

/// One message.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// How bad it is.
    pub severity: Severity,
    /// Whose fault it is.
    pub fault: Fault,
    /// Where it stands, if it stands anywhere.
    pub place: Option<Place>,
    /// What is wrong.
    pub message: String,
    /// How to mend it; may be empty.
    pub help: String,
}

impl Diagnostic {
    /// An error without a place.
    #[must_use]
    pub fn error(fault: Fault, message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { severity: Severity::Error, fault, place: None, message: message.into(), help: help.into() }
    }

    /// A warning without a place.
    #[must_use]
    pub fn warning(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(Fault::Scene, message, help) }
    }

    /// The same message at a place.
    #[must_use]
    pub fn at(mut self, place: Option<Place>) -> Self {
        self.place = place;
        self
    }
}

/// Several messages, at least one of them an error: the failure of anything that checks all before it gives up.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostics(pub Vec<Diagnostic>);

impl Diagnostics {
    /// The exit code: that of the first error.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        let first = self.0.iter().find(|d| d.severity == Severity::Error);
        first.map_or(Fault::Bug, |d| d.fault).exit_code()
    }
}

impl From<Diagnostic> for Diagnostics {
    fn from(diagnostic: Diagnostic) -> Self {
        Self(vec![diagnostic])
    }
}

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let texts: Vec<&str> = self.0.iter().map(|d| d.message.as_str()).collect();
        write!(f, "{}", texts.join("; "))
    }
}

impl std::error::Error for Diagnostics {}
