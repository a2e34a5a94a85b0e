//! What a client has heard from the device so far.

use glenoid::can::identity::Naming;
use glenoid::can::report::{OutcomeReport, PoseReport};
use glenoid::can::result::{MotionPart, Parameter, Quality, VerificationReport, ZeroError};
use glenoid::can::status::{Answer, Fault, Heartbeat, Versions};
use glenoid::can::watch::WatchReport;
use glenoid::can::{BaseId, Frame, Message, ParameterAnswer, UnpackError};
use glenoid::identification::joint::{MOTION_PARTS, ShownMotion};
use glenoid::procedure::PoseSet;
use glenoid::procedure::elbow::SHOWN_NUMBERS;
use glenoid::rig::{CABLES, POINTS};
use std::collections::BTreeMap;

/// The latest of every message, and those of which each one counts.
#[derive(Debug, Clone, Default)]
pub struct Inbox {
    /// The latest heartbeat.
    pub heartbeat: Option<Heartbeat>,
    /// The first heartbeat of every state that the run went through. A state may last a few milliseconds only; the
    /// board sends a heartbeat at every change.
    pub states: Vec<Heartbeat>,
    /// Versions of firmware and vocabulary.
    pub versions: Option<Versions>,
    /// Answers by nonce.
    pub answers: BTreeMap<u16, Answer>,
    /// Reports on poses, in order.
    pub poses: Vec<PoseReport>,
    /// Coordinates of the new centre.
    pub centre: [Option<Parameter>; POINTS],
    /// The new radii.
    pub radii: [Option<Parameter>; POINTS],
    /// How well the first set fits.
    pub quality: Option<Quality>,
    /// How well the second set fits.
    pub verification: Option<VerificationReport>,
    /// How the run ended.
    pub outcome: Option<OutcomeReport>,
    /// The centre in use.
    pub live_centre: [Option<Parameter>; POINTS],
    /// The radii in use.
    pub live_radii: [Option<Parameter>; POINTS],
    /// Zero errors that were found with the new centre, by cable from 0; none when the zeros were known.
    pub zeros: [Option<ZeroError>; CABLES],
    /// Those in use.
    pub live_zeros: [Option<ZeroError>; CABLES],
    /// How the new centre moves, part by part.
    pub motion: [Option<MotionPart>; MOTION_PARTS],
    /// How the centre in use moves.
    pub live_motion: [Option<MotionPart>; MOTION_PARTS],
    /// The numbers of the new hinge, in the order in which they are shown.
    pub hinge: [Option<HingeNumber>; SHOWN_NUMBERS],
    /// Those of the hinge in use.
    pub live_hinge: [Option<HingeNumber>; SHOWN_NUMBERS],
    /// What an accept of the new centre must name.
    pub naming: Option<Naming>,
    /// The latest warning of the watch over the centre in use.
    pub watch: Option<WatchReport>,
    /// Lengths that were read out, mm, by set (second set: true), pose and cable (from 0).
    pub lengths_mm: BTreeMap<(bool, u8, u8), f32>,
    /// How many samples each pose is the mean of, by set and pose.
    samples: BTreeMap<(bool, u8), u16>,
    /// The latest answer about a parameter.
    pub parameter: Option<ParameterAnswer>,
    /// Faults, in order.
    pub faults: Vec<Fault>,
    /// Frames with an identifier of the device that could not be read.
    pub unreadable: u32,
}

/// A number of a hinge as it came over CAN.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HingeNumber {
    /// The run that found it.
    pub run_id: u16,
    /// A component of a direction, or mm.
    pub value: f32,
    /// Its 1σ.
    pub sigma: f32,
}

impl HingeNumber {
    /// The number in a message, and which of the numbers of a hinge it is: the axis and its foot point in the base, the
    /// same in the platform, the offset along the axis.
    pub fn of(message: &Message) -> Option<(usize, Self)> {
        let place = |index: u8, past: usize| match index {
            6 => SHOWN_NUMBERS - 1,
            index => usize::from(index) / 3 * 6 + past + usize::from(index) % 3,
        };
        match message {
            Message::CandidateHingeAxis(m) | Message::LiveHingeAxis(m) => {
                Some((place(m.index, 0), Self { run_id: m.run_id, value: m.value, sigma: m.sigma }))
            }
            Message::CandidateHingePlace(m) | Message::LiveHingePlace(m) => {
                Some((place(m.index, 3), Self { run_id: m.run_id, value: m.value_mm, sigma: m.sigma_mm }))
            }
            _ => None,
        }
    }

    /// All numbers of a hinge, when they have come.
    pub fn all(numbers: &[Option<Self>; SHOWN_NUMBERS], run_id: u16) -> Option<[Self; SHOWN_NUMBERS]> {
        let mut all = [Self { run_id, value: 0.0, sigma: 0.0 }; SHOWN_NUMBERS];
        for (slot, number) in all.iter_mut().zip(numbers) {
            *slot = number.filter(|number| number.run_id == run_id)?;
        }
        Some(all)
    }
}

impl Inbox {
    /// Takes in one frame from the bus. Frames of others are ignored.
    pub fn take(&mut self, frame: &Frame, base: BaseId) {
        let message = match Message::unpack(frame, base) {
            Ok(message) => message,
            Err(UnpackError::Foreign) => return,
            Err(_) => {
                self.unreadable += 1;
                return;
            }
        };
        let put = |place: &mut [Option<Parameter>; POINTS], value: Parameter| {
            if let Some(slot) = place.get_mut(usize::from(value.index)) {
                *slot = Some(value);
            }
        };
        let put_zero = |place: &mut [Option<ZeroError>; CABLES], value: ZeroError| {
            if let Some(slot) = place.get_mut(usize::from(value.cable).wrapping_sub(1)) {
                *slot = Some(value);
            }
        };
        let put_part = |place: &mut [Option<MotionPart>; MOTION_PARTS], part: MotionPart| {
            if let Some(slot) = place.get_mut(usize::from(part.part)) {
                *slot = Some(part);
            }
        };
        let put_number = |place: &mut [Option<HingeNumber>; SHOWN_NUMBERS], message: &Message| {
            if let Some((position, number)) = HingeNumber::of(message)
                && let Some(slot) = place.get_mut(position)
            {
                *slot = Some(number);
            }
        };
        match message {
            Message::Answer(answer) => drop(self.answers.insert(answer.nonce, answer)),
            Message::Heartbeat(heartbeat) => {
                if self.heartbeat.is_none_or(|before| before.state != heartbeat.state) {
                    self.states.push(heartbeat);
                }
                self.heartbeat = Some(heartbeat);
            }
            Message::Versions(versions) => self.versions = Some(versions),
            Message::Pose(report) => self.poses.push(report),
            Message::CandidateCentre(value) => put(&mut self.centre, value),
            Message::CandidateRadius(value) => put(&mut self.radii, value),
            Message::LiveCentre(value) => put(&mut self.live_centre, value),
            Message::LiveRadius(value) => put(&mut self.live_radii, value),
            Message::CandidateZero(value) => put_zero(&mut self.zeros, value),
            Message::LiveZero(value) => put_zero(&mut self.live_zeros, value),
            Message::CandidateMotion(part) => put_part(&mut self.motion, part),
            Message::LiveMotion(part) => put_part(&mut self.live_motion, part),
            Message::CandidateHingeAxis(_) | Message::CandidateHingePlace(_) => put_number(&mut self.hinge, &message),
            Message::LiveHingeAxis(_) | Message::LiveHingePlace(_) => put_number(&mut self.live_hinge, &message),
            Message::CandidateNaming(naming) => self.naming = Some(naming),
            Message::Watch(report) => self.watch = Some(report),
            Message::Quality(quality) => self.quality = Some(quality),
            Message::Verification(report) => self.verification = Some(report),
            Message::Outcome(report) => self.outcome = Some(report),
            Message::Parameter(answer) => self.parameter = Some(answer),
            Message::Fault(fault) => self.faults.push(fault),
            Message::RawLength(raw) => {
                let key = (raw.set == PoseSet::HeldOut, raw.index, raw.cable.wrapping_sub(1));
                self.lengths_mm.insert(key, raw.length_mm);
            }
            Message::PoseSamples(of) => {
                self.samples.insert((of.set == PoseSet::HeldOut, of.index), of.samples);
            }
            // Said of a set of poses that is refused, or of no interest here.
            _ => {}
        }
    }

    /// The lengths of a pose, mm, when those of all cables were read out; 0 beyond them.
    pub fn pose_mm(&self, set: PoseSet, index: u8, cables: usize) -> Option<[f32; CABLES]> {
        let mut lengths = [0.0; CABLES];
        for (cable, length) in lengths.iter_mut().take(cables).enumerate() {
            *length = *self.lengths_mm.get(&(set == PoseSet::HeldOut, index, cable as u8))?;
        }
        Some(lengths)
    }

    /// How many samples a pose is the mean of; 1 when that was not said.
    pub fn samples(&self, set: PoseSet, index: u8) -> u16 {
        self.samples.get(&(set == PoseSet::HeldOut, index)).copied().unwrap_or(1)
    }

    /// The new centre and radii of the run `run_id`, when all six have come, in the order x, y, z, p1, p2, p3.
    pub fn parameters(&self, run_id: u16) -> Option<[Parameter; 6]> {
        all(self.centre, self.radii).filter(|all| all.iter().all(|parameter| parameter.run_id == run_id))
    }

    /// How the new centre of the run `run_id` moves, when all parts have come.
    pub fn motion(&self, run_id: u16) -> Option<ShownMotion> {
        all_parts(&self.motion, run_id)
    }

    /// How the centre in use moves, when it is that of this run and all parts have come.
    pub fn live_motion(&self, run_id: u16) -> Option<ShownMotion> {
        all_parts(&self.live_motion, run_id)
    }

    /// Centre and radii in use, when all six have come, in the same order.
    pub fn live(&self) -> Option<[Parameter; 6]> {
        all(self.live_centre, self.live_radii)
    }
}

fn all(centre: [Option<Parameter>; POINTS], radii: [Option<Parameter>; POINTS]) -> Option<[Parameter; 6]> {
    let [Some(x), Some(y), Some(z)] = centre else { return None };
    let [Some(p1), Some(p2), Some(p3)] = radii else { return None };
    Some([x, y, z, p1, p2, p3])
}

fn all_parts(parts: &[Option<MotionPart>; MOTION_PARTS], run_id: u16) -> Option<ShownMotion> {
    let mut all = [[0; 3]; MOTION_PARTS];
    for (numbers, part) in all.iter_mut().zip(parts) {
        *numbers = part.filter(|part| part.run_id == run_id)?.numbers;
    }
    Some(ShownMotion::from_parts(all))
}
