//! A module that is a ball: shoulder or wrist, its board and the joint of the person in it.

use super::bus::{Bus, Place};
use super::module::ArmModule;
use crate::estimation::Estimation;
use crate::rehearse::display::Display;
use crate::rehearse::machine::KnownMachine;
use crate::rehearse::options::Options;
use crate::rehearse::report::Report;
use crate::rehearse::session::Session;
use crate::rehearse::transcript::Transcript;
use crate::rehearse::{judgement, replay};
use crate::wearer::{Pose, Wearer, WearerSettings};
use glenoid::identification::Machine;
use glenoid::identification::arm::{Ball, Module};
use glenoid::rig::CABLES;

/// Shoulder or wrist.
pub struct BallModule {
    /// Its board.
    pub module: ArmModule,
    machine: KnownMachine,
    board: usize,
    wearer: Wearer,
    at: Pose,
    options: Options,
}

/// What its board has found, and the same calculation on the host.
pub struct CalibratedBall {
    /// The board's centre against the truth and against the host's.
    pub report: Report,
    machine: Machine<f32>,
    estimation: Estimation<f32>,
}

impl CalibratedBall {
    /// As a joint of the chain.
    pub fn ball(&self) -> Ball<'_, f32> {
        Ball { estimator: &self.estimation.estimator, machine: &self.machine }
    }
}

impl BallModule {
    /// A ball on a board.
    ///
    /// # Errors
    /// None in practice.
    pub fn new(
        which: Module,
        machine: KnownMachine,
        board: usize,
        settings: WearerSettings,
        options: &Options,
    ) -> Result<Self, String> {
        let module = ArmModule::new(which, machine.told.unwrap_or_default())?;
        let error_mm = machine.double.tolerance().base_mm;
        let built = machine.as_built((error_mm > 0.0).then_some(error_mm), settings.seed)?;
        let wearer = Wearer::new(built, settings);
        let options = Options { tilt: settings.tilt_rad.to_degrees(), ..options.clone() };
        Ok(Self { module, machine, board, at: wearer.home(), wearer, options })
    }

    /// What the board's encoders show.
    pub fn counts(&self) -> [i32; CABLES] {
        self.at.counts
    }

    /// Calibrates it, accepts the centre, and restarts the board, which must come back with it.
    ///
    /// # Errors
    /// Why there is no centre.
    pub fn calibrate(&mut self, bus: &mut dyn Bus, display: &Display) -> Result<CalibratedBall, String> {
        let (poses, second) = (self.options.poses, self.options.verification_poses());
        let calibrated = self.in_session(bus, display, |session| {
            let transcript = session.calibrate(poses, second, 0)?;
            Ok((transcript, session.restart()?))
        });
        let (transcript, after_restart) = calibrated?;
        let (wearer, known) = (&self.wearer, &self.machine);
        let report = judgement::judge(&transcript, &after_restart, wearer, known, &self.options, None)?;
        let (machine, estimation) = self.estimate(&transcript)?;
        Ok(CalibratedBall { report, machine, estimation })
    }

    /// The way of the encoders to another posture, a sample every so many ms. The joint is there from now on.
    pub fn move_on(&mut self, duration_ms: u32, period_ms: u32) -> Vec<[i32; CABLES]> {
        let from = std::mem::replace(&mut self.at, self.wearer.next_pose());
        self.wearer.motion(&from, &self.at, duration_ms, period_ms)
    }

    /// The person's joint.
    pub fn wearer(&self) -> &Wearer {
        &self.wearer
    }

    /// The posture in which it stands.
    pub fn at(&self) -> &Pose {
        &self.at
    }

    fn in_session<T>(
        &mut self,
        bus: &mut dyn Bus,
        display: &Display,
        act: impl FnOnce(&mut Session<'_>) -> Result<T, crate::rehearse::SessionError>,
    ) -> Result<T, String> {
        let fastest = self.machine.double.drum().fastest_mm_per_s;
        let mut place = Place::new(bus, self.board);
        let session = Session::new(&mut place, &mut self.wearer, fastest, display);
        let mut session = session.at(self.module.base).standing_in(self.at);
        let result = act(&mut session);
        let at = *session.pose();
        self.at = at;
        result.map_err(|error| error.to_string())
    }

    /// The very calculation of the board, from the lengths that were read out of it.
    fn estimate(&self, transcript: &Transcript) -> Result<(Machine<f32>, Estimation<f32>), String> {
        let taken: Vec<_> = transcript.identification.iter().map(|pose| (pose.lengths_mm, pose.samples)).collect();
        let refused = |refusal: glenoid::identification::Refusal| refusal.text().to_owned();
        let (machine, estimation) = replay::estimate(&self.machine.single, &taken, 0.0).map_err(refused)?;
        match &estimation.outcome {
            Ok(_) => Ok((machine, estimation)),
            Err(refusal) => Err(refused(*refusal)),
        }
    }
}
