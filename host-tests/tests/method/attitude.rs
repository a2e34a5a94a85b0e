//! The arm's rotation from the lengths, the centre known: with all six cables, with any five, in either precision,
//! beyond the singularity of the forward kinematics as well. Expected rotations are those that the lengths were made from.

use crate::common::dense::{derivative, lengths_mm};
use crate::common::library::{as_cables, rig};
use crate::common::sets::{NOISE_MM, machines, normal, sweep};
use crate::common::{Worn, parameters, rng};
use glenoid::kinematics::rotation::{nearest_attitude, turned};
use glenoid::kinematics::{AttitudeFit, AttitudeSolver, CableSet, ForwardKinematics, Geometry, JointCentre};
use glenoid::rig::Parameters;
use glenoid::scalar::Real;
use host_tests::literal::Lengths;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use rand::Rng;

/// The rotation that {P} has at home: its x axis runs from P1 to P2, its z axis away from the base.
fn home_axes(worn: &Worn) -> Rotation3<f64> {
    let [p1, p2, p3] = worn.home_mm;
    let x = (p2 - p1).normalize();
    let z = (p2 - p1).cross(&(p3 - p1)).normalize();
    let z = z * z.z.signum();
    Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, z.cross(&x), z]))
}

/// A machine with its centre known, in one precision.
struct Known<T: Real> {
    geometry: Geometry<T>,
    centre: JointCentre<T>,
}

impl<T: Real> Known<T> {
    fn of(worn: &Worn) -> Self {
        let rig = rig::<T>(worn);
        let geometry = Geometry::new(&rig);
        let truth = Parameters::from_array(parameters(&worn.truth()).map(T::of));
        Self { centre: JointCentre::from_parameters(&truth, &geometry), geometry }
    }

    fn solver(&self) -> AttitudeSolver<'_, T> {
        AttitudeSolver { geometry: &self.geometry, centre: &self.centre }
    }

    fn fit(&self, lengths: &Lengths<f64>, cables: CableSet) -> Option<AttitudeFit<T>> {
        self.solver().solve(&as_cables(lengths), cables)
    }
}

/// Angle between the fitted and the true rotation from home, rad.
fn off<T: Real>(worn: &Worn, fit: &AttitudeFit<T>, turn: &Rotation3<f64>) -> f64 {
    let rotation = fit.attitude.to_rotation_matrix().matrix().map(|entry| entry.to_f64());
    let difference = rotation * (turn * home_axes(worn)).matrix().transpose();
    // Of a small rotation the skew part is the rotation vector, to the last digit.
    let skew = (difference - difference.transpose()) * 0.5;
    Vector3::new(skew.m32, skew.m13, skew.m21).norm().atan2((difference.trace() - 1.0) * 0.5)
}

#[test]
fn any_rotation_is_found_without_a_start() {
    let mut rng = rng(2301);
    for (name, worn) in machines() {
        for worn in [worn, worn.mirrored()] {
            let known = Known::<f64>::of(&worn);
            for turn in sweep(&mut rng, 1000, 60.0, 60.0) {
                let fit = known.fit(&worn.lengths_mm(&turn), CableSet::ALL).expect(name);
                let error = off(&worn, &fit, &turn);
                assert!(error < 1e-9, "{name}: off by {error} rad: {turn}");
                assert!(fit.squares_mm2 < 1e-18, "{name}: {} mm²", fit.squares_mm2);
            }
        }
    }
}

#[test]
fn random_machines_and_poses_beyond_the_singularity() {
    let mut rng = rng(2302);
    let (mut lost, mut beyond) = (0, 0);
    for _ in 0..4000 {
        let worn = Worn::random(&mut rng, 20.0);
        let turn = sweep(&mut rng, 1, 60.0, 60.0)[0];
        let lengths = worn.lengths_mm(&turn);
        let found = Known::<f64>::of(&worn).fit(&lengths, CableSet::ALL);
        let fit = found.expect("a pose of this machine");
        assert!(fit.squares_mm2 < 1e-16, "{} mm²", fit.squares_mm2);
        lost += usize::from(off(&worn, &fit, &turn) > 1e-7);
        let placed = ForwardKinematics::new(&rig::<f64>(&worn)).solve(&as_cables(&lengths));
        let misplaced = |origin: Vector3<f64>| (origin - worn.centre_mm - turn * worn.home_mm[0]).norm() > 0.1;
        beyond += usize::from(placed.map_or(true, |pose| misplaced(pose.origin_mm)));
    }
    assert_eq!(lost, 0, "six lengths and the centre leave one rotation");
    assert!(beyond > 10, "only {beyond} poses that the forward kinematics cannot place");
}

#[test]
fn five_cables_are_enough() {
    let mut rng = rng(2303);
    let mut other = 0;
    for (name, worn) in machines() {
        let known = Known::<f64>::of(&worn);
        for turn in sweep(&mut rng, 300, 45.0, 30.0) {
            for cable in 0..6 {
                let mut lengths = worn.lengths_mm(&turn);
                // The missing cable's reading is of no consequence.
                lengths[cable] = rng.random_range(1.0..1000.0);
                let fit = known.fit(&lengths, CableSet::all_but(cable)).expect(name);
                assert!(fit.squares_mm2 < 1e-16, "{name} without cable {}: {} mm²", cable + 1, fit.squares_mm2);
                other += usize::from(off(&worn, &fit, &turn) > 1e-7);
            }
        }
    }
    // Two lengths more than angles: hardly ever do two rotations fit.
    assert!(other < 4, "{other} of 3600 other rotations");
}

#[test]
fn a_wrong_length_shows_and_the_other_five_clear_it() {
    let mut rng = rng(2304);
    for (name, worn) in machines() {
        let known = Known::<f64>::of(&worn);
        for turn in sweep(&mut rng, 200, 45.0, 30.0) {
            let cable = rng.random_range(0..6);
            let mut lengths = worn.lengths_mm(&turn);
            lengths[cable] += 2.0 * crate::common::sets::sign(&mut rng);
            let all = known.fit(&lengths, CableSet::ALL).expect(name);
            let five = known.fit(&lengths, CableSet::all_but(cable)).expect(name);
            assert!(all.squares_mm2 > 0.01, "{name}: only {} mm² for 2 mm on cable {}", all.squares_mm2, cable + 1);
            assert!(five.squares_mm2 < 1e-16, "{name}: {} mm²", five.squares_mm2);
        }
    }
}

#[test]
fn noisy_lengths_give_the_least_squares_rotation() {
    let mut rng = rng(2305);
    for (name, worn) in machines() {
        let known = Known::<f64>::of(&worn);
        for turn in sweep(&mut rng, 200, 45.0, 30.0) {
            let measured = worn.lengths_mm(&turn).map(|length| length + NOISE_MM * normal(&mut rng));
            let fit = known.fit(&measured, CableSet::ALL).expect(name);
            let rotation = fit.attitude.to_rotation_matrix() * home_axes(&worn).inverse();
            let lengths = |step: &Vector3<f64>| {
                lengths_mm(&worn, &worn.centre_mm, &Vector3::zeros(), &(Rotation3::new(*step) * rotation))
            };
            let computed = lengths(&Vector3::zeros());
            let residuals = nalgebra::Vector6::from_fn(|k, _| measured[k] - computed[k]);
            assert!((residuals.norm_squared() - fit.squares_mm2).abs() < 1e-9, "{name}: {} mm²", fit.squares_mm2);
            // At the minimum the residuals are orthogonal to every derivative.
            let rows = derivative::<6, 3>(lengths);
            let uphill = (rows.transpose() * residuals).amax() / rows.amax();
            assert!(uphill < 1e-6, "{name}: not the minimum, {uphill} mm");
        }
    }
}

#[test]
fn single_precision_finds_sound_and_spoilt_poses_as_double_does() {
    let mut rng = rng(2306);
    let mut unsettled = 0;
    for (name, worn) in machines() {
        let (single, double) = (Known::<f32>::of(&worn), Known::<f64>::of(&worn));
        for turn in sweep(&mut rng, 500, 60.0, 60.0) {
            let mut lengths = worn.lengths_mm(&turn).map(|length| length + NOISE_MM * normal(&mut rng));
            let fit = single.fit(&lengths, CableSet::ALL).expect(name);
            assert!(off(&worn, &fit, &turn) < 0.02, "{name}: off by {} rad", off(&worn, &fit, &turn));
            lengths[rng.random_range(0..6)] += 5.0;
            for cables in [CableSet::ALL, CableSet::all_but(rng.random_range(0..6))] {
                let (Some(mine), Some(reference)) = (single.fit(&lengths, cables), double.fit(&lengths, cables)) else {
                    unsettled += 1;
                    continue;
                };
                let (mine, reference) = (f64::from(mine.squares_mm2), reference.squares_mm2);
                assert!((mine - reference).abs() < 1e-3 * (reference + 0.1), "{name}: {mine} or {reference} mm²");
            }
        }
    }
    // Five millimetres that fit nowhere make the iteration slow where the pose is nearly singular.
    assert!(unsettled < 20, "{unsettled} of 2000 spoilt poses do not settle");
}

#[test]
fn tracking_follows_from_sample_to_sample() {
    let (name, worn) = machines()[0];
    let known = Known::<f32>::of(&worn);
    // 90 degrees a second at 100 Hz, through the singularity and back.
    let at = |sample: usize| Rotation3::from_euler_angles(0.3, (sample as f64 * 0.9).to_radians() - 0.9, 0.2);
    let mut attitude = known.fit(&worn.lengths_mm(&at(0)), CableSet::ALL).expect(name).attitude;
    for sample in 1..120 {
        let lengths = as_cables(&worn.lengths_mm(&at(sample)));
        let fit = known.solver().track(attitude, &lengths, CableSet::ALL).expect(name);
        let error = off(&worn, &fit, &at(sample));
        assert!(error < 1e-4, "sample {sample}: off by {error} rad");
        attitude = fit.attitude;
    }
}

/// A control loop's single step: 200 degrees a second at 1 kHz, through the singularity and back, with single precision.
#[test]
fn a_single_step_follows_a_fast_arm() {
    let (name, worn) = machines()[0];
    let known = Known::<f32>::of(&worn);
    let at = |sample: usize| Rotation3::from_euler_angles(0.3, (sample as f64 * 0.2).to_radians() - 0.9, 0.2);
    let mut attitude = known.fit(&worn.lengths_mm(&at(0)), CableSet::ALL).expect(name).attitude;
    let mut worst = 0.0_f64;
    for sample in 1..540 {
        let lengths = as_cables(&worn.lengths_mm(&at(sample)));
        let fit = known.solver().follow(&attitude, &lengths).expect(name);
        worst = worst.max(off(&worn, &fit, &at(sample)));
        attitude = fit.attitude;
    }
    assert!((1e-6..5e-5).contains(&worst), "off by {worst} rad");
    // an arm that has jumped is nobody to follow
    let lengths = as_cables(&worn.lengths_mm(&at(600)));
    assert!(known.solver().follow(&attitude, &lengths).is_none());
}

#[test]
fn no_lengths_bring_it_down() {
    let mut rng = rng(2307);
    for (_, worn) in machines() {
        let (single, double) = (Known::<f32>::of(&worn), Known::<f64>::of(&worn));
        for _ in 0..3000 {
            let scale = 10_f64.powf(rng.random_range(-30.0..30.0));
            let lengths = core::array::from_fn(|_| scale * rng.random_range(0.1..1.0));
            for cables in [CableSet::ALL, CableSet::all_but(rng.random_range(0..6))] {
                for squares in [
                    single.fit(&lengths, cables).map(|fit| f64::from(fit.squares_mm2)),
                    double.fit(&lengths, cables).map(|fit| fit.squares_mm2),
                ] {
                    assert!(squares.is_none_or(|squares| squares >= 0.0), "{squares:?} mm² for {lengths:?}");
                }
            }
        }
    }
}

#[test]
fn small_helpers() {
    assert!((0..6).all(|cable| CableSet::ALL.has(cable)));
    assert!((0..6).all(|left| (0..6).all(|cable| CableSet::all_but(left).has(cable) == (cable != left))));

    let mut rng = rng(2308);
    for _ in 0..200 {
        let from = Rotation3::new(Vector3::from_fn(|_, _| rng.random_range(-3.0..3.0)));
        let turn = Vector3::from_fn(|_, _| rng.random_range(-1e-3..1e-3));
        let attitude = nearest_attitude(from.matrix());
        assert!((attitude.to_rotation_matrix().matrix() - from.matrix()).amax() < 1e-14);
        // Exact to third order: 1e-9 of a milliradian.
        let expected = UnitQuaternion::from_scaled_axis(turn) * attitude;
        assert!(turned(&attitude, &turn).angle_to(&expected) < 1e-9);
    }
}
