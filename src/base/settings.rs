//! Settings that describe themselves: one declaration gives a stage's struct, its defaults, its serde form and the schema
//! from which the scene's checker, the JSON Schema and the starter scene are made.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The kind of value a key takes.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// A finite number; whole numbers are taken too.
    Number,
    /// A whole number.
    Integer,
    /// true or false.
    Boolean,
    /// A string.
    Text,
    /// One of some words.
    Choice(&'static [&'static str]),
    /// A list of one kind, with its smallest and largest length.
    List(Box<Kind>, usize, usize),
    /// One of several kinds, told apart by their TOML type.
    Either(Vec<Kind>),
    /// A table with known keys.
    Table(Schema),
    /// A table whose keys are names of the user's choice.
    Map(Box<Kind>),
}

/// A table's keys.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Schema {
    /// What the table is.
    pub doc: String,
    /// Its keys, in the order of declaration.
    pub keys: Vec<Key>,
}

/// One key of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// Its name.
    pub name: &'static str,
    /// What it means.
    pub doc: String,
    /// The unit of its numbers; empty without one.
    pub unit: &'static str,
    /// The smallest and largest number allowed (also for numbers inside lists).
    pub range: Option<(f64, f64)>,
    /// What it takes.
    pub kind: Kind,
    /// Its default as JSON; null when it may be absent.
    pub default: serde_json::Value,
}

/// A type that can say which values it takes.
pub trait Described {
    /// The kind of value.
    fn kind() -> Kind;
}

macro_rules! described {
    ($($type:ty => $kind:expr;)*) => { $(impl Described for $type { fn kind() -> Kind { $kind } })* };
}
described! {
    f64 => Kind::Number;
    u32 => Kind::Integer;
    u64 => Kind::Integer;
    i64 => Kind::Integer;
    bool => Kind::Boolean;
    String => Kind::Text;
}

impl<T: Described> Described for Option<T> {
    fn kind() -> Kind {
        T::kind()
    }
}

impl<T: Described> Described for Vec<T> {
    fn kind() -> Kind {
        Kind::List(Box::new(T::kind()), 0, usize::MAX)
    }
}

impl<T: Described, const N: usize> Described for [T; N] {
    fn kind() -> Kind {
        Kind::List(Box::new(T::kind()), N, N)
    }
}

impl<T: Described> Described for BTreeMap<String, T> {
    fn kind() -> Kind {
        Kind::Map(Box::new(T::kind()))
    }
}

/// Something a stage's `check` found wrong in well-typed settings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Complaint {
    /// Dotted path of the key below the stage's table, for example `states.green.half_life`; empty for the table itself.
    pub key: String,
    /// Bytes within the key's string value, for texts that are parsed further (L-system rules).
    pub within: Option<std::ops::Range<usize>>,
    /// What is wrong.
    pub message: String,
    /// How to mend it.
    pub help: String,
}

impl Complaint {
    /// A complaint about a key.
    #[must_use]
    pub fn new(key: impl Into<String>, message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { key: key.into(), within: None, message: message.into(), help: help.into() }
    }
}

/// A number, or one for each corner of the climate.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(untagged)]
pub enum Corners {
    /// The same in every climate.
    Same(f64),
    /// Wet and cold, wet and warm, dry and cold, dry and warm.
    Each([f64; 4]),
}

impl Described for Corners {
    fn kind() -> Kind {
        Kind::Either(vec![Kind::Number, <[f64; 4]>::kind()])
    }
}

impl Corners {
    /// The four values: wet and cold, wet and warm, dry and cold, dry and warm.
    #[must_use]
    pub fn values(self) -> [f64; 4] {
        match self {
            Self::Same(value) => [value; 4],
            Self::Each(values) => values,
        }
    }
}

/// Joins the lines of a doc comment into one text.
#[must_use]
pub fn joined(lines: &[&str]) -> String {
    lines.iter().map(|line| line.trim()).collect::<Vec<_>>().join(" ")
}

/// Declares a settings struct. Each key has a doc comment, a type, a default and, where they make sense, a unit and a range:
///
/// ```
/// leafseason::settings! {
///     /// A pond.
///     pub struct Pond {
///         /// Depth of the water.
///         depth: f64 = 2.0, unit "m", range 0.1 => 50.0;
///         /// Whether there are fish.
///         fish: bool = true;
///     }
/// }
/// assert_eq!(Pond::default().depth, 2.0);
/// assert_eq!(Pond::schema().keys[0].range, Some((0.1, 50.0)));
/// ```
#[macro_export]
macro_rules! settings {
    ($(#[doc = $doc:literal])* pub struct $name:ident { $(
        $(#[doc = $key_doc:literal])*
        $key:ident : $type:ty = $default:expr $(, unit $unit:literal)? $(, range $low:expr => $high:expr)? ;
    )* }) => {
        $(#[doc = $doc])*
        #[derive(Clone, Debug, PartialEq, ::serde::Deserialize, ::serde::Serialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $name { $(
            $(#[doc = $key_doc])*
            $(#[doc = concat!("Unit: ", $unit, ".")])?
            $(#[doc = concat!("Range: ", stringify!($low), " to ", stringify!($high), ".")])?
            pub $key: $type,
        )* }

        impl Default for $name {
            fn default() -> Self {
                Self { $($key: $default,)* }
            }
        }

        impl $name {
            /// The keys of this table.
            #[must_use]
            pub fn schema() -> $crate::base::settings::Schema {
                let defaults = ::serde_json::to_value(Self::default()).unwrap_or_default();
                $crate::base::settings::Schema {
                    doc: $crate::base::settings::joined(&[$($doc),*]),
                    keys: vec![$($crate::base::settings::Key {
                        name: stringify!($key),
                        doc: $crate::base::settings::joined(&[$($key_doc),*]),
                        unit: $crate::settings!(@unit $($unit)?),
                        range: $crate::settings!(@range $($low => $high)?),
                        kind: <$type as $crate::base::settings::Described>::kind(),
                        default: defaults.get(stringify!($key)).cloned().unwrap_or_default(),
                    },)*],
                }
            }
        }

        impl $crate::base::settings::Described for $name {
            fn kind() -> $crate::base::settings::Kind {
                $crate::base::settings::Kind::Table(Self::schema())
            }
        }
    };
    (@unit) => { "" };
    (@unit $unit:literal) => { $unit };
    (@range) => { None };
    (@range $low:expr => $high:expr) => { Some(($low as f64, $high as f64)) };
}

/// Declares an enum of words that a key may take; each variant names its word.
#[macro_export]
macro_rules! choice {
    ($(#[doc = $doc:literal])* pub enum $name:ident { $( $(#[doc = $variant_doc:literal])* $variant:ident = $word:literal, )* }) => {
        $(#[doc = $doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, ::serde::Deserialize, ::serde::Serialize)]
        pub enum $name { $( $(#[doc = $variant_doc])* #[serde(rename = $word)] $variant, )* }

        impl $crate::base::settings::Described for $name {
            fn kind() -> $crate::base::settings::Kind {
                $crate::base::settings::Kind::Choice(&[$($word),*])
            }
        }
    };
}
