//! One more equation for a matrix that is factored already.

use super::NormalEquations;
use crate::linear_algebra::packed_index;
use crate::scalar::Real;

impl<T: Real, const N: usize, const P: usize> NormalEquations<T, N, P> {
    /// Once factored: the factor becomes that of JᵀJ with the equation `row` added, by a Givens rotation a column (Golub and Van
    /// Loan, section 6.5.4). Of what the equation equals nothing is known, so that Jᵀe and eᵀe stay.
    pub fn add_row_to_factor(&mut self, row: &[T; N]) {
        let mut x = *row;
        for k in 0..self.unknowns {
            let Some(inverse) = self.matrix.get_mut(packed_index(k, k)) else { return };
            let known = T::one() / *inverse;
            let added = x.get(k).copied().unwrap_or_else(T::zero);
            let diagonal = (known * known + added * added).root();
            let (cosine, sine) = (known / diagonal, added / diagonal);
            *inverse = T::one() / diagonal;
            for (i, x) in x.iter_mut().enumerate().take(self.unknowns).skip(k + 1) {
                let Some(entry) = self.matrix.get_mut(packed_index(i, k)) else { return };
                let below = *entry;
                *entry = below * cosine + *x * sine;
                *x = *x * cosine - below * sine;
            }
        }
    }
}
