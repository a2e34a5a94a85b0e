//! The library's types from the oracle's, in either precision.

use super::{Worn, parameters};
use glenoid::identification::{Estimator, EstimatorSettings, Identified, JointChoice, Machine, Pose, Refusal};
use glenoid::kinematics::CableLengths;
use glenoid::rig::{Drum, Parameters, Rig};
use glenoid::scalar::Real;
use host_tests::literal::{Estimate, Lengths};

/// The rig that the library is given for a worn machine. The drum plays no part in the identification.
pub fn rig<T: Real>(worn: &Worn) -> Rig<T> {
    let drum = Drum {
        radius_mm: T::of(15.0),
        counts_per_turn: T::of(4096.0),
        home_length_mm: [T::of(250.0); 6],
        fastest_mm_per_s: T::of(1500.0),
    };
    let base = worn.base_mm.map(|point| point.map(T::of));
    Rig::new(base, worn.machine().edges_mm.map(T::of), drum, T::of(0.06), as_parameters(&worn.truth()))
        .expect("a rig that can be built")
}

/// An estimate as the library's parameters.
pub fn as_parameters<T: Real>(estimate: &Estimate<f64>) -> Parameters<T> {
    Parameters::from_array(parameters(estimate).map(T::of))
}

/// Cable lengths as the library's.
pub fn as_cables<T: Real>(lengths: &Lengths<f64>) -> CableLengths<T> {
    CableLengths::new(lengths.map(T::of)).expect("lengths of a real pose")
}

/// A set of cable lengths as the library's.
pub fn as_lengths<T: Real>(poses: &[Lengths<f64>]) -> Vec<CableLengths<T>> {
    poses.iter().map(as_cables).collect()
}

/// A set of poses as the library's, none of them placed.
pub fn as_poses<T: Real>(poses: &[Lengths<f64>]) -> Vec<Pose<T>> {
    poses.iter().map(|lengths| Pose::new(as_cables(lengths))).collect()
}

/// The limits of acceptance for a rig, the joint a ball: no other model is asked for.
pub fn settings<T: Real>(rig: &Rig<T>) -> EstimatorSettings<T> {
    EstimatorSettings { joint: JointChoice::Ball, ..EstimatorSettings::for_rig(rig) }
}

/// The estimator's answer for poses that nothing has been made of yet.
pub fn estimate<T: Real>(
    rig: &Rig<T>,
    machine: &Machine<T>,
    settings: EstimatorSettings<T>,
    poses: &[Pose<T>],
) -> Result<Identified<T>, Refusal> {
    Estimator::new(machine, rig.nominal(), settings).run(machine, &mut poses.to_vec())
}

/// The same with the rig's own settings, the machine exactly known.
pub fn identify<T: Real>(worn: &Worn, poses: &[Lengths<f64>]) -> Result<Identified<T>, Refusal> {
    let rig = rig::<T>(worn);
    estimate(&rig, &Machine::new(&rig), settings(&rig), &as_poses(poses))
}
