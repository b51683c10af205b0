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

/// A flat band of triangles along a line: a stalk.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Strip {
    /// The centre line from the blade's joint outwards, metres.
    pub line: Vec<DVec2>,
    /// Vertices, two for each point of the line: its left and its right, metres.
    pub positions: Vec<DVec2>,
    /// Vertex numbers of each triangle, counter-clockwise seen from +z.
    pub triangles: Vec<[u32; 3]>,
}

/// A blade as the leaf stage hands it on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Blade {
    /// The mesh, with the joint of the petiole at the origin.
    pub mesh: FlatMesh,
    /// The outline, densely sampled and counter-clockwise, metres.
    pub outline: Vec<DVec2>,
    /// The outlines of gaps that are seen through the blade, densely sampled, metres.
    pub holes: Vec<Vec<DVec2>>,
    /// The key points of outline and gaps, metres.
    pub keys: Vec<DVec2>,
    /// Veins, thick ones first.
    pub veins: Vec<Vein>,
    /// The mask map by the mesh's texture coordinates: white stays, black moves most. The mesh's greys are read from it.
    pub mask: Picture,
    /// The stalk as a strip of its own, if a scan shows it.
    pub petiole: Option<Strip>,
    /// The user's scan laid out by the mesh's texture coordinates; clear where no leaf is, in the colour of the leaf nearby.
    pub scan: Option<Picture>,
}
