//! Who sits in the machine of an emulated board, and what can be asked of them.

use clap::ValueEnum;
use glenoid::rig::CABLES;

/// Time between two samples of the encoders while the arm rests, ms.
pub(super) const PERIOD_MS: u32 = 10;

/// What kind of joint sits in what kind of machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PersonKind {
    /// A joint that is a ball, in the machine of the drawing. In an elbow's machine: an elbow that bends by 120 degrees.
    Ball,
    /// A shoulder whose centre moves with the arm.
    Moving,
    /// A joint that is a ball, in a machine whose attachment points are up to half a millimetre off the drawing.
    Built,
    /// An elbow that never bends; in an elbow's machine only.
    Straight,
}

/// Who sits in the machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Person {
    /// The joint and the machine.
    pub kind: PersonKind,
    /// Seed of the poses and of the true joint.
    pub seed: u64,
    /// Largest error of a cable length, mm.
    pub noise_mm: f64,
    /// How long a pose is held, ms.
    pub hold_ms: u32,
    /// How long a movement takes, ms.
    pub move_ms: u32,
}

/// What the person, or the machine around the person, is to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Press the button, or let go.
    Button(bool),
    /// The encoders fall silent, or count again.
    Encoders(bool),
    /// Pull this cable, 1 to 6, by a finger's breadth, and let go, once the one before has been let go.
    Pull(u8),
}

impl Order {
    /// An order as a terminal writes it: `press`, `release`, `silent`, `sound`, `pull 3`.
    pub fn parse(line: &str) -> Option<Self> {
        match line.trim() {
            "press" => Some(Self::Button(true)),
            "release" => Some(Self::Button(false)),
            "silent" => Some(Self::Encoders(false)),
            "sound" => Some(Self::Encoders(true)),
            other => {
                let cable: u8 = other.strip_prefix("pull ")?.trim().parse().ok()?;
                (1..=CABLES as u8).contains(&cable).then_some(Self::Pull(cable))
            }
        }
    }
}
