//! What a tile reads of what changes from frame to frame, noted while it is drawn: where all of that is the same in a later
//! frame, so are its pixels.

/// What was read. What is not told here is either the same in all frames of one scenery or told by the tile's items.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Reads {
    /// The wood on the horizon as it looks in its season.
    pub wood: bool,
    /// How far the grass has gone into its winter rest.
    pub rest: bool,
    /// The light from all sides at places that no crown reaches.
    pub open: bool,
    /// The light from all sides within reach of the crowns' leaves.
    pub crowns: bool,
    /// The sun's shadows.
    pub sun: bool,
    /// Shadows whose taps are turned by what an instance is known by.
    pub salt: bool,
    /// The least nearness to the sun that was compared with each tile of the shadow map; what lies below it there does not matter.
    shadow: Vec<f32>,
}

impl Reads {
    /// Notes that a tile of the shadow map was looked up for a point of a nearness to the sun.
    #[inline(always)]
    pub(super) fn note_shadow(&mut self, tile: usize, nearness: f32) {
        if tile >= self.shadow.len() {
            self.shadow.reserve_exact(tile + 1 - self.shadow.len());
            self.shadow.resize(tile + 1, f32::INFINITY);
        }
        let least = &mut self.shadow[tile];
        *least = if nearness < *least { nearness } else { *least };
    }

    /// Whether shadows may not be what they were, where `changed` is the largest nearness before or now of what has changed in
    /// each tile of the shadow map.
    pub(super) fn has_shadow_of(&self, changed: &[f32]) -> bool {
        self.shadow.iter().zip(changed).any(|(read, changed)| changed > read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_changes_beyond_all_points_of_a_tile_gives_no_other_shadow() {
        let mut reads = Reads::default();
        reads.note_shadow(3, -4.0);
        reads.note_shadow(3, -5.0);
        let changed = |tile: usize, nearness: f32| {
            let mut changed = [f32::MIN; 6];
            changed[tile] = nearness;
            reads.has_shadow_of(&changed)
        };
        assert!(changed(3, -4.5) && !changed(3, -5.0) && !changed(3, -7.0));
        assert!(!changed(2, 9.0) && !changed(5, 9.0));
        assert!(!Reads::default().has_shadow_of(&[9.0; 6]));
    }
}
