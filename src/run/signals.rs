//! Signals end a run between two steps: they only set a flag, which the run looks at, so that no file is left half written
//! and the temporary of the frame at hand is removed. A second signal ends the process at once.

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::flag::{register_conditional_shutdown, register_usize};
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// A flag that a signal has set, or will.
#[derive(Clone, Debug, Default)]
pub struct Signals(Arc<AtomicUsize>);

impl Signals {
    /// Starts to listen to SIGINT, SIGTERM and SIGHUP. A SIGHUP that was ignored before the program started stays ignored,
    /// as `nohup` wants it.
    ///
    /// # Errors
    /// When the system does not let a handler be set.
    pub fn listen() -> io::Result<Self> {
        let signals = Self::default();
        let second = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|&signal| signal != SIGHUP || !is_ignored(SIGHUP)) {
            // In this order: the first signal finds `second` unset, passes, and sets it.
            register_conditional_shutdown(signal, 128 + signal, Arc::clone(&second))?;
            signal_hook::flag::register(signal, Arc::clone(&second))?;
            register_usize(signal, Arc::clone(&signals.0), signal as usize)?;
        }
        Ok(signals)
    }

    /// The exit code of the signal that came, 128 plus its number; `None` while none has come.
    #[must_use]
    pub fn exit_code(&self) -> Option<u8> {
        match self.0.load(Ordering::Relaxed) {
            0 => None,
            signal => u8::try_from(128 + signal).ok(),
        }
    }

    /// Whether the run should end.
    #[must_use]
    pub fn came(&self) -> bool {
        self.exit_code().is_some()
    }
}

/// Whether a signal is ignored, by the mask that Linux shows; elsewhere it is taken not to be.
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    mask >> (signal - 1) & 1 == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_signal_sets_the_flag_and_its_exit_code() {
        let signals = Signals::listen().unwrap();
        assert!(!signals.came());
        signal_hook::low_level::raise(SIGTERM).unwrap();
        assert_eq!(signals.exit_code(), Some(143));
        assert!(signals.clone().came());
    }
}
