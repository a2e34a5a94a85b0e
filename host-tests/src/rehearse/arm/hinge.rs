//! The module that is a hinge: the elbow, its board and the person's joint in it.

use super::bus::{Bus, Place};
use super::elbow::ElbowWearer;
use super::elbow_report::ElbowReport;
use super::module::ArmModule;
use crate::rehearse::client::ANSWER_LIMIT_MS;
use crate::rehearse::display::Display;
use crate::rehearse::inbox::HingeNumber;
use crate::rehearse::options::Options;
use crate::rehearse::session::{Person, Reviewed, Session};
use crate::rehearse::transcript::{Captured, SessionError};
use crate::wearer::Pose;
use glenoid::can::hinge::{HingeAxis, HingePlace};
use glenoid::can::{BaseId, Message, Opcode};
use glenoid::identification::hinge::{HingeEstimator, HingePart, HingePose, HingeSettings, IdentifiedHinge};
use glenoid::procedure::Reason;
use glenoid::procedure::elbow::{ElbowRig, FoundHinge, SHOWN_NUMBERS};
use glenoid::rig::CABLES;

/// An error may be so many σ, and this much beyond, mm: single precision, and lengths that are rounded to counts.
const SIGMAS: f64 = 5.0;
const GRANTED_MM: f64 = 0.05;
const GRANTED_DEG: f64 = 0.02;

/// More angles than these would be too near to one another: the board wants three degrees between any two.
const MAX_POSES: u8 = 20;
const MAX_VERIFICATION_POSES: u8 = 5;
/// An elbow that has given fewer angles than these when no other one is far enough from them never bends.
const BENT_ANGLES: usize = 3;

/// The elbow and its board.
pub struct HingeModule {
    /// Its board.
    pub module: ArmModule,
    rig: ElbowRig,
    board: usize,
    wearer: ElbowWearer,
    at: Pose,
    poses: [u8; 2],
}

/// What its board has found, and the same calculation on the host.
pub struct CalibratedHinge {
    /// The board's axis against the truth and against the host's.
    pub report: ElbowReport,
    /// The host's estimator at its end.
    pub estimator: HingeEstimator<f32>,
}

/// What a session with its board has brought to light.
struct Transcript {
    reviewed: Reviewed,
    shown: [HingeNumber; SHOWN_NUMBERS],
    after_restart: [HingeNumber; SHOWN_NUMBERS],
}

impl HingeModule {
    /// An elbow on a board.
    ///
    /// # Errors
    /// When the module's machine is no hinge.
    pub fn new(module: ArmModule, board: usize, wearer: ElbowWearer, options: &Options) -> Result<Self, String> {
        let rig = module.rig.hinge().ok_or("the elbow's machine is no hinge")?.clone();
        let poses = [options.poses.min(MAX_POSES), options.verification_poses().min(MAX_VERIFICATION_POSES)];
        Ok(Self { module, rig, board, at: wearer.home(), wearer, poses })
    }

    /// What the board's encoders show.
    pub fn counts(&self) -> [i32; CABLES] {
        self.at.counts
    }

    /// Calibrates it, accepts the hinge, and restarts the board, which must come back with it.
    ///
    /// # Errors
    /// Why there is no hinge.
    pub fn calibrate(&mut self, bus: &mut dyn Bus, display: &Display) -> Result<CalibratedHinge, String> {
        let [poses, second] = self.poses;
        let transcript = self.in_session(bus, display, |session| {
            let reviewed = session.go_to_review(poses, second, 0).map_err(|error| explained(session, error))?;
            let text = |error: SessionError| error.to_string();
            let run_id = reviewed.run_id;
            let client = &mut session.client;
            let shown = client.wait_for("report", ANSWER_LIMIT_MS, |inbox| HingeNumber::all(&inbox.hinge, run_id));
            let shown = shown.map_err(text)?;
            session.accept_run(run_id).and_then(|()| session.restart_board()).map_err(text)?;
            session.client.command(Opcode::Query, 0, 0).map_err(text)?;
            let after_restart = session
                .client
                .wait_for("hinge in use", ANSWER_LIMIT_MS, |inbox| HingeNumber::all(&inbox.live_hinge, run_id));
            Ok(Transcript { reviewed, shown, after_restart: after_restart.map_err(text)? })
        })?;
        let (found, estimator) = self.estimate(&transcript.reviewed.identification)?;
        Ok(CalibratedHinge { report: self.judge(&transcript, &found, &estimator), estimator })
    }

    /// The way of the encoders to another angle, a sample every so many ms. The elbow is there from now on.
    pub fn move_on(&mut self, duration_ms: u32, period_ms: u32) -> Vec<[i32; CABLES]> {
        let from = std::mem::replace(&mut self.at, self.wearer.next_pose());
        self.wearer.motion(&from, &self.at, duration_ms, period_ms)
    }

    /// The person's joint.
    pub fn wearer(&self) -> &ElbowWearer {
        &self.wearer
    }

    /// The angle at which it stands, rad.
    pub fn flexion_rad(&self) -> f64 {
        self.wearer.flexion_rad(&self.at)
    }

    fn in_session<T>(
        &mut self,
        bus: &mut dyn Bus,
        display: &Display,
        act: impl FnOnce(&mut Session<'_, ElbowWearer>) -> Result<T, String>,
    ) -> Result<T, String> {
        let fastest = f64::from(self.rig.drum().fastest_mm_per_s);
        let mut place = Place::new(bus, self.board);
        let session = Session::new(&mut place, &mut self.wearer, fastest, display);
        let mut session = session.at(self.module.base).standing_in(self.at);
        let result = act(&mut session);
        let at = *session.pose();
        self.at = at;
        result
    }

    /// The very calculation of the board, from the lengths that were read out of it.
    fn estimate(&self, taken: &[Captured]) -> Result<(IdentifiedHinge<f32>, HingeEstimator<f32>), String> {
        let four = |captured: &Captured| std::array::from_fn(|k| captured.lengths_mm[k]);
        let mut poses: Vec<_> = taken.iter().map(|captured| HingePose::new(four(captured))).collect();
        let rig = self.rig.hinge();
        let mut estimator = HingeEstimator::new(rig, HingeSettings::for_rig(rig));
        let refused = "the host refuses what the board accepted";
        let found = estimator.run(&mut poses).map_err(|refusal| format!("{refused}: {}", refusal.text()))?;
        Ok((found, estimator))
    }

    fn judge(
        &self,
        transcript: &Transcript,
        found: &IdentifiedHinge<f32>,
        estimator: &HingeEstimator<f32>,
    ) -> ElbowReport {
        let Transcript { reviewed, shown, after_restart } = transcript;
        let truth = self.wearer.elbow().hinge();
        let value = |k: usize| f64::from(shown[k].value);
        let axis = nalgebra::Vector3::new(value(0), value(1), value(2));
        let place_mm = estimator.axis_point().at_mm.map(f64::from);
        let sigma = |part| f64::from(found.worst_sigma(part));
        ElbowReport {
            base_id: self.module.base.raw(),
            serial: self.module.serial,
            poses: self.poses[0],
            axis: axis.into(),
            axis_error_deg: axis.cross(truth.axis()).norm().atan2(axis.dot(truth.axis()).abs()).to_degrees(),
            axis_sigma_deg: sigma(HingePart::Axis).to_degrees(),
            place_mm: place_mm.into(),
            place_error_mm: (place_mm - truth.nearest_mm(&place_mm)).norm(),
            place_sigma_mm: sigma(HingePart::Place),
            host_agrees: same_bits(shown, &through_can(reviewed.run_id, found)),
            survives_restart: same_bits(shown, after_restart),
        }
    }
}

/// Why a run ended. An elbow that hardly bends gives poses of which each is too near to another, until the board gives up.
fn explained(session: &Session<'_, ElbowWearer>, error: SessionError) -> String {
    let inbox = &session.client.inbox;
    let taken = inbox.poses.iter().filter(|pose| pose.reason == Reason::Fine).count();
    let why = match inbox.outcome {
        Some(outcome) if outcome.reason != Reason::Fine => SessionError::Failed(outcome).to_string(),
        _ => error.to_string(),
    };
    match error {
        SessionError::Refused(Opcode::Capture, _) if taken < BENT_ANGLES => {
            format!("it never bends: {taken} of its angles are far enough apart; {why}")
        }
        _ => why,
    }
}

/// What a client would receive if the board had found what the host has.
fn through_can(run_id: u16, found: &IdentifiedHinge<f32>) -> [HingeNumber; SHOWN_NUMBERS] {
    let mut numbers = [HingeNumber { run_id, value: f32::NAN, sigma: f32::NAN }; SHOWN_NUMBERS];
    for (position, [value, sigma]) in FoundHinge::of(found).shown().into_iter().enumerate() {
        let index = (position / 6 * 3 + position % 3) as u8;
        let message = if position % 6 < 3 && position < SHOWN_NUMBERS - 1 {
            Message::CandidateHingeAxis(HingeAxis { run_id, index, value, sigma })
        } else {
            Message::CandidateHingePlace(HingePlace { run_id, index, value_mm: value, sigma_mm: sigma })
        };
        let sent = message.pack(BaseId::DEFAULT).ok().and_then(|frame| Message::unpack(&frame, BaseId::DEFAULT).ok());
        if let Some((place, number)) = sent.as_ref().and_then(HingeNumber::of) {
            numbers[place] = number;
        }
    }
    numbers
}

fn same_bits(one: &[HingeNumber; SHOWN_NUMBERS], other: &[HingeNumber; SHOWN_NUMBERS]) -> bool {
    let bits = |number: &HingeNumber| (number.run_id, number.value.to_bits(), number.sigma.to_bits());
    one.iter().map(bits).eq(other.iter().map(bits))
}

impl ElbowReport {
    /// What is wrong with it, in words. No number is never right.
    pub fn objections(&self) -> Vec<String> {
        let mut objections = Vec::new();
        if !(self.axis_error_deg <= SIGMAS * self.axis_sigma_deg + GRANTED_DEG) {
            let (error, sigma) = (self.axis_error_deg, self.axis_sigma_deg);
            objections.push(format!("the elbow's axis is {error:.2}° off, where its σ is {sigma:.2}°"));
        }
        if !(self.place_error_mm <= SIGMAS * self.place_sigma_mm + GRANTED_MM) {
            let (error, sigma) = (self.place_error_mm, self.place_sigma_mm);
            objections.push(format!("the elbow's axis passes {error:.2} mm off, where its σ is {sigma:.2} mm"));
        }
        if !self.host_agrees {
            objections.push("host and elbow's board differ over the same lengths".to_owned());
        }
        if !self.survives_restart {
            objections.push("the elbow's hinge after a restart is not the one that was accepted".to_owned());
        }
        objections
    }
}
