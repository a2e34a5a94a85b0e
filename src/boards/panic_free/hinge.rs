//! The elbow, and the hand through the whole arm.

use core::hint::black_box;

use glenoid::device::Event;
use glenoid::identification::arm::{Arm, ArmPose, Ball, Mount};
use glenoid::identification::carried_point::CarriedPoint;
use glenoid::identification::hinge::{
    Drawing, HINGE_UNKNOWNS, Hinge, HingeEstimator, HingePose, HingeRig, HingeSettings, MAX_CABLES,
};
use glenoid::identification::{Estimator, EstimatorSettings, Machine, Noise, Pose};
use glenoid::kinematics::CableLengths;
use glenoid::rig::{CABLES, CableEnds, Rig, Tolerance};
use nalgebra::{Matrix3, Vector3};

/// A hinge from anything.
pub fn identify() -> Event {
    let cables: &[CableEnds<f32>] = black_box(&[]);
    let drawing = Drawing {
        hinge: Hinge::through(&black_box(Vector3::x()), &any(), &black_box(Vector3::x()), &any()),
        sigma: black_box(Some([0.0; HINGE_UNKNOWNS])),
        range_rad: black_box((0.0, 0.0)),
    };
    let rig = HingeRig::new(cables, black_box(0.0))
        .and_then(|rig| rig.with_tolerance(black_box(Tolerance::exact()), black_box([0.0; MAX_CABLES])))
        .map(|rig| rig.with_drawing(black_box(drawing)));
    let Ok(rig) = rig else { return Event::Tick };
    let settings = HingeSettings { noise: black_box(Noise::EstimatedUpTo(0.0)), ..HingeSettings::for_rig(&rig) };
    let mut estimator = HingeEstimator::new(&rig, settings);
    let poses: &mut [HingePose<f32>] = black_box(&mut []);
    match estimator.run(poses) {
        Ok(found) => drop(black_box(found.sigmas())),
        Err(refusal) => drop(black_box(refusal.text())),
    }
    carry(&estimator);
    Event::Tick
}

/// The hand through three joints.
fn carry(elbow: &HingeEstimator<f32>) {
    let (Ok(rig), Ok(lengths)) =
        (black_box(Rig::shoulder(black_box(150.0))), CableLengths::new(black_box([0.0; CABLES])))
    else {
        return;
    };
    let machine = Machine::new(&rig);
    let estimator = Estimator::new(&machine, rig.nominal(), EstimatorSettings::for_rig(&rig));
    let ball = Ball { estimator: &estimator, machine: &machine };
    let mount = Mount { rotation: black_box(Matrix3::identity()), origin_mm: any(), sigma_mm: 0.0, sigma_rad: 0.0 };
    let arm = Arm { shoulder: ball, upper_arm: mount, elbow, forearm: mount, wrist: ball };
    let pose = Pose::new(lengths);
    let pose = ArmPose { shoulder: pose, elbow_mm: black_box([0.0; MAX_CABLES]), wrist: pose };
    let _ = black_box(arm.position(&pose, &any()));
    black_box(arm.segments());
    black_box(elbow.carry(&pose.elbow_mm, &CarriedPoint::exact(any())));
}

fn any() -> Vector3<f32> {
    black_box(Vector3::zeros())
}
