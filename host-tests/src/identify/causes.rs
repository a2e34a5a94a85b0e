//! What explains a log that the fixed centre and the stated machine do not: causes are told apart by χ².
//!
//! All poses are fitted alike; each explanation is tried as further columns of that fit, and is rated by the χ² that is
//! left plus what its parameters cost (ln of the number of equations for each: Schwarz 1978). The best is named with its
//! size when the next of another kind is clearly worse, else it is said that the two cannot be told apart.

mod all_poses_fit;
mod columns;
mod wiring;
mod words;

use self::all_poses_fit::{AllPosesFit, Freedom};
use glenoid::identification::Machine;
use glenoid::identification::joint::MIN_MOVING_POSES;
use glenoid::identification::machine::MachineParameter;
use glenoid::identification::statistics::{FALSE_ALARM, chi_square_quantile};
use glenoid::kinematics::CableLengths;
use glenoid::rig::Rig;
use serde::Serialize;

pub use self::words::{remedy, text};

/// So much worse must the next explanation of another kind be for the best to be named alone.
const CLEARLY_WORSE: f64 = 10.0;
/// Scatter about a moving centre beyond which it is no joint's, mm.
const MAX_SCATTER_MM: f64 = 1.0;
/// A constant so many standard deviations from what its tolerance allows contradicts it: in 200 sound sets none was beyond
/// 3.7.
const CONTRADICTS: f64 = 4.5;

/// A kind of cause.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CauseKind {
    /// Nothing beside a fixed centre and the machine as stated.
    Nothing,
    /// The drum of one cable pays out more or less than stated.
    DrumScale,
    /// One encoder's offset.
    EncoderOffset,
    /// Cables lag behind the direction of movement.
    Hysteresis,
    /// The attachment points are not where they are stated.
    BaseShape,
    /// The platform is not as stated.
    PlatformShape,
    /// Counts were lost between two poses.
    LostCounts,
    /// The base slipped on the body between two poses.
    BaseSlipped,
    /// The cuff slipped on the arm between two poses.
    CuffSlipped,
    /// The centre scatters from pose to pose: something is loose.
    Loose,
    /// The joint centre moves with the arm.
    MovingJoint,
    /// One encoder stands still.
    ConstantEncoder,
    /// Two cables are exchanged.
    ExchangedCables,
}

/// A cause with its size.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Cause {
    /// What it is.
    pub kind: CauseKind,
    /// The cable meant, 1 to 6.
    pub cable: Option<u8>,
    /// The cable that it is exchanged with.
    pub other_cable: Option<u8>,
    /// The first pose after it happened: row of the log, from 0.
    pub pose: Option<usize>,
    /// How large, mm; of a drum per cent; 0 where there is none.
    pub size: f64,
    /// With it, the residuals are no larger than the noise.
    pub explains: bool,
}

/// What explains a log best.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Causes {
    /// The best explanation.
    pub best: Cause,
    /// Another kind that explains it nearly as well.
    pub or: Option<Cause>,
}

/// A cause with what is left of χ², and what its parameters cost.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Scored {
    cause: Cause,
    score: f64,
}

impl CauseKind {
    /// May it be the joint, and no fault of the machine?
    pub const fn may_be_the_joint(self) -> bool {
        matches!(self, Self::Loose | Self::MovingJoint)
    }

    /// Largest size that is told by the linear model: mm, of a drum per cent.
    const fn largest(self) -> f64 {
        match self {
            Self::DrumScale => 20.0,
            Self::Hysteresis => 10.0,
            _ => 30.0,
        }
    }
}

impl Cause {
    const fn of(kind: CauseKind) -> Self {
        Self { kind, cable: None, other_cable: None, pose: None, size: 0.0, explains: false }
    }
}

impl Scored {
    /// From the fit without it: `gain` is what it takes off χ². `None` for a size beyond which the fit says nothing of it.
    fn within(cause: Cause, fit: &AllPosesFit, gain: f64, cost: f64) -> Option<Self> {
        (cause.size.abs() <= cause.kind.largest()).then(|| Self::new(cause, fit, gain, cost))
    }

    fn new(cause: Cause, fit: &AllPosesFit, gain: f64, cost: f64) -> Self {
        let left = fit.chi_square - gain;
        let explains = left <= chi_square_quantile(fit.freedom, FALSE_ALARM);
        Self { cause: Cause { explains, ..cause }, score: fit.likelihood - gain + cost }
    }
}

/// What explains these poses best; `None` when nothing beside the stated machine is needed, or nothing can be said.
pub fn find(rig: &Rig<f64>, machine: &Machine<f64>, lengths: &[CableLengths<f64>], noise_mm: f64) -> Option<Causes> {
    if let Some(best) = wiring::standing_still(lengths) {
        return Some(Causes { best, or: None });
    }
    let still = Freedom { scatters: false, moves: false };
    let fit = AllPosesFit::new(machine, lengths, noise_mm, still);
    if let Some(fit) = fit.as_ref().filter(|fit| fit.chi_square <= chi_square_quantile(fit.freedom, FALSE_ALARM)) {
        // The stated machine can take it up; but as far as that?
        return contradiction_in(machine, fit).map(|best| Causes { best, or: None });
    }
    let compared = fit.map(|fit| compare(rig, machine, lengths, noise_mm, &fit)).unwrap_or_default();
    // A scatter explains everything: it counts when it is one that a joint can have.
    let is_settled = |scored: &Scored| match scored.cause.kind {
        CauseKind::Loose => false,
        CauseKind::MovingJoint => scored.cause.size < MAX_SCATTER_MM,
        _ => scored.cause.explains,
    };
    let best = compared.first();
    if !best.is_some_and(is_settled) {
        // Nothing that a fit can show: what leaves none.
        let other = wiring::exchanged(machine, lengths, noise_mm)
            .filter(|cause| cause.explains)
            .or_else(|| wiring::count_begun_anew(rig, machine, lengths, noise_mm));
        if let Some(best) = other {
            return Some(Causes { best, or: None });
        }
    }
    let best = best?;
    let next = compared.iter().find(|other| other.cause.kind != best.cause.kind);
    let or = next.filter(|next| next.score - best.score < CLEARLY_WORSE).map(|next| next.cause);
    (best.cause.kind != CauseKind::Nothing).then_some(Causes { best: best.cause, or })
}

/// The two cables that are exchanged in all of these poses, where that gives them a joint that they have not without.
pub fn exchanged(machine: &Machine<f64>, lengths: &[CableLengths<f64>], noise_mm: f64) -> Option<Causes> {
    let best = wiring::exchanged(machine, lengths, noise_mm).filter(|cause| cause.explains)?;
    Some(Causes { best, or: None })
}

/// All explanations, the best first.
fn compare(
    rig: &Rig<f64>,
    machine: &Machine<f64>,
    lengths: &[CableLengths<f64>],
    noise_mm: f64,
    fit: &AllPosesFit,
) -> Vec<Scored> {
    let cost = (3.0 * lengths.len() as f64).ln();
    let mut all = vec![Scored::new(Cause::of(CauseKind::Nothing), fit, 0.0, 0.0)];
    all.extend(columns::of_the_machine(fit, rig, lengths));
    all.extend(columns::from_a_pose_on(fit));
    // By their own scatter these leave no residuals beyond the noise.
    let mut scattered = |kind, moves, parameters: f64| {
        if let Some(fit) = AllPosesFit::new(machine, lengths, noise_mm, Freedom { scatters: true, moves }) {
            let cause = Cause { size: fit.scatter_mm, explains: true, ..Cause::of(kind) };
            all.push(Scored { cause, score: fit.likelihood + cost * parameters });
        }
    };
    scattered(CauseKind::Loose, false, 1.0);
    if lengths.len() >= MIN_MOVING_POSES {
        scattered(CauseKind::MovingJoint, true, 19.0);
    }
    all.sort_by(|one, other| one.score.total_cmp(&other.score));
    all
}

/// The constant of the machine that contradicts its stated tolerance most, in a set that is accepted: its estimate is
/// further from what was stated than the tolerance lets it be.
pub fn contradiction(machine: &Machine<f64>, lengths: &[CableLengths<f64>], noise_mm: f64) -> Option<Cause> {
    let still = Freedom { scatters: false, moves: false };
    contradiction_in(machine, &AllPosesFit::new(machine, lengths, noise_mm, still)?)
}

fn contradiction_in(machine: &Machine<f64>, fit: &AllPosesFit) -> Option<Cause> {
    let tolerance = machine.tolerance();
    let off = |index: usize| {
        let (kind, cable, sigma) = match machine.parameter(index) {
            MachineParameter::Base(_) => (CauseKind::BaseShape, None, tolerance.base_mm),
            MachineParameter::Ends(_) => (CauseKind::PlatformShape, None, tolerance.edges_mm),
            MachineParameter::Offset(cable) => (CauseKind::EncoderOffset, Some(cable), tolerance.offset_mm),
            // The estimate is in per cent.
            MachineParameter::Scale(cable) => (CauseKind::DrumScale, Some(cable), 100.0 * tolerance.drum),
        };
        let value = fit.estimate.values()[index];
        let learnt = sigma * sigma - fit.covariance[(index, index)];
        let cause = Cause {
            cable: cable.map(|cable| cable as u8 + 1),
            // What the poses alone say: the tolerance draws the estimate towards what is stated.
            size: value * sigma * sigma / learnt,
            explains: true,
            ..Cause::of(kind)
        };
        (value.abs() / learnt.max(f64::MIN_POSITIVE).sqrt(), cause, learnt > 1e-3 * sigma * sigma)
    };
    let offs = (0..machine.parameters()).map(off).filter(|(_, _, is_learnt)| *is_learnt);
    let (times, cause, _) = offs.max_by(|one, other| one.0.total_cmp(&other.0))?;
    (times > CONTRADICTS).then_some(cause)
}
