//! How well the first set fits what was found, and which of its poses were left out.

use crate::can::result::Quality;
use crate::procedure::module::JointValue;
use crate::procedure::{ModuleProcedure, PoseSet};

/// How well the first set fits.
pub(super) fn quality(run_id: u16, value: &JointValue<'_>) -> Quality {
    match value {
        JointValue::Ball(identified, _) => Quality {
            run_id,
            deviation_mm: identified.rms_residual_mm,
            noise_mm: identified.noise_mm,
            iterations: identified.iterations,
            left_out: identified.rejected.len() as u8,
        },
        JointValue::Hinge(found) => Quality {
            run_id,
            deviation_mm: found.rms_residual_mm,
            noise_mm: found.noise_mm,
            iterations: 0,
            left_out: found.rejected,
        },
    }
}

/// A pose that was left out, with its faulty cables, and how many there are.
pub(super) fn left_out(procedure: &ModuleProcedure, value: &JointValue<'_>, index: u8) -> Option<(u8, u8, u8)> {
    match value {
        JointValue::Ball(identified, _) => {
            let rejected = identified.rejected.get(usize::from(index))?;
            Some((u8::try_from(rejected.pose).ok()?, rejected.cables, identified.rejected.len() as u8))
        }
        JointValue::Hinge(found) => {
            let poses = procedure.hinge()?.poses(PoseSet::Identification).iter().enumerate();
            let (pose, of) = poses.filter(|(_, pose)| !pose.is_used()).nth(index.into())?;
            Some((u8::try_from(pose).ok()?, of.suspect_cables, found.rejected))
        }
    }
}
