//! The six zeros as unknowns of the normal equations, and their elimination.
//!
//! After a pose's rotation is eliminated (see [`pose_information`](crate::identification::pose_information)), zero z_k is
//! seen through a_k = u_k - K G⁻¹ g_k in the pose's three combinations δ, and through δ_kl - g_k G⁻¹ g_l against the
//! other zeros.

use crate::identification::blocks::{BlockEquations, Blocks};
use crate::identification::normal_equations::{Factors, PACKED, Singular, UNKNOWNS, at};
use crate::identification::pose_information::PoseInformation;
use crate::kinematics::LengthEquations;
use crate::rig::CABLES;
use crate::scalar::Real;
use nalgebra::Matrix3;

/// The part of the normal equations that concerns the zeros.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZeroEquations<T> {
    /// Between the six unknowns O, C (rows) and the six zeros (columns).
    mixed: [[T; CABLES]; UNKNOWNS],
    /// Among the zeros, lower triangle row by row; the prior is in its diagonal.
    inner: [T; PACKED],
    gradient: [T; CABLES],
    /// Squares of the prior's own residuals, mm².
    prior_squares: T,
}

impl<T: Real> ZeroEquations<T> {
    /// Equations that hold the prior only. `weight` is the noise's variance over the prior's; `zeros_mm` the present
    /// estimate, mm.
    pub fn new(weight: T, zeros_mm: &[T; CABLES]) -> Self {
        let mut inner = [T::zero(); PACKED];
        for k in 0..CABLES {
            inner[at(k, k)] = weight;
        }
        Self {
            mixed: [[T::zero(); CABLES]; UNKNOWNS],
            inner,
            gradient: zeros_mm.map(|z| -z * weight),
            prior_squares: zeros_mm.iter().fold(T::zero(), |sum, z| sum + *z * *z * weight),
        }
    }

    /// Adds a pose with its rotation ({P} to {B}) and weight.
    // Not inlined: it has its own place in the memory without wait states (`hot.x`).
    #[inline(never)]
    pub fn add(&mut self, rotation: &Matrix3<T>, equations: &LengthEquations<T>, pose: &PoseInformation<T>, weight: T) {
        let through = &pose.through;
        // entry after entry, as they are packed
        let mut inner = self.inner.iter_mut();
        for (k, cable) in equations.cables.iter().enumerate() {
            let g = &cable.moment_mm;
            let seen = (cable.direction - through.tr_mul(g)) * weight;
            let in_platform = rotation.tr_mul(&seen);
            for i in 0..3 {
                self.mixed[i][k] += seen[i];
                self.mixed[3 + i][k] -= in_platform[i];
            }
            self.gradient[k] += (cable.residual_mm - g.dot(&pose.turn)) * weight;
            let taken = pose.turning_inverse.image(g) * weight;
            for (other, entry) in equations.cables.iter().take(k).zip(inner.by_ref()) {
                *entry -= taken.dot(&other.moment_mm);
            }
            if let Some(entry) = inner.next() {
                *entry += weight - taken.dot(g);
            }
        }
    }

    /// Eliminates the zeros: the normal equations that remain for O and C.
    ///
    /// # Errors
    /// [`Singular`] when the zeros determine each other badly; cannot happen with a prior.
    #[inline(never)]
    pub fn reduce(&self, equations: &BlockEquations<T>) -> Result<Reduced<T>, Singular> {
        let Ok(factors) = &Factors::of(&self.inner) else { return Err(Singular) };
        let alone = factors.solve(&self.gradient);
        let columns = self.mixed.map(|row| factors.solve(&row));
        let mut reduced = *equations;
        for i in 0..UNKNOWNS {
            for (j, column) in columns.iter().enumerate().take(i + 1) {
                if let Some(entry) = reduced.matrix.entry_mut(i, j) {
                    *entry -= dot(&self.mixed[i], column);
                }
            }
            reduced.gradient[i / 3][i % 3] -= dot(&self.mixed[i], &alone);
        }
        reduced.squares = equations.squares + self.prior_squares - dot(&self.gradient, &alone);
        Ok(Reduced { equations: reduced, alone, columns, inverse: factors.inverse() })
    }

    /// Covariance of O and C for a noise of 1 mm, and the variances of the zeros for the same.
    ///
    /// # Errors
    /// [`Singular`] when the poses leave O and C undetermined.
    #[inline(never)]
    pub fn covariance(&self, equations: &BlockEquations<T>) -> Result<(Blocks<T>, [T; CABLES]), Singular> {
        let Ok(reduced) = &mut self.reduce(equations) else { return Err(Singular) };
        reduced.equations.matrix.invert()?;
        Ok((reduced.equations.matrix, reduced.zeros_variance()))
    }
}

/// The zeros eliminated, and what is needed to get them back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reduced<T> {
    /// For O and C; `squares` is what is left with the best zeros and O, C unmoved.
    pub equations: BlockEquations<T>,
    alone: [T; CABLES],
    columns: [[T; CABLES]; UNKNOWNS],
    inverse: [T; PACKED],
}

impl<T: Real> Reduced<T> {
    /// The step of the zeros that goes with a step of O and C, mm.
    pub fn zeros_step(&self, step: &[T; UNKNOWNS]) -> [T; CABLES] {
        core::array::from_fn(|k| (0..UNKNOWNS).fold(self.alone[k], |rest, i| rest - self.columns[i][k] * step[i]))
    }

    /// Variance of each zero for a noise of 1 mm, the equations inverted.
    fn zeros_variance(&self) -> [T; CABLES] {
        let covariance = &self.equations.matrix;
        core::array::from_fn(|k| {
            let mut variance = self.inverse[at(k, k)];
            for i in 0..UNKNOWNS {
                for j in 0..UNKNOWNS {
                    let entry = covariance.entry(i.max(j), i.min(j));
                    variance += self.columns[i][k] * entry * self.columns[j][k];
                }
            }
            variance
        })
    }
}

fn dot<T: Real>(a: &[T; 6], b: &[T; 6]) -> T {
    a.iter().zip(b).fold(T::zero(), |sum, (x, y)| sum + *x * *y)
}
