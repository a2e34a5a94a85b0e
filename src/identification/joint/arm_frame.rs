//! The features φ of a moving joint centre: the arm's direction and its torsion, from the rotations of the poses alone.
//! Nothing here depends on the choice of axes in {B} or about the arm in {P}.

use crate::identification::excitation::MeanRotation;
use crate::kinematics::rotation::{nearest_attitude, rotation_of};
use crate::linear_algebra::{column, triad, unit};
use crate::scalar::Real;
use nalgebra::{Matrix3, Vector3};

/// Components of φ that are shown and kept: three of the arm's direction, two quadratic, torsion.
pub const SHOWN_FEATURES: usize = 6;

/// All components of φ: the two trefoils as well, x³ - 3 x y² and 3 x² y - y³ of the tilt. Left out, C takes what they explain:
/// before they were in, `cargo study shoulder` gave 1.16 mm across the arm on the thorax instead of 0.90. Over a disc of tilts they
/// are orthogonal to the components of the direction: not showing them takes nothing from the path but themselves (`cargo study
/// free-motion` judges it as it is shown).
pub const FEATURES: usize = SHOWN_FEATURES + 2;

/// φ of one rotation, rad, rad² and rad³.
pub type Features<T> = [T; FEATURES];

/// The frame of the features.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmFrame<T> {
    /// R̄: mean rotation of the poses that identified, from {P} to {B}.
    mean: Matrix3<T>,
    /// h = R̄ a: the arm's mean direction in {B}; a is the normal of the platform's plane, z of {P}.
    home: Vector3<T>,
    /// Two axes across h.
    across: [Vector3<T>; 2],
}

/// A rotation as the arm's direction and torsion.
struct Arm<T> {
    /// d = R a.
    direction: Vector3<T>,
    /// e1·d, e2·d.
    tilt: [T; 2],
    /// Vector and scalar of the quaternion of R R̄ᵀ.
    vector: Vector3<T>,
    scalar: T,
}

impl<T: Real> ArmFrame<T> {
    /// The frame of a set of poses.
    pub fn new(rotations: &MeanRotation<T>) -> Self {
        let mean = nearest_rotation(rotations.sum());
        Self::of_mean(mean)
    }

    /// The frame about a mean rotation.
    pub(super) fn of_mean(mean: Matrix3<T>) -> Self {
        let home = column(&mean, 2);
        // Any axis that is not along h: the features do not depend on which.
        let other = if home.x.abs() < T::of(0.5) { Vector3::x() } else { Vector3::y() };
        let axes = triad(&home, &other);
        Self { mean, home, across: [column(&axes, 1), column(&axes, 2)] }
    }

    /// R̄.
    pub fn mean(&self) -> &Matrix3<T> {
        &self.mean
    }

    /// h, the arm's mean direction in {B}.
    pub fn home(&self) -> &Vector3<T> {
        &self.home
    }

    /// Two axes across h, in {B}.
    pub fn across(&self) -> &[Vector3<T>; 2] {
        &self.across
    }

    /// Tilt across h (two components) and torsion of a rotation, rad.
    pub fn tilt_and_torsion(&self, rotation: &Matrix3<T>) -> ([T; 2], T) {
        let Arm { tilt, vector, scalar, .. } = self.arm(rotation);
        (tilt, vector.dot(&self.home).atan2(scalar) * T::of(2.0))
    }

    #[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    fn arm(&self, rotation: &Matrix3<T>) -> Arm<T> {
        let direction = column(rotation, 2);
        let [e1, e2] = &self.across;
        let turn = nearest_attitude(&(rotation * self.mean.transpose()));
        let sign = if turn.w < T::zero() { -T::one() } else { T::one() };
        let vector = Vector3::new(turn.i, turn.j, turn.k) * sign;
        Arm { direction, tilt: [e1.dot(&direction), e2.dot(&direction)], vector, scalar: turn.w * sign }
    }

    /// φ = (d - h, x² - y², 2 x y, τ, x³ - 3 x y², 3 x² y - y³): x, y the arm's direction across h, τ its twist about h from the
    /// mean rotation.
    pub fn features(&self, rotation: &Matrix3<T>) -> Features<T> {
        self.features_of(&self.arm(rotation))
    }

    /// ∂φ/∂ω for a small rotation ω of the pose, axes of {B}: one row a feature.
    pub fn gradients(&self, rotation: &Matrix3<T>) -> [Vector3<T>; FEATURES] {
        self.gradients_of(&self.arm(rotation))
    }

    /// Both.
    pub fn features_and_gradients(&self, rotation: &Matrix3<T>) -> (Features<T>, [Vector3<T>; FEATURES]) {
        let arm = self.arm(rotation);
        (self.features_of(&arm), self.gradients_of(&arm))
    }

    #[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    fn features_of(&self, arm: &Arm<T>) -> Features<T> {
        let Arm { direction, tilt: [x, y], vector, scalar } = *arm;
        let d = direction - self.home;
        let two = T::of(2.0);
        let torsion = vector.dot(&self.home).atan2(scalar) * two;
        let (quadratic, mixed) = (x * x - y * y, x * y * two);
        let trefoil = [x * quadratic - y * mixed, x * mixed + y * quadratic];
        [d.x, d.y, d.z, quadratic, mixed, torsion, trefoil[0], trefoil[1]]
    }

    fn gradients_of(&self, arm: &Arm<T>) -> [Vector3<T>; FEATURES] {
        let Arm { direction, tilt: [x, y], vector, scalar } = *arm;
        let two = T::of(2.0);
        let [dx, dy] = self.across.map(|axis| direction.cross(&axis));
        // Of the quaternion (w, v) of R R̄ᵀ: δw = -ω·v / 2, δ(v·h) = ω·(w h + v × h) / 2.
        let along = vector.dot(&self.home);
        let (quadratic, mixed, three) = (x * x - y * y, x * y * two, T::of(3.0));
        let of_along = self.home * scalar + vector.cross(&self.home);
        let torsion = (of_along * scalar + vector * along) * (T::one() / (scalar * scalar + along * along));
        [
            direction.cross(&Vector3::x()),
            direction.cross(&Vector3::y()),
            direction.cross(&Vector3::z()),
            (dx * x - dy * y) * two,
            (dx * y + dy * x) * two,
            torsion,
            (dx * quadratic - dy * mixed) * three,
            (dx * mixed + dy * quadratic) * three,
        ]
    }
}

/// Steps of Newton's iteration to the nearest rotation. From poses within 60 degrees of their mean, five reach
/// rounding.
const POLAR_STEPS: usize = 12;

/// The rotation nearest to a sum of rotations: the orthogonal polar factor, by Newton's iteration X ← (X + X⁻ᵀ) / 2
/// (Higham 1986). The identity's axes along the sum's where that is singular.
fn nearest_rotation<T: Real>(sum: &Matrix3<T>) -> Matrix3<T> {
    let scale = sum.norm_squared().root();
    let mut x = sum * (T::of(3.0).root() / scale);
    for _ in 0..POLAR_STEPS {
        let [a, b, c] = [column(&x, 0), column(&x, 1), column(&x, 2)];
        // The columns of X⁻ᵀ det X are cross products.
        let (bc, ca, ab) = (b.cross(&c), c.cross(&a), a.cross(&b));
        let by_determinant = T::one() / a.dot(&bc);
        if !by_determinant.is_a_number() {
            break;
        }
        x = (x + Matrix3::from_columns(&[bc, ca, ab]) * by_determinant) * T::of(0.5);
    }
    // What rounding has left.
    let orthonormal = triad(&column(&x, 0), &column(&x, 1));
    let is_finite = unit(&column(&orthonormal, 2)).x.is_a_number();
    if is_finite { rotation_of(&nearest_attitude(&orthonormal)) } else { Matrix3::identity() }
}
