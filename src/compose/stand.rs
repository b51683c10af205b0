//! The trees of a scene: each form grown once, and every tree a form at a place.

use crate::base::vector::{Affine, DVec3, Mat3, rotated};
use crate::fall::HeightMap;
use crate::scene::Standing;
use crate::tree::{LeafSite, Tree, Wood};
use std::sync::Arc;

/// Most leaves of a run.
const RUN: usize = 2048;

/// A grown tree that may stand in several places.
#[derive(Clone, Debug)]
pub struct Form {
    /// Number of its species in the scene.
    pub species: usize,
    /// The wood by girth.
    pub wood: Vec<Wood>,
    /// The leaves.
    pub sites: Vec<LeafSite>,
    /// Highest point, metres.
    pub height: f64,
    /// Largest distance from the trunk's foot, seen from above, metres.
    pub crown_radius: f64,
}

impl Form {
    /// Vertices of the wood.
    #[must_use]
    pub fn wood_vertices(&self) -> usize {
        self.wood.iter().map(|wood| wood.mesh.positions.len()).sum()
    }

    /// Keeps of a tree what is drawn.
    #[must_use]
    pub fn new(species: usize, tree: Tree) -> Self {
        let Tree { wood, sites, height, crown_radius, .. } = tree;
        Self { species, wood, sites, height, crown_radius }
    }
}

/// All trees.
#[derive(Clone, Debug, Default)]
pub struct Stand {
    /// The forms.
    pub forms: Vec<Form>,
    /// The number of each tree's form, and where the tree stands.
    pub trees: Vec<(usize, Standing)>,
    /// The ids of all leaves, tree by tree in the order of the sites.
    pub leaf_ids: Vec<u64>,
    /// The heights of the ground on which they stand; level without any.
    pub heights: Option<Arc<HeightMap>>,
}

impl Stand {
    /// Gathers trees. The leaves of the first keep the ids of their sites; those of others are told apart by the tree's key.
    #[must_use]
    pub fn new(forms: Vec<Form>, trees: Vec<(usize, Standing)>) -> Self {
        let mut leaf_ids = Vec::new();
        for (form, standing) in &trees {
            leaf_ids.extend(forms[*form].sites.iter().map(|site| standing.own(site.id)));
        }
        Self { forms, trees, leaf_ids, heights: None }
    }

    /// The same trees standing on ground of these heights.
    #[must_use]
    pub fn on(mut self, heights: Option<Arc<HeightMap>>) -> Self {
        if let Some(map) = &heights {
            self.trees.iter_mut().for_each(|(_, tree)| tree.height = map.at(tree.place.into()));
        }
        Self { heights, ..self }
    }

    /// Height of the ground at a place (x, z), metres.
    pub(super) fn ground_height(&self, place: [f64; 2]) -> f64 {
        self.heights.as_ref().map_or(0.0, |map| map.at(place.into()))
    }

    /// The trees in their order: the form, and where it stands.
    pub fn standing(&self) -> impl Iterator<Item = (&Form, &Standing)> {
        self.trees.iter().map(|(form, standing)| (&self.forms[*form], standing))
    }

    /// The number of the species of each leaf, in the order of the ids.
    pub fn species_of_leaves(&self) -> impl Iterator<Item = usize> {
        self.standing().flat_map(|(form, _)| std::iter::repeat_n(form.species, form.sites.len()))
    }

    /// All leaves in their order, in runs that may be handled side by side.
    #[must_use]
    pub fn leaf_runs(&self) -> Vec<LeafRun<'_>> {
        let mut runs = Vec::new();
        let mut first = 0;
        for (form, standing) in self.standing() {
            for sites in form.sites.chunks(RUN) {
                runs.push(LeafRun { form, standing, sites, places: first..first + sites.len() });
                first += sites.len();
            }
        }
        runs
    }

    /// Trees of a species.
    #[must_use]
    pub fn trees_of(&self, species: usize) -> usize {
        self.standing().filter(|(form, _)| form.species == species).count()
    }

    /// Height of the highest tree, metres.
    #[must_use]
    pub fn height(&self) -> f64 {
        self.standing().map(|(form, _)| form.height).fold(0.0, f64::max)
    }
}

/// Some leaves of a tree that one task handles.
pub struct LeafRun<'a> {
    /// The tree's form.
    pub form: &'a Form,
    /// Where it stands.
    pub standing: &'a Standing,
    /// The leaves' sites.
    pub sites: &'a [LeafSite],
    /// Places of the leaves among all of the stand, in the order of the ids.
    pub places: std::ops::Range<usize>,
}

/// From a tree's own coordinates to the world's: a turn about the vertical, then a step over the ground.
#[derive(Clone, Copy)]
pub(super) struct Pose {
    /// The turn, radians; none keeps every bit.
    turn: Option<f64>,
    place: Option<DVec3>,
}

impl Pose {
    pub(super) fn of(standing: &Standing) -> Self {
        let [x, z] = standing.place;
        Self {
            turn: (standing.turn != 0.0).then(|| standing.turn.to_radians()),
            place: (standing.place != [0.0; 2] || standing.height != 0.0).then(|| DVec3::new(x, standing.height, z)),
        }
    }

    pub(super) fn direction(self, direction: DVec3) -> DVec3 {
        self.turn.map_or(direction, |angle| rotated(direction, DVec3::y(), angle))
    }

    pub(super) fn point(self, point: DVec3) -> DVec3 {
        let turned = self.direction(point);
        self.place.map_or(turned, |place| turned + place)
    }

    pub(super) fn affine(self) -> Affine {
        let axes = [DVec3::x(), DVec3::y(), DVec3::z()].map(|axis| self.direction(axis).cast::<f32>());
        let translation = self.place.unwrap_or_else(DVec3::zeros).cast::<f32>();
        Affine { linear: Mat3::from_columns(&axes), translation }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn form(leaves: u64) -> Form {
        let site = |id| LeafSite {
            id,
            base: DVec3::new(1.0, 2.0, -0.0),
            petiole: DVec3::x(),
            blade: DVec3::x(),
            normal: DVec3::y(),
            scale: 1.0,
            order: 0,
            petiole_length: 1.0,
            segment: None,
            limb: 0,
            shoot: 0,
        };
        Form::new(0, Tree { sites: (0..leaves).map(site).collect(), ..Tree::default() })
    }

    fn standing(key: u64, place: [f64; 2], turn: f64) -> Standing {
        Standing { entry: 0, seed: 1, key, place, height: 0.0, turn }
    }

    #[test]
    fn trees_of_one_form_have_leaves_of_their_own_and_the_first_keeps_its_ids() {
        let trees = (0..100).map(|key| (0, standing(key, [0.0; 2], 0.0))).collect();
        let stand = Stand::new(vec![form(1000)], trees);
        assert_eq!(stand.leaf_ids[..1000], (0..1000).collect::<Vec<u64>>());
        assert_eq!(stand.leaf_ids.iter().collect::<BTreeSet<_>>().len(), 100_000);
        assert_eq!((stand.species_of_leaves().count(), stand.trees_of(0), stand.trees_of(1)), (100_000, 100, 0));
    }

    #[test]
    fn a_quarter_turn_brings_x_to_the_far_side_and_the_affine_map_agrees() {
        let pose = Pose::of(&standing(0, [3.0, 5.0], 90.0));
        assert!((pose.point(DVec3::x()) - DVec3::new(3.0, 0.0, 4.0)).norm() < 1e-12);
        let point = DVec3::new(0.3, 0.7, -1.1);
        let mapped = pose.affine().point(point.cast::<f32>()).cast::<f64>();
        assert!((mapped - pose.point(point)).norm() < 1e-6);
    }

    #[test]
    fn a_tree_at_the_origin_keeps_every_bit() {
        let pose = Pose::of(&standing(0, [0.0; 2], 0.0));
        let point = form(1).sites[0].base;
        assert!(pose.point(point).z.is_sign_negative());
        assert_eq!(pose.affine(), Affine::identity());
    }
}
