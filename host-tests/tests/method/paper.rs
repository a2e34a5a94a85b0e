//! The paper's iteration on Table I's machine.

use glenoid::kinematics::{CableLengths, inverse};
use glenoid::paper::{PaperIteration, PaperSettings, verify};
use glenoid::rig::{Parameters, Rig};
use nalgebra::{Rotation3, Vector3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn poses(rig: &Rig<f64>, count: usize, rng: &mut ChaCha8Rng) -> Vec<CableLengths<f64>> {
    let circumradius = rig.edges_mm()[0] / 3f64.sqrt();
    let end_points = [60f64, 180.0, 300.0]
        .map(|a| Vector3::new(circumradius * a.to_radians().cos(), circumradius * a.to_radians().sin(), 96.0));
    (0..count)
        .map(|_| {
            let turn = Vector3::from_fn(|_, _| rng.random_range(-0.5..0.5));
            let lengths =
                inverse::cable_lengths(rig, &Vector3::new(0.0, 0.0, 148.0), &end_points, &Rotation3::new(turn));
            CableLengths::new(lengths).unwrap()
        })
        .collect()
}

#[test]
fn home_lengths_are_those_of_the_inverse_kinematics() {
    let rig = Rig::<f64>::shoulder(150.0).unwrap();
    let c = rig.edges_mm()[0] / 3f64.sqrt();
    let end_points =
        [60f64, 180.0, 300.0].map(|a| Vector3::new(c * a.to_radians().cos(), c * a.to_radians().sin(), 96.0));
    let home = inverse::cable_lengths(&rig, &Vector3::new(0.0, 0.0, 148.0), &end_points, &Rotation3::identity());
    for (length, expected) in home.iter().zip(&rig.drum().home_length_mm) {
        assert!((length - expected).abs() < 1e-9, "{length} {expected}");
    }
}

#[test]
fn a_start_within_ten_millimetres_is_recovered() {
    let rig = Rig::<f64>::shoulder(150.0).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let first = poses(&rig, 10, &mut rng);
    let second = poses(&rig, 10, &mut rng);
    let truth = Parameters { centre_mm: Vector3::new(0.0, 0.0, 148.0), radii_mm: [140.8; 3] };
    assert!(verify(&rig, &truth, &second).unwrap() < 1e-9);
    let start = truth.moved_by(&[5.0, -4.0, 6.0, 3.0, -7.0, 2.0]);
    let found = PaperIteration::new(&rig, start, PaperSettings::default()).run(&first).unwrap();
    let centre = found.parameters.centre_mm;
    assert!((centre - truth.centre_mm).norm() < 1e-3, "{centre:?}");
    assert!(verify(&rig, &found.parameters, &second).unwrap() < 1e-3);
}
