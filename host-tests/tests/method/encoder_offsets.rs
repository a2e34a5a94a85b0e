//! Encoder offsets that nobody knows, found with the centre. Lengths come from the tests' own machine.

use crate::common::library::{as_poses, estimate, identify, rig, settings};
use crate::common::sets::{NOISE_MM, add_noise, lengths_at, shoulder, sweep, wrist};
use crate::common::{Worn, rng};
use glenoid::identification::{Identified, Machine, Refusal};
use glenoid::scalar::Real;
use host_tests::literal::Lengths;
use nalgebra::Vector3;
use rand::Rng;

/// Noise-free poses whose cables read too much by `offsets_mm`.
fn shifted(worn: &Worn, seed: u64, count: usize, offsets_mm: &[f64; 6]) -> Vec<Lengths<f64>> {
    let mut poses = lengths_at(worn, &sweep(&mut rng(seed), count, 45.0, 40.0));
    poses.iter_mut().for_each(|pose| pose.iter_mut().zip(offsets_mm).for_each(|(length, offset)| *length += offset));
    poses
}

fn random_offsets(seed: u64, most_mm: f64) -> [f64; 6] {
    let mut random = rng(seed ^ 0x2E05);
    std::array::from_fn(|_| random.random_range(-most_mm..=most_mm))
}

fn solve<T: Real>(worn: &Worn, poses: &[Lengths<f64>], prior_mm: f64) -> Result<Identified<T>, Refusal> {
    let rig = rig::<T>(worn);
    estimate(&rig, &Machine::with_offset_prior(&rig, T::of(prior_mm)), settings(&rig), &as_poses(poses))
}

fn centre_error_mm<T: Real>(worn: &Worn, found: &Identified<T>) -> f64 {
    (found.parameters.centre_mm.map(Real::to_f64) - worn.centre_mm).norm()
}

#[test]
fn without_noise_offsets_of_ten_millimetres_are_found_to_microns() {
    // A prior of a metre says nothing: what it pulls, (noise / prior)² of the offsets, is below a micron.
    for (worn, seed) in [(shoulder(), 1), (wrist(), 2), (Worn::random(&mut rng(3), 10.0), 3)] {
        let offsets = random_offsets(seed, 10.0);
        let found = solve::<f64>(&worn, &shifted(&worn, seed, 30, &offsets), 1000.0).unwrap();
        assert!(centre_error_mm(&worn, &found) < 1e-4, "{}", centre_error_mm(&worn, &found));
        assert!(
            found.offsets_mm.iter().zip(offsets).all(|(f, z)| (f - z).abs() < 1e-4),
            "{:?} {offsets:?}",
            found.offsets_mm
        );
    }
}

#[test]
fn single_precision_finds_the_same_within_a_tenth_of_sigma() {
    for seed in 0..20 {
        let mut poses = shifted(&shoulder(), seed, 30, &random_offsets(seed, 10.0));
        add_noise(&mut poses, &mut rng(seed), NOISE_MM);
        let double = solve::<f64>(&shoulder(), &poses, 10.0).unwrap();
        let single = solve::<f32>(&shoulder(), &poses, 10.0).unwrap();
        for k in 0..3 {
            let apart = (f64::from(single.parameters.centre_mm[k]) - double.parameters.centre_mm[k]).abs();
            assert!(apart < 0.1 * double.sigma_mm()[k], "seed {seed}, axis {k}: {apart}");
        }
        for k in 0..6 {
            assert!((f64::from(single.offsets_mm[k]) - double.offsets_mm[k]).abs() < 0.1 * double.offset_sigmas_mm[k]);
        }
    }
}

#[test]
fn offsets_that_are_known_are_none() {
    let mut poses = shifted(&shoulder(), 5, 20, &[0.0; 6]);
    add_noise(&mut poses, &mut rng(5), NOISE_MM);
    let known = solve::<f64>(&shoulder(), &poses, 0.0).unwrap();
    assert_eq!((known.offsets_mm, known.offset_sigmas_mm), ([0.0; 6], [0.0; 6]));
    // A prior of a nanometre is hardly another thing.
    let nearly = solve::<f64>(&shoulder(), &poses, 1e-6).unwrap();
    assert!((known.parameters.centre_mm - nearly.parameters.centre_mm).norm() < 1e-9);
    assert!((known.sigma_mm()[0] / nearly.sigma_mm()[0] - 1.0).abs() < 1e-6);
}

/// A prior of zero is no prior: to the bit what an exact machine gives.
#[test]
fn an_offset_prior_of_zero_changes_nothing() {
    for (seed, count) in [(11, 6), (12, 30), (13, 100)] {
        let mut poses = shifted(&shoulder(), seed, count, &[0.0; 6]);
        add_noise(&mut poses, &mut rng(seed), NOISE_MM);
        poses[3][2] += 4.0;
        assert_eq!(identify::<f32>(&shoulder(), &poses), solve::<f32>(&shoulder(), &poses, 0.0), "{count} poses");
    }
}

/// The worse the machine was homed, the wider the standard deviation; never wider than without any homing, and with a
/// perfect one that of known offsets.
#[test]
fn the_standard_deviation_grows_with_the_prior() {
    let mut poses = shifted(&shoulder(), 6, 30, &[0.0; 6]);
    add_noise(&mut poses, &mut rng(6), NOISE_MM);
    let worst = |prior_mm| solve::<f64>(&shoulder(), &poses, prior_mm).unwrap().worst_centre_sigma_mm().0;
    let sigmas: Vec<f64> = [0.0, 0.01, 0.1, 1.0, 10.0].map(worst).to_vec();
    assert!(sigmas.windows(2).all(|pair| pair[0] < pair[1]), "{sigmas:?}");
    assert!(sigmas[4] > 5.0 * sigmas[0], "the centre depends on the offsets: {sigmas:?}");
}

/// A homing error that the estimator does not know of is either refused or goes into the centre; with a prior for it the
/// estimator finds both, and the standard deviation covers what is left.
#[test]
fn one_millimetre_on_all_cables_goes_into_the_centre_unless_it_is_looked_for() {
    let poses = shifted(&shoulder(), 7, 30, &[1.0; 6]);
    match solve::<f64>(&shoulder(), &poses, 0.0) {
        Ok(blind) => assert!(centre_error_mm(&shoulder(), &blind) > 0.5),
        Err(refusal) => assert!(matches!(refusal, Refusal::CentreNotFixed { .. } | Refusal::TooManyOutliers { .. })),
    }
    let found = solve::<f64>(&shoulder(), &poses, 10.0).unwrap();
    assert!(centre_error_mm(&shoulder(), &found) < 0.02);
    assert!(found.offsets_mm.iter().all(|offset| (offset - 1.0).abs() < 0.02), "{:?}", found.offsets_mm);
}

#[test]
fn too_little_motion_to_determine_the_offsets_is_refused_by_name() {
    let worn = shoulder();
    let mut poses = lengths_at(&worn, &sweep(&mut rng(8), 12, 12.0, 10.0));
    add_noise(&mut poses, &mut rng(8), NOISE_MM);
    let known = solve::<f64>(&worn, &poses, 0.0).unwrap();
    assert!(centre_error_mm(&worn, &known) < 5.0 * known.worst_centre_sigma_mm().0 + 0.05);
    match solve::<f64>(&worn, &poses, 10.0) {
        Err(Refusal::OffsetNotDetermined { cable, sigma_mm }) => {
            assert!((1..=6).contains(&cable));
            assert!(sigma_mm > 1.0, "{sigma_mm}");
        }
        other => panic!("{other:?}"),
    }
    // Homed to a tenth of a millimetre the same poses will do, and the standard deviation says that it depends on the homing.
    let homed = solve::<f64>(&worn, &poses, 0.1).unwrap();
    assert!(homed.worst_centre_sigma_mm().0 > known.worst_centre_sigma_mm().0);
}

/// Mean of the squared errors over their variances is 1 for each of nine unknowns, within what 300 sets can tell.
#[test]
fn errors_of_centre_and_offsets_are_what_the_standard_deviation_says() {
    let (mut centre, mut offset, sets) = (Vector3::zeros(), [0.0; 6], 300);
    for seed in 0..sets {
        let offsets = random_offsets(seed, 10.0);
        let mut poses = shifted(&shoulder(), seed, 30, &offsets);
        add_noise(&mut poses, &mut rng(seed), NOISE_MM);
        let found = solve::<f64>(&shoulder(), &poses, 10.0).unwrap();
        let error = found.parameters.centre_mm - shoulder().centre_mm;
        let sigma = found.sigma_mm();
        for k in 0..3 {
            centre[k] += (error[k] / sigma[k]).powi(2) / sets as f64;
        }
        for k in 0..6 {
            offset[k] += ((found.offsets_mm[k] - offsets[k]) / found.offset_sigmas_mm[k]).powi(2) / sets as f64;
        }
    }
    // The variance of the mean of 300 chi-squares is 2/300: four of its roots are 0.33.
    for mean in centre.iter().chain(&offset) {
        assert!((mean - 1.0).abs() < 0.33, "{centre:?} {offset:?}");
    }
}

/// Four poses give twelve equations for twelve unknowns: whatever is wrong with one of them, nothing contradicts it.
#[test]
fn four_poses_with_unknown_offsets_are_refused() {
    let mut accepted = 0;
    for seed in 0..200 {
        let mut poses = shifted(&shoulder(), seed, 4, &random_offsets(seed, 10.0));
        add_noise(&mut poses, &mut rng(seed), NOISE_MM);
        accepted += usize::from(solve::<f64>(&shoulder(), &poses, 10.0).is_ok());
    }
    assert_eq!(accepted, 0);
}
