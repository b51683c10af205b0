//! The way down of one leaf.
//!
//! A leaf flutters when its Froude number is low, tumbles when it is high, and between the two does the one or the other by
//! chance; some leaves spiral instead. Each motion is a function of the metres fallen, so it starts and ends with the descent:
//! the leaf leaves its twig at rest in the attitude in which it hung, and arrives in that in which it will lie.

use super::descent::{Descent, GRAVITY, froude, terminal_speed};
use super::wind::Wind;
use super::{DAY, Fallen};
use crate::base::maths::{cos, exp, sin, sincos, smooth_step};
use crate::base::random::{Purpose, Stream};
use crate::base::vector::{DVec2, DVec3};
use nalgebra::{UnitQuaternion, UnitVector3};
use std::f64::consts::{PI, TAU};

/// Spread of terminal speeds among leaves of one kind (standard deviation of the logarithm; judged).
const SPREAD: f64 = 0.15;
/// Froude numbers below which leaves flutter and above which they tumble (0.67 +- 0.05, Belmonte et al. 1998).
const BORDER: [f64; 2] = [0.62, 0.72];
/// Share of leaves that spiral (judged).
const SPIRALS: f64 = 0.15;
/// Least height of a flight, metres.
const LEAST_HEIGHT: f64 = 0.02;
/// Most turns and swings a second: faster ones cannot be followed by the eye (judged).
const MOST_TURNS: f64 = 4.0;
/// Metres within which the motion builds up after the leaf has let go.
const ONSET: f64 = 0.25;
/// Seconds within which a leaf turns from the attitude in which it hung to that of its flight.
const TURNING: f64 = 0.9;

/// How a leaf moves about its mean way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// It swings from side to side.
    Flutter {
        /// Sideways amplitude along and across the heading, metres.
        swing: [f64; 2],
        /// Largest tilt, radians.
        tilt: f64,
        /// Half swings in all: whole, so that it arrives level.
        half_swings: f64,
    },
    /// It turns over and over about a level axis and drifts across that.
    Tumble {
        /// Turns in all: whole, so that it arrives as it will lie.
        turns: f64,
        /// Metres aside a metre fallen.
        glide: f64,
        /// How its heading turns, radians a metre fallen.
        veer: f64,
    },
    /// It circles, banked, like a maple's key.
    Spiral {
        /// Radius, metres.
        radius: f64,
        /// Bank, radians.
        bank: f64,
        /// Turns in all, whole.
        turns: f64,
    },
}

/// The flight of a leaf, from its twig to the ground.
#[derive(Clone, Copy, Debug)]
pub struct Flight {
    /// Its descent.
    pub descent: Descent,
    /// Height that it falls through, metres.
    pub height: f64,
    /// Seconds from the twig to the ground.
    pub seconds: f64,
    /// How it moves.
    pub motion: Motion,
    /// Heading of the motion, radians from +x towards +z.
    heading: f64,
    /// When it let go, seconds.
    start: f64,
}

impl Flight {
    /// The flight of a leaf over ground at `ground` metres.
    #[must_use]
    pub fn new(leaf: &Fallen, seed: u64, ground: f64) -> Self {
        let mut stream = Stream::new(seed, Purpose::Flight, leaf.leaf, leaf.year);
        // mean 1: the mean over leaves is the speed of the formula
        let chance = exp(SPREAD * stream.normal().clamp(-3.0, 3.0) - 0.5 * SPREAD * SPREAD);
        let descent = Descent { speed: (terminal_speed(leaf.mass_per_area) * chance).clamp(0.4, 2.5) };
        let height = (leaf.twig.y - ground).max(LEAST_HEIGHT);
        let motion = motion(leaf, descent.speed, height, &mut stream);
        let heading = stream.range(0.0, TAU);
        Self { descent, height, seconds: descent.seconds(height), motion, heading, start: leaf.day * DAY }
    }

    /// When the leaf arrives, days, if it comes down `slow_motion` times slower than in life.
    #[must_use]
    pub fn lands(&self, leaf: &Fallen, slow_motion: f64) -> f64 {
        leaf.day + self.seconds * slow_motion / DAY
    }

    /// How far the leaf has moved aside, along x and z, so many seconds of its own after it let go, metres.
    #[must_use]
    pub fn aside(&self, wind: &Wind, seconds: f64) -> DVec2 {
        let seconds = seconds.clamp(0.0, self.seconds);
        let done = self.done(seconds);
        let response = self.descent.speed / GRAVITY;
        let carried = wind.carried(self.start, self.height, self.descent.speed, done);
        carried + wind.gusted(self.start, seconds, response) + self.sway(done)
    }

    /// How far it is above or below its mean height, metres: it rises a little at the ends of its swings.
    #[must_use]
    pub fn lift(&self, seconds: f64) -> f64 {
        match self.motion {
            Motion::Flutter { swing, tilt, half_swings } => {
                let done = self.done(seconds);
                let phase = TAU * half_swings * done;
                -0.25 * swing[0] * tilt * sin(phase) * self.onset(done) * (1.0 - done)
            }
            _ => 0.0,
        }
    }

    /// The share of the height that is behind the leaf.
    #[must_use]
    pub fn done(&self, seconds: f64) -> f64 {
        (self.descent.fallen(seconds) / self.height).clamp(0.0, 1.0)
    }

    /// How much of its motion a leaf has taken up.
    fn onset(&self, done: f64) -> f64 {
        let metres = done * self.height / ONSET;
        1.0 - exp(-metres * metres)
    }

    /// The motion's own way aside.
    fn sway(&self, done: f64) -> DVec2 {
        let (sine, cosine) = sincos(self.heading);
        let (along, across) = (DVec2::new(cosine, sine), DVec2::new(-sine, cosine));
        let onset = self.onset(done);
        match self.motion {
            Motion::Flutter { swing, half_swings, .. } => {
                let phase = PI * half_swings * done;
                (along * (swing[0] * sin(phase)) + across * (swing[1] * sin(0.618 * phase))) * onset
            }
            Motion::Tumble { glide, veer, .. } => {
                // the chord of an arc of this length, whose heading turns evenly
                let metres = done * self.height;
                let half = 0.5 * veer * metres;
                let chord = if half.abs() < 1e-6 { metres } else { metres * sin(half) / half };
                let (sine, cosine) = sincos(self.heading + half);
                DVec2::new(cosine, sine) * (glide * chord * onset)
            }
            Motion::Spiral { radius, turns, .. } => {
                let (sine, cosine) = sincos(self.heading + TAU * turns * done);
                (DVec2::new(cosine, sine) - along) * (radius * onset)
            }
        }
    }

    /// Its attitude, from `hung` on the twig to `lying` on the ground.
    #[must_use]
    pub fn attitude(
        &self,
        seconds: f64,
        hung: &UnitQuaternion<f64>,
        lying: &UnitQuaternion<f64>,
    ) -> UnitQuaternion<f64> {
        let turning = TURNING.min(0.8 * self.seconds).max(1e-6);
        let share = f64::from(smooth_step(0.0, 1.0, (seconds / turning) as f32));
        let level = hung.try_slerp(lying, share, 1e-9).unwrap_or(if share < 0.5 { *hung } else { *lying });
        let done = self.done(seconds);
        let (sine, cosine) = sincos(self.heading);
        let across = UnitVector3::new_unchecked(DVec3::new(-sine, 0.0, cosine));
        let turn = |axis: &UnitVector3<f64>, angle: f64| UnitQuaternion::from_axis_angle(axis, angle);
        // motions die out over the last centimetres
        let settling = f64::from(smooth_step(0.0, 0.12, ((1.0 - done) * self.height) as f32));
        match self.motion {
            Motion::Flutter { tilt, half_swings, .. } => {
                // tilted most where it is fastest, in the middle of a swing
                let phase = PI * half_swings * done;
                turn(&across, tilt * cos(phase) * self.onset(done) * settling) * level
            }
            Motion::Tumble { turns, .. } => turn(&across, TAU * turns * done) * level,
            Motion::Spiral { bank, turns, .. } => {
                let yaw = turn(&DVec3::y_axis(), -TAU * turns * done);
                yaw * turn(&across, bank * self.onset(done) * settling) * level
            }
        }
    }
}

fn motion(leaf: &Fallen, speed: f64, height: f64, stream: &mut Stream) -> Motion {
    let length = leaf.length.max(5e-3);
    let number = froude(leaf.mass_per_area, length);
    let chance = stream.uniform();
    let whole = |per_metre: f64| (height * per_metre.min(MOST_TURNS / speed)).round().max(1.0);
    if stream.uniform() < SPIRALS {
        let turns = whole(stream.range(1.0, 2.0) / speed);
        return Motion::Spiral { radius: length * stream.range(0.5, 2.0), bank: stream.range(0.2, 0.6), turns };
    }
    let tumbles = chance < (number - BORDER[0]) / (BORDER[1] - BORDER[0]);
    if tumbles {
        let turns = whole(stream.range(0.5, 1.0) / (PI * length));
        return Motion::Tumble { turns, glide: stream.range(0.12, 0.48), veer: 0.3 * stream.normal() };
    }
    // 0.25 V / length swings a second, 0.8 to 4 (oracle: 1 to 2 Hz for a strip of 8 cm)
    let swings = (0.25 * speed / length).clamp(0.8, MOST_TURNS) / speed;
    let swing = [length * stream.range(0.5, 1.5), length * stream.range(0.1, 0.6)];
    Motion::Flutter { swing, tilt: stream.range(0.3, 0.8), half_swings: (2.0 * height * swings).round().max(1.0) }
}
