//! The instances that are drawn.

use crate::base::random::hash;
use crate::base::vector::Affine;
use crate::frame::{Frame, Instance};
use rayon::prelude::*;
use std::borrow::Cow;

/// Instances that one task sums up; fixed, so that the sum does not depend on the threads.
const CHUNK: usize = 1024;
/// What spreads a bit over those above it: the golden ratio's fraction in 64 bits, odd.
const ODD: u64 = 0x9E37_79B9_7F4A_7C15;

/// The instances of a frame, then those of its ground's cover.
#[derive(Clone)]
pub(super) struct Drawn<'a> {
    /// All of them; their places are their numbers. The frame's own where nothing covers its ground: a million of them are
    /// not held twice.
    pub all: Cow<'a, [Instance]>,
    /// How many stand.
    standing: usize,
    /// How many lie after them.
    fallen: usize,
}

/// What the instances of a frame come to, see [`Drawn::fingerprints`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Fingerprints {
    /// Those that stand.
    pub standing: u64,
    /// Those that lie.
    pub fallen: u64,
}

impl<'a> Drawn<'a> {
    /// Those of a frame.
    pub(super) fn of(frame: &'a Frame) -> Self {
        let cover = frame.ground.as_ref().map_or(&[][..], |ground| &ground.cover);
        let all = match cover {
            [] => Cow::Borrowed(frame.instances.as_slice()),
            _ => Cow::Owned([frame.instances.as_slice(), cover].concat()),
        };
        let standing = frame.standing().len();
        Self { all, standing, fallen: frame.instances.len() - standing }
    }

    /// The same for longer than the frame.
    pub(super) fn kept(&self) -> Drawn<'static> {
        Drawn { all: Cow::Owned(self.all.to_vec()), ..*self }
    }

    /// What stands and what lies, each in one number: where it is the same, so are models, places and leaves.
    pub(super) fn fingerprints(&self) -> Fingerprints {
        let (standing, others) = self.all.split_at(self.standing);
        Fingerprints { standing: fingerprint(standing), fallen: fingerprint(&others[..self.fallen]) }
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

/// What some instances come to in one number: another if a model, a place or a leaf among them is another.
fn fingerprint(instances: &[Instance]) -> u64 {
    let with = |sum: u64, one: &Instance| {
        let Instance { model, transform: Affine { linear, translation }, leaf } = one;
        let numbers = linear.iter().chain(translation.iter()).map(|number| u64::from(number.to_bits()));
        let start = hash(sum, u64::from(*model));
        let told = numbers.fold(start, |told, number| told.rotate_left(9).wrapping_mul(ODD) ^ number);
        hash(told, leaf.map_or(0, |leaf| hash(leaf, 1)))
    };
    let sums: Vec<u64> = instances.par_chunks(CHUNK).map(|part| part.iter().fold(0, with)).collect();
    sums.into_iter().fold(instances.len() as u64, hash)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::vector::{Affine, Vec3};

    #[test]
    fn no_two_stands_come_to_the_same_number() {
        let one = |model: u32, x: f32, leaf: Option<u64>| {
            let translation = Vec3::new(x, 2.0, 0.0);
            Instance { model, transform: Affine { translation, ..Affine::identity() }, leaf }
        };
        let all = [one(0, 1.0, None), one(1, 1.0, Some(0)), one(1, -1.0, Some(0)), one(1, 1.0, Some(1))];
        let mut numbers = std::collections::BTreeSet::new();
        for (a, b) in (0..4).flat_map(|a| (0..4).map(move |b| (a, b))) {
            let pair = [all[a], all[b]];
            assert_eq!(fingerprint(&pair), fingerprint(&pair));
            assert!(numbers.insert(fingerprint(&pair)), "{a} {b}");
        }
        let many = vec![all[1]; CHUNK + 1];
        assert!((3..=CHUNK + 1).all(|count| numbers.insert(fingerprint(&many[..count]))));
    }

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
            Drawn { all: all.into(), standing: 1 + standing.len(), fallen: fallen.len() }
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
