//! The flat blade as a sheet: springs along its edges, hinges between its triangles, and for each triangle the bending energy
//! as a quadratic form of its hinges' folds. Lengths are in extents of the blade, energies in units of the bending stiffness.
//!
//! Springs: k = 3 Y A / l^2 with A a third of the adjoining area, which on equilateral triangles is the sheet of stretch
//! stiffness Y and Poisson ratio 1/3.
//!
//! Bending: the curvature tensor of a triangle is S = sum f_i l_i n_i n_i' / (2 A) over its edges (n_i normal to the edge in
//! the plane), exact for constant curvature on equilateral triangles; rest folds are those of the smooth surface. Its energy is A D / 2 ((1 - nu) tr (S-K)^2 +
//! nu (tr (S-K))^2), plus A D rho / 2 (t'(S-K) t)^2 for a vein along t. So E = r' M r / 2 with r = f - f0 and a constant M.
//! A plain sum over hinges would have the Poisson ratio -1/3 whatever it was given. A triangle at the rim lacks a fold; it
//! takes the one of least energy, which says that no moment acts across a free rim.

use super::overlap::piercings;
use super::settings::Settings;
use crate::base::flat_mesh::FlatMesh;
use crate::base::maths::cbrt;
use crate::base::vector::{DMat3, DVec2, DVec3};

/// A symmetric tensor of the plane: xx, xy, yy.
pub type Tensor = [f64; 3];

/// The absent hinge of a rim edge.
pub const RIM: u32 = u32::MAX;

/// A stretch spring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// Its vertices.
    pub ends: [u32; 2],
    /// Length in the flat blade.
    pub length: f64,
    /// Force for each unit of length.
    pub stiffness: f64,
}

/// A triangle that bends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plate {
    /// Its vertices.
    pub corners: [u32; 3],
    /// The hinge at the edge from corner i to i + 1, or [`RIM`].
    pub hinges: [u32; 3],
    /// Whether the hinge sees this triangle as its second.
    pub second: [bool; 3],
    /// The vertex across each edge (0 where there is none).
    pub across: [u32; 3],
    /// The quadratic form of the folds; rows and columns of absent hinges are nought.
    pub form: DMat3,
    /// The fold of each hinge for each component of a curvature (see [`Plate::folds`]).
    folds: [Tensor; 3],
    /// Its edges in the flat blade.
    edges: [DVec2; 3],
    doubled_area: f64,
}

/// The sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheet {
    /// Places of the vertices in the flat blade.
    pub places: Vec<DVec2>,
    /// Area of each vertex, a third of its triangles'.
    pub areas: Vec<f64>,
    /// Springs.
    pub springs: Vec<Spring>,
    /// Vertices a, b, c, d of each hinge: the edge, and the corners of the triangles left and right of it.
    pub hinges: Vec<[u32; 4]>,
    /// Triangles.
    pub plates: Vec<Plate>,
    /// Whether the petiole holds each vertex.
    pub held: Vec<bool>,
}

/// How a vein stiffens a triangle: the share of the vein's stiffness, and the tensor of its direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rib {
    /// Additional bending stiffness along the vein, in units of the blade's.
    pub stiffness: f64,
    /// t t' of the unit direction t (less than unit where the direction is not clear).
    pub along: Tensor,
    /// Additional bending stiffness every way, in units of the blade's.
    pub thickening: f64,
}

impl Sheet {
    /// The sheet of a mesh, all of whose triangles have an area, with coordinates divided by `extent`. `ribs` has one entry for
    /// each triangle.
    pub fn new(settings: &Settings, mesh: &FlatMesh, extent: f64, ribs: &[Rib]) -> Self {
        let places: Vec<DVec2> = mesh.positions.iter().map(|p| p / extent).collect();
        let sides = Sides::of(mesh);
        let mut areas = vec![0.0; places.len()];
        let mut around = vec![0.0; sides.springs.len()];
        let mut plates = Vec::with_capacity(mesh.triangles.len());
        for (number, &corners) in mesh.triangles.iter().enumerate() {
            let plate = Plate::new(number, corners, &places, &sides);
            let third = plate.doubled_area / 6.0;
            corners.iter().for_each(|&v| areas[v as usize] += third);
            // Bending goes with the third power of the thickness, stretching with the first.
            let thicker = cbrt(1.0 + ribs[number].thickening);
            sides.edges[number].iter().for_each(|&edge| around[edge as usize] += third * thicker);
            plates.push(plate.stiffened(settings.poisson_ratio, &ribs[number]));
        }
        // Y / D of a plate of this thickness.
        let stretch =
            12.0 * (1.0 - settings.poisson_ratio * settings.poisson_ratio) / (settings.thickness * settings.thickness);
        let spring = |(&ends, area): (&[u32; 2], &f64)| {
            let length = (places[ends[1] as usize] - places[ends[0] as usize]).norm();
            Spring { ends, length, stiffness: 3.0 * stretch * area / (length * length) }
        };
        let springs = sides.springs.iter().zip(&around).map(spring).collect();
        let mut held = vec![false; places.len()];
        mesh.held.iter().for_each(|&v| held[v as usize] = true);
        Self { places, areas, springs, hinges: sides.hinges, plates, held }
    }

    /// How many of its edges pass through its triangles.
    pub fn piercings(&self, positions: &[DVec3]) -> u64 {
        let triangles: Vec<[u32; 3]> = self.plates.iter().map(|plate| plate.corners).collect();
        let edges: Vec<[u32; 2]> = self.springs.iter().map(|spring| spring.ends).collect();
        piercings(positions, &triangles, &edges)
    }

    /// The folds at which a triangle has a curvature.
    pub fn folds(&self, plate: usize, curvature: Tensor) -> [f64; 3] {
        self.plates[plate].folds(curvature)
    }
}

/// Which triangles meet at which edges.
struct Sides {
    /// Ends of each edge.
    springs: Vec<[u32; 2]>,
    hinges: Vec<[u32; 4]>,
    /// For each triangle and edge: number of the edge.
    edges: Vec<[u32; 3]>,
    /// For each triangle and edge: hinge, whether seen as second, vertex across.
    meetings: Vec<[(u32, bool, u32); 3]>,
}

impl Sides {
    fn of(mesh: &FlatMesh) -> Self {
        let count = mesh.triangles.len();
        let mut half_edges: Vec<([u32; 2], usize, usize)> = Vec::with_capacity(3 * count);
        for (number, corners) in mesh.triangles.iter().enumerate() {
            for i in 0..3 {
                let (a, b) = (corners[i], corners[(i + 1) % 3]);
                half_edges.push(([a.min(b), a.max(b)], number, i));
            }
        }
        half_edges.sort_unstable();
        let mut sides = Self {
            springs: Vec::new(),
            hinges: Vec::new(),
            edges: vec![[0; 3]; count],
            meetings: vec![[(RIM, false, 0); 3]; count],
        };
        for meeting in half_edges.chunk_by(|x, y| x.0 == y.0) {
            for &(_, triangle, i) in meeting {
                sides.edges[triangle][i] = sides.springs.len() as u32;
            }
            sides.springs.push(meeting[0].0);
            // More than two triangles at an edge do not occur in a plane; of more, the first two share the hinge.
            if let [(_, first, i), (_, second, j), ..] = *meeting {
                let (t, u) = (mesh.triangles[first], mesh.triangles[second]);
                let (c, d) = (t[(i + 2) % 3], u[(j + 2) % 3]);
                let hinge = sides.hinges.len() as u32;
                sides.hinges.push([t[i], t[(i + 1) % 3], c, d]);
                sides.meetings[first][i] = (hinge, false, d);
                sides.meetings[second][j] = (hinge, true, c);
            }
        }
        sides
    }
}

impl Plate {
    fn new(number: usize, corners: [u32; 3], places: &[DVec2], sides: &Sides) -> Self {
        let edges = [0, 1, 2].map(|i| places[corners[(i + 1) % 3] as usize] - places[corners[i] as usize]);
        let doubled_area = edges[0].perp(&edges[1]);
        let meetings = sides.meetings[number];
        Self {
            corners,
            hinges: meetings.map(|meeting| meeting.0),
            second: meetings.map(|meeting| meeting.1),
            across: meetings.map(|meeting| meeting.2),
            form: DMat3::zeros(),
            folds: [0, 1, 2].map(|i| fold_of_curvature(corners, i, meetings[i], places)),
            edges,
            doubled_area,
        }
    }

    /// With the quadratic form of a Poisson ratio and a rib.
    fn stiffened(mut self, poisson_ratio: f64, rib: &Rib) -> Self {
        let normals = self.edges.map(|edge| DVec2::new(-edge.y, edge.x) / edge.norm());
        let along =
            normals.map(|n| rib.along[0] * n.x * n.x + 2.0 * rib.along[1] * n.x * n.y + rib.along[2] * n.y * n.y);
        let lengths = self.edges.map(|edge| edge.norm());
        let entry = |i: usize, j: usize| {
            let cosine = normals[i].dot(&normals[j]);
            let plate = (1.0 - poisson_ratio) * cosine * cosine + poisson_ratio;
            ((1.0 + rib.thickening) * plate + rib.stiffness * along[i] * along[j]) * lengths[i] * lengths[j]
                / (2.0 * self.doubled_area)
        };
        let mut form = DMat3::from_fn(entry);
        for i in 0..3 {
            if self.hinges[i] == RIM {
                form = without(&form, i);
            }
        }
        self.form = form;
        self
    }

    /// The folds that its hinges have on a smooth surface of curvature K: those of vertices lifted by x' K x / 2, to first
    /// order. On uneven triangles they differ from the folds that give S = K in this triangle alone; a sheet that takes the
    /// smooth shape must be at rest.
    fn folds(&self, k: Tensor) -> [f64; 3] {
        self.folds.map(|of| of[0] * k[0] + of[1] * k[1] + of[2] * k[2])
    }

    /// Its middle in the flat blade.
    pub fn middle(&self, places: &[DVec2]) -> DVec2 {
        self.corners.iter().map(|&v| places[v as usize]).sum::<DVec2>() / 3.0
    }
}

/// The fold at edge `i` of a triangle for each component (xx, xy, yy) of a curvature; nought at the rim.
fn fold_of_curvature(corners: [u32; 3], i: usize, meeting: (u32, bool, u32), places: &[DVec2]) -> Tensor {
    if meeting.0 == RIM {
        return [0.0; 3];
    }
    let place = |v: u32| places[v as usize];
    let [a, b, c] = [0, 1, 2].map(|j| place(corners[(i + j) % 3]));
    let edge = b - a;
    // Slope of the fold by the lift of c and of d, and their feet on the edge; the edge's ends take the opposite.
    let arm =
        |p: DVec2, sign: f64| (edge.norm() * sign / edge.perp(&(p - a)), edge.dot(&(p - a)) / edge.norm_squared());
    let d = place(meeting.2);
    let mut fold = [0.0; 3];
    for ((lift, foot), p) in [(arm(c, 1.0), c - a), (arm(d, -1.0), d - a)] {
        let product = |u: DVec2| [0.5 * u.x * u.x, u.x * u.y, 0.5 * u.y * u.y];
        for ((fold, far), near) in fold.iter_mut().zip(product(p)).zip(product(edge)) {
            *fold += lift * (far - foot * near);
        }
    }
    fold
}

/// A quadratic form after one of its variables has taken its best value.
fn without(form: &DMat3, i: usize) -> DMat3 {
    if form[(i, i)] <= 0.0 {
        return *form;
    }
    let mut rest = form - form.column(i) * form.row(i) / form[(i, i)];
    rest.row_mut(i).fill(0.0);
    rest.column_mut(i).fill(0.0);
    rest
}
