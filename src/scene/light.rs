//! Sun, sky and exposure.

use crate::{choice, settings};

choice! {
    /// How linear light becomes the colours of the file.
    pub enum Tone {
        /// Khronos PBR Neutral: colours below 0.76 stay as set, brighter ones are compressed.
        Neutral = "neutral",
        /// None but clipping: for measurements.
        None = "none",
    }
}

settings! {
    /// The light.
    pub struct Light {
        /// Height of the sun above the horizon; below 0 there is no sunlight.
        sun_elevation: f64 = 38.0, unit "°", range -90.0 => 90.0;
        /// Direction of the sun relative to the camera's viewing axis: 0 behind the camera, 90 from the right.
        sun_azimuth: f64 = 50.0, unit "°", range -360.0 => 360.0;
        /// Strength of the sun; 1 is a clear day.
        sun: f64 = 1.0, range 0.0 => 1e6;
        /// Strength of the sky; 1 is a clear day.
        sky: f64 = 1.0, range 0.0 => 1e6;
        /// Exposure: each step doubles the light.
        exposure: f64 = 0.0, unit "EV", range -20.0 => 20.0;
        /// How linear light becomes the colours of the file.
        tone: Tone = Tone::Neutral;
        /// Side of the shadow map; 0 for no shadows.
        shadow_size: u32 = 2048, unit "px", range 0 => 16384;
    }
}
