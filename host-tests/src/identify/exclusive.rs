//! What excludes each other: options that ask for two things at once, and poses that are used twice.

use super::Request;
use super::input_error::InputError;
use super::lengths_file::{LengthsFile, Row};
use super::report::Method;
use super::wording::counted;
use glenoid::identification::JointChoice;
use glenoid::rig::CABLES;
use std::collections::HashMap;

/// So many poses with the same six lengths to the last digit are no chance: they are the same poses.
const NO_CHANCE: usize = 3;

/// Refuses options that ask for two things at once.
///
/// # Errors
/// [`InputError::Request`] names both and says which to leave out.
pub fn options(request: &Request) -> Result<(), InputError> {
    let paper = request.method == Method::Paper;
    let complaint = match (request.still.is_some(), request.joint) {
        (true, JointChoice::Ball) => {
            "--still is for a centre that moves with the arm, and --joint ball takes it for fixed: leave out one of them"
        }
        (true, _) if paper => {
            "--still is for a centre that moves, and --method paper takes it for fixed: leave out one of them"
        }
        (_, JointChoice::Moving) if paper => {
            "--method paper takes the centre for fixed: leave it out, or leave out --joint moving"
        }
        _ => return Ok(()),
    };
    Err(InputError::Request(complaint.to_owned()))
}

/// Refuses poses that stand in two logs: each is to be used for one thing only.
///
/// # Errors
/// [`InputError::At`] names the first of them.
pub fn poses(log: &LengthsFile, still: Option<&LengthsFile>, second: Option<&LengthsFile>) -> Result<(), InputError> {
    let held = "the held phase wants poses of its own, with the shoulder blade held; or leave out --still";
    let verify = "poses that identify verify nothing: record others for --verify, or leave it out";
    if let Some(still) = still {
        all_new(still, log, held)?;
    }
    for first in [Some(log), still].into_iter().flatten() {
        if let Some(second) = second {
            all_new(second, first, verify)?;
        }
    }
    Ok(())
}

fn all_new(log: &LengthsFile, known: &LengthsFile, remedy: &str) -> Result<(), InputError> {
    let lines: HashMap<_, _> = known.rows().iter().rev().map(|row| (bits(row), row.line)).collect();
    let shared: Vec<_> = log.rows().iter().filter_map(|row| Some((row.line, *lines.get(&bits(row))?))).collect();
    match shared.first() {
        Some((line, same)) if shared.len() >= NO_CHANCE.min(log.rows().len()) => {
            let count = counted(shared.len(), "pose");
            let message =
                format!("{count} of {} stand here again, this one from its line {same}: {remedy}", known.file());
            Err(InputError::at(log.file(), *line, 1, message))
        }
        _ => Ok(()),
    }
}

fn bits(row: &Row) -> [u64; CABLES] {
    row.lengths_mm.map(f64::to_bits)
}
