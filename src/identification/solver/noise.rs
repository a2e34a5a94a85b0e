//! How large the noise is: as told, or as the residuals say.

use super::placement::State;
use super::settings::Noise;
use super::{Solver, judgement};
use crate::calls::root;
use crate::identification::normal_equations::UNKNOWNS;
use crate::identification::zeros::Zeros;
use crate::scalar::Real;

impl<T: Real, const N: usize, Z: Zeros<T>> Solver<T, N, Z> {
    /// Degrees of freedom of the residuals of the pass.
    #[inline(never)]
    pub(super) fn freedom(&self) -> T {
        T::of_integer((3 * self.sum.poses as i32 - UNKNOWNS as i32).max(1))
    }

    /// Are the residuals no larger than the noise explains?
    #[inline(never)]
    pub(super) fn residuals_are_noise(&self) -> bool {
        let (squares_mm2, freedom) = (self.sum.squares_left_mm2, self.freedom());
        match self.settings.noise {
            Noise::Known(noise) => {
                judgement::is_noise(squares_mm2, freedom, noise * noise, T::of(judgement::FALSE_ALARM))
            }
            Noise::EstimatedUpTo(most) => {
                let estimate = root(squares_mm2 / freedom);
                // A bad reading must not hide behind the noise that it pretends: the typical misfit is the measure,
                // unless it is finer than the noise that the rig states. A handful has no typical misfit.
                let typical = if self.placements.len() >= judgement::POSES_TO_ESTIMATE {
                    smaller(self.typical_noise_mm().max(self.placer.rig_noise_mm), estimate)
                } else {
                    estimate
                };
                let unit = self.noise_mm / typical.max(T::of(judgement::LEAST_NOISE_MM));
                let worst = self.misfits.worst;
                estimate <= most && worst * unit * unit <= T::of(judgement::MISFIT_LIMIT)
            }
        }
    }

    /// Is a selection that has settled no noisier than it may be?
    pub(super) fn selection_is_noise(&self) -> bool {
        match self.settings.noise {
            Noise::Known(_) => self.residuals_are_noise(),
            Noise::EstimatedUpTo(most) => self.sum.squares_left_mm2 <= self.freedom() * most * most,
        }
    }

    /// First scale of the annealing; with an unknown noise, its robust estimate too.
    pub(super) fn first_scale(&mut self) -> T {
        if let Noise::EstimatedUpTo(_) = self.settings.noise {
            self.noise_shrinks();
            return T::of(8.0 * judgement::ANNEALED_SCALE);
        }
        self.misfits.median * T::of(3.0)
    }

    /// An unknown noise, estimated from the typical misfit. Bad poses spoil all misfits until they are weighed down, so
    /// the first estimates are too large: true while they fall by a fifth.
    #[inline(never)]
    pub(super) fn noise_shrinks(&mut self) -> bool {
        let Noise::EstimatedUpTo(most) = self.settings.noise else { return false };
        let before = self.noise_mm;
        self.noise_mm = smaller(self.typical_noise_mm(), most).max(T::of(judgement::LEAST_NOISE_MM));
        self.noise_mm < before * T::of(0.8)
    }

    /// The noise that the typical misfit speaks of, mm.
    #[inline(never)]
    fn typical_noise_mm(&self) -> T {
        let poses = T::of_integer(self.placements.len() as i32);
        let median = self.misfits.median;
        let typical = median / T::of(judgement::MEDIAN_OF_CHI_SQUARE_3) * poses / (poses - T::of(2.0));
        self.noise_mm * root(typical)
    }

    /// The noise, and that of the error bar, which is wider where a bad reading may hide, mm.
    pub(super) fn noise_of_error_bar(&self) -> (T, T) {
        let mut squares = self.sum.squares_left_mm2;
        let mut freedom = self.freedom();
        match self.settings.noise {
            // Residuals that sound sets leave only once in twenty widen the error bar (Birge's ratio). Poses that were
            // left out by a close call are counted in: of few poses, the worst leaves the others looking too good.
            Noise::Known(noise) => {
                let variance = noise * noise;
                for pose in &self.placements {
                    if pose.state == State::Placed && pose.misfit <= T::of(judgement::CLEARLY_OUT) {
                        squares += pose.misfit * variance;
                        freedom += T::of(3.0);
                    }
                }
                let fits = judgement::is_noise(squares, freedom, variance, T::of(judgement::WIDENING));
                let noise = if fits { noise } else { root(squares / freedom) };
                (noise, noise)
            }
            // A variance estimated from few residuals is too small too often: the rig's own noise is worth a few more.
            // Residuals beyond the rig's noise may also be one bad reading's that few poses cannot show as such.
            Noise::EstimatedUpTo(_) => {
                let prior = T::of(judgement::PRIOR_FREEDOM);
                let rig = self.placer.rig_noise_mm * self.placer.rig_noise_mm;
                let pooled = root((squares + prior * rig) / (freedom + prior));
                let few = self.sum.poses < judgement::POSES_TO_ESTIMATE;
                if few && !judgement::is_noise(squares, freedom, rig, T::of(judgement::FALSE_ALARM)) {
                    return (pooled, pooled * T::of(judgement::WIDENING_FOR_ONE_BAD_READING));
                }
                (pooled, pooled)
            }
        }
    }
}

/// The smaller of two numbers; the second where one is none.
fn smaller<T: Real>(a: T, b: T) -> T {
    if a < b { a } else { b }
}
