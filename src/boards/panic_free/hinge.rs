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
use glenoid::procedure::elbow::{ElbowProcedure, ElbowRig};
use glenoid::procedure::{Command, PoseSet};
use glenoid::rig::{CABLES, CableEnds, Drum, Rig, Tolerance};
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
    black_box(estimator.verify(&black_box([0.0; MAX_CABLES])));
    carry(&estimator);
    calibrate();
    Event::Tick
}

/// An elbow's procedure with anything that can happen to it.
fn calibrate() {
    let cables: &[CableEnds<f32>] = black_box(&[]);
    let drawing = Drawing {
        hinge: Hinge::through(&any(), &any(), &any(), &any()),
        sigma: black_box(None),
        range_rad: black_box((0.0, 0.0)),
    };
    let drum =
        black_box(Drum { radius_mm: 0.0, counts_per_turn: 0.0, home_length_mm: [0.0; CABLES], fastest_mm_per_s: 0.0 });
    let made = ElbowRig::new(cables, drum, black_box(0.0), black_box(Tolerance::exact()), black_box(Some(drawing)));
    let Ok(rig) = made.or(ElbowRig::four_cables()) else { return };
    let mut procedure = ElbowProcedure::new(rig);
    procedure.resume_at(black_box(0), black_box(0));
    black_box(procedure.set_wearer(black_box(0)));
    loop {
        let now_ms = black_box(0);
        procedure.sample(now_ms, &black_box([0; CABLES]));
        black_box(procedure.command(now_ms, black_box(Command::Capture)));
        black_box(procedure.tick(now_ms));
        black_box((procedure.guidance(now_ms), procedure.reason(now_ms), procedure.progress_percent()));
        black_box(procedure.lengths_mm(black_box(PoseSet::HeldOut), black_box(0)));
        black_box(procedure.candidate().map(|candidate| candidate.found.shown()));
        if black_box(true) {
            return;
        }
    }
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
