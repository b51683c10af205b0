//! The turtle of Prusinkiewicz and Lindenmayer, "The Algorithmic Beauty of Plants" (1990), section 1.5, in metres.
//!
//! It starts at the origin with heading H = +Y, left L = -X and up U = +Z (H x L = U). Turns follow the right-hand rule about
//! their axis: `+` about U (to the left), `&` about L (down), `\` about H; `-`, `^` and `/` are their opposites, `|` turns
//! round. `$` rolls so that L is level. `F(m)` draws, `f(m)` moves, both 1 m without an argument; `!(cm)` sets the diameter;
//! `L(s)` is a leaf of relative size s (1 without an argument). Other upper-case letters, `{` and `}` are silent.

use super::TreeError;
use super::derivation::Modules;
use super::skeleton::{Segment, Shoot, Skeleton};
use crate::base::maths::{atan2, sincos};
use crate::base::vector::{DVec3, rotated};

/// Longest segment, metres.
const LONGEST: f64 = 1e4;
/// Farthest that wood may stand from the root on any axis, metres.
const FARTHEST: f64 = 1e5;
/// Thickest wood, centimetres.
const THICKEST: f64 = 1e4;
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
    fn yaw(&mut self, angle: f64) {
        (self.heading, self.left) = turned(self.heading, self.left, angle);
    }

    /// Turns about L: U towards H.
    fn pitch(&mut self, angle: f64) {
        (self.up, self.heading) = turned(self.up, self.heading, angle);
    }

    /// Turns about H: L towards U.
    fn roll(&mut self, angle: f64) {
        (self.left, self.up) = turned(self.left, self.up, angle);
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

    /// Bends the heading towards +Y by `susceptibility` |H x T| radians (the torque of section 2.1.1 with T = +Y).
    fn bend(&mut self, susceptibility: f64) {
        let torque = self.heading.cross(&DVec3::y());
        if let Some(axis) = torque.try_normalize(1e-12) {
            // Never beyond the vertical: angles up to the one left.
            let left = atan2(torque.norm(), self.heading.y);
            let angle = (susceptibility * torque.norm()).min(left);
            self.heading = rotated(self.heading, axis, angle);
            self.left = rotated(self.left, axis, angle);
        }
    }
}

/// Two vectors at right angles turned in their plane, the first towards the second (radians).
fn turned(first: DVec3, second: DVec3, angle: f64) -> (DVec3, DVec3) {
    let (sine, cosine) = sincos(angle);
    (first * cosine + second * sine, second * cosine - first * sine)
}

/// Follows the string. `angle` (degrees) is that of turns without an argument, `tropism` in radians a metre.
pub(super) fn draw(modules: &Modules, angle: f64, tropism: f64) -> Result<Drawing, TreeError> {
    let mut drawing = Drawing::default();
    let (mut state, mut saved) = (State::start(), Vec::new());
    let mut axes = 0;
    for module in 0..modules.len() {
        let argument = modules.parameters(module).first().copied();
        let radians = argument.unwrap_or(angle).to_radians();
        match modules.letters[module] {
            b'F' => {
                let birth = (modules.ids[module], modules.births[module]);
                draw_segment(&mut drawing, &mut state, &mut axes, argument.unwrap_or(1.0), birth, tropism)?;
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
                drawing.shoots.push(shoot(&state, modules.ids[module], scale));
            }
            b'+' => state.yaw(radians),
            b'-' => state.yaw(-radians),
            b'&' => state.pitch(radians),
            b'^' => state.pitch(-radians),
            b'\\' => state.roll(radians),
            b'/' => state.roll(-radians),
            b'|' => state.yaw(std::f64::consts::PI),
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
    Ok(drawing)
}

fn draw_segment(
    drawing: &mut Drawing,
    state: &mut State,
    axes: &mut u32,
    length: f64,
    (id, birth): (u64, u32),
    tropism: f64,
) -> Result<(), TreeError> {
    if !(0.0..=LONGEST).contains(&length) {
        return Err(TreeError::Length { metres: length });
    }
    if length == 0.0 {
        return Ok(());
    }
    if tropism != 0.0 {
        state.bend(tropism * length);
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
    use std::collections::BTreeMap;

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
    fn tropism_turns_by_its_susceptibility_and_not_past_the_vertical() {
        let settings =
            |tropism| Settings { axiom: "+(90)F(0.5)".to_owned(), iterations: 0, tropism, ..Settings::default() };
        let end = |tropism| grow(&settings(tropism), 1, &Limits::default()).unwrap().0.skeleton.segments[0].end;
        assert!((end(0.4) - DVec3::new(-cos(0.2), sin(0.2), 0.0) * 0.5).norm() < 1e-12);
        assert!((end(10.0) - DVec3::y() * 0.5).norm() < 1e-12);
    }

    /// Figure 2.6 a of the book: Honda's monopodial tree.
    fn honda(iterations: u32) -> Settings {
        let constants = [("r1", 0.9), ("r2", 0.6), ("a0", 45.0), ("a2", 45.0), ("d", 137.5), ("wr", 0.707)];
        let rules = [
            "A(l,w) -> !(w)F(l)[&(a0)B(l*r2,w*wr)]/(d)A(l*r1,w*wr)",
            "B(l,w) -> !(w)F(l)[-(a2)$C(l*r2,w*wr)]C(l*r1,w*wr)",
            "C(l,w) -> !(w)F(l)[+(a2)$B(l*r2,w*wr)]B(l*r1,w*wr)",
        ];
        Settings {
            axiom: "A(1,10)".to_owned(),
            rules: rules.map(str::to_owned).to_vec(),
            constants: constants.map(|(name, value)| (name.to_owned(), value)).into_iter().collect::<BTreeMap<_, _>>(),
            iterations,
            ..Settings::default()
        }
    }

    /// The same tree by recursion with matrices whose columns are H, L and U.
    fn recurse(kind: char, base: DVec3, frame: crate::base::vector::DMat3, l: f64, left: u32, ends: &mut Vec<DVec3>) {
        use crate::base::vector::DMat3;
        if left == 0 {
            return;
        }
        let end = base + frame.column(0) * l;
        ends.push(end);
        let (c, s) = (cos(45f64.to_radians()), sin(45f64.to_radians()));
        let about_up = |s: f64| DMat3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0);
        let pitch = DMat3::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c);
        let (rc, rs) = (cos(137.5f64.to_radians()), sin(137.5f64.to_radians()));
        let roll = DMat3::new(1.0, 0.0, 0.0, 0.0, rc, rs, 0.0, -rs, rc);
        let level = |frame: DMat3| {
            let heading = frame.column(0).into_owned();
            let left = DVec3::y().cross(&heading).normalize();
            DMat3::from_columns(&[heading, left, heading.cross(&left)])
        };
        let (lateral, next, inner, outer) = match kind {
            'A' => ('B', 'A', frame * pitch, frame * roll),
            'B' => ('C', 'C', level(frame * about_up(-s)), frame),
            _ => ('B', 'B', level(frame * about_up(s)), frame),
        };
        recurse(lateral, end, inner, l * 0.6, left - 1, ends);
        recurse(next, end, outer, l * 0.9, left - 1, ends);
    }

    #[test]
    fn hondas_tree_has_its_segments_and_end_points() {
        let (tree, figures) = grow(&honda(10), 1, &Limits::default()).unwrap();
        assert_eq!(tree.skeleton.segments.len(), (1 << 10) - 1);
        assert_eq!(figures.values["segments"], 1023);
        let frame = crate::base::vector::DMat3::from_columns(&[DVec3::y(), -DVec3::x(), DVec3::z()]);
        let mut wanted = Vec::new();
        recurse('A', DVec3::zeros(), frame, 1.0, 10, &mut wanted);
        for (segment, wanted) in tree.skeleton.segments.iter().zip(&wanted) {
            assert!((segment.end - wanted).norm() < 1e-6);
        }
        let widths = tree.skeleton.segments.iter().map(|segment| segment.radius);
        assert!((widths.fold(1.0, f64::min) - 0.05 * crate::base::maths::pow(0.707, 9.0)).abs() < 1e-12);
        assert!(tree.wood.iter().all(|wood| wood.mesh.check() == Ok(())));
    }
}
