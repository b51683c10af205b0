//! The tree stage: L-system grammar -> derivation -> turtle -> skeleton, leaf sites and the mesh of the wood.

use crate::settings;
use std::collections::BTreeMap;

settings! {
    /// The tree's growth. With an L-system of its own a scene needs no species.
    pub struct Settings {
        /// Age; when given, the number of derivation steps, one a year.
        age: Option<u32> = None, unit "a", range 1 => 200;
        /// The string that growth starts from.
        axiom: String = String::new();
        /// Rewriting rules, `predecessor : condition -> successor`, with a weight as in `A(l) : l > 1 : 0.3 -> F(l)A(l)`.
        rules: Vec<String> = Vec::new();
        /// Named numbers that rules may use.
        constants: BTreeMap<String, f64> = BTreeMap::new(), range -1e9 => 1e9;
        /// Derivation steps; `age` wins.
        iterations: u32 = 10, range 0 => 200;
        /// The angle of turns without an argument.
        angle: f64 = 25.0, unit "°", range -360.0 => 360.0;
        /// Sum of child diameters to this power equals the parent's (pipe model); used where the rules set no width.
        radius_exponent: f64 = 2.0, range 1.0 => 4.0;
        /// Diameter of the thinnest twigs.
        twig_diameter: f64 = 2.0, unit "mm", range 0.1 => 100.0;
        /// How strongly new wood bends upwards, towards the light; negative bends down.
        tropism: f64 = 0.0, unit "1/m", range -10.0 => 10.0;
        /// Length of the petiole.
        petiole: f64 = 60.0, unit "mm", range 0.0 => 500.0;
        /// Angle between a twig and its petioles.
        petiole_angle: f64 = 50.0, unit "°", range 0.0 => 180.0;
        /// Mean inclination of blades below the horizontal.
        blade_inclination: f64 = 35.0, unit "°", range -90.0 => 90.0;
        /// Relative spread of leaf sizes, standard deviation over mean.
        leaf_size_spread: f64 = 0.22, range 0.0 => 0.6;
    }
}
