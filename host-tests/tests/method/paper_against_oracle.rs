//! The library's closed form against the paper written out the long way: the same model, the same iterates, the same
//! refusals, over random machines, poses and starts.

use crate::common::differences::{central_differences, flattest_mm, relative_difference};
use crate::common::library::{as_cables, as_lengths, as_parameters, rig};
use crate::common::{Worn, arm, distance, one_axis, oracle, parameters, poses, rng};
use glenoid::identification::{Identified, Refusal, Termination};
use glenoid::kinematics::BaseEdges;
use glenoid::paper::model::{Contradiction, Model, NotClosing};
use glenoid::paper::{PaperIteration, PaperSettings, verify};
use glenoid::scalar::Real;
use host_tests::literal::{Ending, Estimate, Failure, Lengths, pose_model, root_mean_square};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// The library's Y and D of one pose.
fn library_model<T: Real>(
    worn: &Worn,
    at: &Estimate<f64>,
    lengths: &Lengths<f64>,
) -> Result<([T; 3], [[T; 6]; 3]), Contradiction> {
    let rig = rig::<T>(worn);
    let base = BaseEdges::new(&rig);
    let parameters = as_parameters(at);
    let model = Model::new(&base, rig.edges_mm(), &parameters);
    let pose = model.evaluate(&base, &as_cables(lengths))?;
    Ok((pose.residuals_mm, model.rows(&base, &parameters.radii_mm, &pose)))
}

/// The library's iteration.
fn library_run<T: Real>(
    worn: &Worn,
    poses: &[Lengths<f64>],
    start: &Estimate<f64>,
    tolerance_mm: f64,
    iteration_cap: u8,
) -> Result<Identified<T>, Refusal> {
    let settings = PaperSettings { tolerance_mm: T::of(tolerance_mm), iteration_cap };
    PaperIteration::new(&rig(worn), as_parameters(start), settings).run(&as_lengths(poses))
}

/// Every length off by up to `noise_mm`, uniformly.
fn add_noise(poses: &mut [Lengths<f64>], rng: &mut ChaCha8Rng, noise_mm: f64) {
    for length in poses.as_flattened_mut() {
        *length += rng.random_range(-noise_mm..=noise_mm);
    }
}

#[test]
fn d_and_y_equal_the_appendix_and_the_differences() {
    let mut rng = rng(101);
    let (mut closed, mut open, mut flat) = (0, 0, 0);
    while closed < 10_000 {
        let worn = Worn::random(&mut rng, 20.0);
        let (machine, start) = (worn.machine(), worn.start(&mut rng, 50.0));
        let lengths = worn.lengths_mm(&arm(&mut rng, 30.0));
        match (library_model::<f64>(&worn, &start, &lengths), pose_model(&machine, &start, &lengths, 0)) {
            (Ok((residuals_mm, rows)), Ok(literal)) => {
                closed += 1;
                let off = relative_difference(&rows, &literal.d);
                assert!(off < 1e-8, "D is off the Appendix by {off}: {worn:?} {start:?} {lengths:?}");
                for (mine, printed) in residuals_mm.iter().zip(literal.y_mm) {
                    assert!((mine - printed).abs() < 1e-9, "Y: {mine} instead of {printed}");
                }
                if flattest_mm(&machine, &start, &literal) < 1.0 {
                    flat += 1; // the derivative is next to infinite: no step is small enough
                    continue;
                }
                let expected = central_differences(&machine, &start, &lengths).expect("closes all around");
                let off = relative_difference(&rows, &expected);
                assert!(off < 1e-8, "D is off the differences by {off}: {worn:?} {start:?} {lengths:?}");
            }
            (
                Err(Contradiction::NotClosing(NotClosing { end_point: from_one })),
                Err(Failure::DoesNotClose { end_point, .. }),
            ) => {
                assert_eq!(usize::from(from_one), end_point + 1);
                open += 1;
            }
            (library, literal) => panic!("{library:?} but {literal:?}"),
        }
    }
    assert!(open > 500, "too few that do not close ({open}) to compare their end-points");
    assert!(flat < 50, "{flat} poses too flat to compare with differences");
}

#[test]
fn the_whole_iteration_is_the_same() {
    let mut rng = rng(102);
    let (mut by_deviation, mut by_step, mut open) = (0, 0, 0);
    for trial in 0..10_000 {
        let worn = Worn::random(&mut rng, 20.0);
        let start = worn.start(&mut rng, 30.0);
        let count = rng.random_range(3..=20);
        let mut lengths = poses(&worn, &mut rng, count, 30.0);
        if trial % 2 == 1 {
            add_noise(&mut lengths, &mut rng, 0.1);
        }
        let library = library_run::<f64>(&worn, &lengths, &start, 1e-3, 15);
        // With noise δE stays above ε; the library ends when a step is below ε, the paper does not end at all.
        let cap = library.as_ref().map_or(15, |found| usize::from(found.iterations));
        let (literal, deviations) = oracle::run(&worn.machine(), &lengths, start, 1e-3, cap);
        match (&library, literal.ending) {
            (Ok(found), Ending::Converged | Ending::IterationCap) => {
                match found.termination {
                    Termination::DeviationBelowTolerance => {
                        assert_eq!(literal.ending, Ending::Converged);
                        by_deviation += 1;
                    }
                    Termination::Settled => {
                        assert_eq!(literal.ending, Ending::IterationCap);
                        assert_is_first_small_step(&worn, &lengths, start, cap, 1e-3);
                        by_step += 1;
                    }
                }
                assert_eq!(usize::from(found.iterations), literal.iterations);
                assert_eq!(found.rms_residuals_mm.len(), deviations.len());
                assert_eq!(Some(&found.rms_residual_mm), found.rms_residuals_mm.last());
                for (mine, printed) in found.rms_residuals_mm.iter().zip(&deviations) {
                    assert!((mine - printed).abs() < 1e-8 * (1.0 + printed), "δE {mine} instead of {printed}");
                }
                for (mine, printed) in found.parameters.to_array().iter().zip(parameters(&literal.estimate)) {
                    assert!((mine - printed).abs() < 1e-8, "{mine} mm instead of {printed} mm");
                }
            }
            (
                Err(Refusal::NotClosing { pose, end_point: from_one, iteration }),
                Ending::Failed(Failure::DoesNotClose { pose: expected_pose, end_point }),
            ) => {
                assert_eq!(*pose as usize, expected_pose);
                assert_eq!(usize::from(*from_one), end_point + 1);
                assert_eq!(usize::from(*iteration), literal.iterations);
                open += 1;
            }
            (library, literal) => panic!("{library:?} but {literal:?}"),
        }
    }
    assert!(by_deviation > 2000 && by_step > 2000 && open > 1000, "{by_deviation} {by_step} {open}");
}

/// Fails unless the literal step number `last` is the first that moves no parameter by as much as `tolerance_mm`.
fn assert_is_first_small_step(
    worn: &Worn,
    poses: &[Lengths<f64>],
    start: Estimate<f64>,
    last: usize,
    tolerance_mm: f64,
) {
    let after = |steps: usize| oracle::run(&worn.machine(), poses, start, 0.0, steps).0.estimate;
    for step in 1..=last {
        let small = distance(&after(step), &after(step - 1)) < tolerance_mm;
        assert_eq!(small, step == last, "step {step} of {last}");
    }
}

#[test]
fn the_cap_is_reached_at_the_same_step() {
    let mut rng = rng(103);
    let worn = Worn::table_one(350.0);
    for cap in 0..=3 {
        for _ in 0..100 {
            let (lengths, start) = (poses(&worn, &mut rng, 6, 30.0), worn.start(&mut rng, 40.0));
            let (free, deviations) = oracle::run(&worn.machine(), &lengths, start, 1e-3, 15);
            if free.ending != Ending::Converged || free.iterations <= usize::from(cap) {
                continue;
            }
            assert_eq!(library_run::<f64>(&worn, &lengths, &start, 1e-3, cap), Err(Refusal::IterationCap));
            // One more step than the cap allows, and exactly as many, give the same answer as no cap at all.
            for enough in [free.iterations, free.iterations + 1] {
                let found = library_run::<f64>(&worn, &lengths, &start, 1e-3, enough as u8).expect("enough steps");
                assert_eq!(found.rms_residuals_mm.len(), deviations.len());
            }
        }
    }
}

#[test]
fn one_pose_many_times_is_singular_in_both() {
    let mut rng = rng(104);
    for count in [3, 5, 10, 100] {
        for _ in 0..100 {
            let worn = Worn::random(&mut rng, 20.0);
            let lengths = vec![worn.lengths_mm(&arm(&mut rng, 20.0)); count];
            // ε = 0 is never reached, so that a step is tried even at the truth.
            let library = library_run::<f64>(&worn, &lengths, &worn.truth(), 0.0, 5);
            assert_eq!(library, Err(Refusal::Singular), "{count} poses");
            let (literal, _) = oracle::run(&worn.machine(), &lengths, worn.truth(), 0.0, 5);
            assert_eq!(literal.ending, Ending::Failed(Failure::SingularNormalMatrix), "{count} poses");
        }
    }
}

#[test]
fn poses_about_one_axis_are_singular_in_both() {
    let mut rng = rng(107);
    for count in [3, 10, 100] {
        for _ in 0..300 {
            let worn = Worn::random(&mut rng, 20.0);
            let lengths = one_axis(&worn, &mut rng, count, 20.0);
            // At the truth, where D has rank five exactly.
            let library = library_run::<f64>(&worn, &lengths, &worn.truth(), 0.0, 5);
            assert_eq!(library, Err(Refusal::Singular), "{count} poses");
            let (literal, _) = oracle::run(&worn.machine(), &lengths, worn.truth(), 0.0, 5);
            assert_eq!(literal.ending, Ending::Failed(Failure::SingularNormalMatrix), "{count} poses");
        }
    }
}

#[test]
fn poses_about_one_axis_are_never_identified_though_their_deviation_vanishes() {
    let mut rng = rng(108);
    let mut vanished = 0;
    for trial in 0..3000 {
        let worn = Worn::random(&mut rng, 20.0);
        let lengths = one_axis(&worn, &mut rng, [3, 10, 100][trial % 3], 30.0);
        let start = worn.start(&mut rng, 10.0);
        let library = library_run::<f64>(&worn, &lengths, &start, 1e-3, 20);
        assert!(matches!(library, Err(Refusal::Singular | Refusal::NotClosing { .. })), "{library:?}");
        let (literal, _) = oracle::run(&worn.machine(), &lengths, start, 1e-3, 20);
        vanished += usize::from(literal.ending == Ending::Converged);
    }
    assert!(vanished > 500, "{vanished} of 3000 end with the paper's δE below its ε");
}

#[test]
fn the_deviation_of_a_second_set_is_the_same() {
    let mut rng = rng(105);
    for _ in 0..1000 {
        let worn = Worn::random(&mut rng, 20.0);
        let mut lengths = poses(&worn, &mut rng, 10, 25.0);
        add_noise(&mut lengths, &mut rng, 0.1);
        let at = worn.start(&mut rng, 5.0);
        let models: Result<Vec<_>, _> =
            lengths.iter().enumerate().map(|(pose, l)| pose_model(&worn.machine(), &at, l, pose)).collect();
        match (verify(&rig(&worn), &as_parameters(&at), &as_lengths::<f64>(&lengths)), models) {
            (Ok(mine), Ok(models)) => {
                let residues: Vec<f64> = models.iter().flat_map(|model| model.y_mm).collect();
                assert!((mine - root_mean_square(&residues)).abs() < 1e-9);
            }
            (
                Err(Refusal::NotClosing { pose, end_point: from_one, .. }),
                Err(Failure::DoesNotClose { pose: expected_pose, end_point }),
            ) => {
                assert_eq!((pose as usize, usize::from(from_one)), (expected_pose, end_point + 1));
            }
            (library, literal) => panic!("{library:?} but {literal:?}"),
        }
    }
}

#[test]
fn single_precision_stays_close() {
    let mut rng = rng(106);
    let (mut identified, mut refused) = (0, 0);
    for _ in 0..10_000 {
        let worn = Worn::random(&mut rng, 20.0);
        let start = worn.start(&mut rng, 20.0);
        let count = rng.random_range(6..=20);
        let mut lengths = poses(&worn, &mut rng, count, 25.0);
        add_noise(&mut lengths, &mut rng, 0.1);
        let double = library_run::<f64>(&worn, &lengths, &start, 1e-3, 15);
        let single = library_run::<f32>(&worn, &lengths, &start, 1e-3, 15);
        match (double, single) {
            (Ok(double), Ok(single)) => {
                identified += 1;
                for (exact, rounded) in double.parameters.to_array().iter().zip(single.parameters.to_array()) {
                    assert!((exact - f64::from(rounded)).abs() < 1e-3, "{rounded} mm instead of {exact} mm");
                }
                // On the way a flat tetrahedron magnifies the rounding.
                for (exact, rounded) in double.rms_residuals_mm.iter().zip(&single.rms_residuals_mm) {
                    assert!((exact - f64::from(*rounded)).abs() < 0.02 * (1.0 + exact), "δE {rounded} for {exact}");
                }
            }
            (Err(double), Err(single)) => {
                refused += 1;
                assert_eq!(double, single);
            }
            (double, single) => panic!("{double:?} but {single:?}"),
        }
    }
    assert!(identified > 8000 && refused > 100, "{identified} {refused}");
}
