//! The instances that are drawn.

use crate::base::random::hash;
use crate::frame::{Frame, Instance};

/// The instances of a frame, then those of its ground's cover.
#[derive(Clone)]
pub(super) struct Drawn {
    /// All of them; their places are their numbers.
    pub all: Vec<Instance>,
    /// How many stand, and how many do not belong to the cover.
    standing: usize,
    placed: usize,
}

impl Drawn {
    /// Those of a frame.
    pub(super) fn of(frame: &Frame) -> Self {
        let cover = frame.ground.iter().flat_map(|ground| &ground.cover);
        let all = frame.instances.iter().chain(cover).copied().collect();
        Self { all, standing: frame.standing().len(), placed: frame.instances.len() }
    }

    /// Those that stand.
    pub(super) fn standing(&self) -> &[Instance] {
        &self.all[..self.standing]
    }

    /// What an instance is known by in every frame: where leaves fall and decay from day to day, those that lie beside them, and
    /// the grass, keep the grain of their shadows.
    pub(super) fn salt(&self, number: u32) -> u64 {
        let place = number as usize;
        match self.all[place].leaf {
            Some(leaf) if place >= self.standing && place < self.placed => hash(leaf, 1),
            _ if place >= self.placed => (place - self.placed + self.standing) as u64,
            _ => u64::from(number),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::vector::Affine;

    #[test]
    fn what_lies_and_grows_is_known_by_the_same_when_leaves_decay() {
        let one = |leaf: Option<u64>| Instance { model: 0, transform: Affine::identity(), leaf };
        let with = |fallen: &[u64]| {
            let leaves = [None, Some(40)].into_iter().chain(fallen.iter().map(|leaf| Some(*leaf)));
            let all = leaves.chain([None; 2]).map(one).collect();
            Drawn { all, standing: 2, placed: 2 + fallen.len() }
        };
        let (many, few) = (with(&[7, 8, 9]), with(&[7, 9]));
        let known = |drawn: &Drawn| (0..drawn.all.len() as u32).map(|number| drawn.salt(number)).collect::<Vec<u64>>();
        let (many, few) = (known(&many), known(&few));
        assert_eq!([&many[..3], &many[4..]].concat(), few);
        assert_eq!((few[0], few[1], few[4], few[5]), (0, 1, 2, 3));
    }
}
