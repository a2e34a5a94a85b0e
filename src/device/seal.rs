//! Checksums of the centre in use and of what the procedure goes by, formed with every heartbeat: a word at a time, since a
//! CRC over a record would take as long as everything else in such a tick.

use super::fingerprint::{for_each_number, for_each_number_of_elbow};
use crate::procedure::elbow::{ElbowCandidate, ElbowRig, FoundHinge};
use crate::procedure::module::FoundJoint;
use crate::procedure::{Candidate, Limits, ModuleProcedure, ModuleRig, Verification};
use crate::rig::Rig;

/// FNV-1a (32 bits) over whole words. Each step is a bijection of the sum, so a change of any one word changes it for certain.
#[derive(Debug, Clone, Copy)]
struct Sum(u32);

/// The checksum of what a procedure goes by.
pub(super) fn seal_of(procedure: &ModuleProcedure) -> u32 {
    match procedure {
        ModuleProcedure::Ball(procedure) => seal_of_constants(procedure.rig(), procedure.limits()),
        ModuleProcedure::Hinge(procedure) => seal_of_elbow(procedure.rig(), procedure.limits()),
    }
}

/// The same of what a procedure is made of.
pub(super) fn seal_of_rig(rig: &ModuleRig, limits: &Limits) -> u32 {
    match rig {
        ModuleRig::Ball(rig) => seal_of_constants(rig, limits),
        ModuleRig::Hinge(rig) => seal_of_elbow(rig, limits),
    }
}

/// The checksum of an elbow's rig and its limits.
fn seal_of_elbow(rig: &ElbowRig, limits: &Limits) -> u32 {
    let mut sum = Sum(0x811C_9DC5);
    for_each_number_of_elbow(rig, &mut |numbers| sum.add_numbers(numbers));
    sum.add_numbers(&[rig.hinge().length_noise_mm()]);
    limits.words().into_iter().for_each(|word| sum.add(word));
    sum.0
}

/// The checksum of a rig and its limits.
fn seal_of_constants(rig: &Rig<f32>, limits: &Limits) -> u32 {
    let mut sum = Sum(0x811C_9DC5);
    for_each_number(rig, &mut |numbers| sum.add_numbers(numbers));
    sum.add_numbers(&[rig.length_noise_mm(), rig.sample_noise_mm()]);
    sum.add_numbers(&rig.nominal().to_array());
    limits.words().into_iter().for_each(|word| sum.add(word));
    sum.0
}

/// The checksum of a joint that was found, and of what its record says of the board.
pub(super) fn seal(live: &FoundJoint<'_>, serial: u32, rig: u32) -> u32 {
    match live {
        FoundJoint::Ball(live) => seal_of_ball(live, serial, rig),
        FoundJoint::Hinge(live) => seal_of_hinge(live, serial, rig),
    }
}

fn seal_of_hinge(live: &ElbowCandidate, serial: u32, rig: u32) -> u32 {
    let ElbowCandidate { run_id, boot, wearer, found, verification } = live;
    let FoundHinge { hinge, covariance, constants, noise_mm, rms_residual_mm, flexion_rad, poses, rejected } = found;
    let mut sum = Sum(0x811C_9DC5);
    let head = [serial, rig, u32::from(*run_id), u32::from(*boot), u32::from(*wearer)];
    head.into_iter().for_each(|word| sum.add(word));
    sum.add_numbers(&hinge.to_array());
    sum.add_numbers(covariance.as_slice());
    sum.add_numbers(constants);
    sum.add_numbers(&[*noise_mm, *rms_residual_mm, *flexion_rad]);
    sum.add(u32::from(*poses) << 8 | u32::from(*rejected));
    sum.add_verification(verification);
    sum.0
}

#[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
fn seal_of_ball(live: &Candidate, serial: u32, rig: u32) -> u32 {
    let Candidate { run_id, boot, wearer, identified, motion, verification } = live;
    let mut sum = Sum(0x811C_9DC5);
    for word in [serial, rig, u32::from(*run_id), u32::from(*boot), u32::from(*wearer)] {
        sum.add(word);
    }
    sum.add_numbers(&identified.parameters.to_array());
    sum.add_numbers(&identified.covariance_mm2);
    sum.add_numbers(&identified.offsets_mm);
    sum.add_numbers(&identified.offset_sigmas_mm);
    sum.add_numbers(&[identified.noise_mm, identified.rms_residual_mm, identified.excitation_rad]);
    sum.add_numbers(&identified.machine.base_mm);
    sum.add_numbers(&identified.machine.ends_mm);
    sum.add_numbers(&identified.machine.scale);
    for word in [identified.poses, identified.iterations.into(), identified.termination as u32] {
        sum.add(word);
    }
    for rejected in &identified.rejected {
        sum.add(rejected.pose);
        sum.add(rejected.cables.into());
    }
    sum.add(u32::from(motion.is_some()));
    for number in motion.iter().flat_map(|motion| motion.parts().as_flattened()) {
        sum.add(u32::from(number.cast_unsigned()));
    }
    sum.add_verification(verification);
    sum.0
}

impl Sum {
    fn add(&mut self, word: u32) {
        self.0 = (self.0 ^ word).wrapping_mul(0x0100_0193);
    }

    fn add_verification(&mut self, verification: &Verification) {
        self.add_numbers(&[verification.deviation_mm, verification.limit_mm]);
        self.add(verification.poses.into());
    }

    fn add_numbers(&mut self, numbers: &[f32]) {
        numbers.iter().for_each(|number| self.add(number.to_bits()));
    }
}
