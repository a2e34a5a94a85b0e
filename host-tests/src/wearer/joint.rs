//! A joint centre that moves with the arm, as those of people do.

use super::Wearer;
use crate::anatomy::Shoulder;
use nalgebra::{Rotation3, Vector3};

/// What is left of the shoulder blade's motion when somebody holds it.
const LEFT_WHEN_HELD: f64 = 0.1;
/// Poses with the shoulder blade held tilt the arm by up to this angle, rad (30 degrees).
const TILT_WHEN_HELD_RAD: f64 = 0.524;
/// Slides of the head that follow nothing, 1σ along each axis, mm (Ludewig et al. 2009, from bone pins).
pub(super) const SCATTER_MM: f64 = 0.35;

/// A shoulder, and what is done to it.
#[derive(Debug, Clone)]
pub(super) struct MovingJoint {
    shoulder: Shoulder,
    is_held: bool,
}

impl Wearer {
    /// Has the wearer's joint centre move as that of a shoulder.
    pub fn wear(&mut self, shoulder: Shoulder) {
        self.joint = Some(MovingJoint { shoulder, is_held: false });
    }

    /// Somebody holds the shoulder blade, or lets it go.
    pub fn hold_blade(&mut self, is_held: bool) {
        if let Some(joint) = &mut self.joint {
            joint.is_held = is_held;
        }
    }

    /// The joint centre in {B} with the arm at a rotation from home, mm, but for the slides that follow nothing.
    pub fn centre_at(&self, arm: &Rotation3<f64>) -> Vector3<f64> {
        let moved = self.joint.as_ref().map_or_else(Vector3::zeros, |joint| {
            let share = if joint.is_held { LEFT_WHEN_HELD } else { 1.0 };
            joint.shoulder.displacement_mm(arm) * share
        });
        self.arm.centre_mm() + moved
    }

    /// The next slide of the head that follows nothing, mm; 0 for a ball.
    pub(super) fn next_slide(&mut self) -> Vector3<f64> {
        match self.joint {
            Some(_) => Shoulder::scatter_mm(&mut self.random, SCATTER_MM),
            None => Vector3::zeros(),
        }
    }

    /// Can the arm be there?
    pub(super) fn reaches(&self, arm: &Rotation3<f64>) -> bool {
        self.joint.as_ref().is_none_or(|joint| joint.shoulder.reaches(arm))
    }

    /// Up to how far poses tilt the arm now, rad.
    pub(super) fn tilt_limit_rad(&self) -> f64 {
        let is_held = self.joint.as_ref().is_some_and(|joint| joint.is_held);
        if is_held { self.settings.tilt_rad.min(TILT_WHEN_HELD_RAD) } else { self.settings.tilt_rad }
    }
}
