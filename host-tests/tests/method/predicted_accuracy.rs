//! Predicted accuracy: the standard deviation that the poses so far promise, against the one that they give.

use crate::common::library::{as_cables, as_poses, estimate, rig, settings};
use crate::common::sets::{machines, noisy, sound};
use crate::common::{Worn, rng};
use glenoid::identification::{Machine, Pose, Predicted, PredictedAccuracy};
use glenoid::kinematics::PlatformError;
use glenoid::rig::{Rig, Tolerance};
use glenoid::scalar::Real;
use host_tests::literal::Lengths;
use nalgebra::{Rotation3, Unit, Vector3};
use rand::Rng;

/// A machine and what its poses promise.
struct Forecast<T: Real> {
    machine: Machine<T>,
    accuracy: PredictedAccuracy<T>,
}

impl<T: Real> Forecast<T> {
    fn new(rig: &Rig<T>) -> Self {
        let machine = Machine::new(rig);
        Self { accuracy: PredictedAccuracy::new(&machine, rig.nominal()), machine }
    }

    fn add(&mut self, lengths: &Lengths<f64>) -> Result<(), PlatformError> {
        let pose = Pose::placed(self.machine.platform(), as_cables(lengths))?;
        self.accuracy.add(&self.machine, &pose);
        Ok(())
    }

    fn predicted(&self) -> Option<Predicted<T>> {
        self.accuracy.predicted(&self.machine)
    }
}

/// A machine that is known to half a millimetre and a tenth of a per cent.
fn toleranced(worn: &Worn) -> Rig<f64> {
    let tolerance = Tolerance { base_mm: 0.5, edges_mm: 0.5, offset_mm: 0.3, drum: 1e-3 };
    rig::<f64>(worn).with_tolerance(tolerance).expect("a tolerance")
}

#[test]
fn the_predicted_standard_deviation_is_the_final_one() {
    for (seed, (name, worn)) in machines().into_iter().enumerate() {
        for rig in [rig::<f64>(&worn), toleranced(&worn)] {
            for count in [5, 10, 30, 100] {
                // Without noise: the running centre, and the nominal one, are the true centre.
                let poses = sound(&worn, 2403 + seed as u64, count);
                let mut forecast = Forecast::new(&rig);
                for pose in &poses {
                    forecast.add(pose).expect(name);
                }
                let predicted = forecast.predicted().expect(name);
                let mut settings = settings(&rig);
                settings.sigma_limit_mm = 100.0;
                // Few poses of an inexact machine are not redundant; what they give is asked for here.
                settings.require_redundancy = false;
                let found = estimate(&rig, &forecast.machine, settings, &as_poses(&poses)).expect(name);
                let (sigma_mm, direction) = found.worst_centre_sigma_mm();
                assert!((predicted.sigma_mm / sigma_mm - 1.0).abs() < 1e-6, "{name}: {predicted:?} or {sigma_mm}");
                let along: f64 = predicted.direction.iter().zip(direction).map(|(a, b)| a * b).sum();
                assert!(along.abs() > 0.999, "{name}: {:?} or {direction:?}", predicted.direction);
                assert!((forecast.accuracy.excitation().least_rad - found.excitation_rad).abs() < 1e-6, "{name}");
            }
        }
    }
}

#[test]
fn the_predicted_standard_deviation_only_shrinks() {
    for (name, worn) in machines() {
        let mut forecast = Forecast::new(&rig::<f32>(&worn));
        let mut before = f32::INFINITY;
        let mut steps = 0;
        for lengths in noisy(&worn, 2405, 100) {
            forecast.add(&lengths).expect(name);
            if let Some(predicted) = forecast.predicted() {
                assert!(predicted.sigma_mm <= before * 1.0001, "{name}: {} after {before} mm", predicted.sigma_mm);
                before = predicted.sigma_mm;
                steps += 1;
            }
        }
        assert!(steps >= 95 && before < 0.2, "{name}: {steps} predictions, the last {before} mm");
    }
}

#[test]
fn more_poses_of_the_same_kind_are_as_good_as_the_same_poses_again() {
    for (name, worn) in machines() {
        let (mut once, mut thrice) = (Forecast::new(&toleranced(&worn)), Forecast::new(&toleranced(&worn)));
        assert_eq!(once.accuracy.predicted_with(&once.machine, 10), None);
        let poses = sound(&worn, 2407, 12);
        poses.iter().for_each(|pose| once.add(pose).expect(name));
        poses.iter().cycle().take(36).for_each(|pose| thrice.add(pose).expect(name));
        let expected = thrice.predicted().expect(name).sigma_mm;
        let found = once.accuracy.predicted_with(&once.machine, 24).expect(name).sigma_mm;
        assert!((found / expected - 1.0).abs() < 1e-6, "{name}: {found} instead of {expected} mm");
        assert!(found < once.predicted().expect(name).sigma_mm);
    }
}

#[test]
fn nothing_is_predicted_of_poses_that_determine_nothing() {
    let mut rng = rng(2406);
    for (name, worn) in machines() {
        let mut forecast = Forecast::new(&rig::<f64>(&worn));
        assert_eq!(forecast.predicted(), None);
        let axis = Unit::new_normalize(Vector3::new(0.2, 0.1, 1.0));
        for _ in 0..10 {
            let turn = Rotation3::from_axis_angle(&axis, rng.random_range(-0.4..0.4));
            forecast.add(&worn.lengths_mm(&turn)).expect(name);
            assert_eq!(forecast.predicted(), None, "{name}: one axis only");
        }
        let excitation = forecast.accuracy.excitation();
        assert!(excitation.least_rad < 1e-5 && excitation.axis.cross(&axis).norm() < 1e-4, "{name}");
        // A pose that cannot be placed is none.
        let broken = [1.0, 500.0, 250.0, 250.0, 250.0, 250.0];
        assert!(matches!(forecast.add(&broken), Err(PlatformError::Length(_))), "{name}");
        assert_eq!(forecast.accuracy.excitation(), excitation);
    }
}
