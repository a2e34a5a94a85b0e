//! Slip detection over a hinge: one angle explains all lengths of an elbow; three of four are to spare at every instant.
//!
//! It is the watch over a centre (see [`monitor`](super)) with other causes: the machine's base slipped on the upper arm, the
//! cuff slipped on the forearm, or one cable did. With two or three cables too little is to spare to tell them apart: the
//! warning names none then.

use super::DetectorState;
use super::MOVED_MM;
use super::hinge_evidence::HingeEvidence;
use super::suspicion::{Change, SUSPICIOUS, Suspicion};
use super::warning::{Cause, Explanation, Warning};
use crate::identification::hinge::{HingeAngles, HingeSample, MAX_CABLES};
use crate::scalar::Real;
use nalgebra::UnitQuaternion;

/// How far the elbow must have bent for a decision, rad (29 degrees); looked at after every so many samples. While a slip of the
/// base looks like one of the cuff, more is gathered, up to a limit (`cargo study elbow-watch`).
const SPAN_RAD: f64 = 0.5;
const SAMPLES: u16 = 32;
const MOST_SAMPLES: u16 = 256;

/// What is being made of a sample, a slice at a time.
#[derive(Clone, Copy, Debug)]
enum Look<T> {
    /// Nothing.
    No,
    /// Its angle is looked for, from that of the sample before.
    Follow,
    /// What it says of the hinge, at this angle, rad.
    See(T),
    /// It is added to the evidence.
    Add(T),
    /// A slip of the base is looked for in the evidence.
    Strap,
    /// One of the cuff.
    Cuff(Explanation<T>),
    /// The evidence is judged, with those two.
    Judge([Explanation<T>; 2]),
}

/// The slip detector of one accepted hinge. The hinge and its angle stay with the caller.
#[derive(Clone, Debug)]
pub struct HingeSlipDetector<T> {
    variance_mm2: T,
    /// The last sample that counted, mm.
    counted_mm: Option<[T; MAX_CABLES]>,
    look: Look<T>,
    suspicion: Suspicion<T>,
    attitude: Option<UnitQuaternion<T>>,
    /// The angle in which suspicion began, and how far the arm has bent since, rad.
    first_rad: T,
    span_rad: T,
    evidence: HingeEvidence<T>,
}

impl<T: Real> HingeSlipDetector<T> {
    /// A detector for the hinge of a rig with so many cables. `noise_mm`: standard deviation of a length.
    pub fn new(cables: usize, noise_mm: T) -> Self {
        Self {
            variance_mm2: noise_mm * noise_mm,
            counted_mm: None,
            look: Look::No,
            suspicion: Suspicion::none(),
            attitude: None,
            first_rad: T::zero(),
            span_rad: T::zero(),
            evidence: HingeEvidence::none(cables),
        }
    }

    /// What the detector is doing.
    pub fn state(&self) -> DetectorState {
        self.suspicion.state()
    }

    /// The forearm's rotation ({P} to {B}) in the last sample that counted.
    pub fn attitude(&self) -> Option<UnitQuaternion<T>> {
        self.attitude
    }

    /// Goes back to quiet after a warning.
    pub fn rearm(&mut self) {
        self.suspicion.rearm();
        self.evidence.clear();
    }

    /// Nothing was seen for a while. A suspicion is dropped; a warning stays.
    pub fn interrupted(&mut self) {
        (self.attitude, self.counted_mm, self.look) = (None, None, Look::No);
        if self.state() == DetectorState::Suspicious {
            self.rearm();
        }
    }

    /// Takes in a sample of raw lengths, mm, to its end. Returns a warning once, when a decision falls for one.
    pub fn sample(&mut self, lengths_mm: &[T; MAX_CABLES], angles: &mut HingeAngles<T>) -> Option<Warning<T>> {
        self.begin(lengths_mm);
        while self.is_looking() {
            let warning = self.advance(angles);
            if warning.is_some() {
                return warning;
            }
        }
        None
    }

    /// The same a slice at a time: begins with a sample, if the arm has moved since the last one that counted. One that is still
    /// being looked at is given up, unless the evidence is being judged.
    pub fn begin(&mut self, lengths_mm: &[T; MAX_CABLES]) {
        if let Look::Strap | Look::Cuff(_) | Look::Judge(_) = self.look {
            return;
        }
        self.look = Look::No;
        let has_moved = self.counted_mm.is_none_or(|before| {
            before.iter().zip(lengths_mm).any(|(before, now)| (*now - *before).abs() >= T::of(MOVED_MM))
        });
        if has_moved {
            self.counted_mm = Some(*lengths_mm);
            self.look = Look::Follow;
        }
    }

    /// There is more to be made of the sample.
    pub fn is_looking(&self) -> bool {
        !matches!(self.look, Look::No)
    }

    /// The next slice. Returns a warning once, when a decision falls for one.
    pub fn advance(&mut self, angles: &mut HingeAngles<T>) -> Option<Warning<T>> {
        let lengths_mm = self.counted_mm?;
        match core::mem::replace(&mut self.look, Look::No) {
            Look::No => {}
            Look::Follow => {
                // While the first angle is searched for, samples do not count.
                self.look = Look::See(angles.follow(&lengths_mm)?.angle_rad);
            }
            Look::See(angle_rad) => {
                let sample = HingeSample::new(angles, &lengths_mm, angle_rad)?;
                let variance = self.variance_mm2 * T::of_integer(self.evidence.spare());
                self.attitude = Some(angles.hinge().attitude(angle_rad));
                self.see(sample.squares_mm2() / variance, angle_rad);
            }
            Look::Add(angle_rad) => {
                self.evidence.add(&HingeSample::new(angles, &lengths_mm, angle_rad)?);
                if self.evidence.samples().is_multiple_of(SAMPLES) && self.span_rad >= T::of(SPAN_RAD) {
                    self.look = Look::Strap;
                }
            }
            Look::Strap => self.look = Look::Cuff(self.evidence.strap(angles.hinge(), self.variance_mm2)),
            Look::Cuff(strap) => {
                self.look = Look::Judge([strap, self.evidence.cuff(angles.hinge(), self.variance_mm2)])
            }
            Look::Judge(slips) => {
                let usual = self.suspicion.usual();
                let warning = self.evidence.judge(self.variance_mm2, T::of(SUSPICIOUS), usual, slips);
                let is_unknown = warning.is_some_and(|warning| warning.cause == Cause::Unknown);
                if is_unknown && self.evidence.tells_apart() && self.evidence.samples() < MOST_SAMPLES {
                    return None;
                }
                self.suspicion.judged(warning.is_some());
                return warning;
            }
        }
        None
    }

    /// Takes in χ² of a sample per degree of freedom; suspicion begins, or goes on.
    fn see(&mut self, chi_square: T, angle_rad: T) {
        match self.suspicion.see(chi_square) {
            Change::None => {}
            Change::Begins => {
                self.evidence.clear();
                (self.first_rad, self.span_rad) = (angle_rad, T::zero());
            }
            Change::GoesOn => {
                self.span_rad = self.span_rad.max((angle_rad - self.first_rad).abs());
                self.look = Look::Add(angle_rad);
            }
        }
    }
}
