//! A leaf blade: its flat mesh with what painting and placing need besides.

use crate::base::flat_mesh::FlatMesh;
use crate::base::picture::Picture;
use crate::base::vector::DVec2;

/// A vein as a polyline that thins towards its end.
#[derive(Clone, Debug, PartialEq)]
pub struct Vein {
    /// Points from the thick end to the thin end, metres in the blade's plane.
    pub points: Vec<DVec2>,
    /// Width at the thick end, metres.
    pub width: f64,
    /// Width at the thin end, metres.
    pub end_width: f64,
    /// 1 for a midrib or main vein, 2 for its branches, 3 for the net between.
    pub order: u8,
}

/// A blade as the leaf stage hands it on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Blade {
    /// The mesh, with the joint of the petiole at the origin.
    pub mesh: FlatMesh,
    /// The outline, densely sampled and counter-clockwise, metres.
    pub outline: Vec<DVec2>,
    /// Veins, thick ones first.
    pub veins: Vec<Vein>,
    /// The user's scan laid out by the mesh's texture coordinates, the background filled with leaf colour.
    pub scan: Option<Picture>,
}
