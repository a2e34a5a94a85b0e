//! What the logs have determined, and what to record next, in words.

use super::constants::Constant;
use super::fit::Fit;
use super::normal_equations::{self, Sums};
use super::wearing::Wearing;
use glenoid::identification::Machine;
use glenoid::identification::weights::{INLIER_LIMIT, Weights};
use glenoid::kinematics::rotation::rotation_vector;
use nalgebra::{DMatrix, DVector, Matrix3};

/// What is left of a constant's tolerance: below the first it is well determined, above the second hardly at all.
const WELL: f64 = 0.33;
const HARDLY: f64 = 0.8;

/// Poses of the next wearing that the forecast is for.
const NEXT_POSES: f64 = 30.0;
/// Total standard deviation of the next wearing's centre at which nothing more need be recorded, mm.
const GOOD_ENOUGH_MM: f64 = 0.15;

/// Root-mean-square angles that a ball about on a bench reaches easily: uniform to 45° of tilt, ±35° of torsion.
const WIDE_TILT_DEG: f64 = 25.0;
const WIDE_TORSION_DEG: f64 = 20.0;
/// Places of the ball nearer to each other than this are one, mm.
const PLACES_APART_MM: f64 = 10.0;
/// Fewer poses than this in all are few.
const MANY_POSES: usize = 200;

/// What the logs have determined.
#[derive(Clone, Debug, PartialEq)]
pub struct Determined {
    /// Sentences about what is known now.
    pub known: Vec<String>,
    /// What to record next; empty when nothing need be.
    pub next: Vec<String>,
    /// Total 1σ of the next wearing's joint centre from thirty such poses, before and after, mm.
    pub next_centre_sigma_mm: [f64; 2],
}

impl Determined {
    /// Of a fit at its end, with the covariance of the machine's parameters (mm², homing included) before and after.
    pub fn of(fit: &Fit<'_>, constants: &[Constant], before: &DMatrix<f64>, after: &DMatrix<f64>) -> Self {
        let next = [before, after].map(|covariance| next_centre_sigma_mm(fit, covariance));
        let mut known = vec![
            classed(constants, "well determined", |share| share < WELL),
            classed(constants, "determined in part", |share| (WELL..=HARDLY).contains(&share)),
            classed(constants, "not determined beyond the stated tolerance", |share| share > HARDLY),
        ];
        known.retain(|sentence| !sentence.is_empty());
        known.extend(least_known(fit.machine, before, after));
        Self { known, next: what_next(fit, next[1]), next_centre_sigma_mm: next }
    }
}

/// The constants of which such a share of the tolerance is left.
fn classed(constants: &[Constant], class: &str, belongs: impl Fn(f64) -> bool) -> String {
    let names: Vec<_> = constants
        .iter()
        .filter(|constant| belongs(constant.share_left()))
        .map(|constant| format!("{} ({:.0} %)", constant.name, 100.0 * constant.share_left()))
        .collect();
    if names.is_empty() {
        String::new()
    } else {
        format!("{class} (of the stated sigma are left): {}", names.join(", "))
    }
}

/// The combination of the parameters that is known least, in the measure of what was known before.
fn least_known(machine: &Machine<f64>, before: &DMatrix<f64>, after: &DMatrix<f64>) -> Option<String> {
    let factor = before.clone().cholesky()?.l();
    let inverse = factor.clone().try_inverse()?;
    let eigen = (&inverse * after * inverse.transpose()).symmetric_eigen();
    let worst = eigen.eigenvalues.imax();
    let undetermined = eigen.eigenvalues.iter().filter(|share| share.sqrt() > HARDLY).count();
    let left = eigen.eigenvalues[worst].max(0.0).sqrt();
    if left <= HARDLY {
        return Some(format!(
            "every combination of the constants is determined: of the least known {:.0} % of the stated sigma are left",
            100.0 * left
        ));
    }
    let pattern: DVector<f64> = factor * eigen.eigenvectors.column(worst);
    let zeros = machine.first_offset().map(|first| {
        let zeros: Vec<_> = (first..first + 6).map(|index| format!("{:+.1}", pattern[index])).collect();
        format!(" ({} mm in the six zeros)", zeros.join(", "))
    });
    Some(format!(
        "{undetermined} of {} combinations of the constants are known no better than stated{}: they look like another place \
         or size of everything at once",
        before.nrows(),
        zeros.unwrap_or_default()
    ))
}

/// What to record next.
fn what_next(fit: &Fit<'_>, next_sigma_mm: f64) -> Vec<String> {
    if next_sigma_mm <= GOOD_ENOUGH_MM {
        return Vec::new();
    }
    let mut next = Vec::new();
    let places: Vec<_> = fit.wearings.iter().filter_map(|wearing| wearing.known.as_ref()).collect();
    let apart = |a: usize, b: usize| (places[a].in_base_mm - places[b].in_base_mm).norm() > PLACES_APART_MM;
    let distinct = (0..places.len()).filter(|&a| (0..a).all(|b| apart(a, b))).count();
    if distinct == 0 {
        next.push(
            "put a ball joint at a known place (centre = [x, y, z] in {B}, to 0.1 mm): some patterns of the zeros mimic a \
             shift of every centre, and no wearer can tell the two apart"
                .to_owned(),
        );
    } else if distinct < 3 {
        next.push(format!(
            "put the ball at another known place, 20 mm or more away: {distinct} of the 3 that determine everything {}",
            if distinct == 1 { "is there" } else { "are there" }
        ));
    }
    let angles: Vec<_> = fit.wearings.iter().map(motion_deg).collect();
    let widest = |k: usize| angles.iter().map(|angles| angles[k]).fold(0.0, f64::max);
    if widest(0) < WIDE_TILT_DEG {
        next.push(format!("tilt wider: {:.0}° in the mean now, to 55° if the machine allows", widest(0)));
    }
    if widest(1) < WIDE_TORSION_DEG {
        next.push(format!(
            "turn the arm more about its own axis: {:.0}° in the mean now, to ±55° if it can",
            widest(1)
        ));
    }
    let poses: usize = fit.wearings.iter().map(Wearing::used).sum();
    if poses < MANY_POSES {
        next.push(format!("record more poses: {poses} in all now, 300 determine what the geometry allows"));
    }
    if next.is_empty() {
        next.push("record more wearers: each adds what the others leave open".to_owned());
    }
    next
}

/// Root-mean-square tilt and torsion of a log's poses about their mean, degrees.
fn motion_deg(wearing: &Wearing) -> [f64; 2] {
    let rotations: Vec<_> = wearing.poses.iter().filter(|pose| pose.is_used()).map(|pose| pose.rotation()).collect();
    let sum: Matrix3<f64> = rotations.iter().sum();
    let svd = sum.svd(true, true);
    let (Some(u), Some(v)) = (svd.u, svd.v_t) else { return [0.0; 2] };
    let mean = u * v;
    let normal = mean.column(2).into_owned();
    let squares = rotations.iter().fold([0.0; 2], |[tilt, torsion], rotation| {
        let turn = rotation_vector(&mean, rotation);
        let along = turn.dot(&normal);
        [tilt + (turn - normal * along).norm_squared(), torsion + along * along]
    });
    squares.map(|sum| (sum / rotations.len().max(1) as f64).sqrt().to_degrees())
}

/// Total 1σ of the joint centre of a next wearing with thirty poses like those of the first log, when the machine is known
/// with this covariance, mm.
fn next_centre_sigma_mm(fit: &Fit<'_>, covariance_mm2: &DMatrix<f64>) -> f64 {
    let Some(mut like) = fit.wearings.first().cloned() else { return f64::NAN };
    let variance = fit.noise_mm * fit.noise_mm;
    let weights = Weights::Inliers(INLIER_LIMIT);
    let used = like.used().max(1) as f64;
    let sums = normal_equations::sum(fit.machine, &fit.estimate, &mut like, &weights, variance, false);
    let Some(factor) = covariance_mm2.clone().cholesky() else { return f64::NAN };
    let known = Sums { machine: factor.inverse() * variance, ..Sums::none(covariance_mm2.nrows()) };
    match normal_equations::solve(&known, &[sums.times(NEXT_POSES / used)]) {
        Ok(solution) => {
            let centre = &solution.centre_covariances[0];
            ((centre[(0, 0)] + centre[(1, 1)] + centre[(2, 2)]) * variance).sqrt()
        }
        Err(_) => f64::NAN,
    }
}
