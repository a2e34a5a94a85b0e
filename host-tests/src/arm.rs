//! `cargo arm`: three logs, one of each module, and one posture: where the hand is, and how well that is known.

mod posture;
mod proposal;
mod range;
mod report;
mod request;

pub use posture::{Cause, Contradiction};
pub use proposal::{PROPOSED, Proposed, Proposer};
pub use report::{ArmReport, FurtherPose, ModulePose, ModulePoses, Point, Segment};
pub use request::ArmFile;

use crate::estimation::{Estimation, estimate_poses};
use crate::identify;
use crate::identify::hinge::{self, Solved};
use crate::identify::input_error::InputError;
use crate::identify::report::Status;
use glenoid::identification::arm::{Arm, ArmPose, Ball, FurtherPoses, Module};
use glenoid::identification::hinge::MAX_CABLES;
use glenoid::identification::joint::Joint;
use glenoid::identification::{EstimatorSettings, Machine, Noise, Pose};
use glenoid::kinematics::CableLengths;
use glenoid::rig::{CABLES, Correction, Rig};
use proposal::elbow_readings_mm;
use request::BallFile;
use std::path::Path;

/// Of the poses among which the further ones are chosen.
const SEED: u64 = 1;

/// What to do where a joint is no ball.
const HOLD: &str =
    "Record the log with the shoulder blade held and the arm within 30 degrees: so it turns about one centre.";

/// A ball, identified.
struct Identified {
    machine: Machine<f64>,
    estimation: Estimation<f64>,
    posture: Pose<f64>,
}

/// Reads the arm's file and what it names, identifies the three modules and carries the hand through them.
///
/// # Errors
/// [`InputError`] names the place that cannot be read. A refusal is not an error.
pub fn run(path: &Path) -> Result<ArmReport, InputError> {
    let arm = ArmFile::read(path)?;
    if are_exchanged(&arm) {
        let remedy = format!("Exchange log = ... of [shoulder] and [wrist] in {}.", arm.file);
        return Ok(ArmReport::refused(
            Module::Shoulder,
            "its log is that of the wrist, and the other way round",
            remedy,
        ));
    }
    let shoulder = ball(&arm.shoulder, &arm.shoulder.log)?;
    let elbow = elbow(&arm)?;
    let wrist = ball(&arm.wrist, &arm.wrist.log)?;
    for (module, file, ball) in [(Module::Shoulder, &arm.shoulder, &shoulder), (Module::Wrist, &arm.wrist, &wrist)] {
        if let Err(refusal) = &ball.estimation.outcome {
            return Ok(ArmReport::refused(module, refusal.text(), file.identify()));
        }
        if matches!(ball.estimation.estimator.joint(), Joint::Moving(_)) {
            let reason = "its centre moves with the limb, and such a joint is not carried";
            return Ok(ArmReport::refused(module, reason, HOLD.to_owned()));
        }
    }
    if let Err(refusal) = &elbow.outcome {
        return Ok(ArmReport::refused(Module::Elbow, refusal.text(), arm.elbow.identify()));
    }
    if let Some(contradicted) = contradicted(&arm, [&shoulder, &wrist], &elbow) {
        return Ok(contradicted);
    }
    let chain = Arm {
        shoulder: Ball { estimator: &shoulder.estimation.estimator, machine: &shoulder.machine },
        upper_arm: arm.upper_arm,
        elbow: &elbow.estimator,
        forearm: arm.forearm,
        wrist: Ball { estimator: &wrist.estimation.estimator, machine: &wrist.machine },
    };
    let posture = ArmPose { shoulder: shoulder.posture, elbow_mm: arm.elbow.posture_mm, wrist: wrist.posture };
    Ok(match chain.position(&posture, &arm.hand_mm) {
        Ok(position) => {
            let further = further_poses(&chain, &posture, &arm, [&shoulder, &wrist], &elbow);
            ArmReport::accepted(&position, &chain.segments(), further)
        }
        Err(module) => ArmReport::refused(module, "the lengths of the posture fit no pose", arm.read_again(module)),
    })
}

/// The first module whose joint cannot have the lengths of the posture.
fn contradicted(arm: &ArmFile, [shoulder, wrist]: [&Identified; 2], elbow: &Solved<f64>) -> Option<ArmReport> {
    let ball = |file: &BallFile, ball: &Identified| {
        let samples = ball.posture.samples;
        posture::contradiction(*file.posture.as_mm(), CABLES, CABLES - 3, |lengths_mm| {
            let lengths = CableLengths::new(*lengths_mm).ok()?.corrected(&file.rig.rig).ok()?;
            let pose = Pose::new(lengths).averaged_over(samples);
            Some(ball.estimation.estimator.verify(&ball.machine, &pose)?.chi_square)
        })
    };
    let cables = arm.elbow.rig.cables().len();
    let hinge = || {
        let chi_square = |lengths_mm: &[f64; MAX_CABLES]| Some(elbow.estimator.verify(lengths_mm)?.chi_square);
        posture::contradiction(arm.elbow.posture_mm, cables, cables - 1, chi_square)
    };
    let found = ball(&arm.shoulder, shoulder)
        .map(|found| (Module::Shoulder, found))
        .or_else(|| Some((Module::Elbow, hinge()?)))
        .or_else(|| Some((Module::Wrist, ball(&arm.wrist, wrist)?)));
    found.map(|(module, found)| ArmReport::contradicted(module, found, arm.read_again(module)))
}

/// The poses of each module that would narrow the hand's covariance most.
fn further_poses(
    chain: &Arm<'_, f64>,
    posture: &ArmPose<f64>,
    arm: &ArmFile,
    [shoulder, wrist]: [&Identified; 2],
    elbow: &Solved<f64>,
) -> Vec<ModulePoses> {
    let proposer = Proposer { arm: chain, posture, hand_mm: arm.hand_mm, seed: SEED };
    let Some(now_mm) = proposer.sigma_mm(&FurtherPoses::default()) else { return Vec::new() };
    let module = |module, poses: Vec<ModulePose>| {
        let then_mm = poses.last().map_or(now_mm, |pose| pose.hand_sigma_mm);
        ModulePoses { module: report::name(module), hand_sigma_mm: [now_mm, then_mm], poses }
    };
    let ball = |which, file: &BallFile, ball: &Identified| {
        let (rig, samples) = (&file.rig.rig, file.rig.samples_a_row.unwrap_or(1));
        let home_mm = &rig.drum().home_length_mm;
        let proposed = proposer.of_ball(which, &ball.estimation.poses, home_mm, samples);
        let poses = proposed.iter().map(|Proposed { pose, hand_sigma_mm }| ModulePose {
            lengths_mm: uncorrected_mm(pose.lengths().as_mm(), rig).to_vec(),
            hand_sigma_mm: *hand_sigma_mm,
        });
        module(which, poses.collect())
    };
    let mut of_elbow = Vec::new();
    if let Ok(found) = &elbow.outcome {
        let poses = proposer.of_elbow(&elbow.poses);
        of_elbow.extend(poses.iter().map(|Proposed { pose, hand_sigma_mm }| ModulePose {
            lengths_mm: elbow_readings_mm(found, *pose)[..arm.elbow.rig.cables().len()].to_vec(),
            hand_sigma_mm: *hand_sigma_mm,
        }));
    }
    vec![
        ball(Module::Shoulder, &arm.shoulder, shoulder),
        module(Module::Elbow, of_elbow),
        ball(Module::Wrist, &arm.wrist, wrist),
    ]
}

/// What the encoders read that is corrected to these lengths by what commissioning has found, mm.
fn uncorrected_mm(lengths_mm: &[f64; CABLES], rig: &Rig<f64>) -> [f64; CABLES] {
    let Some(Correction { offset_mm, scale }) = rig.correction() else { return *lengths_mm };
    let home = &rig.drum().home_length_mm;
    std::array::from_fn(|k| home[k] + scale[k] * (lengths_mm[k] - home[k]) + offset_mm[k])
}

fn ball(file: &BallFile, log: &Path) -> Result<Identified, InputError> {
    let rig = &file.rig.rig;
    let log = identify::log(log, rig)?.with_repeated_rows_merged(file.rig.row_noise_mm());
    let machine = file.rig.machine(rig);
    let poses = log.poses(log.rows().iter(), rig, file.rig.samples_a_row)?;
    let posture = file.posture.corrected(rig).map_err(|error| InputError::Request(error.fault.text().to_owned()))?;
    let noise = Noise::Known(rig.length_noise_mm());
    let settings = EstimatorSettings { noise, ..EstimatorSettings::for_rig(rig) };
    let estimation = estimate_poses(&machine, rig, settings, None, poses);
    let posture = Pose::new(posture).averaged_over(file.rig.samples_a_row.unwrap_or(1));
    Ok(Identified { machine, estimation, posture })
}

/// Are shoulder and wrist each identified from the log of the other, and not from their own?
fn are_exchanged(arm: &ArmFile) -> bool {
    let is_found = |file: &BallFile, log: &Path| ball(file, log).is_ok_and(|ball| ball.estimation.outcome.is_ok());
    let (shoulder, wrist) = (&arm.shoulder, &arm.wrist);
    !is_found(shoulder, &shoulder.log) && is_found(shoulder, &wrist.log) && is_found(wrist, &shoulder.log)
}

fn elbow(arm: &ArmFile) -> Result<Solved<f64>, InputError> {
    let rig = &arm.elbow.rig;
    let log = hinge::read_log(&arm.elbow.log, rig)?.with_repeated_rows_merged(rig.length_noise_mm());
    hinge::solve(rig, &log, Some(rig.length_noise_mm()))
}

/// Was the whole arm accepted?
pub fn is_accepted(report: &ArmReport) -> bool {
    report.status == Status::Accepted
}
