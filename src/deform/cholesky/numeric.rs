//! The numbers of the factor: front by front, gather the matrix's columns and the children's updates, eliminate the own
//! vertices, hand the update of the boundary up.

use super::dense::{self, Quad, TILE, triangle_start};
use super::matrix::Matrix;
use super::symbolic::{Front, Symbolic};

/// The matrix is not positive definite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Indefinite;

/// A factor; [`Factor::compute`] may be called again and again for matrices of one pattern.
#[derive(Clone, Debug, PartialEq)]
pub struct Factor {
    symbolic: Symbolic,
    panels: Vec<Quad>,
}

impl Factor {
    /// An empty factor for matrices of a pattern.
    #[must_use]
    pub fn new(symbolic: Symbolic) -> Self {
        let panels = vec![[0.0; TILE]; symbolic.quads];
        Self { symbolic, panels }
    }

    /// Factors a matrix.
    ///
    /// # Errors
    /// [`Indefinite`] when a pivot is not positive; the factor is then not to be used.
    pub fn compute(&mut self, matrix: &Matrix) -> Result<(), Indefinite> {
        let mut updates: Vec<Vec<Quad>> = vec![Vec::new(); self.symbolic.fronts.len()];
        for (number, front) in self.symbolic.fronts.iter().enumerate() {
            let panel = &mut self.panels[front.start..front.start + front.quads()];
            let mut triangle = vec![[0.0; TILE]; triangle_start(front.below() / TILE)];
            panel.fill([0.0; TILE]);
            gather(front, matrix, panel);
            for &child in &front.children {
                let update = std::mem::take(&mut updates[child]);
                extend(front, &self.symbolic.fronts[child], &update, panel, &mut triangle);
            }
            let width = front.width();
            if width > 0 {
                if !dense::factor_panel(panel, width) {
                    return Err(Indefinite);
                }
                dense::update_triangle(&mut triangle, &panel[width / TILE * width..], width);
            }
            updates[number] = triangle;
        }
        Ok(())
    }

    /// Solves A x = b in place; vectors are in the order of elimination.
    pub fn solve(&self, x: &mut [[f64; 3]]) {
        for front in &self.symbolic.fronts {
            let mut own = own_part(front, x);
            let below = dense::forward(self.panel(front), front.width(), &mut own);
            put(front, &own, x);
            for (&number, part) in front.boundary.iter().zip(below.chunks_exact(3)) {
                x[number as usize].iter_mut().zip(part).for_each(|(x, part)| *x -= part);
            }
        }
        for front in self.symbolic.fronts.iter().rev() {
            let mut own = own_part(front, x);
            let mut below = vec![0.0; front.below()];
            for (&number, part) in front.boundary.iter().zip(below.chunks_exact_mut(3)) {
                part.copy_from_slice(&x[number as usize]);
            }
            dense::backward(self.panel(front), front.width(), &mut own, &below);
            put(front, &own, x);
        }
    }

    fn panel(&self, front: &Front) -> &[Quad] {
        &self.panels[front.start..front.start + front.quads()]
    }
}

fn own_part(front: &Front, x: &[[f64; 3]]) -> Vec<f64> {
    let mut own = vec![0.0; front.width()];
    for (part, x) in own.chunks_exact_mut(3).zip(&x[front.own.start as usize..front.own.end as usize]) {
        part.copy_from_slice(x);
    }
    own
}

fn put(front: &Front, own: &[f64], x: &mut [[f64; 3]]) {
    for (x, part) in x[front.own.start as usize..front.own.end as usize].iter_mut().zip(own.chunks_exact(3)) {
        x.copy_from_slice(part);
    }
}

/// Puts the matrix's columns of the own vertices into the panel, and 1 on the diagonal of what fills its last tile.
fn gather(front: &Front, matrix: &Matrix, panel: &mut [Quad]) {
    let width = front.width();
    for filler in 3 * front.own.len()..width {
        panel[filler / TILE * width + filler][filler % TILE] = 1.0;
    }
    for number in front.own.clone() {
        let column = front.row(number);
        for at in matrix.column(number as usize) {
            let row = front.row(matrix.rows[at]);
            let block = &matrix.blocks[at];
            for i in 0..3 {
                let strip = (row + i) / TILE * width;
                for j in 0..3 {
                    panel[strip + column + j][(row + i) % TILE] = block[3 * i + j];
                }
            }
        }
    }
}

/// Adds a child's update to the panel and the triangle of its parent.
fn extend(front: &Front, child: &Front, update: &[Quad], panel: &mut [Quad], triangle: &mut [Quad]) {
    let width = front.width();
    let rows: Vec<usize> =
        child.boundary.iter().map(|&number| front.row(number)).flat_map(|row| [row, row + 1, row + 2]).collect();
    for (i, &row) in rows.iter().enumerate() {
        let (strip, lane) = (triangle_start(i / TILE), i % TILE);
        let (own, later) = rows[..=i].split_at(rows[..=i].partition_point(|&column| column < width));
        let base = row / TILE * width;
        for (j, &column) in own.iter().enumerate() {
            panel[base + column][row % TILE] += update[strip + j][lane];
        }
        if row < width {
            continue;
        }
        let below = row - width;
        let base = triangle_start(below / TILE);
        for (j, &column) in later.iter().enumerate() {
            triangle[base + column - width][below % TILE] += update[strip + own.len() + j][lane];
        }
    }
}
