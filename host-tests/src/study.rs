//! The simulations: the paper's own, and the Monte-Carlo studies behind every figure that the README states.
//!
//! A study is a function from a [`Plan`] (seed, trials) to [`Findings`] (tables, targets, charts). It touches no file
//! and prints nothing; [`output`] does. Every trial draws from a random stream of its own, and results are summed in
//! the order of the trials, so that the bytes are the same on one core and on many.

pub(crate) mod arm;
mod arm_boards;
mod arm_poses;
mod bound;
pub(crate) mod built;
mod commissioning;
mod cramer_rao;
mod degenerate;
mod findings;
mod free_motion;
mod machine;
pub mod output;
pub mod scene;
mod solve;
mod statistics;
mod trials;

pub mod adversarial;
pub mod elbow;
mod million;
mod outliers;
mod paper;
mod precision;
mod pulley;
mod shoulder;
mod wander;
mod watch;
mod zeros;

pub use findings::{Findings, Plan, Problem, Table, Target};

/// A named study.
#[derive(Debug, Clone, Copy)]
pub struct Study {
    /// Name on the command line, and of its files.
    pub name: &'static str,
    /// What it answers, in a line.
    pub about: &'static str,
    /// Trials by default; what one trial is, its summary says.
    pub trials: u64,
    /// Does it.
    pub run: fn(&Plan) -> Result<Findings, Problem>,
}

/// All studies, the paper's first.
pub const ALL: &[Study] = &[
    paper::TABLE_2,
    paper::FIG_5,
    paper::FIG_6,
    paper::FIG_7,
    paper::SUCCESS,
    million::MILLION,
    million::EXTREMES,
    bound::STUDY,
    outliers::STUDY,
    degenerate::STUDY,
    wander::STUDY,
    adversarial::STUDY,
    precision::STUDY,
    zeros::STUDY,
    watch::STUDY,
    machine::STUDY,
    commissioning::STUDY,
    shoulder::STUDY,
    free_motion::STUDY,
    elbow::STUDY,
    elbow::ACCEPTS,
    elbow::WATCH,
    arm::STUDY,
    arm_boards::STUDY,
    arm_poses::STUDY,
    pulley::STUDY,
];
