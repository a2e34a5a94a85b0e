//! Whatever finite lengths come in: the estimator ends, in a bounded number of slices, without a panic, and accepts nothing
//! that the lengths do not support.

use crate::common::library::{self, as_parameters, rig};
use crate::common::sets::{machines, noisy};
use glenoid::identification::outcome::{MAX_ITERATIONS, MAX_REJECTED};
use glenoid::identification::{
    Estimator, EstimatorSettings, Identified, JointChoice, Machine, Noise, Pose, PredictedAccuracy, Progress, Refusal,
};
use glenoid::kinematics::CableLengths;
use glenoid::rig::Rig;
use glenoid::scalar::Real;
use host_tests::literal::Lengths;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// Runs in slices; panics when they do not end.
fn run<T: Real>(
    rig: &Rig<T>,
    machine: &Machine<T>,
    settings: EstimatorSettings<T>,
    poses: &[Lengths<f64>],
) -> Result<Identified<T>, Refusal> {
    // What a length cannot be is stopped at the door: in single precision 1e-46 is zero, 1e39 infinite.
    let lengths = poses.iter().filter_map(|lengths| CableLengths::new(lengths.map(T::of)).ok());
    let mut poses: Vec<_> = lengths.map(Pose::new).collect();
    let mut accuracy = PredictedAccuracy::new(machine, rig.nominal());
    for lengths in poses.iter().map(Pose::lengths) {
        if let Ok(pose) = Pose::placed(machine.platform(), *lengths) {
            accuracy.add(machine, &pose);
        }
        let _ = accuracy.predicted(machine);
    }
    let mut estimator = Estimator::new(machine, rig.nominal(), settings);
    for _ in 0..(MAX_ITERATIONS + 20) * (poses.len() + 48) + 105 * MAX_REJECTED {
        match estimator.advance(machine, &mut poses) {
            Progress::Working => {}
            Progress::Identified(identified) => return Ok(identified.clone()),
            Progress::Refused(refusal) => return Err(refusal),
        }
    }
    panic!("no end with {poses:?}");
}

fn settings<T: Real>(rig: &Rig<T>, estimate: bool) -> EstimatorSettings<T> {
    let noise = if estimate { Noise::EstimatedUpTo(T::of(0.5)) } else { Noise::Known(rig.length_noise_mm()) };
    EstimatorSettings { noise, ..library::settings(rig) }
}

/// Finite numbers of an accepted result.
fn assert_whole<T: Real>(identified: &Identified<T>) {
    assert!(identified.parameters.to_array().iter().all(|x| x.is_a_number()), "{identified:?}");
    assert!(identified.sigma_mm().iter().all(|x| x.is_a_number() && *x >= T::zero()), "{identified:?}");
    assert!(identified.rejected.len() * 5 <= identified.poses as usize, "{identified:?}");
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
        prop_assert!(run(&double, &Machine::new(&double), settings(&double, estimate), &poses).is_err());
        prop_assert!(run(&single, &Machine::new(&single), settings(&single, estimate), &poses).is_err());
    }

    #[test]
    fn equal_lengths_are_never_accepted(length in any_length(), count in 3..20_usize, which in 0..2_usize) {
        let (_, worn) = machines()[which];
        let poses = vec![[length; 6]; count];
        let (double, single) = (rig::<f64>(&worn), rig::<f32>(&worn));
        prop_assert!(run(&double, &Machine::new(&double), settings(&double, false), &poses).is_err());
        prop_assert!(run(&single, &Machine::new(&single), settings(&single, false), &poses).is_err());
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
        let identified = run(&double, &Machine::new(&double), settings(&double, false), &poses);
        prop_assert!(identified.is_ok(), "{:?}", identified);
        let identified = identified.expect("just asserted");
        assert_whole(&identified);
        let (sigma, _) = identified.worst_centre_sigma_mm();
        prop_assert!((identified.parameters.centre_mm - truth).norm() < 6.0 * sigma);
        // A pose of 1e30 mm may be stopped at the door in single precision; the others remain.
        let identified = run(&single, &Machine::new(&single), settings(&single, false), &poses);
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
        let [noise, offset_prior_mm, tolerance_mm, sigma_limit_mm, excitation] = values;
        let noise = if estimate { Noise::EstimatedUpTo(noise) } else { Noise::Known(noise) };
        let odd = EstimatorSettings {
            noise,
            joint: JointChoice::Ball,
            tolerance_mm,
            sigma_limit_mm,
            excitation_limit_rad: excitation,
            spread_limit_rad: excitation,
            require_redundancy: estimate,
        };
        if let Ok(identified) = run(&rig, &Machine::with_offset_prior(&rig, offset_prior_mm), odd, &poses) {
            assert_whole(&identified);
            let truth = as_parameters::<f64>(&worn.truth()).centre_mm;
            let off = (identified.parameters.centre_mm - truth).norm();
            prop_assert!(off < 6.0 * identified.worst_centre_sigma_mm().0 + 1.0, "{} mm off: {:?}", off, identified);
        }
    }
}
