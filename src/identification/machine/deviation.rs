//! By how much a machine was found to differ from what is stated: what is kept of an estimate.

use super::Machine;
use super::shape::MAX_MODES;
use crate::kinematics::Geometry;
use crate::rig::CABLES;
use crate::scalar::Real;

/// The shape and the drums of a machine as an identification found them. The encoder offsets are kept beside it. What
/// takes no part is 0, so the same numbers hold whichever constants the next identification leaves open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MachineDeviation<T> {
    /// Coefficients of the shape modes of the base, mm.
    pub base_mm: [T; MAX_MODES],
    /// Coefficients of the shape modes of the platform (3-3: its three edges), mm.
    pub ends_mm: [T; MAX_MODES],
    /// By how much each drum pays out more than stated, relative.
    pub scale: [T; CABLES],
}

impl<T: Real> MachineDeviation<T> {
    /// A machine that is as stated.
    pub fn none() -> Self {
        Self { base_mm: [T::zero(); MAX_MODES], ends_mm: [T::zero(); MAX_MODES], scale: [T::zero(); CABLES] }
    }
}

impl<T: Real> Machine<T> {
    /// The geometry of the machine as it was found.
    pub fn geometry_with(&self, deviation: &MachineDeviation<T>) -> Geometry<T> {
        let mut geometry = *self.geometry();
        self.base.displace(&mut geometry.base_mm, &deviation.base_mm);
        self.ends.displace(&mut geometry.end_mm, &deviation.ends_mm);
        geometry
    }
}

impl<T: Real> super::MachineEstimate<T> {
    /// By how much the machine is estimated to differ from what is stated.
    pub fn deviation(&self, machine: &Machine<T>) -> MachineDeviation<T> {
        let mut values = self.values().iter().copied();
        let mut modes = |count: usize| {
            let mut coefficients = [T::zero(); MAX_MODES];
            coefficients.iter_mut().take(count).zip(&mut values).for_each(|(kept, value)| *kept = value);
            coefficients
        };
        let unknown = machine.unknown();
        let (base_mm, ends_mm) = (modes(unknown.base), modes(unknown.ends));
        MachineDeviation { base_mm, ends_mm, scale: self.scales() }
    }
}
