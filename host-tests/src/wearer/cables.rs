//! The six cables as they run: their ends on the base, and the guide pulleys that some machines have.
//!
//! Written here from the geometry, apart from the library's length model, which is tested against it.

use glenoid::rig::{ATTACHMENTS, CABLES, Pulley, Rig};
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Where the six cables leave the base, and over what.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cables {
    base_mm: [Vector3<f64>; CABLES],
    pulleys: [Pulley<f64>; CABLES],
}

impl Cables {
    /// Those of a rig.
    pub fn new(rig: &Rig<f64>) -> Self {
        match rig.cables() {
            Some(cables) => Self {
                base_mm: cables.each_ref().map(|cable| cable.base_mm),
                pulleys: cables.each_ref().map(|cable| cable.pulley),
            },
            None => Self::from_base(std::array::from_fn(|k| rig.base_mm()[ATTACHMENTS[k / 2][k % 2]])),
        }
    }

    /// Cables that end at these points of the base, without pulleys, mm.
    pub fn from_base(base_mm: [Vector3<f64>; CABLES]) -> Self {
        Self { base_mm, pulleys: [Pulley::none(); CABLES] }
    }

    /// The same with their ends on the base moved, mm.
    pub fn moved(&self, by_mm: &[Vector3<f64>; CABLES]) -> Self {
        Self { base_mm: std::array::from_fn(|k| self.base_mm[k] + by_mm[k]), ..*self }
    }

    /// Where they leave the base, in {B}, mm.
    pub fn base_mm(&self) -> &[Vector3<f64>; CABLES] {
        &self.base_mm
    }

    /// The six lengths to these ends in {B}, mm.
    pub fn lengths_mm(&self, ends_mm: &[Vector3<f64>; CABLES]) -> [f64; CABLES] {
        std::array::from_fn(|k| length_mm(&(ends_mm[k] - self.base_mm[k]), &self.pulleys[k]))
    }
}

/// Length of a cable from where it enters its pulley to an end `span` away. The pulley's wheel touches the swivel axis
/// where the cable comes up and turns towards the end: the cable lies on the wheel over an arc, and leaves it along the
/// tangent to the end.
pub(crate) fn length_mm(span: &Vector3<f64>, pulley: &Pulley<f64>) -> f64 {
    let radius = pulley.radius_mm;
    if radius == 0.0 {
        return libm::sqrt(span.norm_squared());
    }
    let up = span.dot(&pulley.axis);
    let out = (span - pulley.axis * up).norm();
    // From the wheel's centre to the end, and the tangent from there.
    let across = out - radius;
    let free = libm::sqrt(across * across + up * up - radius * radius);
    free + radius * (PI - libm::atan2(up, across) - libm::atan2(free, radius))
}
