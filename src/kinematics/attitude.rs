//! The platform's rotation from the cable lengths, once the joint centre is known: Gauss-Newton on three angles.
//!
//! Six lengths for three angles: one cable may be left out. It also solves poses that the forward kinematics cannot
//! (beyond their singularity, or with a bad length).

use super::cable_length::CableLengths;
use super::geometry::Geometry;
use super::length_jacobian::{JointCentre, LengthJacobian};
use super::rotation::{nearest_attitude, rotation_of, turned};
use super::trilateration::trilaterate;
use crate::linear_algebra::{rounding, solve_positive_definite, triad};
use crate::rig::CABLES;
use crate::scalar::Real;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// Maximum number of Gauss-Newton steps from one start.
const MAX_STEPS: usize = 12;

/// So many of them in one call: 6 000 cycles of a Cortex-M4F.
const STEPS_A_CALL: usize = 3;

/// Assembly modes of a pose whose joint centre is known: one bit for each of two end-points.
const ASSEMBLY_MODES: u8 = 4;

/// Largest turn from sample to sample that a single step follows, rad: 1100 degrees a second at 1 kHz.
const MAX_FOLLOWED_RAD: f64 = 0.02;

/// Which cables take part: bit k is cable k + 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CableSet(u8);

impl CableSet {
    /// All six cables.
    pub const ALL: Self = Self((1 << CABLES) - 1);

    /// All but the cable with this index, from 0.
    pub const fn all_but(index: usize) -> Self {
        Self(Self::ALL.0 & !(1 << index))
    }

    /// Does the cable with this index, from 0, take part?
    pub const fn has(self, index: usize) -> bool {
        self.0 & (1 << index) != 0
    }
}

/// A rotation of the platform that fits the lengths.
#[derive(Clone, Copy, Debug)]
pub struct AttitudeFit<T> {
    /// Rotation from {P} to {B}.
    pub attitude: UnitQuaternion<T>,
    /// Sum of the squared length residuals of the cables that take part, mm².
    pub squares_mm2: T,
}

/// Gauss-Newton from one start, a few steps a call, for callers that must not do all of it at once.
#[derive(Clone, Copy, Debug)]
pub struct AttitudeTrack<T> {
    attitude: UnitQuaternion<T>,
    steps_left: usize,
}

impl<T: Real> AttitudeTrack<T> {
    /// No step has been taken yet.
    pub const fn new(start: UnitQuaternion<T>) -> Self {
        Self { attitude: start, steps_left: MAX_STEPS }
    }

    /// The next steps; the fit when they have settled, or that they do not. The lengths are those of the first call.
    pub fn advance(
        &mut self,
        solver: &AttitudeSolver<'_, T>,
        lengths: &CableLengths<T>,
        cables: CableSet,
    ) -> Option<Option<AttitudeFit<T>>> {
        let steps = self.steps_left.min(STEPS_A_CALL);
        self.steps_left -= steps;
        match solver.steps(&mut self.attitude, lengths, cables, steps) {
            Steps::Settled(fit) => Some(Some(fit)),
            Steps::Singular => Some(None),
            Steps::Going => (self.steps_left == 0).then_some(None),
        }
    }
}

/// The search for a rotation without a start, a few steps a call.
#[derive(Clone, Copy, Debug)]
pub struct AttitudeSearch<T> {
    next_mode: u8,
    /// The mode under way.
    under_way: Option<AttitudeTrack<T>>,
    best: Option<AttitudeFit<T>>,
}

impl<T: Real> AttitudeSearch<T> {
    /// Nothing was tried yet.
    pub const fn new() -> Self {
        Self { next_mode: 0, under_way: None, best: None }
    }

    /// Goes on with the next mode: its start, then a few Gauss-Newton steps a call; true when the last mode is through. The
    /// lengths are those of the first call.
    pub fn advance(&mut self, solver: &AttitudeSolver<'_, T>, lengths: &CableLengths<T>, cables: CableSet) -> bool {
        let Some(mut track) = self.under_way.take() else {
            self.under_way = Some(AttitudeTrack::new(solver.start_in(self.next_mode, lengths, cables)));
            return false;
        };
        match track.advance(solver, lengths, cables) {
            None => {
                self.under_way = Some(track);
                return false;
            }
            Some(Some(fit)) if self.best.is_none_or(|best| fit.squares_mm2 < best.squares_mm2) => {
                self.best = Some(fit);
            }
            Some(_) => {}
        }
        self.next_mode += 1;
        self.next_mode >= ASSEMBLY_MODES
    }

    /// The best of the modes tried; `None` when none has converged.
    pub const fn best(&self) -> Option<AttitudeFit<T>> {
        self.best
    }
}

impl<T: Real> Default for AttitudeSearch<T> {
    fn default() -> Self {
        Self::new()
    }
}

/// What came of some steps.
enum Steps<T> {
    Settled(AttitudeFit<T>),
    Going,
    Singular,
}

/// Finds the rotation of a machine's platform about a known joint centre.
#[derive(Clone, Copy, Debug)]
pub struct AttitudeSolver<'a, T> {
    /// The machine's geometry.
    pub geometry: &'a Geometry<T>,
    /// The joint centre in both bodies.
    pub centre: &'a JointCentre<T>,
}

impl<T: Real> AttitudeSolver<'_, T> {
    /// Best rotation for the cables in `cables` from a start nearby: for tracking, the rotation of the sample before.
    ///
    /// `None` when the iteration meets a singularity or does not converge.
    pub fn track(
        &self,
        start: UnitQuaternion<T>,
        lengths: &CableLengths<T>,
        cables: CableSet,
    ) -> Option<AttitudeFit<T>> {
        let mut attitude = start;
        match self.steps(&mut attitude, lengths, cables, MAX_STEPS) {
            Steps::Settled(fit) => Some(fit),
            Steps::Going | Steps::Singular => None,
        }
    }

    /// So many steps at most.
    #[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    fn steps(
        &self,
        attitude: &mut UnitQuaternion<T>,
        lengths: &CableLengths<T>,
        cables: CableSet,
        most: usize,
    ) -> Steps<T> {
        // Single precision: 3e-4 rad. The error after a step is about its square.
        let settled = T::default_epsilon();
        for _ in 0..most {
            let Some((fit, turn)) = self.step(attitude, lengths, cables) else { return Steps::Singular };
            if turn.norm_squared() <= settled {
                return Steps::Settled(fit);
            }
            *attitude = fit.attitude;
        }
        Steps::Going
    }

    /// The rotation by a single step from that of the sample before: for a control loop. The error that is left is about the
    /// square of the turn from sample to sample: 0.7 µrad at 50 degrees a second, 12 µrad at 200, with 1000 samples a second;
    /// the next sample takes it away.
    ///
    /// `None` at a singularity, and when the platform has turned by more than 20 mrad: [`track`](Self::track) goes on then.
    #[cfg_attr(feature = "ccm", inline(never), unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    pub fn follow(&self, before: &UnitQuaternion<T>, lengths: &CableLengths<T>) -> Option<AttitudeFit<T>> {
        let (fit, turn) = self.step(before, lengths, CableSet::ALL)?;
        (turn.norm_squared() <= T::of(MAX_FOLLOWED_RAD * MAX_FOLLOWED_RAD)).then_some(fit)
    }

    /// One Gauss-Newton step: where it leads, with the squares there by the linear model, and how far it turns.
    // Inlined: 1 982 estimated cycles a followed sample otherwise, 1 752 with it (`cargo cycles`).
    #[inline(always)]
    fn step(
        &self,
        attitude: &UnitQuaternion<T>,
        lengths: &CableLengths<T>,
        cables: CableSet,
    ) -> Option<(AttitudeFit<T>, Vector3<T>)> {
        let jacobian = LengthJacobian::new(self.geometry, self.centre, &rotation_of(attitude), lengths);
        let mut information = Matrix3::zeros();
        let mut gradient = Vector3::zeros();
        let mut squares_mm2 = T::zero();
        for (cable, row) in jacobian.rows.iter().enumerate() {
            if cables.has(cable) {
                let g = &row.rotation_mm;
                // One triangle is enough: 39 instructions of 877 less a sample (`cargo cycles`).
                information.m11 += g.x * g.x;
                information.m21 += g.y * g.x;
                information.m31 += g.z * g.x;
                information.m22 += g.y * g.y;
                information.m32 += g.z * g.y;
                information.m33 += g.z * g.z;
                gradient += g * row.residual_mm;
                squares_mm2 += row.residual_mm * row.residual_mm;
            }
        }
        let turn = solve_positive_definite(&information, &gradient, rounding())?;
        // The squares after the step by the linear model, without another evaluation.
        let squares_mm2 = squares_mm2 - gradient.dot(&turn);
        // Not `max`, which is a call of 14 cycles (`cargo cycles`).
        let squares_mm2 = if squares_mm2 > T::zero() { squares_mm2 } else { T::zero() };
        Some((AttitudeFit { attitude: turned(attitude, &turn), squares_mm2 }, turn))
    }

    /// Best rotation without a start: two end-points by trilateration from the known centre and their base points, on
    /// either side of the plane of those; the best of the four assembly modes. `cables` may lack one cable: the two
    /// other end-points serve then. `None` when no mode converges.
    pub fn solve(&self, lengths: &CableLengths<T>, cables: CableSet) -> Option<AttitudeFit<T>> {
        let mut search = AttitudeSearch::new();
        while !search.advance(self, lengths, cables) {}
        search.best()
    }

    /// The rotation that one of the four assembly modes, 0 to 3, begins with.
    pub fn start_in(&self, mode: u8, lengths: &CableLengths<T>, cables: CableSet) -> UnitQuaternion<T> {
        let whole = |i: usize| cables.has(2 * i) && cables.has(2 * i + 1);
        // Two end-points with both cables sound fix the rotation.
        let (i, j) = (if whole(0) { 0 } else { 1 }, if whole(2) { 2 } else { 1 });
        let end_points_mm = self.geometry.end_points_mm();
        let from_centre = |k: usize| end_points_mm[k] - self.centre.in_platform_mm;
        let side = |bit: u8| if mode & bit == 0 { T::one() } else { -T::one() };
        let in_platform = triad(&from_centre(i), &from_centre(j));
        let apex = |k: usize, side: T| self.apex(k, from_centre(k).norm_squared().root(), lengths, side);
        let in_base = triad(&apex(i, side(1)), &apex(j, side(2)));
        nearest_attitude(&(in_base * in_platform.transpose()))
    }

    /// End-point `i` from O, on one `side` (1 or -1) of the plane through O and its two base points: where the spheres
    /// that its two cables and its radius allow meet. When they do not quite meet, a point near: a start to iterate
    /// from. Not finite with O on the base edge's line.
    fn apex(&self, i: usize, radius_mm: T, lengths: &CableLengths<T>, side: T) -> Vector3<T> {
        let (base_mm, mm) = (&self.geometry.base_mm, lengths.as_mm());
        let centres = [&self.centre.in_base_mm, &base_mm[2 * i], &base_mm[2 * i + 1]];
        trilaterate(centres, &[radius_mm, mm[2 * i], mm[2 * i + 1]], side)
    }
}
