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

/// Refuses held poses that stand among the free ones; says which poses of the second log have identified.
///
/// # Errors
/// [`InputError::At`] names the first of the held poses.
pub fn poses(
    log: &LengthsFile,
    still: Option<&LengthsFile>,
    second: Option<&LengthsFile>,
) -> Result<Option<String>, InputError> {
    if let Some(still) = still
        && let Some((line, again)) = again(still, log)
    {
        let remedy = "the held phase wants poses of its own, with the shoulder blade held; or leave out --still";
        return Err(InputError::at(still.file(), line, 1, format!("{again}: {remedy}")));
    }
    let identifying = [Some(log), still].into_iter().flatten();
    Ok(second.and_then(|second| {
        let (line, again) = identifying.filter_map(|first| self::again(second, first)).next()?;
        Some(format!("{}, line {line}: {again}: poses that identify verify nothing, record others", second.file()))
    }))
}

/// The first line of a log with a pose that is known, and how many there are.
fn again(log: &LengthsFile, known: &LengthsFile) -> Option<(usize, String)> {
    let lines: HashMap<_, _> = known.rows().iter().rev().map(|row| (bits(row), row.line)).collect();
    let shared: Vec<_> = log.rows().iter().filter_map(|row| Some((row.line, *lines.get(&bits(row))?))).collect();
    let (line, same) = shared.first().filter(|_| shared.len() >= NO_CHANCE.min(log.rows().len()))?;
    let count = counted(shared.len(), "pose");
    Some((*line, format!("{count} of {} stand here again, this one from its line {same}", known.file())))
}

fn bits(row: &Row) -> [u64; CABLES] {
    row.lengths_mm.map(f64::to_bits)
}
