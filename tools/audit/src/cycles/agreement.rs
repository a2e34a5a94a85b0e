//! Two ways of counting held against each other: the ticks of the image's timer and the emulator's trace.

use super::emulation::RunError;
use super::figures::Path;
use super::trace::{Count, Trace};

/// The image counts nothing and a known loop before its paths.
const CALIBRATIONS: usize = 2;

/// The paths that are the device's events, in the order of the kinds: their counts stand among each other.
const EVENTS: [&str; 3] = ["device-tick", "device-sample", "device-frame"];

/// Instructions by which the two may differ in one count: the readings of the timer are rounded to ticks, and what
/// lies between the marks beside the path itself is known from counting nothing.
const SLACK: u64 = 4;

/// A path's estimated cycles, and the trace's counts that they come from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Traced {
    /// Which counts of the trace are the path's.
    pub counts: Vec<usize>,
    /// Of all counts together.
    pub sum: Count,
    /// Of the one with the most cycles.
    pub worst: Count,
    /// Which one that is.
    pub worst_at: usize,
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
            if path.precision != "f32" {
                return Ok(None);
            }
            let counts: Vec<usize> = match EVENTS.iter().position(|event| *event == path.name) {
                Some(kind) => (0..trace.kinds.len()).filter(|count| trace.kinds[*count] == Some(kind)).collect(),
                None => {
                    let first = next;
                    next += path.counts as usize;
                    (first..next).collect()
                }
            };
            if counts.len() != path.counts as usize || counts.last().is_some_and(|last| *last >= trace.counts.len()) {
                return Err(RunError::Trace(format!("it has other counts of {} than the image", path.name)));
            }
            let traced = summed(counts, trace, empty);
            if traced.sum.instructions.abs_diff(path.instructions) > SLACK * path.counts {
                let (ticks, trace) = (path.instructions, traced.sum.instructions);
                return Err(RunError::Trace(format!("{}: {ticks} instructions by ticks, {trace} by trace", path.name)));
            }
            Ok(Some(traced))
        })
        .collect()
}

fn summed(counts: Vec<usize>, trace: &Trace, empty: Count) -> Traced {
    let (mut sum, mut worst, mut worst_at) = (Count::default(), Count::default(), 0);
    for at in &counts {
        let count = trace.counts[*at].without(&empty);
        sum = sum.with(&count);
        if count.cycles() > worst.cycles() {
            (worst, worst_at) = (count, *at);
        }
    }
    Traced { counts, sum, worst, worst_at }
}
