//! A joint centre that moves with the arm: O(R) = O0 + A φ(R), with a scatter of its own.
//!
//! One direction is invisible to lengths (a gauge freedom): C and O0 along the arm by 1 mm equal A = identity by 1
//! mm/rad. It is fixed by a prior on T = tr(A)/3 of the direction's part of A, and by a prior on C from poses in which
//! the shoulder blade was held.

use super::arm_frame::{ArmFrame, FEATURES, Features, SHOWN_FEATURES};
use super::scatter::Scatter;
use crate::identification::parameters::Equations;
use crate::linear_algebra::non_negative_root;
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// Unknowns of A.
pub const MAX_JOINT: usize = 3 * FEATURES;

/// Of them those that the poses determine; the trefoils' are mostly what their prior says.
pub const FREE_OF_JOINT: usize = 3 * SHOWN_FEATURES;

/// 1σ of the last columns of A along each axis (assumed). The torsion's, mm/rad: the shoulder blade follows a twist of the arm
/// little, and few poses hardly tell it from C across the arm (30 poses, one phase, thorax: 1.30 mm across with this prior, 1.40
/// without; `cargo study shoulder`). The trefoils', mm/rad³: 0.7 mm at 45 degrees of tilt.
const TORSION_AND_TREFOILS: [f64; 3] = [3.0, 2.0, 2.0];

/// The isotropic part of A against the norm N of the rest, mm/rad: T = SLOPE max(N - FROM, 0), with a standard
/// deviation of √((SHARE N)² + FLOOR²). Measured over three anatomies (bone pins; scapulohumeral rhythm of de Groot and
/// Brand; a musculoskeletal model) and three mountings of the base.
const SLOPE: f64 = 0.29;
const FROM: f64 = 1.5;
const SHARE: f64 = 0.08;
const FLOOR: f64 = 0.5;

/// What moves the centre along the arm as the arm tilts is at least this share of N in those living shoulders (0.63 to
/// 0.97). The rule holds for as much of N as that goes with. Of the remainder beyond UNRULED, mm/rad, only the order of
/// magnitude is known of T: as large as that itself, to either side. A centre that drifts along the arm, or with its
/// direction, is all remainder.
const SHARE_ALONG: f64 = 0.6;
const UNRULED: f64 = 1.0;

/// How far the arm lies askew to the platform's normal, which is taken for its direction: 1σ about each axis across it, rad (5
/// degrees, assumed; no length shows it).
const ASKEW_RAD: f64 = 0.087;

/// By how much C then goes across the arm, as a share of N times that angle. The centre moves by A (R a), a askew by δ to the
/// normal. The share of T in A R δ is the motion of a C that is off by T δ; the rest is so in part: in all 0.37 N, rms over random
/// matrices A with the T of the rule above. With it a 99 % region covers 98 to 100 % of the path of people with cuffs askew by 5
/// and 8 degrees (`cargo study shoulder`).
const ASKEW_SHARE: f64 = 0.37;

/// What φ does not explain is no white scatter, and biases C and A as well: their variances are this many times those
/// of the fit. With it and [`LACK_OF_FIT`] a 99 % region covers 98.6 to 100.0 % of the path (`cargo study shoulder --seed 6`,
/// `--seed 7`; chosen on seed 1).
const VARIANCE_FACTOR: f64 = 1.5;

/// Of the scatter's variance, what is taken for motion that φ does not explain.
const LACK_OF_FIT: f64 = 0.64;

/// Of the correlation of a pose's scatter with that of the next, what chance makes of none: two standard deviations with 60
/// poses.
const BY_CHANCE: f64 = 0.15;
/// The largest correlation that is reckoned with.
const MAX_CORRELATION: f64 = 0.8;

/// How much larger the variance of a mean is where each value is correlated with the next like this, (1 + ρ) / (1 - ρ) of a
/// first-order autoregression (Bartlett 1946); 1 where chance explains the correlation.
pub fn persistence<T: Real>(correlation: T) -> T {
    let rho = (correlation - T::of(BY_CHANCE)).max(T::zero()).min(T::of(MAX_CORRELATION));
    (T::one() + rho) / (T::one() - rho)
}

/// How the joint centre moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovingCentre<T> {
    /// The frame of φ.
    pub frame: ArmFrame<T>,
    /// The columns of A, mm per unit of a feature.
    pub gains: [Vector3<T>; FEATURES],
    /// The scatter of a pose's own centre.
    pub scatter: Scatter<T>,
    /// By how much the variances of the fit are larger because the scatter of a pose persists in the next; 1 where it does not.
    pub persistence: T,
}

impl<T: Real> MovingCentre<T> {
    /// A centre that does not move yet.
    pub fn new(frame: ArmFrame<T>) -> Self {
        Self { frame, gains: [Vector3::zeros(); FEATURES], scatter: Scatter::default(), persistence: T::one() }
    }

    /// A φ(R): displacement of the centre from O0 at a rotation ({P} to {B}), mm.
    pub fn displacement_mm(&self, rotation: &Matrix3<T>) -> Vector3<T> {
        self.displacement_of(&self.frame.features(rotation))
    }

    #[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    fn displacement_of(&self, features: &Features<T>) -> Vector3<T> {
        self.gains.iter().zip(features).fold(Vector3::zeros(), |sum, (gain, feature)| sum + gain * *feature)
    }

    /// A ∂φ/∂ω, mm/rad.
    pub fn turning(&self, rotation: &Matrix3<T>) -> Matrix3<T> {
        self.turning_of(&self.frame.gradients(rotation))
    }

    /// Both.
    pub fn displacement_mm_and_turning(&self, rotation: &Matrix3<T>) -> (Vector3<T>, Matrix3<T>) {
        let (features, gradients) = self.frame.features_and_gradients(rotation);
        (self.displacement_of(&features), self.turning_of(&gradients))
    }

    fn turning_of(&self, gradients: &[Vector3<T>; FEATURES]) -> Matrix3<T> {
        self.gains.iter().zip(gradients).fold(Matrix3::zeros(), |sum, (gain, row)| sum + gain * row.transpose())
    }

    /// T and what the rule says of it from the rest of A: mean and variance. mm/rad.
    fn isotropic_part(&self) -> (T, T, T) {
        let (isotropic, rest, norm) = self.direction_part();
        // Along the arm, as it tilts: hᵀ A across h.
        let home = self.frame.home();
        let along = rest.tr_mul(home);
        let by_tilt = non_negative_root((along - home * along.dot(home)).norm_squared());
        let ruled = norm.min(by_tilt * T::of(1.0 / SHARE_ALONG));
        let expected = (ruled - T::of(FROM)).max(T::zero()) * T::of(SLOPE);
        let unruled = (norm - ruled - T::of(UNRULED)).max(T::zero());
        let share = norm * T::of(SHARE);
        (isotropic, expected, share * share + unruled * unruled + T::of(FLOOR * FLOOR))
    }

    /// T, the rest of the direction's part of A, and N. mm/rad.
    fn direction_part(&self) -> (T, Matrix3<T>, T) {
        let [a, b, c, ..] = &self.gains;
        let direction = Matrix3::from_columns(&[*a, *b, *c]);
        let isotropic = direction.trace() * T::of(1.0 / 3.0);
        let rest = direction - Matrix3::from_diagonal_element(isotropic);
        (isotropic, rest, non_negative_root(rest.norm_squared()))
    }

    /// Variance of the centre along each axis across the arm, mm², for an arm that lies askew to the platform's normal.
    pub fn askew_mm2(&self) -> T {
        let (_, _, norm) = self.direction_part();
        let sigma = norm * T::of(ASKEW_SHARE * ASKEW_RAD);
        sigma * sigma
    }

    /// The prior on T, one more equation (A₁₁ + A₂₂ + A₃₃)/3 = μ ± σ, and on the columns of torsion and trefoils, times the
    /// noise's variance, mm².
    pub fn add_prior(&self, equations: &mut Equations<T>, first: usize, variance_mm2: T) {
        let column = FEATURES - TORSION_AND_TREFOILS.len();
        for ((column, gain), sigma) in self.gains.iter().enumerate().skip(column).zip(TORSION_AND_TREFOILS) {
            let sigma = T::of(sigma);
            let weight = variance_mm2 / (sigma * sigma);
            for (unknown, gain) in (first + 3 * column..).zip(gain) {
                equations.add_to_entry(unknown, unknown, weight);
                equations.add_to_gradient(unknown, -*gain * weight);
                equations.add_squares(*gain * *gain * weight);
            }
        }
        let (isotropic, expected, variance) = self.isotropic_part();
        let weight = variance_mm2 / variance;
        let third = T::of(1.0 / 3.0);
        let residual = expected - isotropic;
        // Unknown 3 j + i is row i of column j: the diagonal is 0, 4, 8.
        for i in [0, 4, 8] {
            for j in [0, 4, 8] {
                if j <= i {
                    equations.add_to_entry(first + i, first + j, weight * third * third);
                }
            }
            equations.add_to_gradient(first + i, weight * third * residual);
        }
        equations.add_squares(weight * residual * residual);
    }

    /// Variance that φ does not explain, along each axis, mm²: 0.64 of the scatter's.
    pub fn lack_of_fit_mm2(&self) -> T {
        self.scatter.variance_mm2() * T::of(LACK_OF_FIT)
    }

    /// By how much the covariance of the fit is widened for what φ does not explain, and for a scatter that persists.
    pub fn variance_factor(&self) -> T {
        T::of(VARIANCE_FACTOR) * self.persistence
    }

    /// Moves A by a step.
    pub fn apply(&mut self, step: &[T]) {
        for (gain, step) in self.gains.iter_mut().zip(step.chunks_exact(3)) {
            if let [x, y, z] = step {
                *gain += Vector3::new(*x, *y, *z);
            }
        }
    }
}
