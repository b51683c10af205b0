//! The random numbers of one module in one derivation step, keyed by the module's identity: what a rule draws does not depend
//! on what other rules drew.

use crate::base::random::{Purpose, Stream};

/// Events of one module and step are told apart from the choice of its rule by this bit.
const CHOICE: u64 = 1 << 32;

/// Draws of the module that is being rewritten; the generator is only set up when it is asked.
#[derive(Debug)]
pub(super) struct Draws {
    seed: u64,
    id: u64,
    step: u64,
    stream: Option<Stream>,
}

impl Draws {
    pub fn new(seed: u64, id: u64, step: u32) -> Self {
        Self { seed, id, step: u64::from(step), stream: None }
    }

    /// Numbers for `rand` and `normal`, in the order of evaluation.
    pub fn stream(&mut self) -> &mut Stream {
        let (seed, id, step) = (self.seed, self.id, self.step);
        self.stream.get_or_insert_with(|| Stream::new(seed, Purpose::Derivation, id, step))
    }

    /// The number in [0, 1) that chooses between weighted rules.
    pub fn choice(&self) -> f64 {
        Stream::new(self.seed, Purpose::Derivation, self.id, self.step | CHOICE).uniform()
    }
}
