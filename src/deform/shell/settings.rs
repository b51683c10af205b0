//! The keys of `[deform.shell]`.

use crate::settings;

settings! {
    /// The drying shell: what a dry leaf would like to be, and what holds it back. Lengths count in extents of the blade (the
    /// longer side of its bounding box), so that a table suits a leaf of any size and any mesh.
    pub struct Settings {
        /// Curvature that the darkest part of the mask has when quite dry, in radians for each extent: 15 rolls a margin to a
        /// radius of a fifteenth of the blade. Negative curls downwards.
        curl: f64 = 15.0, range -1000.0 => 1000.0;
        /// Thickness of the blade's upper layer over that of the lower one; `curl` is that of layers alike.
        upper_thickness: f64 = 1.0, range 0.01 => 100.0;
        /// Stiffness of the upper layer over that of the lower one.
        upper_stiffness: f64 = 1.0, range 0.01 => 100.0;
        /// Share of the curl that goes across the midrib (the blade's long axis) instead of across the nearest veins: with 1 the
        /// blade rolls up as a whole, with 0 each lobe and margin for itself.
        roll: f64 = 0.05, range 0.0 => 1.0;
        /// Share of the curl that goes all ways alike where the mask is darkest, hence at tips and margins: 0 rolls, 1 cups.
        cupping: f64 = 0.4, range 0.0 => 1.0;
        /// Strain by which the darkest part of the mask shrinks in its plane when quite dry; veins do not.
        shrink: f64 = 0.14, range 0.0 => 0.5;
        /// How far drying runs ahead at the margin: where the blade is deepest it is the state's dryness to the power of one
        /// more than this.
        front: f64 = 0.5, range 0.0 => 4.0;
        /// How much shapes of one state differ in curl, direction and twist: 0 not at all, 1 as leaves of one tree do.
        variation: f64 = 1.0, range 0.0 => 3.0;
        /// Share of the shapes that curl the other way.
        reversed: f64 = 0.2, range 0.0 => 1.0;
        /// Thickness of the blade in extents: sets how much harder it is to stretch than to bend. Real blades are near 0.003;
        /// larger ones solve faster and differ little in shape (6 per cent of the deformation at 0.01).
        thickness: f64 = 0.01, range 1e-4 => 0.5;
        /// Poisson ratio of bending.
        poisson_ratio: f64 = 0.33, range 0.0 => 0.49;
        /// Bending stiffness of a vein along itself, in units of the blade's.
        vein_stiffness: f64 = 200.0, range 0.0 => 1e4;
        /// Weight of the blade, pressing towards its lower side: weight of a unit of area times the cube of the extent over the
        /// bending stiffness. A strip held at one end sinks by an eighth of this for small values.
        gravity: f64 = 0.0, range -1e4 => 1e4;
        /// Accuracy: the solver ends when its last step moves no vertex by more than this share of the extent. That step is the
        /// error of the one before it; the error left after it is smaller by one or two orders.
        tolerance: f64 = 3e-4, range 1e-9 => 0.1;
        /// Most steps of the solver towards one shape before it is refused.
        iterations: u32 = 200, range 1 => 100000;
    }
}
