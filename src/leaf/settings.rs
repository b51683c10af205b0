//! The keys of `[leaf]`.

use crate::leaf::mask::Mask;
use crate::leaf::teeth::Teeth;
use crate::{choice, settings};

choice! {
    /// How the main veins of a blade are laid out.
    pub enum Venation {
        /// Palmate if at least three lobes stand out from the joint, else pinnate.
        Auto = "auto",
        /// One midrib with secondaries, whatever the lobes: oaks, birch, beech.
        Pinnate = "pinnate",
        /// Equal veins that fork again and again from the joint, no midrib: ginkgo.
        Forking = "forking",
    }
}

choice! {
    /// How a blade is cut into triangles.
    pub enum Meshing {
        /// Triangles of even size, by rounds of relocation and reconnection.
        Even = "even",
        /// The constrained Delaunay triangulation of the points on the outline alone, long and narrow triangles and all.
        Delaunay = "delaunay",
    }
}

settings! {
    /// A vein of a blade.
    pub struct VeinLine {
        /// 1 for a midrib or main vein, 2 for its branches, 3 for the net between.
        order: u32 = 1, range 1 => 3;
        /// Points from the thick end to the thin one.
        points: Vec<[f64; 2]> = Vec::new(), unit "mm", range -2000.0 => 2000.0;
        /// Width at the thick end.
        width: f64 = 1.0, unit "mm", range 0.0 => 100.0;
        /// Width at the thin end.
        end_width: f64 = 0.25, unit "mm", range 0.0 => 100.0;
    }
}

settings! {
    /// The blade's shape and its mesh.
    pub struct Settings {
        /// Key points of the outline in order, the joint of the petiole at the origin, the tip towards +y.
        outline: Option<Vec<[f64; 2]>> = None, unit "mm", range -2000.0 => 2000.0;
        /// A scan from which outline and texture are taken; wins over `outline`.
        picture: Option<String> = None;
        /// A traced leaf as `leafseason leaf` writes it: its keys lie below those that stand here.
        file: Option<String> = None;
        /// Key points of the gaps that are seen through the blade, each a closed line like `outline`.
        holes: Vec<Vec<[f64; 2]>> = Vec::new(), unit "mm", range -2000.0 => 2000.0;
        /// Centre line of the petiole from the joint outwards, each point with the width there: x, y, width.
        petiole: Vec<[f64; 3]> = Vec::new(), unit "mm", range -2000.0 => 2000.0;
        /// The veins, thick ones first. Found in the picture, or drawn from the outline, when there are none here.
        veins: Vec<VeinLine> = Vec::new();
        /// Where the petiole joins the blade in `picture`, from its upper left corner; found when absent. Beside an
        /// `outline` it only tells where the scan had it.
        joint: Option<[f64; 2]> = None, unit "px", range 0.0 => 1e6;
        /// A grey picture over the blade: white stays, black moves most. Derived from veins and margin when absent.
        mask: Option<String> = None;
        /// The blade's upper side as `leafseason leaf` writes it: straightened, laid out by texture coordinates, clear
        /// where no leaf is. That of `picture` when absent; painted when there is neither.
        texture: Option<String> = None;
        /// How the margin runs between the key points of `outline`.
        teeth: Teeth = Teeth::default();
        /// The law by which a mask is derived.
        mask_law: Mask = Mask::default();
        /// Length of the blade from the joint to the farthest tip, to which an outline or a scan is scaled.
        length: f64 = 75.0, unit "mm", range 1.0 => 2000.0;
        /// How the veins are laid out when they are drawn from the outline.
        venation: Venation = Venation::Auto;
        /// How the blade is cut into triangles.
        meshing: Meshing = Meshing::Even;
        /// Vertices of the mesh.
        vertices: u32 = 220, range 12 => 20000;
        /// Length of edges about the joint, where the petiole bears the blade, over that elsewhere; 1 for even ones. Meshes of less
        /// than 400 vertices are even in any case.
        joint_edges: f64 = 0.33, range 0.1 => 1.0;
        /// Most rounds of relocation and reconnection after triangulation; they end when the triangles have settled.
        iterations: u32 = 160, range 0 => 10000;
        /// Largest distance between a traced outline and the spline; a thousandth of the diagonal of the blade's bounding box,
        /// at least 1 px, when absent.
        tolerance_px: Option<f64> = None, unit "px", range 0.25 => 50.0;
        /// Key points at which the outline turns by more than this stay sharp; 180 keeps none.
        corner: f64 = 65.0, unit "degrees", range 0.0 => 180.0;
    }
}
