//! What a session brings to light, or why it does not.

use super::bench::BenchError;
use crate::wearer::Pose;
use glenoid::can::message::PROTOCOL;
use glenoid::can::report::OutcomeReport;
use glenoid::can::result::{Parameter, Quality, VerificationReport, ZeroError};
use glenoid::can::status::{Answer, Versions};
use glenoid::can::{Opcode, ParameterAnswer};
use glenoid::procedure::Reason;
use glenoid::rig::CABLES;
use std::fmt;

/// Why a session ended without a result.
#[derive(Debug, Clone, PartialEq)]
pub enum SessionError {
    /// The board is gone.
    Bench(BenchError),
    /// Nothing was heard of what was waited for.
    Silence(&'static str),
    /// A command was not obeyed.
    Refused(Opcode, Answer),
    /// A parameter was not set, or the set as a whole was refused.
    ParameterRefused(ParameterAnswer),
    /// The run ended without a centre.
    Failed(OutcomeReport),
    /// The poses do not suffice; the board went back to collecting more.
    WantsMore(Reason),
    /// The firmware speaks another vocabulary.
    Protocol(u8),
    /// After a restart there is no centre in use, and what the board says is wrong, if it says anything.
    Forgotten(Option<Reason>),
}

impl fmt::Display for SessionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bench(error) => write!(f, "{error}"),
            Self::Silence(what) => write!(f, "the board sent no {what} in time"),
            Self::Refused(opcode, answer) => write!(
                f,
                "the board did not obey {opcode:?}: {} (code {}, detail {}). What to do: {}",
                answer.code,
                answer.code.code(),
                answer.detail,
                answer.code.remedy()
            ),
            Self::ParameterRefused(answer) => write!(
                f,
                "the board did not take parameter {}: {} (code {}, value {:#x}). What to do: {}",
                answer.index,
                answer.code,
                answer.code.code(),
                answer.value,
                answer.code.remedy()
            ),
            Self::Failed(outcome) => {
                write!(f, "the board gave up: {} (code {}", outcome.reason, outcome.reason.code())?;
                if let Some(pose) = outcome.pose {
                    write!(f, ", pose {pose}")?;
                }
                if outcome.cable != 0 {
                    write!(f, ", cable {}", outcome.cable)?;
                }
                if let Some(size) = outcome.size_mm {
                    write!(f, ", {size:.3} mm")?;
                }
                write!(f, "). What to do: {}", outcome.reason.remedy())
            }
            Self::WantsMore(reason) => {
                let (code, remedy) = (reason.code(), reason.remedy());
                write!(f, "the board wants more poses: {reason} (code {code}). What to do: {remedy}")
            }
            Self::Forgotten(None) => write!(f, "after a restart the board has no centre in use"),
            Self::Forgotten(Some(reason)) => {
                write!(f, "after a restart the board has no centre in use: {reason} (code {})", reason.code())
            }
            Self::Protocol(theirs) => {
                write!(f, "the firmware speaks vocabulary {theirs}, this program speaks {PROTOCOL}")
            }
        }
    }
}

impl std::error::Error for SessionError {}

impl From<BenchError> for SessionError {
    fn from(error: BenchError) -> Self {
        Self::Bench(error)
    }
}

/// A pose that the board took.
#[derive(Debug, Clone, PartialEq)]
pub struct Captured {
    /// The pose in which the wearer held the arm.
    pub pose: Pose,
    /// The lengths that the board took for it, as read out over CAN, mm.
    pub lengths_mm: [f32; CABLES],
    /// How many samples they are the mean of.
    pub samples: u16,
    /// The centre's σ that the board predicted from the poses so far, mm.
    pub predicted_sigma_mm: Option<f32>,
}

impl Transcript {
    /// Zero errors of the encoders as the board found them, mm; 0 when they were known.
    pub fn zeros_mm(&self) -> [f32; CABLES] {
        self.zeros.map_or([0.0; CABLES], |zeros| zeros.map(|zero| zero.value_mm))
    }
}

/// Everything that a session brought to light.
#[derive(Debug, Clone, PartialEq)]
pub struct Transcript {
    /// The firmware.
    pub versions: Versions,
    /// The run.
    pub run_id: u16,
    /// The first set.
    pub identification: Vec<Captured>,
    /// The second set.
    pub verification: Vec<Captured>,
    /// Poses that the board refused because they were too near to others.
    pub refused_poses: u32,
    /// x, y, z, p1, p2, p3 with their standard deviations.
    pub parameters: [Parameter; 6],
    /// Zero errors of the encoders, when they were not known.
    pub zeros: Option<[ZeroError; CABLES]>,
    /// How well the first set fits.
    pub quality: Quality,
    /// How well the second set fits.
    pub verified: VerificationReport,
    /// The centre that is in use after the acceptance, mm.
    pub live_centre_mm: [f32; 3],
}
