//! The moving centre as a whole: shoulders are found, what only looks like one is refused by name, and so is every kind of
//! motion that is missing.

use crate::common::sets::{NOISE_MM, add_noise, normal, shoulder, sweep};
use crate::common::{Worn, library, rng};
use glenoid::identification::joint::{Joint, MissingMotion};
use glenoid::identification::{Estimator, EstimatorSettings, Machine, Refusal};
use host_tests::anatomy::Shoulder;
use host_tests::estimation::{Estimation, estimate, estimate_poses};
use host_tests::identify::held_phase;
use host_tests::literal::Lengths;
use nalgebra::{Rotation3, Vector3};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// Slides of the head that follow nothing, 1σ along each axis, mm.
const SLIDE_MM: f64 = 0.35;

/// A wearer whose centre is elsewhere by `moved` in each pose, mm.
fn readings(
    rng: &mut ChaCha8Rng,
    worn: &Worn,
    rotations: &[Rotation3<f64>],
    moved: impl Fn(&Rotation3<f64>) -> Vector3<f64>,
    slide_mm: f64,
) -> Vec<Lengths<f64>> {
    let mut poses: Vec<_> = rotations
        .iter()
        .map(|rotation| {
            let slide = Vector3::from_fn(|_, _| normal(rng)) * slide_mm;
            Worn { centre_mm: worn.centre_mm + moved(rotation) + slide, ..*worn }.lengths_mm(rotation)
        })
        .collect();
    add_noise(&mut poses, rng, NOISE_MM);
    poses
}

/// Poses that this person's shoulder can take.
fn within_reach(person: &Shoulder, rotations: Vec<Rotation3<f64>>) -> Vec<Rotation3<f64>> {
    rotations.into_iter().filter(|rotation| person.reaches(rotation)).collect()
}

/// The estimator's answer where the data choose the model.
fn by_the_data(stated: &Worn, poses: &[Lengths<f64>]) -> Estimation<f64> {
    let rig = library::rig::<f64>(stated);
    estimate(&Machine::new(&rig), &rig, EstimatorSettings::for_rig(&rig), &library::as_lengths(poses))
}

fn refusal(rng: &mut ChaCha8Rng, rotations: Vec<Rotation3<f64>>, person: u64) -> Refusal {
    let person = Shoulder::new(person, 0.0);
    let rotations = within_reach(&person, rotations);
    let poses = readings(rng, &shoulder(), &rotations, |arm| person.displacement_mm(arm), SLIDE_MM);
    by_the_data(&shoulder(), &poses).outcome.expect_err("these poses lack something")
}

/// Share of the poses that have their centre within 5 σ + 0.05 mm of the predicted one.
fn share_within(
    estimator: &Estimator<f64>,
    stated: &Worn,
    rotations: &[Rotation3<f64>],
    poses: &[Lengths<f64>],
    moved: impl Fn(&Rotation3<f64>) -> Vector3<f64>,
) -> f64 {
    let rig = library::rig::<f64>(stated);
    let machine = Machine::new(&rig);
    let is_within = |(rotation, pose): &(&Rotation3<f64>, glenoid::identification::Pose<f64>)| {
        let prediction = estimator.predict(&machine, pose).expect("a prediction");
        let error = prediction.predicted_mm - stated.centre_mm - moved(rotation);
        error.norm() <= 5.0 * prediction.predicted_covariance_mm2.trace().sqrt() + 0.05
    };
    let within = rotations.iter().zip(library::as_poses(poses)).filter(is_within).count();
    within as f64 / poses.len() as f64
}

#[test]
fn a_shoulder_is_found_in_a_machine_that_is_as_stated() {
    for seed in 0..6 {
        let mut rng = rng(4700 + seed);
        let person = Shoulder::new(seed, 0.0);
        let rotations = within_reach(&person, sweep(&mut rng, 80, 45.0, 30.0));
        let moved = |arm: &Rotation3<f64>| person.displacement_mm(arm);
        let poses = readings(&mut rng, &shoulder(), &rotations, moved, SLIDE_MM);
        let estimation = by_the_data(&shoulder(), &poses);
        assert!(estimation.outcome.is_ok(), "{seed}: {:?}", estimation.outcome);
        assert!(matches!(estimation.estimator.joint(), Joint::Moving(_)));
        let within = share_within(&estimation.estimator, &shoulder(), &rotations, &poses, moved);
        assert!(within > 0.98, "{seed}: {within}");
    }
}

/// A ball in a machine whose points are not where they are stated moves lengths as smoothly as a moving centre does.
#[test]
fn a_machine_that_is_not_as_stated_is_no_moving_joint() {
    for (seed, off_mm) in [(0, 0.5), (1, 0.5), (2, 1.0), (3, 1.0), (4, 2.0), (5, 2.0)] {
        let mut rng = rng(4720 + seed);
        let mut built = shoulder();
        for point in built.base_mm.iter_mut().chain(&mut built.home_mm) {
            *point += Vector3::from_fn(|_, _| normal(&mut rng)) * off_mm;
        }
        let rotations = sweep(&mut rng, 60, 45.0, 30.0);
        let poses = readings(&mut rng, &built, &rotations, |_| Vector3::zeros(), 0.0);
        let outcome = by_the_data(&shoulder(), &poses).outcome;
        assert_eq!(outcome.map(|_| ()), Err(Refusal::MachineNotAsStated), "{seed}");
    }
}

/// Where the centre is moved to by a rotation, mm.
type Displacement<'a> = dyn Fn(&Rotation3<f64>) -> Vector3<f64> + 'a;

/// Lengths do not show a motion of the centre along the arm, and the rule for living shoulders says nothing of these. So the
/// standard deviation must.
#[test]
fn motion_along_the_arm_is_within_its_bar() {
    let tilt = |arm: &Rotation3<f64>| (arm * Vector3::z()).z.clamp(-1.0, 1.0).acos().to_degrees() / 45.0;
    let aside = |arm: &Rotation3<f64>| {
        let along = arm * Vector3::z();
        Vector3::new(along.x, along.y, 0.0).normalize() * (4.0 * tilt(arm))
    };
    let up = |arm: &Rotation3<f64>| Vector3::z() * (2.0 * tilt(arm));
    let with_the_arm = |arm: &Rotation3<f64>| arm * Vector3::z() * (2.0 * tilt(arm));
    let motions: [(&str, &Displacement<'_>); 3] = [("aside", &aside), ("up", &up), ("with the arm", &with_the_arm)];
    let mut accepted = 0;
    for (name, moved) in motions {
        for seed in 0..5 {
            let mut rng = rng(4740 + seed);
            let rotations = sweep(&mut rng, 60, 45.0, 30.0);
            let poses = readings(&mut rng, &shoulder(), &rotations, moved, 0.0);
            let estimation = by_the_data(&shoulder(), &poses);
            if estimation.outcome.is_err() {
                continue;
            }
            accepted += 1;
            let within = share_within(&estimation.estimator, &shoulder(), &rotations, &poses, moved);
            assert!(within > 0.98, "{name}, {seed}: {within}");
        }
    }
    assert!(accepted >= 5, "{accepted}");
}

/// The arm in one plane only: about one axis, and about its own length.
fn in_one_plane(rng: &mut ChaCha8Rng, count: usize) -> Vec<Rotation3<f64>> {
    let mut one = || {
        let (tilt, torsion) = (rng.random_range(-40f64..40.0), rng.random_range(-30f64..30.0));
        Rotation3::new(Vector3::new(0.6, 0.8, 0.0) * tilt.to_radians())
            * Rotation3::new(Vector3::z() * torsion.to_radians())
    };
    (0..count).map(|_| one()).collect()
}

#[test]
fn motion_that_is_missing_is_named() {
    for seed in 0..4 {
        let mut rng = rng(4760 + seed);
        let plane = in_one_plane(&mut rng, 60);
        let Refusal::MissingMotion { missing: MissingMotion::SecondPlane, direction, .. } =
            refusal(&mut rng, plane, seed)
        else {
            panic!("{seed}: one plane is not named");
        };
        // The arm tilts about (0.6, 0.8, 0), so it never leans that way.
        let along = Vector3::from(direction).dot(&Vector3::new(0.6, 0.8, 0.0)).abs();
        assert!(along > 0.97, "{seed}: {direction:?}");

        let straight = sweep(&mut rng, 60, 45.0, 2.0);
        let found = refusal(&mut rng, straight, seed);
        assert!(matches!(found, Refusal::MissingMotion { missing: MissingMotion::Torsion, .. }), "{seed}: {found:?}");

        let upright = sweep(&mut rng, 60, 9.0, 30.0);
        let found = refusal(&mut rng, upright, seed);
        assert!(matches!(found, Refusal::MissingMotion { missing: MissingMotion::Tilt, .. }), "{seed}: {found:?}");

        let few = sweep(&mut rng, 16, 45.0, 30.0);
        let found = refusal(&mut rng, few, seed);
        let are_few = matches!(
            found,
            Refusal::TooFewForMovingCentre { .. } | Refusal::CentreNotFixed { .. } | Refusal::TooManyOutliers { .. }
        );
        assert!(are_few, "{seed}: {found:?}");
    }
}

#[test]
fn a_held_phase_that_was_not_held_or_is_of_another_wearing_is_named() {
    let rig = library::rig::<f64>(&shoulder());
    let (machine, settings) = (Machine::new(&rig), EstimatorSettings::for_rig(&rig));
    for seed in 0..4 {
        let mut rng = rng(4780 + seed);
        let person = Shoulder::new(seed, 0.0);
        let moved = |share: f64| move |arm: &Rotation3<f64>| Shoulder::new(seed, 0.0).displacement_mm(arm) * share;
        let still = within_reach(&person, sweep(&mut rng, 24, 30.0, 30.0));
        let loose = readings(&mut rng, &shoulder(), &still, moved(0.6), SLIDE_MM);
        let found = held_phase::identify(&machine, &rig, settings, library::as_poses(&loose));
        assert!(matches!(found, Err(Refusal::NotHeld { .. })), "{seed}: {found:?}");

        // The same person with the cuff 20 mm elsewhere.
        let mut other = shoulder();
        other.home_mm.iter_mut().for_each(|point| *point += Vector3::new(12.0, -14.0, 8.0));
        let held = readings(&mut rng, &other, &still, moved(0.1), SLIDE_MM);
        let held = held_phase::identify(&machine, &rig, settings, library::as_poses(&held)).expect("a held phase");
        let free = within_reach(&person, sweep(&mut rng, 80, 45.0, 30.0));
        let free = readings(&mut rng, &shoulder(), &free, moved(1.0), SLIDE_MM);
        let found = estimate_poses(&machine, &rig, settings, Some(held), library::as_poses(&free)).outcome;
        assert!(matches!(found, Err(Refusal::HeldOfAnotherWearing { .. })), "{seed}: {found:?}");
    }
}

/// Held poses of which three are misread have no scatter on which the passes would settle.
#[test]
fn held_poses_that_contradict_the_others_are_too_many_outliers() {
    let rig = library::rig::<f64>(&shoulder());
    let (machine, settings) = (Machine::new(&rig), EstimatorSettings::for_rig(&rig));
    for seed in 0..8 {
        let mut rng = rng(4790 + seed);
        let person = Shoulder::new(seed, 0.0);
        let still = within_reach(&person, sweep(&mut rng, 24, 30.0, 30.0));
        let moved = |arm: &Rotation3<f64>| Shoulder::new(seed, 0.0).displacement_mm(arm) * 0.1;
        let mut held = readings(&mut rng, &shoulder(), &still, moved, SLIDE_MM);
        // Of twenty, at most two may be left out.
        held.truncate(20);
        for (pose, cable) in [(1, 0), (4, 3), (12, 5)] {
            held[pose][cable] += 25.0;
        }
        let found = held_phase::identify(&machine, &rig, settings, library::as_poses(&held));
        assert!(matches!(found, Err(Refusal::TooManyOutliers { .. })), "{seed}: {found:?}");
    }
}

/// A cuff that sits askew: the arm's direction is not the platform's normal, and no length shows it. The 99 % region holds the
/// centre all the same.
#[test]
fn the_bar_holds_for_a_cuff_that_sits_askew() {
    let rig = library::rig::<f64>(&shoulder());
    let machine = Machine::new(&rig);
    let (mut covered, mut poses) = (0, 0);
    for seed in 0..24 {
        let mut rng = rng(4810 + seed);
        let person = Shoulder::new(seed, 0.0);
        let azimuth = rng.random_range(0.0..std::f64::consts::TAU);
        let cuff = Rotation3::new(Vector3::new(azimuth.cos(), azimuth.sin(), 0.0) * 8_f64.to_radians());
        let arms = within_reach(&person, sweep(&mut rng, 80, 45.0, 30.0));
        let platforms: Vec<_> = arms.iter().map(|arm| arm * cuff).collect();
        let moved = |platform: &Rotation3<f64>| person.displacement_mm(&(platform * cuff.inverse()));
        let lengths = readings(&mut rng, &shoulder(), &platforms, moved, SLIDE_MM);
        let estimation = by_the_data(&shoulder(), &lengths);
        if estimation.outcome.is_err() {
            continue;
        }
        for (platform, pose) in platforms.iter().zip(library::as_poses(&lengths)) {
            let prediction = estimation.estimator.predict(&machine, &pose).expect("a prediction");
            let error = prediction.predicted_mm - shoulder().centre_mm - moved(platform);
            let inverse = prediction.predicted_covariance_mm2.try_inverse().expect("a covariance");
            poses += 1;
            covered += i32::from(error.dot(&(inverse * error)) < 11.345);
        }
    }
    let share = f64::from(covered) / f64::from(poses);
    assert!(poses > 1000 && share > 0.97, "{share} of {poses} poses");
}
