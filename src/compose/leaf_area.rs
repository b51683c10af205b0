//! Leaf area: what neither the tree stage, which knows no blade, nor the leaf stage, which knows no tree, can say.

use crate::base::flat_mesh::FlatMesh;
use crate::tree::LeafSite;

/// One-sided area of the blades at these sites in full leaf, square metres.
#[must_use]
pub fn blade_area(sites: &[LeafSite], blade: &FlatMesh) -> f64 {
    sites.iter().map(|site| site.scale * site.scale).sum::<f64>() * blade.area()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::vector::{DVec2, DVec3};

    fn site(scale: f64) -> LeafSite {
        let (base, petiole, blade, normal) = (DVec3::zeros(), DVec3::x(), DVec3::x(), DVec3::y());
        LeafSite {
            id: 0,
            base,
            petiole,
            blade,
            normal,
            scale,
            order: 0,
            petiole_length: 1.0,
            segment: None,
            limb: 0,
            shoot: 0,
        }
    }

    /// Two by three centimetres.
    fn blade() -> FlatMesh {
        let corners = [(0.0, 0.0), (0.02, 0.0), (0.02, 0.03), (0.0, 0.03)];
        FlatMesh {
            positions: corners.iter().map(|&(x, y)| DVec2::new(x, y)).collect(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..FlatMesh::default()
        }
    }

    #[test]
    fn blades_grow_with_the_square_of_their_scale() {
        assert!((blade_area(&[site(1.0), site(2.0)], &blade()) - 5.0 * 6e-4).abs() < 1e-12);
        assert_eq!(blade_area(&[], &blade()), 0.0);
    }
}
