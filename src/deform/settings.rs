//! The keys of `[deform]`.

use crate::base::settings::{Described, Kind};
use crate::deform::shell;
use crate::{choice, settings};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

choice! {
    /// Which mechanics bends the leaf.
    pub enum Model {
        /// A sheet that dries, solved for its shape of least energy.
        Shell = "shell",
        /// The mass-spring system of Tang, Wu and Fan 2013, equations (1) to (3).
        Paper = "paper",
    }
}

choice! {
    /// The external force of the model "paper", which the paper does not name.
    pub enum Field {
        /// The same force on every vertex, in a fixed direction.
        Constant = "constant",
        /// A pull of the same strength on every vertex towards a fixed point.
        Point = "point",
        /// The same strength on every vertex along its upper normal, which turns as the leaf bends.
        Normal = "normal",
        /// Along the normals, upwards where the mask is dark, downwards along the veins, without resultant or torque.
        Curl = "curl",
    }
}

choice! {
    /// A word in the place of a number.
    pub enum Automatic {
        /// The program chooses.
        Auto = "auto",
    }
}

/// A number, or "auto".
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(untagged)]
pub enum Step {
    /// Chosen by the program.
    Automatic(Automatic),
    /// Fixed, in seconds.
    Seconds(f64),
}

impl Described for Step {
    fn kind() -> Kind {
        Kind::Either(vec![Kind::Number, Automatic::kind()])
    }
}

settings! {
    /// How a leaf in a state is bent.
    pub struct StateShape {
        /// How dry the leaf is: 0 flat, 1 as curled as the model makes it.
        dryness: f64 = 0.0, range 0.0 => 1.0;
    }
}

settings! {
    /// How leaves curl.
    pub struct Settings {
        /// The mechanics.
        model: Model = Model::Shell;
        /// Different shapes made for each state.
        shapes: u32 = 3, range 1 => 64;
        /// The states' shapes by name; a state without an entry is flat.
        states: BTreeMap<String, StateShape> = BTreeMap::new();
        /// The model "shell". The keys below it belong to the model "paper".
        shell: shell::Settings = shell::Settings::default();
        /// Time step of equation (1); "auto" takes 0.7 of the largest stable one, which a fixed one may not exceed.
        step: Step = Step::Automatic(Automatic::Auto), unit "s", range 1e-9 => 1.0;
        /// Time steps to the driest shape; a state's shape is the snapshot at its dryness times these.
        steps: u32 = 3000, range 0 => 4294967295u32;
        /// Stiffness of the springs.
        stiffness: f64 = 40.0, unit "N/m", range 1e-6 => 1e9;
        /// Largest stretch of a spring relative to its natural length, tau_c of equation (2).
        strain_limit: f64 = 0.1, range 0.0 => 1e6;
        /// Which way the external force acts on the vertices.
        field: Field = Field::Curl;
        /// External force on a vertex (with the field "curl", where the leaf curls most). Negative reverses it. The default rolls
        /// the lobes of a maple of 75 mm in the default steps; it goes about with the blade's length.
        force: f64 = 1.2e-2, unit "N", range -1e6 => 1e6;
        /// Direction of the field "constant": x to the right, y to the tip, z out of the upper side. Its length does not count.
        direction: [f64; 3] = [0.0, 0.0, 1.0], range -1.0 => 1.0;
        /// Where the field "point" pulls to, from the petiole's joint, in the axes of `direction`.
        point: [f64; 3] = [0.0, 40.0, 60.0], unit "mm", range -1e4 => 1e4;
        /// Mass that one unit of equation (3) stands for; the mask's masses are 0.5 to 5.55 of it.
        mass_unit: f64 = 1.0, unit "mg", range 1e-6 => 1e6;
        /// Drag of the air on a vertex (Provot 1995, viscous damping).
        drag: f64 = 1e-3, unit "N s/m", range 0.0 => 1e3;
        /// Internal friction of a spring against any relative velocity of its ends. It alone keeps the blade smooth, since
        /// springs do not resist bending: with less, neighbouring triangles fold over. The default suits about 220 vertices;
        /// force and friction belong to vertices and edges, so a finer mesh curls more and wants more of it.
        friction: f64 = 9e-3, unit "N s/m", range 0.0 => 1e3;
    }
}
