//! What further poses would add to what is known, against fits of sets that have them.

use crate::common::library::{as_cables, as_poses, rig};
use crate::common::rng;
use crate::common::sets::{lengths_at, machines, sweep};
use glenoid::identification::carried_point::CarriedPoint;
use glenoid::identification::{Estimator, EstimatorSettings, Machine, Noise, Pose};
use glenoid::rig::Tolerance;
use nalgebra::Vector3;

/// Lengths without noise, so that the fit of the larger set stands where that of the smaller one does.
#[test]
fn further_poses_narrow_a_carried_point_as_predicted() {
    for (name, worn) in machines() {
        for tolerance in [Tolerance::exact(), Tolerance::hand_built()] {
            let rig = rig::<f64>(&worn).with_tolerance(tolerance).unwrap();
            let machine = Machine::new(&rig);
            let random = &mut rng(71);
            let lengths = lengths_at(&worn, &sweep(random, 12, 30.0, 20.0));
            let further = lengths_at(&worn, &sweep(random, 4, 45.0, 30.0));
            let posture = Pose::new(as_cables(&lengths_at(&worn, &sweep(random, 1, 40.0, 25.0))[0]));
            let point = CarriedPoint::exact(Vector3::new(40.0, -25.0, 90.0));
            let settings =
                EstimatorSettings { noise: Noise::Known(rig.length_noise_mm()), ..EstimatorSettings::for_rig(&rig) };
            let fitted = |poses: &mut Vec<Pose<f64>>| {
                let mut estimator = Estimator::new(&machine, rig.nominal(), settings);
                estimator.run(&machine, poses).unwrap();
                estimator
            };
            let before = fitted(&mut as_poses(&lengths));
            let now = before.carry(&machine, &posture, &point).unwrap().covariance_mm2;
            let none = before.carry_with(&machine, &posture, &point, &[]).unwrap().covariance_mm2;
            assert!((none - now).norm() < 1e-12 * now.norm());

            // One is the mean of four samples.
            let mut added = as_poses(&further);
            added[1] = added[1].averaged_over(4);
            let mut larger = [as_poses(&lengths), added.clone()].concat();
            let after = fitted(&mut larger);
            added.iter_mut().for_each(|pose| pose.place(machine.platform()));
            for count in 1..=added.len() {
                let predicted = before.carry_with(&machine, &posture, &point, &added[..count]).unwrap().covariance_mm2;
                let after = if count == added.len() { &after } else { &fitted(&mut larger[..12 + count].to_vec()) };
                let found = after.carry(&machine, &posture, &point).unwrap().covariance_mm2;
                let gained = (now - found).norm();
                let difference = (found - predicted).norm() / gained;
                assert!(difference < 0.01, "{name}, {count}: {difference} {found} {predicted}");
                assert!(found.trace() < now.trace(), "{name}, {count}");
            }
        }
    }
}
