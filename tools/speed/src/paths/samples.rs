//! What is done with one pose or one sample.

use core::hint::black_box;

use glenoid::identification::{self, Survey};
use glenoid::kinematics::arm::{Arm, CableSet, nearest_attitude, turned};
use glenoid::kinematics::{Octahedron, Pivot, RigPoints};
use nalgebra::Vector3;

use super::{Bench, Geometry};
use crate::measure::Number;

/// The arm has turned by this much about each axis since the sample before, rad: one degree in all, which is 1000
/// degrees a second at 1 kHz and 100 at 100 Hz.
const TURN_RAD: f64 = 0.01;

/// Nothing to prepare.
pub fn nothing<T: Number>(_: &mut Bench<T>) -> Option<()> {
    Some(())
}

/// The rig's geometry with the true centre.
pub fn geometry<T: Number>(bench: &mut Bench<T>) -> Option<()> {
    let (rig, truth) = (&bench.problem.rig, &bench.problem.truth);
    let points = RigPoints::new(rig);
    let pivot = Pivot::from_parameters(truth, &points);
    bench.geometry = Some(Geometry { octahedron: Octahedron::new(rig), points, pivot });
    Some(())
}

/// A survey of no poses.
pub fn new_survey<T: Number>(bench: &mut Bench<T>) -> Option<()> {
    bench.survey = Some(Survey::new(&bench.problem.rig));
    Some(())
}

/// One more pose into the survey, and the error bar foretold. The first two poses foretell none.
#[inline(never)]
pub fn survey<T: Number>(bench: &mut Bench<T>, index: usize) -> Option<bool> {
    let survey = bench.survey.as_mut()?;
    survey.add(bench.problem.poses.as_slice().get(index)?).ok()?;
    black_box(survey.foretold());
    Some(more(bench, index))
}

/// Forward kinematics of one sample from nothing: the octahedron.
#[inline(never)]
pub fn octahedron<T: Number>(bench: &mut Bench<T>, index: usize) -> Option<bool> {
    let pose = &bench.geometry.as_ref()?.octahedron.solve(bench.poses().get(index)?);
    black_box(pose).is_ok().then(|| more(bench, index))
}

/// The attitudes of the samples before, for tracking.
pub fn arm_before<T: Number>(bench: &mut Bench<T>) -> Option<()> {
    geometry(bench)?;
    for index in 0..bench.poses().len() {
        let pose = bench.geometry.as_ref()?.octahedron.solve(bench.poses().get(index)?).ok()?;
        let turn = Vector3::repeat(T::of(TURN_RAD));
        *bench.before.get_mut(index)? = turned(&nearest_attitude(&pose.rotation), &turn);
    }
    Some(())
}

/// Forward kinematics of one sample with the joint centre known, from the attitude of the sample before.
#[inline(never)]
pub fn tracking<T: Number>(bench: &mut Bench<T>, index: usize) -> Option<bool> {
    let Geometry { points, pivot, .. } = bench.geometry.as_ref()?;
    let arm = Arm { points, pivot };
    let fit = &arm.fit_from(*bench.before.get(index)?, bench.poses().get(index)?, CableSet::ALL);
    black_box(fit).is_some().then(|| more(bench, index))
}

/// One pose of the second set laid against the centre.
#[inline(never)]
pub fn verify<T: Number>(bench: &mut Bench<T>, index: usize) -> Option<bool> {
    let pose = bench.poses().get(index..=index)?;
    black_box(identification::verify(&bench.problem.rig, &bench.problem.truth, pose).ok()?);
    Some(more(bench, index))
}

fn more<T: Number>(bench: &Bench<T>, index: usize) -> bool {
    index + 1 < bench.poses().len()
}
