//! The tree stage: L-system grammar -> derivation -> turtle -> skeleton, leaf sites and the mesh of the wood.
//!
//! The language of the rules is described at [`rule`]'s grammar below, the symbols at the turtle's:
//!
//! ```text
//! rule        = predecessor [ ":" condition [ ":" weight ] ] "->" successor
//! predecessor = symbol [ "(" name { "," name } ")" ]           condition = "*" | expression
//! successor   = { symbol [ "(" expression { "," expression } ")" ] }
//! expression  = numbers, parameters, tree.constants, age (or n: the step, from 1), ( ), prefix - !,
//!               + - * / % ^, < <= > >= == !=, && ||, c ? a : b,
//!               min max abs floor sqrt sin cos (degrees) exp ln rand(low, high) normal(mean, deviation)
//! symbols     = F(m) f(m) draw, move    + - & ^ \ / (degrees) | $ turn    !(cm) diameter    L(size) leaf
//!               [ ] branch    % cut the rest of the branch off    { } and other upper-case letters: silent
//! ```
//!
//! After Prusinkiewicz and Lindenmayer, "The Algorithmic Beauty of Plants" (1990), chapters 1 and 2. Not here: rules that
//! look at neighbours, and growth that senses the world (only a pass of light after growth sheds shaded shoots).

mod axis;
mod cursor;
mod derivation;
mod draws;
mod expression;
mod grammar;
mod growth;
mod leaf_site;
mod parser;
mod path;
mod radii;
mod rule;
mod shade;
mod skeleton;
mod symbol;
mod turtle;
mod wood;

pub use leaf_site::LeafSite;
pub use skeleton::{Segment, Skeleton};

use crate::base::figures::Figures;
use crate::base::limits::{Limit, Limits, Refusal};
use crate::base::mesh::Mesh;
use crate::base::settings::Complaint;
use crate::settings;
use grammar::Grammar;
use std::collections::BTreeMap;
use std::ops::Range;
use thiserror::Error;

settings! {
    /// The tree's growth. With an L-system of its own a scene needs no species.
    pub struct Settings {
        /// Age; when given, the number of derivation steps, one a year.
        age: Option<u32> = None, unit "a", range 1 => 200;
        /// The string that growth starts from.
        axiom: String = String::new();
        /// Rewriting rules, `predecessor : condition : weight -> successor`, as in `A(l) : l > 1 : 0.3 -> F(l)A(l)`; the
        /// condition may be `*` (always), it and the weight may be left out.
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
        /// Reflectance of the bark of stem and limbs: linear red, green, blue.
        bark: [f64; 3] = [0.21, 0.19, 0.165], range 0.0 => 1.0;
        /// Reflectance of the bark of twigs: linear red, green, blue.
        twig_bark: [f64; 3] = [0.13, 0.09, 0.08], range 0.0 => 1.0;
        /// Reflectance of petioles: linear red, green, blue.
        petiole_colour: [f64; 3] = [0.30, 0.09, 0.07], range 0.0 => 1.0;
        /// Relative spread of leaf sizes, standard deviation over mean.
        leaf_size_spread: f64 = 0.22, range 0.0 => 0.6;
        /// Leaves a square metre behind which light falls to 1/e; shoots that see too little sky lose their leaves, and wood
        /// without leaves is shed. 0 sheds nothing.
        shade: f64 = 0.0, unit "1/m2", range 0.0 => 1e6;
    }
}

/// A grown tree.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tree {
    /// Wood of 12 mm radius and more.
    pub bark: Mesh,
    /// Thinner wood.
    pub twigs: Mesh,
    /// The leaves, in the order of growth.
    pub sites: Vec<LeafSite>,
    /// The wood as lines.
    pub skeleton: Skeleton,
    /// Highest point of wood or leaf base, metres.
    pub height: f64,
    /// Largest distance of wood or leaf base from the trunk's foot, seen from above, metres.
    pub crown_radius: f64,
}

/// Why a tree could not be grown.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum TreeError {
    /// The settings are at fault.
    #[error("the tree's rules are wrong")]
    Settings(Vec<Complaint>),
    /// A value in a rule came out as NaN or infinity.
    #[error("{key}: a value is not defined here")]
    Undefined {
        /// `axiom` or `rules.N`.
        key: String,
        /// The bytes of the expression.
        within: Range<usize>,
    },
    /// `F` had a negative or absurd length.
    #[error("F({metres}) cannot be drawn: lengths are 0 to 10000 m")]
    Length {
        /// The length asked for, metres.
        metres: f64,
    },
    /// A limit refused it.
    #[error(transparent)]
    Refused(#[from] Refusal),
}

/// Everything that is wrong with the rules, at once.
#[must_use]
pub fn check(settings: &Settings) -> Vec<Complaint> {
    Grammar::new(settings).err().unwrap_or_default()
}

/// Grows a tree.
///
/// # Errors
/// Complaints about the settings, a value that is not defined, or a limit that stands in the way.
pub fn grow(settings: &Settings, seed: u64, limits: &Limits) -> Result<(Tree, Figures), TreeError> {
    let grammar = Grammar::new(settings).map_err(TreeError::Settings)?;
    let steps = settings.age.unwrap_or(settings.iterations);
    growth::allow(&grammar, steps, limits)?;
    let modules = derivation::derive(&grammar, steps, seed, limits)?;
    limits.allow(Limit::Leaves, "tree.rules", modules.count(b'L') as f64)?;
    let mut drawing = turtle::draw(&modules, settings.angle, settings.tropism)?;
    let symbols = modules.len();
    drop(modules);
    if settings.shade > 0.0 {
        shed(&mut drawing, settings.shade);
    }
    let least = settings.twig_diameter * 0.0005;
    if drawing.widths {
        radii::as_set(&mut drawing.skeleton, least);
    } else {
        radii::pipe_model(&mut drawing.skeleton, settings.radius_exponent, least);
    }
    let skeleton = drawing.skeleton;
    let sites: Vec<LeafSite> =
        drawing.shoots.iter().map(|shoot| leaf_site::site(shoot, &skeleton, settings, seed)).collect();
    let (bark, twigs) = wood::meshes(&skeleton);
    let places = || skeleton.segments.iter().map(|segment| segment.end).chain(sites.iter().map(|site| site.base));
    let height = places().map(|place| place.y).fold(0.0, f64::max);
    let crown_radius = places().map(|place| (place.x * place.x + place.z * place.z).sqrt()).fold(0.0, f64::max);
    let figures = Figures::of(sites.len() as u64)
        .with("symbols", symbols as u64)
        .with("segments", skeleton.segments.len() as u64)
        .with("leaves", sites.len() as u64)
        .with("height_m", height)
        .with("crown_projection_m2", crown_projection(&sites))
        .with("max_order", skeleton.max_order())
        .with("triangles", (bark.triangles.len() + twigs.triangles.len()) as u64);
    Ok((Tree { bark, twigs, sites, skeleton, height, crown_radius }, figures))
}

/// Sheds leaves in the shade and the wood that bears none.
fn shed(drawing: &mut turtle::Drawing, depth: f64) {
    let lit = shade::lit(&drawing.shoots, &drawing.skeleton, depth);
    let alive = shade::alive(&drawing.skeleton, &drawing.shoots, &lit);
    let numbers = drawing.skeleton.retain(&alive);
    let mut kept = lit.into_iter();
    drawing.shoots.retain(|_| kept.next().unwrap_or(false));
    for shoot in &mut drawing.shoots {
        shoot.segment = shoot.segment.and_then(|number| numbers[number as usize]);
    }
}

/// Area of the ground below the crown, square metres: the outline of the leaves in 36 sectors about their middle, each as
/// far as its outermost leaf.
fn crown_projection(sites: &[LeafSite]) -> f64 {
    const SECTORS: usize = 36;
    let count = sites.len().max(1) as f64;
    let middle = sites.iter().fold((0.0, 0.0), |sum, site| (sum.0 + site.base.x / count, sum.1 + site.base.z / count));
    let mut reach = [0.0f64; SECTORS];
    for site in sites {
        let (x, z) = (site.base.x - middle.0, site.base.z - middle.1);
        let turn = crate::base::maths::atan2(z, x) / std::f64::consts::TAU + 0.5;
        let sector = ((turn * SECTORS as f64) as usize).min(SECTORS - 1);
        reach[sector] = reach[sector].max(x * x + z * z);
    }
    reach.iter().sum::<f64>() * std::f64::consts::PI / SECTORS as f64
}
