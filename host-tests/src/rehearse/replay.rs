//! The board's calculation again on the host, from the very lengths that the board used.

use crate::estimation::{Estimation, estimate_poses};
use glenoid::can::result::Parameter;
use glenoid::can::{BaseId, Message};
use glenoid::identification::{EstimatorSettings, Identified, Machine, Pose, Refusal};
use glenoid::kinematics::CableLengths;
use glenoid::paper::{PaperIteration, PaperSettings, verify};
use glenoid::rig::{CABLES, Parameters, Rig};
use glenoid::scalar::Real;

/// A pose as the board took it: its lengths, mm, and how many samples they are the mean of.
pub type TakenPose = ([f32; CABLES], u16);

/// Identifies the centre the way that the firmware does, in single or double precision.
///
/// # Errors
/// The library's [`Refusal`].
pub fn identify<T: Real>(rig: &Rig<T>, taken: &[TakenPose], zero_prior_mm: f64) -> Result<Identified<T>, Refusal> {
    estimate(rig, taken, zero_prior_mm)?.1.outcome
}

/// The same with the machine and the estimator at its end.
///
/// # Errors
/// The library's [`Refusal`] of a length.
pub fn estimate<T: Real>(
    rig: &Rig<T>,
    taken: &[TakenPose],
    zero_prior_mm: f64,
) -> Result<(Machine<T>, Estimation<T>), Refusal> {
    let machine = Machine::with_offset_prior(rig, rig.offset_prior_mm(T::of(zero_prior_mm)));
    let lengths_mm: Vec<_> = taken.iter().map(|(lengths_mm, _)| *lengths_mm).collect();
    let poses = lengths(&lengths_mm)?.into_iter().zip(taken);
    let poses = poses.map(|(lengths, (_, samples))| Pose::new(lengths).averaged_over(*samples)).collect();
    let estimation = estimate_poses(&machine, rig, EstimatorSettings::for_rig(rig), None, poses);
    Ok((machine, estimation))
}

/// The paper's iteration (Fig. 4), and where it began.
#[derive(Debug, Clone, PartialEq)]
pub struct PaperRun {
    /// What it found.
    pub identified: Identified<f64>,
    /// Distance of the start from the nominal parameters, as a share of the way to `found`: 0 is the nominal start.
    pub share: f64,
    /// Distance of the start's centre from that of `found`, mm.
    pub start_off_mm: f64,
}

/// The paper's iteration over the same lengths, for comparison: from the rig's nominal parameters if it converges from
/// there, else from ever closer to the parameters `found`. From a start far off some tetrahedron does not close.
///
/// # Errors
/// The library's [`Refusal`] from the closest start.
pub fn identify_as_the_paper(
    rig: &Rig<f64>,
    found: &Parameters<f64>,
    lengths_mm: &[[f32; CABLES]],
) -> Result<PaperRun, Refusal> {
    let lengths = lengths(lengths_mm)?;
    let way = |k: usize| found.to_array()[k] - rig.nominal().to_array()[k];
    let mut outcome = Err(Refusal::IterationCap);
    for share in [0.0, 0.5, 0.75, 0.875, 0.9375] {
        let start = rig.nominal().moved_by(&std::array::from_fn(|k| share * way(k)));
        let start_off_mm = (start.centre_mm - found.centre_mm).norm();
        outcome = PaperIteration::new(rig, start, PaperSettings::default()).run(&lengths).map(|identified| PaperRun {
            identified,
            share,
            start_off_mm,
        });
        if outcome.is_ok() {
            break;
        }
    }
    outcome
}

/// Lengths as the library wants them. A pose that cannot be is refused as the library refuses it.
fn lengths<T: Real>(lengths_mm: &[[f32; CABLES]]) -> Result<Vec<CableLengths<T>>, Refusal> {
    let convert = |(pose, lengths): (usize, &[f32; CABLES])| {
        CableLengths::new(lengths.map(|length| T::of(f64::from(length)))).map_err(|error| Refusal::BadLength {
            pose: pose as u32,
            cable: error.cable,
            fault: error.fault,
        })
    };
    lengths_mm.iter().enumerate().map(convert).collect()
}

/// δE in the paper's sense (Eq. 17, over the platform's edges) of the board's parameters over these lengths less the
/// encoders' zero errors, mm.
///
/// # Errors
/// The library's [`Refusal`], when a pose does not fit the parameters at all.
pub fn deviation_mm(
    rig: &Rig<f64>,
    board: &[Parameter; 6],
    zeros_mm: &[f32; CABLES],
    lengths_mm: &[[f32; CABLES]],
) -> Result<f64, Refusal> {
    let lengths_mm: Vec<_> = lengths_mm.iter().map(|pose| std::array::from_fn(|k| pose[k] - zeros_mm[k])).collect();
    let parameters = Parameters::from_array(board.map(|parameter| f64::from(parameter.value_mm)));
    verify(rig, &parameters, &lengths(&lengths_mm)?)
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
