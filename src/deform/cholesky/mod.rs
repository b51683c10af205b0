//! Sparse Cholesky factorisation of symmetric positive definite matrices of 3 x 3 blocks: multifrontal (Duff and Reid 1983)
//! over a nested dissection of the vertices' places.
//!
//! Why not a library: the fast ones choose their kernels by the processor at run time and fuse products with sums where it
//! can, so their last bits differ between machines, and with them every picture. This one has a single unfused kernel.

mod dense;
mod matrix;
mod numeric;
mod ordering;
mod symbolic;

pub use matrix::{Block, Matrix, NOWHERE};
pub use numeric::Factor;
#[cfg(test)]
use numeric::Indefinite;
pub use symbolic::Symbolic;

#[cfg(test)]
mod tests;
