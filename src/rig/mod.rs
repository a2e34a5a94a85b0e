//! Every constant of the machine, in one place: a [`Rig`] is a value, and another machine is another value.
//!
//! Frames: {B} is fixed to the base, its z axis points from the base towards the moving platform. Where the attachment
//! points have a tolerance, {B} is the frame best fitted to the points as they are. {P} is fixed to the moving
//! platform.

mod error;
mod named;
mod parts;

pub use error::RigError;
pub use named::ASSUMED_BASE_RADIUS_MM;
pub use parts::{CableEnds, Correction, Drum, Parameters, Pulley, Tolerance};

use crate::linear_algebra::{non_negative_root, triad};
use crate::scalar::Real;
use nalgebra::Vector3;

/// Number of cables, of base attachment points and of platform end-points.
pub const CABLES: usize = 6;
/// Base attachment points B1..B3, platform end-points P1..P3, platform edges p12, p23, p31.
pub const POINTS: usize = 3;

/// For each end-point P1..P3 the two attachment points (from 0) that its two cables run to, in cable order:
/// L1 = P1 B1, L2 = P1 B2, L3 = P2 B2, L4 = P2 B3, L5 = P3 B3, L6 = P3 B1 (Eq. 2, 3, 5, 6, 8, 9).
pub const ATTACHMENTS: [[usize; 2]; POINTS] = [[0, 1], [1, 2], [2, 0]];

/// For each platform edge p12, p23, p31 its two end-points (from 0), Eq. 10-12.
pub const EDGE_ENDS: [[usize; 2]; POINTS] = [[0, 1], [1, 2], [2, 0]];

/// Two ends nearer than this are one point, mm.
const MIN_APART_MM: f64 = 1e-3;

/// The machine: geometry, drive and limits. Made by [`Rig::new`] or one of the named rigs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rig<T> {
    base_mm: [Vector3<T>; POINTS],
    edges_mm: [T; POINTS],
    cables: Option<[CableEnds<T>; CABLES]>,
    drum: Drum<T>,
    length_noise_mm: T,
    sample_noise_mm: T,
    nominal: Parameters<T>,
    tolerance: Tolerance<T>,
    correction: Option<Correction<T>>,
}

impl<T: Real> Rig<T> {
    /// A rig from its constants, checked.
    ///
    /// * `base_mm`: attachment points B1..B3 in {B}, mm. They need not be equilateral nor at z = 0; the platform lies
    ///   on their +z side.
    /// * `edges_mm`: platform edges p12, p23, p31, mm.
    /// * `length_noise_mm`: standard deviation of one cable length, mm, however many samples it averages.
    /// * `nominal`: where the centre is expected (the paper's skin-based start), mm.
    ///
    /// # Errors
    /// [`RigError`] names the first constant that is impossible.
    pub fn new(
        base_mm: [Vector3<T>; POINTS],
        edges_mm: [T; POINTS],
        drum: Drum<T>,
        length_noise_mm: T,
        nominal: Parameters<T>,
    ) -> Result<Self, RigError> {
        let rig = Self {
            base_mm,
            edges_mm,
            cables: None,
            drum,
            length_noise_mm,
            sample_noise_mm: T::zero(),
            nominal,
            tolerance: Tolerance::exact(),
            correction: None,
        };
        rig.check()?;
        Ok(rig)
    }

    /// A rig whose cables have ends of their own, and may run over pulleys. `cables`: the platform's ends in any frame
    /// fixed to the platform, numbered like the 3-3 machine's (see [`ATTACHMENTS`]).
    ///
    /// # Errors
    /// [`RigError`] names the first constant that is impossible.
    pub fn with_cables(
        cables: [CableEnds<T>; CABLES],
        drum: Drum<T>,
        length_noise_mm: T,
        nominal: Parameters<T>,
    ) -> Result<Self, RigError> {
        let finite = |point: &Vector3<T>| point.iter().all(|x| x.is_a_number());
        for cable in &cables {
            if !(finite(&cable.base_mm) && finite(&cable.end_mm)) {
                return Err(RigError::NotFinite);
            }
            let Pulley { radius_mm, axis } = &cable.pulley;
            let is_direction = (axis.norm_squared() - T::one()).abs() < T::of(1e-3);
            if !(*radius_mm >= T::zero() && *radius_mm < T::of(1e3) && is_direction) {
                return Err(RigError::PulleyImpossible);
            }
        }
        let apart = |a: &Vector3<T>, b: &Vector3<T>| (a - b).norm_squared() > T::of(MIN_APART_MM * MIN_APART_MM);
        for (i, one) in cables.iter().enumerate() {
            for other in cables.iter().skip(i + 1) {
                if !(apart(&one.base_mm, &other.base_mm) || apart(&one.end_mm, &other.end_mm)) {
                    return Err(RigError::EndsCoincide);
                }
            }
        }
        // The nearest triangles: each point the middle of the two ends that the 3-3 machine has in one.
        let [c1, c2, c3, c4, c5, c6] = &cables;
        let half = T::of(0.5);
        let middle = |a: &Vector3<T>, b: &Vector3<T>| (a + b) * half;
        let base_mm =
            [middle(&c6.base_mm, &c1.base_mm), middle(&c2.base_mm, &c3.base_mm), middle(&c4.base_mm, &c5.base_mm)];
        let [p1, p2, p3] =
            [middle(&c1.end_mm, &c2.end_mm), middle(&c3.end_mm, &c4.end_mm), middle(&c5.end_mm, &c6.end_mm)];
        let edges_mm = [p2 - p1, p3 - p2, p1 - p3].map(|edge| edge.norm_squared().root());
        let mut rig = Self::new(base_mm, edges_mm, drum, length_noise_mm, nominal)?;
        // The ends in {P}, which is defined by the nearest triangle.
        let side = if rig.is_counterclockwise() { T::one() } else { -T::one() };
        let axes = triad(&(p2 - p1), &((p3 - p1) * side));
        let in_platform = |cable: CableEnds<T>| CableEnds { end_mm: axes.tr_mul(&(cable.end_mm - p1)), ..cable };
        rig.cables = Some(cables.map(in_platform));
        Ok(rig)
    }

    /// The same rig, known with this tolerance.
    ///
    /// # Errors
    /// [`RigError::ToleranceImpossible`].
    pub fn with_tolerance(mut self, tolerance: Tolerance<T>) -> Result<Self, RigError> {
        if !tolerance.is_possible() {
            return Err(RigError::ToleranceImpossible);
        }
        self.tolerance = tolerance;
        Ok(self)
    }

    /// The same rig with what commissioning has found of its encoders and drums.
    ///
    /// # Errors
    /// [`RigError::CorrectionImpossible`].
    pub fn with_correction(mut self, correction: Correction<T>) -> Result<Self, RigError> {
        if !correction.is_possible() {
            return Err(RigError::CorrectionImpossible);
        }
        self.correction = Some(correction);
        Ok(self)
    }

    /// The same rig, the noise of whose lengths has two parts, 1σ, mm.
    ///
    /// * `length_noise_mm`: what does not average over the samples of a held pose (friction, hysteresis), positive.
    /// * `sample_noise_mm`: what each sample has beyond that (white noise, encoder quantisation), which does average; 0 = none.
    ///
    /// # Errors
    /// [`RigError::NoiseNotPositive`].
    pub fn with_noise(mut self, length_noise_mm: T, sample_noise_mm: T) -> Result<Self, RigError> {
        let is_possible = |noise: T| noise >= T::zero() && noise.is_a_number();
        if !(is_possible(sample_noise_mm) && is_possible(length_noise_mm) && length_noise_mm > T::zero()) {
            return Err(RigError::NoiseNotPositive);
        }
        (self.length_noise_mm, self.sample_noise_mm) = (length_noise_mm, sample_noise_mm);
        Ok(self)
    }

    fn check(&self) -> Result<(), RigError> {
        let [b1, b2, b3] = self.base_mm;
        let [p12, p23, p31] = self.edges_mm;
        let drum = &self.drum;
        let all_finite = self.base_mm.iter().flat_map(|b| b.iter()).all(|x| x.is_a_number())
            && self.edges_mm.iter().chain(&drum.home_length_mm).all(|x| x.is_a_number())
            && self.nominal.to_array().iter().all(|x| x.is_a_number())
            && [drum.radius_mm, drum.counts_per_turn, drum.fastest_mm_per_s, self.length_noise_mm]
                .iter()
                .all(|x| x.is_a_number());
        if !all_finite {
            return Err(RigError::NotFinite);
        }
        let normal = (b2 - b1).cross(&(b3 - b1));
        let longest = (b2 - b1).norm_squared().max((b3 - b1).norm_squared()).max((b3 - b2).norm_squared());
        // Twice the triangle's area against its longest side squared: 0.87 when equilateral.
        let twice_area = normal.norm_squared().root();
        if !(twice_area > longest * T::of(1e-3)) {
            return Err(RigError::BaseCollapsed);
        }
        if normal.z.abs() < twice_area * T::of(1e-2) {
            return Err(RigError::BaseOnEdge);
        }
        // 1e-3 of slack: a platform flatter than that has no well-defined plane.
        let slack = (p12 + p23 + p31) * T::of(1e-3);
        let triangle = |a: T, b: T, c: T| a > T::zero() && a + slack < b + c;
        if !(triangle(p12, p23, p31) && triangle(p23, p31, p12) && triangle(p31, p12, p23)) {
            return Err(RigError::PlatformCollapsed);
        }
        let positive = |x: &T| *x > T::zero();
        if !(positive(&drum.radius_mm)
            && positive(&drum.counts_per_turn)
            && positive(&drum.fastest_mm_per_s)
            && drum.home_length_mm.iter().all(positive))
        {
            return Err(RigError::DrumNotPositive);
        }
        if !positive(&self.length_noise_mm) {
            return Err(RigError::NoiseNotPositive);
        }
        if !self.nominal.radii_mm.iter().all(positive) {
            return Err(RigError::RadiusNotPositive);
        }
        Ok(())
    }

    /// Attachment points B1..B3 in {B}, mm.
    pub fn base_mm(&self) -> &[Vector3<T>; POINTS] {
        &self.base_mm
    }

    /// Platform edges p12, p23, p31, mm.
    pub fn edges_mm(&self) -> &[T; POINTS] {
        &self.edges_mm
    }

    /// The ends of each cable, where they are not those of the two triangles; the platform's in {P}.
    pub fn cables(&self) -> Option<&[CableEnds<T>; CABLES]> {
        self.cables.as_ref()
    }

    /// How well the encoder offsets are known in a run that states them to `stated_mm`, 1σ, mm: homing is never better than the
    /// rig's tolerance.
    pub fn offset_prior_mm(&self, stated_mm: T) -> T {
        stated_mm.max(self.tolerance.offset_mm)
    }

    /// How well the machine is known, 1σ.
    pub fn tolerance(&self) -> &Tolerance<T> {
        &self.tolerance
    }

    /// What commissioning has found of the encoders and drums.
    pub fn correction(&self) -> Option<&Correction<T>> {
        self.correction.as_ref()
    }

    /// The drive: counts to lengths.
    pub fn drum(&self) -> &Drum<T> {
        &self.drum
    }

    /// Standard deviation of one cable length, mm: of what does not average over the samples of a held pose.
    pub fn length_noise_mm(&self) -> T {
        self.length_noise_mm
    }

    /// Standard deviation of what a single sample has beyond that, mm; 0 where it is not known apart.
    pub fn sample_noise_mm(&self) -> T {
        self.sample_noise_mm
    }

    /// Where the centre is expected before anything is known, mm: the paper's skin-based start.
    pub fn nominal(&self) -> &Parameters<T> {
        &self.nominal
    }

    /// The attachment points are numbered counterclockwise as the platform sees them, from +z of {B}.
    fn is_counterclockwise(&self) -> bool {
        let [b1, b2, b3] = &self.base_mm;
        (b2.x - b1.x) * (b3.y - b1.y) > (b2.y - b1.y) * (b3.x - b1.x)
    }

    /// The end-points in {P}, mm: P1 at the origin, P2 on the x axis, P3 in the xy plane on the side that makes the
    /// z axis of {P} point away from the base at home.
    pub fn platform_mm(&self) -> [Vector3<T>; POINTS] {
        let [p12, p23, p31] = self.edges_mm;
        let x = (p12 * p12 + p31 * p31 - p23 * p23) / (p12 + p12);
        let y = non_negative_root(p31 * p31 - x * x);
        let y = if self.is_counterclockwise() { y } else { -y };
        let zero = T::zero();
        [Vector3::zeros(), Vector3::new(p12, zero, zero), Vector3::new(x, y, zero)]
    }
}
