//! The start-free estimator against maximum likelihood the long way (`common::dense`): the same centre, the same
//! standard deviation, from any order, in any frame, in slices or at once, and on either machine.

use crate::common::dense::{Dense, Unknowns, maximum_likelihood};
use crate::common::library::{as_cables, as_poses, estimate, identify, rig, settings};
use crate::common::sets::{NOISE_MM, add_noise, lengths_at, machines, noisy, sweep};
use crate::common::{Worn, mirrored, parameters, rng};
use glenoid::identification::outcome::{MAX_ITERATIONS, MAX_REJECTED};
use glenoid::identification::{Estimator, Identified, Machine, Pose, PoseState, Progress, Refusal, Termination};
use glenoid::kinematics::ForwardKinematics;
use glenoid::linear_algebra::packed_index;
use glenoid::rig::{Parameters, Rig};
use glenoid::scalar::Real;
use host_tests::literal::Lengths;
use nalgebra::{Rotation3, Vector3};
use rand::Rng;
use rand::seq::SliceRandom;

/// The dense problem's solution, begun at the truth.
fn reference(worn: &Worn, poses: &[Lengths<f64>], rotations: &[Rotation3<f64>]) -> Dense {
    let start = Unknowns { centre_mm: worn.centre_mm, in_platform_mm: Vector3::zeros(), rotations: rotations.to_vec() };
    maximum_likelihood(worn, poses, start)
}

fn found<T: Real>(identified: &Identified<T>) -> [f64; 6] {
    identified.parameters.to_array().map(Real::to_f64)
}

/// Largest difference of two sets of parameters, mm.
fn apart(one: &[f64; 6], other: &[f64; 6]) -> f64 {
    one.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// The noise that the standard deviation counts with: the rig's, or the residuals' own where they are larger than in nineteen
/// sound sets of twenty. `None` where the table is too coarse to tell.
fn expected_noise_mm(squares_mm2: f64, count: usize) -> Option<f64> {
    let freedom = 3 * count - 6;
    // 95 % quantiles of chi-square (any table).
    let quantile = match freedom {
        9 => 16.92,
        24 => 36.42,
        30 => 43.77,
        66 => 85.96,
        114 => 139.92,
        _ => panic!("look up chi-square with {freedom} degrees of freedom"),
    };
    let chi_square = squares_mm2 / (NOISE_MM * NOISE_MM);
    let told = (chi_square / quantile - 1.0).abs() > 0.01;
    told.then(|| if chi_square > quantile { (squares_mm2 / freedom as f64).sqrt() } else { NOISE_MM })
}

/// Asserts that centre, radii, standard deviation and what is left of the residuals are the dense problem's; the covariance to
/// the share `close` of the variances.
fn assert_maximum_likelihood(identified: &Identified<f64>, dense: &Dense, count: usize, close: f64, what: &str) {
    let off = apart(&found(identified), &parameters(&dense.estimate));
    assert!(off < 1e-6, "{what}: {off} mm from the maximum-likelihood estimate");
    let noise_mm = expected_noise_mm(dense.squares_mm2, count).unwrap_or(identified.noise_mm);
    assert!((identified.noise_mm / noise_mm - 1.0).abs() < 1e-6, "{what}: {} not {noise_mm} mm", identified.noise_mm);
    let bound = dense.covariance * (noise_mm * noise_mm);
    for i in 0..6 {
        for j in 0..=i {
            let (mine, expected) = (identified.covariance_mm2[packed_index(i, j)], bound[(i, j)]);
            let scale = (bound[(i, i)] * bound[(j, j)]).sqrt();
            assert!((mine - expected).abs() < close * scale, "{what}: covariance {i}, {j}: {mine} not {expected}");
        }
    }
    let deviation = (dense.squares_mm2 / (3 * count) as f64).sqrt();
    assert!(
        (identified.rms_residual_mm - deviation).abs() < 1e-7,
        "{what}: {} not {deviation}",
        identified.rms_residual_mm
    );
}

#[test]
fn noisy_sets_give_the_maximum_likelihood_estimate_and_the_cramer_rao_bound() {
    for (name, worn) in machines() {
        for (seed, count) in [(2501, 5), (2502, 10), (2503, 40)] {
            let rotations = sweep(&mut rng(seed), count, 45.0, 30.0);
            let mut poses = lengths_at(&worn, &rotations);
            add_noise(&mut poses, &mut rng(seed + 10), NOISE_MM);
            let identified = identify::<f64>(&worn, &poses).expect(name);
            let dense = reference(&worn, &poses, &rotations);
            assert_maximum_likelihood(&identified, &dense, count, 1e-5, &format!("{name}, {count} poses"));
            assert!(identified.rejected.is_empty());
            assert_eq!(identified.poses as usize, count);
        }
    }
}

#[test]
fn random_machines_give_the_maximum_likelihood_estimate() {
    let mut rng = rng(2504);
    for trial in 0..60 {
        let worn = Worn::random(&mut rng, 20.0);
        let rotations = sweep(&mut rng, 12, 45.0, 30.0);
        let mut poses = lengths_at(&worn, &rotations);
        add_noise(&mut poses, &mut rng, NOISE_MM);
        let identified = identify::<f64>(&worn, &poses).expect("a sound set");
        let dense = reference(&worn, &poses, &rotations);
        assert_maximum_likelihood(&identified, &dense, 12, 1e-5, &format!("machine {trial}"));
    }
}

#[test]
fn poses_beyond_the_singularity_are_used_and_well() {
    let mut rng = rng(2505);
    for (name, mut worn) in machines() {
        // A joint far beside the base's middle meets the singularity soonest.
        worn.centre_mm.x += 0.3 * worn.base_mm[0].norm();
        let kinematics = ForwardKinematics::new(&rig::<f64>(&worn));
        let placed = |turn: &Rotation3<f64>| {
            let pose = kinematics.solve(&as_cables(&worn.lengths_mm(turn)));
            pose.is_ok_and(|pose| (pose.origin_mm - worn.centre_mm - turn * worn.home_mm[0]).norm() < 0.1)
        };
        let mut rotations = sweep(&mut rng, 20, 45.0, 30.0);
        let beyond = sweep(&mut rng, 4000, 80.0, 60.0).into_iter().filter(|turn| !placed(turn));
        for turn in beyond.take(4) {
            rotations.insert(rng.random_range(0..=rotations.len()), turn);
        }
        assert_eq!(rotations.len(), 24, "{name}: hardly any pose beyond the singularity");
        let mut poses = lengths_at(&worn, &rotations);
        add_noise(&mut poses, &mut rng, NOISE_MM);
        let identified = identify::<f64>(&worn, &poses).expect(name);
        assert!(identified.rejected.is_empty(), "{name}: left out {:?}", identified.rejected);
        // The rotation of a pose beside the singularity settles last.
        assert_maximum_likelihood(&identified, &reference(&worn, &poses, &rotations), 24, 1e-4, name);
        let single = identify::<f32>(&worn, &poses).expect(name);
        assert!(single.rejected.is_empty(), "{name}: single precision left out {:?}", single.rejected);
    }
}

#[test]
fn without_noise_and_start_every_machine_is_found() {
    let mut rng = rng(2506);
    let mut refused = 0;
    for _ in 0..600 {
        let worn = Worn::random(&mut rng, 20.0);
        let count = rng.random_range(4..=100);
        let poses = lengths_at(&worn, &sweep(&mut rng, count, 45.0, 30.0));
        match identify::<f64>(&worn, &poses) {
            Ok(identified) => {
                let off = apart(&found(&identified), &parameters(&worn.truth()));
                assert!(off < 1e-6, "{count} poses: {off} mm off");
            }
            Err(Refusal::Weak { .. } | Refusal::OneAxis { .. } | Refusal::NotRedundant { .. }) => refused += 1,
            Err(refusal) => panic!("{count} poses: {refusal:?}"),
        }
        if count >= 6 {
            let identified = identify::<f32>(&worn, &poses).expect("a sound set");
            let off = apart(&found(&identified), &parameters(&worn.truth()));
            assert!(off < 1e-2, "single precision, {count} poses: {off} mm off");
        }
    }
    assert!(refused < 6, "{refused} of 600 refused");
}

#[test]
fn single_precision_finds_what_double_finds() {
    for (name, worn) in machines() {
        for seed in 2510..2530 {
            let poses = noisy(&worn, seed, 12);
            let double = identify::<f64>(&worn, &poses).expect(name);
            let single = identify::<f32>(&worn, &poses).expect(name);
            let off = apart(&found(&single), &found(&double));
            assert!(off < 5e-3, "{name}: {off} mm apart");
            for (mine, reference) in single.sigma_mm().iter().zip(double.sigma_mm()) {
                assert!((f64::from(*mine) / reference - 1.0).abs() < 1e-3, "{name}: {mine} or {reference}");
            }
        }
    }
}

#[test]
fn the_order_of_the_poses_is_of_no_consequence() {
    let mut rng = rng(2507);
    for (name, worn) in machines() {
        let mut poses = noisy(&worn, 2531, 25);
        poses[7][2] += 4.0;
        let first = identify::<f64>(&worn, &poses).expect(name);
        for _ in 0..10 {
            let mut order: Vec<usize> = (0..25).collect();
            order.shuffle(&mut rng);
            let shuffled: Vec<_> = order.iter().map(|&pose| poses[pose]).collect();
            let again = identify::<f64>(&worn, &shuffled).expect(name);
            assert!(apart(&found(&again), &found(&first)) < 1e-8, "{name}");
            let left_out: Vec<_> = again.rejected.iter().map(|r| (order[r.pose as usize], r.cables)).collect();
            assert_eq!(left_out, [(7, 0b100)], "{name}");
        }
    }
}

#[test]
fn the_result_moves_with_the_base_and_turns_with_it() {
    for (name, worn) in machines() {
        let poses = noisy(&worn, 2532, 15);
        let first = identify::<f64>(&worn, &poses).expect(name);
        let shift = Vector3::new(310.0, -85.0, 40.0);
        // About z, and tilted: the platform stays on the base's +z side.
        for turn in [Rotation3::from_euler_angles(0.0, 0.0, 2.2), Rotation3::from_euler_angles(0.3, -0.4, -1.0)] {
            let mut moved = worn;
            moved.base_mm = worn.base_mm.map(|point| turn * point + shift);
            moved.centre_mm = turn * worn.centre_mm + shift;
            let again = identify::<f64>(&moved, &poses).expect(name);
            let expected = turn * first.parameters.centre_mm + shift;
            assert!((again.parameters.centre_mm - expected).amax() < 1e-7, "{name}");
            let radii = again.parameters.radii_mm.iter().zip(first.parameters.radii_mm);
            assert!(radii.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-7, "{name}");
            let spread = |result: &Identified<f64>| result.worst_centre_sigma_mm().0;
            assert!(
                (spread(&again) / spread(&first) - 1.0).abs() < 1e-6,
                "{name}: the standard deviation does not turn along"
            );
        }
    }
}

#[test]
fn numbering_is_of_no_consequence() {
    for (name, worn) in machines() {
        let poses = noisy(&worn, 2533, 15);
        let first = identify::<f64>(&worn, &poses).expect(name);

        // In a mirror: clockwise numbering, the very same lengths.
        let again = identify::<f64>(&worn.mirrored(), &poses).expect(name);
        assert!((again.parameters.centre_mm - mirrored(first.parameters.centre_mm)).amax() < 1e-7, "{name}");

        // P2 becomes P1, and so on; B2 becomes B1.
        let rolled = |[a, b, c]: [Vector3<f64>; 3]| [b, c, a];
        let renamed = Worn { base_mm: rolled(worn.base_mm), home_mm: rolled(worn.home_mm), ..worn };
        let renamed_poses: Vec<_> = poses.iter().map(|l| [l[2], l[3], l[4], l[5], l[0], l[1]]).collect();
        let again = identify::<f64>(&renamed, &renamed_poses).expect(name);
        assert!((again.parameters.centre_mm - first.parameters.centre_mm).amax() < 1e-7, "{name}");
        let [p1, p2, p3] = first.parameters.radii_mm;
        let radii = again.parameters.radii_mm.iter().zip([p2, p3, p1]);
        assert!(radii.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-7, "{name}");
    }
}

#[test]
fn the_nominal_centre_is_not_looked_at() {
    for (name, worn) in machines() {
        let poses = as_poses::<f64>(&noisy(&worn, 2534, 10));
        let rig = rig::<f64>(&worn);
        let far = Parameters { centre_mm: Vector3::new(-900.0, 4000.0, 1.0), radii_mm: [3.0, 700.0, 55.0] };
        let misled = Rig::new(*rig.base_mm(), *rig.edges_mm(), *rig.drum(), NOISE_MM, far).expect(name);
        let run = |rig: &Rig<f64>| estimate(rig, &Machine::new(rig), settings(rig), &poses);
        assert_eq!(run(&rig), run(&misled), "{name}");
    }
}

/// A bound on the slices of a run: passes of the fit and of leave-one-out, and for each pose left out 21 questions in five
/// attempts.
fn most_slices(poses: usize) -> usize {
    (MAX_ITERATIONS + 20) * (poses + 48) + 105 * MAX_REJECTED
}

/// Runs in slices and counts them.
fn sliced<T: Real>(worn: &Worn, poses: &[Lengths<f64>]) -> (Result<Identified<T>, Refusal>, usize) {
    let rig = rig::<T>(worn);
    let machine = Machine::new(&rig);
    let mut estimator = Estimator::new(&machine, rig.nominal(), settings(&rig));
    let mut poses = as_poses(poses);
    let most = most_slices(poses.len());
    for slice in 1..=most {
        match estimator.advance(&machine, &mut poses) {
            Progress::Working => {}
            Progress::Identified(identified) => {
                // Asked again it says the same.
                let identified = identified.clone();
                assert_eq!(estimator.advance(&machine, &mut poses), Progress::Identified(&identified));
                return (Ok(identified), slice);
            }
            Progress::Refused(refusal) => return (Err(refusal), slice),
        }
    }
    panic!("still working after {most} slices");
}

#[test]
fn slices_give_the_same_as_one_run() {
    let mut rng = rng(2508);
    for (name, worn) in machines() {
        let clean = noisy(&worn, 2535, 30);
        let mut spoilt = clean.clone();
        for pose in [3, 11, 29] {
            spoilt[pose][rng.random_range(0..6)] += 7.0;
        }
        let mut hopeless = clean.clone();
        add_noise(&mut hopeless, &mut rng, 5.0);
        let three = clean[..3].to_vec();
        for poses in [clean, spoilt, hopeless, three] {
            let (in_slices, slices) = sliced::<f64>(&worn, &poses);
            assert_eq!(in_slices, identify(&worn, &poses), "{name}");
            assert!(slices > poses.len(), "{name}: {slices} slices for {} poses", poses.len());
            assert_eq!(sliced::<f32>(&worn, &poses).0, identify(&worn, &poses), "{name}");
        }
    }
}

#[test]
fn poses_that_were_worked_on_are_new_once_reset() {
    for (name, worn) in machines() {
        let rig = rig::<f64>(&worn);
        let machine = Machine::new(&rig);
        let mut spoilt = noisy(&worn, 2536, 30);
        spoilt[5].swap(0, 3);
        let mut poses = as_poses(&spoilt);
        let expected = estimate(&rig, &machine, settings(&rig), &poses);
        // Stopped in the middle of a run, at its end, and begun again.
        for stop in [0, 20, 60, 200, 100_000] {
            let mut estimator = Estimator::new(&machine, rig.nominal(), settings(&rig));
            for _ in 0..stop {
                if estimator.advance(&machine, &mut poses) != Progress::Working {
                    break;
                }
            }
            poses.iter_mut().for_each(Pose::reset);
            assert_eq!(poses, as_poses(&spoilt), "{name}");
            assert_eq!(estimate(&rig, &machine, settings(&rig), &poses), expected, "{name}");
        }
    }
}

#[test]
fn a_pose_placed_at_its_capture_gives_the_same_result() {
    for (name, worn) in machines() {
        let rig = rig::<f64>(&worn);
        let machine = Machine::new(&rig);
        let mut spoilt = noisy(&worn, 2537, 20);
        // Broken, not closing, and sound.
        spoilt[2][1] *= 30.0;
        spoilt[9] = spoilt[9].map(|length| length * 1.4);
        let raw = as_poses(&spoilt);
        let mut placed = raw.clone();
        placed.iter_mut().for_each(|pose| pose.place(machine.platform()));
        assert_eq!(placed[2].state, PoseState::Broken, "{name}");
        assert_eq!(placed[2].suspect_cables, 0b11, "{name}");
        assert!(placed[3].is_placed() && !placed[3].is_used(), "{name}");
        let [from_raw, from_placed] = [raw, placed].map(|poses| estimate(&rig, &machine, settings(&rig), &poses));
        assert_eq!(from_raw, from_placed, "{name}");
        assert_eq!(from_raw.expect(name).poses, 20);
    }
}

#[test]
fn a_pose_with_twice_the_variance_counts_half() {
    // Each pose twice, with twice the variance: the same estimate, the same covariance. A sample has twice the variance of
    // the rest as well: the mean of four has 1.5 times, a single one 3 times the variance of the rest.
    for (name, worn) in machines() {
        let rig = rig::<f64>(&worn);
        let rig = rig.with_noise(rig.length_noise_mm(), rig.length_noise_mm() * 2.0_f64.sqrt()).expect(name);
        let machine = Machine::new(&rig);
        let poses: Vec<_> = as_poses(&noisy(&worn, 2538, 15)).into_iter().map(|pose| pose.averaged_over(4)).collect();
        let once = estimate(&rig, &machine, settings(&rig), &poses).expect(name);
        let mut twice = [&poses[..], &poses[..]].concat();
        twice.iter_mut().for_each(|pose| pose.samples = 1);
        let again = estimate(&rig, &machine, settings(&rig), &twice).expect(name);
        assert!(apart(&found(&once), &found(&again)) < 1e-8, "{name}");
        for (one, other) in once.covariance_mm2.iter().zip(again.covariance_mm2) {
            let (one, other) = (one / once.noise_mm.powi(2), other / again.noise_mm.powi(2));
            assert!((one - other).abs() < 1e-7 * once.covariance_mm2[0] / once.noise_mm.powi(2), "{name}");
        }
    }
}

#[test]
fn the_figures_beside_the_centre_are_consistent() {
    for (name, worn) in machines() {
        let identified = identify::<f64>(&worn, &noisy(&worn, 2541, 20)).expect(name);
        assert_eq!(identified.termination, Termination::Settled);
        assert_eq!(usize::from(identified.iterations), identified.rms_residuals_mm.len());
        let last = identified.rms_residuals_mm.last().expect("a step");
        assert!((last - identified.rms_residual_mm).abs() < 1e-9, "{name}: {last} or {}", identified.rms_residual_mm);
        // Sixty lengths of 0.06 mm, fifty-four degrees of freedom out of sixty.
        assert!((0.04..0.08).contains(&identified.rms_residual_mm), "{name}: {} mm", identified.rms_residual_mm);
        assert_eq!((identified.offsets_mm, identified.offset_sigmas_mm), ([0.0; 6], [0.0; 6]));
        // Tilts to 45 degrees move any axis by a tenth of a radian at least.
        assert!((0.1..1.5).contains(&identified.excitation_rad), "{name}: {} rad", identified.excitation_rad);
    }
}
