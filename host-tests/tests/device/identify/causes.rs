//! Causes told apart: each is put into the lengths of the virtual wearer, and must be named with its cable, its pose and
//! its size. The machine is off by its stated tolerances as well.

use glenoid::identification::Machine;
use glenoid::kinematics::CableLengths;
use glenoid::rig::{CABLES, Rig, Tolerance};
use host_tests::identify::causes::{Cause, CauseKind, contradiction, find};
use host_tests::rehearse::KnownMachine;
use host_tests::wearer::{Cables, FittedArm};
use nalgebra::{Rotation3, Vector3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

const POSES: usize = 40;
const NOISE_MM: f64 = 0.0577;

/// A wearer in a machine that is off as stated, and what it would read without noise.
struct Log {
    stated: Rig<f64>,
    home_mm: [f64; CABLES],
    readings: Vec<[f64; CABLES]>,
    rotations: Vec<Rotation3<f64>>,
}

fn symmetric(random: &mut ChaCha8Rng, limit: f64) -> f64 {
    random.random_range(-limit..=limit)
}

fn vector(random: &mut ChaCha8Rng, limit: f64) -> Vector3<f64> {
    Vector3::from_fn(|_, _| symmetric(random, limit))
}

/// `centre`: where the joint centre is in a pose, from where it is at home, mm.
fn log(
    seed: u64,
    built: impl Fn(Rig<f64>) -> Rig<f64>,
    centre: impl Fn(usize, &Rotation3<f64>) -> Vector3<f64>,
) -> Log {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let stated = Rig::shoulder(150.0).unwrap().with_tolerance(Tolerance::hand_built()).unwrap();
    let known = KnownMachine::built_in(stated, Rig::shoulder(150.0).unwrap());
    let built = built(known.as_built(Some(0.5), seed).unwrap());
    let arm = FittedArm::new(&built, vector(&mut random, 20.0), vector(&mut random, 10.0));
    let home_mm = stated.drum().home_length_mm;
    let truth = *built.correction().unwrap();
    let rotations: Vec<_> = (0..POSES)
        .map(|_| {
            let azimuth: f64 = random.random_range(0.0..std::f64::consts::TAU);
            let tilt = random.random_range(0.0..=45f64.to_radians());
            let across = Vector3::new(azimuth.cos(), azimuth.sin(), 0.0);
            Rotation3::new(across * tilt) * Rotation3::new(Vector3::z() * symmetric(&mut random, 30f64.to_radians()))
        })
        .collect();
    let read = |(index, rotation): (usize, &Rotation3<f64>)| {
        let centre_mm = arm.centre_mm() + centre(index, rotation);
        let lengths = Cables::new(&built).lengths_mm(&arm.ends_mm().map(|end| centre_mm + rotation * end));
        std::array::from_fn(|k| home_mm[k] + truth.scale[k] * (lengths[k] - home_mm[k]) + truth.offset_mm[k])
    };
    let readings = rotations.iter().enumerate().map(read).collect();
    Log { stated, home_mm, readings, rotations }
}

fn plain(seed: u64) -> Log {
    log(seed, |rig| rig, |_, _| Vector3::zeros())
}

impl Log {
    fn lengths(&self, seed: u64) -> Vec<CableLengths<f64>> {
        let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0xABCD);
        let noisy =
            |reading: &[f64; CABLES]| CableLengths::new(reading.map(|mm| mm + symmetric(&mut random, 0.1))).unwrap();
        self.readings.iter().map(noisy).collect()
    }

    fn cause(&self, seed: u64) -> Option<Cause> {
        let causes = find(&self.stated, &Machine::new(&self.stated), &self.lengths(seed), NOISE_MM)?;
        assert_eq!(causes.or, None, "{causes:?}");
        Some(causes.best)
    }
}

/// Ten machines each, the cable by the seed.
fn each(mut check: impl FnMut(u64, usize)) {
    (0..10).for_each(|seed| check(seed, seed as usize % CABLES));
}

#[test]
fn a_machine_that_is_off_as_stated_needs_no_cause() {
    each(|seed, _| assert_eq!(plain(seed).cause(seed), None, "{seed}"));
}

#[test]
fn a_drum_is_named_with_its_size() {
    each(|seed, cable| {
        let mut log = plain(seed);
        let home = log.home_mm[cable];
        log.readings.iter_mut().for_each(|reading| reading[cable] = home + 1.02 * (reading[cable] - home));
        let cause = log.cause(seed).unwrap();
        assert_eq!((cause.kind, cause.cable), (CauseKind::DrumScale, Some(cable as u8 + 1)), "{seed}: {cause:?}");
        // What is found is what the tolerance has not taken up.
        assert!(cause.explains && (cause.size - 2.0).abs() < 0.4, "{cause:?}");
    });
}

#[test]
fn an_offset_is_named_with_its_size() {
    each(|seed, cable| {
        let mut log = plain(seed);
        log.readings.iter_mut().for_each(|reading| reading[cable] += 4.0);
        let cause = log.cause(seed).unwrap();
        assert_eq!((cause.kind, cause.cable), (CauseKind::EncoderOffset, Some(cable as u8 + 1)), "{seed}: {cause:?}");
        assert!((cause.size - 4.0).abs() < 1.5, "{cause:?}");
    });
}

#[test]
fn hysteresis_is_named_with_its_size() {
    each(|seed, _| {
        let mut log = plain(seed);
        let mut before = log.home_mm;
        for reading in &mut log.readings {
            let now = *reading;
            (0..CABLES).for_each(|k| reading[k] += 0.25 * (now[k] - before[k]).signum());
            before = now;
        }
        let cause = log.cause(seed).unwrap();
        assert_eq!((cause.kind, cause.cable), (CauseKind::Hysteresis, None), "{seed}: {cause:?}");
        assert!((cause.size - 0.5).abs() < 0.15, "{cause:?}");
    });
}

#[test]
fn lost_counts_are_named_with_cable_and_pose() {
    // A little, and so much that the two parts of the log do not fit each other at all.
    for by_mm in [2.0, -40.0] {
        each(|seed, cable| {
            let from = 10 + 2 * seed as usize;
            let mut log = plain(seed);
            log.readings[from..].iter_mut().for_each(|reading| reading[cable] += by_mm);
            let cause = log.cause(seed).unwrap();
            assert_eq!(cause.kind, CauseKind::LostCounts, "{by_mm} {seed}: {cause:?}");
            assert_eq!((cause.cable, cause.pose), (Some(cable as u8 + 1), Some(from)), "{by_mm} {seed}: {cause:?}");
            assert!((cause.size - by_mm).abs() < 0.5, "{cause:?}");
        });
    }
}

#[test]
fn a_stretched_machine_is_named() {
    each(|seed, _| {
        let stretched = |rig: Rig<f64>| {
            let base = rig.base_mm().map(|point| point * 1.04);
            let other = Rig::new(base, *rig.edges_mm(), *rig.drum(), NOISE_MM, *rig.nominal()).unwrap();
            other.with_correction(*rig.correction().unwrap()).unwrap()
        };
        let cause = log(seed, stretched, |_, _| Vector3::zeros()).cause(seed).unwrap();
        assert!(matches!(cause.kind, CauseKind::BaseShape), "{seed}: {cause:?}");
    });
}

#[test]
fn a_slip_is_named_with_its_pose() {
    each(|seed, _| {
        let from = 12 + seed as usize;
        let slipped = |index: usize, _: &Rotation3<f64>| match index < from {
            true => Vector3::zeros(),
            false => Vector3::new(2.0, -1.5, 1.0),
        };
        let cause = log(seed, |rig| rig, slipped).cause(seed).unwrap();
        assert_eq!((cause.kind, cause.pose), (CauseKind::BaseSlipped, Some(from)), "{seed}: {cause:?}");
        assert!((cause.size - 2.69).abs() < 0.5, "{cause:?}");
    });
}

#[test]
fn a_moving_joint_is_no_fault_of_the_machine() {
    each(|seed, _| {
        let mut scatter = ChaCha8Rng::seed_from_u64(seed);
        let scatter: Vec<_> = (0..POSES).map(|_| vector(&mut scatter, 0.5)).collect();
        let moving = |index: usize, rotation: &Rotation3<f64>| {
            let tilted = rotation * Vector3::z() - Vector3::z();
            Vector3::new(8.0 * tilted.x, 3.0 * tilted.x - 6.0 * tilted.y, 5.0 * tilted.y) + scatter[index]
        };
        let log = log(seed, |rig| rig, moving);
        assert!(log.rotations.len() == POSES);
        let cause = log.cause(seed).unwrap();
        assert_eq!(cause.kind, CauseKind::MovingJoint, "{seed}: {cause:?}");
    });
}

#[test]
fn something_loose_is_named() {
    each(|seed, _| {
        let mut scatter = ChaCha8Rng::seed_from_u64(seed);
        let scatter: Vec<_> = (0..POSES).map(|_| vector(&mut scatter, 0.8)).collect();
        let cause = log(seed, |rig| rig, |index, _| scatter[index]).cause(seed).unwrap();
        assert_eq!(cause.kind, CauseKind::Loose, "{seed}: {cause:?}");
        assert!((cause.size - 0.46).abs() < 0.15, "{cause:?}");
    });
}

#[test]
fn exchanged_cables_and_a_still_encoder_are_named() {
    each(|seed, cable| {
        let other = (cable + 1 + seed as usize % 4) % CABLES;
        let mut log = plain(seed);
        log.readings.iter_mut().for_each(|reading| reading.swap(cable, other));
        let cause = log.cause(seed).unwrap();
        let named = [cause.cable, cause.other_cable].map(|cable| usize::from(cable.unwrap_or_default()));
        assert_eq!(cause.kind, CauseKind::ExchangedCables, "{seed}: {cause:?}");
        assert_eq!(named, [cable.min(other) + 1, cable.max(other) + 1], "{seed}");

        let mut log = plain(seed);
        let first = log.readings[0][cable];
        log.readings.iter_mut().for_each(|reading| reading[cable] = first);
        let cause = log.cause(seed).unwrap();
        assert_eq!((cause.kind, cause.cable), (CauseKind::ConstantEncoder, Some(cable as u8 + 1)), "{seed}");
    });
}

/// A drum that is off by twenty times its tolerance is taken up by the estimate, and contradicts it; what is off as stated
/// does not.
#[test]
fn an_accepted_machine_that_contradicts_its_tolerance_is_named() {
    each(|seed, cable| {
        let log = plain(seed);
        let machine = Machine::new(&log.stated);
        assert_eq!(contradiction(&machine, &log.lengths(seed), NOISE_MM), None, "{seed}");
        let mut log = log;
        let home = log.home_mm[cable];
        log.readings.iter_mut().for_each(|reading| reading[cable] = home + 1.02 * (reading[cable] - home));
        let cause = contradiction(&machine, &log.lengths(seed), NOISE_MM).unwrap();
        assert_eq!((cause.kind, cause.cable), (CauseKind::DrumScale, Some(cable as u8 + 1)), "{seed}: {cause:?}");
    });
}
