//! Two ways of counting held against each other: the ticks of the image's timer and the emulator's trace.

use std::ops::Range;

use super::emulation::RunError;
use super::figures::Path;
use super::trace::{Count, Trace};

/// The image counts nothing and a known loop before its paths.
const CALIBRATIONS: usize = 2;

/// How the names of the paths begin that are not traced: a minute of the whole device.
const DEVICE: &str = "device";

/// Instructions by which the two may differ in one count: the readings of the timer are rounded to ticks, and what
/// lies between the marks beside the path itself is known from counting nothing.
const SLACK: u64 = 4;

/// A path's estimated cycles, and the trace's counts that they come from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Traced {
    /// Which counts of the trace are the path's.
    pub counts: Range<usize>,
    /// Of all counts together.
    pub sum: Count,
    /// Of the longest.
    pub worst: Count,
}

/// Finds the counts of each single-precision path in the trace; `None` for the other paths.
///
/// # Errors
/// [`RunError::Trace`] when the two ways of counting disagree.
pub fn assign(paths: &[Path], trace: &Trace) -> Result<Vec<Option<Traced>>, RunError> {
    let empty = *trace.counts.first().ok_or_else(|| RunError::Trace("it holds no count".to_owned()))?;
    let mut next = CALIBRATIONS;
    paths
        .iter()
        .map(|path| {
            if path.precision != "f32" || path.name.starts_with(DEVICE) {
                return Ok(None);
            }
            let counts = next..next + path.counts as usize;
            next = counts.end;
            let of_path =
                trace.counts.get(counts.clone()).ok_or_else(|| RunError::Trace("it ends early".to_owned()))?;
            let traced = summed(counts, of_path, empty);
            if traced.sum.instructions.abs_diff(path.instructions) > SLACK * path.counts {
                let (ticks, trace) = (path.instructions, traced.sum.instructions);
                return Err(RunError::Trace(format!("{}: {ticks} instructions by ticks, {trace} by trace", path.name)));
            }
            Ok(Some(traced))
        })
        .collect()
}

fn summed(counts: Range<usize>, of_path: &[Count], empty: Count) -> Traced {
    let mut traced = Traced { counts, sum: Count::default(), worst: Count::default() };
    for count in of_path {
        let instructions = count.instructions.saturating_sub(empty.instructions);
        let cycles = count.cycles.saturating_sub(empty.cycles);
        traced.sum = Count { instructions: traced.sum.instructions + instructions, cycles: traced.sum.cycles + cycles };
        if instructions > traced.worst.instructions {
            traced.worst = Count { instructions, cycles };
        }
    }
    traced
}
