//! An elbow from four cables: the whole identification, and its longest slice.

use glenoid::identification::hinge::{
    Drawing, HINGE_UNKNOWNS, Hinge, HingeEstimator, HingePose, HingeProgress, HingeRefusal, HingeRig, HingeSettings,
    MAX_CABLES,
};
use glenoid::rig::{CableEnds, Parameters, Pulley, Tolerance};
use heapless::Vec;
use nalgebra::Vector3;

use super::whole_runs::hand_built;
use super::{Bench, Held};
use crate::measure::{Answer, Number};
use crate::problem::{NOISE_MM, uniform_noise_mm};

/// Poses of a set, spread evenly over this flexion, rad: 120 degrees.
const POSES: usize = 30;
const FLEXION_RAD: f64 = 2.1;
/// Rings on the upper arm and the forearm, mm, the azimuth of their points, and by how much an end is turned against its base
/// point, to either side alternately, rad.
const RINGS_MM: [f64; 2] = [60.0, 45.0];
const AZIMUTH_RAD: f64 = 0.785;
const ALTERNATING_RAD: f64 = 0.436;
/// Lengths at count zero, mm.
const HOME_MM: f64 = 230.0;
/// How far somebody's elbow is from the drawing, 1σ of each unknown, rad and mm.
const ANYBODY: [f64; HINGE_UNKNOWNS] = [0.15, 0.15, 12.0, 12.0, 0.15, 0.15, 8.0, 8.0, 5.0];
/// By how much the cable of an outlier is off, mm, and every which pose is one.
const OUTLIER_MM: f64 = 8.0;
const OUTLIERS: usize = 7;

/// An estimator with the set that it works on.
pub struct Elbow<T: Number> {
    estimator: HingeEstimator<T>,
    poses: Vec<HingePose<T>, POSES>,
}

/// A machine that is exactly known.
pub fn exact<T: Number>(bench: &mut Bench<T>) -> Option<()> {
    set(bench, Tolerance::exact(), false)
}

/// The same with a bad pose in seven.
pub fn outliers<T: Number>(bench: &mut Bench<T>) -> Option<()> {
    set(bench, Tolerance::exact(), true)
}

/// A machine built by hand: 20 unknown constants.
pub fn machine<T: Number>(bench: &mut Bench<T>) -> Option<()> {
    set(bench, hand_built(), false)
}

// Not inlined: the estimator passes through its frame on its way to its place.
#[inline(never)]
fn set<T: Number>(bench: &mut Bench<T>, tolerance: Tolerance<T>, spoilt: bool) -> Option<()> {
    let cables = cables();
    let rig = HingeRig::new(&cables, T::of(NOISE_MM)).ok()?;
    let (x, z) = (Vector3::x(), Vector3::z());
    let drawn = Hinge::through(&x, &(z * T::of(160.0)), &x, &(z * T::of(-70.0)));
    // Of a machine that is exactly known it only tells two solutions apart; else it is a prior, good for anybody.
    let is_exact = tolerance == Tolerance::exact();
    let sigma = (!is_exact).then(|| ANYBODY.map(T::of));
    let drawing = Drawing { hinge: drawn, sigma, range_rad: (T::of(-2.5), T::of(0.3)) };
    let rig = rig.with_tolerance(tolerance, [T::of(HOME_MM); MAX_CABLES]).ok()?.with_drawing(drawing);
    let mut poses = Vec::new();
    let (truth, mut random) = (truth::<T>(), 1);
    for index in 0..POSES {
        let angle = -T::of(FLEXION_RAD) * T::of_integer(index as i32) / T::of_integer(POSES as i32 - 1);
        let rotation = truth.rotation(angle);
        let mut lengths_mm = cables.each_ref().map(|cable| {
            let end = truth.platform_foot_mm() + rotation * (cable.end_mm - truth.foot_in_platform_mm());
            (end - cable.base_mm).norm_squared().root() + uniform_noise_mm(&mut random)
        });
        if spoilt && index % OUTLIERS == 3 {
            lengths_mm[index % MAX_CABLES] += T::of(OUTLIER_MM);
        }
        poses.push(HingePose::new(lengths_mm)).ok()?;
    }
    bench.held = Held::Elbow(Elbow { estimator: HingeEstimator::new(&rig, HingeSettings::for_rig(&rig)), poses });
    Some(())
}

fn cables<T: Number>() -> [CableEnds<T>; MAX_CABLES] {
    let point = |radius: f64, angle: f64| {
        let (sin, cos) = T::of(angle).sin_cos();
        Vector3::new(T::of(radius) * cos, T::of(radius) * sin, T::zero())
    };
    core::array::from_fn(|k| {
        let azimuth = AZIMUTH_RAD * (1 + 2 * k) as f64;
        let turned = if k % 2 == 0 { azimuth + ALTERNATING_RAD } else { azimuth - ALTERNATING_RAD };
        CableEnds { base_mm: point(RINGS_MM[0], azimuth), end_mm: point(RINGS_MM[1], turned), pulley: Pulley::none() }
    })
}

/// Somebody's elbow: 160 mm beyond the one ring and 70 mm before the other.
fn truth<T: Number>() -> Hinge<T> {
    let vector = |x: f64, y: f64, z: f64| Vector3::new(T::of(x), T::of(y), T::of(z));
    Hinge::through(
        &vector(1.0, 0.12, -0.07),
        &vector(0.0, 6.0, 160.0),
        &vector(1.0, 0.1, 0.05),
        &vector(0.0, 0.0, -70.0),
    )
}

/// From raw lengths to hinge and covariance. The error is that of the axis' foot point.
#[inline(never)]
pub fn identify<T: Number>(bench: &mut Bench<T>) -> Option<Answer<T>> {
    let at = bench.problem.truth;
    let Held::Elbow(Elbow { estimator, poses }) = &mut bench.held else { return None };
    let foot_mm = loop {
        match estimator.advance(poses) {
            HingeProgress::Working => {}
            HingeProgress::Identified(found) => break *found.hinge.foot_mm(),
            HingeProgress::Refused(_) => return None,
        }
    };
    let centre_mm = at.centre_mm + foot_mm - truth::<T>().foot_mm();
    Some(Answer { parameters: Parameters { centre_mm, ..at }, steps: 1 })
}

/// One slice: what it keeps a board from doing anything else.
#[inline(never)]
pub fn slice<T: Number>(bench: &mut Bench<T>, _: usize) -> Option<bool> {
    let Held::Elbow(Elbow { estimator, poses }) = &mut bench.held else { return None };
    match estimator.advance(poses) {
        HingeProgress::Working => Some(true),
        HingeProgress::Identified(_) | HingeProgress::Refused(HingeRefusal::SecondAxis { .. }) => Some(false),
        HingeProgress::Refused(_) => None,
    }
}
