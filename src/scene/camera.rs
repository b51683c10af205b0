//! Where the picture is taken from.

use crate::base::settings::Complaint;
use crate::{choice, settings};

choice! {
    /// What the camera looks at.
    pub enum Subject {
        /// The trees.
        Trees = "trees",
        /// A leaf by itself before a plain ground, the one that most leaves look like: upright, its upper side to the
        /// camera. Places are relative to its joint.
        Leaf = "leaf",
    }
}

settings! {
    /// The camera. Without a position it stands where the whole tree is seen, its eye 1.6 m above the ground.
    pub struct Camera {
        /// What is in the picture: "trees", or "leaf" for the one that most leaves look like, upright before a plain ground.
        subject: Subject = Subject::Trees;
        /// Where the eye stands: x to the right, y up, z towards the default camera; the tree's foot is the origin. Fitted to the
        /// tree when absent.
        position: Option<[f64; 3]> = None, unit "m", range -1e5 => 1e5;
        /// What the camera looks at; the middle of the tree when absent.
        target: Option<[f64; 3]> = None, unit "m", range -1e5 => 1e5;
        /// Angle of view from the lower to the upper edge.
        field_of_view: f64 = 20.0, unit "°", range 1.0 => 150.0;
        /// Focal length of a full-frame lens (its picture is 36 mm wide) instead of an angle of view; 50 to 85 suits a tree.
        focal_length: Option<f64> = None, unit "mm", range 4.0 => 2000.0;
        /// Height of a fitted camera's eye above the ground: a standing person's.
        eye_height: f64 = 1.6, unit "m", range 0.01 => 1000.0;
        /// Share of the picture that the trees fill before a fitted camera.
        fill: f64 = 0.84, range 0.05 => 1.0;
        /// Turn of the camera around its target; 90 shows the tree from the right. The sun stays with the unturned camera.
        orbit: f64 = 0.0, unit "°", range -3600.0 => 3600.0;
        /// Further turn over the frames of the scene, the last being one step short of it: 360 is a turntable.
        turn: f64 = 0.0, unit "°", range -36000.0 => 36000.0;
        /// Nearest distance that is drawn.
        near: f64 = 0.05, unit "m", range 1e-4 => 1e4;
        /// Farthest distance that is drawn; beyond `near`.
        far: f64 = 2000.0, unit "m", range 1e-3 => 1e6;
    }
}

/// What is wrong with well-typed settings.
#[must_use]
pub fn check(camera: &Camera) -> Vec<Complaint> {
    let mut complaints = Vec::new();
    if camera.far <= camera.near {
        let what = format!("the camera's `far` ({} m) is not beyond its `near` ({} m)", camera.far, camera.near);
        complaints.push(Complaint::new("far", what, "let `far` be larger than `near`"));
    }
    if camera.position.is_some() && camera.position == camera.target {
        let help = "move one of them, or leave `target` out to look at the tree";
        complaints.push(Complaint::new("position", "the camera stands on its target", help));
    }
    complaints
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_faults_are_found_at_once() {
        let here = Some([1.0, 1.0, 1.0]);
        let camera = Camera { position: here, target: here, near: 10.0, far: 10.0, ..Camera::default() };
        let keys: Vec<String> = check(&camera).into_iter().map(|complaint| complaint.key).collect();
        assert_eq!(keys, ["far", "position"]);
        assert!(check(&Camera::default()).is_empty());
    }
}
