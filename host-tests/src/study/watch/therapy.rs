//! An arm that exercises in the machine after its centre was accepted, and what can slip meanwhile.

use crate::study::findings::Problem;
use crate::study::scene::{Reach, Scene, normal, symmetric, with_noise};
use crate::study::solve::{Answer, Knowledge, solve_with_zeros};
use crate::wearer::{Encoder, rotation};
use glenoid::identification::Machine;
use glenoid::identification::joint::Joint;
use glenoid::identification::machine::MachineDeviation;
use glenoid::kinematics::CableLengths;
use glenoid::monitor::SlipDetector;
use glenoid::rig::{CABLES, Parameters, RigError};
use nalgebra::{Rotation3, Vector3};
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// Noise of every length, uniform within this to either side, mm; the encoder's quantisation comes on top.
const NOISE_MM: f64 = 0.1;
/// Poses of the calibration, as many as the device collects by itself: with known zeros, and with unknown ones.
const POSES: [usize; 2] = [12, 30];
/// Unknown zeros, when they are, and the prior that the estimator is given, mm.
const ZEROS_MM: f64 = 10.0;

/// What slips, and by how much.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mishap {
    /// Nothing.
    None,
    /// The centre in {B}: by this vector, mm.
    Strap(Vector3<f64>),
    /// The platform on the arm: by this vector, axes of {B} at home, mm.
    Cuff(Vector3<f64>),
    /// A cable, from 0: reads too much by this, mm.
    Cable(usize, f64),
    /// The centre moves with the elevation: by this vector for 10 degrees, mm.
    Drift(Vector3<f64>),
}

/// How the arm moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion {
    /// Three angles, each the sum of two slow oscillations: [amplitude (rad), angular speed (rad/s), phase].
    Free([[[f64; 3]; 2]; 3]),
    /// One turn about one axis from a pose, minimum jerk: axis, angle (rad), seconds.
    Sweep(Rotation3<f64>, Vector3<f64>, f64, f64),
}

impl Motion {
    /// A free motion of the usual reach: some 20 degrees a second.
    pub fn free(random: &mut impl Rng) -> Self {
        let mut oscillation = |amplitude| [amplitude, random.random_range(0.5..1.5), random.random_range(0.0..TAU)];
        Self::Free([
            [oscillation(0.35), oscillation(0.2)],
            [oscillation(0.35), oscillation(0.2)],
            [oscillation(0.3), oscillation(0.15)],
        ])
    }

    /// The least motion: from a random pose by `angle_rad` about a random axis in `seconds`.
    pub fn sweep(random: &mut impl Rng, angle_rad: f64, seconds: f64) -> Self {
        // The reach less the sweep, so that the whole of it is within the machine's.
        let from = Reach { tilt_deg: 25.0, torsion_deg: 15.0 }.rotation(random);
        Self::Sweep(from, Vector3::from_fn(|_, _| normal(random)), angle_rad, seconds)
    }

    /// The arm's rotation from home after `seconds`.
    pub fn at(&self, seconds: f64) -> Rotation3<f64> {
        match self {
            Self::Free(angles) => {
                let [x, y, z] = angles.map(|two| {
                    two.iter().map(|[amplitude, speed, phase]| amplitude * libm::sin(phase + speed * seconds)).sum()
                });
                Rotation3::new(Vector3::new(x, y, 0.0)) * Rotation3::new(Vector3::new(0.0, 0.0, z))
            }
            Self::Sweep(from, axis, angle, duration) => {
                let t = (seconds / duration).clamp(0.0, 1.0);
                rotation(*axis, angle * t * t * t * (10.0 + t * (6.0 * t - 15.0))) * from
            }
        }
    }

    /// Largest turn away from the pose at `from` within the next `seconds`, rad.
    pub fn span_rad(&self, from: f64, seconds: f64) -> f64 {
        let start = self.at(from);
        (0..=100).fold(0.0, |most: f64, k| most.max(self.at(from + seconds * f64::from(k) / 100.0).angle_to(&start)))
    }
}

/// A machine on a wearer, calibrated, in use.
pub struct Therapy {
    scene: Scene,
    encoder: Encoder,
    random: ChaCha8Rng,
}

impl Therapy {
    /// A wearer with a random centre; the encoders' zeros are off unless they are known. The watch is over the centre
    /// that the device's own solver (f32) finds. `Ok(None)` when it refuses them.
    pub fn begin(mut random: ChaCha8Rng, zeros_known: bool) -> Result<Option<(Self, SlipDetector<f32>)>, Problem> {
        let scene = Scene::table_1(150.0)?.worn(&mut random, 20.0, 10.0);
        let prior_mm = if zeros_known { 0.0 } else { ZEROS_MM };
        let zeros_mm: [f64; CABLES] = std::array::from_fn(|_| symmetric(&mut random, prior_mm));
        // A drum that begins with a cable longer by an error reads too little by it.
        let encoder = Encoder::new(scene.rig().drum(), zeros_mm.map(|zero| -zero));
        let mut therapy = Self { scene, encoder, random };
        let reach = Reach { torsion_deg: 40.0, ..Reach::USUAL };
        let poses: Vec<_> = (0..POSES[usize::from(!zeros_known)])
            .map(|_| {
                let turned = reach.rotation(&mut therapy.random);
                therapy.measured(therapy.scene.lengths(&turned))
            })
            .collect();
        let Ok(answer) = solve_with_zeros::<f32>(&therapy.scene, &poses, Knowledge::Noise, prior_mm) else {
            return Ok(None);
        };
        let watch = therapy.watch(&answer)?;
        Ok(Some((therapy, watch)))
    }

    fn watch(&self, answer: &Answer) -> Result<SlipDetector<f32>, RigError> {
        let rig = self.scene.rig_single();
        let parameters = Parameters::from_array(answer.parameters_mm.map(|x| x as f32));
        let zeros_mm = answer.zeros_mm.map(|x| x as f32);
        let as_drawn = MachineDeviation::none();
        let noise_mm = rig.length_noise_mm();
        Ok(SlipDetector::new(&Machine::new(rig), &as_drawn, &parameters, &zeros_mm, noise_mm, Joint::Ball))
    }

    /// What the device makes of six true lengths: noise, then whole counts, mm.
    fn measured(&mut self, lengths_mm: [f64; CABLES]) -> [f64; CABLES] {
        let counts = self.encoder.counts(with_noise(lengths_mm, &mut self.random, NOISE_MM));
        let home = self.scene.rig().drum().home_length_mm;
        std::array::from_fn(|k| home[k] + f64::from(counts[k]) * self.encoder.mm_per_count())
    }

    /// What the device sees of a pose with a mishap. `None` when it is no six lengths.
    pub fn lengths(&mut self, turned: &Rotation3<f64>, mishap: Mishap) -> Option<CableLengths<f32>> {
        let mut scene = self.scene;
        match mishap {
            Mishap::Strap(moved) => scene.centre_mm += moved,
            Mishap::Cuff(moved) => scene.end_points_mm = scene.end_points_mm.map(|end| end + moved),
            Mishap::Drift(per_ten) => {
                let elevation = Vector3::z().angle(&(turned * Vector3::z()));
                scene.centre_mm += per_ten * (elevation.to_degrees() / 10.0);
            }
            Mishap::None | Mishap::Cable(..) => {}
        }
        let mut lengths = scene.lengths(turned);
        if let Mishap::Cable(cable, error_mm) = mishap {
            lengths[cable] += error_mm;
        }
        CableLengths::new(self.measured(lengths).map(|x| x as f32)).ok()
    }

    /// The random numbers of this wearer.
    pub fn random(&mut self) -> &mut ChaCha8Rng {
        &mut self.random
    }
}
