use super::*;
use crate::base::random::{Purpose, Stream};
use crate::base::vector::DVec2;

/// A grid of vertices coupled to their neighbours (eight around each), with holes where `hole` says so.
fn grid(columns: usize, rows: usize, hole: fn(usize, usize) -> bool) -> (Vec<DVec2>, Vec<[u32; 2]>) {
    let cells: Vec<(usize, usize)> =
        (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y))).filter(|&(x, y)| !hole(x, y)).collect();
    let places = cells.iter().map(|&(x, y)| DVec2::new(x as f64, y as f64)).collect();
    let near = |a: usize, b: usize| a.abs_diff(b) <= 1;
    let mut couplings = Vec::new();
    for (i, a) in cells.iter().enumerate() {
        for (j, b) in cells.iter().enumerate().take(i) {
            if near(a.0, b.0) && near(a.1, b.1) {
                couplings.push([i as u32, j as u32]);
            }
        }
    }
    (places, couplings)
}

/// A random matrix of a pattern, made definite by `weight` times its diagonal's sum of absolute values.
fn filled(symbolic: &Symbolic, couplings: &[[u32; 2]], weight: f64) -> Matrix {
    let number = |v: u32| symbolic.numbers[v as usize];
    let size = symbolic.numbers.len();
    let mut matrix = Matrix::new(size, couplings.iter().map(|c| c.map(number)));
    let mut stream = Stream::new(5, Purpose::Deformation, 0, 0);
    let mut sums = vec![0.0; size];
    for &[a, b] in couplings {
        let block: Block = std::array::from_fn(|_| stream.range(-1.0, 1.0));
        let (a, b) = (number(a), number(b));
        matrix.add(matrix.place(a, b), [a, b], &block, true);
        let sum: f64 = block.iter().map(|x| x.abs()).sum();
        sums[a as usize] += sum;
        sums[b as usize] += sum;
    }
    matrix.shift(&sums, weight);
    matrix
}

fn residual(matrix: &Matrix, factor: &Factor) -> f64 {
    let mut stream = Stream::new(6, Purpose::Deformation, 0, 0);
    let b: Vec<[f64; 3]> = (0..matrix.size()).map(|_| std::array::from_fn(|_| stream.range(-1.0, 1.0))).collect();
    let mut x = b.clone();
    factor.solve(&mut x);
    let off = |(p, q): (&[f64; 3], &[f64; 3])| (0..3).map(|i| (p[i] - q[i]).abs()).fold(0.0, f64::max);
    matrix.times(&x).iter().zip(&b).map(off).fold(0.0, f64::max)
}

#[test]
fn the_solution_solves() {
    for (columns, rows) in [(1, 1), (2, 1), (5, 3), (13, 17), (40, 9)] {
        let (places, couplings) = grid(columns, rows, |_, _| false);
        let symbolic = Symbolic::new(&places, couplings.iter().copied());
        let matrix = filled(&symbolic, &couplings, 1.1);
        if couplings.is_empty() {
            continue;
        }
        let mut factor = Factor::new(symbolic);
        assert_eq!(factor.compute(&matrix), Ok(()));
        let residual = residual(&matrix, &factor);
        assert!(residual < 1e-12, "{columns} x {rows}: {residual}");
    }
}

#[test]
fn holes_and_separate_parts_are_no_matter() {
    let (places, couplings) =
        grid(30, 20, |x, y| (10..14).contains(&x) || (20..25).contains(&x) && (5..9).contains(&y));
    let symbolic = Symbolic::new(&places, couplings.iter().copied());
    let matrix = filled(&symbolic, &couplings, 1.1);
    let mut factor = Factor::new(symbolic);
    assert_eq!(factor.compute(&matrix), Ok(()));
    assert!(residual(&matrix, &factor) < 1e-12);
}

#[test]
fn every_vertex_is_eliminated_once_and_fronts_hold_all_couplings() {
    let (places, couplings) = grid(23, 31, |_, _| false);
    let symbolic = Symbolic::new(&places, couplings.iter().copied());
    let mut numbers = symbolic.numbers.clone();
    numbers.sort_unstable();
    assert!(numbers.iter().enumerate().all(|(i, &number)| i as u32 == number));
    for [a, b] in couplings {
        let (a, b) = (symbolic.numbers[a as usize], symbolic.numbers[b as usize]);
        let front = symbolic.fronts.iter().find(|front| front.own.contains(&a.min(b))).unwrap();
        assert!(front.own.contains(&a.max(b)) || front.boundary.contains(&a.max(b)));
    }
}

#[test]
fn dissection_fills_far_less_than_a_band_would() {
    let (places, couplings) = grid(40, 40, |_, _| false);
    let symbolic = Symbolic::new(&places, couplings.iter().copied());
    // A band of 41 vertices: 1600 * 3 columns of 123 numbers and more.
    assert!(symbolic.quads * 4 < 1600 * 3 * 123, "{}", symbolic.quads * 4);
}

#[test]
fn an_indefinite_matrix_is_told() {
    let (places, couplings) = grid(12, 12, |_, _| false);
    let symbolic = Symbolic::new(&places, couplings.iter().copied());
    let matrix = filled(&symbolic, &couplings, 0.01);
    assert_eq!(Factor::new(symbolic).compute(&matrix), Err(Indefinite));
}

#[test]
fn a_matrix_that_is_not_finite_is_no_factor() {
    let (places, couplings) = grid(4, 4, |_, _| false);
    let symbolic = Symbolic::new(&places, couplings.iter().copied());
    let mut matrix = filled(&symbolic, &couplings, 1.1);
    matrix.blocks[3][1] = f64::NAN;
    matrix.blocks[0][0] = f64::INFINITY;
    assert_eq!(Factor::new(symbolic).compute(&matrix), Err(Indefinite));
}
