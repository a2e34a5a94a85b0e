//! Which further poses of a module narrow the hand's covariance most, from what each would add to what is known: nothing is
//! fitted anew.

use super::range::{BallRange, hinge_grid};
use glenoid::identification::Pose;
use glenoid::identification::arm::{Arm, ArmPose, Ball, FurtherPoses, Module};
use glenoid::identification::hinge::{HingePose, IdentifiedHinge, MAX_CABLES};
use glenoid::kinematics::CableLengths;
use glenoid::kinematics::rotation::nearest_attitude;
use glenoid::rig::CABLES;
use nalgebra::{Matrix3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Poses that are proposed for a module.
pub const PROPOSED: usize = 5;

/// The arm in a posture, and the hand in it.
#[derive(Clone, Copy)]
pub struct Proposer<'a> {
    /// The arm.
    pub arm: &'a Arm<'a, f64>,
    /// The posture.
    pub posture: &'a ArmPose<f64>,
    /// The hand in the wrist's platform, mm.
    pub hand_mm: Vector3<f64>,
    /// Of the grid of poses.
    pub seed: u64,
}

/// A pose that is proposed.
#[derive(Clone, Copy, Debug)]
pub struct Proposed<P> {
    /// The pose.
    pub pose: P,
    /// The hand's σ with it and those before it in the list, root of the summed variances, mm.
    pub hand_sigma_mm: f64,
}

impl Proposer<'_> {
    /// For a ball, from the poses of its log; `home_mm`: its rig's home lengths, `samples`: those that a length is the mean of.
    /// Lengths are as its encoders would read them.
    pub fn of_ball(
        &self,
        module: Module,
        log: &[Pose<f64>],
        home_mm: &[f64; CABLES],
        samples: u16,
    ) -> Vec<Proposed<Pose<f64>>> {
        let ball = if module == Module::Shoulder { &self.arm.shoulder } else { &self.arm.wrist };
        let rotations: Vec<_> = log.iter().filter(|pose| pose.is_used()).map(Pose::rotation).collect();
        let grid = BallRange::of(&rotations).grid(&mut self.random(module));
        let candidates: Vec<_> = grid
            .iter()
            .filter_map(|rotation| {
                let lengths = CableLengths::new(readings_mm(ball, home_mm, rotation)).ok()?;
                let mut pose = Pose::new(lengths).averaged_over(samples);
                pose.set_attitude(nearest_attitude(rotation));
                Some(pose)
            })
            .collect();
        greedy(&candidates, |poses| {
            let none = FurtherPoses::default();
            self.sigma_mm(&match module {
                Module::Shoulder => FurtherPoses { shoulder: poses, ..none },
                _ => FurtherPoses { wrist: poses, ..none },
            })
        })
    }

    /// For the elbow: angles from the hinge's own zero, rad.
    pub fn of_elbow(&self, log: &[HingePose<f64>]) -> Vec<Proposed<f64>> {
        let angles: Vec<_> = log.iter().filter(|pose| pose.is_used()).map(|pose| pose.angle_rad).collect();
        let candidates = hinge_grid(&angles, &mut self.random(Module::Elbow));
        greedy(&candidates, |elbow_rad| self.sigma_mm(&FurtherPoses { elbow_rad, ..FurtherPoses::default() }))
    }

    /// The hand's σ with further poses, root of the summed variances, mm.
    pub fn sigma_mm(&self, further: &FurtherPoses<'_, f64>) -> Option<f64> {
        let hand = self.arm.hand_with(self.posture, &self.hand_mm, further).ok()?;
        Some(hand.covariance_mm2.trace().sqrt())
    }

    /// The grid of one module is not the other's.
    fn random(&self, module: Module) -> ChaCha8Rng {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        random.set_stream(module as u64);
        random
    }
}

/// One after the other, the candidate that leaves the least; none twice, for a pose that stands in a log twice counts once.
fn greedy<P: Copy>(candidates: &[P], sigma_mm: impl Fn(&[P]) -> Option<f64>) -> Vec<Proposed<P>> {
    let mut left = candidates.to_vec();
    let mut chosen: Vec<P> = Vec::new();
    let mut proposed: Vec<Proposed<P>> = Vec::new();
    while proposed.len() < PROPOSED {
        let with = |candidate: &P| sigma_mm(&[&chosen[..], &[*candidate]].concat());
        let sigmas = left.iter().enumerate().filter_map(|(index, candidate)| Some((index, with(candidate)?)));
        let Some((index, hand_sigma_mm)) = sigmas.min_by(|one, other| one.1.total_cmp(&other.1)) else { break };
        let pose = left.swap_remove(index);
        chosen.push(pose);
        proposed.push(Proposed { pose, hand_sigma_mm });
    }
    proposed
}

/// What a ball's encoders would read at a rotation ({P} to {B}), by the machine as it is estimated, mm.
fn readings_mm(ball: &Ball<'_, f64>, home_mm: &[f64; CABLES], rotation: &Matrix3<f64>) -> [f64; CABLES] {
    let (estimate, centre) = (ball.estimator.machine_estimate(), ball.estimator.centre());
    let (geometry, offsets, scales) = (estimate.geometry(), estimate.offsets_mm(), estimate.scales());
    std::array::from_fn(|k| {
        let end = centre.in_base_mm + rotation * (geometry.end_mm[k] - centre.in_platform_mm);
        let length = geometry.span(k, &end).length_mm;
        home_mm[k] + (1.0 + scales[k]) * (length - home_mm[k]) + offsets[k]
    })
}

/// What an elbow's encoders would read at an angle from the hinge's own zero, by the machine as it is estimated, mm.
pub fn elbow_readings_mm(found: &IdentifiedHinge<f64>, angle_rad: f64) -> [f64; MAX_CABLES] {
    let (hinge, machine) = (&found.hinge, &found.machine);
    let rotation = hinge.rotation(angle_rad);
    std::array::from_fn(|k| {
        let end = hinge.platform_foot_mm() + rotation * (machine.end_mm()[k] - hinge.foot_in_platform_mm());
        machine.reading(k, machine.span(k, &end).length_mm).0
    })
}
