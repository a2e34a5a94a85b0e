//! What is done with one pose or one sample.

use core::hint::black_box;

use glenoid::identification::{Pose, PredictedAccuracy};
use glenoid::kinematics::rotation::{nearest_attitude, turned};
use glenoid::kinematics::{AttitudeSolver, CableSet, JointCentre};
use nalgebra::Vector3;

use super::whole_runs::{self, exact};
use super::{Bench, Held};
use crate::measure::Number;

/// The arm has turned by this much about each axis since the sample before, rad: one degree in all, which is 1000
/// degrees a second at 1 kHz and 100 at 100 Hz.
const TURN_RAD: f64 = 0.01;
/// The same about each axis at 200 degrees a second and 1 kHz.
const FOLLOWED_RAD: f64 = 0.003_5 / 1.732;

/// The accuracy of no poses.
#[inline(never)]
pub fn new_accuracy<T: Number>(bench: &mut Bench<T>) -> Option<()> {
    exact(bench)?;
    bench.held = Held::Accuracy(PredictedAccuracy::new(&bench.machine, bench.problem.rig.nominal()));
    Some(())
}

/// The same for a machine with tolerances.
#[inline(never)]
pub fn new_accuracy_with_tolerances<T: Number>(bench: &mut Bench<T>) -> Option<()> {
    whole_runs::tolerances(bench)?;
    bench.held = Held::Accuracy(PredictedAccuracy::new(&bench.machine, bench.problem.rig.nominal()));
    Some(())
}

/// One more pose, placed, and the standard deviation that it promises. The first two poses promise none.
#[inline(never)]
pub fn accuracy<T: Number>(bench: &mut Bench<T>, index: usize) -> Option<bool> {
    let Bench { held: Held::Accuracy(accuracy), machine, problem, .. } = bench else { return None };
    let pose = Pose::placed(machine.platform(), *problem.poses.get(index)?).ok()?;
    accuracy.add(machine, &pose);
    black_box(accuracy.predicted(machine));
    Some(more(bench, index))
}

/// Forward kinematics of one sample from nothing.
#[inline(never)]
pub fn forward_kinematics<T: Number>(bench: &mut Bench<T>, index: usize) -> Option<bool> {
    let pose = &bench.machine.platform().solve(bench.problem.poses.get(index)?);
    black_box(pose).is_ok().then(|| more(bench, index))
}

/// The true centre, and the attitudes of the samples before, for tracking.
pub fn attitudes_before<T: Number>(bench: &mut Bench<T>) -> Option<()> {
    exact(bench)?;
    bench.centre = JointCentre::from_parameters(&bench.problem.truth, bench.machine.geometry());
    for (before, lengths) in bench.before.iter_mut().zip(&bench.problem.poses) {
        let pose = bench.machine.platform().solve(lengths).ok()?;
        *before = turned(&nearest_attitude(&pose.rotation), &Vector3::repeat(T::of(TURN_RAD)));
    }
    Some(())
}

/// Forward kinematics of one sample with the joint centre known, from the attitude of the sample before.
#[inline(never)]
pub fn tracking<T: Number>(bench: &mut Bench<T>, index: usize) -> Option<bool> {
    let solver = AttitudeSolver { geometry: bench.machine.geometry(), centre: &bench.centre };
    let fit = &solver.track(*bench.before.get(index)?, bench.problem.poses.get(index)?, CableSet::ALL);
    black_box(fit).is_some().then(|| more(bench, index))
}

/// As [`attitudes_before`], at 200 degrees a second and 1 kHz.
pub fn attitudes_just_before<T: Number>(bench: &mut Bench<T>) -> Option<()> {
    attitudes_before(bench)?;
    for (before, lengths) in bench.before.iter_mut().zip(&bench.problem.poses) {
        let pose = bench.machine.platform().solve(lengths).ok()?;
        *before = turned(&nearest_attitude(&pose.rotation), &Vector3::repeat(T::of(FOLLOWED_RAD)));
    }
    Some(())
}

/// The attitude of one sample by a single step from the one before, for a control loop.
#[inline(never)]
pub fn following<T: Number>(bench: &mut Bench<T>, index: usize) -> Option<bool> {
    let solver = AttitudeSolver { geometry: bench.machine.geometry(), centre: &bench.centre };
    let fit = &solver.follow(bench.before.get(index)?, bench.problem.poses.get(index)?);
    black_box(fit).is_some().then(|| more(bench, index))
}

/// An estimator that has identified the centre, and the poses placed anew.
pub fn new_verification<T: Number>(bench: &mut Bench<T>) -> Option<()> {
    exact(bench)?;
    whole_runs::start_free(bench)?;
    let Bench { machine, poses, .. } = bench;
    poses.as_mut_slice().iter_mut().for_each(|pose| {
        pose.reset();
        pose.place(machine.platform());
    });
    Some(())
}

/// One pose of the second set against the centre.
#[inline(never)]
pub fn verify<T: Number>(bench: &mut Bench<T>, index: usize) -> Option<bool> {
    let Bench { held: Held::Estimator(estimator), machine, poses, .. } = &*bench else { return None };
    black_box(estimator.verify(machine, poses.as_slice().get(index)?)?);
    Some(more(bench, index))
}

fn more<T: Number>(bench: &Bench<T>, index: usize) -> bool {
    index + 1 < bench.problem.poses.len()
}
