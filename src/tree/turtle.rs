//! The turtle of Prusinkiewicz and Lindenmayer, "The Algorithmic Beauty of Plants" (1990), section 1.5, in metres.
//!
//! It starts at the origin with heading H = +Y, left L = -X and up U = +Z (H x L = U). Turns follow the right-hand rule about
//! their axis: `+` about U (to the left), `&` about L (down), `\` about H; `-`, `^` and `/` are their opposites, `|` turns
//! round. `$` rolls so that L is level. `F(m)` draws, `f(m)` moves, both 1 m without an argument; `!(cm)` sets the diameter;
//! `L(s)` is a leaf of relative size s (1 without an argument). Other upper-case letters, `{` and `}` are silent.

use super::TreeError;
use super::derivation::Modules;
use super::skeleton::{Segment, Shoot, Skeleton};
use crate::base::vector::{DVec3, rotated};

/// What the turtle drew.
#[derive(Clone, Debug, Default)]
pub(super) struct Drawing {
    pub skeleton: Skeleton,
    pub shoots: Vec<Shoot>,
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

    fn turn(&mut self, axis: DVec3, angle: f64) {
        self.heading = rotated(self.heading, axis, angle);
        self.left = rotated(self.left, axis, angle);
        self.orthonormalise();
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
            let left = crate::base::maths::atan2(torque.norm(), self.heading.y);
            self.turn(axis, (susceptibility * torque.norm()).min(left));
        }
    }
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
            }
            b'f' => state.position += state.heading * argument.unwrap_or(1.0),
            b'L' => drawing.shoots.push(shoot(&state, modules.ids[module], argument.unwrap_or(1.0))),
            b'+' => state.turn(state.up, radians),
            b'-' => state.turn(state.up, -radians),
            b'&' => state.turn(state.left, radians),
            b'^' => state.turn(state.left, -radians),
            b'\\' => state.turn(state.heading, radians),
            b'/' => state.turn(state.heading, -radians),
            b'|' => state.turn(state.up, std::f64::consts::PI),
            b'$' => state.level(),
            b'!' => {
                drawing.widths = true;
                state.radius = (argument.unwrap_or(0.0) * 0.005).max(0.0);
            }
            b'[' => {
                saved.push(state.clone());
                state.branches = true;
            }
            b']' => state = saved.pop().unwrap_or_else(State::start),
            _ => {}
        }
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
    if length < 0.0 || length > 1e4 {
        return Err(TreeError::Length { metres: length });
    }
    if length == 0.0 {
        return Ok(());
    }
    state.bend(tropism * length);
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
