//! What a rehearsal of a shoulder whose centre moves has found.

use serde::Serialize;
use std::fmt;

/// The centre's path as the board has found it, held against the truth in the second set of poses. Root mean squares, mm.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ShoulderReport {
    /// Who, and how much of the shoulder blade's motion the base makes.
    pub person: u64,
    /// The same share.
    pub follow: f64,
    /// A phase with the shoulder blade held came first.
    pub two_phases: bool,
    /// The board captured the poses while the arm moved.
    pub in_motion: bool,
    /// Poses of the free phase.
    pub poses: usize,
    /// The wearer's time from the start to the new centre, s.
    pub wearer_s: f64,
    /// The true centre's distance from its mean.
    pub travel_mm: f64,
    /// The centre by the board's model less the true one, in all and across the arm.
    pub path_error_mm: f64,
    /// Across the arm.
    pub across_error_mm: f64,
    /// What the board's figures say of the two: 1σ of the path, in all and across the arm.
    pub path_sigma_mm: f64,
    /// Across the arm.
    pub across_sigma_mm: f64,
    /// Share of the poses within the 99 % region.
    pub covered: f64,
    /// The centre read from each pose's own lengths less the true one, slide included.
    pub live_error_mm: f64,
    /// Scatter that the board has found, and the true one, along an axis.
    pub scatter_mm: f64,
    /// Largest difference between board and host over the same lengths, mm; 0 is to the bit.
    pub difference_mm: f64,
    /// After a restart the same motion is in use.
    pub survives_restart: bool,
}

impl fmt::Display for ShoulderReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut line = |title: &str, text: String| writeln!(f, "  {title:<20} {text}");
        let phases = if self.two_phases { "two phases" } else { "one phase" };
        line("shoulder", format!("person {}, follow {}, {phases}", self.person, self.follow))?;
        let how = if self.in_motion { "captured in motion" } else { "held" };
        line("poses", format!("{} {how}, {:.0} s from the start to the new centre", self.poses, self.wearer_s))?;
        line("true centre", format!("moves by {:.2} mm rms: a fixed centre would be off by that", self.travel_mm))?;
        line("path", format!("off by {:.2} mm rms, 1σ by the board {:.2} mm", self.path_error_mm, self.path_sigma_mm))?;
        let (error, sigma) = (self.across_error_mm, self.across_sigma_mm);
        line("across the arm", format!("off by {error:.2} mm rms, 1σ by the board {sigma:.2} mm"))?;
        line("99 % region", format!("covers {:.0} % of the poses", self.covered * 100.0))?;
        line("live centre", format!("R C + t off by {:.2} mm rms", self.live_error_mm))?;
        line("scatter", format!("{:.2} mm along an axis found", self.scatter_mm))?;
        let agreement = if self.difference_mm == 0.0 { "agree to the bit" } else { "DIFFER" };
        line("host and board", format!("{agreement}, from the lengths read out of the board"))?;
        line("after a restart", if self.survives_restart { "the same" } else { "ANOTHER" }.to_string())
    }
}
