//! The calibration of a module, whichever joint its rig is about: one place that knows both procedures.

mod found;
mod rig;

pub use found::{FoundJoint, JointValue};
pub use rig::ModuleRig;

use super::Procedure;
use super::arm::NotReady;
use super::elbow::{ElbowCandidate, ElbowProcedure};
use super::encoders::EncoderFault;
use super::guidance::Guidance;
use super::limits::Limits;
use super::outcome::{Candidate, Ending, PoseNotice};
use super::reason::Reason;
use super::reply::Reply;
use super::solve::Detail;
use super::state::{Command, PoseSet, StateName};
use crate::identification::hinge::{FollowedAngle, HingeAngles};
use crate::rig::{CABLES, Drum};

/// The procedure of a module. Both kinds share their place.
// There is one of it, and no heap to box the larger one on.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone)]
pub enum ModuleProcedure {
    /// Of a shoulder or a wrist.
    Ball(Procedure),
    /// Of an elbow.
    Hinge(ElbowProcedure),
}

/// Asks the procedure that there is.
macro_rules! of_either {
    ($procedure:expr, $name:ident => $call:expr) => {
        match $procedure {
            Self::Ball($name) => $call,
            Self::Hinge($name) => $call,
        }
    };
}

impl ModuleProcedure {
    /// The procedure, if the joint is a ball.
    pub const fn ball(&self) -> Option<&Procedure> {
        match self {
            Self::Ball(procedure) => Some(procedure),
            Self::Hinge(_) => None,
        }
    }

    /// The procedure, if the joint is a hinge.
    pub const fn hinge(&self) -> Option<&ElbowProcedure> {
        match self {
            Self::Ball(_) => None,
            Self::Hinge(procedure) => Some(procedure),
        }
    }

    /// The ball's procedure, to spoil it as memory can.
    #[cfg(test)]
    pub(crate) fn ball_mut(&mut self) -> Option<&mut Procedure> {
        match self {
            Self::Ball(procedure) => Some(procedure),
            Self::Hinge(_) => None,
        }
    }

    /// Goes on after a power-down: in which boot, and from which run id on.
    pub fn resume_at(&mut self, boot: u16, last_run_id: u16) {
        of_either!(self, procedure => procedure.resume_at(boot, last_run_id));
    }

    /// Takes over the centre of an earlier run, of before the power was switched off.
    ///
    /// # Errors
    /// What about it cannot be, [`Reason::RecordOfOtherRig`] where the joint is a hinge; there is none in use then.
    pub fn resume_ball(&mut self, live: Candidate) -> Result<(), Reason> {
        match self {
            Self::Ball(procedure) => procedure.resume(live),
            Self::Hinge(_) => Err(Reason::RecordOfOtherRig),
        }
    }

    /// The same for a hinge.
    ///
    /// # Errors
    /// [`Reason::RecordUnfit`], or [`Reason::RecordOfOtherRig`] where the joint is a ball; there is none in use then.
    pub fn resume_hinge(&mut self, live: ElbowCandidate) -> Result<(), Reason> {
        match self {
            Self::Ball(_) => Err(Reason::RecordOfOtherRig),
            Self::Hinge(procedure) => procedure.resume(live),
        }
    }

    /// Sets whose arm the runs to come are made for; 0 = not said. Not while a run is under way.
    pub fn set_wearer(&mut self, wearer: u16) -> Reason {
        of_either!(self, procedure => procedure.set_wearer(wearer))
    }

    /// Sets how well the encoder zeros are known in the runs to come, 1σ, mm. An elbow's always go by its
    /// rig's tolerance, which is what 0 asks for.
    pub fn set_zero_prior(&mut self, prior_mm: f32) -> Reason {
        match self {
            Self::Ball(procedure) => procedure.set_zero_prior(prior_mm),
            Self::Hinge(_) if prior_mm == 0.0 => Reason::Fine,
            Self::Hinge(_) => Reason::NotOfHinge,
        }
    }

    /// Takes in one sample of the six counts.
    pub fn sample(&mut self, now_ms: u32, counts: &[i32; CABLES]) {
        of_either!(self, procedure => procedure.sample(now_ms, counts));
    }

    /// Obeys a command, or says why not.
    pub fn command(&mut self, now_ms: u32, command: Command) -> Reply {
        of_either!(self, procedure => procedure.command(now_ms, command))
    }

    /// The answer to a command that was to come later, once; an elbow answers every command at once.
    pub fn take_answer(&mut self) -> Option<(Reason, u16)> {
        match self {
            Self::Ball(procedure) => procedure.take_answer(),
            Self::Hinge(_) => None,
        }
    }

    /// Time passes. Returns the pose that was captured or refused, if any.
    pub fn tick(&mut self, now_ms: u32) -> Option<PoseNotice> {
        of_either!(self, procedure => procedure.tick(now_ms))
    }

    /// The drive: counts to lengths.
    pub fn drum(&self) -> &Drum<f32> {
        of_either!(self, procedure => procedure.rig().drum())
    }

    /// Cables, which are also the encoders in use, from the first on.
    pub fn cables(&self) -> u8 {
        match self {
            Self::Ball(_) => CABLES as u8,
            Self::Hinge(procedure) => procedure.rig().cables(),
        }
    }

    /// The limits of a run.
    pub const fn limits(&self) -> &Limits {
        of_either!(self, procedure => procedure.limits())
    }

    /// The state's name.
    pub const fn state(&self) -> StateName {
        of_either!(self, procedure => procedure.state())
    }

    /// There is computing to do: the next tick should follow as soon as the board has time.
    pub const fn is_busy(&self) -> bool {
        of_either!(self, procedure => procedure.is_busy())
    }

    /// The run under way, or the last one; 0 before the first.
    pub const fn run_id(&self) -> u16 {
        of_either!(self, procedure => procedure.run_id())
    }

    /// Are poses captured by command only?
    pub const fn by_command_only(&self) -> bool {
        of_either!(self, procedure => procedure.by_command_only())
    }

    /// Is the shoulder blade to be held now: the first of two phases?
    pub const fn is_held_phase(&self) -> bool {
        match self {
            Self::Ball(procedure) => procedure.is_held_phase(),
            Self::Hinge(_) => false,
        }
    }

    /// Whose arm the runs to come, or the one under way, are made for.
    pub const fn wearer(&self) -> u16 {
        of_either!(self, procedure => procedure.wearer())
    }

    /// The joint in use.
    pub fn live(&self) -> Option<FoundJoint<'_>> {
        match self {
            Self::Ball(procedure) => procedure.live().map(FoundJoint::Ball),
            Self::Hinge(procedure) => procedure.live().map(FoundJoint::Hinge),
        }
    }

    /// The new joint that waits for a decision.
    pub fn candidate(&self) -> Option<FoundJoint<'_>> {
        match self {
            Self::Ball(procedure) => procedure.candidate().map(FoundJoint::Ball),
            Self::Hinge(procedure) => procedure.candidate().map(FoundJoint::Hinge),
        }
    }

    /// What the run has identified so far, verified or not.
    pub fn identified(&self) -> Option<JointValue<'_>> {
        match self {
            Self::Ball(procedure) => {
                procedure.identified().map(|identified| JointValue::Ball(identified, procedure.motion()))
            }
            Self::Hinge(procedure) => procedure.found().map(JointValue::Hinge),
        }
    }

    /// How the last run ended; None while one is under way and before the first.
    pub const fn ending(&self) -> Option<&Ending> {
        of_either!(self, procedure => procedure.ending())
    }

    /// Why the solver refused the set, last; None when it did not.
    pub const fn refusal(&self) -> Option<&Detail> {
        of_either!(self, procedure => procedure.refusal())
    }

    /// Captured poses of a set.
    pub fn poses_of(&self, set: PoseSet) -> usize {
        match self {
            Self::Ball(procedure) => procedure.poses(set).len(),
            Self::Hinge(procedure) => procedure.poses(set).len(),
        }
    }

    /// The lengths of a captured pose, mm: as many as there are cables.
    pub fn lengths_mm(&self, set: PoseSet, index: u8) -> Option<&[f32]> {
        let index = usize::from(index);
        match self {
            Self::Ball(procedure) => Some(procedure.poses(set).get(index)?.lengths().as_mm()),
            Self::Hinge(procedure) => {
                let pose = procedure.poses(set).get(index)?;
                pose.lengths_mm.get(..usize::from(procedure.rig().cables()))
            }
        }
    }

    /// How many samples a captured pose is the mean of, where the rig makes a difference of that.
    pub fn samples(&self, set: PoseSet, index: u8) -> Option<u16> {
        let procedure = self.ball().filter(|procedure| procedure.rig().sample_noise_mm() > 0.0)?;
        procedure.poses(set).get(usize::from(index)).map(|pose| pose.samples)
    }

    /// How far the hinge in use bends where the counts stand so; `None` for a ball.
    pub fn angle(&mut self, counts: &[i32; CABLES]) -> Option<FollowedAngle<f32>> {
        match self {
            Self::Ball(_) => None,
            Self::Hinge(procedure) => procedure.angle(counts),
        }
    }

    /// The angles of the hinge in use; `None` for a ball.
    pub fn angles_mut(&mut self) -> Option<&mut HingeAngles<f32>> {
        match self {
            Self::Ball(_) => None,
            Self::Hinge(procedure) => procedure.angles_mut(),
        }
    }

    /// What is wrong with the encoders now.
    pub fn fault(&self, now_ms: u32) -> Option<EncoderFault> {
        of_either!(self, procedure => procedure.fault(now_ms))
    }

    /// The reason, if a count was lost since the last run began.
    pub fn lost_count(&self) -> Option<Reason> {
        of_either!(self, procedure => procedure.lost_count())
    }

    /// Is the arm held still, with believable encoders and every cable at rest?
    ///
    /// # Errors
    /// What is in the way.
    pub fn arm(&self, now_ms: u32) -> Result<(), NotReady> {
        of_either!(self, procedure => procedure.arm(now_ms))
    }

    /// Poses in the set that is being captured, or was last.
    pub fn pose_count(&self) -> u8 {
        of_either!(self, procedure => procedure.pose_count())
    }

    /// Progress in percent.
    pub fn progress_percent(&self) -> u8 {
        of_either!(self, procedure => procedure.progress_percent())
    }

    /// Why the run stands where it stands, or what disturbs it now.
    pub fn reason(&self, now_ms: u32) -> Reason {
        of_either!(self, procedure => procedure.reason(now_ms))
    }

    /// What the person at the arm should do now.
    pub fn guidance(&self, now_ms: u32) -> Guidance {
        of_either!(self, procedure => procedure.guidance(now_ms))
    }
}
