//! The keys of `[fall]`.

use crate::settings;

settings! {
    /// Leaves that fall: in the air, and as litter on the ground.
    pub struct Settings {
        /// Whether leaves that have fallen are seen; when absent, where there is a ground to lie on.
        on: Option<bool> = None;
        /// Mean speed of the wind over the height that a leaf falls through.
        wind: f64 = 0.3, unit "m/s", range 0.0 => 20.0;
        /// Where the wind blows to: 0 along +x, 90 along +z (with the camera left open: to the right, towards the camera). When
        /// absent, every day has its own direction by chance and the hours wander about it.
        direction: Option<f64> = None, unit "°", range -360.0 => 360.0;
        /// Standard deviation of gusts along each direction over the mean speed; hours are calm or blustery by chance.
        gustiness: f64 = 1.0, range 0.0 => 5.0;
        /// Time over which gusts keep their strength (correlation e^-1).
        gust_time: f64 = 4.0, unit "s", range 0.1 => 600.0;
        /// Whether leaves are seen on their way down; otherwise they lie on the ground as soon as they let go.
        air: bool = true;
        /// How many times slower than in life leaves come down. An autumn tree has less than one leaf in the air at once: a
        /// film of days in seconds shows leaves in the air only with some hundred.
        slow_motion: f64 = 1.0, range 1.0 => 1e5;
        /// Radius about every trunk that is kept clear of litter.
        raked: f64 = 0.0, unit "m", range 0.0 => 1e3;
        /// Mean time that a leaf lies until nothing is left of it; that of the species when absent.
        days: Option<f64> = None, unit "d", range 0.0 => 1e6;
        /// Mean time on the ground until a leaf is brown; that of the species when absent.
        browning: Option<f64> = None, unit "d", range 0.0 => 1e6;
    }
}

settings! {
    /// How the litter of a species goes.
    pub struct Decay {
        /// Mean time that a leaf lies until nothing is left of it.
        days: f64 = 200.0, unit "d", range 0.0 => 1e6;
        /// Mean time on the ground until a leaf is brown.
        browning: f64 = 12.0, unit "d", range 0.0 => 1e6;
    }
}

impl Settings {
    /// The species' decay with what these settings say in its place.
    #[must_use]
    pub fn decay(&self, species: &Decay) -> Decay {
        Decay { days: self.days.unwrap_or(species.days), browning: self.browning.unwrap_or(species.browning) }
    }
}
