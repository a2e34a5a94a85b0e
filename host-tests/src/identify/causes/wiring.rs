//! Explanations that leave no fit to compare: an encoder that stands still, exchanged cables, an encoder that began anew.

use super::all_poses_fit::{AllPosesFit, Freedom};
use super::{Cause, CauseKind, MAX_SCATTER_MM};
use crate::estimation::estimate;
use glenoid::identification::joint::MIN_MOVING_POSES;
use glenoid::identification::pivot_calibration::PivotCalibration;
use glenoid::identification::statistics::{FALSE_ALARM, chi_square_quantile};
use glenoid::identification::{EstimatorSettings, JointChoice, Machine, Noise};
use glenoid::kinematics::{AttitudeSolver, CableLengths, CableSet, LengthJacobian};
use glenoid::rig::{CABLES, Rig};

/// An encoder whose reading stays within this stands still while the typical one moves by the other, mm.
const STANDS_STILL_MM: f64 = 1.0;
const MOVES_MM: f64 = 10.0;
/// The best exchange must be so much better than the next.
const CLEARLY_BETTER: f64 = 0.5;
/// Poses of an unplaced exchange that may be missing.
const MIN_PLACED: f64 = 0.7;
/// Poses that a part of the log must have to be fitted by itself.
const MIN_PART: usize = 8;
/// χ² of a pose (3 degrees of freedom) that belongs to another part.
const OTHER_PART: f64 = 50.0;
/// Losses of one cable in several poses are one loss when they agree within this, mm.
const SAME_LOSS_MM: f64 = 1.0;

/// The cable whose reading stays the same while the others change.
pub fn standing_still(lengths: &[CableLengths<f64>]) -> Option<Cause> {
    let range = |cable: usize| {
        let values = || lengths.iter().map(|lengths| lengths.as_mm()[cable]);
        values().fold(f64::MIN, f64::max) - values().fold(f64::MAX, f64::min)
    };
    let ranges: [f64; CABLES] = std::array::from_fn(range);
    let mut sorted = ranges;
    sorted.sort_by(f64::total_cmp);
    let cable = ranges.iter().position(|range| *range == sorted[0])?;
    let stands = sorted[0] < STANDS_STILL_MM && (sorted[2] + sorted[3]) / 2.0 > MOVES_MM;
    let cause = Cause { cable: Some(cable as u8 + 1), size: sorted[0], ..Cause::of(CauseKind::ConstantEncoder) };
    stands.then_some(Cause { explains: true, ..cause })
}

/// The two cables which, exchanged, give the poses one centre.
pub fn exchanged(machine: &Machine<f64>, lengths: &[CableLengths<f64>], noise_mm: f64) -> Option<Cause> {
    let pairs = (0..CABLES).flat_map(|a| (a + 1..CABLES).map(move |b| (a, b)));
    let swapped = |(a, b): (usize, usize)| -> Vec<_> { lengths.iter().map(|l| l.exchanged(a, b)).collect() };
    let mut rated: Vec<_> = pairs
        .map(|pair| (median_distance_mm(machine, &swapped(pair)), Some(pair)))
        .chain([(median_distance_mm(machine, lengths), None)])
        .filter(|(distance_mm, _)| distance_mm.is_finite())
        .collect();
    rated.sort_by(|one, other| one.0.total_cmp(&other.0));
    let (distance_mm, _) = *rated.first()?;
    let is_clear = rated.get(1).is_none_or(|next| distance_mm <= CLEARLY_BETTER * next.0);
    if is_clear {
        let (a, b) = rated.first()?.1?;
        return Some(Cause { explains: has_a_joint(machine, &swapped((a, b)), noise_mm), ..exchange(a, b) });
    }
    // Distances do not tell: a centre that moves is off the common one as well. Then it is the only one with a joint.
    let as_it_is = has_a_joint(machine, lengths, noise_mm);
    let mut with_a_joint =
        rated.iter().filter_map(|(_, pair)| *pair).filter(|pair| has_a_joint(machine, &swapped(*pair), noise_mm));
    match (as_it_is, with_a_joint.next(), with_a_joint.next()) {
        (false, Some((a, b)), None) => Some(Cause { explains: true, ..exchange(a, b) }),
        _ => None,
    }
}

fn exchange(a: usize, b: usize) -> Cause {
    Cause { cable: Some(a as u8 + 1), other_cable: Some(b as u8 + 1), ..Cause::of(CauseKind::ExchangedCables) }
}

/// Do the poses have a joint: a ball to within the noise, or one that scatters or moves no more than a living one?
fn has_a_joint(machine: &Machine<f64>, lengths: &[CableLengths<f64>], noise_mm: f64) -> bool {
    let fit = |scatters, moves| AllPosesFit::new(machine, lengths, noise_mm, Freedom { scatters, moves });
    let may_move = lengths.len() >= MIN_MOVING_POSES;
    fit(false, false).is_some_and(|fit| fit.chi_square <= chi_square_quantile(fit.freedom, FALSE_ALARM))
        || fit(true, may_move).is_some_and(|fit| fit.scatter_mm < MAX_SCATTER_MM)
}

/// Median distance of the poses' own centres from the common one, each pose placed by itself, mm. Infinite when too few
/// have a place.
fn median_distance_mm(machine: &Machine<f64>, lengths: &[CableLengths<f64>]) -> f64 {
    let placed: Vec<_> = lengths.iter().filter_map(|lengths| machine.platform().solve(lengths).ok()).collect();
    if (placed.len() as f64) < MIN_PLACED * lengths.len() as f64 {
        return f64::INFINITY;
    }
    let mut pivot = PivotCalibration::default();
    placed.iter().for_each(|pose| pivot.add(pose));
    let Ok(centre) = pivot.solve() else { return f64::INFINITY };
    let own = |pose: &glenoid::kinematics::PlatformPose<f64>| {
        (pose.rotation * centre.in_platform_mm + pose.origin_mm - centre.in_base_mm).norm()
    };
    let mut distances: Vec<_> = placed.iter().map(own).collect();
    distances.sort_by(f64::total_cmp);
    distances.get(distances.len() / 2).copied().unwrap_or(f64::INFINITY)
}

/// The cable whose counts jumped by so much that the poses before and after do not fit each other at all: the beginning of
/// the log has a centre, and about that centre all poses from one on want the same correction of the same cable.
pub fn count_begun_anew(
    rig: &Rig<f64>,
    machine: &Machine<f64>,
    lengths: &[CableLengths<f64>],
    noise_mm: f64,
) -> Option<Cause> {
    let beginnings = [2, 3, 4, 6].map(|share| (lengths.len() / share).max(MIN_PART));
    beginnings
        .into_iter()
        .filter_map(|poses| lengths.get(..poses))
        .find_map(|beginning| loss_after(rig, machine, lengths, beginning, noise_mm))
}

fn loss_after(
    rig: &Rig<f64>,
    machine: &Machine<f64>,
    lengths: &[CableLengths<f64>],
    beginning: &[CableLengths<f64>],
    noise_mm: f64,
) -> Option<Cause> {
    let noise = Noise::Known(noise_mm);
    let settings = EstimatorSettings { noise, joint: JointChoice::Ball, ..EstimatorSettings::for_rig(rig) };
    let fitted = estimate(machine, rig, settings, beginning);
    fitted.outcome.as_ref().ok()?;
    let (estimate, centre) = (fitted.estimator.machine_estimate(), fitted.estimator.centre());
    let variance = noise_mm * noise_mm;
    let solver = AttitudeSolver { geometry: estimate.geometry(), centre };
    // Of each pose: it fits, or which cable reads too much by how much.
    let look = |lengths: &CableLengths<f64>| {
        let lengths = estimate.corrected(machine, lengths);
        let fits = solver.solve(&lengths, CableSet::ALL).is_some_and(|fit| fit.squares_mm2 < OTHER_PART * variance);
        if fits {
            return Some(None);
        }
        let mut without: Vec<_> =
            (0..CABLES).filter_map(|cable| Some((cable, solver.solve(&lengths, CableSet::all_but(cable))?))).collect();
        without.sort_by(|a, b| a.1.squares_mm2.total_cmp(&b.1.squares_mm2));
        let (cable, fit) = without.first()?;
        let rotation = *fit.attitude.to_rotation_matrix().matrix();
        let jacobian = LengthJacobian::new(estimate.geometry(), centre, &rotation, &lengths);
        (fit.squares_mm2 < OTHER_PART * variance).then(|| Some((*cable, jacobian.rows[*cable].residual_mm)))
    };
    let seen: Vec<_> = lengths.iter().map(look).collect::<Option<_>>()?;
    let lost: Vec<_> = seen.iter().flatten().collect();
    let (cable, size) = **lost.first()?;
    let all_agree = lost.iter().all(|(other, by)| *other == cable && (by - size).abs() < SAME_LOSS_MM);
    let first = seen.iter().position(Option::is_some)?;
    let mean = lost.iter().map(|(_, by)| by).sum::<f64>() / lost.len() as f64;
    (all_agree && first + lost.len() == lengths.len()).then(|| Cause {
        cable: Some(cable as u8 + 1),
        pose: Some(first),
        size: mean,
        explains: true,
        ..Cause::of(CauseKind::LostCounts)
    })
}
