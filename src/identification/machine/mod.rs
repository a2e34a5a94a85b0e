//! The machine as the estimator sees it: its geometry, and the constants of it that are not known exactly.
//!
//! Observable from six lengths are the shape of the base, the shape of the platform, six encoder offsets and six drum
//! scales. A rigid motion of all attachment points is not: it is a motion of {B}, which is by definition the frame best
//! fitted to the points as they are, and every σ of a centre is meant in that frame. Each constant takes part when its
//! tolerance is not zero, with that as its prior standard deviation (maximum a posteriori).

mod deviation;
mod estimate;
mod shape;

pub use deviation::MachineDeviation;
pub use estimate::MachineEstimate;
pub use shape::MAX_MODES;
pub(super) use shape::for_each_mode;

use self::shape::ShapeModes;
use crate::identification::settings::MIN_NOISE_MM;
use crate::kinematics::{Geometry, PlatformSolver};
use crate::linear_algebra::packed_index;
use crate::rig::{CABLES, POINTS, Rig, Tolerance};
use crate::scalar::Real;
use nalgebra::Vector3;

/// Maximum number of unknown constants: twelve modes of the base, twelve of the platform, six offsets, six
/// scales. The 3-3 machine has three modes of each.
pub const MAX_MACHINE: usize = 2 * MAX_MODES + 2 * CABLES;
/// Entries of the packed precision of their priors.
const MACHINE_PACKED: usize = MAX_MACHINE * (MAX_MACHINE + 1) / 2;

/// Unit of a scale parameter: a drum that pays out 1 mm more in 100 mm. All parameters then change lengths by about as
/// much, which keeps the normal equations well conditioned.
pub const SCALE_UNIT: f64 = 0.01;

/// A machine, and how well it is known.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine<T> {
    platform: PlatformSolver<T>,
    noise_mm: T,
    sample_noise_mm: T,
    home_mm: [T; CABLES],
    base: ShapeModes<T>,
    ends: ShapeModes<T>,
    tolerance: Tolerance<T>,
    /// Those of its constants that are unknown, by the tolerances.
    unknown: Constants,
    /// Precision (inverse covariance) of the priors, packed lower triangle, in the order base modes, platform modes,
    /// offsets, scales.
    precision: [T; MACHINE_PACKED],
}

/// A parameter of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MachineParameter {
    /// A mode of the base's shape.
    Base(usize),
    /// A platform edge (3-3), or a mode of the shape of the platform's ends.
    Ends(usize),
    /// The offset of a cable's encoder, from 0.
    Offset(usize),
    /// The scale of a cable's drum, from 0.
    Scale(usize),
}

impl<T: Real> Machine<T> {
    /// The machine of `rig` with its tolerances.
    pub fn new(rig: &Rig<T>) -> Self {
        Self::with_offset_prior(rig, rig.tolerance().offset_mm)
    }

    /// The same with encoder offsets that are known to `offset_mm`, 1σ, mm; 0 = exactly.
    pub fn with_offset_prior(rig: &Rig<T>, offset_mm: T) -> Self {
        let platform = PlatformSolver::new(rig);
        let tolerance = Tolerance { offset_mm, ..*rig.tolerance() };
        let mut machine = Self {
            platform,
            noise_mm: rig.length_noise_mm(),
            sample_noise_mm: rig.sample_noise_mm(),
            home_mm: rig.drum().home_length_mm,
            base: ShapeModes::none(),
            ends: ShapeModes::none(),
            tolerance,
            unknown: Constants { base: 0, ends: 0, offsets: 0, scales: 0 },
            precision: [T::zero(); MACHINE_PACKED],
        };
        // Filled in where they stay: they are too large to be passed on.
        let geometry = machine.platform.geometry();
        if geometry.is_three_three {
            machine.base.set_triangle(rig.base_mm(), crate::rig::ATTACHMENTS.as_flattened());
            machine.ends.set_edges(&rig.platform_mm());
        } else {
            machine.base.set_six(&geometry.base_mm);
            machine.ends.set_six(&geometry.end_mm);
        }
        machine.state_tolerances();
        machine
    }

    /// Changes how well the encoder offsets are known, 1σ, mm; 0 = exactly. In place: the shapes stay as they are.
    pub fn set_offset_prior(&mut self, offset_mm: T) {
        self.tolerance.offset_mm = offset_mm;
        self.state_tolerances();
    }

    /// Each constant's prior is its own tolerance.
    fn state_tolerances(&mut self) {
        self.precision.fill(T::zero());
        let tolerance = self.tolerance;
        let if_unknown = |tolerance: T, count: usize| if tolerance > T::zero() { count } else { 0 };
        let all = self.all();
        self.unknown = Constants {
            base: if_unknown(tolerance.base_mm, all.base),
            ends: if_unknown(tolerance.edges_mm, all.ends),
            offsets: if_unknown(tolerance.offset_mm, all.offsets),
            scales: if_unknown(tolerance.drum, all.scales),
        };
        for index in 0..self.parameters() {
            let sigma = match self.parameter(index) {
                MachineParameter::Base(_) => tolerance.base_mm,
                MachineParameter::Ends(_) => tolerance.edges_mm,
                MachineParameter::Offset(_) => tolerance.offset_mm,
                MachineParameter::Scale(_) => tolerance.drum / T::of(SCALE_UNIT),
            };
            if let Some(entry) = self.precision.get_mut(packed_index(index, index)) {
                *entry = T::one() / (sigma * sigma);
            }
        }
    }

    /// The same machine with priors that are correlated, as commissioning leaves them: the packed lower triangle of
    /// their precision (inverse covariance) in the order of [`parameter`](Self::parameter).
    #[must_use]
    pub fn with_precision(mut self, precision: &[T]) -> Self {
        self.precision = [T::zero(); MACHINE_PACKED];
        let used = packed_index(self.parameters(), 0);
        self.precision.iter_mut().zip(precision).take(used).for_each(|(kept, given)| *kept = *given);
        self
    }

    /// The forward kinematics.
    pub fn platform(&self) -> &PlatformSolver<T> {
        &self.platform
    }

    /// The geometry as stated, mm.
    pub fn geometry(&self) -> &Geometry<T> {
        self.platform.geometry()
    }

    /// Standard deviation of one length, mm: of what does not average over the samples of a held pose.
    pub fn noise_mm(&self) -> T {
        self.noise_mm
    }

    /// Variance of a length that is the mean of so many samples, over that of [`noise_mm`](Self::noise_mm): 1 where the rig
    /// states no noise that averages.
    pub fn relative_variance(&self, samples: u16) -> T {
        if self.sample_noise_mm <= T::zero() {
            return T::one();
        }
        let ratio = self.sample_noise_mm / self.noise_mm.max(T::of(MIN_NOISE_MM));
        T::one() + ratio * ratio / T::of_integer(i32::from(samples.max(1)))
    }

    /// Variance of one sample of a length, mm², where that of a held pose but for what averages is `noise_mm` squared.
    pub fn sample_variance_mm2(&self, noise_mm: T) -> T {
        noise_mm * noise_mm + self.sample_noise_mm * self.sample_noise_mm
    }

    /// Length of each cable at count zero, mm.
    pub fn home_mm(&self) -> &[T; CABLES] {
        &self.home_mm
    }

    /// The tolerances, 1σ.
    pub fn tolerance(&self) -> &Tolerance<T> {
        &self.tolerance
    }

    /// How many of its constants are unknown.
    pub fn parameters(&self) -> usize {
        self.unknown().count()
    }

    /// Those of its constants that are unknown.
    pub(super) const fn unknown(&self) -> Constants {
        self.unknown
    }

    /// All its constants, known or not: 18 of a 3-3 machine.
    pub(super) fn all(&self) -> Constants {
        Constants { base: self.base.count(), ends: self.ends.count(), offsets: CABLES, scales: CABLES }
    }

    /// What parameter `index` is.
    pub fn parameter(&self, index: usize) -> MachineParameter {
        self.unknown().at(index)
    }

    /// Indices of the parameters of the platform's shape.
    pub fn platform_shape(&self) -> core::ops::Range<usize> {
        let Constants { base, ends, .. } = self.unknown();
        base..base + ends
    }

    /// How far each end-point moves in {P} when parameter `index`, one of the platform's shape, grows by 1 mm, mm.
    pub fn end_points_moved(&self, index: usize) -> [Vector3<T>; POINTS] {
        let [a, b, c, d, e, f] = self.ends.mode(index.saturating_sub(self.unknown().base));
        let half = T::of(0.5);
        [(a + b) * half, (c + d) * half, (e + f) * half]
    }

    /// Index of the first encoder offset; `None` when they are known.
    pub fn first_offset(&self) -> Option<usize> {
        self.unknown().first_offset()
    }

    /// Index of the first drum scale; `None` when they are known.
    pub fn first_scale(&self) -> Option<usize> {
        self.unknown().first_scale()
    }
}

/// How many constants of each kind are looked for. They stand in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Constants {
    /// Modes of the base.
    pub base: usize,
    /// Modes of the platform.
    pub ends: usize,
    /// Encoder offsets.
    pub offsets: usize,
    /// Drum scales.
    pub scales: usize,
}

impl Constants {
    /// Number of constants that take part.
    pub const fn count(&self) -> usize {
        self.base + self.ends + self.offsets + self.scales
    }

    /// What constant `index` is.
    pub const fn at(&self, index: usize) -> MachineParameter {
        let Self { base, ends, offsets, .. } = *self;
        if index < base {
            MachineParameter::Base(index)
        } else if index < base + ends {
            MachineParameter::Ends(index - base)
        } else if index < base + ends + offsets {
            MachineParameter::Offset(index - base - ends)
        } else {
            MachineParameter::Scale(index - base - ends - offsets)
        }
    }

    /// Index of the first encoder offset, if they are among them.
    pub fn first_offset(&self) -> Option<usize> {
        (self.offsets > 0).then_some(self.base + self.ends)
    }

    /// Index of the first drum scale, if they are among them.
    pub fn first_scale(&self) -> Option<usize> {
        (self.scales > 0).then_some(self.base + self.ends + self.offsets)
    }
}
