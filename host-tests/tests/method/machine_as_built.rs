//! Machines that are off by their tolerances: the estimate's error is what its standard deviation says.

use super::machine::toleranced;
use crate::common::library::{as_poses, estimate, rig, settings};
use crate::common::sets::{NOISE_MM, add_noise, lengths_at, normal, shoulder, sweep};
use crate::common::{Worn, rng};
use glenoid::identification::{Identified, Machine, Refusal};
use glenoid::rig::Tolerance;
use nalgebra::{Matrix3, Rotation3, Vector3};
use rand_chacha::ChaCha8Rng;

/// A machine that is not as stated, and the poses that it measures. The true centre in the frame best fitted to its
/// attachment points, and its true distances from the end-points.
fn as_built(
    rng: &mut ChaCha8Rng,
    worn: &Worn,
    tolerance: &Tolerance<f64>,
    count: usize,
) -> (Vec<[f64; 6]>, Vector3<f64>, [f64; 3]) {
    let home = rig::<f64>(worn).drum().home_length_mm;
    let mut built = *worn;
    built.base_mm.iter_mut().for_each(|point| *point += Vector3::from_fn(|_, _| tolerance.base_mm * normal(rng)));
    // Edges off by their tolerance: the platform rebuilt from three edges, in its plane.
    let edges = worn.machine().edges_mm.map(|edge| edge + tolerance.edges_mm * normal(rng));
    built.home_mm = with_edges(&worn.home_mm, edges);
    let offsets: [f64; 6] = core::array::from_fn(|_| tolerance.offset_mm * normal(rng));
    let scales: [f64; 6] = core::array::from_fn(|_| 1.0 + tolerance.drum * normal(rng));
    let mut poses = lengths_at(&built, &sweep(rng, count, 45.0, 30.0));
    for pose in &mut poses {
        for k in 0..6 {
            pose[k] = home[k] + scales[k] * (pose[k] - home[k]) + offsets[k];
        }
    }
    add_noise(&mut poses, rng, NOISE_MM);
    let radii = built.home_mm.map(|point| point.norm());
    (poses, in_stated_frame(&worn.base_mm, &built.base_mm, &built.centre_mm), radii)
}

/// The triangle nearest to another with these edges p12, p23, p31: each point moved along the edges until they fit.
fn with_edges(points: &[Vector3<f64>; 3], edges: [f64; 3]) -> [Vector3<f64>; 3] {
    let mut points = *points;
    for _ in 0..200 {
        for (edge, (i, j)) in [(0, 1), (1, 2), (2, 0)].into_iter().enumerate() {
            let along = points[j] - points[i];
            let half = along.normalize() * ((along.norm() - edges[edge]) / 2.0);
            points[i] += half;
            points[j] -= half;
        }
    }
    points
}

/// A point in the frame in which the true attachment points are best fitted to the stated ones (Kabsch 1976).
fn in_stated_frame(stated: &[Vector3<f64>; 3], built: &[Vector3<f64>; 3], point: &Vector3<f64>) -> Vector3<f64> {
    let middle = |points: &[Vector3<f64>; 3]| points.iter().sum::<Vector3<f64>>() / 3.0;
    let (to, from) = (middle(stated), middle(built));
    let product = stated.iter().zip(built).map(|(s, b)| (s - to) * (b - from).transpose()).sum::<Matrix3<f64>>();
    let svd = product.svd(true, true);
    let (u, v) = (svd.u.expect("u"), svd.v_t.expect("v"));
    let sign = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, (u * v).determinant().signum()));
    let turn = Rotation3::from_matrix_unchecked(u * sign * v);
    turn * (point - from) + to
}

fn identify_with(worn: &Worn, tolerance: Tolerance<f64>, poses: &[[f64; 6]]) -> Result<Identified<f64>, Refusal> {
    let rig = toleranced(worn, tolerance);
    estimate(&rig, &Machine::new(&rig), settings(&rig), &as_poses(poses))
}

/// Sets of a machine that is off by its tolerances: how many are accepted, root mean square of error over σ of the centre and
/// of the radii, and of the centre's error.
fn sets(tolerance: Tolerance<f64>, seed: u64, count: usize) -> (usize, [f64; 2], f64) {
    let (mut accepted, mut ratio, mut squares) = (0, [0.0; 2], 0.0);
    for set in 0..SETS {
        let mut rng = rng(seed + set);
        let (poses, truth, radii) = as_built(&mut rng, &shoulder(), &tolerance, count);
        let Ok(found) = identify_with(&shoulder(), tolerance, &poses) else { continue };
        let error = found.parameters.centre_mm - truth;
        let sigma = found.sigma_mm();
        accepted += 1;
        squares += error.norm_squared();
        ratio[0] += (0..3).map(|k| (error[k] / sigma[k]).powi(2)).sum::<f64>() / 3.0;
        let off = |k: usize| (found.parameters.radii_mm[k] - radii[k]) / sigma[3 + k];
        ratio[1] += (0..3).map(|k| off(k).powi(2)).sum::<f64>() / 3.0;
    }
    (accepted, ratio.map(|ratio| (ratio / accepted as f64).sqrt()), (squares / accepted as f64).sqrt())
}

/// Sets of each kind.
const SETS: u64 = 200;

#[test]
fn a_machine_within_its_tolerances_is_accepted_with_a_true_standard_deviation() {
    for (tolerance, least, most_mm) in [
        (Tolerance { base_mm: 0.5, edges_mm: 0.5, offset_mm: 0.0, drum: 0.0 }, 198, 0.12),
        (Tolerance { base_mm: 0.5, edges_mm: 0.5, offset_mm: 0.3, drum: 1e-3 }, 198, 0.36),
    ] {
        let (accepted, ratio, rms_mm) = sets(tolerance, 4300, 30);
        assert!(accepted >= least, "{tolerance:?}: {accepted} of {SETS}");
        // 600 squares: their root mean is known to 3 %.
        let is_true = |ratio: &f64| (0.88..1.12).contains(ratio);
        assert!(ratio.iter().all(is_true), "{tolerance:?}: error is {ratio:?} of σ");
        assert!(rms_mm < most_mm, "{tolerance:?}: {rms_mm} mm");
    }
}

/// The radii's, where only some of the constants are unknown: each takes the place of another among the parameters.
#[test]
fn the_radii_have_a_true_standard_deviation_whatever_is_known() {
    let exact = Tolerance { base_mm: 0.0, edges_mm: 0.0, offset_mm: 0.0, drum: 0.0 };
    for tolerance in [
        exact,
        Tolerance { edges_mm: 0.5, ..exact },
        Tolerance { base_mm: 0.5, ..exact },
        Tolerance { base_mm: 0.5, offset_mm: 0.3, ..exact },
        Tolerance { edges_mm: 0.5, drum: 1e-3, ..exact },
        Tolerance { offset_mm: 0.3, drum: 1e-3, ..exact },
    ] {
        let (_, ratio, _) = sets(tolerance, 4700, 30);
        // 600 squares: their root mean is known to 3 %.
        assert!(ratio.iter().all(|ratio| (0.88..1.12).contains(ratio)), "{tolerance:?}: error is {ratio:?} of σ");
    }
}

#[test]
fn a_machine_that_is_taken_for_exact_is_refused_or_wrong() {
    // What the tolerances are there for.
    let tolerance = Tolerance { base_mm: 0.5, edges_mm: 0.5, offset_mm: 0.0, drum: 0.0 };
    let (mut beyond, mut refused) = (0, 0);
    for set in 0..100 {
        let (poses, truth, _) = as_built(&mut rng(4400 + set), &shoulder(), &tolerance, 30);
        match identify_with(&shoulder(), Tolerance::exact(), &poses) {
            Ok(found) => {
                let (sigma, _) = found.worst_centre_sigma_mm();
                beyond += u32::from((found.parameters.centre_mm - truth).norm() > 3.0 * sigma);
            }
            Err(_) => refused += 1,
        }
    }
    assert!(refused > 30 && refused + beyond > 60, "{refused} refused, {beyond} beyond 3 σ");
}

#[test]
fn without_tolerances_there_is_nothing_to_estimate() {
    let worn = shoulder();
    let (poses, ..) = as_built(&mut rng(4500), &worn, &Tolerance::exact(), 30);
    let exact = identify_with(&worn, Tolerance::exact(), &poses).expect("a sound set");
    let tiny = Tolerance { base_mm: 1e-6, edges_mm: 1e-6, offset_mm: 1e-6, drum: 1e-9 };
    let nearly = identify_with(&worn, tiny, &poses).expect("a sound set");
    assert!((exact.parameters.centre_mm - nearly.parameters.centre_mm).norm() < 1e-6);
    assert!((exact.sigma_mm()[0] / nearly.sigma_mm()[0] - 1.0).abs() < 1e-6);
}
