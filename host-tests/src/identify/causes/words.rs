//! A cause in words, and what to do about it.

use super::{Cause, CauseKind, Causes};
use crate::identify::lengths_file::LengthsFile;
use crate::identify::wording;

/// What explains the log, in a sentence.
pub fn text(causes: &Causes, log: &LengthsFile) -> String {
    let best = named(&causes.best, log);
    match &causes.or {
        Some(or) => format!("cannot be told apart: {best}, or {}", named(or, log)),
        None if causes.best.explains => best,
        None => format!("mostly that {best}; something else remains"),
    }
}

/// What to do.
pub fn remedy(cause: &Cause) -> &'static str {
    match cause.kind {
        CauseKind::Nothing => "",
        CauseKind::DrumScale => {
            "Measure that drum and the gear behind it, or commission the machine (cargo commission)."
        }
        CauseKind::EncoderOffset => "Home that cable again, or say with --zeros how well the cables are homed.",
        CauseKind::Hysteresis => {
            "Look for friction: pulleys, guides, a cable that rubs. Come to every pose from one side."
        }
        CauseKind::BaseShape => "Measure the attachment points again, or commission the machine (cargo commission).",
        CauseKind::PlatformShape => "Measure the platform again, or commission the machine (cargo commission).",
        CauseKind::LostCounts => "Check that encoder and its cable; use the poses on one side of the loss only.",
        CauseKind::BaseSlipped => "Tighten the strap of the base; use the poses on one side of the slip only.",
        CauseKind::CuffSlipped => "Tighten the cuff; use the poses on one side of the slip only.",
        CauseKind::Loose => "Look for a loose strap, cuff or cable, move slowly and hold each pose.",
        CauseKind::MovingJoint => {
            "Record more poses: tilt the arm in all directions, and turn it about its own length."
        }
        CauseKind::ConstantEncoder => "Check that encoder and its connector: it does not count.",
        CauseKind::ExchangedCables => "Exchange those two connectors, or those two columns of the log.",
    }
}

fn named(cause: &Cause, log: &LengthsFile) -> String {
    let cable = cause.cable.unwrap_or_default();
    let size = cause.size;
    let from = || cause.pose.map_or_else(String::new, |pose| format!(" before {}", wording::pose(pose, log)));
    match cause.kind {
        CauseKind::Nothing => "the machine is as stated, and the centre is fixed".to_owned(),
        CauseKind::DrumScale => format!("the drum of cable {cable} pays out {size:+.2} % more than stated"),
        CauseKind::EncoderOffset => format!("cable {cable} reads {size:+.2} mm too much"),
        CauseKind::Hysteresis if cause.cable.is_none() => format!("the cables have {size:.2} mm of hysteresis"),
        CauseKind::Hysteresis => format!("cable {cable} has {size:.2} mm of hysteresis"),
        CauseKind::BaseShape => format!("the attachment points are off by {:.1} mm in all", size.abs()),
        CauseKind::PlatformShape => format!("the platform is off by {:.1} mm in all", size.abs()),
        CauseKind::LostCounts => format!("cable {cable} lost counts{}: it reads {size:+.2} mm too much since", from()),
        CauseKind::BaseSlipped => format!("the base slipped by {size:.1} mm{}", from()),
        CauseKind::CuffSlipped => format!("the cuff slipped by {size:.1} mm{}", from()),
        CauseKind::Loose => format!("something is loose: the centre scatters by {size:.2} mm along each axis"),
        CauseKind::MovingJoint => "the joint centre moves with the arm".to_owned(),
        CauseKind::ConstantEncoder => format!("the encoder of cable {cable} stands still"),
        CauseKind::ExchangedCables => {
            format!("cables {cable} and {} are exchanged", cause.other_cable.unwrap_or_default())
        }
    }
}
