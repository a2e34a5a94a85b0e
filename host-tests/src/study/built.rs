//! A machine as it is built: what is stated of it, what is true, and what six lengths are then.

use super::scene::{Reach, normal, symmetric, symmetric_vector};
use super::statistics::root_mean_square;
use crate::estimation::estimate_poses;
use crate::identify::rig_file::RigFile;
use glenoid::identification::{EstimatorSettings, Noise, Pose};
use glenoid::kinematics::{CableLengths, LengthError};
use glenoid::rig::{ATTACHMENTS, CABLES, POINTS, Rig, RigError, Tolerance};
use nalgebra::{Matrix3, Rotation3, Vector3};
use rand::Rng;

/// Noise of every length, uniform within this to either side, mm, and its standard deviation.
pub const NOISE_MM: f64 = 0.1;
/// See [`NOISE_MM`].
pub const NOISE_SIGMA_MM: f64 = 0.057_735_026_918_962_58;

/// A machine that is not as stated.
pub struct BuiltMachine {
    /// As stated.
    pub stated: Rig<f64>,
    base_mm: [Vector3<f64>; POINTS],
    edges_mm: [f64; POINTS],
    offset_mm: [f64; CABLES],
    scale: [f64; CABLES],
}

/// An arm in it: the joint centre in the true frame, and where the platform's points are about it at home.
pub struct Worn {
    centre_mm: Vector3<f64>,
    end_points_mm: [Vector3<f64>; POINTS],
}

impl Worn {
    /// The joint centre at home in the machine's own frame, mm.
    pub fn centre_mm(&self) -> &Vector3<f64> {
        &self.centre_mm
    }

    /// The end-points at a rotation from home about a centre, in the machine's own frame, mm.
    pub fn end_points_mm(&self, centre_mm: &Vector3<f64>, rotation: &Rotation3<f64>) -> [Vector3<f64>; POINTS] {
        self.end_points_mm.map(|point| centre_mm + rotation * point)
    }
}

impl BuiltMachine {
    /// A machine that is off by normal errors of `truth`'s sizes, stated with `tolerance`. Where `offset_mm` of both is 10,
    /// offsets are uniform within it.
    ///
    /// # Errors
    /// When the constants give no rig.
    pub fn random(random: &mut impl Rng, truth: &Tolerance<f64>, tolerance: Tolerance<f64>) -> Result<Self, RigError> {
        Self::of(random, Rig::shoulder(150.0)?, truth, tolerance)
    }

    /// The same of any 3-3 rig.
    ///
    /// # Errors
    /// When the constants give no rig.
    pub fn of(
        random: &mut impl Rng,
        rig: Rig<f64>,
        truth: &Tolerance<f64>,
        tolerance: Tolerance<f64>,
    ) -> Result<Self, RigError> {
        let stated = rig.with_tolerance(tolerance)?;
        let mut error = |sigma: f64| normal(random) * sigma;
        let base_mm = stated.base_mm().map(|point| point + Vector3::from_fn(|_, _| error(truth.base_mm)));
        let edges_mm = stated.edges_mm().map(|edge| edge + error(truth.edges_mm));
        let scale = std::array::from_fn(|_| 1.0 + error(truth.drum));
        let offset_mm = std::array::from_fn(|_| {
            if truth.offset_mm >= 10.0 { symmetric(random, truth.offset_mm) } else { normal(random) * truth.offset_mm }
        });
        Ok(Self { stated, base_mm, edges_mm, offset_mm, scale })
    }

    /// An arm in it, its centre up to `centre_mm` and its cuff up to 10 mm off along each axis.
    pub fn worn(&self, random: &mut impl Rng, centre_mm: f64) -> Worn {
        self.worn_within(random, centre_mm, 10.0)
    }

    /// The same with the cuff up to `cuff_mm` off.
    pub fn worn_within(&self, random: &mut impl Rng, centre_mm: f64, cuff_mm: f64) -> Worn {
        let centre = self.stated.nominal().centre_mm + symmetric_vector(random, centre_mm);
        let cuff = symmetric_vector(random, cuff_mm);
        // The platform as built, best fitted to where it stands at home by the drawing.
        let drawn = drawn_end_points_mm(&self.stated);
        let shape = self.platform_mm();
        let (turn, shift) = best_fit(&shape, &drawn);
        Worn { centre_mm: centre, end_points_mm: shape.map(|point| turn * point + shift + cuff) }
    }

    /// The platform's points as built, in {P}, mm.
    fn platform_mm(&self) -> [Vector3<f64>; POINTS] {
        let (stated, edges_mm) = (&self.stated, self.edges_mm);
        let built = Rig::new(*stated.base_mm(), edges_mm, *stated.drum(), NOISE_SIGMA_MM, *stated.nominal());
        built.as_ref().unwrap_or(stated).platform_mm()
    }

    /// Where a point fixed in {P} stands in {B} at a rotation from home, mm.
    pub fn carried_mm(&self, worn: &Worn, rotation: &Rotation3<f64>, point_mm: &Vector3<f64>) -> Vector3<f64> {
        let (home, shift) = best_fit(&self.platform_mm(), &worn.end_points_mm);
        let (turn, to) = best_fit(&self.base_mm, self.stated.base_mm());
        turn * (worn.centre_mm + rotation * (home * point_mm + shift)) + to
    }

    /// Where the joint centre is in {P}, mm.
    pub fn centre_in_platform_mm(&self, worn: &Worn) -> Vector3<f64> {
        let (home, shift) = best_fit(&self.platform_mm(), &worn.end_points_mm);
        -(home.transpose() * shift)
    }

    /// Where the joint centre is in {B}: the frame best fitted to the attachment points.
    pub fn centre_in_base_mm(&self, worn: &Worn) -> Vector3<f64> {
        self.in_base_mm(&worn.centre_mm)
    }

    /// Where a point stands in {B}, of which the machine's own frame is off: mm.
    pub fn in_base_mm(&self, point_mm: &Vector3<f64>) -> Vector3<f64> {
        let (turn, shift) = best_fit(&self.base_mm, self.stated.base_mm());
        turn * point_mm + shift
    }

    /// The six readings of random poses, mm.
    pub fn readings(&self, random: &mut impl Rng, worn: &Worn, poses: usize, reach: Reach) -> Vec<[f64; CABLES]> {
        let mut one = || {
            let rotation = reach.rotation(random);
            self.reading(random, worn, &rotation)
        };
        (0..poses).map(|_| one()).collect()
    }

    /// The six readings at a rotation from home, mm.
    pub fn reading(&self, random: &mut impl Rng, worn: &Worn, rotation: &Rotation3<f64>) -> [f64; CABLES] {
        self.exact_reading(worn, rotation).map(|length| length + symmetric(random, NOISE_MM))
    }

    /// The six readings of a pose that is held for so many samples, each with noise of its own beside `friction_mm`, 1σ, that is
    /// the same in all of them: their mean, mm.
    pub fn held_reading(
        &self,
        random: &mut impl Rng,
        worn: &Worn,
        rotation: &Rotation3<f64>,
        samples: u16,
        friction_mm: f64,
    ) -> [f64; CABLES] {
        self.exact_reading(worn, rotation).map(|length| {
            let mean = (0..samples).map(|_| symmetric(random, NOISE_MM)).sum::<f64>() / f64::from(samples);
            length + friction_mm * normal(random) + mean
        })
    }

    /// The six readings without noise, mm.
    fn exact_reading(&self, worn: &Worn, rotation: &Rotation3<f64>) -> [f64; CABLES] {
        self.without_noise(&worn.end_points_mm(&worn.centre_mm, rotation))
    }

    /// The six readings of these end-points, mm.
    pub fn without_noise(&self, ends_mm: &[Vector3<f64>; POINTS]) -> [f64; CABLES] {
        let home = &self.stated.drum().home_length_mm;
        std::array::from_fn(|cable| {
            let end = ends_mm[cable / 2];
            let length = (end - self.base_mm[ATTACHMENTS[cable / 2][cable % 2]]).norm();
            home[cable] + self.scale[cable] * (length - home[cable]) + self.offset_mm[cable]
        })
    }
}

/// The end-points about the joint centre at home, by the drawing, axes of {B}, mm.
fn drawn_end_points_mm(rig: &Rig<f64>) -> [Vector3<f64>; POINTS] {
    let arm = crate::wearer::FittedArm::new(rig, Vector3::zeros(), Vector3::zeros());
    *arm.end_points_mm()
}

/// The rigid motion that brings `from` nearest to `to` (Kabsch 1976). Of two points, the smallest rotation.
pub fn best_fit(from: &[Vector3<f64>], to: &[Vector3<f64>]) -> (Matrix3<f64>, Vector3<f64>) {
    let middle = |points: &[Vector3<f64>]| points.iter().sum::<Vector3<f64>>() / points.len() as f64;
    let (a, b) = (middle(from), middle(to));
    if let ([p, q], [r, s]) = (from, to) {
        let turn = Rotation3::rotation_between(&(q - p), &(s - r)).unwrap_or_else(Rotation3::identity).into_inner();
        return (turn, b - turn * a);
    }
    let covariance: Matrix3<f64> = from.iter().zip(to).map(|(p, q)| (p - a) * (q - b).transpose()).sum();
    let svd = covariance.svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { return (Matrix3::identity(), b - a) };
    let sign = (v_t.transpose() * u.transpose()).determinant().signum();
    let turn = v_t.transpose() * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, sign)) * u.transpose();
    (turn, b - turn * a)
}

/// An accepted centre: found minus true, and 1σ, mm.
#[derive(Clone, Copy, Debug)]
pub struct Accepted {
    /// Found minus true, mm.
    pub error_mm: [f64; 3],
    /// 1σ, mm.
    pub sigma_mm: [f64; 3],
}

/// Identifies the centre from readings with a rig as it is known.
pub fn identify(rig: &RigFile, readings: &[[f64; CABLES]], truth_mm: &Vector3<f64>) -> Option<Accepted> {
    let machine = rig.machine(&rig.rig);
    let pose = |reading: &[f64; CABLES]| {
        let pose = Pose::new(CableLengths::new(*reading)?.corrected(&rig.rig)?);
        Ok(pose.averaged_over(rig.samples_a_row.unwrap_or(1)))
    };
    let poses = readings.iter().map(pose).collect::<Result<Vec<_>, LengthError>>().ok()?;
    let noise_mm = rig.samples_a_row.map_or(NOISE_SIGMA_MM, |_| rig.rig.length_noise_mm());
    let settings = EstimatorSettings { noise: Noise::Known(noise_mm), ..EstimatorSettings::for_rig(&rig.rig) };
    let found = estimate_poses(&machine, &rig.rig, settings, None, poses).outcome.ok()?;
    let [x, y, z, ..] = found.sigma_mm();
    Some(Accepted { error_mm: (found.parameters.centre_mm - truth_mm).into(), sigma_mm: [x, y, z] })
}

/// The figures of a cell: share accepted, rms error (mm), real over reported σ, accepted beyond 5 σ + 0.05 mm.
pub struct Figures {
    /// Of all trials.
    pub accepted: f64,
    /// Of the centre, mm.
    pub rms_mm: f64,
    /// Real over reported.
    pub ratio: f64,
    /// How many.
    pub wrong: usize,
}

impl Figures {
    /// Of trials; `None` is a refusal.
    pub fn of(trials: &[Option<Accepted>]) -> Self {
        let accepted: Vec<_> = trials.iter().flatten().collect();
        let norm = |vector: &[f64; 3]| vector.iter().map(|x| x * x).sum::<f64>().sqrt();
        let is_wrong = |a: &&&Accepted| norm(&a.error_mm) > 5.0 * norm(&a.sigma_mm) + 0.05;
        Self {
            accepted: accepted.len() as f64 / trials.len() as f64,
            rms_mm: root_mean_square(accepted.iter().map(|a| norm(&a.error_mm))),
            ratio: root_mean_square(accepted.iter().flat_map(|a| (0..3).map(|k| a.error_mm[k] / a.sigma_mm[k]))),
            wrong: accepted.iter().filter(is_wrong).count(),
        }
    }
}
