//! The error bar that the poses captured so far promise, before anything is solved.
//!
//! How much a pose tells about the centre hangs on its rotation and hardly on where exactly the centre is, so each
//! pose's information is taken at the rig's nominal centre when it is captured, and summed. The inverse of the sum
//! is the covariance to come. Work a pose: one information matrix, one 6x6 factorisation.

use crate::identification::normal_equations::{Factors, NormalEquations, PACKED, at};
use crate::identification::pose_information::PoseInformation;
use crate::identification::uncertainty::worst_centre_direction;
use crate::kinematics::pivot::{LengthEquations, Pivot, RigPoints};
use crate::kinematics::{CableLengths, PlatformPose};
use crate::rig::Rig;
use nalgebra::Matrix3;

/// Sum of the information of the captured poses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Forecast {
    points: RigPoints<f32>,
    pivot: Pivot<f32>,
    noise_mm: f32,
    matrix: [f32; PACKED],
    sigma_mm: Option<f32>,
}

impl Forecast {
    /// Nothing captured yet.
    pub fn new(rig: &Rig<f32>) -> Self {
        let points = RigPoints::new(rig);
        Self {
            pivot: Pivot::from_parameters(rig.nominal(), &points),
            points,
            noise_mm: rig.length_noise_mm(),
            matrix: *NormalEquations::new().matrix(),
            sigma_mm: None,
        }
    }

    /// Adds a captured pose.
    pub fn add(&mut self, lengths: &CableLengths<f32>, platform: &PlatformPose<f32>) {
        let rotation = &platform.rotation;
        let equations = LengthEquations::new(&self.points, &self.pivot, rotation, lengths);
        let Some(pose) = PoseInformation::of(&equations) else { return };
        self.add_information(rotation, &pose.information);
        self.sigma_mm = Factors::of(&self.matrix).ok().map(|factors| {
            let (sigma, _) = worst_centre_direction(&factors.inverse());
            sigma * self.noise_mm
        });
    }

    /// 1σ of the centre in its worst direction in {B}, mm, at the rig's noise; None while the poses do not determine
    /// the centre.
    pub const fn sigma_mm(&self) -> Option<f32> {
        self.sigma_mm
    }

    /// The pose sees δO - R δC: [I, -R]ᵀ S [I, -R] is added.
    fn add_information(&mut self, rotation: &Matrix3<f32>, information: &Matrix3<f32>) {
        let mixed = rotation.transpose() * information;
        let own = mixed * rotation;
        for i in 0..3 {
            for j in 0..3 {
                if j <= i {
                    self.matrix[at(i, j)] += information[(i, j)];
                    self.matrix[at(3 + i, 3 + j)] += own[(i, j)];
                }
                self.matrix[at(3 + i, j)] -= mixed[(i, j)];
            }
        }
    }
}
