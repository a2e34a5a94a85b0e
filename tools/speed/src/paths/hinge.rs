//! The elbow: a hinge from four cables and nothing else.

use core::mem::size_of;

use glenoid::identification::hinge::{Hinge, HingeEstimator, HingePose, HingeRig, HingeSettings, MAX_CABLES};
use glenoid::rig::{CableEnds, Parameters, Pulley};
use heapless::Vec;
use nalgebra::Vector3;

use super::{Bench, Held};
use crate::measure::{Answer, Number};
use crate::problem::{NOISE_LIMIT_MM, NOISE_MM, uniform};

const POSES: usize = 30;
/// Flexion from pose to pose, and in the first, rad: 6 to 119 degrees.
const STEP_RAD: f64 = 0.068;
const FIRST_RAD: f64 = 0.1;
/// Rings on the upper arm and the forearm, mm; azimuths of a cable's two ends, degrees.
const RINGS_MM: (f64, f64) = (60.0, 45.0);
const AZIMUTHS_DEG: [(f64, f64); MAX_CABLES] = [(45.0, 70.0), (135.0, 110.0), (225.0, 250.0), (315.0, 290.0)];

/// The estimator and its poses.
pub struct Elbow<T: Number> {
    estimator: HingeEstimator<T>,
    poses: Vec<HingePose<T>, POSES>,
}

/// What it keeps, bytes.
pub const fn state_bytes<T: Number>() -> usize {
    size_of::<Elbow<T>>()
}

/// A point of the true axis, next to the middle of the base, in place of a centre.
pub fn truth<T: Number>() -> Parameters<T> {
    at(&true_hinge())
}

fn at<T: Number>(hinge: &Hinge<T>) -> Parameters<T> {
    Parameters { centre_mm: hinge.nearest_mm(&Vector3::zeros()), radii_mm: [T::zero(); 3] }
}

fn true_hinge<T: Number>() -> Hinge<T> {
    let point = |x: f64, y: f64, z: f64| Vector3::new(T::of(x), T::of(y), T::of(z));
    Hinge::through(&point(1.0, 0.1, -0.05), &point(4.0, -3.0, 162.0), &point(1.0, 0.03, 0.04), &point(0.0, 2.0, -71.0))
}

fn cables<T: Number>() -> [CableEnds<T>; MAX_CABLES] {
    let point = |radius_mm: f64, degrees: f64| {
        let (sin, cos) = T::of(degrees.to_radians()).sin_cos();
        Vector3::new(cos, sin, T::zero()) * T::of(radius_mm)
    };
    AZIMUTHS_DEG.map(|(base, end)| CableEnds {
        base_mm: point(RINGS_MM.0, base),
        end_mm: point(RINGS_MM.1, end),
        pulley: Pulley::none(),
    })
}

/// A machine that is exactly known, 30 poses with noise.
#[inline(never)]
pub fn begin<T: Number>(bench: &mut Bench<T>) -> Option<()> {
    let (hinge, cables) = (true_hinge::<T>(), cables());
    let mut random = 0x0bad_5eed_u32;
    let mut poses = Vec::new();
    for index in 0..POSES {
        let angle = -(T::of(FIRST_RAD) + T::of(STEP_RAD) * T::of_integer(index as i32));
        let rotation = hinge.rotation(angle);
        let lengths = cables.each_ref().map(|cable| {
            let end = hinge.platform_foot_mm() + rotation * (cable.end_mm - hinge.foot_in_platform_mm());
            (end - cable.base_mm).norm_squared().root() + uniform::<T>(&mut random) * T::of(NOISE_LIMIT_MM)
        });
        poses.push(HingePose::new(lengths)).ok()?;
    }
    let rig = HingeRig::new(&cables, T::of(NOISE_MM)).ok()?;
    bench.held = Held::Elbow(Elbow { estimator: HingeEstimator::new(&rig, HingeSettings::for_rig(&rig)), poses });
    Some(())
}

/// From raw lengths to the axis in both bodies and its covariance, in one go.
#[inline(never)]
pub fn run<T: Number>(bench: &mut Bench<T>) -> Option<Answer<T>> {
    let Bench { held: Held::Elbow(elbow), .. } = bench else { return None };
    let found = elbow.estimator.run(&mut elbow.poses).ok()?;
    Some(Answer { parameters: at(&found.hinge), steps: 1 })
}
