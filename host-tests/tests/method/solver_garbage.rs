//! Whatever finite lengths come in: the solver ends, in a bounded number of slices, without a panic, and accepts nothing
//! that the lengths do not support.

use crate::common::library::{as_parameters, rig};
use crate::common::sets::{machines, noisy};
use glenoid::identification::outcome::{MOST_ITERATIONS, MOST_REJECTED};
use glenoid::identification::{Identified, Noise, Progress, Refusal, Solver, SolverSettings, Survey};
use glenoid::kinematics::CableLengths;
use glenoid::rig::Rig;
use glenoid::scalar::Real;
use host_tests::literal::Lengths;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// Runs in slices; panics when they do not end.
fn run<T: Real, const N: usize>(
    rig: &Rig<T>,
    settings: SolverSettings<T>,
    poses: &[Lengths<f64>],
) -> Result<Identified<T>, Refusal> {
    // What a length cannot be is stopped at the door: in single precision 1e-46 is zero, 1e39 infinite.
    let poses: Vec<_> = poses.iter().filter_map(|lengths| CableLengths::new(lengths.map(T::of)).ok()).collect();
    let mut survey = Survey::new(rig);
    for pose in &poses {
        let _ = survey.add(pose);
        let _ = survey.foretold();
    }
    let mut solver = Solver::<T, N>::new(rig, settings);
    for _ in 0..(MOST_ITERATIONS + 4) * (N + 1) + 22 * MOST_REJECTED {
        match solver.advance(&poses) {
            Progress::Working => {}
            Progress::Identified(identified) => return Ok(identified.clone()),
            Progress::Refused(refusal) => return Err(refusal),
        }
    }
    panic!("no end with {poses:?}");
}

fn settings<T: Real>(rig: &Rig<T>, estimate: bool) -> SolverSettings<T> {
    let noise = if estimate { Noise::EstimatedUpTo(T::of(0.5)) } else { Noise::Known(rig.length_noise_mm()) };
    SolverSettings { noise, ..SolverSettings::for_rig(rig) }
}

/// Finite numbers of an accepted result.
fn assert_whole<T: Real>(identified: &Identified<T>) {
    assert!(identified.parameters.to_array().iter().all(|x| x.is_a_number()), "{identified:?}");
    assert!(identified.sigma_mm().iter().all(|x| x.is_a_number() && *x >= T::zero()), "{identified:?}");
    assert!(identified.rejected.len() * 5 <= usize::from(identified.poses), "{identified:?}");
}

/// A length of any size from 1e-30 to 1e30 mm, mostly of a machine's size.
fn any_length() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => 50.0..600.0_f64,
        1 => (-30.0..30.0_f64).prop_map(|exponent| 10.0_f64.powf(exponent)),
        1 => Just(f64::MIN_POSITIVE),
        1 => Just(1e30),
        1 => Just(250.0),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2_000, rng_seed: RngSeed::Fixed(2801), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_lengths_are_never_accepted(
        poses in prop::collection::vec(prop::array::uniform6(any_length()), 0..24),
        which in 0..2_usize,
        estimate: bool,
    ) {
        let (_, worn) = machines()[which];
        let (double, single) = (rig::<f64>(&worn), rig::<f32>(&worn));
        prop_assert!(run::<f64, 16>(&double, settings(&double, estimate), &poses).is_err());
        prop_assert!(run::<f32, 16>(&single, settings(&single, estimate), &poses).is_err());
    }

    #[test]
    fn equal_lengths_are_never_accepted(length in any_length(), count in 3..20_usize, which in 0..2_usize) {
        let (_, worn) = machines()[which];
        let poses = vec![[length; 6]; count];
        let (double, single) = (rig::<f64>(&worn), rig::<f32>(&worn));
        prop_assert!(run::<f64, 32>(&double, settings(&double, false), &poses).is_err());
        prop_assert!(run::<f32, 32>(&single, settings(&single, false), &poses).is_err());
    }

    #[test]
    fn a_sound_set_survives_garbage_up_to_a_fifth(
        garbage in prop::collection::vec((0..30_usize, prop::array::uniform6(any_length())), 0..6),
        seed in 0..1000_u64,
        which in 0..2_usize,
    ) {
        let (_, worn) = machines()[which];
        let mut poses = noisy(&worn, seed, 30);
        for (pose, lengths) in &garbage {
            poses[*pose] = *lengths;
        }
        let truth = as_parameters::<f64>(&worn.truth()).centre_mm;
        let (double, single) = (rig::<f64>(&worn), rig::<f32>(&worn));
        let identified = run::<f64, 32>(&double, settings(&double, false), &poses);
        prop_assert!(identified.is_ok(), "{:?}", identified);
        let identified = identified.expect("just asserted");
        assert_whole(&identified);
        let (sigma, _) = identified.worst_centre_sigma_mm();
        prop_assert!((identified.parameters.centre_mm - truth).norm() < 6.0 * sigma);
        // A pose of 1e30 mm may be stopped at the door in single precision; the others remain.
        let identified = run::<f32, 32>(&single, settings(&single, false), &poses);
        prop_assert!(identified.is_ok(), "{:?}", identified);
        let identified = identified.expect("just asserted");
        assert_whole(&identified);
        let centre = identified.parameters.centre_mm.map(f64::from);
        prop_assert!((centre - truth).norm() < 6.0 * sigma);
    }

    #[test]
    fn no_setting_brings_it_down(
        values in prop::array::uniform5(prop_oneof![
            Just(f64::NAN), Just(f64::INFINITY), Just(f64::NEG_INFINITY), Just(0.0), Just(-1.0), Just(1e-30), Just(1e30), 0.0..1.0_f64
        ]),
        estimate: bool,
        seed in 0..1000_u64,
    ) {
        let (_, worn) = machines()[(seed % 2) as usize];
        let rig = rig::<f64>(&worn);
        let poses = noisy(&worn, seed, 12);
        let [noise, zero_prior_mm, tolerance_mm, sigma_limit_mm, sway] = values;
        let noise = if estimate { Noise::EstimatedUpTo(noise) } else { Noise::Known(noise) };
        let odd = SolverSettings {
            noise,
            zero_prior_mm,
            tolerance_mm,
            sigma_limit_mm,
            sway_limit_rad: sway,
            spread_limit_rad: sway,
            refuse_hanging: estimate,
        };
        if let Ok(identified) = run::<f64, 16>(&rig, odd, &poses) {
            assert_whole(&identified);
            let truth = as_parameters::<f64>(&worn.truth()).centre_mm;
            let off = (identified.parameters.centre_mm - truth).norm();
            prop_assert!(off < 6.0 * identified.worst_centre_sigma_mm().0 + 1.0, "{} mm off: {:?}", off, identified);
        }
    }
}
