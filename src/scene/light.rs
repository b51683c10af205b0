//! Sun, sky and exposure.

use crate::base::calendar::Date;
use crate::base::settings::Complaint;
use crate::{choice, settings};

choice! {
    /// How linear light becomes the colours of the file.
    pub enum Tone {
        /// Khronos PBR Neutral: colours below 0.76 stay as set, brighter ones are compressed.
        Neutral = "neutral",
        /// AgX: holds more of a scene's range, as film does; bright colours pale. For light from behind.
        Agx = "agx",
        /// None but clipping: for measurements.
        None = "none",
    }
}

choice! {
    /// What sets the exposure.
    pub enum Metering {
        /// The light of sun and sky on level ground, as an incident light meter reads it: the same in every frame and from
        /// every side.
        Incident = "incident",
        /// The picture itself, each frame for itself.
        Auto = "auto",
    }
}

settings! {
    /// The light.
    pub struct Light {
        /// Height of the sun above the horizon; below 0 there is no sunlight.
        sun_elevation: f64 = 38.0, unit "°", range -90.0 => 90.0;
        /// Direction of the sun relative to the camera's viewing axis: 0 behind the camera, 90 from the right.
        sun_azimuth: f64 = 50.0, unit "°", range -360.0 => 360.0;
        /// Date whose sun it is, "YEAR-MONTH-DAY"; its height and direction then follow from `hour`, `latitude` and `north`.
        date: Option<String> = None;
        /// Hour of the day on that date, local mean time: the sun is highest about 12.
        hour: f64 = 14.0, unit "h", range 0.0 => 24.0;
        /// Latitude of the place, with a date; the south is negative.
        latitude: f64 = 45.0, unit "°", range -90.0 => 90.0;
        /// Where north lies, with a date: 0 before the default camera, 90 to its right.
        north: f64 = 0.0, unit "°", range -360.0 => 360.0;
        /// Haze of the air: 2 is very clear, 3 clear, 6 hazy.
        turbidity: f64 = 2.5, range 1.0 => 10.0;
        /// Share of the sky that clouds cover: 0 clear, 1 overcast. They dim the sun and even the light out.
        clouds: f64 = 0.0, range 0.0 => 1.0;
        /// Strength of the sun; 1 is a clear day.
        sun: f64 = 1.0, range 0.0 => 1e6;
        /// Strength of the sky; 1 is a clear day.
        sky: f64 = 1.0, range 0.0 => 1e6;
        /// Correction of the exposure: each step doubles the light of the picture.
        exposure: f64 = 0.0, unit "EV", range -20.0 => 20.0;
        /// Exposure value at ISO 100, as an incident light meter shows it: 15 in full sun; found from sun and sky when absent.
        exposure_value: Option<f64> = None, unit "EV", range -10.0 => 25.0;
        /// What sets the exposure when no value is given.
        metering: Metering = Metering::Incident;
        /// Colour temperature of the light that is to look white: lower makes the picture bluer; sRGB's own 6500 when absent.
        white_balance: Option<f64> = None, unit "K", range 1667.0 => 25000.0;
        /// How linear light becomes the colours of the file.
        tone: Tone = Tone::Neutral;
        /// Side of the shadow map; 0 for no shadows.
        shadow_size: u32 = 2048, unit "px", range 0 => 16384;
    }
}

/// What is wrong with well-typed settings.
#[must_use]
pub fn check(light: &Light) -> Vec<Complaint> {
    match light.date.as_deref() {
        Some(text) if Date::parse(text).is_none() => {
            let what = format!("`{text}` is no date");
            vec![Complaint::new("date", what, "write year, month and day: \"2017-10-12\"")]
        }
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_dates_are_dates() {
        let of = |text: &str| check(&Light { date: Some(text.to_owned()), ..Light::default() }).len();
        assert_eq!((of("2017-10-12"), of("2017-13-12"), of("October")), (0, 1, 1));
        assert!(check(&Light::default()).is_empty());
    }
}
