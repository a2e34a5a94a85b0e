//! Somebody's arm in its machines, which goes to poses that it is told and reads its lengths there.

use crate::estimation::{Estimation, estimate};
use crate::study::arm::{Case, FOREARM_MM, HAND_MM, UPPER_ARM_MM, WRIST, mount, through};
use crate::study::built::{BuiltMachine, NOISE_SIGMA_MM, Worn};
use crate::study::elbow::scene::{Elbow, drawn};
use crate::study::elbow::{ANYBODY, RANGE_RAD};
use crate::study::scene::{Reach, normal};
use glenoid::identification::arm::{Arm, ArmPose, Ball, Mount};
use glenoid::identification::hinge::{Drawing, HingeEstimator, HingePose, HingeRig, HingeSettings, MAX_CABLES};
use glenoid::identification::{EstimatorSettings, Machine, Noise, Pose};
use glenoid::kinematics::CableLengths;
use glenoid::rig::{CABLES, Rig};
use nalgebra::{Matrix3, Rotation3, Vector3};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// A ball in its machine.
pub struct BallJoint {
    built: BuiltMachine,
    worn: Worn,
    /// The machine as it is known.
    pub machine: Machine<f64>,
    reach: Reach,
}

/// Poses of a ball: rotations from home, and what was read there, mm.
#[derive(Clone, Default)]
pub struct BallLog {
    rotations: Vec<Rotation3<f64>>,
    readings: Vec<[f64; CABLES]>,
}

impl BallJoint {
    fn new(random: &mut ChaCha8Rng, rig: Rig<f64>, case: &Case, off_mm: [f64; 2], reach: Reach) -> Option<Self> {
        let built = BuiltMachine::of(random, rig, &case.tolerance, case.tolerance).ok()?;
        let worn = built.worn_within(random, off_mm[0], off_mm[1]);
        Some(Self { machine: Machine::new(&built.stated), built, worn, reach })
    }

    /// The lengths at home by the drawing, mm.
    pub fn home_mm(&self) -> &[f64; CABLES] {
        &self.built.stated.drum().home_length_mm
    }

    /// Goes to a rotation from home.
    pub fn go(&self, random: &mut ChaCha8Rng, log: &mut BallLog, rotation: Rotation3<f64>) {
        log.readings.push(self.built.reading(random, &self.worn, &rotation));
        log.rotations.push(rotation);
    }

    /// Goes anywhere within its reach, so many times.
    pub fn go_anywhere(&self, random: &mut ChaCha8Rng, log: &mut BallLog, times: usize) {
        for _ in 0..times {
            let rotation = self.reach.rotation(random);
            self.go(random, log, rotation);
        }
    }

    /// Goes where the platform is turned so ({P} to {B}) by an estimate from the log.
    pub fn go_to(&self, random: &mut ChaCha8Rng, log: &mut BallLog, by: &Estimation<f64>, turned: &Matrix3<f64>) {
        // From the estimate's frames to home, by the log's first pose.
        let between = turned * by.poses[0].rotation().transpose();
        let rotation = Rotation3::from_matrix_unchecked(between) * log.rotations[0];
        self.go(random, log, rotation);
    }

    /// Identified from a log.
    pub fn identified(&self, log: &BallLog) -> Option<Estimation<f64>> {
        let rig = &self.built.stated;
        let lengths: Vec<_> = log.readings.iter().map(|six| CableLengths::new(*six)).collect::<Result<_, _>>().ok()?;
        let settings = EstimatorSettings { noise: Noise::Known(NOISE_SIGMA_MM), ..EstimatorSettings::for_rig(rig) };
        let estimation = estimate(&self.machine, rig, settings, &lengths);
        estimation.outcome.is_ok().then_some(estimation)
    }

    fn pose(&self, random: &mut ChaCha8Rng, rotation: &Rotation3<f64>) -> Option<Pose<f64>> {
        CableLengths::new(self.built.reading(random, &self.worn, rotation)).ok().map(Pose::new)
    }
}

/// The elbow in its machine.
pub struct ElbowJoint {
    elbow: Elbow,
    rig: HingeRig<f64>,
}

/// Poses of an elbow: its flexions, rad, and what was read there, mm.
#[derive(Clone, Default)]
pub struct ElbowLog {
    flexions_rad: Vec<f64>,
    readings: Vec<[f64; MAX_CABLES]>,
}

/// An elbow that is identified.
pub struct FoundElbow {
    /// The estimator at its end.
    pub estimator: HingeEstimator<f64>,
    /// The log's poses.
    pub poses: Vec<HingePose<f64>>,
}

impl ElbowJoint {
    fn new(random: &mut ChaCha8Rng, case: &Case) -> Option<Self> {
        let step: [f64; 9] = std::array::from_fn(|k| ANYBODY[k] * normal(random));
        let elbow = Elbow::of_hinge(random, 4, &drawn().moved(&step), &case.tolerance);
        let mut rig = elbow.rig(case.tolerance).ok()?;
        if case.drawing {
            rig = rig.with_drawing(Drawing { hinge: drawn(), sigma: Some(ANYBODY), range_rad: RANGE_RAD });
        }
        Some(Self { elbow, rig })
    }

    /// Goes to a flexion, rad.
    pub fn go(&self, random: &mut ChaCha8Rng, log: &mut ElbowLog, flexion_rad: f64) {
        log.readings.extend(self.elbow.readings_mm(random, &[flexion_rad]));
        log.flexions_rad.push(flexion_rad);
    }

    /// Goes anywhere from 0 to 120 degrees, so many times.
    pub fn go_anywhere(&self, random: &mut ChaCha8Rng, log: &mut ElbowLog, times: usize) {
        for _ in 0..times {
            let flexion = -random.random_range(0.0..=120.0_f64).to_radians();
            self.go(random, log, flexion);
        }
    }

    /// Goes to an angle from the zero of a hinge that was found from the log, rad.
    pub fn go_to(&self, random: &mut ChaCha8Rng, log: &mut ElbowLog, by: &FoundElbow, angle_rad: f64) {
        // The hinge has a zero of its own, and may be named the other way round.
        let from_first = |pose: usize| (by.poses[pose].angle_rad - by.poses[0].angle_rad, log.flexions_rad[pose]);
        let moved = (1..by.poses.len()).map(from_first).max_by(|one, other| one.0.abs().total_cmp(&other.0.abs()));
        let first = log.flexions_rad[0];
        let sign = moved.map_or(1.0, |(angle, flexion)| (angle * (flexion - first)).signum());
        self.go(random, log, first + sign * (angle_rad - by.poses[0].angle_rad));
    }

    /// Identified from a log.
    pub fn identified(&self, log: &ElbowLog) -> Option<FoundElbow> {
        let mut poses: Vec<_> = log.readings.iter().copied().map(HingePose::new).collect();
        let mut estimator = HingeEstimator::new(&self.rig, HingeSettings::for_rig(&self.rig));
        estimator.run(&mut poses).ok()?;
        Some(FoundElbow { estimator, poses })
    }
}

/// The logs of all three.
#[derive(Clone, Default)]
pub struct Logs {
    pub shoulder: BallLog,
    pub elbow: ElbowLog,
    pub wrist: BallLog,
}

/// All three, identified.
pub struct Found {
    pub shoulder: Estimation<f64>,
    pub elbow: FoundElbow,
    pub wrist: Estimation<f64>,
}

/// An arm, and how the modules stand on its limbs: as stated, and as they do.
pub struct Person {
    pub shoulder: BallJoint,
    pub elbow: ElbowJoint,
    pub wrist: BallJoint,
    upper_arm: (Mount<f64>, Mount<f64>),
    forearm: (Mount<f64>, Mount<f64>),
}

impl Person {
    /// Somebody.
    pub fn new(random: &mut ChaCha8Rng, case: &Case) -> Option<Self> {
        let mounted = |random: &mut ChaCha8Rng, origin| mount(random, case.mount_mm, case.mount_rad, origin);
        Some(Self {
            shoulder: BallJoint::new(random, Rig::shoulder(150.0).ok()?, case, [20.0, 10.0], Reach::USUAL)?,
            wrist: BallJoint::new(random, Rig::wrist().ok()?, case, [4.0, 3.0], WRIST)?,
            upper_arm: mounted(random, UPPER_ARM_MM),
            forearm: mounted(random, FOREARM_MM),
            elbow: ElbowJoint::new(random, case)?,
        })
    }

    /// Each module goes anywhere, so many times.
    pub fn go_anywhere(&self, random: &mut ChaCha8Rng, logs: &mut Logs, times: usize) {
        self.shoulder.go_anywhere(random, &mut logs.shoulder, times);
        self.elbow.go_anywhere(random, &mut logs.elbow, times);
        self.wrist.go_anywhere(random, &mut logs.wrist, times);
    }

    /// Identified; `None` when a module is refused.
    pub fn identified(&self, logs: &Logs) -> Option<Found> {
        Some(Found {
            shoulder: self.shoulder.identified(&logs.shoulder)?,
            elbow: self.elbow.identified(&logs.elbow)?,
            wrist: self.wrist.identified(&logs.wrist)?,
        })
    }

    /// As a chain.
    pub fn chain<'a>(&'a self, found: &'a Found) -> Arm<'a, f64> {
        Arm {
            shoulder: Ball { estimator: &found.shoulder.estimator, machine: &self.shoulder.machine },
            upper_arm: self.upper_arm.0,
            elbow: &found.elbow.estimator,
            forearm: self.forearm.0,
            wrist: Ball { estimator: &found.wrist.estimator, machine: &self.wrist.machine },
        }
    }

    /// What all cables read in some posture, and where the hand is, mm.
    pub fn posture(&self, random: &mut ChaCha8Rng) -> Option<(ArmPose<f64>, Vector3<f64>)> {
        let (raised, waved) = (self.shoulder.reach.rotation(random), self.wrist.reach.rotation(random));
        let bent = -random.random_range(5.0_f64..115.0).to_radians();
        let posture = ArmPose {
            shoulder: self.shoulder.pose(random, &raised)?,
            elbow_mm: self.elbow.elbow.readings_mm(random, &[bent])[0],
            wrist: self.wrist.pose(random, &waved)?,
        };
        let on_forearm = through(&self.forearm.1, &self.wrist.built.carried_mm(&self.wrist.worn, &waved, &HAND_MM));
        let on_upper_arm = through(&self.upper_arm.1, &self.elbow.elbow.carried_mm(&on_forearm, bent));
        Some((posture, self.shoulder.built.carried_mm(&self.shoulder.worn, &raised, &on_upper_arm)))
    }
}
