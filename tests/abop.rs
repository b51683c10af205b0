//! The trees of P. Prusinkiewicz and A. Lindenmayer, "The Algorithmic Beauty of Plants" (1990), chapter 2, as the scenes
//! `scenes/abop-*.toml` grow them: every branch end point against a second derivation, by recursion on matrices.

use leafseason::base::limits::Limits;
use leafseason::base::maths::{cos, sin};
use leafseason::base::vector::{DMat3, DVec3};
use leafseason::scene;
use leafseason::tree::{self, Segment};
use nalgebra::{Rotation3, Unit};
use std::path::Path;

/// A piece of wood by its end and radius, metres.
type End = (DVec3, f64);

/// The frame of the turtle at the start: its columns are heading, left and up.
fn start() -> DMat3 {
    DMat3::from_columns(&[DVec3::y(), -DVec3::x(), DVec3::z()])
}

/// Turns in the turtle's own frame by an angle in degrees: the matrices R_U, R_L and R_H of section 1.5.
fn about_up(degrees: f64) -> DMat3 {
    let (c, s) = (cos(degrees.to_radians()), sin(degrees.to_radians()));
    DMat3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)
}

fn about_left(degrees: f64) -> DMat3 {
    let (c, s) = (cos(degrees.to_radians()), sin(degrees.to_radians()));
    DMat3::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c)
}

fn about_heading(degrees: f64) -> DMat3 {
    let (c, s) = (cos(degrees.to_radians()), sin(degrees.to_radians()));
    DMat3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c)
}

/// `$`: the left vector brought to the horizontal.
fn level(frame: DMat3) -> DMat3 {
    let heading = frame.column(0).into_owned();
    let left = DVec3::y().cross(&heading).normalize();
    DMat3::from_columns(&[heading, left, heading.cross(&left)])
}

/// What the scene `name` grows with `changes` to it.
fn grown(name: &str, changes: &[String]) -> Vec<Segment> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(format!("{name}.toml"));
    let (scene, _) = scene::read(&path, changes, &[], &Limits::default()).unwrap_or_else(|fault| panic!("{fault}"));
    tree::grow(&scene.species[0].tree, scene.seed, &Limits::default()).expect("a tree").0.skeleton.segments
}

/// Holds the scene's tree to the ends wanted, piece by piece in the order of growth.
fn compare(name: &str, changes: &[String], count: usize, wanted: &[End]) {
    let found = grown(name, changes);
    assert_eq!((found.len(), wanted.len()), (count, count), "{name} {changes:?}");
    for (segment, (end, radius)) in found.iter().zip(wanted) {
        assert!((segment.end - end).norm() < 1e-6, "{name} {changes:?}: {} is not {end}", segment.end);
        assert!((segment.radius - radius).abs() < 1e-9, "{name} {changes:?}: {} is not {radius}", segment.radius);
    }
}

fn constants(values: &[(&str, f64)]) -> Vec<String> {
    values.iter().map(|(name, value)| format!("tree.constants.{name}={value}")).collect()
}

/// Radius (metres) of a diameter in centimetres.
fn radius(centimetres: f64) -> f64 {
    centimetres * 0.005
}

struct Honda {
    r2: f64,
    a0: f64,
    a2: f64,
    ends: Vec<End>,
}

impl Honda {
    fn grow(&mut self, kind: char, base: DVec3, frame: DMat3, (length, width): (f64, f64), left: u32) {
        if left == 0 {
            return;
        }
        let end = base + frame.column(0) * length;
        self.ends.push((end, radius(width)));
        let (lateral, next, inner, outer) = match kind {
            'A' => ('B', 'A', frame * about_left(self.a0), frame * about_heading(-137.5)),
            'B' => ('C', 'C', level(frame * about_up(-self.a2)), frame),
            _ => ('B', 'B', level(frame * about_up(self.a2)), frame),
        };
        self.grow(lateral, end, inner, (length * self.r2, width * 0.707), left - 1);
        self.grow(next, end, outer, (length * 0.9, width * 0.707), left - 1);
    }
}

#[test]
fn monopodial_trees_of_honda() {
    for (r2, a0, a2) in [(0.6, 45.0, 45.0), (0.9, 45.0, 45.0), (0.8, 45.0, 45.0), (0.7, 30.0, -30.0)] {
        let mut honda = Honda { r2, a0, a2, ends: Vec::new() };
        honda.grow('A', DVec3::zeros(), start(), (1.0, 10.0), 10);
        let changes = constants(&[("r2", r2), ("a0", a0), ("a2", a2)]);
        // Every module becomes a piece of wood and two modules: 1 + 2 + 4 ... + 512.
        compare("abop-monopodial", &changes, (1 << 10) - 1, &honda.ends);
    }
}

struct AonoKunii {
    r2: f64,
    a1: f64,
    a2: f64,
    ends: Vec<End>,
}

impl AonoKunii {
    fn grow(&mut self, first: bool, base: DVec3, frame: DMat3, (length, width): (f64, f64), left: u32) {
        if left == 0 {
            return;
        }
        let end = base + frame.column(0) * length;
        self.ends.push((end, radius(width)));
        let (strong, weak) = if first {
            (frame * about_left(self.a1), frame * about_heading(-180.0) * about_left(self.a2))
        } else {
            (level(frame * about_up(self.a1)), level(frame * about_up(-self.a2)))
        };
        self.grow(false, end, strong, (length * 0.9, width * 0.707), left - 1);
        self.grow(false, end, weak, (length * self.r2, width * 0.707), left - 1);
    }
}

#[test]
fn sympodial_trees_of_aono_and_kunii() {
    for (r2, a1, a2) in [(0.7, 5.0, 65.0), (0.7, 10.0, 60.0), (0.8, 20.0, 50.0), (0.8, 35.0, 35.0)] {
        let mut tree = AonoKunii { r2, a1, a2, ends: Vec::new() };
        tree.grow(true, DVec3::zeros(), start(), (1.0, 10.0), 10);
        let changes = constants(&[("r2", r2), ("a1", a1), ("a2", a2)]);
        compare("abop-sympodial", &changes, (1 << 10) - 1, &tree.ends);
    }
}

struct Ternary {
    divergence: [f64; 2],
    angle: f64,
    lengthening: f64,
    susceptibility: f64,
    direction: DVec3,
    ends: Vec<End>,
}

impl Ternary {
    const WIDENING: f64 = 1.732;

    /// Adds a piece of wood of `length` that has still `steps` steps to grow; returns where it ends and the frame there.
    fn piece(&mut self, base: DVec3, frame: DMat3, length: f64, width: f64, steps: u32) -> (DVec3, DMat3) {
        let heading = frame.column(0).into_owned();
        let power = |base: f64| (0..steps).fold(1.0, |product, _| product * base);
        let end = base + heading * (length * power(self.lengthening));
        self.ends.push((end, radius(width * power(Self::WIDENING))));
        let torque = heading.cross(&self.direction);
        if torque.norm() < 1e-12 {
            return (end, frame);
        }
        let turn = Rotation3::from_axis_angle(&Unit::new_normalize(torque), self.susceptibility * torque.norm());
        (end, turn.matrix() * frame)
    }

    /// What the apex A becomes in `left` steps.
    fn grow(&mut self, base: DVec3, frame: DMat3, left: u32) {
        if left == 0 {
            return;
        }
        let (end, mut frame) = self.piece(base, frame, 0.5, Self::WIDENING, left - 1);
        for divergence in [0.0, self.divergence[0], self.divergence[1]] {
            frame *= about_heading(-divergence);
            let (tip, bent) = self.piece(end, frame * about_left(self.angle), 0.5, Self::WIDENING, left - 1);
            self.grow(tip, bent, left - 1);
        }
    }
}

#[test]
fn ternary_trees_bend_along_the_tropism() {
    let figures = [
        ([94.74, 132.63], 18.95, 1.109, 0.22, [0.0, -1.0, 0.0], 6),
        ([137.5, 137.5], 18.95, 1.109, 0.14, [0.0, -1.0, 0.0], 8),
        ([112.5, 157.5], 22.5, 1.79, 0.27, [-0.02, -1.0, 0.0], 8),
        ([180.0, 252.0], 36.0, 1.07, 0.4, [-0.61, 0.77, -0.19], 6),
    ];
    for (divergence, angle, lengthening, susceptibility, direction, steps) in figures {
        let mut tree = Ternary {
            divergence,
            angle,
            lengthening,
            susceptibility,
            direction: DVec3::from(direction),
            ends: Vec::new(),
        };
        let (foot, frame) = tree.piece(DVec3::zeros(), start(), 2.0, 1.0, steps);
        tree.grow(foot, frame * about_heading(-45.0), steps);
        let mut changes = constants(&[("d1", divergence[0]), ("d2", divergence[1]), ("a", angle), ("lr", lengthening)]);
        changes.push(format!("tree.segment_tropism={susceptibility}"));
        changes.push(format!("tree.tropism_direction={direction:?}"));
        changes.push(format!("tree.iterations={steps}"));
        // An apex adds 4 pieces and 3 apices a step: 4 (3^n - 1) / 2, and the trunk.
        compare("abop-ternary", &changes, 2 * 3usize.pow(steps) - 1, &tree.ends);
    }
}
