//! The error bar foretold: what the poses captured so far will give, updated with every pose.
//!
//! The information of a pose hangs on its geometry alone, so the covariance of the result is known before any residual
//! is looked at. A therapist can be told after each pose how good the centre would be, and what is missing.

use super::blocks::BlockEquations;
use super::observability::Sway;
use super::pivot_fit::PivotFit;
use super::pose_information::PoseInformation;
use super::uncertainty::worst_direction_of_point;
use crate::kinematics::{CableLengths, LengthEquations, Octahedron, OctahedronError, Pivot, PlatformPose, RigPoints};
use crate::rig::Rig;
use crate::scalar::Real;

/// The information gathered so far.
#[derive(Clone, Debug)]
pub struct Survey<T: Real> {
    octahedron: Octahedron<T>,
    points: RigPoints<T>,
    noise_mm: T,
    pivot: Pivot<T>,
    linear: PivotFit<T>,
    information: BlockEquations<T>,
    /// What the last pose says. Kept only to be overwritten: made anew and handed over they would cost a twentieth more.
    equations: LengthEquations<T>,
    known: PoseInformation<T>,
}

/// What an identification from the poses so far would be worth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foretold<T> {
    /// 1σ of the centre in its worst direction, mm.
    pub sigma_mm: T,
    /// That direction in {B}, a unit vector.
    pub direction: [T; 3],
}

impl<T: Real> Survey<T> {
    /// A survey of no poses. The information of the first poses is judged at the rig's nominal centre.
    pub fn new(rig: &Rig<T>) -> Self {
        let points = RigPoints::new(rig);
        Self {
            octahedron: Octahedron::new(rig),
            pivot: Pivot::from_parameters(rig.nominal(), &points),
            points,
            noise_mm: rig.length_noise_mm(),
            linear: PivotFit::default(),
            information: BlockEquations::new(),
            equations: LengthEquations::empty(),
            known: PoseInformation::empty(),
        }
    }

    /// Adds a pose; returns where the platform stands in it.
    ///
    /// # Errors
    /// [`OctahedronError`] when the lengths give no platform pose; nothing is added then.
    pub fn add(&mut self, lengths: &CableLengths<T>) -> Result<PlatformPose<T>, OctahedronError> {
        let solved = self.octahedron.solve(lengths);
        // By reference, like the information below: taken out of the result it would be copied.
        let Ok(pose) = &solved else { return solved };
        self.linear.add(pose);
        // As soon as the poses tell a centre, theirs is better than the nominal one. Until then that stays.
        let _ = self.linear.solve(&mut self.pivot);
        self.equations.set(&self.points, &self.pivot, &pose.rotation, lengths);
        if self.known.set(&self.equations).is_ok() {
            self.information.add_pose(&pose.rotation, &self.known.information, &self.known.gradient_mm, T::one());
        }
        solved
    }

    /// The error bar that the poses so far would give, or `None` while they leave the centre undetermined.
    pub fn foretold(&self) -> Option<Foretold<T>> {
        let Ok(centre) = &self.information.matrix.first_inverse() else { return None };
        let (sigma, direction) = worst_direction_of_point(centre);
        Some(Foretold { sigma_mm: sigma * self.noise_mm, direction })
    }

    /// How far the poses so far are from turning about one axis, and about which.
    pub fn sway(&self) -> Sway<T> {
        self.linear.rotations().sway()
    }
}
