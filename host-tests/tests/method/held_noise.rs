//! The noise of a length in two parts: one averages over the samples of a held pose, the other does not. Readings are made
//! sample by sample; what the estimator makes of them is compared with the truth.

use crate::common::library::{as_cables, rig, settings};
use crate::common::rng;
use crate::common::sets::{normal, shoulder, sound};
use glenoid::identification::joint::Joint;
use glenoid::identification::machine::MachineDeviation;
use glenoid::identification::{Estimator, Identified, Machine, Pose, Refusal};
use glenoid::monitor::SlipDetector;
use glenoid::rig::Rig;
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// Friction, 1σ, and the white noise of a sample, uniform to either side, mm.
const FRICTION_MM: f64 = 0.02;
const WHITE_MM: f64 = 0.1;
/// 1σ of that, mm.
const SAMPLE_MM: f64 = 0.057_735;

/// Lengths held for so many samples: their means.
fn held(rng: &mut ChaCha8Rng, lengths: &[f64; 6], samples: u16) -> [f64; 6] {
    lengths.map(|length| {
        let white: f64 = (0..samples).map(|_| rng.random_range(-WHITE_MM..=WHITE_MM)).sum();
        length + FRICTION_MM * normal(rng) + white / f64::from(samples)
    })
}

fn stated() -> Rig<f64> {
    rig::<f64>(&shoulder()).with_noise(FRICTION_MM, SAMPLE_MM).unwrap()
}

/// Thirty poses, each held for another time, and ten more.
fn set(seed: u64) -> (Vec<Pose<f64>>, Vec<Pose<f64>>) {
    let mut rng = rng(seed);
    let mut poses: Vec<_> = sound(&shoulder(), seed, 40)
        .iter()
        .map(|lengths| {
            let samples = [8, 20, 40, 200][rng.random_range(0..4)];
            Pose::new(as_cables(&held(&mut rng, lengths, samples))).averaged_over(samples)
        })
        .collect();
    let second = poses.split_off(30);
    (poses, second)
}

fn identify(rig: &Rig<f64>, poses: &mut [Pose<f64>]) -> (Estimator<f64>, Result<Identified<f64>, Refusal>) {
    let machine = Machine::new(rig);
    let mut estimator = Estimator::new(&machine, rig.nominal(), settings(rig));
    let outcome = estimator.run(&machine, poses);
    (estimator, outcome)
}

/// Real errors over reported standard deviations, and χ² of the second poses over its degrees of freedom.
fn ratios(rig: &Rig<f64>, sets: u64) -> (f64, f64) {
    let machine = Machine::new(rig);
    let truth = shoulder().truth().centre_mm;
    let (mut errors, mut chi_square, mut verified) = (0.0, 0.0, 0.0);
    for seed in 0..sets {
        let (mut poses, second) = set(7700 + seed);
        let (estimator, found) = identify(rig, &mut poses);
        let found = found.unwrap();
        let (error, sigma) = (found.parameters.centre_mm - truth, found.sigma_mm());
        errors += (0..3).map(|k| (error[k] / sigma[k]).powi(2)).sum::<f64>() / 3.0;
        for pose in &second {
            chi_square += estimator.verify(&machine, pose).unwrap().chi_square / 3.0;
            verified += 1.0;
        }
    }
    ((errors / sets as f64).sqrt(), chi_square / verified)
}

/// 600 errors and 2 000 poses: ±3 %, ±2 %.
#[test]
fn the_standard_deviation_and_the_second_set_go_by_the_poses_own_noise() {
    let (ratio, chi_square) = ratios(&stated(), 200);
    assert!((0.91..1.09).contains(&ratio), "{ratio}");
    assert!((0.93..1.07).contains(&chi_square), "{chi_square}");
    // Taken for noise that no pose averages, the standard deviation is more than twice too large; left out, sound sets are refused.
    let (wide, chi_square) = ratios(&rig::<f64>(&shoulder()), 40);
    assert!(wide < 0.55 && chi_square < 0.3, "{wide} {chi_square}");
    let frictional = stated().with_noise(FRICTION_MM, 0.0).unwrap();
    let refused = (0..40).filter(|seed| identify(&frictional, &mut set(7700 + seed).0).1.is_err()).count();
    // Of sound sets one in 10 000 is.
    assert!(refused >= 3, "{refused}");
}

/// A reading that is wrong by 0.35 mm is an outlier of a pose held for long, and noise of one that was
/// not.
#[test]
fn an_outlier_is_judged_by_the_poses_own_noise() {
    let wrong = |samples: u16| {
        let rig = stated();
        (0..20)
            .filter(|seed| {
                let mut rng = rng(7900 + seed);
                let mut poses = Vec::new();
                for (index, lengths) in sound(&shoulder(), 7900 + seed, 30).iter().enumerate() {
                    let samples = if index == 11 { samples } else { 40 };
                    let mut lengths = held(&mut rng, lengths, samples);
                    lengths[2] += if index == 11 { 0.35 } else { 0.0 };
                    poses.push(Pose::new(as_cables(&lengths)).averaged_over(samples));
                }
                let found = identify(&rig, &mut poses).1.unwrap();
                found.rejected.iter().any(|rejected| rejected.pose == 11)
            })
            .count()
    };
    let (long, short) = (wrong(200), wrong(1));
    assert!(long >= 15 && short <= 4, "{long} and {short} of 20");
}

/// The slip detector goes by single samples: χ² is about one for each degree of freedom.
#[test]
fn the_slip_detector_goes_by_single_samples() {
    let watch = |rig: &Rig<f64>| {
        let mut rng = rng(7950);
        let (machine, found) = (Machine::new(rig), *rig.nominal());
        let mut detector = SlipDetector::new(
            &machine,
            &MachineDeviation::none(),
            &found,
            &[0.0; 6],
            rig.length_noise_mm(),
            Joint::Ball,
        );
        let (mut sum, mut count, mut alarms) = (0.0, 0.0, 0);
        for step in 0..3_000 {
            let angle = f64::from(step) * 0.01;
            let turn =
                nalgebra::Rotation3::from_euler_angles(0.5 * angle.sin(), 0.4 * (1.3 * angle).cos(), 0.3 * angle.sin());
            let lengths = held(&mut rng, &shoulder().lengths_mm(&turn), 1);
            alarms += usize::from(detector.sample(&as_cables(&lengths)).is_some());
            if step > 100 {
                sum += detector.chi_square();
                count += 1.0;
            }
        }
        (sum / count, alarms)
    };
    let (chi_square, alarms) = watch(&stated());
    assert!((0.8..1.2).contains(&chi_square) && alarms == 0, "{chi_square} {alarms}");
    let (chi_square, _) = watch(&stated().with_noise(FRICTION_MM, 0.0).unwrap());
    assert!(chi_square > 5.0, "{chi_square}");
}

/// A rig that does not tell the two apart: whatever the number of samples, to the bit as without one.
#[test]
fn without_noise_that_averages_the_samples_do_not_matter() {
    let rig = rig::<f64>(&shoulder());
    let (mut poses, _) = set(7990);
    assert!(poses.iter().any(|pose| pose.samples == 200));
    let mut plain: Vec<_> = poses.iter().map(|pose| Pose::new(*pose.lengths())).collect();
    assert_eq!(identify(&rig, &mut poses).1, identify(&rig, &mut plain).1);
}

#[test]
fn impossible_noise_is_refused() {
    let rig = stated();
    for (length, sample) in
        [(0.0, 0.1), (-0.1, 0.1), (0.1, -0.1), (f64::NAN, 0.1), (0.1, f64::NAN), (0.1, f64::INFINITY)]
    {
        assert_eq!(rig.with_noise(length, sample), Err(glenoid::rig::RigError::NoiseNotPositive), "{length} {sample}");
    }
}
