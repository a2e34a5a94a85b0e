//! Does the advice help? For each family of poses that lacks something: following the advice must sharpen the centre
//! more than going on as before.

use glenoid::identification::{Machine, Pose, PredictedAccuracy};
use glenoid::kinematics::{CableLengths, inverse};
use glenoid::procedure::Guidance;
use glenoid::procedure::guidance::Spread;
use glenoid::rig::Rig;
use nalgebra::{Rotation3, Unit, Vector3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// What the wearer does: tilt up to an angle, in planes of an azimuth up to another, torsion up to a third. Degrees.
#[derive(Clone, Copy)]
struct Range {
    tilt: f64,
    azimuth: f64,
    torsion: f64,
}

fn rotation(range: Range, random: &mut ChaCha8Rng) -> Rotation3<f64> {
    let mut within = |limit: f64| random.random_range(-1.0..=1.0) * limit.to_radians();
    let (tilt, azimuth, torsion) = (within(range.tilt), within(range.azimuth), within(range.torsion));
    let axis = Unit::new_normalize(Vector3::new(azimuth.cos(), azimuth.sin(), 0.0));
    Rotation3::from_axis_angle(&axis, tilt) * Rotation3::from_axis_angle(&Vector3::z_axis(), torsion)
}

struct Arm {
    machine: Machine<f32>,
    accuracy: PredictedAccuracy<f32>,
    spread: Spread,
    random: ChaCha8Rng,
}

impl Arm {
    fn new(seed: u64) -> Self {
        let rig = Rig::shoulder(150.0).unwrap();
        let machine = Machine::new(&rig);
        let accuracy = PredictedAccuracy::new(&machine, rig.nominal());
        Self { machine, accuracy, spread: Spread::default(), random: ChaCha8Rng::seed_from_u64(seed) }
    }

    fn capture(&mut self, poses: usize, range: Range) {
        let rig: Rig<f64> = Rig::shoulder(150.0).unwrap();
        let centre = rig.nominal().centre_mm;
        let circumradius = (140.8f64 * 140.8 - 96.0 * 96.0).sqrt();
        let ends = [60.0f64, 180.0, 300.0].map(|azimuth| {
            let (sine, cosine) = azimuth.to_radians().sin_cos();
            Vector3::new(circumradius * cosine, circumradius * sine, 96.0)
        });
        for _ in 0..poses {
            let rotation = rotation(range, &mut self.random);
            let lengths = inverse::cable_lengths(&rig, &centre, &ends, &rotation).map(|length| length as f32);
            let pose = Pose::placed(self.machine.platform(), CableLengths::new(lengths).unwrap()).unwrap();
            self.accuracy.add(&self.machine, &pose);
            self.spread.add(&pose.rotation());
        }
    }

    fn sigma_mm(&self) -> f32 {
        self.accuracy.predicted(&self.machine).map_or(f32::INFINITY, |predicted| predicted.sigma_mm)
    }
}

/// Captures some poses of a family. For those seeds whose poses call forth the advice: how many times smaller is σ after
/// four poses that follow it than after four more of the family? At least `gain` times for nine tenths of them.
fn check(poses: usize, family: Range, advised: Range, advice: Guidance, gain: f32) {
    let mut gains = Vec::new();
    for seed in 0..60 {
        let after = |next: Range| {
            let mut arm = Arm::new(seed);
            arm.capture(poses, family);
            let as_expected = arm.spread.advice() == advice;
            arm.capture(4, next);
            as_expected.then(|| arm.sigma_mm())
        };
        if let (Some(without), Some(with)) = (after(family), after(advised)) {
            gains.push(without / with);
        }
    }
    gains.sort_by(f32::total_cmp);
    assert!(gains.len() >= 50, "{advice:?} was given for {} of 60", gains.len());
    assert!(gains[gains.len() / 10] > gain, "{advice:?}: {gains:?}");
}

const WIDE: f64 = 40.0;
const ALL_ROUND: f64 = 180.0;

#[test]
fn tilt_more() {
    let timid = Range { tilt: 8.0, azimuth: ALL_ROUND, torsion: 30.0 };
    check(8, timid, Range { tilt: WIDE, ..timid }, Guidance::TiltMore, 2.0);
    let turning_only = Range { tilt: 0.0, azimuth: 0.0, torsion: 40.0 };
    check(8, turning_only, Range { tilt: WIDE, azimuth: ALL_ROUND, ..turning_only }, Guidance::TiltMore, 10.0);
}

#[test]
fn another_plane() {
    let one_plane = Range { tilt: WIDE, azimuth: 0.0, torsion: 3.0 };
    check(4, one_plane, Range { azimuth: ALL_ROUND, ..one_plane }, Guidance::AnotherPlane, 2.0);
}

/// Who keeps tilting in one plane may have no other: turning about the arm's length helps nearly as much.
#[test]
fn turn_about_length() {
    let one_plane = Range { tilt: WIDE, azimuth: 0.0, torsion: 3.0 };
    check(12, one_plane, Range { torsion: 40.0, ..one_plane }, Guidance::TurnAboutLength, 2.0);
}

#[test]
fn a_wide_spread_needs_no_advice() {
    let mut arm = Arm::new(3);
    arm.capture(30, Range { tilt: WIDE, azimuth: ALL_ROUND, torsion: 30.0 });
    assert_eq!(arm.spread.advice(), Guidance::MoveOn);
}
