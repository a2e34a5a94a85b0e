//! A calibration of a shoulder whose centre moves, in one phase or two: is the centre where the board says, in poses that
//! identified nothing?

use super::bench::Bench;
use super::client::ANSWER_LIMIT_MS;
use super::display::Display;
use super::in_motion::Motion;
use super::machine::KnownMachine;
use super::options::Options;
use super::report::{Report, Status};
use super::session::{SOLVER_LIMIT_MS, Session};
use super::shoulder_report::ShoulderReport;
use super::transcript::{Captured, SessionError};
use crate::estimation::estimate_poses;
use crate::identify::held_phase;
use crate::wearer::Wearer;
use glenoid::can::Opcode;
use glenoid::can::command::{BY_COMMAND_ONLY, HELD_FIRST, IN_MOTION};
use glenoid::can::result::Parameter;
use glenoid::identification::joint::{MovingCentre, ShownMotion};
use glenoid::identification::verification::CentrePrediction;
use glenoid::identification::{EstimatorSettings, Machine, Pose, Refusal};
use glenoid::kinematics::CableLengths;
use glenoid::procedure::{PoseSet, StateName};
use glenoid::rig::Rig;
use nalgebra::{Matrix3, Vector3};

/// Poses of a held phase.
const HELD_POSES: u8 = 20;
/// 99 % of the squared distances of a centre from its prediction lie below this many squared σ (χ², 3 degrees of freedom).
const WITHIN_99: f64 = 11.345;
/// An error beyond this many σ and this much, mm, is wrong.
const SIGMAS: f64 = 5.0;
const GRANTED_MM: f64 = 0.05;

/// What the session has brought to light.
struct Transcript {
    /// From the start to the new centre.
    seconds: f64,
    held: Vec<Captured>,
    free: Vec<Captured>,
    second: Vec<Captured>,
    parameters: [Parameter; 6],
    motion: Option<ShownMotion>,
    motion_after_restart: Option<ShownMotion>,
    parameters_after_restart: [Parameter; 6],
}

/// Rehearses it on a bench and holds the result against the truth.
pub(super) fn rehearse(
    bench: &mut dyn Bench,
    wearer: &mut Wearer,
    known: &KnownMachine,
    options: &Options,
    display: &Display,
) -> Report {
    let truth = wearer.truth();
    let mut session = Session::new(bench, wearer, known.double.drum().fastest_mm_per_s, display);
    let told = known.told.as_ref().map(|set| session.become_machine(set)).transpose();
    let transcript = told.and_then(|_| session.shoulder(options)).map_err(|error| error.to_string());
    let report = transcript.and_then(|transcript| {
        let (shoulder, reasons) = judge(&transcript, &known.single, options)?;
        Ok(Report {
            status: if reasons.is_empty() { Status::Right } else { Status::Wrong },
            reasons,
            shoulder: Some(shoulder),
            ..Report::failed(options, &truth, String::new())
        })
    });
    report.unwrap_or_else(|reason| Report::failed(options, &truth, reason))
}

impl Session<'_> {
    fn shoulder(&mut self, options: &Options) -> Result<Transcript, SessionError> {
        let bit = |asked: bool, bit: u16| if asked { bit } else { 0 };
        let start = BY_COMMAND_ONLY | bit(options.two_phase, HELD_FIRST) | bit(options.free_motion, IN_MOTION);
        let mut motion = if options.free_motion { Some(self.begin_motion()?) } else { None };
        let (_, run_id) = self.begin(0, start)?;
        let began_ms = self.client.elapsed_ms;
        let held = if options.two_phase { self.held_phase(run_id, &mut motion)? } else { Vec::new() };
        let mut free = self.collect_either(&mut motion, PoseSet::Identification, options.poses)?;
        self.identify()?;
        let mut second = self.collect_either(&mut motion, PoseSet::HeldOut, options.verification_poses())?;
        self.client.command(Opcode::Verify, 0, 0)?;
        self.client.wait_for_state(StateName::Verifying, StateName::Review, SOLVER_LIMIT_MS)?;
        let seconds = f64::from(self.client.elapsed_ms - began_ms) / 1000.0;
        self.read_out(run_id, &mut free, &mut second)?;
        if let Some(motion) = &motion {
            motion.locate(&mut second);
        }
        let parameters = self.client.wait_for("report", ANSWER_LIMIT_MS, |inbox| inbox.parameters(run_id))?;
        self.accept(run_id)?;
        // It comes before the outcome, which the accept has waited for.
        let motion = self.client.inbox.motion(run_id);
        let parameters_after_restart = self.restart()?;
        let motion_after_restart = match motion {
            Some(_) => Some(self.client.wait_for("motion", ANSWER_LIMIT_MS, |inbox| inbox.live_motion(run_id))?),
            None => None,
        };
        Ok(Transcript {
            seconds,
            held,
            free,
            second,
            parameters,
            motion,
            motion_after_restart,
            parameters_after_restart,
        })
    }

    /// Poses in motion, or each held.
    fn collect_either(
        &mut self,
        motion: &mut Option<Motion>,
        set: PoseSet,
        count: u8,
    ) -> Result<Vec<Captured>, SessionError> {
        match motion {
            Some(motion) => self.collect_in_motion(motion, set, count),
            None => self.collect(set, count).map(|(captured, _)| captured),
        }
    }

    /// The first of two phases.
    fn held_phase(&mut self, run_id: u16, motion: &mut Option<Motion>) -> Result<Vec<Captured>, SessionError> {
        self.wearer.hold_blade(true);
        let mut held = self.collect_either(motion, PoseSet::Identification, HELD_POSES)?;
        self.read_out(run_id, &mut held, &mut [])?;
        self.client.command(Opcode::Identify, 0, 0)?;
        self.client.wait_for_state(StateName::Identifying, StateName::Collecting, SOLVER_LIMIT_MS)?;
        // The next phase numbers its poses from 0 again.
        self.client.inbox.lengths_mm.clear();
        self.client.inbox.poses.clear();
        self.wearer.hold_blade(false);
        Ok(held)
    }
}

/// Holds what the board found against the truth, and against the host's own calculation.
fn judge(transcript: &Transcript, rig: &Rig<f32>, options: &Options) -> Result<(ShoulderReport, Vec<String>), String> {
    let machine = Machine::new(rig);
    let settings = EstimatorSettings::for_rig(rig);
    let refused = |refusal: Refusal| format!("the host refuses what the board accepted: {}", refusal.text());
    let held = match &transcript.held[..] {
        [] => None,
        poses => Some(held_phase::identify(&machine, rig, settings, as_taken(poses)?).map_err(refused)?),
    };
    let estimation = estimate_poses(&machine, rig, settings, held, as_taken(&transcript.free)?);
    let identified = estimation.outcome.map_err(refused)?;
    let estimator = &estimation.estimator;
    let host = match estimator.joint() {
        glenoid::identification::joint::Joint::Moving(moving) => {
            let [across_mm, all_mm] = estimator.path_sigmas_mm();
            ShownMotion::new(moving, across_mm, all_mm)
        }
        _ => None,
    };
    let mut reasons = Vec::new();
    let mut difference_mm = super::replay::difference_mm(&transcript.parameters, &identified.parameters);
    if host != transcript.motion {
        difference_mm = f64::INFINITY;
    }
    if difference_mm != 0.0 {
        reasons.push("host and board differ over the same lengths".to_string());
    }
    let bits = |parameters: &[Parameter; 6]| parameters.map(|parameter| parameter.value_mm.to_bits());
    let survives_restart = transcript.motion_after_restart == transcript.motion
        && bits(&transcript.parameters) == bits(&transcript.parameters_after_restart);
    if !survives_restart {
        reasons.push("the centre in use after a restart is not the one that was accepted".to_string());
    }

    let second = as_taken(&transcript.second)?;
    let model = transcript.motion.map(|motion| motion.model());
    let mut sums = Sums::default();
    for (captured, mut pose) in transcript.second.iter().zip(second) {
        pose.place(machine.platform());
        if !pose.is_placed() {
            return Err("a pose does not close".to_string());
        }
        let prediction = estimator.predict(&machine, &pose).ok_or("a pose has no prediction")?;
        let found_mm = shown_mm(&transcript.parameters, model.as_ref(), &pose.rotation());
        let arm = pose.rotation().map(f64::from).column(2).into_owned();
        if let Some(objection) = sums.add(captured, &prediction, &found_mm, &arm) {
            reasons.push(objection);
        }
    }
    let [scatter_mm, across_sigma_mm, path_sigma_mm] =
        transcript.motion.map_or([0.0; 3], |motion| motion.sigmas_mm().map(f64::from));
    let report =
        sums.report(options, transcript, [scatter_mm, across_sigma_mm, path_sigma_mm], difference_mm, survives_restart);
    if transcript.motion.is_some() && !(report.covered >= 0.8) {
        reasons.push(format!("only {:.0} % of the poses lie within the 99 % region", report.covered * 100.0));
    }
    Ok((report, reasons))
}

/// The centre that the board's shown numbers give at a rotation, mm.
fn shown_mm(parameters: &[Parameter; 6], model: Option<&MovingCentre<f32>>, rotation: &Matrix3<f32>) -> Vector3<f64> {
    let [x, y, z, ..] = parameters.map(|parameter| parameter.value_mm);
    let moved = model.map_or_else(Vector3::zeros, |model| model.displacement_mm(rotation));
    (Vector3::new(x, y, z) + moved).map(f64::from)
}

/// Sums over the poses of the second set.
#[derive(Default)]
struct Sums {
    poses: f64,
    path: f64,
    across: f64,
    covered: f64,
    live: f64,
    centre: Vector3<f64>,
    centre_squares: f64,
}

impl Sums {
    /// Adds a pose; what is wrong with it, in words.
    fn add(
        &mut self,
        captured: &Captured,
        prediction: &CentrePrediction<f32>,
        found_mm: &Vector3<f64>,
        arm: &Vector3<f64>,
    ) -> Option<String> {
        let true_mm = captured.pose.centre_mm;
        let covariance = prediction.predicted_covariance_mm2.map(f64::from);
        let error = found_mm - true_mm;
        let distance = covariance.try_inverse().map_or(f64::INFINITY, |inverse| error.dot(&(inverse * error)));
        let live = prediction.live_mm.map(f64::from) - true_mm - captured.pose.slide_mm;
        self.poses += 1.0;
        self.path += error.norm_squared();
        self.across += (error - arm * error.dot(arm)).norm_squared();
        self.covered += f64::from(u8::from(distance < WITHIN_99));
        self.live += live.norm_squared();
        self.centre += true_mm;
        self.centre_squares += true_mm.norm_squared();
        let sigma_mm = covariance.trace().sqrt();
        let is_wrong = !(error.norm() <= SIGMAS * sigma_mm + GRANTED_MM);
        is_wrong.then(|| format!("the centre is off by {:.2} mm where its σ is {sigma_mm:.2} mm", error.norm()))
    }

    fn report(
        &self,
        options: &Options,
        transcript: &Transcript,
        [scatter_mm, across_sigma_mm, path_sigma_mm]: [f64; 3],
        difference_mm: f64,
        survives_restart: bool,
    ) -> ShoulderReport {
        let rms = |squares: f64| (squares / self.poses).sqrt();
        let travel_mm = rms(self.centre_squares - self.centre.norm_squared() / self.poses);
        ShoulderReport {
            person: options.shoulder.unwrap_or_default(),
            follow: options.follow,
            two_phases: options.two_phase,
            in_motion: options.free_motion,
            poses: transcript.free.len(),
            wearer_s: transcript.seconds,
            travel_mm,
            path_error_mm: rms(self.path),
            across_error_mm: rms(self.across),
            path_sigma_mm,
            across_sigma_mm,
            covered: self.covered / self.poses,
            live_error_mm: rms(self.live),
            scatter_mm,
            difference_mm,
            survives_restart,
        }
    }
}

/// The poses as the board took them.
fn as_taken(captured: &[Captured]) -> Result<Vec<Pose<f32>>, String> {
    let pose = |captured: &Captured| {
        let lengths = CableLengths::new(captured.lengths_mm).map_err(|error| error.fault.text().to_string())?;
        Ok(Pose::new(lengths).averaged_over(captured.samples))
    };
    captured.iter().map(pose).collect()
}
