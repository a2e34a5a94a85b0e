//! Least squares of two 3-vectors, by blocks: O and C of the pivot, δ and the rotation of one pose, the two parts of a
//! drift.
//!
//! The second vector is eliminated, which leaves a symmetric 3x3 matrix for the first. Everything wanted follows from
//! that: the step, the covariance of the first alone, the whole covariance.

use super::normal_equations::{Singular, UNKNOWNS, at, smallest_pivot};
use crate::calls::{difference, dot, image, image_transposed, scaled, transposed};
use crate::scalar::Real;
use crate::symmetric::Symmetric;
use crate::vector::add_to;
use nalgebra::{Matrix3, Vector3};

/// A symmetric 6x6 matrix: information on two vectors, or their covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blocks<T> {
    /// First with first.
    pub first: Symmetric<T>,
    /// Second (rows) with first (columns).
    pub mixed: Matrix3<T>,
    /// Second with second.
    pub second: Symmetric<T>,
}

/// Normal equations of two vectors, summed equation by equation or pose by pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockEquations<T> {
    /// Their matrix.
    pub matrix: Blocks<T>,
    /// Right-hand sides of the first vector and of the second.
    pub gradient: [Vector3<T>; 2],
    /// Sum of the squared values.
    pub squares: T,
}

impl<T: Real> Blocks<T> {
    /// Nothing known.
    pub fn zero() -> Self {
        Self { first: Symmetric::zero(), mixed: Matrix3::zeros(), second: Symmetric::zero() }
    }

    /// Eliminates the second vector, in place (the sweep operator, Goodnight 1979): `first` becomes what is left for the
    /// first vector, `second` its own inverse, and `mixed` that inverse times itself: how the second follows the first.
    ///
    /// # Errors
    /// [`Singular`] when a pivot of the second block is not larger than the part `smallest` of the diagonal entry that it
    /// came from, or is not a number.
    #[inline(always)]
    pub fn eliminate(&mut self, smallest: T) -> Result<(), Singular> {
        eliminate(&mut self.first, &mut self.mixed, &mut self.second, smallest)
    }

    /// Both vectors eliminated: as [`eliminate`](Self::eliminate), and `first` inverted.
    #[inline(never)]
    fn eliminate_both(&mut self) -> Result<(), Singular> {
        let (smallest, first) = (smallest_pivot(), self.first);
        self.eliminate(smallest)?;
        if self.first.invert(&first, smallest) { Ok(()) } else { Err(Singular) }
    }

    /// The first block of the inverse: the covariance of the first vector, the second eliminated.
    ///
    /// # Errors
    /// [`Singular`] when a pivot is too small against the diagonal entry that it came from, or is not a number.
    #[inline(never)]
    pub fn first_inverse(&self) -> Result<Symmetric<T>, Singular> {
        // Part by part: each is small enough to be moved without a call.
        let Self { first, mixed, second } = *self;
        let mut eliminated = Self { first, mixed, second };
        eliminated.eliminate_both()?;
        Ok(eliminated.first)
    }

    /// Becomes its inverse.
    ///
    /// # Errors
    /// As [`first_inverse`](Self::first_inverse).
    #[inline(never)]
    pub fn invert(&mut self) -> Result<(), Singular> {
        self.eliminate_both()?;
        let turned = transposed(&self.mixed);
        let mut mixed = turned;
        self.first.apply_to(&mut mixed);
        self.second.add_product(&turned, &mixed, T::one());
        self.mixed = transposed(&(-mixed));
        Ok(())
    }

    /// Row `i`, column `j <= i` of the whole 6x6 matrix; zero beside it.
    pub fn entry(&self, i: usize, j: usize) -> T {
        let entry = match (i < 3, j < 3) {
            (true, _) => self.first.0.get(at(i, j)),
            (false, true) => self.mixed.get((i - 3, j)),
            (false, false) => self.second.0.get(at(i - 3, j - 3)),
        };
        entry.copied().unwrap_or(T::zero())
    }

    /// The same, to be changed.
    pub fn entry_mut(&mut self, i: usize, j: usize) -> Option<&mut T> {
        match (i < 3, j < 3) {
            (true, _) => self.first.0.get_mut(at(i, j)),
            (false, true) => self.mixed.get_mut((i - 3, j)),
            (false, false) => self.second.0.get_mut(at(i - 3, j - 3)),
        }
    }
}

impl<T: Real> Default for BlockEquations<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Real> BlockEquations<T> {
    /// No equations yet.
    pub fn new() -> Self {
        Self {
            matrix: Blocks::zero(),
            // Number by number: with `zeros` the solver takes 250 bytes of flash more.
            gradient: [Vector3::new(T::zero(), T::zero(), T::zero()); 2],
            squares: T::zero(),
        }
    }

    /// The step of both vectors.
    ///
    /// # Errors
    /// [`Singular`] as for [`Blocks::first_inverse`].
    #[inline(never)]
    pub fn solve(&self) -> Result<[T; UNKNOWNS], Singular> {
        let mut matrix = self.matrix;
        matrix.eliminate_both()?;
        let [first, second] = &self.gradient;
        let a = matrix.first.image(&difference(first, &image_transposed(&matrix.mixed, second)));
        let b = difference(&matrix.second.image(second), &image(&matrix.mixed, &a));
        Ok([a.x, a.y, a.z, b.x, b.y, b.z])
    }

    /// How much of the squares a step takes away, as far as the equations are linear.
    pub fn gained(&self, [a, b, c, d, e, f]: &[T; UNKNOWNS]) -> T {
        let [first, second] = &self.gradient;
        dot(&Vector3::new(*a, *b, *c), first) + dot(&Vector3::new(*d, *e, *f), second)
    }

    /// Adds what a pose knows of δ = δO - R δC, `weight` times: Jᵀ S J and Jᵀ g for J = [I, -R], unknowns O and C.
    #[inline(never)]
    pub fn add_pose(&mut self, rotation: &Matrix3<T>, information: &Symmetric<T>, gradient: &Vector3<T>, weight: T) {
        let mut turned = *rotation;
        information.apply_to(&mut turned);
        let Blocks { first, mixed, second } = &mut self.matrix;
        first.add(information, weight);
        second.add_product(rotation, &turned, weight);
        mixed.m11 -= turned.m11 * weight;
        mixed.m12 -= turned.m21 * weight;
        mixed.m13 -= turned.m31 * weight;
        mixed.m21 -= turned.m12 * weight;
        mixed.m22 -= turned.m22 * weight;
        mixed.m23 -= turned.m32 * weight;
        mixed.m31 -= turned.m13 * weight;
        mixed.m32 -= turned.m23 * weight;
        mixed.m33 -= turned.m33 * weight;
        let gradient = scaled(gradient, weight);
        let [of_first, of_second] = &mut self.gradient;
        add_to(of_first, &gradient);
        *of_second = difference(of_second, &image_transposed(rotation, &gradient));
    }

    /// Adds what a sample knows of δO = a + b t, unknowns a and b, for a known t.
    pub fn add_growing(&mut self, information: &Symmetric<T>, gradient: &Vector3<T>, t: T) {
        let Blocks { first, mixed, second } = &mut self.matrix;
        first.add(information, T::one());
        second.add(information, t * t);
        *mixed += information.to_matrix() * t;
        let [of_first, of_second] = &mut self.gradient;
        add_to(of_first, gradient);
        add_to(of_second, &scaled(gradient, t));
    }
}

/// [`Blocks::eliminate`], on blocks that lie apart: each is small enough to be moved without a call.
#[inline(never)]
pub(super) fn eliminate<T: Real>(
    first: &mut Symmetric<T>,
    mixed: &mut Matrix3<T>,
    second: &mut Symmetric<T>,
    smallest: T,
) -> Result<(), Singular> {
    let (information, shared) = (*second, *mixed);
    if !second.invert(&information, smallest) {
        return Err(Singular);
    }
    second.apply_to(mixed);
    first.add_product(&shared, mixed, -T::one());
    Ok(())
}
