//! The slip monitor over the joint in use: when it looks at a sample, what it reports, until when.
//!
//! It looks while a joint is in use and no calibration is under way, at believable encoders only, and at most once in
//! [`PERIOD_MS`]: that bounds its cost whatever the sampling rate, and at 20 degrees a second the arm turns by a tenth
//! of a degree meanwhile. Every sample of a board that takes a hundred a second is looked at, late or early. A warning stays
//! until somebody acknowledges it or another joint is accepted. If what slipped is still where it slipped to, the next few
//! degrees of motion warn again. The joint in use never changes.

use super::live_joint::LiveJoint;
use super::{Action, Device, LogEntry};
use crate::can::Message;
use crate::can::watch::WatchReport;
use crate::identification::hinge::HingeAngles;
use crate::identification::joint::Joint;
use crate::identification::{Identified, Machine};
use crate::kinematics::CableLengths;
use crate::monitor::{DetectorState, HingeSlipDetector, SlipDetector, Warning};
use crate::procedure::elbow::ElbowProcedure;
use crate::procedure::{Candidate, ModuleProcedure, Reason, StateName};
use crate::rig::CABLES;
use nalgebra::UnitQuaternion;

/// Shortest time between two samples that are looked at, ms.
const PERIOD_MS: u32 = 5;

/// The detector of the joint in use. Both kinds share their place.
// There is one of it, and no heap to box the larger one on.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone)]
enum Detector {
    Ball(SlipDetector<f32>),
    Hinge(HingeSlipDetector<f32>),
}

/// Asks the detector that there is.
macro_rules! of_either {
    ($detector:expr, $name:ident => $call:expr) => {
        match $detector {
            Detector::Ball($name) => $call,
            Detector::Hinge($name) => $call,
        }
    };
}

impl Detector {
    fn state(&self) -> DetectorState {
        of_either!(self, detector => detector.state())
    }

    fn attitude(&self) -> Option<UnitQuaternion<f32>> {
        of_either!(self, detector => detector.attitude())
    }

    fn is_looking(&self) -> bool {
        of_either!(self, detector => detector.is_looking())
    }

    fn rearm(&mut self) {
        of_either!(self, detector => detector.rearm());
    }

    fn interrupted(&mut self) {
        of_either!(self, detector => detector.interrupted());
    }

    /// `angles`: of the hinge in use.
    fn advance(&mut self, angles: Option<&mut HingeAngles<f32>>) -> Option<Warning<f32>> {
        match self {
            Self::Ball(detector) => detector.advance(),
            Self::Hinge(detector) => detector.advance(angles?),
        }
    }
}

/// The watch over the joint in use, if there is one.
#[derive(Debug, Clone, Default)]
pub(super) struct SlipMonitor {
    detector: Option<Detector>,
    /// Where the centre in use is now; `None` for a ball, whose centre rests.
    live_joint: Option<LiveJoint>,
    /// 1σ of that centre in its worst direction, mm: every set of telemetry says it.
    centre_sigma_mm: Option<f32>,
    looked_at_ms: Option<u32>,
    /// A sample is being looked at.
    is_looking: bool,
    warning: Option<WatchReport>,
    evidence: Evidence,
    due: Due,
}

/// What is to be built next for the centre in use: all at once would take 16 000 cycles of a Cortex-M4F.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
enum Due {
    #[default]
    Nothing,
    Sigma,
    Joint,
    Detector,
}

/// How much motion has fitted the centre.
#[derive(Debug, Clone, Copy, Default)]
struct Evidence {
    samples: u16,
    first: Option<UnitQuaternion<f32>>,
    last: Option<UnitQuaternion<f32>>,
    span_rad: f32,
}

/// Samples of a moving arm that must fit before motion has borne a centre out, and how far it must have turned among
/// them, rad (20 degrees): more than a warning wants.
const CONFIRMING_SAMPLES: u16 = 64;
const CONFIRMING_SPAN_RAD: f32 = 0.35;

impl Evidence {
    /// Takes in what the detector has made of a sample. True once there is enough.
    fn add(&mut self, detector: &Detector) -> bool {
        let Some(attitude) = detector.attitude().filter(|_| detector.state() == DetectorState::Quiet) else {
            *self = Self::default();
            return false;
        };
        if self.last == Some(attitude) {
            return false;
        }
        self.last = Some(attitude);
        let first = *self.first.get_or_insert(attitude);
        self.samples = self.samples.saturating_add(1);
        self.span_rad = self.span_rad.max(first.angle_to(&attitude));
        self.samples >= CONFIRMING_SAMPLES && self.span_rad >= CONFIRMING_SPAN_RAD
    }
}

impl SlipMonitor {
    /// A watch that is still to be built, a part a tick.
    pub fn to_be_built() -> Self {
        Self { due: Due::Sigma, ..Self::default() }
    }

    /// Is there more to be built?
    pub fn is_to_be_built(&self) -> bool {
        self.due != Due::Nothing
    }

    /// Builds the next part of the watch over a centre, on the machine as it was found with the centre.
    pub fn build(&mut self, procedure: &ModuleProcedure) {
        let ball = procedure.ball().and_then(|procedure| Some((procedure.machine(), procedure.live()?)));
        let Some((machine, live)) = ball else {
            self.due = Due::Nothing;
            self.detector = procedure.hinge().and_then(watch_over).map(Detector::Hinge);
            return;
        };
        let identified = &live.identified;
        self.due = match self.due {
            Due::Sigma => {
                self.centre_sigma_mm = Some(identified.worst_centre_sigma_mm().0);
                Due::Joint
            }
            Due::Joint => {
                self.live_joint = live.motion.and_then(|_| LiveJoint::new(machine, identified));
                Due::Detector
            }
            Due::Detector => {
                self.detector = Some(Detector::Ball(detector_of(machine, live)));
                Due::Nothing
            }
            Due::Nothing => Due::Nothing,
        };
    }

    /// A sample is being looked at, or there is something to be built: the next tick should follow as soon as the board has
    /// time.
    pub fn is_busy(&self) -> bool {
        self.is_looking || self.is_to_be_built()
    }

    /// Where the centre in use is now; `None` for a ball.
    pub fn live_joint(&self) -> Option<&LiveJoint> {
        self.live_joint.as_ref()
    }

    /// 1σ of the centre in use in its worst direction, mm.
    pub fn centre_sigma_mm(&self) -> Option<f32> {
        self.centre_sigma_mm
    }

    /// What it warns of.
    pub fn warning(&self) -> Option<&WatchReport> {
        self.warning.as_ref()
    }

    /// The warning has been seen: watch on.
    pub fn acknowledge(&mut self) {
        self.warning = None;
        if let Some(detector) = self.detector.as_mut().filter(|detector| detector.state() == DetectorState::Warned) {
            detector.rearm();
        }
    }
}

fn detector_of(machine: &Machine<f32>, live: &Candidate) -> SlipDetector<f32> {
    let Identified { parameters, offsets_mm, machine: deviation, noise_mm, .. } = &live.identified;
    // A calibration whose residuals were larger than the rig's noise has shown that the cables are noisier.
    let noise_mm = machine.noise_mm().max(*noise_mm);
    let joint = live.motion.map_or(Joint::Ball, |motion| Joint::Moving(motion.model()));
    SlipDetector::new(machine, deviation, parameters, offsets_mm, noise_mm, joint)
}

fn watch_over(procedure: &ElbowProcedure) -> Option<HingeSlipDetector<f32>> {
    let noise_mm = procedure.rig().hinge().length_noise_mm().max(procedure.live()?.found.noise_mm);
    Some(HingeSlipDetector::new(procedure.rig().cables().into(), noise_mm))
}

impl Device {
    /// Lets the watch begin to look at a sample of the encoders.
    pub(super) fn monitor_sample(&mut self, now_ms: u32, counts: &[i32; CABLES], out: &mut impl FnMut(Action)) {
        let Some(detector) = self.slip_monitor.detector.as_mut() else { return };
        let in_use = matches!(self.procedure.state(), StateName::Idle | StateName::Failed);
        if !in_use || self.procedure.fault(now_ms).is_some() {
            detector.interrupted();
            // The arm may be in another cuff afterwards: what has confirmed the centre so far confirms it no more.
            self.slip_monitor.evidence = Evidence::default();
            self.slip_monitor.is_looking = false;
            // the centre is in terms of counts that have shifted
            if let Some(lost) = self.procedure.lost_count() {
                self.trust(Some(lost), out);
            }
            return;
        }
        if self.slip_monitor.looked_at_ms.is_some_and(|at_ms| now_ms.wrapping_sub(at_ms) < PERIOD_MS) {
            return;
        }
        self.slip_monitor.looked_at_ms = Some(now_ms);
        let begun = match (detector, &self.procedure) {
            (Detector::Ball(detector), ModuleProcedure::Ball(procedure)) => {
                CableLengths::from_counts(procedure.rig(), counts).ok().map(|lengths| detector.begin(&lengths))
            }
            (Detector::Hinge(detector), ModuleProcedure::Hinge(procedure)) => {
                procedure.lengths_of(counts).map(|lengths| detector.begin(&lengths))
            }
            _ => None,
        };
        self.slip_monitor.is_looking |= begun.is_some();
    }

    /// Goes on with the sample that is being looked at, a slice a tick.
    pub(super) fn monitor_tick(&mut self, out: &mut impl FnMut(Action)) {
        let Some(detector) = self.slip_monitor.detector.as_mut().filter(|_| self.slip_monitor.is_looking) else {
            return;
        };
        let Some(warning) = detector.advance(self.procedure.angles_mut()) else {
            if !detector.is_looking() {
                self.slip_monitor.is_looking = false;
                self.confirmed |= self.slip_monitor.evidence.add(detector);
            }
            return;
        };
        self.slip_monitor.is_looking = false;
        let Some(live) = self.procedure.live() else { return };
        let report = WatchReport::of(live.run_id(), &warning.cause);
        self.slip_monitor.warning = Some(report);
        self.trust(Some(report.cause), out);
        out(Action::Log(LogEntry::Slipped(report)));
    }

    /// What the watch warns of, as a fault that lasts: reason and cable.
    pub(super) fn slipped(&self) -> Option<(Reason, u8)> {
        self.slip_monitor.warning().map(|warning| (warning.cause, warning.cable))
    }

    /// Sends how far and which way, beside the fault.
    pub(super) fn report_slip(&mut self, out: &mut impl FnMut(Action)) {
        if let Some(report) = self.slip_monitor.warning().copied() {
            self.send(&Message::Watch(report), out);
        }
    }
}
