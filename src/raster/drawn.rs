//! The instances that are drawn.

use crate::base::random::hash;
use crate::frame::{Frame, Instance};
use std::borrow::Cow;

/// The instances of a frame, then those of its ground's cover.
#[derive(Clone)]
pub(super) struct Drawn<'a> {
    /// All of them; their places are their numbers. The frame's own where nothing covers its ground: a million of them are
    /// not held twice.
    pub all: Cow<'a, [Instance]>,
    /// How many stand.
    standing: usize,
}

impl<'a> Drawn<'a> {
    /// Those of a frame.
    pub(super) fn of(frame: &'a Frame) -> Self {
        let cover = frame.ground.as_ref().map_or(&[][..], |ground| &ground.cover);
        let all = match cover {
            [] => Cow::Borrowed(frame.instances.as_slice()),
            _ => Cow::Owned([frame.instances.as_slice(), cover].concat()),
        };
        Self { all, standing: frame.standing().len() }
    }

    /// The same for longer than the frame.
    pub(super) fn kept(&self) -> Drawn<'static> {
        Drawn { all: Cow::Owned(self.all.to_vec()), standing: self.standing }
    }

    /// Those that stand.
    pub(super) fn standing(&self) -> &[Instance] {
        &self.all[..self.standing]
    }

    /// What an instance is known by in every frame: a leaf by its id, wood and what covers the ground by the place where it stands.
    /// So all keep the grain of their shadows where leaves bud, fall and decay from day to day beside them.
    pub(super) fn salt(&self, number: u32) -> u64 {
        let one = &self.all[number as usize];
        match one.leaf {
            Some(leaf) => hash(leaf, 1),
            None => {
                // Not by its model, whose number depends on what else a run draws.
                let [x, y, z] = <[f32; 3]>::from(one.transform.translation).map(|place| u64::from(place.to_bits()));
                hash(x << 32 | z, y)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::vector::{Affine, Vec3};

    #[test]
    fn what_stands_and_lies_is_known_by_the_same_when_others_bud_and_decay() {
        let one = |model: u32, leaf: Option<u64>| {
            let translation = Vec3::new(model as f32, 0.0, -1.0);
            Instance { model, transform: Affine { translation, ..Affine::identity() }, leaf }
        };
        let with = |standing: &[u64], fallen: &[u64]| {
            let leaves = standing.iter().chain(fallen).map(|leaf| one(9, Some(*leaf)));
            let all: Vec<Instance> =
                [one(0, None)].into_iter().chain(leaves).chain([one(1, None), one(2, None)]).collect();
            Drawn { all: all.into(), standing: 1 + standing.len() }
        };
        let known =
            |drawn: &Drawn<'_>| -> Vec<u64> { (0..drawn.all.len() as u32).map(|number| drawn.salt(number)).collect() };
        let (many, few) = (known(&with(&[4, 5], &[7, 8, 9])), known(&with(&[5], &[7, 9])));
        // A leaf that hangs is known by the same when it lies.
        assert_eq!(known(&with(&[], &[4, 5, 7, 8, 9])), many);
        let kept: Vec<u64> = [0, 2, 3, 5, 6, 7].map(|place: usize| many[place]).into();
        assert_eq!(kept, few);
        let different: std::collections::BTreeSet<u64> = many.iter().copied().collect();
        assert_eq!(different.len(), many.len());
    }
}
