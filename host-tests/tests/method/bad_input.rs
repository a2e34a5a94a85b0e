//! What cannot be is refused, each with its own reason; nothing panics and nothing collected is lost.

use crate::common::library::{as_lengths, as_parameters, as_poses, rig};
use crate::common::{Worn, arm, distance, estimate, parameters, poses, rng};
use glenoid::identification::{DEFAULT_CAPACITY, Full, Identified, Pose, PoseBuffer, Progress, Refusal};
use glenoid::kinematics::{BaseEdges, CableLengths, LengthError, LengthFault};
use glenoid::paper::{PaperIteration, PaperSettings, verify};
use glenoid::rig::Parameters;
use glenoid::scalar::Real;
use host_tests::literal::Lengths;
use nalgebra::Rotation3;
use rand::Rng;

/// The machine of most tests.
fn worn() -> Worn {
    Worn::table_one(150.0)
}

/// The library's iteration with the paper's settings.
fn identify<T: Real>(poses: &[CableLengths<T>], start: Parameters<T>) -> Result<Identified<T>, Refusal> {
    PaperIteration::new(&rig(&worn()), start, PaperSettings::default()).run(poses)
}

/// A start that good poses converge from.
fn good_start<T: Real>() -> Parameters<T> {
    as_parameters::<T>(&worn().truth()).moved_by(&[4.0, -3.0, 5.0, -2.0, 3.0, 1.0].map(T::of))
}

/// Fails unless the poses still give the true centre to 0.01 mm.
fn assert_still_identified(poses: &[CableLengths<f64>]) {
    let found = identify(poses, good_start()).expect("the collected poses are still good");
    assert!(distance(&estimate(found.parameters.to_array()), &worn().truth()) < 0.01);
}

#[test]
fn fewer_than_three_poses() {
    let all = as_lengths::<f64>(&poses(&worn(), &mut rng(1), 3, 20.0));
    for count in 0..3 {
        let refusal = identify(&all[..count], good_start());
        assert_eq!(refusal, Err(Refusal::TooFewPoses { poses: count as u32 }));
    }
    assert!(!matches!(identify(&all, good_start()), Err(Refusal::TooFewPoses { .. })));
    assert_eq!(verify(&rig(&worn()), &good_start::<f64>(), &[]), Err(Refusal::TooFewPoses { poses: 0 }));
}

#[test]
fn a_full_buffer_hands_the_pose_back_and_keeps_the_others() {
    let all = as_poses::<f64>(&poses(&worn(), &mut rng(2), DEFAULT_CAPACITY + 1, 20.0));
    let (fitting, last) = all.split_at(DEFAULT_CAPACITY);
    let mut buffer = PoseBuffer::<f64>::new();
    for (index, pose) in fitting.iter().enumerate() {
        assert!(!buffer.is_full());
        assert_eq!(buffer.push(*pose), Ok(index));
    }
    assert!(buffer.is_full());
    for _ in 0..3 {
        assert_eq!(buffer.push(last[0]), Err(Full(last[0])));
        assert_eq!(buffer.as_slice(), fitting);
    }
    let lengths: Vec<_> = buffer.as_slice().iter().map(|pose: &Pose<f64>| *pose.lengths()).collect();
    assert_still_identified(&lengths);
    buffer.clear();
    assert_eq!(buffer.push(last[0]), Ok(0));
}

/// Every cable with every number that is not a length.
fn numbers_that_are_not_lengths<T: Real>() {
    let good = worn().lengths_mm(&Rotation3::identity()).map(T::of);
    let (zero, one) = (T::zero(), T::one());
    let cases = [
        (T::of(f64::NAN), LengthFault::NotFinite),
        (T::of(f64::INFINITY), LengthFault::NotFinite),
        (T::of(f64::NEG_INFINITY), LengthFault::NotFinite),
        (zero, LengthFault::NotPositive),
        (-zero, LengthFault::NotPositive),
        (-one, LengthFault::NotPositive),
        (-T::default_epsilon(), LengthFault::NotPositive),
    ];
    for cable in 0..6 {
        for (number, fault) in cases {
            let mut lengths = good;
            lengths[cable] = number;
            assert_eq!(CableLengths::new(lengths), Err(LengthError { cable: cable as u8 + 1, fault }));
            // The first bad cable is the one that is named.
            for later in &mut lengths[cable + 1..] {
                *later = -one;
            }
            assert_eq!(CableLengths::new(lengths), Err(LengthError { cable: cable as u8 + 1, fault }));
        }
    }
}

#[test]
fn lengths_that_are_not_finite_or_not_positive() {
    numbers_that_are_not_lengths::<f32>();
    numbers_that_are_not_lengths::<f64>();
}

#[test]
fn counts_that_would_wind_a_cable_past_its_end() {
    let rig = rig::<f64>(&worn());
    let drum = *rig.drum();
    let counts_to_zero = (drum.home_length_mm[0] / drum.mm_per_count()) as i32 + 1;
    for cable in 0..6 {
        let mut counts = [0; 6];
        counts[cable] = -counts_to_zero;
        let expected = LengthError { cable: cable as u8 + 1, fault: LengthFault::NotPositive };
        assert_eq!(CableLengths::from_counts(&rig, &counts), Err(expected));
        counts[cable] = 1 - counts_to_zero;
        assert!(CableLengths::from_counts(&rig, &counts).is_ok());
    }
    assert!(CableLengths::from_counts(&rig, &[i32::MAX; 6]).is_ok());
    assert!(CableLengths::from_counts(&rig, &[i32::MIN; 6]).is_err());
}

/// Both cables of each end-point too short, each longer than the other and the edge together, and squares that overflow.
fn lengths_that_break_each_triangle<T: Real>() {
    let mut good = as_lengths::<T>(&poses(&worn(), &mut rng(3), 5, 20.0));
    let base = BaseEdges::new(&rig::<T>(&worn()));
    let edge = base.as_array()[0].length_mm.to_f64();
    let beyond_squaring = 1e200_f64.min(T::max_value().unwrap_or(T::one()).to_f64() / 8.0);
    for end_point in 0..3 {
        for (first, second) in [
            (edge * 0.4, edge * 0.5),
            (edge + 201.0, 200.0),
            (200.0, edge + 201.0),
            (beyond_squaring, 200.0),
            (beyond_squaring, beyond_squaring),
        ] {
            let mut lengths = *good[2].as_mm();
            (lengths[2 * end_point], lengths[2 * end_point + 1]) = (T::of(first), T::of(second));
            let broken = CableLengths::new(lengths).expect("finite and positive");
            let (cable, fault) = (2 * end_point as u8 + 1, LengthFault::BreaksTriangle);
            assert_eq!(base.first_broken(&broken), Some(LengthError { cable, fault }), "{first} {second}");

            let kept = good[2];
            good[2] = broken;
            let expected = Refusal::BadLength { pose: 2, cable, fault };
            assert_eq!(identify(&good, good_start()).map(|found| found.parameters), Err(expected));
            assert_eq!(verify(&rig(&worn()), &good_start(), &good), Err(expected));
            good[2] = kept;
        }
    }
    assert!(identify(&good, good_start()).is_ok());
}

#[test]
fn lengths_that_break_a_triangle() {
    lengths_that_break_each_triangle::<f32>();
    lengths_that_break_each_triangle::<f64>();
}

#[test]
fn a_tetrahedron_that_does_not_close_is_named_by_pose_and_end_point() {
    let mut rng = rng(4);
    for pose in 0..6 {
        for end_point in 0..3 {
            let mut set = poses(&worn(), &mut rng, 6, 20.0);
            let good = set[pose];
            // A triangle over the base edge all right, but 400 mm up, where no radius of 140 mm reaches.
            (set[pose][2 * end_point], set[pose][2 * end_point + 1]) = (500.0, 500.0);
            let expected = Refusal::NotClosing { pose: pose as u32, end_point: end_point as u8 + 1, iteration: 0 };
            assert_eq!(identify(&as_lengths::<f64>(&set), good_start()), Err(expected));
            assert_eq!(identify(&as_lengths::<f32>(&set), good_start()), Err(expected));
            assert_eq!(verify(&rig::<f64>(&worn()), &good_start(), &as_lengths(&set)), Err(expected));
            set[pose] = good;
            assert_still_identified(&as_lengths(&set));
        }
    }
}

#[test]
fn a_start_that_is_nowhere() {
    let good = as_lengths::<f64>(&poses(&worn(), &mut rng(5), 6, 20.0));
    let truth = parameters(&worn().truth());
    let first = Refusal::NotClosing { pose: 0, end_point: 1, iteration: 0 };
    for nothing in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e200] {
        for unknown in 0..4 {
            let mut start = truth;
            start[unknown] = nothing;
            assert_eq!(identify(&good, Parameters::from_array(start)), Err(first), "{start:?}");
        }
    }
    // On the line of the first base edge no plane O-B_a-B_b exists.
    let middle = (worn().base_mm[0] + worn().base_mm[1]) / 2.0;
    let start = Parameters { centre_mm: middle, radii_mm: [140.8; 3] };
    assert_eq!(identify(&good, start), Err(first));
}

#[test]
fn poses_that_do_not_determine_the_centre() {
    let mut rng = rng(6);
    for count in [3, 10, 100] {
        let same = vec![worn().lengths_mm(&arm(&mut rng, 20.0)); count];
        let start = worn().start(&mut rng, 5.0);
        assert_eq!(identify(&as_lengths::<f64>(&same), as_parameters(&start)), Err(Refusal::Singular));
        assert_eq!(identify(&as_lengths::<f32>(&same), as_parameters(&start)), Err(Refusal::Singular));
        // The same poses count again once others join them.
        let mut more = same.clone();
        more.extend(poses(&worn(), &mut rng, 5, 20.0));
        assert_still_identified(&as_lengths(&more));
    }
}

#[test]
fn the_iteration_cap() {
    let mut rng = rng(7);
    let good = as_lengths::<f64>(&poses(&worn(), &mut rng, 6, 20.0));
    for (tolerance_mm, iteration_cap) in
        [(1e-3, 0), (1e-3, 1), (0.0, 5), (0.0, 30), (0.0, 255), (f64::NAN, 20), (-1.0, 20)]
    {
        let settings = PaperSettings { tolerance_mm, iteration_cap };
        let refusal = PaperIteration::new(&rig(&worn()), good_start(), settings).run(&good);
        assert_eq!(refusal, Err(Refusal::IterationCap), "{settings:?}");
    }
    assert_still_identified(&good);
}

/// Each cable as far as the drum can turn, and one count farther.
fn jumps<T: Real>() {
    let drum = *rig::<T>(&worn()).drum();
    let before = [-3000, 12, 0, 70_000, -5, 900];
    for elapsed_ms in [0, 1, 20, 1000] {
        let fastest = drum.fastest_mm_per_s.to_f64() * f64::from(elapsed_ms) / 1000.0;
        let per_count = core::f64::consts::TAU * drum.radius_mm.to_f64() / drum.counts_per_turn.to_f64();
        let possible = (fastest / per_count) as i32;
        for cable in 0..6 {
            for direction in [-1, 1] {
                let mut now = before;
                now[cable] += direction * (possible + 1); // the sample may fall just beside an edge
                assert_eq!(drum.check_jump(&before, &now, elapsed_ms), Ok(()));
                now[cable] += direction;
                let expected = LengthError { cable: cable as u8 + 1, fault: LengthFault::Jump };
                assert_eq!(drum.check_jump(&before, &now, elapsed_ms), Err(expected), "{elapsed_ms} ms");
            }
        }
    }
    let (low, high) = ([i32::MIN; 6], [i32::MAX; 6]);
    assert!(drum.check_jump(&low, &high, 0).is_err());
    assert!(drum.check_jump(&high, &low, 1000).is_err());
    assert_eq!(drum.check_jump(&before, &before, u32::MAX), Ok(()));
}

#[test]
fn a_count_jump_beyond_what_the_drum_can_turn() {
    jumps::<f32>();
    jumps::<f64>();
}

#[test]
fn every_reason_has_its_own_code_and_text() {
    let fault = LengthFault::Jump;
    let refusals = [
        Refusal::TooFewPoses { poses: 2 },
        Refusal::BadLength { pose: 1, cable: 2, fault },
        Refusal::NotClosing { pose: 1, end_point: 2, iteration: 3 },
        Refusal::Singular,
        Refusal::IterationCap,
    ];
    for (index, one) in refusals.iter().enumerate() {
        for other in &refusals[index + 1..] {
            assert_ne!(one.code(), other.code());
            assert_ne!(one.text(), other.text());
        }
    }
    let faults = [LengthFault::NotFinite, LengthFault::NotPositive, LengthFault::BreaksTriangle, LengthFault::Jump];
    for (index, one) in faults.iter().enumerate() {
        assert!(faults[index + 1..].iter().all(|other| one.text() != other.text()));
    }
}

/// Sets of numbers made of random bits, of random lengths, and of good poses with one random length.
fn random_poses<T: Real>(rng: &mut rand_chacha::ChaCha8Rng, kind: u32) -> Vec<CableLengths<T>> {
    let count = rng.random_range(0..8);
    let mut set: Vec<Lengths<f64>> = poses(&worn(), rng, count, 60.0);
    for length in set.as_flattened_mut() {
        match kind {
            0 => *length = f64::from(f32::from_bits(rng.random()).abs()),
            1 => *length = rng.random_range(1.0..600.0),
            _ if rng.random_ratio(1, 20) => *length += rng.random_range(-300.0..300.0),
            _ => {}
        }
    }
    set.iter().filter_map(|lengths| CableLengths::new(lengths.map(T::of)).ok()).collect()
}

/// Runs the identification slice by slice and past its end.
fn is_answered<T: Real>(poses: &[CableLengths<T>], start: Parameters<T>) {
    let mut iteration = PaperIteration::new(&rig(&worn()), start, PaperSettings::default());
    let most_slices = 31 * (poses.len() + 1);
    let mut slices = 0;
    let identified = loop {
        match iteration.advance(poses) {
            Progress::Working => slices += 1,
            Progress::Identified(identified) => break Some(identified),
            Progress::Refused(_) => break None,
        }
        assert!(slices <= most_slices, "the work is not bounded");
    };
    if let Some(identified) = identified {
        assert!(identified.parameters.to_array().iter().all(|x| x.is_a_number()));
        assert!(identified.rms_residual_mm.is_a_number());
    }
    for _ in 0..3 {
        let _ = iteration.advance(poses);
    }
}

#[test]
fn any_numbers_are_answered_and_none_panics() {
    let mut rng = rng(8);
    for trial in 0..30_000 {
        let start = worn().start(&mut rng, 100.0);
        is_answered::<f32>(&random_poses(&mut rng, trial % 3), as_parameters(&start));
        is_answered::<f64>(&random_poses(&mut rng, trial % 3), as_parameters(&start));
    }
}
