//! `cargo arm`: three logs, one of each module, and one posture: where the hand is, and how well that is known.

mod report;
mod request;

pub use report::{ArmReport, FurtherPose, Point, Segment};
pub use request::ArmFile;

use crate::estimation::{Estimation, estimate_poses};
use crate::identify::hinge::{self, Solved};
use crate::identify::input_error::InputError;
use crate::identify::lengths_file::LengthsFile;
use crate::identify::report::Status;
use glenoid::identification::arm::{Arm, ArmPose, Ball, Module};
use glenoid::identification::{EstimatorSettings, Machine, Noise, Pose};
use std::path::Path;

use self::request::BallFile;

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
    let shoulder = ball(&arm.shoulder)?;
    let elbow = elbow(&arm)?;
    let wrist = ball(&arm.wrist)?;
    for (module, outcome) in [(Module::Shoulder, &shoulder), (Module::Wrist, &wrist)] {
        if let Err(refusal) = &outcome.estimation.outcome {
            return Ok(ArmReport::refused(module, refusal.text()));
        }
    }
    if let Err(refusal) = &elbow.outcome {
        return Ok(ArmReport::refused(Module::Elbow, refusal.text()));
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
            let further = further_pose(&chain, &posture, &arm, &elbow, position.hand.covariance_mm2.trace().sqrt());
            ArmReport::accepted(&position, &chain.segments(), further)
        }
        Err(module) => ArmReport::refused(module, "the lengths of the posture fit no pose"),
    })
}

/// Which row of the elbow's log is worth another one like it.
fn further_pose(
    chain: &Arm<'_, f64>,
    posture: &ArmPose<f64>,
    arm: &ArmFile,
    elbow: &Solved<f64>,
    now_mm: f64,
) -> Option<FurtherPose> {
    let used: Vec<_> = elbow.poses.iter().filter(|pose| pose.is_used()).collect();
    let angles_rad: Vec<_> = used.iter().map(|pose| pose.angle_rad).collect();
    let (index, then_mm) = chain.most_useful_bend(posture, &arm.hand_mm, &angles_rad)?;
    let elbow_mm = used[index].lengths_mm[..arm.elbow.rig.cables().len()].to_vec();
    Some(FurtherPose { elbow_mm, hand_sigma_mm: [now_mm, then_mm] })
}

fn ball(file: &BallFile) -> Result<Identified, InputError> {
    let rig = &file.rig.rig;
    let log = LengthsFile::read(&file.log)?.with_repeated_rows_merged(file.rig.row_noise_mm());
    let machine = file.rig.machine(rig);
    let poses = log.poses(log.rows().iter(), rig, file.rig.samples_a_row)?;
    let posture = file.posture.corrected(rig).map_err(|error| InputError::Request(error.fault.text().to_owned()))?;
    let noise = Noise::Known(rig.length_noise_mm());
    let settings = EstimatorSettings { noise, ..EstimatorSettings::for_rig(rig) };
    let estimation = estimate_poses(&machine, rig, settings, None, poses);
    let posture = Pose::new(posture).averaged_over(file.rig.samples_a_row.unwrap_or(1));
    Ok(Identified { machine, estimation, posture })
}

fn elbow(arm: &ArmFile) -> Result<Solved<f64>, InputError> {
    let rig = &arm.elbow.rig;
    let log =
        LengthsFile::read_of(&arm.elbow.log, rig.cables().len())?.with_repeated_rows_merged(rig.length_noise_mm());
    hinge::solve(rig, &log, Some(rig.length_noise_mm()))
}

/// Was the whole arm accepted?
pub fn is_accepted(report: &ArmReport) -> bool {
    report.status == Status::Accepted
}
