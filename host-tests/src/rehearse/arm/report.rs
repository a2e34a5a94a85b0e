//! What the rehearsal of an arm found, for people and as JSON.

use super::chain::{Hand, Limb};
use super::elbow_report::ElbowReport;
use super::module::{name, serialize_name};
use crate::rehearse::options::Options;
use crate::rehearse::report::{Report, Status};
use glenoid::identification::arm::Module;
use glenoid::rig::Tolerance;
use serde::Serialize;
use std::fmt;

/// Everything that it found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ArmReport {
    /// How it ended.
    pub status: Status,
    /// Why it did not end right; one entry for each objection.
    pub reasons: Vec<String>,
    /// What was asked for.
    pub seed: u64,
    /// Poses of each module.
    pub poses: u8,
    /// Every length is wrong by up to this, uniformly, mm.
    pub noise_mm: f64,
    /// The machines are off by the tolerances that their boards are told.
    pub machine_tolerance: bool,
    /// The shoulder and the wrist.
    pub balls: Vec<BallReport>,
    /// The elbow.
    pub elbow: Option<ElbowReport>,
    /// Upper arm and forearm.
    pub limbs: Option<[Limb; 2]>,
    /// The hand in postures that identified nothing.
    pub hand: Vec<Hand>,
}

/// A ball on its board.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BallReport {
    /// Which.
    #[serde(serialize_with = "serialize_name")]
    pub module: Module,
    /// First identifier of its board.
    pub base_id: u16,
    /// Serial number of its board.
    pub serial: u32,
    /// As the rehearsal of one board reports it.
    pub rehearsal: Report,
}

impl ArmReport {
    /// An arm of which nothing is known yet.
    pub fn empty(options: &Options) -> Self {
        Self {
            status: Status::Right,
            reasons: Vec::new(),
            seed: options.seed,
            poses: options.poses,
            noise_mm: options.noise,
            machine_tolerance: options.machine_tolerance,
            balls: Vec::new(),
            elbow: None,
            limbs: None,
            hand: Vec::new(),
        }
    }

    /// Host and boards have found the same, to the bit, in all modules.
    pub fn host_agrees(&self) -> bool {
        let same =
            |ball: &BallReport| ball.rehearsal.found.as_ref().is_some_and(|found| found.host.difference_mm == 0.0);
        self.balls.iter().all(same) && self.elbow.as_ref().is_some_and(|elbow| elbow.host_agrees)
    }

    /// The same, ended by something.
    #[must_use]
    pub fn failed(self, reason: String) -> Self {
        Self { status: Status::Failed, reasons: vec![reason], ..self }
    }
}

impl fmt::Display for ArmReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f)?;
        if self.machine_tolerance {
            let Tolerance { base_mm, edges_mm, offset_mm, drum } = Tolerance::<f64>::hand_built();
            let off = format!("base {base_mm}, edges {edges_mm}, zeros {offset_mm} mm, drums {} %", drum * 100.0);
            line(f, "machines", &format!("off by these, 1σ, which their boards are told: {off}"))?;
        }
        for ball in &self.balls {
            ball.fmt(f)?;
        }
        if let Some(elbow) = &self.elbow {
            elbow.fmt(f)?;
        }
        for (title, limb) in ["upper arm", "forearm"].iter().zip(self.limbs.iter().flatten()) {
            let Limb { length_mm, sigma_mm, true_mm } = limb;
            line(f, title, &format!("{length_mm:.2} mm long, 1σ {sigma_mm:.2} mm; true {true_mm:.2} mm"))?;
        }
        for (number, hand) in (1..).zip(&self.hand) {
            let Hand { found_mm, sigma_mm, true_mm, error_mm, by_module_mm, .. } = hand;
            line(f, &format!("hand, posture {number}"), &format!("{} mm, 1σ {} mm", list(found_mm), list(sigma_mm)))?;
            line(f, "", &format!("{} mm true, {error_mm:.2} mm off", list(true_mm)))?;
            let [shoulder, elbow, wrist, mounts] = by_module_mm;
            let parts = format!("shoulder {shoulder:.2}, elbow {elbow:.2}, wrist {wrist:.2}, mounts {mounts:.2} mm");
            line(f, "", &format!("σ from {parts}"))?;
        }
        match self.status {
            Status::Right => {
                writeln!(f, "\nright: all modules are what they are within their σ, and the hand is where the arm says")
            }
            Status::Wrong => writeln!(f, "\nWRONG: {}", self.reasons.join("\n       ")),
            Status::Failed => writeln!(f, "\nFAILED: {}", self.reasons.join("\n        ")),
        }
    }
}

impl fmt::Display for BallReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        line(f, name(self.module), &format!("board {} at {:#X}", self.serial, self.base_id))?;
        let Some(found) = &self.rehearsal.found else { return Ok(()) };
        let [sx, sy, sz, ..] = found.sigma_mm;
        line(f, "  centre", &format!("{} mm, 1σ {} mm", list(&found.centre_mm), list(&[sx, sy, sz])))?;
        let truth = list(&self.rehearsal.true_centre_mm);
        line(f, "", &format!("{truth} mm true, {:.3} mm off", found.centre_error_mm))?;
        let agreement = match found.host.difference_mm {
            0.0 => "agree to the bit".to_owned(),
            mm => format!("differ by {mm:.1e} mm"),
        };
        line(f, "  host and board", &format!("{agreement}, from the lengths read out of the board"))?;
        let same = if found.centre_after_restart_mm == found.centre_mm { "the same centre" } else { "ANOTHER centre" };
        line(f, "  after a restart", &format!("{same} in use, from the record"))
    }
}

impl fmt::Display for ElbowReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        line(f, "elbow", &format!("board {} at {:#X}", self.serial, self.base_id))?;
        let (axis, error, sigma) = (list(&self.axis), self.axis_error_deg, self.axis_sigma_deg);
        line(f, "  axis", &format!("{axis}, {error:.2}° off, 1σ {sigma:.2}°"))?;
        let (place, error, sigma) = (list(&self.place_mm), self.place_error_mm, self.place_sigma_mm);
        line(f, "  place", &format!("{place} mm, {error:.2} mm off, 1σ {sigma:.2} mm"))?;
        let agreement = if self.host_agrees { "agree to the bit" } else { "DIFFER" };
        line(f, "  host and board", &format!("{agreement}, from the lengths read out of the board"))?;
        let same = if self.survives_restart { "the same hinge" } else { "ANOTHER hinge" };
        line(f, "  after a restart", &format!("{same} in use, from the record"))
    }
}

fn line(f: &mut fmt::Formatter<'_>, title: &str, text: &str) -> fmt::Result {
    writeln!(f, "  {title:<20} {text}")
}

fn list(numbers: &[f64; 3]) -> String {
    numbers.map(|number| format!("{number:.3}")).join(", ")
}
