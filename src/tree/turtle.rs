//! The turtle of Prusinkiewicz and Lindenmayer, "The Algorithmic Beauty of Plants" (1990), section 1.5, in metres.
//!
//! It starts at the origin with heading H = +Y, left L = -X and up U = +Z (H x L = U). Turns follow the right-hand rule about
//! their axis: `+` about U (to the left), `&` about L (down), `\` about H; `-`, `^` and `/` are their opposites, `|` turns
//! round. `$` rolls so that L is level. `F(m)` draws, `f(m)` moves, both 1 m without an argument; `!(cm)` sets the diameter;
//! `L(s)` is a leaf of relative size s (1 without an argument). Other upper-case letters, `{` and `}` are silent.

use super::modules::Modules;
use super::skeleton::{Segment, Shoot, Skeleton};
use super::{Settings, TreeError};
use crate::base::maths::{atan2, sincos};
use crate::base::vector::DVec3;

/// Longest segment, metres.
const LONGEST: f64 = 1e4;
/// Farthest that wood may stand from the root on any axis, metres.
const FARTHEST: f64 = 1e5;
/// Thickest wood, centimetres.
const THICKEST: f64 = 1e4;
/// Years after which a branch has sagged by half.
const HALF_SAG: f64 = 10.0;
/// Largest leaf, in mean leaves of its species.
const LARGEST_LEAF: f64 = 1e3;

/// What the turtle drew.
#[derive(Clone, Debug, Default)]
pub(super) struct Drawing {
    pub skeleton: Skeleton,
    pub shoots: Vec<Shoot>,
    /// The segment at whose end each module stands.
    pub owners: Vec<Option<u32>>,
    /// Whether `!` set the diameters.
    pub widths: bool,
}

#[derive(Clone, Debug)]
struct State {
    position: DVec3,
    heading: DVec3,
    left: DVec3,
    up: DVec3,
    /// The segment at whose end the turtle stands.
    segment: Option<u32>,
    axis: u32,
    order: u32,
    /// Radius in metres.
    radius: f64,
    /// Whether the next segment starts an axis of its own.
    branches: bool,
}

impl State {
    fn start() -> Self {
        let (heading, left, up) = (DVec3::y(), -DVec3::x(), DVec3::z());
        let (segment, axis, order, radius) = (None, 0, 0, 0.0);
        Self { position: DVec3::zeros(), heading, left, up, segment, axis, order, radius, branches: true }
    }

    /// Turns about U: H towards L.
    fn yaw(&mut self, turn: (f64, f64)) {
        (self.heading, self.left) = turned(self.heading, self.left, turn);
    }

    /// Turns about L: U towards H.
    fn pitch(&mut self, turn: (f64, f64)) {
        (self.up, self.heading) = turned(self.up, self.heading, turn);
    }

    /// Turns about H: L towards U.
    fn roll(&mut self, turn: (f64, f64)) {
        (self.left, self.up) = turned(self.left, self.up, turn);
    }

    /// Takes back the rounding of many turns.
    fn orthonormalise(&mut self) {
        self.heading.normalize_mut();
        self.left = (self.left - self.heading * self.heading.dot(&self.left)).normalize();
        self.up = self.heading.cross(&self.left);
    }

    /// Rolls so that L is level and U as high as possible; nothing to do when the heading is vertical.
    fn level(&mut self) {
        if let Some(left) = DVec3::y().cross(&self.heading).try_normalize(1e-9) {
            self.left = left;
            self.up = self.heading.cross(&left);
        }
    }

    /// How much wood of this many `years` bends down, radians a metre: the more the longer it has carried its load, and the
    /// trunk not at all.
    fn sag(&self, full: f64, years: u32) -> f64 {
        let is_trunk = self.order == 0 && !(self.branches && self.segment.is_some());
        if is_trunk { 0.0 } else { full * f64::from(years) / (f64::from(years) + HALF_SAG) }
    }

    /// Bends the heading towards T by `susceptibility` |H x T| radians: the torque of section 2.1.1.
    fn bend(&mut self, susceptibility: f64, direction: DVec3) {
        let torque = self.heading.cross(&direction);
        if let Some(axis) = torque.try_normalize(1e-12) {
            let mut angle = susceptibility * torque.norm();
            if angle > 0.9 * torque.norm() / direction.norm() {
                // Never beyond T: angles up to the one left. That is at least its sine, so a weak bend cannot.
                angle = angle.min(atan2(torque.norm(), self.heading.dot(&direction)));
            }
            let turn = sincos(angle);
            self.heading = about(self.heading, axis, turn);
            self.left = about(self.left, axis, turn);
            self.up = about(self.up, axis, turn);
        }
    }
}

/// `vector` turned about the unit vector `axis` (Rodrigues) by an angle of which sine and cosine are given.
fn about(vector: DVec3, axis: DVec3, (sine, cosine): (f64, f64)) -> DVec3 {
    vector * cosine + axis.cross(&vector) * sine + axis * (axis.dot(&vector) * (1.0 - cosine))
}

/// Two vectors at right angles turned in their plane, the first towards the second.
fn turned(first: DVec3, second: DVec3, (sine, cosine): (f64, f64)) -> (DVec3, DVec3) {
    (first * cosine + second * sine, second * cosine - first * sine)
}

/// Sines and cosines of the angles met last: rules repeat most of theirs.
struct Angles([(u64, (f64, f64)); Self::SLOTS]);

impl Angles {
    const SLOTS: usize = 64;

    fn new() -> Self {
        Self([(0, (0.0, 1.0)); Self::SLOTS])
    }

    /// Sine and cosine of an angle in degrees.
    fn turn(&mut self, degrees: f64) -> (f64, f64) {
        let bits = degrees.to_bits();
        let slot = &mut self.0[(bits.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 58) as usize];
        if slot.0 != bits {
            *slot = (bits, sincos(degrees.to_radians()));
        }
        slot.1
    }
}

/// The same turn the other way.
fn back((sine, cosine): (f64, f64)) -> (f64, f64) {
    (-sine, cosine)
}

/// Follows the string. Wood that the last step wrote is drawn as far as the last year has come; how large leaves are is for
/// the season to say.
pub(super) fn draw(modules: &Modules, settings: &Settings) -> Result<Drawing, TreeError> {
    let mut drawing = Drawing::default();
    redraw(&mut drawing, modules, settings, settings.last_year())?;
    Ok(drawing)
}

/// As [`draw`], in the place of what was drawn before, and with the wood of the last step at `last_year` of its length.
pub(super) fn redraw(
    drawing: &mut Drawing,
    modules: &Modules,
    settings: &Settings,
    last_year: f64,
) -> Result<(), TreeError> {
    let youngest = settings.steps();
    drawing.skeleton.segments.clear();
    drawing.shoots.clear();
    drawing.owners.clear();
    drawing.widths = false;
    drawing.skeleton.segments.reserve(modules.count(b'F'));
    drawing.shoots.reserve(modules.count(b'L'));
    drawing.owners.reserve(modules.list.len());
    let (mut state, mut saved, mut angles) = (State::start(), Vec::new(), Angles::new());
    let mut axes = 0;
    for module in &modules.list {
        let argument = module.argument();
        let degrees = argument.unwrap_or(settings.angle);
        match module.letter {
            b'F' => {
                let birth = (module.id, module.birth);
                let length = argument.unwrap_or(1.0) * if module.birth == youngest { last_year } else { 1.0 };
                let sag = state.sag(settings.sag, youngest.saturating_sub(module.birth));
                draw_segment(drawing, &mut state, &mut axes, (length, sag), birth, settings)?;
                if state.position.amax() > FARTHEST {
                    return Err(TreeError::Far);
                }
            }
            b'f' => state.position += state.heading * argument.unwrap_or(1.0),
            b'L' => {
                let scale = argument.unwrap_or(1.0);
                if !(0.0..=LARGEST_LEAF).contains(&scale) {
                    return Err(TreeError::Leaf { scale });
                }
                drawing.shoots.push(shoot(&state, module.id, scale));
            }
            b'+' => state.yaw(angles.turn(degrees)),
            b'-' => state.yaw(back(angles.turn(degrees))),
            b'&' => state.pitch(angles.turn(degrees)),
            b'^' => state.pitch(back(angles.turn(degrees))),
            b'\\' => state.roll(angles.turn(degrees)),
            b'/' => state.roll(back(angles.turn(degrees))),
            b'|' => state.yaw(angles.turn(180.0)),
            b'$' => state.level(),
            b'!' => {
                let centimetres = argument.unwrap_or(0.0);
                if !(0.0..=THICKEST).contains(&centimetres) {
                    return Err(TreeError::Width { centimetres });
                }
                drawing.widths = true;
                state.radius = centimetres * 0.005;
            }
            b'[' => {
                saved.push(state.clone());
                state.branches = true;
            }
            b']' => state = saved.pop().unwrap_or_else(State::start),
            _ => {}
        }
        drawing.owners.push(state.segment);
    }
    Ok(())
}

fn draw_segment(
    drawing: &mut Drawing,
    state: &mut State,
    axes: &mut u32,
    (length, sag): (f64, f64),
    (id, birth): (u64, u32),
    settings: &Settings,
) -> Result<(), TreeError> {
    if !(0.0..=LONGEST).contains(&length) {
        return Err(TreeError::Length { metres: length });
    }
    if length == 0.0 {
        return Ok(());
    }
    let direction = DVec3::from(settings.tropism_direction);
    if settings.tropism != 0.0 {
        state.bend(settings.tropism * length, direction);
    }
    if sag != 0.0 {
        state.bend(sag * length, -DVec3::y());
    }
    state.orthonormalise();
    if state.branches {
        state.order = if state.segment.is_some() { state.order + 1 } else { 0 };
        (state.axis, state.branches) = (*axes, false);
        *axes += 1;
    }
    let (start, end) = (state.position, state.position + state.heading * length);
    let (parent, axis, order, radius) = (state.segment, state.axis, state.order, state.radius);
    state.segment = Some(drawing.skeleton.segments.len() as u32);
    state.position = end;
    drawing.skeleton.segments.push(Segment { id, parent, axis, order, start, end, birth, radius });
    if settings.segment_tropism != 0.0 {
        state.bend(settings.segment_tropism, direction);
    }
    Ok(())
}

fn shoot(state: &State, id: u64, scale: f64) -> Shoot {
    let (segment, position, heading, up, order) = (state.segment, state.position, state.heading, state.up, state.order);
    Shoot { id, segment, position, heading, up, scale: scale.max(0.0), order }
}

#[cfg(test)]
mod tests {
    use super::super::{Settings, grow};
    use super::*;
    use crate::base::limits::Limits;
    use crate::base::maths::{cos, sin};

    fn ends(axiom: &str) -> Vec<DVec3> {
        let settings = Settings { axiom: axiom.to_owned(), iterations: 0, angle: 90.0, ..Settings::default() };
        let (tree, _) = grow(&settings, 1, &Limits::default()).unwrap();
        tree.skeleton.segments.iter().map(|segment| segment.end).collect()
    }

    #[test]
    fn turns_go_the_way_they_are_named() {
        let (x, y, z) = (DVec3::x(), DVec3::y(), DVec3::z());
        let cases = [
            ("F", y),
            ("+F", -x),
            ("-F", x),
            ("&F", -z),
            ("^F", z),
            ("|F", -y),
            ("f(2)F", y * 3.0),
            ("+$&F", -y),
            ("[+F]F(2)", -x),
        ];
        for (axiom, wanted) in cases {
            assert!((ends(axiom)[0] - wanted).norm() < 1e-12, "{axiom}: {}", ends(axiom)[0]);
        }
        // A roll about H by the right-hand rule takes L = -X to U = +Z.
        assert!((ends("\\+F")[0] - z).norm() < 1e-12);
        assert!((ends("/+F")[0] + z).norm() < 1e-12);
    }

    #[test]
    fn old_branches_sag_and_the_trunk_does_not() {
        let rules = vec!["A -> F(0.5)[+(60)B]A".to_owned(), "B -> F(0.3)B".to_owned()];
        let settings = |sag| Settings {
            axiom: "+(10)A".to_owned(),
            rules: rules.clone(),
            iterations: 9,
            sag,
            ..Settings::default()
        };
        let lean = |sag| {
            let segments = grow(&settings(sag), 1, &Limits::default()).unwrap().0.skeleton.segments;
            let steepness = |axis: u32| segments.iter().rev().find(|s| s.axis == axis).unwrap().direction().y;
            (steepness(0), steepness(1))
        };
        let ((trunk, limb), (same, sagged)) = (lean(0.0), lean(0.2));
        assert!((trunk - same).abs() < 1e-12);
        assert!(sagged < limb - 0.05);
        // The first 0.3 m of the lowest limb is 7 years old: 0.2 x 7/17 x 0.3 |sin| radians.
        let first = |sag| grow(&settings(sag), 1, &Limits::default()).unwrap().0.skeleton.segments[1].direction();
        let angle = crate::base::maths::acos(first(0.0).dot(&first(0.2)));
        assert!((angle - 0.06 * 7.0 / 17.0 * sin(70f64.to_radians())).abs() < 1e-9, "{angle}");
    }

    #[test]
    fn tropism_turns_by_its_susceptibility_and_not_past_the_vertical() {
        let settings =
            |tropism| Settings { axiom: "+(90)F(0.5)".to_owned(), iterations: 0, tropism, ..Settings::default() };
        let end = |tropism| grow(&settings(tropism), 1, &Limits::default()).unwrap().0.skeleton.segments[0].end;
        assert!((end(0.4) - DVec3::new(-cos(0.2), sin(0.2), 0.0) * 0.5).norm() < 1e-12);
        assert!((end(10.0) - DVec3::y() * 0.5).norm() < 1e-12);
    }

    #[test]
    fn bending_a_segment_at_a_time_has_a_direction_and_does_not_depend_on_length() {
        let grown = |length: f64, segment_tropism, tropism_direction| {
            let axiom = format!("+(90)F({length})F(1)");
            let settings = Settings { axiom, iterations: 0, segment_tropism, tropism_direction, ..Settings::default() };
            let segments = grow(&settings, 1, &Limits::default()).unwrap().0.skeleton.segments;
            assert!((segments[0].direction() + DVec3::x()).norm() < 1e-12);
            segments[1].direction()
        };
        for length in [0.1, 3.0] {
            let down = grown(length, 0.3, [0.0, -1.0, 0.0]);
            assert!((down - DVec3::new(-cos(0.3), -sin(0.3), 0.0)).norm() < 1e-12);
            assert!((grown(length, -0.3, [0.0, 1.0, 0.0]) - down).norm() < 1e-12);
            // twice the force, a slant of 30 degrees
            let slant = [-2.0 * cos(0.5), 0.0, 2.0 * sin(0.5)];
            let turn = 0.2 * 2.0 * sin(0.5);
            assert!((grown(length, 0.2, slant) - DVec3::new(-cos(turn), 0.0, sin(turn))).norm() < 1e-12);
            assert!((grown(length, 9.0, slant) - DVec3::new(-cos(0.5), 0.0, sin(0.5))).norm() < 1e-12);
        }
    }
}
