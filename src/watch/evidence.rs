//! The evidence of a suspicious stretch of motion, laid against each possible cause.

use crate::identification::blocks::BlockEquations;
use crate::identification::normal_equations::UNKNOWNS;
use crate::identification::pose_information::PoseInformation;
use crate::kinematics::LengthEquations;
use crate::rig::CABLES;
use crate::scalar::Real;
use crate::symmetric::Symmetric;
use nalgebra::{Matrix3, Vector3};

/// What is left per degree of freedom, in units of the noise's variance, up to which a cause explains the evidence. 1
/// would be noise alone; a slip of 3 mm is seen through equations linear in it, which adds a little.
const EXPLAINED: f64 = 4.0;

/// A richer cause must leave so many times less than a simpler one that explains the evidence as well.
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
        /// What its length reads too much, mm.
        error_mm: T,
    },
    /// The centre moves with the arm's elevation: not a ball joint. Movement per 10 degrees, mm, axes of {B}.
    NotABall(Vector3<T>),
    /// Something has moved that none of the causes explains alone.
    Unknown,
}

/// A warning: what has happened, and how sure it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Warning<T> {
    /// The cause that explains the evidence best.
    pub cause: Cause<T>,
    /// Misfit per degree of freedom before any explanation, and with this one; 1 is noise.
    pub misfit: [T; 2],
}

/// Sums over the samples of a stretch of motion.
#[derive(Clone, Debug)]
pub(super) struct Evidence<T> {
    samples: u16,
    /// Squares with no explanation, mm².
    squares: T,
    /// δO, and (rows 3..6) δO per radian of elevation.
    drift: BlockEquations<T>,
    cuff: (Symmetric<T>, Vector3<T>),
    cables: [(T, T); CABLES],
}

impl<T: Real> Evidence<T> {
    pub fn new() -> Self {
        Self {
            samples: 0,
            squares: T::zero(),
            drift: BlockEquations::new(),
            cuff: (Symmetric::zero(), Vector3::zeros()),
            cables: [(T::zero(), T::zero()); CABLES],
        }
    }

    pub fn samples(&self) -> u16 {
        self.samples
    }

    /// Adds a sample with the arm's rotation ({P} to {B}).
    pub fn add(&mut self, rotation: &Matrix3<T>, equations: &LengthEquations<T>, pose: &PoseInformation<T>) {
        self.samples = self.samples.saturating_add(1);
        self.squares += pose.squares_mm2;
        let information = &pose.information;
        self.drift.add_growing(information, &pose.gradient_mm, elevation(rotation));
        let mut turned = *rotation;
        information.apply_to(&mut turned);
        self.cuff.0.add_product(rotation, &turned, T::one());
        self.cuff.1 -= rotation.tr_mul(&pose.gradient_mm);
        for ((weight, gradient), cable) in self.cables.iter_mut().zip(&equations.cables) {
            let g = &cable.moment_mm;
            *weight += T::one() - g.dot(&(pose.turning_inverse.image(g)));
            *gradient += cable.residual_mm - g.dot(&pose.turn);
        }
    }

    /// The cause that explains the evidence; `None` when there is nothing to explain. `usual`: misfit per degree of
    /// freedom when all was well, 1 or more.
    pub fn judge(&self, variance_mm2: T, suspicious: T, usual: T) -> Option<Warning<T>> {
        let before = self.left(T::zero(), 0) / variance_mm2;
        if before < suspicious {
            return None;
        }
        // From the simplest cause to the richest: the first that explains everything is named, else the best of all.
        let mut best = Warning { cause: Cause::Unknown, misfit: [before, before] };
        let causes = [self.cable(), self.strap(), self.cuff(), self.drift()];
        for (cause, explained, unknowns) in causes.into_iter().flatten() {
            let after = self.left(explained, unknowns) / variance_mm2;
            if after <= T::of(EXPLAINED) && after < best.misfit[1] {
                let first = best.cause == Cause::Unknown;
                // A richer cause must explain clearly more than a simpler one that already does. What is left below
                // the usual tells nothing: that much the noise and the error of the centre in use leave anyway.
                if first || after.max(usual) * T::of(CLEARLY) < best.misfit[1] {
                    best = Warning { cause, misfit: [before, after] };
                }
            }
        }
        Some(best)
    }

    /// What an explanation leaves per degree of freedom, mm².
    fn left(&self, explained: T, unknowns: i32) -> T {
        let freedom = (3 * i32::from(self.samples) - unknowns).max(1);
        (self.squares - explained).max(T::zero()) / T::of_integer(freedom)
    }

    fn cable(&self) -> Option<(Cause<T>, T, i32)> {
        let explained = |&(weight, gradient): &(T, T)| {
            if weight > T::zero() { gradient * gradient / weight } else { T::zero() }
        };
        let [first, ..] = &self.cables;
        let better = |best: (u8, _), next: (u8, _)| if explained(next.1) > explained(best.1) { next } else { best };
        let (cable, best) = (1..).zip(&self.cables).fold((1, first), better);
        let &(weight, gradient) = best;
        (weight > T::zero()).then(|| (Cause::CableSlipped { cable, error_mm: gradient / weight }, explained(best), 1))
    }

    fn strap(&self) -> Option<(Cause<T>, T, i32)> {
        let (moved, explained) = moved(&self.drift.matrix.first, &self.drift.gradient[0])?;
        Some((Cause::StrapSlipped(moved), explained, 3))
    }

    fn cuff(&self) -> Option<(Cause<T>, T, i32)> {
        let (moved, explained) = moved(&self.cuff.0, &self.cuff.1)?;
        Some((Cause::CuffSlipped(moved), explained, 3))
    }

    fn drift(&self) -> Option<(Cause<T>, T, i32)> {
        let step = self.drift.solve().ok()?;
        // A radian of elevation to 10 degrees.
        let per_ten_degrees = Vector3::new(step[3], step[4], step[5]) * T::of(0.174_532_925_199_432_95);
        Some((Cause::NotABall(per_ten_degrees), self.drift.gained(&step), UNKNOWNS as i32))
    }
}

/// What moves a point best, and the squares that it explains.
fn moved<T: Real>(information: &Symmetric<T>, gradient: &Vector3<T>) -> Option<(Vector3<T>, T)> {
    let mut covariance = *information;
    covariance.invert(information, T::default_epsilon()).then(|| {
        let moved = covariance.image(gradient);
        (moved, moved.dot(gradient))
    })
}

/// Angle between the arm's long axis (z of {P}) and z of {B}, rad, from its sine and cosine.
fn elevation<T: Real>(rotation: &Matrix3<T>) -> T {
    let (x, y, z) = (rotation.m13, rotation.m23, rotation.m33);
    (x * x + y * y).root().atan2(z)
}
