//! A joint in use as its record holds it, and back.

use super::status;
use crate::identification::hinge::HINGE_UNKNOWNS;
use crate::identification::outcome::MAX_REJECTED;
use crate::identification::{Identified, Rejected, Termination};
use crate::linear_algebra::packed_index;
use crate::procedure::elbow::{ElbowCandidate, FoundHinge};
use crate::procedure::module::FoundJoint;
use crate::procedure::{Candidate, Verification};
use crate::record::{HINGE_PACKED, HingeRecord, JointRecord, Record};
use heapless::Vec;
use nalgebra::SMatrix;

/// What is kept of a joint.
pub(super) fn record(live: &FoundJoint<'_>, serial: u32, rig: u32) -> JointRecord {
    match live {
        FoundJoint::Ball(live) => JointRecord::Ball(record_of_ball(live, serial, rig)),
        FoundJoint::Hinge(live) => JointRecord::Hinge(record_of_hinge(live, serial, rig)),
    }
}

pub(super) fn record_of_ball(live: &Candidate, serial: u32, rig: u32) -> Record {
    let Candidate { run_id, boot, wearer, identified, motion, verification } = live;
    let mut rejected = [Rejected { pose: 0, cables: 0 }; MAX_REJECTED];
    for (place, entry) in rejected.iter_mut().zip(&identified.rejected) {
        *place = *entry;
    }
    Record {
        run_id: *run_id,
        boot: *boot,
        wearer: *wearer,
        serial,
        rig,
        firmware: status::FIRMWARE,
        parameters: identified.parameters,
        covariance_mm2: identified.covariance_mm2,
        zeros_mm: identified.offsets_mm,
        zero_sigmas_mm: identified.offset_sigmas_mm,
        noise_mm: identified.noise_mm,
        deviation_mm: identified.rms_residual_mm,
        excitation_rad: identified.excitation_rad,
        poses: u16::try_from(identified.poses).unwrap_or(u16::MAX),
        // never more than MAX_REJECTED
        left_out: identified.rejected.len() as u8,
        rejected,
        iterations: identified.iterations,
        termination: identified.termination as u8,
        verification_poses: verification.poses,
        verification_deviation_mm: verification.deviation_mm,
        verification_limit_mm: verification.limit_mm,
        motion: *motion,
        machine: identified.machine,
    }
}

/// The centre that a record holds. Of its history, the deviation before each step is not kept.
pub(super) fn candidate(record: &Record) -> Candidate {
    let left_out = record.rejected.get(..usize::from(record.left_out)).unwrap_or_default();
    Candidate {
        run_id: record.run_id,
        boot: record.boot,
        wearer: record.wearer,
        identified: Identified {
            parameters: record.parameters,
            covariance_mm2: record.covariance_mm2,
            noise_mm: record.noise_mm,
            rms_residual_mm: record.deviation_mm,
            rms_residuals_mm: Vec::new(),
            iterations: record.iterations,
            termination: if record.termination == Termination::DeviationBelowTolerance as u8 {
                Termination::DeviationBelowTolerance
            } else {
                Termination::Settled
            },
            poses: record.poses.into(),
            rejected: Vec::from_slice(left_out).unwrap_or_default(),
            excitation_rad: record.excitation_rad,
            offsets_mm: record.zeros_mm,
            offset_sigmas_mm: record.zero_sigmas_mm,
            machine: record.machine,
        },
        motion: record.motion,
        verification: Verification {
            deviation_mm: record.verification_deviation_mm,
            limit_mm: record.verification_limit_mm,
            poses: record.verification_poses,
        },
    }
}

fn record_of_hinge(live: &ElbowCandidate, serial: u32, rig: u32) -> HingeRecord {
    let ElbowCandidate { run_id, boot, wearer, found, verification } = live;
    let mut covariance = [0.0; HINGE_PACKED];
    for i in 0..HINGE_UNKNOWNS {
        for j in 0..=i {
            if let (Some(place), Some(entry)) = (covariance.get_mut(packed_index(i, j)), found.covariance.get((i, j))) {
                *place = *entry;
            }
        }
    }
    HingeRecord {
        run_id: *run_id,
        boot: *boot,
        wearer: *wearer,
        serial,
        rig,
        firmware: status::FIRMWARE,
        hinge: found.hinge,
        covariance,
        constants: found.constants,
        noise_mm: found.noise_mm,
        rms_residual_mm: found.rms_residual_mm,
        flexion_rad: found.flexion_rad,
        poses: found.poses,
        left_out: found.rejected,
        verification_poses: verification.poses,
        verification_deviation_mm: verification.deviation_mm,
        verification_limit_mm: verification.limit_mm,
    }
}

/// The hinge that a record holds.
pub(super) fn hinge_candidate(record: &HingeRecord) -> ElbowCandidate {
    let entry =
        |i: usize, j: usize| record.covariance.get(packed_index(i.max(j), i.min(j))).copied().unwrap_or_default();
    ElbowCandidate {
        run_id: record.run_id,
        boot: record.boot,
        wearer: record.wearer,
        found: FoundHinge {
            hinge: record.hinge,
            covariance: SMatrix::from_fn(entry),
            constants: record.constants,
            noise_mm: record.noise_mm,
            rms_residual_mm: record.rms_residual_mm,
            flexion_rad: record.flexion_rad,
            poses: record.poses,
            rejected: record.left_out,
        },
        verification: Verification {
            deviation_mm: record.verification_deviation_mm,
            limit_mm: record.verification_limit_mm,
            poses: record.verification_poses,
        },
    }
}
