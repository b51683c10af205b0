//! The families of studies: what the command line offers and `study` measures.

use clap::ValueEnum;

/// What is studied.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Family {
    /// Ways to a leaf's shape: error against work.
    Deform,
    /// How long a step may be, and the matrix of stiff and extreme cases.
    Stability,
    /// The seasons' chain: the paper's step against the exact law.
    Chain,
    /// Meshes of blades: vertices against error.
    Mesh,
    /// Pictures: samples and level of detail against error.
    Raster,
    /// What scenes do not need, left out and measured.
    LeftOut,
    /// The error that scenes ask for against the one they get.
    Quality,
    /// The species as trees at 10, 25 and 60 years: stature, leaves, crown.
    Trees,
    /// All of them.
    #[default]
    All,
}

impl Family {
    /// Whether who asks for this asks for `other` too.
    #[must_use]
    pub fn includes(self, other: Self) -> bool {
        self == Self::All || self == other
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_are_all_and_each_is_itself() {
        let each = || Family::value_variants().iter().copied();
        assert!(each().all(|family| Family::All.includes(family)));
        for family in each().filter(|family| *family != Family::All) {
            assert!(each().all(|other| family.includes(other) == (family == other)));
        }
    }
}
