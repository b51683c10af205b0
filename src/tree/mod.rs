//! The tree stage: L-system grammar -> derivation -> turtle -> skeleton, leaf sites and the mesh of the wood.
//!
//! The language of the rules, spaces being free; rules are tried in order, and of weighted ones that hold one is drawn:
//!
//! ```text
//! rule        = predecessor [ ":" condition [ ":" weight ] ] "->" successor
//! predecessor = [ patterns "<" ] pattern [ ">" patterns ]       condition = "*" | expression
//! pattern     = symbol [ "(" name { "," name } ")" ]
//! successor   = { symbol [ "(" expression { "," expression } ")" ] }
//! expression  = numbers, parameters, tree.constants, age (or n: the step, from 1), ( ), prefix - !,
//!               + - * / % ^, < <= > >= == !=, && ||, c ? a : b,
//!               min max abs floor sqrt sin cos (degrees) exp ln rand(low, high) normal(mean, deviation)
//! symbols     = F(m) f(m) draw, move    + - & ^ \ / (degrees) | $ turn    !(cm) diameter    L(size) leaf
//!               [ ] branch    % cut the rest of the branch off    { } and other upper-case letters: silent
//! ```
//!
//! After Prusinkiewicz and Lindenmayer, "The Algorithmic Beauty of Plants" (1990), chapters 1 and 2. `P < A > N`
//! rewrites an A that stands on a P and has an N behind it (section 1.8). Not here: growth that senses the world (only a pass of light after growth sheds shaded shoots).

mod axis;
mod context;
mod cursor;
mod derivation;
mod draws;
mod expression;
mod flare;
mod grammar;
mod growth;
mod height;
mod join;
mod leaf_site;
mod modules;
mod parser;
mod path;
mod petiole;
mod radii;
mod rule;
mod shade;
mod shedding;
mod skeleton;
mod symbol;
mod turtle;
mod weave;
mod wood;

use leaf_site::Bearer;
pub use leaf_site::LeafSite;
pub use skeleton::{Segment, Skeleton};
pub use wood::Wood;

use crate::base::figures::Figures;
use crate::base::limits::{Limit, Limits, Refusal};
use crate::base::settings::Complaint;
use crate::{choice, settings};
use grammar::Grammar;
use modules::Modules;
use skeleton::Shoot;
use std::collections::BTreeMap;
use std::ops::Range;
use thiserror::Error;

/// Memory that a module `F` comes to, bytes: segment, path and a ring of the wood (measured: 200 straight, 600 in zigzag).
const LENGTH_BYTES: f64 = 640.0;
/// Memory that a leaf comes to before it is drawn, bytes.
const LEAF_BYTES: f64 = 400.0;

choice! {
    /// How bark breaks up as the wood grows thick.
    pub enum BarkKind {
        /// Smooth for life, with faint marks across: beech, Japanese maple.
        Smooth = "smooth",
        /// Interlacing ridges between furrows along the stem: oaks, ginkgo, sweetgum, Norway maple.
        Ridged = "ridged",
        /// Long plates that come loose at their sides: red maple, sugar maple.
        Plated = "plated",
        /// Pale, with dark marks across; black cracks in diamonds near the foot of old trunks: birches.
        Papery = "papery",
        /// Pale and smooth with dark scars of branches, furrowed near the foot of old trunks: aspens.
        Scarred = "scarred",
    }
}

settings! {
    /// The tree's growth. With an L-system of its own a scene needs no species.
    pub struct Settings {
        /// Age; a derivation step is a year. Of a year that is not over, shoots have grown by its share: 14.5 is the tree of 15
        /// years half-way through its last year's growth. Leaves are whole: their age is the season's.
        age: Option<f64> = None, unit "years", range 0.01 => 200.0;
        /// Height to grow to, in place of an age; the age follows.
        height: Option<f64> = None, unit "m", range 0.05 => 150.0;
        /// The string that growth starts from.
        axiom: String = String::new();
        /// Rewriting rules, `predecessor : condition : weight -> successor`, as in `A(l) : l > 1 : 0.3 -> F(l)A(l)`; the
        /// condition may be `*` (always), it and the weight may be left out.
        rules: Vec<String> = Vec::new();
        /// Symbols that count for nothing when rules look at the neighbours of a module, as in `P < A > N -> A`.
        ignored: String = "+-&^\\/|$!{}".to_owned();
        /// Named numbers that rules may use.
        constants: BTreeMap<String, f64> = BTreeMap::new(), range -1e9 => 1e9;
        /// Derivation steps; `age` and `height` win.
        iterations: u32 = 10, range 0 => 200;
        /// The angle of turns without an argument.
        angle: f64 = 25.0, unit "°", range -360.0 => 360.0;
        /// Sum of child diameters to this power equals the parent's (pipe model); used where the rules set no width.
        radius_exponent: f64 = 2.0, range 1.0 => 4.0;
        /// Diameter of the thinnest twigs.
        twig_diameter: f64 = 2.0, unit "mm", range 0.1 => 100.0;
        /// How strongly wood bends along `tropism_direction`, up to the light by default; negative bends away. A segment of m
        /// metres turns by this times m |H x T| radians before it is drawn, H its heading and T the direction.
        tropism: f64 = 0.0, unit "1/m", range -10.0 => 10.0;
        /// The same a segment, whatever its length: after each, the turtle turns by this times |H x T| radians. It is the
        /// susceptibility e of "The Algorithmic Beauty of Plants", section 2.1.1.
        segment_tropism: f64 = 0.0, unit "rad", range -10.0 => 10.0;
        /// Where wood bends to: the light's direction, or that of gravity, [0, -1, 0]; its length is the force.
        tropism_direction: [f64; 3] = [0.0, 1.0, 0.0], unit "1", range -10.0 => 10.0;
        /// How strongly branches sag in the end, half of it after ten years; young wood at their ends follows `tropism` alone.
        sag: f64 = 0.0, unit "1/m", range 0.0 => 10.0;
        /// Length of the petiole.
        petiole: f64 = 60.0, unit "mm", range 0.0 => 500.0;
        /// Angle between a twig and its petioles.
        petiole_angle: f64 = 50.0, unit "°", range 0.0 => 180.0;
        /// Mean inclination of blades below the horizontal.
        blade_inclination: f64 = 35.0, unit "°", range -90.0 => 90.0;
        /// Reflectance of old bark, of its plates or ridges: linear red, green, blue.
        bark: [f64; 3] = [0.21, 0.19, 0.165], range 0.0 => 1.0;
        /// How the bark breaks up as the wood grows thick.
        bark_kind: BarkKind = BarkKind::Plated;
        /// Reflectance of smooth bark on young limbs: linear red, green, blue.
        bark_young: [f64; 3] = [0.26, 0.25, 0.22], range 0.0 => 1.0;
        /// Girth at which half the bark has turned from young to old.
        bark_girth: f64 = 0.55, unit "m", range 0.01 => 50.0;
        /// Width of a plate or ridge of old bark, of a mark on smooth bark.
        bark_scale: f64 = 0.05, unit "m", range 0.005 => 0.5;
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

impl Settings {
    /// Derivation steps: the years begun, or `iterations`.
    #[must_use]
    pub fn steps(&self) -> u32 {
        self.age.map_or(self.iterations, |age| age.ceil() as u32)
    }

    /// Share of its last year's growth that the tree has made, above 0 to 1.
    #[must_use]
    pub fn last_year(&self) -> f64 {
        self.age.map_or(1.0, |age| age - age.ceil() + 1.0)
    }
}

/// A grown tree.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tree {
    /// The surface of the wood by girth, thinnest first.
    pub wood: Vec<Wood>,
    /// The leaves, in the order of growth.
    pub sites: Vec<LeafSite>,
    /// The wood as lines.
    pub skeleton: Skeleton,
    /// Highest point of wood or leaf base, metres.
    pub height: f64,
    /// Largest distance of wood or leaf base from the trunk's foot, seen from above, metres.
    pub crown_radius: f64,
    /// Area of the ground below the crown, square metres.
    pub crown_projection: f64,
    /// The derivation step of the youngest wood.
    pub youngest: u32,
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
    /// `!` had a negative or absurd diameter.
    #[error("!({centimetres}) cannot be drawn: diameters are 0 to 10000 cm")]
    Width {
        /// The diameter asked for, centimetres.
        centimetres: f64,
    },
    /// `L` had a negative or absurd size.
    #[error("L({scale}) cannot be drawn: leaves are 0 to 1000 times the mean")]
    Leaf {
        /// The size asked for.
        scale: f64,
    },
    /// The wood leaves the world.
    #[error("the tree grows more than 100 km from its root")]
    Far,
    /// The height asked for is never reached.
    #[error("the tree does not grow to {metres} m: it is {reached:.2} m high after {years} years")]
    Height {
        /// The height asked for, metres.
        metres: f64,
        /// The greatest height seen, metres.
        reached: f64,
        /// Years tried.
        years: u32,
    },
    /// A limit refused it.
    #[error(transparent)]
    Refused(#[from] Refusal),
}

/// Everything that is wrong with the rules, at once.
#[must_use]
pub fn check(settings: &Settings) -> Vec<Complaint> {
    let mut complaints = Grammar::new(settings).err().unwrap_or_default();
    if settings.age.is_some() && settings.height.is_some() {
        let what = "a tree has an age or a height, not both";
        complaints.push(Complaint::new("height", what, "take `age` or `height` away"));
    }
    complaints
}

/// Grows a tree.
///
/// # Errors
/// Complaints about the settings, a value that is not defined, or a limit that stands in the way.
pub fn grow(settings: &Settings, seed: u64, limits: &Limits) -> Result<(Tree, Figures), TreeError> {
    let grammar = Grammar::new(settings).map_err(TreeError::Settings)?;
    let aged;
    let settings = match settings.height {
        Some(height) => {
            aged = Settings { age: Some(height::age(&grammar, settings, height, seed, limits)?), ..settings.clone() };
            &aged
        }
        None => settings,
    };
    if settings.shade == 0.0 || !grammar.bears_leaves() {
        growth::allow(&grammar, settings.steps(), limits)?;
    }
    let modules = derivation::derive(&grammar, settings, seed, limits)?;
    allow(&modules, limits)?;
    let mut drawing = turtle::draw(&modules, settings)?;
    let symbols = modules.list.len();
    drop(modules);
    let least = settings.twig_diameter * 0.0005;
    if drawing.widths {
        radii::as_set(&mut drawing.skeleton, least);
    } else {
        radii::pipe_model(&mut drawing.skeleton, least, settings);
    }
    let skeleton = drawing.skeleton;
    let light = shade::light(&drawing.shoots, settings.shade);
    let petioles = petiole::lengths(&skeleton);
    let bearers = Bearer::of_segments(&skeleton);
    let site = |(shoot, light): (&Shoot, &f64)| {
        let petiole = shoot.segment.map_or(1.0, |number| petioles[number as usize]);
        let bearer = shoot.segment.map_or(Bearer::NONE, |number| bearers[number as usize]);
        leaf_site::site(shoot, &skeleton, &bearer, (*light, petiole), settings, seed)
    };
    let sites: Vec<LeafSite> = drawing.shoots.iter().zip(&light).map(site).collect();
    let wood = wood::meshes(&skeleton);
    let places = || skeleton.segments.iter().map(|segment| segment.end).chain(sites.iter().map(|site| site.base));
    let height = places().map(|place| place.y).fold(0.0, f64::max);
    let crown_radius = places().map(|place| (place.x * place.x + place.z * place.z).sqrt()).fold(0.0, f64::max);
    let crown_projection = crown_projection(&sites);
    let figures = Figures::of(sites.len() as u64)
        .with("age_years", settings.age)
        .with("symbols", symbols as u64)
        .with("segments", skeleton.segments.len() as u64)
        .with("leaves", sites.len() as u64)
        .with("height_m", height)
        .with("crown_projection_m2", crown_projection)
        .with("max_order", skeleton.max_order())
        .with("triangles", wood.iter().map(|wood| wood.mesh.triangles.len() as u64).sum::<u64>());
    let youngest = settings.steps();
    Ok((Tree { wood, sites, skeleton, height, crown_radius, crown_projection, youngest }, figures))
}

/// Holds what a string will be drawn to against the limits.
fn allow(modules: &Modules, limits: &Limits) -> Result<(), Refusal> {
    let (leaves, lengths) = (modules.count(b'L') as f64, modules.count(b'F') as f64);
    limits.allow(Limit::Leaves, "tree.rules", leaves)?;
    limits.allow(Limit::Memory, "tree.rules", lengths * LENGTH_BYTES + leaves * LEAF_BYTES)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::vector::DVec3;

    #[derive(serde::Deserialize)]
    struct File {
        tree: Settings,
    }

    const RED_MAPLE: &str = concat!(
        "[tree]\n",
        include_str!("../species/habit/decussate.toml"),
        "\n",
        include_str!("../species/red-maple.tree.toml"),
    );

    fn red_maple() -> Settings {
        toml::from_str::<File>(RED_MAPLE).unwrap().tree
    }

    /// Open-grown red maples as an experienced eye expects them, each range widened by a fifth: age, height (m), thousands of
    /// leaves, trunk diameter at 1.3 m (cm), widest reach of the crown (m).
    const EXPECTED: [(u32, [[f64; 2]; 4]); 2] = [
        (10, [[3.2, 8.4], [4.0, 14.4], [3.0, 14.0], [1.0, 3.2]]),
        (25, [[7.2, 15.6], [24.0, 96.0], [14.4, 36.0], [2.4, 5.4]]),
    ];

    #[test]
    fn the_red_maple_is_one() {
        assert_eq!(check(&red_maple()), vec![]);
        for ((age, [height, leaves, trunk, reach]), seed) in EXPECTED.into_iter().flat_map(|row| [(row, 1), (row, 6)]) {
            let settings = Settings { age: Some(f64::from(age)), ..red_maple() };
            let (tree, _) = grow(&settings, seed, &Limits::default()).unwrap();
            let chest = tree.skeleton.segments.iter().find(|segment| segment.axis == 0 && segment.end.y > 1.3).unwrap();
            let found = [
                (tree.height, height),
                (tree.sites.len() as f64 * 1e-3, leaves),
                (chest.radius * 200.0, trunk),
                (tree.crown_radius, reach),
            ];
            for (value, [low, high]) in found {
                assert!((low..high).contains(&value), "{value} is not in {low} to {high} at {age} years, seed {seed}");
            }
            assert!(tree.wood.iter().all(|wood| wood.mesh.check() == Ok(())));
            let mut ids: Vec<u64> = tree.sites.iter().map(|site| site.id).collect();
            ids.sort_unstable();
            ids.dedup();
            assert_eq!(ids.len(), tree.sites.len());
        }
    }

    #[test]
    fn the_same_seed_grows_the_same_tree() {
        let settings = Settings { age: Some(9.0), ..red_maple() };
        let grown = |seed| grow(&settings, seed, &Limits::default()).unwrap();
        assert_eq!(grown(3), grown(3));
        assert_ne!(grown(3).0.sites, grown(4).0.sites);
    }

    /// Distance of a point from a segment's line.
    fn distance(segment: &Segment, point: DVec3) -> f64 {
        let along = segment.end - segment.start;
        let share = ((point - segment.start).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
        (segment.start + along * share - point).norm()
    }

    #[test]
    fn no_leaf_floats_and_directions_are_unit() {
        let settings = Settings { age: Some(8.0), ..red_maple() };
        let (tree, _) = grow(&settings, 1, &Limits::default()).unwrap();
        assert!(tree.sites.len() > 300);
        for site in &tree.sites {
            let gap = |segment: &Segment| distance(segment, site.base) - segment.radius;
            let nearest = tree.skeleton.segments.iter().map(gap).fold(f64::INFINITY, f64::min);
            assert!(nearest <= 0.001, "{nearest}");
            for unit in [site.petiole, site.blade, site.normal] {
                assert!((unit.norm() - 1.0).abs() < 1e-9);
            }
            assert!(site.blade.dot(&site.normal).abs() < 1e-9);
        }
    }

    #[test]
    fn adding_a_branch_or_a_year_keeps_the_other_leaves() {
        let rules = |branch: &str| vec![format!("A(l) -> F(l)[&(40)L]{branch}[+(50)A(l*rand(0.5,0.9))]A(l*0.9)")];
        let ids = |branch: &str, iterations| {
            let settings =
                Settings { axiom: "A(1)".to_owned(), rules: rules(branch), iterations, ..Settings::default() };
            let tree = grow(&settings, 1, &Limits::default()).unwrap().0;
            tree.sites.iter().map(|site| (site.id, site.base.map(f64::to_bits))).collect::<Vec<_>>()
        };
        let before: Vec<u64> = ids("", 5).iter().map(|leaf| leaf.0).collect();
        for after in [ids("[-(30)F(0.2)L]", 5), ids("", 6)] {
            let after: Vec<u64> = after.iter().map(|leaf| leaf.0).collect();
            assert!(after.len() > before.len());
            assert!(before.iter().all(|id| after.contains(id)));
        }
    }

    #[test]
    fn a_probability_touches_only_what_it_decides() {
        let grown = |bearing: &str| {
            let mut rules = vec![
                "A(l) : * : 2 -> F(l)[+(rand(30,50))A(l*0.8)][B]/(137.5)A(l*rand(0.7,0.9))".to_owned(),
                "A(l) : * : 1 -> F(l)[B]/(90)A(l*0.9)".to_owned(),
            ];
            rules.extend(bearing.split_terminator(';').map(str::to_owned));
            let settings = Settings { axiom: "A(1)".to_owned(), rules, iterations: 12, ..Settings::default() };
            let segments = grow(&settings, 1, &Limits::default()).unwrap().0.skeleton.segments;
            let key = |segment: &Segment| (segment.id, segment.start.map(f64::to_bits), segment.end.map(f64::to_bits));
            segments.iter().map(key).collect::<std::collections::HashSet<_>>()
        };
        let limbs = grown("");
        let few = grown("B : * : 1 -> F(0.1)[-F(0.1)L];B : * : 9 -> F(0.2)");
        let many = grown("B : * : 9 -> F(0.1)[-F(0.1)L];B : * : 1 -> F(0.2)");
        assert!(limbs.len() > 300 && limbs.is_subset(&few) && limbs.is_subset(&many));
        assert!(many.len() > few.len() + 100);
        // A bud that bore with the smaller chance bears with the larger one too, and the same.
        let twigs = |all: &std::collections::HashSet<_>, length: f64| {
            let long = |key: &&(u64, nalgebra::Vector3<u64>, nalgebra::Vector3<u64>)| {
                ((key.1.map(f64::from_bits) - key.2.map(f64::from_bits)).norm() - length).abs() < 1e-9
            };
            all.difference(&limbs).filter(long).copied().collect::<std::collections::HashSet<_>>()
        };
        assert!(twigs(&few, 0.1).len() > 20 && twigs(&few, 0.1).is_subset(&twigs(&many, 0.1)));
    }

    #[test]
    fn lengths_that_cannot_be_drawn_are_refused() {
        let settings = Settings { axiom: "F(1-2)".to_owned(), ..Settings::default() };
        let error = grow(&settings, 1, &Limits::default()).unwrap_err();
        assert_eq!(error, TreeError::Length { metres: -1.0 });
        assert!(grow(&Settings::default(), 1, &Limits::default()).is_ok());
    }
}
