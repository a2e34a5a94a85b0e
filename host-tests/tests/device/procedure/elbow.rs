//! An elbow calibrated by its procedure, with a virtual one in the machine: what it finds, and what it refuses.

use glenoid::identification::hinge::{Hinge, HingeEstimator, HingePose, HingeSettings, MAX_CABLES};
use glenoid::procedure::elbow::{ElbowProcedure, ElbowRig};
use glenoid::procedure::{Command, Guidance, PoseNotice, PoseSet, Reason, StateName};
use glenoid::rig::{CABLES, Tolerance};
use host_tests::study::elbow::scene::{Elbow, drawn};
use nalgebra::Vector3;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

const PERIOD_MS: u32 = 10;
const HOLD_MS: u32 = 600;
const START: Command = Command::Start { by_command_only: false, held_first: false, in_motion: false };

/// A procedure over an elbow.
struct Bench {
    procedure: ElbowProcedure,
    elbow: Elbow,
    /// A second axis in the platform and the angle about it.
    second: Option<(Vector3<f64>, f64)>,
    /// What the encoders that are not in use read.
    unused: [i32; 2],
    flexion_rad: f64,
    now_ms: u32,
    notices: Vec<PoseNotice>,
}

impl Bench {
    fn new() -> Self {
        // Near the drawing, in the drawn frames.
        let step = [0.03, -0.05, 4.0, -3.0, 0.04, 0.02, 2.0, 3.0, -2.0];
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let elbow = Elbow::of_hinge(&mut random, 4, &drawn().moved(&step), &Tolerance::exact());
        let procedure = ElbowProcedure::new(ElbowRig::four_cables().unwrap());
        let mut bench =
            Self { procedure, elbow, second: None, unused: [0; 2], flexion_rad: 0.0, now_ms: 0, notices: Vec::new() };
        bench.hold(HOLD_MS);
        bench
    }

    fn counts(&self) -> [i32; CABLES] {
        let mm_per_count = f64::from(self.procedure.rig().drum().mm_per_count());
        let lengths = self.elbow.reading_mm(self.flexion_rad, self.second);
        let [a, b, c, d] = lengths.map(|length| ((length - 230.0) / mm_per_count).round() as i32);
        [a, b, c, d, self.unused[0], self.unused[1]]
    }

    /// Time passes, with samples of the encoders; the solver gets the ticks that it wants.
    fn hold(&mut self, ms: u32) {
        for _ in 0..ms {
            self.now_ms += 1;
            if self.now_ms.is_multiple_of(PERIOD_MS) {
                self.procedure.sample(self.now_ms, &self.counts());
            }
            self.notices.extend(self.procedure.tick(self.now_ms));
            for _ in 0..2_000 {
                if self.procedure.is_busy() {
                    self.notices.extend(self.procedure.tick(self.now_ms));
                }
            }
        }
    }

    fn bend_to(&mut self, degrees: f64) {
        let (from, to) = (self.flexion_rad, -degrees.to_radians());
        for step in 1..=40 {
            self.flexion_rad = from + (to - from) * f64::from(step) / 40.0;
            self.hold(PERIOD_MS);
        }
        self.hold(HOLD_MS);
    }

    fn command(&mut self, command: Command) -> Reason {
        self.procedure.command(self.now_ms, command).reason
    }
}

/// Bends as the golden ratio spreads the flexions, until the state is another one.
fn bend_while(bench: &mut Bench, state: StateName, most_deg: f64) {
    for k in 0..60 {
        if bench.procedure.state() != state {
            return;
        }
        bench.bend_to(most_deg * (0.5 + 0.618_034 * f64::from(k)).fract());
    }
}

/// To the review, by itself.
fn to_review(bench: &mut Bench) {
    assert_eq!(bench.command(START), Reason::Fine);
    bend_while(bench, StateName::Collecting, 120.0);
    bench.hold(1_000);
    bend_while(bench, StateName::Verifying, 115.0);
    bench.hold(1_000);
}

/// The truth in single precision.
fn truth(bench: &Bench) -> Hinge<f32> {
    let hinge = bench.elbow.hinge();
    let single = |point: &Vector3<f64>| point.map(|x| x as f32);
    Hinge::through(
        &single(hinge.axis()),
        &single(&hinge.platform_foot_mm()),
        &single(&hinge.axis_in_platform()),
        &single(hinge.foot_in_platform_mm()),
    )
}

#[test]
fn an_elbow_that_bends_is_found_verified_and_taken_into_use() {
    let mut bench = Bench::new();
    to_review(&mut bench);
    assert_eq!(bench.procedure.state(), StateName::Review, "{:?}", bench.procedure.ending());
    let candidate = bench.procedure.candidate().unwrap().clone();
    let found = &candidate.found;
    let error = found.hinge.difference(&truth(&bench));
    for (k, error) in error.iter().enumerate() {
        let sigma = found.covariance[(k, k)].sqrt();
        assert!(error.abs() < 5.0 * sigma, "unknown {k}: {error}, 1σ {sigma}");
    }
    assert!(found.flexion_rad.to_degrees() > 100.0 && candidate.verification.poses >= 5);
    // The host's own run of the same lengths, to the bit.
    let rig = ElbowRig::four_cables().unwrap();
    let mut poses: Vec<HingePose<f32>> =
        bench.procedure.poses(PoseSet::Identification).iter().map(|pose| HingePose::new(pose.lengths_mm)).collect();
    let again = HingeEstimator::new(rig.hinge(), HingeSettings::for_rig(rig.hinge())).run(&mut poses).unwrap();
    assert_eq!((again.hinge, again.covariance), (found.hinge, found.covariance));

    assert_eq!(bench.procedure.live(), None);
    assert_eq!(bench.command(Command::Accept), Reason::Fine);
    assert_eq!(bench.procedure.live(), Some(&candidate));
    // Another run that is rejected leaves it as it is.
    to_review(&mut bench);
    assert_eq!(bench.command(Command::Reject), Reason::Fine);
    assert_eq!(bench.procedure.live(), Some(&candidate));
}

/// The standard deviation of each shown number is that of what the number does when the unknowns move.
#[test]
fn shown_numbers_move_as_their_standard_deviations_say() {
    let mut bench = Bench::new();
    to_review(&mut bench);
    let found = bench.procedure.candidate().unwrap().found.clone();
    let factor = found.covariance.map(f64::from).cholesky().unwrap().l();
    let wide = |v: &Vector3<f32>| v.map(f64::from);
    let hinge = Hinge::through(
        &wide(found.hinge.axis()),
        &wide(&found.hinge.platform_foot_mm()),
        &wide(&found.hinge.axis_in_platform()),
        &wide(found.hinge.foot_in_platform_mm()),
    );
    let numbers = |hinge: &Hinge<f64>| -> Vec<f64> {
        let vectors = [*hinge.axis(), *hinge.foot_mm(), hinge.axis_in_platform(), *hinge.foot_in_platform_mm()];
        vectors.iter().flat_map(|v| v.iter().copied()).chain([hinge.along_mm()]).collect()
    };
    let small = 1e-3;
    let mut variances = vec![0.0; 13];
    for column in factor.column_iter() {
        let moved = |by: f64| numbers(&hinge.moved((column * by).as_slice()));
        for ((variance, ahead), behind) in variances.iter_mut().zip(moved(small)).zip(moved(-small)) {
            *variance += ((ahead - behind) / (2.0 * small)).powi(2);
        }
    }
    for (k, ([_, sigma], variance)) in found.shown().iter().zip(&variances).enumerate() {
        assert!((f64::from(*sigma) - variance.sqrt()).abs() < 0.01 * variance.sqrt() + 1e-6, "{k}: {sigma} {variance}");
    }
}

#[test]
fn an_elbow_that_never_bends_is_told_to_and_refused() {
    let mut bench = Bench::new();
    assert_eq!(bench.command(START), Reason::Fine);
    for k in 0..8 {
        bench.bend_to(f64::from(k % 2) * 2.0);
    }
    assert_eq!(bench.procedure.pose_count(), 1);
    assert_eq!(bench.procedure.reason(bench.now_ms), Reason::PoseTooNear);
    bench.hold(121_000);
    assert_eq!(bench.procedure.state(), StateName::Failed);
    assert_eq!(bench.procedure.ending().unwrap().detail.reason, Reason::TooAlike);

    // A little: poses enough, and still nothing to identify from.
    assert_eq!(bench.command(Command::Acknowledge), Reason::Fine);
    assert_eq!(bench.command(START), Reason::Fine);
    for k in 0..8 {
        bench.bend_to(3.5 * f64::from(k));
    }
    assert_eq!(bench.procedure.guidance(bench.now_ms), Guidance::BendFurther);
    bench.hold(121_000);
    assert_eq!(bench.procedure.state(), StateName::Collecting, "{:?}", bench.procedure.ending());
    assert_eq!(bench.procedure.reason(bench.now_ms), Reason::TooAlike);
    assert_eq!(bench.procedure.guidance(bench.now_ms), Guidance::BendFurther);
    bench.hold(121_000);
    assert_eq!(bench.procedure.ending().unwrap().detail.reason, Reason::TooAlike);
    assert_eq!(bench.procedure.live(), None);
}

#[test]
fn a_joint_with_a_second_axis_is_refused_by_name() {
    let mut bench = Bench::new();
    let axis = bench.elbow.axis_in_platform().cross(&Vector3::new(0.3, -0.5, 0.8)).normalize();
    assert_eq!(bench.command(START), Reason::Fine);
    for k in 0..60 {
        if bench.procedure.state() != StateName::Collecting {
            break;
        }
        bench.second = Some((axis, if k % 2 == 0 { 0.05 } else { -0.05 }));
        bench.bend_to(120.0 * (0.5 + 0.618_034 * f64::from(k)).fract());
    }
    bench.hold(2_000);
    assert_eq!(bench.procedure.state(), StateName::Failed);
    let detail = bench.procedure.ending().unwrap().detail;
    assert_eq!(detail.reason, Reason::SecondAxis);
    let cosine = Vector3::from(detail.axis.unwrap()).map(f64::from).dot(&axis).abs();
    assert!(cosine > 0.9, "{detail:?} against {axis:?}");
}

#[test]
fn a_strap_that_slips_between_the_sets_fails_the_second() {
    let mut bench = Bench::new();
    assert_eq!(bench.command(START), Reason::Fine);
    bend_while(&mut bench, StateName::Collecting, 120.0);
    bench.hold(1_000);
    assert_eq!(bench.procedure.state(), StateName::Verifying);
    // The base moves by 2 mm across the axis.
    let slipped = bench.elbow.hinge().moved(&[0.0, 0.0, 2.0, -2.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let mut random = ChaCha8Rng::seed_from_u64(3);
    bench.elbow = Elbow::of_hinge(&mut random, MAX_CABLES, &slipped, &Tolerance::exact());
    bend_while(&mut bench, StateName::Verifying, 115.0);
    bench.hold(1_000);
    assert_eq!(bench.procedure.ending().unwrap().detail.reason, Reason::VerificationFailed);
    assert_eq!(bench.procedure.live(), None);
}

/// Encoders that the rig has not neither fault nor count; those that it has do.
#[test]
fn only_the_cables_of_the_rig_count() {
    let mut bench = Bench::new();
    let mut random = ChaCha8Rng::seed_from_u64(9);
    assert_eq!(bench.command(START), Reason::Fine);
    for k in 0..10 {
        bench.unused = [random.random(), 0];
        bench.bend_to(10.0 * f64::from(k));
        assert_eq!(bench.procedure.fault(bench.now_ms), None);
    }
    assert_eq!(bench.procedure.pose_count(), 10);
    // The base of the fourth cable jumps and stays there: its count is lost.
    let now_ms = bench.now_ms;
    for sample in 1..10 {
        let mut counts = bench.counts();
        counts[3] += 5_000;
        bench.procedure.sample(now_ms + sample * PERIOD_MS, &counts);
        bench.procedure.tick(now_ms + sample * PERIOD_MS);
    }
    let ending = bench.procedure.ending().unwrap();
    assert_eq!((ending.detail.reason, ending.detail.cable), (Reason::EncoderJumped, 4));
}

#[test]
fn what_an_elbow_has_not_is_refused_by_name() {
    let mut bench = Bench::new();
    for (held_first, in_motion) in [(true, false), (false, true)] {
        let start = Command::Start { by_command_only: false, held_first, in_motion };
        assert_eq!(bench.command(start), Reason::NotOfHinge);
    }
    assert_eq!(bench.procedure.state(), StateName::Idle);
    let by_command = Command::Start { by_command_only: true, held_first: false, in_motion: false };
    assert_eq!(bench.command(by_command), Reason::Fine);
    assert_eq!(bench.command(Command::Identify), Reason::TooFewPoses);
    assert_eq!(bench.command(Command::Capture), Reason::Fine);
    assert_eq!(bench.command(Command::Capture), Reason::PoseTooNear);
    assert_eq!(bench.command(Command::Verify), Reason::WrongState);
    assert_eq!(bench.command(Command::Abort), Reason::Fine);
    assert_eq!(bench.procedure.pose_count(), 0);
}
