//! What a triangle costs: nought if it is equilateral and has the wanted area, without bound as its area goes to nought.
//!
//! With S the sum of its squared sides, D its doubled area and D0 the wanted one, the shape's cost is the inverse mean ratio
//! S / (2 sqrt(3) D) (Liu and Joe 1994; 1 for the equilateral triangle) and the size's D/D0 + D0/D. To second order in
//! the strain their sum is what springs along the sides cost, so that low cost is even edges. Each summand is convex in
//! one corner while D > 0 (a quadratic over a linear function), so Newton's step for a corner is always downhill.

use crate::base::vector::DVec2;
use crate::leaf::remesh::sizing::Sizing;

/// The shape cost is S / D over this.
const EVEN: f64 = 3.464_101_615_137_754_6;
/// How much the size counts against the shape.
const SIZE: f64 = 0.6;
/// A triangle of this share of the wanted area counts as inverted.
const FLAT: f64 = 1e-9;
/// How much the square of the cost counts: the worst triangles count for more than their share.
const WORST: f64 = 7.0;
/// Shape costs beyond this, that of a right triangle with an angle of 38.5 degrees, cost extra by the square of the excess.
const POINTED: f64 = 1.185;
const THIN: f64 = 300.0;
/// By this factor they cost more where a mesh has settled with triangles that are too thin.
const STIFFER: f64 = 4.0;

/// The cost of triangles with a wanted area.
#[derive(Clone, Copy, Debug)]
pub struct Energy {
    /// Twice the wanted area where the sizing is 1.
    doubled_area: f64,
    sizing: Sizing,
    /// How much thin triangles cost extra.
    thin: f64,
}

/// How a cost changes with one corner.
#[derive(Clone, Copy, Debug, Default)]
pub struct Slope {
    /// The cost.
    pub value: f64,
    /// First derivatives.
    pub gradient: DVec2,
    /// Second derivatives xx, xy, yy.
    pub bend: [f64; 3],
}

/// The inverse mean ratio of a triangle; infinite unless it is counter-clockwise.
pub fn shape_cost(p: DVec2, a: DVec2, b: DVec2) -> f64 {
    let (pa, pb, ab) = (a - p, b - p, b - a);
    let doubled = pa.perp(&pb);
    let sides = pa.norm_squared() + pb.norm_squared() + ab.norm_squared();
    if doubled > 0.0 { sides / (EVEN * doubled) } else { f64::INFINITY }
}

impl Energy {
    /// The cost whose even triangle has sides of this length.
    pub fn of_spacing(spacing: f64, sizing: Sizing) -> Self {
        let doubled_area = spacing * spacing * 0.75f64.sqrt();
        Self { doubled_area, sizing, thin: THIN }
    }

    /// Twice the wanted area of a triangle.
    fn wanted(&self, p: DVec2, a: DVec2, b: DVec2) -> f64 {
        let share = self.sizing.at((p + a + b) / 3.0);
        self.doubled_area * share * share
    }

    /// Makes thin triangles cost more.
    pub fn stiffen(&mut self) {
        self.thin *= STIFFER;
    }

    /// Whether a triangle costs extra for being thin.
    pub fn is_thin(&self, p: DVec2, a: DVec2, b: DVec2) -> bool {
        shape_cost(p, a, b) > POINTED
    }

    /// The cost; infinite unless the triangle is counter-clockwise.
    pub fn of(&self, p: DVec2, a: DVec2, b: DVec2) -> f64 {
        let (pa, pb, ab) = (a - p, b - p, b - a);
        let doubled = pa.perp(&pb);
        let wanted = self.wanted(p, a, b);
        let ratio = doubled / wanted;
        if ratio <= FLAT {
            return f64::INFINITY;
        }
        let over = 1.0 / doubled;
        let shape = (pa.norm_squared() + pb.norm_squared() + ab.norm_squared()) * (over / EVEN);
        let plain = shape - 1.0 + SIZE * (ratio + wanted * over - 2.0);
        let thin = (shape - POINTED).max(0.0);
        plain + WORST * plain * plain + self.thin * thin * thin
    }

    /// Adds the cost and how it changes with the corner `p`; the triangle must be counter-clockwise.
    pub fn add_slope(&self, p: DVec2, a: DVec2, b: DVec2, slope: &mut Slope) {
        let (pa, pb, ab) = (a - p, b - p, b - a);
        let doubled = pa.perp(&pb);
        let over = 1.0 / doubled;
        let by_side = over / EVEN;
        let shape = (pa.norm_squared() + pb.norm_squared() + ab.norm_squared()) * by_side;
        let wanted = self.wanted(p, a, b);
        let inverse = wanted * over;
        let plain = shape - 1.0 + SIZE * (doubled / wanted + inverse - 2.0);
        // How the doubled area and the sum of the squared sides change; the fall of what is divided by the area.
        let area = DVec2::new(-ab.y, ab.x);
        let sides = (pa + pb) * (-2.0 * by_side);
        let crossed = [2.0 * sides.x * area.x, sides.x * area.y + area.x * sides.y, 2.0 * sides.y * area.y];
        let bend = |fall: f64| {
            let twice = 2.0 * fall * over;
            let own = [area.x * area.x, area.x * area.y, area.y * area.y];
            [0, 1, 2].map(|k| twice * own[k] - over * crossed[k] + if k == 1 { 0.0 } else { 4.0 * by_side })
        };
        let fall = (shape + SIZE * inverse) * over;
        let gradient = sides + area * (SIZE / wanted - fall);
        let bent = bend(fall);
        slope.add_square(plain, WORST, gradient, bent);
        slope.value += plain;
        slope.gradient += gradient;
        (0..3).for_each(|k| slope.bend[k] += bent[k]);
        let thin = shape - POINTED;
        if thin > 0.0 {
            slope.add_square(thin, self.thin, sides - area * (shape * over), bend(shape * over));
        }
    }
}

impl Slope {
    /// Adds the square of something, by a weight, given how that changes.
    fn add_square(&mut self, value: f64, weight: f64, gradient: DVec2, bend: [f64; 3]) {
        let (steep, curved) = (2.0 * weight * value, 2.0 * weight);
        self.value += weight * value * value;
        self.gradient += gradient * steep;
        let square = [gradient.x * gradient.x, gradient.x * gradient.y, gradient.y * gradient.y];
        (0..3).for_each(|k| self.bend[k] += steep * bend[k] + curved * square[k]);
    }

    /// Newton's step; nought where the second derivatives are not those of a valley.
    pub fn step(&self) -> DVec2 {
        let [xx, xy, yy] = self.bend;
        let determinant = xx * yy - xy * xy;
        if determinant.is_nan() || determinant <= 0.0 || xx <= 0.0 {
            return DVec2::zeros();
        }
        let g = self.gradient;
        DVec2::new(xy * g.y - yy * g.x, xy * g.x - xx * g.y) / determinant
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: DVec2 = DVec2::new(0.1, -0.2);
    const B: DVec2 = DVec2::new(1.2, 0.1);
    const P: DVec2 = DVec2::new(0.3, 0.9);

    #[test]
    fn the_even_triangle_costs_nothing_and_the_inverted_everything() {
        let energy = Energy::of_spacing(1.0, Sizing::EVEN);
        let (a, b, c) = (DVec2::zeros(), DVec2::x(), DVec2::new(0.5, 0.75f64.sqrt()));
        assert!(energy.of(c, a, b).abs() < 1e-14);
        assert_eq!(energy.of(c, b, a), f64::INFINITY);
        assert!(energy.of(c * 1.2, a * 1.2, b * 1.2) > 0.1);
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let energy = Energy::of_spacing(0.9, Sizing::EVEN);
        let slope_at = |p: DVec2| {
            let mut slope = Slope::default();
            energy.add_slope(p, A, B, &mut slope);
            slope
        };
        let step = 1e-5;
        for (i, e) in [DVec2::x(), DVec2::y()].into_iter().enumerate() {
            let rise = (energy.of(P + e * step, A, B) - energy.of(P - e * step, A, B)) / (2.0 * step);
            assert!((rise - slope_at(P).gradient[i]).abs() < 1e-7);
            assert!((slope_at(P).value - energy.of(P, A, B)).abs() < 1e-12);
            let bend = (slope_at(P + e * step).gradient - slope_at(P - e * step).gradient) / (2.0 * step);
            assert!((bend.x - slope_at(P).bend[i]).abs() < 1e-6 && (bend.y - slope_at(P).bend[i + 1]).abs() < 1e-6);
        }
    }
}
