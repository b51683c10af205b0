//! The tree as lines: segments of wood with parent links, and the shoots' leaves before they have a direction.

use crate::base::vector::DVec3;

/// A straight piece of wood between two turtle moves. Parents stand before their children.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// The stable identity of the module that drew it.
    pub id: u64,
    /// Number of the segment it grows on; `None` at a root.
    pub parent: Option<u32>,
    /// Number of the axis it belongs to: a chain of segments drawn without a bracket between.
    pub axis: u32,
    /// Order of that axis: 0 for the trunk.
    pub order: u32,
    /// Where it starts, metres.
    pub start: DVec3,
    /// Where it ends, metres.
    pub end: DVec3,
    /// Derivation step in which it grew.
    pub birth: u32,
    /// Radius at its start, metres.
    pub radius: f64,
}

impl Segment {
    /// Its length, metres.
    #[must_use]
    pub fn length(&self) -> f64 {
        (self.end - self.start).norm()
    }

    /// The unit vector along it.
    #[must_use]
    pub fn direction(&self) -> DVec3 {
        (self.end - self.start).try_normalize(1e-300).unwrap_or_else(DVec3::y)
    }
}

/// A leaf as the turtle passes it: a place at the end of a segment and the turtle's frame.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Shoot {
    pub id: u64,
    /// The segment it sits on the end of, if any wood was drawn before.
    pub segment: Option<u32>,
    pub position: DVec3,
    pub heading: DVec3,
    pub up: DVec3,
    pub scale: f64,
    pub order: u32,
}

/// All segments of a tree.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skeleton {
    /// The segments, parents before children.
    pub segments: Vec<Segment>,
}

impl Skeleton {
    /// The numbers of the children of each segment, in order.
    #[must_use]
    pub fn children(&self) -> Vec<Vec<u32>> {
        let mut children = vec![Vec::new(); self.segments.len()];
        for (number, segment) in self.segments.iter().enumerate() {
            if let Some(parent) = segment.parent {
                children[parent as usize].push(number as u32);
            }
        }
        children
    }

    /// The highest order of any axis.
    #[must_use]
    pub fn max_order(&self) -> u32 {
        self.segments.iter().map(|segment| segment.order).max().unwrap_or(0)
    }
}
