//! One elbow: what is drawn for it, what becomes of it, and what many of them say.

use super::bound;
use super::scene::{Elbow, NOISE_MM, across, drawn, flexions_rad};
use crate::study::scene::{normal, symmetric};
use crate::study::statistics::root_mean_square;
use glenoid::identification::hinge::{
    Drawing, HINGE_UNKNOWNS, HingeEstimator, HingePose, HingeRefusal, HingeSettings, MAX_CABLES,
};
use glenoid::rig::Tolerance;
use nalgebra::Rotation3;
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// The joint's range about the drawing's zero, rad.
pub const RANGE_RAD: (f64, f64) = (-2.45, 0.27);

/// What is wrong with a set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    None,
    /// Every sixth pose has 2 to 20 mm too much or too little on one cable.
    Outliers,
    /// The forearm turns about a second axis by normal angles of this size, degrees.
    SecondAxis(f64),
}

/// What is drawn.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    pub cables: usize,
    pub poses: usize,
    pub flexion_deg: f64,
    pub tolerance: Tolerance<f64>,
    /// 1σ of the drawing, which is then a prior.
    pub drawing: Option<[f64; HINGE_UNKNOWNS]>,
    pub fault: Fault,
}

/// What became of it.
#[derive(Debug, Clone, Copy)]
pub struct Outcome {
    /// Found minus true, 1σ, and the bound's 1σ (not a number where there is none), rad and mm.
    pub found: Result<[[f64; HINGE_UNKNOWNS]; 3], HingeRefusal>,
    /// Share of the bad poses that are left out with their cable named.
    pub named: f64,
    /// Size of the second axis found over the true one.
    pub size_ratio: f64,
}

/// Many of them.
#[derive(Debug)]
pub struct Cell {
    pub outcomes: Vec<Outcome>,
}

impl Case {
    pub fn trial(&self, mut random: ChaCha8Rng) -> Outcome {
        let random = &mut random;
        let elbow = match &self.drawing {
            None => Elbow::random(random, self.cables, &self.tolerance),
            Some(sigma) => {
                let step: [f64; HINGE_UNKNOWNS] = std::array::from_fn(|k| sigma[k] * normal(random));
                Elbow::of_hinge(random, self.cables, &drawn().moved(&step), &self.tolerance)
            }
        };
        let flexions = flexions_rad(random, self.poses, self.flexion_deg);
        let mut readings = elbow.readings_mm(random, &flexions);
        let mut bad = Vec::new();
        let mut size = f64::NAN;
        match self.fault {
            Fault::None => {}
            Fault::Outliers => {
                for pose in (0..self.poses).step_by(6) {
                    let cable = random.random_range(0..self.cables);
                    let sign = if random.random() { 1.0 } else { -1.0 };
                    readings[pose][cable] += sign * random.random_range(2.0..=20.0);
                    bad.push((pose, cable));
                }
            }
            Fault::SecondAxis(degrees) => {
                let [first, _] = across(elbow.axis_in_platform());
                let about = Rotation3::from_axis_angle(
                    &nalgebra::Unit::new_normalize(*elbow.axis_in_platform()),
                    random.random_range(0.0..std::f64::consts::PI),
                );
                let axis = about * first;
                let angles: Vec<f64> = flexions.iter().map(|_| normal(random) * degrees.to_radians()).collect();
                let mean = angles.iter().sum::<f64>() / angles.len() as f64;
                size = root_mean_square(angles.iter().map(|angle| angle - mean));
                for ((reading, flexion), angle) in readings.iter_mut().zip(&flexions).zip(&angles) {
                    *reading =
                        elbow.reading_mm(*flexion, Some((axis, *angle))).map(|l| l + symmetric(random, NOISE_MM));
                }
            }
        }
        self.identify(&elbow, &flexions, &readings, &bad, size)
    }

    fn identify(
        &self,
        elbow: &Elbow,
        flexions: &[f64],
        readings: &[[f64; MAX_CABLES]],
        bad: &[(usize, usize)],
        size: f64,
    ) -> Outcome {
        let none = Outcome {
            found: Err(HingeRefusal::NotAHinge { residual_mm: f32::NAN }),
            named: f64::NAN,
            size_ratio: f64::NAN,
        };
        let Ok(mut rig) = elbow.rig(self.tolerance) else { return none };
        if let Some(sigma) = self.drawing {
            rig = rig.with_drawing(Drawing { hinge: drawn(), sigma: Some(sigma), range_rad: RANGE_RAD });
        }
        let mut poses: Vec<_> = readings.iter().copied().map(HingePose::new).collect();
        match HingeEstimator::new(&rig, HingeSettings::for_rig(&rig)).run(&mut poses) {
            Ok(found) => {
                let truth = elbow.hinge();
                let bound = bound::bound(&truth, &elbow.stated, flexions, self.drawing.as_ref());
                let bounds = std::array::from_fn(|k| bound.map_or(f64::NAN, |bound| libm::sqrt(bound[(k, k)])));
                let is_named = |(pose, cable): &&(usize, usize)| {
                    !poses[*pose].is_used() && poses[*pose].suspect_cables & (1 << cable) != 0
                };
                let named = bad.iter().filter(is_named).count() as f64 / bad.len() as f64;
                Outcome { found: Ok([found.hinge.difference(&truth), found.sigmas(), bounds]), named, ..none }
            }
            Err(refusal) => {
                let size_ratio = match refusal {
                    HingeRefusal::SecondAxis { size_rad, .. } => f64::from(size_rad) / size,
                    _ => f64::NAN,
                };
                Outcome { found: Err(refusal), size_ratio, ..none }
            }
        }
    }
}

impl Cell {
    pub fn accepted(&self) -> impl Iterator<Item = &[[f64; HINGE_UNKNOWNS]; 3]> {
        self.outcomes.iter().filter_map(|outcome| outcome.found.as_ref().ok())
    }

    /// Refused by this name.
    pub fn refused(&self, name: &str) -> usize {
        let is_named = |refusal: &HingeRefusal| format!("{refusal:?}").split(' ').next() == Some(name);
        self.outcomes.iter().filter(|outcome| outcome.found.as_ref().err().is_some_and(is_named)).count()
    }

    /// Root mean square of the summed squares of these unknowns' errors.
    pub fn rms(&self, unknowns: &[usize]) -> f64 {
        self.parts(unknowns, |[error, _, _], k| error[k])
    }

    /// The same of their bounds.
    pub fn bound(&self, unknowns: &[usize]) -> f64 {
        self.parts(unknowns, |[_, _, bound], k| bound[k])
    }

    fn parts(&self, unknowns: &[usize], of: impl Fn(&[[f64; HINGE_UNKNOWNS]; 3], usize) -> f64) -> f64 {
        let values = self.accepted().flat_map(|found| unknowns.iter().map(|k| of(found, *k)).collect::<Vec<_>>());
        root_mean_square(values) * libm::sqrt(unknowns.len() as f64)
    }

    /// Root mean square of each error over its own bound.
    pub fn over_bound(&self, unknowns: &[usize]) -> f64 {
        let of = |found: &[[f64; HINGE_UNKNOWNS]; 3], k: usize| found[0][k] / found[2][k];
        self.parts(unknowns, of) / libm::sqrt(unknowns.len() as f64)
    }

    /// Root mean square of each error over its own reported 1σ.
    pub fn ratio(&self) -> f64 {
        root_mean_square(
            self.accepted().flat_map(|[error, sigma, _]| std::array::from_fn::<_, 9, _>(|k| error[k] / sigma[k])),
        )
    }

    /// Accepted with an unknown beyond 5 σ + 0.05 mm, of a direction beyond 5 σ + 0.3 mrad.
    pub fn wrong(&self) -> usize {
        let is_off = |[error, sigma, _]: &[[f64; HINGE_UNKNOWNS]; 3]| {
            let slack = |k: usize| if matches!(k, 0 | 1 | 4 | 5) { 3e-4 } else { 0.05 };
            (0..HINGE_UNKNOWNS).any(|k| !(error[k].abs() <= 5.0 * sigma[k] + slack(k)))
        };
        self.accepted().filter(|found| is_off(found)).count()
    }

    /// Mean of a figure over the outcomes that have one.
    pub fn mean(&self, of: impl Fn(&Outcome) -> f64) -> f64 {
        let (sum, count) =
            self.outcomes.iter().map(of).filter(|x| x.is_finite()).fold((0.0, 0), |(s, n), x| (s + x, n + 1));
        sum / f64::from(count)
    }
}
