//! What the tree stands on.

use crate::{choice, settings};

choice! {
    /// What covers the ground.
    pub enum Cover {
        /// A meadow, fading into the distance.
        Grass = "grass",
        /// Bare soil.
        Soil = "soil",
        /// Nothing: the tree stands before the sky.
        None = "none",
    }
}

settings! {
    /// The ground.
    pub struct Ground {
        /// What covers it.
        kind: Cover = Cover::Grass;
        /// Whether a wood closes it off in the distance.
        wood: bool = true;
    }
}
