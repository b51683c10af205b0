//! The leaf stage: outline (given or traced from a picture) -> closed B-spline -> Delaunay -> even mesh; veins and mask.

use crate::settings;

settings! {
    /// The blade's shape and its mesh.
    pub struct Settings {
        /// Key points of the outline in order, the joint of the petiole at the origin, the tip towards +y.
        outline: Option<Vec<[f64; 2]>> = None, unit "mm", range -2000.0 => 2000.0;
        /// A scan from which outline and texture are taken; wins over `outline`.
        picture: Option<String> = None;
        /// A grey picture over the blade: white stays, black moves most. Derived from veins and margin when absent.
        mask: Option<String> = None;
        /// Length of the blade from the joint to the farthest tip, to which an outline or a scan is scaled.
        length: f64 = 75.0, unit "mm", range 1.0 => 2000.0;
        /// Vertices of the mesh.
        vertices: u32 = 220, range 12 => 20000;
        /// Rounds of relocation and reconnection after triangulation.
        iterations: u32 = 160, range 0 => 10000;
        /// Largest distance between a traced outline and the spline.
        tolerance: f64 = 1.5, unit "px", range 0.25 => 50.0;
    }
}
