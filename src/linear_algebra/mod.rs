//! Linear algebra that nalgebra does not offer without a heap or a reachable panic: normal equations whose size is
//! known at run time only, eigenvalues of small symmetric matrices, the inverse of a positive definite 3x3 matrix.

pub mod axes;
pub mod eigen;
pub mod normal_equations;
pub mod parts;
pub mod positive_definite;

pub use axes::{triad, unit};
pub use eigen::{Eigen, EigenSearch, largest_eigenpair, symmetric_eigen};
pub use normal_equations::{NormalEquations, Singular, packed_index};
pub use parts::{block, column};
pub use positive_definite::{inverse_of_eliminated, inverse_of_positive_definite, solve_positive_definite};

use crate::scalar::Real;

// The next two are not inlined: 35 copies of a root and 12 of a loop are 4 KB of flash (`cargo footprint --sections`).

/// a · b, as far as both go, summed from the first on; four products a round, which takes 5.6 instructions each instead of 7.
#[inline(never)]
#[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
pub fn dot<T: Real>(a: &[T], b: &[T]) -> T {
    let len = a.len().min(b.len());
    let (Some(a), Some(b)) = (a.get(..len), b.get(..len)) else { return T::zero() };
    let ((fours_of_a, rest_of_a), (fours_of_b, rest_of_b)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let mut sum = T::zero();
    for ([a, b, c, d], [w, x, y, z]) in fours_of_a.iter().zip(fours_of_b) {
        sum = sum + *a * *w + *b * *x + *c * *y + *d * *z;
    }
    rest_of_a.iter().zip(rest_of_b).fold(sum, |sum, (a, b)| sum + *a * *b)
}

/// Square root; zero of what rounding has made negative. NaN stays.
#[inline(never)]
#[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
pub fn non_negative_root<T: Real>(x: T) -> T {
    if x < T::zero() { T::zero() } else { x.root() }
}

/// The smallest pivot above rounding, as a share of the diagonal entry that it came from. The information on the
/// rotation in a pose of a regular rig is a hundred times above it.
pub fn rounding<T: Real>() -> T {
    T::default_epsilon() * T::of(64.0)
}
