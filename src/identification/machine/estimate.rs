//! The present estimate of the machine's unknown constants.

use super::{Constants, MAX_MACHINE, Machine, MachineParameter, SCALE_UNIT};
use crate::identification::parameters::{Column, Equations, PoseAt};
use crate::kinematics::{CableLengths, Geometry};
use crate::linear_algebra::packed_index;
use crate::rig::CABLES;
use crate::scalar::Real;

/// How far a machine may be off that nobody has measured, 1σ: points, edges and encoder offsets, mm; drums, relative.
const UNMEASURED_MM: f64 = 5.0;
const UNMEASURED_DRUM: f64 = 0.02;

/// How far the machine is from what was stated.
#[derive(Clone, Debug, PartialEq)]
pub struct MachineEstimate<T> {
    /// The ends as they are estimated.
    geometry: Geometry<T>,
    /// Coefficients of the modes, mm; offsets, mm; scales less one in units of [`SCALE_UNIT`]. In the order of
    /// [`Machine::parameter`].
    values: [T; MAX_MACHINE],
    /// The constants that are estimated.
    unknown: Constants,
    /// How many of them take part in a pass: all, or none while they are held. Kept, for every column asks.
    count: usize,
    /// The priors are those of a machine that nobody has measured, whatever its tolerances state.
    is_unmeasured: bool,
}

impl<T: Real> MachineEstimate<T> {
    /// The machine as stated: where the first pass begins.
    pub fn new(machine: &Machine<T>) -> Self {
        Self {
            geometry: *machine.geometry(),
            values: [T::zero(); MAX_MACHINE],
            unknown: machine.unknown(),
            count: machine.unknown().count(),
            is_unmeasured: false,
        }
    }

    /// As stated, but by nobody who has measured it: all its constants are unknown.
    pub fn unmeasured(machine: &Machine<T>) -> Self {
        Self { unknown: machine.all(), count: machine.all().count(), is_unmeasured: true, ..Self::new(machine) }
    }

    /// The ends as they are estimated.
    pub fn geometry(&self) -> &Geometry<T> {
        &self.geometry
    }

    /// By how much each parameter differs from what was stated, in the order and units of [`Machine::parameter`].
    pub fn values(&self) -> &[T; MAX_MACHINE] {
        &self.values
    }

    /// Holds the parameters at their present values from now on.
    pub fn hold(&mut self) {
        self.count = 0;
    }

    /// Lets the parameters take part again.
    pub fn release(&mut self) {
        self.count = self.unknown.count();
    }

    /// Parameters that take part in a pass.
    pub const fn count(&self) -> usize {
        self.count
    }

    /// The present estimate of the encoder offsets (reading minus true length), mm.
    pub fn offsets_mm(&self) -> [T; CABLES] {
        self.six(self.unknown.first_offset())
    }

    /// By how much each drum pays out more than stated, relative.
    pub fn scales(&self) -> [T; CABLES] {
        self.six(self.unknown.first_scale()).map(|scale| scale * T::of(SCALE_UNIT))
    }

    fn six(&self, first: Option<usize>) -> [T; CABLES] {
        let values = first.and_then(|first| self.values.get(first..));
        core::array::from_fn(|k| values.and_then(|values| values.get(k)).copied().unwrap_or_else(T::zero))
    }

    /// The lengths corrected by the present estimate: home + (reading - home - offset) / scale. Unchanged if a
    /// corrected length would not be positive.
    #[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    pub fn corrected(&self, machine: &Machine<T>, lengths: &CableLengths<T>) -> CableLengths<T> {
        let unknown = self.unknown;
        if unknown.offsets == 0 && unknown.scales == 0 {
            return *lengths;
        }
        let (offsets, scales) = (self.offsets_mm(), self.scales());
        let mm = lengths.as_mm();
        let corrected = core::array::from_fn(|k| {
            let length = mm[k] - offsets[k];
            if scales[k] == T::zero() {
                length
            } else {
                machine.home_mm[k] + (length - machine.home_mm[k]) / (T::one() + scales[k])
            }
        });
        CableLengths::new(corrected).unwrap_or(*lengths)
    }

    /// The column of the Jacobian of parameter `index` in a pose.
    pub fn column(&self, machine: &Machine<T>, index: usize, pose: &PoseAt<'_, T>) -> Column<T> {
        let rows = &pose.jacobian.rows;
        match self.unknown.at(index) {
            // A cable grows when its base end moves back.
            MachineParameter::Base(mode) => {
                let moved = machine.base.mode(mode);
                Column::AllCables(core::array::from_fn(|k| -rows[k].translation.dot(&moved[k])))
            }
            MachineParameter::Ends(mode) => {
                let moved = machine.ends.mode(mode);
                Column::AllCables(core::array::from_fn(|k| rows[k].translation.dot(&(pose.rotation * moved[k]))))
            }
            MachineParameter::Offset(cable) => Column::OneCable(cable, T::one()),
            MachineParameter::Scale(cable) => {
                // The length of the model, not the measured one: the noise in that would go with the residual, and thousands
                // of poses would favour drums that make lengths, and so the noise, smaller.
                let mm = pose.lengths.as_mm();
                let change = rows.get(cable).zip(mm.get(cable)).zip(machine.home_mm.get(cable));
                let change =
                    change.map(|((row, length), home)| (*length - row.residual_mm - *home) * T::of(SCALE_UNIT));
                Column::OneCable(cable, change.unwrap_or_else(T::zero))
            }
        }
    }

    /// Adds the priors, times the noise's variance, mm². The first parameter is unknown `first`.
    pub fn add_prior(&self, machine: &Machine<T>, equations: &mut Equations<T>, first: usize, variance_mm2: T) {
        for i in 0..self.count {
            if self.is_unmeasured {
                let sigma = match self.unknown.at(i) {
                    MachineParameter::Scale(_) => T::of(UNMEASURED_DRUM / SCALE_UNIT),
                    _ => T::of(UNMEASURED_MM),
                };
                self.add_entry(equations, first, (i, i), variance_mm2 / (sigma * sigma));
                continue;
            }
            let Some(row) = machine.precision.get(packed_index(i, 0)..=packed_index(i, i)) else { return };
            for (j, precision) in row.iter().enumerate().filter(|(_, precision)| **precision != T::zero()) {
                self.add_entry(equations, first, (i, j), *precision * variance_mm2);
            }
        }
    }

    /// Adds one entry of the priors' precision, or two that mirror each other.
    fn add_entry(&self, equations: &mut Equations<T>, first: usize, (i, j): (usize, usize), weight: T) {
        let (Some(a), Some(b)) = (self.values.get(i).copied(), self.values.get(j).copied()) else { return };
        equations.add_to_entry(first + i, first + j, weight);
        equations.add_to_gradient(first + i, -b * weight);
        let twice = if i == j { T::one() } else { T::of(2.0) };
        if i != j {
            equations.add_to_gradient(first + j, -a * weight);
        }
        equations.add_squares(a * b * weight * twice);
    }

    /// Moves the parameters by a step.
    pub fn apply(&mut self, machine: &Machine<T>, step: &[T]) {
        let count = self.count();
        if count == 0 {
            return;
        }
        self.values.iter_mut().zip(step).take(count).for_each(|(value, step)| *value += *step);
        self.geometry = *machine.geometry();
        let unknown = self.unknown;
        let (base, ends) = self.values.split_at_checked(unknown.base).unwrap_or_default();
        let ends = ends.get(..unknown.ends).unwrap_or_default();
        machine.base.displace(&mut self.geometry.base_mm, base);
        machine.ends.displace(&mut self.geometry.end_mm, ends);
    }
}
