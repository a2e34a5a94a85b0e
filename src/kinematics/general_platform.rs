//! The platform's pose where every cable has ends of its own, or runs over a pulley: a 6-6 Stewart-Gough platform.
//!
//! The 3-3 platform of the nearest triangles gives the start and the assembly mode; Newton's method on the pose's six
//! unknowns does the rest (Merlet, Parallel Robots, 2006).

use super::cable_length::CableLengths;
use super::geometry::Geometry;
use super::length_jacobian::{JointCentre, LengthJacobian};
use super::rotation::{nearest_attitude, rotation_of, turned};
use super::stewart_gough::{ForwardKinematics, PlatformError, PlatformPose};
use crate::linear_algebra::NormalEquations;
use crate::rig::Rig;
use crate::scalar::Real;
use nalgebra::{UnitQuaternion, Vector3};

/// Maximum number of Newton steps. From the nearest triangles three or four suffice.
const MAX_STEPS: u8 = 12;

/// Finds the platform's pose from six lengths, for any rig.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlatformSolver<T> {
    three_three: ForwardKinematics<T>,
    geometry: Geometry<T>,
}

impl<T: Real> PlatformSolver<T> {
    /// A solver for `rig`.
    pub fn new(rig: &Rig<T>) -> Self {
        Self { three_three: ForwardKinematics::new(rig), geometry: Geometry::new(rig) }
    }

    /// The geometry of the rig as stated, mm.
    pub fn geometry(&self) -> &Geometry<T> {
        &self.geometry
    }

    /// The platform's pose in the assembly mode of the home pose: no estimate is needed.
    ///
    /// # Errors
    /// [`PlatformError`] when a cable triangle is broken or no regular assembly mode is found.
    pub fn solve(&self, lengths: &CableLengths<T>) -> Result<PlatformPose<T>, PlatformError> {
        let mut search = PlatformSearch::default();
        loop {
            if let Some(found) = search.advance(self, lengths) {
                return found;
            }
        }
    }
}

/// The search for the pose, a step a call: the nearest triangles, then each of Newton's steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlatformSearch<T: Real> {
    newton: Option<Newton<T>>,
}

impl<T: Real> Default for PlatformSearch<T> {
    fn default() -> Self {
        Self { newton: None }
    }
}

impl<T: Real> PlatformSearch<T> {
    /// The next step of the search for the pose with these lengths, always the same ones; `None` while it is not over.
    ///
    /// # Errors
    /// As [`PlatformSolver::solve`].
    pub fn advance(
        &mut self,
        solver: &PlatformSolver<T>,
        lengths: &CableLengths<T>,
    ) -> Option<Result<PlatformPose<T>, PlatformError>> {
        if let Some(newton) = &mut self.newton {
            return newton.step(&solver.geometry, lengths);
        }
        match solver.three_three.solve(lengths) {
            Ok(start) if !solver.geometry.is_three_three => {
                self.newton = Some(Newton::from(&start));
                None
            }
            pose => Some(pose),
        }
    }
}

/// Newton's method on the pose, from a start nearby. Six equations for six unknowns, so the normal equations give
/// Newton's step; digits lost to their squared condition number are recovered by the next step.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Newton<T: Real> {
    start: UnitQuaternion<T>,
    origin_mm: Vector3<T>,
    attitude: UnitQuaternion<T>,
    steps: u8,
}

impl<T: Real> Newton<T> {
    fn from(start: &PlatformPose<T>) -> Self {
        let attitude = nearest_attitude(&start.rotation);
        Self { start: attitude, origin_mm: start.origin_mm, attitude, steps: 0 }
    }

    fn step(
        &mut self,
        geometry: &Geometry<T>,
        lengths: &CableLengths<T>,
    ) -> Option<Result<PlatformPose<T>, PlatformError>> {
        if self.steps >= MAX_STEPS {
            return Some(Err(PlatformError::DoesNotClose));
        }
        self.steps += 1;
        // The turn is about the platform's middle: about P1 translation and rotation would be nearly alike.
        let [p1, p2, p3] = geometry.end_points_mm();
        let middle = (p1 + p2 + p3) * T::of(1.0 / 3.0);
        let rotation = rotation_of(&self.attitude);
        let centre = JointCentre { in_base_mm: self.origin_mm + rotation * middle, in_platform_mm: middle };
        let jacobian = LengthJacobian::new(geometry, &centre, &rotation, lengths);
        let mut equations = NormalEquations::<T, 6, 21>::new(6);
        for row in &jacobian.rows {
            let (u, g) = (&row.translation, &row.rotation_mm);
            equations.add_row(&[u.x, u.y, u.z, g.x, g.y, g.z], row.residual_mm);
        }
        if equations.factor().is_err() {
            return Some(Err(PlatformError::DoesNotClose));
        }
        let [x, y, z, a, b, c] = equations.step();
        let (moved, turn) = (Vector3::new(x, y, z), Vector3::new(a, b, c));
        self.attitude = turned(&self.attitude, &turn);
        let rotation = rotation_of(&self.attitude);
        self.origin_mm = centre.in_base_mm + moved - rotation * middle;
        let settled_mm = T::default_epsilon().root();
        if moved.norm_squared() + turn.norm_squared() * middle.norm_squared() > settled_mm * settled_mm {
            return None;
        }
        if self.start.angle_to(&self.attitude) > T::of(FARTHEST_RAD) {
            return Some(Err(PlatformError::DoesNotClose));
        }
        Some(Ok(PlatformPose { origin_mm: self.origin_mm, rotation }))
    }
}

/// A solution further than this from the nearest triangles' belongs to another assembly mode, rad (29 degrees). Ends a
/// tenth of the platform's size apart turn a pose by a tenth of this.
const FARTHEST_RAD: f64 = 0.5;
