//! The watch over a centre in use, sample by sample.

use core::hint::black_box;

use glenoid::kinematics::CableLengths;
use glenoid::kinematics::arm::{nearest_attitude, rotation_of, turned};
use glenoid::rig::{ATTACHMENTS, CABLES};
use glenoid::watch::Watch;
use nalgebra::Vector3;

use super::{Bench, Geometry, samples};
use crate::measure::Number;
use crate::problem::POSES;

/// The arm turns by this much from sample to sample, rad: every sample counts.
const TURN_RAD: f64 = 0.012;
/// Samples after which it turns back.
const THERE: usize = 25;
/// The sample at which the base strap slips, and how far, mm: all that the watch does is in the figures.
const SLIP: (usize, f64) = (30, 3.0);

/// A watch that has seen nothing, and the motion that it will see.
pub fn new_watch<T: Number>(bench: &mut Bench<T>) -> Option<()> {
    samples::geometry(bench)?;
    let Geometry { octahedron, points, pivot } = bench.geometry.as_ref()?;
    let mut attitude = nearest_attitude(&octahedron.solve(bench.problem.poses.as_slice().first()?).ok()?.rotation);
    bench.motion.clear();
    for index in 0..POSES {
        let turn = if (index / THERE).is_multiple_of(2) { TURN_RAD } else { -TURN_RAD };
        attitude = turned(&attitude, &Vector3::new(T::of(turn), T::zero(), T::zero()));
        let slip = if index < SLIP.0 { 0.0 } else { SLIP.1 };
        let centre = pivot.in_base_mm + Vector3::new(T::zero(), T::zero(), T::of(slip));
        let rotation = rotation_of(&attitude);
        let end_points = points.platform_mm.map(|point| centre + rotation * (point - pivot.in_platform_mm));
        let mut lengths_mm = [T::zero(); CABLES];
        for (cable, length) in lengths_mm.iter_mut().enumerate() {
            let (point, side) = (cable / 2, cable % 2);
            *length = (end_points[point] - points.base_mm[ATTACHMENTS[point][side]]).norm_squared().root();
        }
        bench.motion.push(CableLengths::new(lengths_mm).ok()?).ok()?;
    }
    let rig = &bench.problem.rig;
    bench.watch = Some(Watch::new(rig, &bench.problem.truth, &[T::zero(); CABLES], rig.length_noise_mm()));
    Some(())
}

/// One sample.
#[inline(never)]
pub fn watch<T: Number>(bench: &mut Bench<T>, index: usize) -> Option<bool> {
    black_box(bench.watch.as_mut()?.sample(bench.motion.as_slice().get(index)?));
    Some(index + 1 < bench.motion.len())
}
