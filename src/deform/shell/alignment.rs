//! A leaf that nothing holds has no place of its own: its shape is laid onto the flat blade, centre on centre and turned to fit
//! best (Kabsch 1976).

use crate::base::vector::{DMat3, DVec2, DVec3};

/// Moves a shape rigidly onto the flat places, in the sense of least squares over the area, of which each vertex has a part.
pub fn laid_onto(places: &[DVec2], areas: &[f64], positions: &mut [DVec3]) {
    let area = areas.iter().sum::<f64>();
    let flat = |p: &DVec2| DVec3::new(p.x, p.y, 0.0);
    let centre = positions.iter().zip(areas).map(|(p, area)| p * *area).sum::<DVec3>() / area;
    let target = places.iter().zip(areas).map(|(p, area)| flat(p) * *area).sum::<DVec3>() / area;
    let mut covariance = DMat3::zeros();
    for ((p, q), area) in positions.iter().zip(places).zip(areas) {
        covariance += (flat(q) - target) * (p - centre).transpose() * *area;
    }
    let turn = rotation(&covariance);
    for p in positions {
        *p = turn * (*p - centre) + target;
    }
}

/// The rotation R for which the trace of R' times the matrix is largest; none where the matrix does not tell.
fn rotation(covariance: &DMat3) -> DMat3 {
    let svd = covariance.svd(true, true);
    let (Some(u), Some(v)) = (svd.u, svd.v_t) else { return DMat3::identity() };
    if !svd.singular_values.iter().all(|s| s.is_finite()) {
        return DMat3::identity();
    }
    // A reflection is made a rotation where it costs least, along the smallest singular value.
    let smallest = (0..3).min_by(|&i, &j| svd.singular_values[i].total_cmp(&svd.singular_values[j])).unwrap_or(2);
    let mut signs = DMat3::identity();
    signs[(smallest, smallest)] = (u * v).determinant().signum();
    u * signs * v
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::vector::rotated;

    #[test]
    fn a_moved_blade_comes_back() {
        let places: Vec<DVec2> = (0..12u32).map(|i| DVec2::new(f64::from(i % 4), f64::from(i / 4) * 1.3)).collect();
        let axis = DVec3::new(1.0, -2.0, 0.7).normalize();
        let moved = |p: &DVec2| rotated(DVec3::new(p.x, p.y, 0.0), axis, 2.1) + DVec3::new(5.0, -1.0, 3.0);
        let mut positions: Vec<DVec3> = places.iter().map(moved).collect();
        let areas: Vec<f64> = (1..=12u32).map(f64::from).collect();
        laid_onto(&places, &areas, &mut positions);
        for (p, q) in positions.iter().zip(&places) {
            assert!((p - DVec3::new(q.x, q.y, 0.0)).norm() < 1e-12);
        }
    }
}
