//! Is what was fitted believed? Logs that fit no ball on this rig, places of a ball in another frame, a machine further
//! off than its tolerances allow.

use super::fit::Fit;
use super::normal_equations::{Solution, Undetermined};
use super::refusal::Refused;
use super::request::KnownCentre;
use super::wearing::Wearing;
use glenoid::identification::statistics::{FALSE_ALARM, chi_square_quantile};
use glenoid::identification::weights::INLIER_LIMIT;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// At most this share of a log's poses is left out as bad.
const MAX_SHARE_LEFT_OUT: f64 = 0.2;

/// Why a log is not believed.
fn complaint(wearing: &Wearing, noise_mm: f64) -> Option<String> {
    let (poses, used) = (wearing.poses.len(), wearing.used());
    let left_out = poses - used;
    if left_out as f64 > MAX_SHARE_LEFT_OUT * poses as f64 {
        return Some(format!("{left_out} of {poses} poses fit no common joint centre"));
    }
    let (chi_square, freedom) = wearing.chi_square();
    (!(chi_square <= chi_square_quantile(freedom, FALSE_ALARM))).then(|| {
        let ratio = (chi_square / freedom).sqrt();
        format!("the lengths are off by {:.2} mm where noise is {noise_mm:.2} mm ({ratio:.1} times)", ratio * noise_mm)
    })
}

/// Refuses logs that do not fit; where leaving one out makes the others fit, that one is named.
///
/// # Errors
/// [`Refused`].
pub fn require_sound_logs(fit: &Fit<'_>) -> Result<(), Refused> {
    let complaints: Vec<_> = fit.wearings.iter().map(|wearing| complaint(wearing, fit.noise_mm)).enumerate().collect();
    let mut bad = complaints.iter().filter_map(|(log, why)| why.as_ref().map(|why| (*log, why))).peekable();
    let Some(&(first, why)) = bad.peek() else { return Ok(()) };
    if let [only] = &fit.wearings[..] {
        let remedy = "a joint that is no ball, a strap that slips, an encoder that lost counts, cables exchanged, or \
                      another rig";
        return Err(Refused::at(only.place.clone(), format!("{}: {why}: {remedy}", only.file)));
    }
    let culprits: Vec<usize> = (0..fit.wearings.len()).filter(|log| others_fit(fit, *log)).collect();
    if let [culprit] = culprits[..] {
        let wearing = &fit.wearings[culprit];
        let why = complaints[culprit].1.as_deref().unwrap_or(why);
        let reason = format!(
            "{}: {why}; the other logs fit without it: another rig or another homing, a joint that is no ball, or a strap \
             that slips",
            wearing.file
        );
        return Err(Refused::at(wearing.place.clone(), reason));
    }
    let names: Vec<&str> = bad.map(|(log, _)| fit.wearings[log].file.as_str()).collect();
    let reason = format!(
        "{}: {why}. The logs contradict each other ({}): of different rigs or homings, or their joint is no ball; leaving \
         out one alone does not tell which",
        fit.wearings[first].file,
        names.join(", ")
    );
    Err(Refused::at(fit.wearings[first].place.clone(), reason))
}

/// Do the logs beside `log` fit when it is left out?
fn others_fit(fit: &Fit<'_>, log: usize) -> bool {
    let mut wearings = fit.wearings.clone();
    wearings.remove(log);
    for pose in wearings.iter_mut().flat_map(|wearing| &mut wearing.poses) {
        // A pose that the bad log has cost its rotation is placed anew.
        pose.reset();
        pose.place(fit.machine.platform());
    }
    let mut others = fit.without(wearings);
    others.run().is_ok() && others.wearings.iter().all(|wearing| complaint(wearing, others.noise_mm).is_none())
}

/// Refuses a stated place that is not where the lengths put the joint centre, all logs fitted without the stated places.
///
/// # Errors
/// [`Refused`] names the place that is furthest off.
pub fn require_centres_where_stated(fit: &Fit<'_>, solution: &Solution) -> Result<(), Refused> {
    let distance = |log: usize, known: &KnownCentre, off_mm: &Vector3<f64>| {
        let own = solution.centre_covariances[log].fixed_view::<3, 3>(0, 0) * fit.noise_mm.powi(2);
        mahalanobis(&(own + stated_covariance(known)), off_mm)
    };
    require_centres(fit, distance)
}

/// Refuses a stated place that contradicts the others and the lengths, everything fitted with all of them.
///
/// # Errors
/// [`Refused`] names the place that is furthest off.
pub fn require_centres_agree(fit: &Fit<'_>, solution: &Solution) -> Result<(), Refused> {
    // What was measured took part in what it is compared with: the covariances are subtracted.
    let distance = |log: usize, known: &KnownCentre, off_mm: &Vector3<f64>| {
        let own = solution.centre_covariances[log].fixed_view::<3, 3>(0, 0) * fit.noise_mm.powi(2);
        mahalanobis(&(stated_covariance(known) - own), off_mm)
    };
    require_centres(fit, distance)
}

fn require_centres(fit: &Fit<'_>, distance: impl Fn(usize, &KnownCentre, &Vector3<f64>) -> f64) -> Result<(), Refused> {
    let of_log = |(log, wearing): (usize, &Wearing)| {
        let known = wearing.known.clone()?;
        let off_mm = known.in_base_mm - wearing.centre.in_base_mm;
        Some((distance(log, &known, &off_mm), log, known, off_mm))
    };
    let all = fit.wearings.iter().enumerate().filter_map(of_log);
    let Some((squared, log, known, off_mm)) = all.max_by(|a, b| a.0.total_cmp(&b.0)) else { return Ok(()) };
    if squared <= INLIER_LIMIT {
        return Ok(());
    }
    let [x, y, z] = fit.wearings[log].centre.in_base_mm.into();
    let reason = format!(
        "the centre of {} is stated {:.2} mm from where the lengths put it, ({x:.2}, {y:.2}, {z:.2}): {:.1} times what both \
         are known to; is it in the frame {{B}} of the rig's attachment points, in millimetres, and measured in this log?",
        fit.wearings[log].file,
        off_mm.norm(),
        squared.sqrt()
    );
    Err(Refused::at(known.place, reason))
}

fn stated_covariance(known: &KnownCentre) -> Matrix3<f64> {
    Matrix3::from_diagonal_element(known.sigma_mm * known.sigma_mm)
}

/// Infinite for a covariance that is none.
fn mahalanobis(covariance: &Matrix3<f64>, off_mm: &Vector3<f64>) -> f64 {
    covariance.cholesky().map_or(f64::INFINITY, |factor| off_mm.dot(&factor.solve(off_mm)))
}

/// How far the machine is from what was stated, in the measure of its tolerances: χ², and its degrees of freedom.
pub fn distance_from_stated(fit: &Fit<'_>, prior_covariance: &DMatrix<f64>) -> (f64, f64) {
    let count = prior_covariance.nrows();
    let values = DVector::from_fn(count, |index, _| fit.estimate.values()[index]);
    let squared =
        prior_covariance.clone().cholesky().map_or(f64::INFINITY, |factor| values.dot(&factor.solve(&values)));
    (squared, count as f64)
}

/// Refuses a machine that is further off than its tolerances allow.
///
/// # Errors
/// [`Refused`] names the constant that is furthest off.
pub fn require_within_tolerances(fit: &Fit<'_>, prior_covariance: &DMatrix<f64>, worst: &str) -> Result<(), Refused> {
    let (squared, freedom) = distance_from_stated(fit, prior_covariance);
    if squared <= chi_square_quantile(freedom, FALSE_ALARM) {
        return Ok(());
    }
    Err(Refused::everywhere(format!(
        "the machine is further from the stated rig than its tolerances allow ({:.1} times): furthest off is {worst}; \
         another rig, cables exchanged, or tolerances stated too narrow",
        (squared / freedom).sqrt()
    )))
}

/// A log whose joint centre has no solution.
pub fn undetermined(fit: &Fit<'_>, found: Undetermined) -> Refused {
    let wearing = &fit.wearings[found.log];
    let (poses, left_out) = (wearing.poses.len(), wearing.poses.len() - wearing.used());
    let why = if left_out > 0 {
        format!(
            "{left_out} of {poses} poses fit no common joint centre: another rig, cables exchanged, a joint that is no ball, \
             or a strap that slips"
        )
    } else {
        "determines nothing: its joint centre has no solution".to_owned()
    };
    Refused::at(wearing.place.clone(), format!("{}: {why}", wearing.file))
}
