//! Measuring one path: its stack first, then its ticks.

use core::hint::black_box;

use glenoid::rig::Parameters;
use glenoid::scalar::Real;

use super::counter;
use super::stack;

/// A precision by its names.
pub trait Number: Real {
    /// As it stands in the report.
    const NAME: &str;
    /// Name of the image that holds the paper's path alone.
    const PAPER: &str;
    /// Name of the image that holds what needs no start, the machine exactly known, and nothing else.
    const FREE: &str;
    /// The same with what is unknown of the machine.
    const MACHINE: &str;
    /// Name of the image that holds all paths of the library.
    const FULL: &str;
}

impl Number for f32 {
    const NAME: &str = "f32";
    const PAPER: &str = "paper-f32";
    const FREE: &str = "free-f32";
    const MACHINE: &str = "machine-f32";
    const FULL: &str = "full-f32";
}

impl Number for f64 {
    const NAME: &str = "f64";
    const PAPER: &str = "paper-f64";
    const FREE: &str = "free-f64";
    const MACHINE: &str = "machine-f64";
    const FULL: &str = "full-f64";
}

/// What a whole run ends with.
#[derive(Clone, Copy)]
pub struct Answer<T> {
    /// The identified centre and radii.
    pub parameters: Parameters<T>,
    /// Least-squares steps taken.
    pub steps: u8,
}

/// The figures of a path.
#[derive(Clone, Copy, Default)]
pub struct Figures {
    /// How often it was counted.
    pub counts: u32,
    /// Sum of the ticks.
    pub ticks: u64,
    /// Most ticks of one count.
    pub worst: u32,
    /// Static memory beside the pose buffer, bytes.
    pub state_bytes: usize,
    /// Stack, bytes.
    pub stack_bytes: usize,
    /// Least-squares steps of a whole run; 0 for others.
    pub steps: u8,
    /// Distance of the centre from the true one, nm; 0 for paths that identify none.
    pub error_nm: u32,
}

/// Ticks of counting nothing.
pub fn empty() -> u32 {
    counter::ticks_of(|| ()).0
}

/// A run from beginning to end, in one count. `begin` sets the state to its beginning; it is not counted. `None` when there
/// is no answer.
pub fn whole<S, T: Real>(
    state: &mut S,
    state_bytes: usize,
    truth: &Parameters<T>,
    begin: fn(&mut S) -> Option<()>,
    path: fn(&mut S) -> Option<Answer<T>>,
) -> Option<Figures> {
    let path = black_box(path);
    begin(state)?;
    let stack_bytes = stack::used_by(&mut || {
        black_box(path(state));
    });
    begin(state)?;
    let (ticks, answer) = counter::ticks_of(|| path(state));
    let answer = answer?;
    let miss = (answer.parameters.centre_mm - truth.centre_mm).norm_squared().root();
    let error_nm = (miss * T::of(1e6)).to_f32() as u32;
    Some(Figures {
        counts: 1,
        ticks: ticks.into(),
        worst: ticks,
        state_bytes,
        stack_bytes,
        steps: answer.steps,
        error_nm,
    })
}

/// A path in pieces, each counted by itself, until `piece` gives `Some(false)`. `begin` sets the state to its
/// beginning; it is not counted. `None` when a piece does.
pub fn pieces<S>(
    state: &mut S,
    state_bytes: usize,
    begin: fn(&mut S) -> Option<()>,
    piece: fn(&mut S, usize) -> Option<bool>,
) -> Option<Figures> {
    let piece = black_box(piece);
    begin(state)?;
    let stack_bytes = stack::used_by(&mut || {
        let mut index = 0;
        while piece(state, index) == Some(true) {
            index += 1;
        }
    });
    begin(state)?;
    let mut figures = Figures { state_bytes, stack_bytes, ..Figures::default() };
    for index in 0.. {
        let (ticks, more) = counter::ticks_of(|| piece(state, index));
        figures.counts += 1;
        figures.ticks += u64::from(ticks);
        figures.worst = figures.worst.max(ticks);
        if !more? {
            break;
        }
    }
    Some(figures)
}
