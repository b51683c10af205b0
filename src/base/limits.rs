//! Limits that stand before an allocation. They are the operator's policy: flags raise them, a scene cannot.

use thiserror::Error;

/// What a limit bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// Symbols of the L-system's last string.
    Symbols,
    /// Leaves of a tree.
    Leaves,
    /// Pixels of a picture that is drawn.
    Pixels,
    /// Pixels of a picture that is read.
    PicturePixels,
    /// Vertices of a leaf's mesh.
    Vertices,
    /// Time steps of a deformation.
    Steps,
    /// Frames of a scene.
    Frames,
    /// Bytes of memory, predicted.
    Memory,
}

/// Every limit, in the order of the command line's help.
pub const ALL_LIMITS: [Limit; 8] = [
    Limit::Symbols,
    Limit::Leaves,
    Limit::Pixels,
    Limit::PicturePixels,
    Limit::Vertices,
    Limit::Steps,
    Limit::Frames,
    Limit::Memory,
];

impl Limit {
    /// The name on the command line, `--limit NAME=N`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Symbols => "symbols",
            Self::Leaves => "leaves",
            Self::Pixels => "pixels",
            Self::PicturePixels => "picture-pixels",
            Self::Vertices => "vertices",
            Self::Steps => "steps",
            Self::Frames => "frames",
            Self::Memory => "memory",
        }
    }

    /// What is counted, for messages.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::PicturePixels => "pixels",
            Self::Memory => "bytes of memory",
            _ => self.name(),
        }
    }

    /// The flag that raises the limit to `wanted`.
    #[must_use]
    pub fn flag(self, wanted: f64) -> String {
        match self {
            Self::Memory => format!("--memory-limit {}M", (wanted / 1e6).ceil()),
            _ => format!("--limit {}={wanted:.0}", self.name()),
        }
    }
}

/// A limit that refused something.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{what} needs {wanted:.0} {unit}, the limit is {allowed:.0}", unit = .limit.unit())]
pub struct Refusal {
    /// Which limit.
    pub limit: Limit,
    /// What asked for too much.
    pub what: String,
    /// What it asked for (a prediction may exceed any integer type).
    pub wanted: f64,
    /// What is allowed.
    pub allowed: f64,
}

impl Refusal {
    /// How to mend it.
    #[must_use]
    pub fn help(&self) -> String {
        format!("ask for less, or raise the limit with {}", self.limit.flag(self.wanted))
    }
}

/// The limits in force.
#[derive(Clone, Debug, PartialEq)]
pub struct Limits([f64; ALL_LIMITS.len()]);

impl Default for Limits {
    fn default() -> Self {
        Self([2e7, 2e6, 2.7e8, 1e8, 2e5, 1e7, 1e6, 4e9])
    }
}

impl Limits {
    /// The value of a limit.
    #[must_use]
    pub fn get(&self, limit: Limit) -> f64 {
        self.0[limit as usize]
    }

    /// Sets a limit.
    pub fn set(&mut self, limit: Limit, value: f64) {
        self.0[limit as usize] = value;
    }

    /// Allows `wanted` or refuses it.
    ///
    /// # Errors
    /// A [`Refusal`] when `wanted` exceeds the limit or is not a number.
    pub fn allow(&self, limit: Limit, what: &str, wanted: f64) -> Result<(), Refusal> {
        let allowed = self.get(limit);
        if wanted <= allowed { Ok(()) } else { Err(Refusal { limit, what: what.to_owned(), wanted, allowed }) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_flag_in_the_help_is_enough() {
        let mut limits = Limits::default();
        let refusal = limits.allow(Limit::Symbols, "tree.rules", 3e7).unwrap_err();
        assert_eq!(refusal.help(), "ask for less, or raise the limit with --limit symbols=30000000");
        limits.set(Limit::Symbols, 3e7);
        assert_eq!(limits.allow(Limit::Symbols, "tree.rules", 3e7), Ok(()));
    }

    #[test]
    fn not_a_number_is_refused() {
        assert!(Limits::default().allow(Limit::Leaves, "x", f64::NAN).is_err());
    }
}
