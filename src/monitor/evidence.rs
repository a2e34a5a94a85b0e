//! The evidence of a suspicious stretch of motion, fitted with each possible cause.

use crate::identification::marginal_information::MarginalInformation;
use crate::linear_algebra::{NormalEquations, dot, inverse_of_positive_definite};
use crate::rig::CABLES;
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// χ² per degree of freedom up to which a cause explains the evidence. 1 is noise alone; the equations are linear in
/// the slip, which adds a little at 3 mm.
const EXPLAINED: f64 = 4.0;

/// A cause with more unknowns must leave a χ² smaller by this factor than a simpler one that explains the evidence.
const CLEARLY: f64 = 1.4;

/// What has happened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cause<T> {
    /// The centre moved in {B}: the base strap slipped. By how much, mm, axes of {B}.
    StrapSlipped(Vector3<T>),
    /// The centre moved in {P}: the cuff slipped on the arm. By how much, mm, axes of {P}.
    CuffSlipped(Vector3<T>),
    /// One cable slipped on its drum or stretched.
    CableSlipped {
        /// Cable, 1 to 6.
        cable: u8,
        /// Error of its length (reading minus true), mm.
        error_mm: T,
    },
    /// The centre moves with the arm's elevation: not a ball joint. Movement per 10 degrees, mm, axes of {B}.
    NotABall(Vector3<T>),
    /// Something has moved that none of the causes explains alone.
    Unknown,
}

/// A warning: the cause, and how well it explains the evidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Warning<T> {
    /// The cause that explains the evidence best.
    pub cause: Cause<T>,
    /// χ² per degree of freedom before any explanation, and with this one; 1 is noise.
    pub chi_square: [T; 2],
}

/// A cause, the squares that it explains, mm², and how many unknowns it has; `None` where the evidence does not determine it.
pub(super) type Explanation<T> = Option<(Cause<T>, T, i32)>;

/// Sums over the samples of a stretch of motion.
#[derive(Clone, Debug)]
pub(super) struct Evidence<T> {
    samples: u16,
    /// Squares with no explanation, mm².
    squares: T,
    /// δO, and (rows 3..6) δO per radian of elevation.
    drift: NormalEquations<T, 6, 21>,
    strap: (Matrix3<T>, Vector3<T>),
    cuff: (Matrix3<T>, Vector3<T>),
    cables: [(T, T); CABLES],
}

impl<T: Real> Evidence<T> {
    pub fn new() -> Self {
        Self {
            samples: 0,
            squares: T::zero(),
            drift: NormalEquations::new(6),
            strap: (Matrix3::zeros(), Vector3::zeros()),
            cuff: (Matrix3::zeros(), Vector3::zeros()),
            cables: [(T::zero(), T::zero()); CABLES],
        }
    }

    pub fn samples(&self) -> u16 {
        self.samples
    }

    /// Adds a sample with the arm's rotation ({P} to {B}), without what it says of single cables.
    #[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    pub fn add(&mut self, rotation: &Matrix3<T>, pose: &MarginalInformation<T>) {
        self.samples = self.samples.saturating_add(1);
        self.squares += pose.squares_mm2();
        let (information, gradient) = (&pose.information(), &pose.gradient_mm());
        self.strap.0 += information;
        self.strap.1 += gradient;
        self.cuff.0 += rotation.tr_mul(&(information * rotation));
        self.cuff.1 -= rotation.tr_mul(gradient);
        self.add_growing(information, gradient, elevation(rotation));
    }

    /// Adds what the same sample says of single cables.
    pub fn add_cables(&mut self, pose: &MarginalInformation<T>) {
        for ((weight, gradient), column) in self.cables.iter_mut().zip(&pose.projector()) {
            *weight += column.norm_squared();
            *gradient += column.dot(&pose.residuals_mm);
        }
    }

    /// Adds a sample to the normal equations of δO = a + b t, unknowns a and b, for a known t.
    fn add_growing(&mut self, information: &Matrix3<T>, gradient: &Vector3<T>, t: T) {
        for i in 0..3 {
            for j in 0..3 {
                self.drift.add_to_entry(3 + i, j, information[(i, j)] * t);
                if j <= i {
                    self.drift.add_to_entry(i, j, information[(i, j)]);
                    self.drift.add_to_entry(3 + i, 3 + j, information[(i, j)] * (t * t));
                }
            }
            self.drift.add_to_gradient(i, gradient[i]);
            self.drift.add_to_gradient(3 + i, gradient[i] * t);
        }
    }

    /// The cause that explains the evidence; `None` when there is nothing to explain. `usual`: χ² per degree of
    /// freedom before the suspicion, 1 or more. `drift`: what [`drift`](Self::drift) found before.
    pub fn judge(&self, variance_mm2: T, suspicious: T, usual: T, drift: Explanation<T>) -> Option<Warning<T>> {
        let before = self.left(T::zero(), 0) / variance_mm2;
        if before < suspicious {
            return None;
        }
        // From the simplest cause to the richest: the first that explains everything is named, else the best of all.
        let mut best = Warning { cause: Cause::Unknown, chi_square: [before, before] };
        let causes = [self.cable(), self.strap(), self.cuff(), drift];
        for (cause, explained, unknowns) in causes.into_iter().flatten() {
            let after = self.left(explained, unknowns) / variance_mm2;
            if after <= T::of(EXPLAINED) && after < best.chi_square[1] {
                let first = best.cause == Cause::Unknown;
                // A cause with more unknowns must explain clearly more. Differences below the usual χ² do not count:
                // the noise and the error of the centre in use leave that much anyway.
                if first || after.max(usual) * T::of(CLEARLY) < best.chi_square[1] {
                    best = Warning { cause, chi_square: [before, after] };
                }
            }
        }
        Some(best)
    }

    /// Squares per degree of freedom that an explanation leaves, mm².
    fn left(&self, explained: T, unknowns: i32) -> T {
        let freedom = (3 * i32::from(self.samples) - unknowns).max(1);
        (self.squares - explained).max(T::zero()) / T::of_integer(freedom)
    }

    fn cable(&self) -> Explanation<T> {
        let explained = |&(weight, gradient): &(T, T)| {
            if weight > T::zero() { gradient * gradient / weight } else { T::zero() }
        };
        let [first, ..] = &self.cables;
        let better = |best: (u8, _), next: (u8, _)| if explained(next.1) > explained(best.1) { next } else { best };
        let (cable, best) = (1..).zip(&self.cables).fold((1, first), better);
        let &(weight, gradient) = best;
        (weight > T::zero()).then(|| (Cause::CableSlipped { cable, error_mm: gradient / weight }, explained(best), 1))
    }

    fn strap(&self) -> Explanation<T> {
        let (moved, explained) = moved(&self.strap.0, &self.strap.1)?;
        Some((Cause::StrapSlipped(moved), explained, 3))
    }

    fn cuff(&self) -> Explanation<T> {
        let (moved, explained) = moved(&self.cuff.0, &self.cuff.1)?;
        Some((Cause::CuffSlipped(moved), explained, 3))
    }

    /// A centre that moves with the arm's elevation as the cause; half of the work of judging.
    pub fn drift(&self) -> Explanation<T> {
        let mut drift = self.drift;
        drift.factor().ok()?;
        let step = drift.step();
        let explained = dot(&step, drift.gradient());
        // A radian of elevation to 10 degrees.
        let per_ten_degrees = Vector3::new(step[3], step[4], step[5]) * T::of(0.174_532_925_199_432_95);
        Some((Cause::NotABall(per_ten_degrees), explained, 6))
    }
}

/// The displacement that fits best, mm, and the squares that it explains, mm².
fn moved<T: Real>(information: &Matrix3<T>, gradient: &Vector3<T>) -> Option<(Vector3<T>, T)> {
    let moved = inverse_of_positive_definite(information, T::default_epsilon())? * gradient;
    Some((moved, moved.dot(gradient)))
}

/// Angle between the arm's long axis (z of {P}) and z of {B}, rad, from its sine and cosine.
fn elevation<T: Real>(rotation: &Matrix3<T>) -> T {
    let (x, y, z) = (rotation.m13, rotation.m23, rotation.m33);
    (x * x + y * y).root().atan2(z)
}
