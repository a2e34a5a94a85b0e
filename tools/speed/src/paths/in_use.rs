//! Slip detection about a centre in use, sample by sample.

use core::hint::black_box;

use glenoid::identification::joint::Joint;
use glenoid::identification::machine::MachineDeviation;
use glenoid::kinematics::rotation::{nearest_attitude, rotation_of, turned};
use glenoid::kinematics::{CableLengths, JointCentre};
use glenoid::monitor::SlipDetector;
use glenoid::rig::CABLES;
use nalgebra::Vector3;

use super::whole_runs::exact;
use super::{Bench, Held};
use crate::measure::Number;
use crate::problem::POSES;

/// The arm turns by this much from sample to sample, rad: every sample counts.
const TURN_RAD: f64 = 0.012;
/// Samples after which it turns back.
const THERE: usize = 25;
/// The sample at which the base strap slips, and how far, mm: all that the detector does is in the figures.
const SLIP: (usize, f64) = (30, 3.0);

/// A detector that has seen nothing, and the motion that it will see.
#[inline(never)]
pub fn new_detector<T: Number>(bench: &mut Bench<T>) -> Option<()> {
    exact(bench)?;
    let geometry = bench.machine.geometry();
    let truth = JointCentre::from_parameters(&bench.problem.truth, geometry);
    let first = bench.machine.platform().solve(bench.problem.poses.first()?).ok()?;
    let mut attitude = nearest_attitude(&first.rotation);
    bench.motion.clear();
    for index in 0..POSES {
        let turn = if (index / THERE).is_multiple_of(2) { TURN_RAD } else { -TURN_RAD };
        attitude = turned(&attitude, &Vector3::new(T::of(turn), T::zero(), T::zero()));
        let slip = if index < SLIP.0 { 0.0 } else { SLIP.1 };
        let centre = truth.in_base_mm + Vector3::new(T::zero(), T::zero(), T::of(slip));
        let rotation = rotation_of(&attitude);
        let mut lengths_mm = [T::zero(); CABLES];
        for ((length, end), base) in lengths_mm.iter_mut().zip(&geometry.end_mm).zip(&geometry.base_mm) {
            *length = (centre + rotation * (end - truth.in_platform_mm) - base).norm_squared().root();
        }
        bench.motion.push(CableLengths::new(lengths_mm).ok()?).ok()?;
    }
    let offsets = [T::zero(); CABLES];
    let (as_drawn, noise_mm) = (MachineDeviation::none(), bench.machine.noise_mm());
    bench.held = Held::Detector(SlipDetector::new(
        &bench.machine,
        &as_drawn,
        &bench.problem.truth,
        &offsets,
        noise_mm,
        Joint::Ball,
    ));
    Some(())
}

/// One sample.
#[inline(never)]
pub fn detect<T: Number>(bench: &mut Bench<T>, index: usize) -> Option<bool> {
    let Bench { held: Held::Detector(detector), motion, .. } = bench else { return None };
    black_box(detector.sample(motion.get(index)?));
    Some(index + 1 < motion.len())
}
