//! Slip detection about a centre in use. Lengths come from the tests' own machine; the detector is given the true centre,
//! so that every warning is of the slip alone.

use crate::common::library::{as_cables, as_parameters, rig};
use crate::common::sets::{add_noise, normal, shoulder};
use crate::common::{Worn, rng};
use glenoid::identification::Machine;
use glenoid::identification::joint::Joint;
use glenoid::identification::machine::MachineDeviation;
use glenoid::monitor::{Cause, DetectorState, SlipDetector, Warning};
use glenoid::rig::CABLES;
use nalgebra::{Rotation3, Vector3};
use rand_chacha::ChaCha8Rng;

const NOISE_MM: f64 = 0.06;

fn detector(worn: &Worn) -> SlipDetector<f32> {
    detector_with(worn, &[0.0; CABLES])
}

fn detector_with(worn: &Worn, offsets_mm: &[f32; CABLES]) -> SlipDetector<f32> {
    let machine = Machine::new(&rig::<f32>(worn));
    let truth = as_parameters(&worn.truth());
    SlipDetector::new(&machine, &MachineDeviation::none(), &truth, offsets_mm, NOISE_MM as f32, Joint::Ball)
}

/// An arm that swings about two axes: 15 degrees a second, sampled a hundred times a second.
fn swing(sample: u32) -> Rotation3<f64> {
    let t = f64::from(sample) / 100.0;
    Rotation3::new(Vector3::new(0.4 * (0.9 * t).sin(), 0.4 * (0.7 * t + 1.0).sin(), 0.0))
        * Rotation3::new(Vector3::z() * (0.3 * (0.6 * t).sin()))
}

/// Samples of a machine and of what became of it; the first warning, and at which sample.
fn play(
    detector: &mut SlipDetector<f32>,
    random: &mut ChaCha8Rng,
    samples: core::ops::Range<u32>,
    measured: impl Fn(&Rotation3<f64>) -> [f64; CABLES],
) -> Option<(u32, Warning<f32>)> {
    for sample in samples {
        let mut poses = [measured(&swing(sample))];
        add_noise(&mut poses, random, NOISE_MM);
        if let Some(warning) = detector.sample(&as_cables(&poses[0])) {
            return Some((sample, warning));
        }
    }
    None
}

/// Sound until sample 200, then `slipped`; the warning must come within two seconds.
fn after_slip(random: &mut ChaCha8Rng, slipped: impl Fn(&Rotation3<f64>) -> [f64; CABLES]) -> Warning<f32> {
    let worn = shoulder();
    let mut detector = detector(&worn);
    assert_eq!(play(&mut detector, random, 0..200, |arm| worn.lengths_mm(arm)), None);
    assert_eq!(detector.state(), DetectorState::Quiet);
    let (sample, warning) = play(&mut detector, random, 200..400, slipped).expect("a warning within two seconds");
    assert!(sample > 200);
    assert_eq!(detector.state(), DetectorState::Warned);
    assert!(warning.chi_square[0] > 10.0 && warning.chi_square[1] < warning.chi_square[0]);
    warning
}

fn direction(random: &mut ChaCha8Rng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| normal(random)).normalize()
}

#[test]
fn a_strap_that_slips_is_named_with_distance_and_direction() {
    for seed in 0..20 {
        let mut random = rng(seed);
        let moved = direction(&mut random) * 3.0;
        let worn = Worn { centre_mm: shoulder().centre_mm + moved, ..shoulder() };
        match after_slip(&mut random, |arm| worn.lengths_mm(arm)).cause {
            Cause::StrapSlipped(found) => {
                let found = found.map(f64::from);
                assert!(found.angle(&moved).to_degrees() < 15.0, "seed {seed}: {found} {moved}");
                assert!((found.norm() - 3.0).abs() < 0.3, "seed {seed}: {found}");
            }
            other => panic!("seed {seed}: {other:?}"),
        }
    }
}

#[test]
fn each_cable_that_slips_is_named_with_its_error() {
    for cable in 0..CABLES {
        for error_mm in [2.0, -2.0] {
            let warning = after_slip(&mut rng(cable as u64), |arm| {
                let mut lengths = shoulder().lengths_mm(arm);
                lengths[cable] += error_mm;
                lengths
            });
            match warning.cause {
                Cause::CableSlipped { cable: named, error_mm: found } => {
                    assert_eq!(usize::from(named), cable + 1);
                    assert!((f64::from(found) - error_mm).abs() < 0.2, "{found}");
                }
                other => panic!("cable {}: {other:?}", cable + 1),
            }
        }
    }
}

#[test]
fn a_cuff_that_slips_on_the_arm_is_no_strap() {
    for seed in 0..10 {
        let mut random = rng(seed);
        let moved = direction(&mut random) * 3.0;
        let worn = Worn { home_mm: shoulder().home_mm.map(|end| end + moved), ..shoulder() };
        match after_slip(&mut random, |arm| worn.lengths_mm(arm)).cause {
            // The centre goes the other way in {P}; its z axis is that of {B} at home.
            Cause::CuffSlipped(found) => assert!((f64::from(found.z) + moved.z).abs() < 0.4, "{found} {moved}"),
            other => panic!("seed {seed}: {other:?}"),
        }
    }
}

#[test]
fn a_centre_that_moves_with_elevation_is_no_ball() {
    let per_ten_degrees = Vector3::new(1.5, 0.0, 2.0);
    let warning = after_slip(&mut rng(4), |arm| {
        let elevation = Vector3::z().angle(&(arm * Vector3::z())).to_degrees();
        let centre_mm = shoulder().centre_mm + per_ten_degrees * (elevation / 10.0);
        Worn { centre_mm, ..shoulder() }.lengths_mm(arm)
    });
    match warning.cause {
        Cause::NotABall(found) => assert!((found.map(f64::from) - per_ten_degrees).norm() < 0.7, "{found}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn an_hour_of_sound_motion_raises_no_alarm() {
    let worn = shoulder();
    assert_eq!(play(&mut detector(&worn), &mut rng(1), 0..360_000, |arm| worn.lengths_mm(arm)), None);
}

/// A slip while the arm rests is told when it moves, not from the noise of one pose.
#[test]
fn a_still_arm_raises_no_alarm() {
    let slipped = Worn { centre_mm: shoulder().centre_mm + Vector3::new(0.0, 3.0, 0.0), ..shoulder() };
    let (mut detector, mut random) = (detector(&shoulder()), rng(2));
    for _ in 0..3_000 {
        let mut poses = [slipped.lengths_mm(&swing(0))];
        add_noise(&mut poses, &mut random, 0.03);
        assert_eq!(detector.sample(&as_cables(&poses[0])), None);
    }
    assert!(play(&mut detector, &mut random, 0..200, |arm| slipped.lengths_mm(arm)).is_some());
}

#[test]
fn a_warning_is_given_once_until_the_detector_is_rearmed() {
    let slipped = Worn { centre_mm: shoulder().centre_mm + Vector3::new(2.0, 0.0, 0.0), ..shoulder() };
    let (mut detector, mut random) = (detector(&shoulder()), rng(3));
    assert!(play(&mut detector, &mut random, 0..300, |arm| slipped.lengths_mm(arm)).is_some());
    assert_eq!(play(&mut detector, &mut random, 300..1_000, |arm| slipped.lengths_mm(arm)), None);
    detector.rearm();
    assert!(play(&mut detector, &mut random, 1_000..1_300, |arm| slipped.lengths_mm(arm)).is_some());
}

/// Offsets that were found with the centre are taken off before anything is judged.
#[test]
fn known_offsets_are_no_slip() {
    let worn = shoulder();
    let offsets = [4.0, -7.0, 2.0, 9.0, -1.0, -5.0f32];
    let mut detector = detector_with(&worn, &offsets);
    let shifted = |arm: &Rotation3<f64>| {
        let lengths = worn.lengths_mm(arm);
        std::array::from_fn(|k| lengths[k] + f64::from(offsets[k]))
    };
    assert_eq!(play(&mut detector, &mut rng(6), 0..3_000, shifted), None);
}
