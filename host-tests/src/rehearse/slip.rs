//! Something slips after the acceptance: what does the board say, and is it right?

use super::client::{ANSWER_LIMIT_MS, PERIOD_MS};
use super::options::Options;
use super::session::Session;
use super::transcript::SessionError;
use glenoid::can::Opcode;
use glenoid::can::watch::WatchReport;
use glenoid::procedure::Reason;
use glenoid::rig::CABLES;
use nalgebra::{Rotation3, Vector3};
use serde::Serialize;
use std::fmt;

/// A slip must be reported within this time of a motion that turns the arm by more than 20 degrees, s.
const WITHIN_S: f64 = 2.0;
/// Largest error of the direction of a slip, degrees.
const DIRECTION_DEG: f64 = 15.0;
/// The arm goes on after the slip for so long, s.
const AFTER_S: f64 = 4.0;

/// One sample of the encoders while the arm exercises.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Time since the arm began to move, s.
    pub at_s: f64,
    /// Encoder counts.
    pub counts: [i32; CABLES],
}

/// What slipped.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Slip {
    /// Time since the arm began to move, s.
    pub at_s: f64,
    /// Movement of the joint centre in {B}, mm; zero for a cable.
    pub strap_mm: [f64; 3],
    /// The cable, 1 to 6, if it is one.
    pub cable: Option<u8>,
    /// What the cable reads too much, mm.
    pub cable_mm: f64,
}

/// What slipped, and what the board said of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SlipReport {
    /// The truth.
    pub slip: Slip,
    /// The board's reason: name in the vocabulary.
    pub reported: Option<&'static str>,
    /// The cable that it named; 0 for none.
    pub reported_cable: u8,
    /// How far and which way, by the board, mm.
    pub reported_mm: [f64; 3],
    /// When, since the slip, s.
    pub after_s: f64,
    /// What is wrong with that; empty when the board is right.
    pub objections: Vec<String>,
}

/// An exercise with a slip, as it went.
#[derive(Debug, Clone, PartialEq)]
pub struct Exercise {
    /// What slipped.
    pub slip: Slip,
    /// All samples.
    pub samples: Vec<Sample>,
    /// The first warning, and when it was heard, s since the arm began to move.
    pub warning: Option<(WatchReport, f64)>,
    /// The centre in use was another one in the end.
    pub centre_changed: bool,
}

impl Session<'_> {
    /// Exercises the arm, lets something slip at the time that the options say, and listens to what the board says.
    ///
    /// # Errors
    /// [`SessionError`]
    pub fn exercise(&mut self, options: &Options, slip_mm: f64) -> Result<Exercise, SessionError> {
        let stage = self.display.stage("exercising");
        let home = self.wearer.home();
        self.move_to(home)?;
        let before = self.client.inbox.live();
        let direction = self.wearer.direction().into_inner();
        let slip = Slip {
            at_s: options.at,
            strap_mm: if options.cable.is_none() { (direction * slip_mm).into() } else { [0.0; 3] },
            cable: options.cable,
            cable_mm: if options.cable.is_some() { slip_mm } else { 0.0 },
        };
        let (mut samples, mut warning) = (Vec::new(), None);
        let steps = ((options.at + AFTER_S) * 1000.0) as u32 / PERIOD_MS;
        for step in 0..steps {
            let at_s = f64::from(step * PERIOD_MS) / 1000.0;
            let slipped = at_s >= slip.at_s;
            let strap_mm = if slipped { Vector3::from(slip.strap_mm) } else { Vector3::zeros() };
            let cable = slip.cable.filter(|_| slipped).map(|cable| (usize::from(cable) - 1, slip.cable_mm));
            let counts = self.wearer.sample(&arm(at_s, options.tilt), strap_mm, cable);
            samples.push(Sample { at_s, counts });
            self.client.sample(counts)?;
            if let (None, Some(report)) = (warning, self.client.inbox.watch) {
                warning = Some((report, at_s));
            }
        }
        self.client.inbox.live_centre = [None; 3];
        self.client.command(Opcode::Query, 0, 0)?;
        let after = self.client.wait_for("centre in use", ANSWER_LIMIT_MS, |inbox| inbox.live())?;
        stage.done(match warning {
            Some(_) => "the board warns",
            None => "the board says nothing",
        });
        Ok(Exercise { slip, samples, warning, centre_changed: before != Some(after) })
    }
}

/// The arm's rotation from home after so many seconds: from home within a second to two thirds of `tilt_deg`, where it
/// goes in circles, turning about its own length meanwhile. At 45 degrees it turns by 30 degrees or more in any two
/// seconds.
fn arm(at_s: f64, tilt_deg: f64) -> Rotation3<f64> {
    let tilt = tilt_deg.to_radians() * 2.0 / 3.0 * at_s.min(1.0);
    let azimuth = 0.7 * at_s;
    let across = Vector3::new(tilt * libm::cos(azimuth), tilt * libm::sin(azimuth), 0.0);
    Rotation3::new(across) * Rotation3::new(Vector3::new(0.0, 0.0, 0.3 * libm::sin(0.8 * at_s)))
}

impl Exercise {
    /// Holds what the board said against what slipped.
    pub fn judge(&self) -> SlipReport {
        let mut objections = Vec::new();
        let expected = if self.slip.cable.is_some() { Reason::CableSlipped } else { Reason::StrapSlipped };
        let report = self.warning.map(|(report, _)| report);
        let after_s = self.warning.map_or(f64::NAN, |(_, at_s)| at_s - self.slip.at_s);
        match report {
            None => objections.push("the board said nothing of the slip".to_string()),
            Some(report) => {
                if after_s < 0.0 {
                    objections.push("the board warned before anything had slipped".to_string());
                } else if after_s > WITHIN_S {
                    objections.push(format!("the board took {after_s:.2} s, more than {WITHIN_S} s"));
                }
                if report.cause != expected || report.cable != self.slip.cable.unwrap_or(0) {
                    let cable = if report.cable == 0 { String::new() } else { format!(" (cable {})", report.cable) };
                    objections.push(format!("the board named {}{cable}", report.cause.name()));
                } else if self.slip.cable.is_none() {
                    let found = Vector3::from(report.moved_mm.map(f64::from));
                    let off_deg = found.angle(&Vector3::from(self.slip.strap_mm)).to_degrees();
                    if !(off_deg <= DIRECTION_DEG) {
                        objections.push(format!("the direction is off by {off_deg:.1} degrees"));
                    }
                }
            }
        }
        if self.centre_changed {
            objections.push("the centre in use has changed".to_string());
        }
        SlipReport {
            slip: self.slip,
            reported: report.map(|report| report.cause.name()),
            reported_cable: report.map_or(0, |report| report.cable),
            reported_mm: report.map_or([0.0; 3], |report| report.moved_mm.map(f64::from)),
            after_s,
            objections,
        }
    }
}

impl fmt::Display for SlipReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let vector = |[x, y, z]: [f64; 3]| format!("{x:+.2}, {y:+.2}, {z:+.2} mm");
        let truth = match self.slip.cable {
            Some(cable) => format!("cable {cable} by {:+.2} mm", self.slip.cable_mm),
            None => format!("the strap: the centre by {}", vector(self.slip.strap_mm)),
        };
        writeln!(f, "  {:<20} {truth}, {:.1} s after the arm began to move", "slipped", self.slip.at_s)?;
        let said = match (self.reported, self.reported_cable) {
            (None, _) => "nothing".to_string(),
            (Some(name), 0) => format!("{name}, {}, {:.2} s after the slip", vector(self.reported_mm), self.after_s),
            (Some(name), cable) => {
                format!("{name}, cable {cable}, {:+.2} mm, {:.2} s after the slip", self.reported_mm[0], self.after_s)
            }
        };
        write!(f, "  {:<20} {said}", "the board said")
    }
}
