//! The fold of a hinge, two triangles (a, b, c) and (b, a, d) about the edge from a to b: f = 2 tan(angle / 2), with its first
//! and second derivatives in closed form. The angle is between the triangles' upper normals, positive where c and d rise
//! above the edge. To second order f is the angle; towards a closed fold it goes to infinity, so that no energy made of it
//! lets the sheet pass through itself at an edge (Grinspun, Gingold, Reisman and Zorin 2006), and it takes no trigonometry.

use crate::base::vector::{DMat3, DVec3};

/// What the derivatives of a fold are made of.
#[derive(Clone, Debug)]
pub struct Fold {
    /// 2 tan(angle / 2).
    pub value: f64,
    /// Gradient for a, b, c, d.
    pub gradient: [DVec3; 4],
    edge: DVec3,
    length: f64,
    /// c and d from a.
    arms: [DVec3; 2],
    /// Feet of c and d on the edge, 0 at a and 1 at b.
    feet: [f64; 2],
    /// Both triangles' upper area vectors (twice the area long), and their squared lengths.
    normals: [DVec3; 2],
    squares: [f64; 2],
    /// Gradients of the angle for c and d.
    lifts: [DVec3; 2],
    /// First derivative of the value by the angle.
    slope: f64,
}

impl Fold {
    /// The value alone. Not finite for a triangle without area.
    pub fn value([a, b, c, d]: [DVec3; 4]) -> f64 {
        let edge = b - a;
        let (n, m) = (edge.cross(&(c - a)), (d - a).cross(&edge));
        half_tangent(&edge, edge.norm(), &n, &m, (n.norm_squared() * m.norm_squared()).sqrt())
    }

    /// Value and gradient.
    pub fn new([a, b, c, d]: [DVec3; 4]) -> Self {
        let edge = b - a;
        let arms = [c - a, d - a];
        let squared = edge.norm_squared();
        let length = squared.sqrt();
        let normals = [edge.cross(&arms[0]), arms[1].cross(&edge)];
        let squares = normals.map(|n| n.norm_squared());
        let value = half_tangent(&edge, length, &normals[0], &normals[1], (squares[0] * squares[1]).sqrt());
        let feet = arms.map(|arm| arm.dot(&edge) / squared);
        let lifts = [0, 1].map(|i| normals[i] * (length / squares[i]));
        let slope = 1.0 + 0.25 * value * value;
        let far = lifts[0] * feet[0] + lifts[1] * feet[1];
        let gradient = [far - lifts[0] - lifts[1], -far, lifts[0], lifts[1]].map(|g| g * slope);
        Self { value, gradient, edge, length, arms, feet, normals, squares, lifts, slope }
    }

    /// Second derivatives by (row, column): (b,b), (b,c), (b,d), (c,c), (d,d) of the angle; those with a follow since moving
    /// all four points changes nothing, and (c,d) is nought.
    fn angle_hessian(&self) -> [DMat3; 5] {
        let squared = self.length * self.length;
        let along = self.edge / self.length;
        let turn = self.edge.cross_matrix();
        let mut by_b = [DMat3::zeros(); 2];
        let mut own = [DMat3::zeros(); 2];
        let mut both = DMat3::zeros();
        for i in 0..2 {
            let normal = self.normals[i];
            let spread = DMat3::identity() - normal * normal.transpose() * (2.0 / self.squares[i]);
            let spread = spread * (self.length / self.squares[i]);
            // The area vectors are edge x arm and arm x edge: opposite signs.
            let sign = if i == 0 { 1.0 } else { -1.0 };
            own[i] = spread * turn * sign;
            let arm_turn = self.arms[i].cross_matrix() * -sign;
            by_b[i] = spread * arm_turn + normal * along.transpose() / self.squares[i];
            let foot = (self.arms[i] - self.edge * (2.0 * self.feet[i])) / squared;
            both -= by_b[i] * self.feet[i] + self.lifts[i] * foot.transpose();
        }
        [both, by_b[0].transpose(), by_b[1].transpose(), own[0], own[1]]
    }

    /// Second derivatives of the value: blocks by rows and columns a, b, c, d; those above the diagonal are left out (the
    /// matrix is symmetric).
    pub fn hessian(&self) -> [[DMat3; 4]; 4] {
        let [bb, bc, bd, cc, dd] = self.angle_hessian();
        let (cb, db) = (bc.transpose(), bd.transpose());
        let (ba, ca, da) = (-(bb + bc + bd), -(cb + cc), -(db + dd));
        let aa = -(ba + ca + da);
        let zero = DMat3::zeros();
        let mut blocks = [[aa, zero, zero, zero], [ba, bb, zero, zero], [ca, cb, cc, zero], [da, db, zero, dd]];
        // The gradient holds one factor of the slope already: f'' / f'^2 = (f f' / 2) / f'^2.
        let bend = 0.5 * self.value / self.slope;
        for i in 0..4 {
            for j in 0..=i {
                blocks[i][j] = blocks[i][j] * self.slope + self.gradient[i] * self.gradient[j].transpose() * bend;
            }
        }
        blocks
    }
}

/// 2 tan(angle / 2) = 2 sin / (1 + cos), with the sign of a rise; `size` is the product of both area vectors' lengths.
fn half_tangent(edge: &DVec3, length: f64, n: &DVec3, m: &DVec3, size: f64) -> f64 {
    let sine = m.cross(n).dot(edge) / length;
    2.0 * sine / (size + n.dot(m))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::maths::{sincos, tan};
    use crate::base::random::{Purpose, Stream};

    fn hinge(angle: f64) -> [DVec3; 4] {
        let (sine, cosine) = sincos(angle);
        [DVec3::zeros(), DVec3::x(), DVec3::new(0.3, cosine, sine), DVec3::new(0.8, -0.7, 0.0)]
    }

    fn crooked(number: u64) -> [DVec3; 4] {
        let mut stream = Stream::new(9, Purpose::Deformation, number, 0);
        hinge(0.4 * number as f64 - 1.0).map(|p| p + DVec3::from_fn(|_, _| stream.range(-0.2, 0.2)))
    }

    #[test]
    fn the_value_is_that_of_the_angle_and_rises_count_up() {
        for angle in [-2.0, -0.5, 0.0, 0.5, 3.0] {
            assert!((Fold::value(hinge(angle)) - 2.0 * tan(angle / 2.0)).abs() < 1e-12, "{angle}");
        }
    }

    #[test]
    fn it_does_not_matter_from_which_triangle_it_is_seen() {
        let [a, b, c, d] = crooked(3);
        assert!((Fold::value([a, b, c, d]) - Fold::value([b, a, d, c])).abs() < 1e-14);
    }

    #[test]
    fn gradient_and_hessian_are_the_differences_of_value_and_gradient() {
        let width = 1e-5;
        for number in 0..6 {
            let points = crooked(number);
            let fold = Fold::new(points);
            let hessian = fold.hessian();
            for (j, axis) in (0..12).map(|k| (k / 3, k % 3)) {
                let moved = |by: f64| {
                    let mut moved = points;
                    moved[j][axis] += by;
                    moved
                };
                let slope = (Fold::value(moved(width)) - Fold::value(moved(-width))) / (2.0 * width);
                assert!((slope - fold.gradient[j][axis]).abs() < 1e-7 * (1.0 + slope.abs()));
                let (above, below) = (Fold::new(moved(width)).gradient, Fold::new(moved(-width)).gradient);
                for i in j..4 {
                    let bend = (above[i] - below[i]) / (2.0 * width);
                    let column = hessian[i][j].column(axis);
                    assert!((bend - column).norm() < 1e-6 * (1.0 + bend.norm()), "{number} {i} {j} {axis}");
                }
            }
        }
    }
}
