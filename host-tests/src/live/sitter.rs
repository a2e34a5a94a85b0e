//! A joint in a machine: what its encoders show at rest and on the way to another pose, and what is true about it.

use glenoid::rig::CABLES;
use std::fmt;

/// Whoever sits in the machine. `blade_held`: somebody holds the shoulder blade.
pub(super) trait Sitter: Send {
    /// What a calibration should find.
    fn truth(&self) -> Truth;

    /// Where the joint is.
    fn now(&self) -> Now;

    /// The next sample of the encoders while the joint rests.
    fn rest(&mut self, blade_held: bool) -> Sample;

    /// The samples on the way to another pose, in which the joint is from then on.
    fn way(&mut self, blade_held: bool, duration_ms: u32, period_ms: u32) -> Vec<Sample>;
}

/// What the encoders show, and where the joint is then.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sample {
    pub(super) counts: [i32; CABLES],
    pub(super) now: Now,
}

/// What a calibration should find.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Truth {
    /// The centre with the arm at home, mm, axes of {B}.
    Centre([f64; 3]),
    /// A hinge's axis: its direction and the point of it next to the origin, mm, in the base and in the forearm's frame.
    Hinge([[[f64; 3]; 2]; 2]),
}

/// Where the joint is at a moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Now {
    /// The true centre, mm, axes of {B}.
    Centre([f64; 3]),
    /// How far the hinge bends, degrees.
    Bent(f64),
}

impl fmt::Display for Truth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Centre([x, y, z]) => write!(f, "true centre {x:.3} {y:.3} {z:.3} mm"),
            Self::Hinge([base, forearm]) => {
                let body = |[[x, y, z], [u, v, w]]: &[[f64; 3]; 2]| {
                    format!("{x:.5} {y:.5} {z:.5} through {u:.3} {v:.3} {w:.3} mm")
                };
                write!(f, "true axis {}, in the forearm {}", body(base), body(forearm))
            }
        }
    }
}

impl fmt::Display for Now {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Centre([x, y, z]) => {
                write!(f, "true centre, with the arm where it is now: {x:.3} {y:.3} {z:.3} mm")
            }
            Self::Bent(degrees) => write!(f, "true angle of the elbow, as it is now: {degrees:.3} degrees"),
        }
    }
}
