//! What is said of the log of `--still`: of a refusal, what was seen in it and what to do.

use super::lengths_file::LengthsFile;
use super::refusal::RefusalDetail;
use super::wording::{self, counted};
use glenoid::identification::joint::MIN_HELD_POSES;
use serde::Serialize;

/// The held phase. Poses are rows of its own log, from 0.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct HeldReport {
    /// Poses in its log.
    pub poses: usize,
    /// The refusal is of these poses, not of the free ones.
    pub refused: bool,
    /// Poses left out; of a refusal those without which the others would do.
    pub left_out: Vec<usize>,
    /// The free poses would pass for held ones, and these do not.
    pub logs_exchanged: bool,
}

/// The reason of a refusal, where the estimator's is that of free poses.
pub fn reason(refusal: &RefusalDetail, held: &HeldReport) -> Option<&'static str> {
    if !held.left_out.is_empty() {
        return Some("too many of the held poses contradict the others");
    }
    match refusal {
        RefusalDetail::TooFewPoses { .. } => Some("too few poses with the shoulder blade held"),
        RefusalDetail::IterationCap | RefusalDetail::Singular => Some("the held poses have no common centre"),
        RefusalDetail::TooManyOutliers { .. } => Some("too many of the held poses contradict the others"),
        _ => None,
    }
}

/// The poses left out, in words; `None` when there are none.
pub fn left_out(held: &HeldReport, still: &LengthsFile) -> Option<String> {
    let poses: Vec<_> = held.left_out.iter().map(|pose| wording::pose(*pose, still)).collect();
    (!poses.is_empty()).then(|| poses.join(", "))
}

/// What to do about a refusal of the held poses.
pub fn remedy(refusal: &RefusalDetail, held: &HeldReport, still: &LengthsFile) -> Option<String> {
    let file = still.file();
    if held.logs_exchanged {
        return Some(format!(
            "The free poses would pass for held ones, those of {file} do not: exchange the two logs."
        ));
    }
    if !held.left_out.is_empty() {
        return Some(
            "Correct or delete those lines, look for slack cables, and hold each pose; or leave out --still."
                .to_owned(),
        );
    }
    match refusal {
        RefusalDetail::TooFewPoses { .. } => Some(format!(
            "Record at least {}, better 20, with the shoulder blade held and the arm within 30 degrees of its middle; or \
             leave out --still.",
            counted(MIN_HELD_POSES, "pose")
        )),
        RefusalDetail::IterationCap | RefusalDetail::Singular | RefusalDetail::TooManyOutliers { .. } => Some(format!(
            "Look in {file} for slack cables, exchanged connectors and misread lengths, and whether it is of this rig; let \
             somebody hold the shoulder blade, and repeat the held poses; or leave out --still."
        )),
        _ => None,
    }
}
