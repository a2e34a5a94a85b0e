//! The board's calculation again on the host, from the very lengths that the board used.

use glenoid::can::result::Parameter;
use glenoid::can::{BaseId, Message};
use glenoid::identification::{Identified, PaperIteration, PaperSettings, Refusal, Solver, SolverSettings};
use glenoid::kinematics::CableLengths;
use glenoid::rig::{CABLES, Parameters, Rig};
use glenoid::scalar::Real;

/// Identifies the centre the way that the firmware does, in single or double precision.
///
/// # Errors
/// The library's [`Refusal`].
pub fn identify<T: Real>(rig: &Rig<T>, lengths_mm: &[[f32; CABLES]]) -> Result<Identified<T>, Refusal> {
    Solver::<T>::new(rig, SolverSettings::for_rig(rig)).run(&lengths(lengths_mm)?)
}

/// The paper's iteration (Fig. 4) from the rig's nominal centre over the same lengths, for comparison.
///
/// # Errors
/// The library's [`Refusal`]: from a start this far off, some tetrahedron often does not close.
pub fn identify_as_the_paper(rig: &Rig<f64>, lengths_mm: &[[f32; CABLES]]) -> Result<Identified<f64>, Refusal> {
    PaperIteration::new(rig, *rig.nominal(), PaperSettings::default()).run(&lengths(lengths_mm)?)
}

/// Lengths as the library wants them. A pose that cannot be is refused as the library refuses it.
fn lengths<T: Real>(lengths_mm: &[[f32; CABLES]]) -> Result<Vec<CableLengths<T>>, Refusal> {
    let convert = |(pose, lengths): (usize, &[f32; CABLES])| {
        CableLengths::new(lengths.map(|length| T::of(f64::from(length)))).map_err(|error| Refusal::BadLength {
            pose: pose as u16,
            cable: error.cable,
            fault: error.fault,
        })
    };
    lengths_mm.iter().enumerate().map(convert).collect()
}

/// How far the board's parameters, as they came over CAN, are from the host's, mm: exactly 0 when the host's would
/// have come over CAN as the very same bits.
pub fn difference_mm(board: &[Parameter; 6], host: &Parameters<f32>) -> f64 {
    let differences = board.iter().zip(host.to_array()).map(|(board, host_mm)| {
        let as_sent = through_can(*board, host_mm);
        if as_sent.to_bits() == board.value_mm.to_bits() {
            0.0
        } else {
            (f64::from(as_sent) - f64::from(board.value_mm)).abs()
        }
    });
    differences.fold(0.0, f64::max)
}

/// What a client would receive if the board had sent `value_mm` in the place of `like`.
fn through_can(like: Parameter, value_mm: f32) -> f32 {
    let sent = Message::CandidateCentre(Parameter { value_mm, ..like }).pack(BaseId::DEFAULT);
    match sent.map(|frame| Message::unpack(&frame, BaseId::DEFAULT)) {
        Ok(Ok(Message::CandidateCentre(received))) => received.value_mm,
        _ => f32::NAN,
    }
}
