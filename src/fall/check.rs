//! What can be wrong with well-typed settings.

use super::{Decay, Settings};
use crate::base::settings::Complaint;

/// Everything wrong with the scene's settings.
#[must_use]
pub fn check(settings: &Settings) -> Vec<Complaint> {
    let mut complaints = Vec::new();
    if !settings.air && settings.slow_motion > 1.0 {
        complaints.push(Complaint::new(
            "slow_motion",
            "`slow_motion` slows leaves in the air, but `air` is false",
            "take `slow_motion` away, or set `air = true`",
        ));
    }
    if let (Some(days), Some(browning)) = (settings.days, settings.browning) {
        complaints.extend(order(days, browning));
    }
    complaints
}

/// Everything wrong with a species' decay.
#[must_use]
pub fn check_decay(decay: &Decay) -> Vec<Complaint> {
    order(decay.days, decay.browning).into_iter().collect()
}

fn order(days: f64, browning: f64) -> Option<Complaint> {
    (browning > days).then(|| {
        let what = format!("leaves are brown after {browning} days, but gone after {days}");
        Complaint::new("browning", what, "let `browning` be at most `days`")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_sound_and_contradictions_are_told_at_their_key() {
        assert!(check(&Settings::default()).is_empty() && check_decay(&Decay::default()).is_empty());
        let still = Settings { air: false, slow_motion: 10.0, ..Settings::default() };
        assert_eq!(check(&still)[0].key, "slow_motion");
        let order = Settings { days: Some(3.0), browning: Some(4.0), ..Settings::default() };
        assert_eq!(check(&order)[0].key, "browning");
        assert_eq!(check_decay(&Decay { days: 1.0, browning: 2.0 })[0].key, "browning");
    }
}
