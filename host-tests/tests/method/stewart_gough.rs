//! Forward kinematics without the centre: six lengths and three edges give the platform's pose, or a refusal.
//!
//! The expected end-points come from the inverse direction, rotations and subtractions alone. What happens beyond the
//! singularity is written down here as well: the lengths have other, equally exact assembly modes on the home side, and
//! one of those is returned, or none.

use crate::common::library::{as_cables, rig};
use crate::common::sets::{machines, sweep};
use crate::common::{Worn, arm, rng, tilted};
use glenoid::kinematics::{CableLengths, ForwardKinematics, LengthError, LengthFault, PlatformError, PlatformPose};
use glenoid::rig::Rig;
use glenoid::scalar::Real;
use host_tests::literal::Lengths;
use nalgebra::{Matrix3, Matrix6, Rotation3, Vector3};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// Where the end-points truly are, in {B}, mm.
fn end_points(worn: &Worn, turn: &Rotation3<f64>) -> [Vector3<f64>; 3] {
    worn.home_mm.map(|point| worn.centre_mm + turn * point)
}

/// The axes of {P} by their definition: x from P1 to P2, the third end-point in the xy plane, z away from the base at
/// home.
fn axes(worn: &Worn, end_points: &[Vector3<f64>; 3]) -> Matrix3<f64> {
    let plane = |[p1, p2, p3]: [Vector3<f64>; 3]| (p2 - p1).cross(&(p3 - p1));
    let x = (end_points[1] - end_points[0]).normalize();
    let away = plane(worn.home_mm).z.signum();
    let z = plane(*end_points).normalize() * away;
    Matrix3::from_columns(&[x, z.cross(&x), z])
}

fn solve<T: Real>(worn: &Worn, lengths: &Lengths<f64>) -> Result<PlatformPose<T>, PlatformError> {
    ForwardKinematics::new(&rig::<T>(worn)).solve(&as_cables(lengths))
}

/// Largest error of an end-point, mm, and of an entry of the rotation.
fn errors<T: Real>(worn: &Worn, turn: &Rotation3<f64>, pose: &PlatformPose<T>) -> (f64, f64) {
    let truth = end_points(worn, turn);
    let rotation = pose.rotation.map(|entry| entry.to_f64());
    let origin = pose.origin_mm.map(|entry| entry.to_f64());
    let platform = rig::<f64>(worn).platform_mm();
    let off = (0..3).map(|i| (origin + rotation * platform[i] - truth[i]).norm()).fold(0.0, f64::max);
    (off, (rotation - axes(worn, &truth)).amax())
}

/// A machine far from the ideal: the base tilted by up to 15 degrees, points off by up to 30 mm along each axis.
fn crooked(rng: &mut ChaCha8Rng) -> Worn {
    let mut worn = Worn::random(rng, 30.0);
    let tilt = rng.random_range(0.0..15.0);
    let tilt = tilted(rng, tilt, 0.0);
    worn.base_mm = worn.base_mm.map(|point| tilt * point);
    worn
}

/// The sign of the determinant of the six cables' lines about P1: it changes at a singularity, where two assembly modes meet.
fn side(worn: &Worn, end_points: &[Vector3<f64>; 3]) -> f64 {
    let [b1, b2, b3] = worn.base_mm;
    let [p1, p2, p3] = *end_points;
    let cables = [(p1, b1), (p1, b2), (p2, b2), (p2, b3), (p3, b3), (p3, b1)];
    let lines = Matrix6::from_fn(|row, column| {
        let (point, base) = cables[row];
        let along = (point - base).normalize();
        let moment = (point - p1).cross(&along) / 100.0;
        if column < 3 { along[column] } else { moment[column - 3] }
    });
    lines.determinant().signum()
}

#[test]
fn poses_of_random_machines_are_recovered() {
    let mut rng = rng(2001);
    for _ in 0..4000 {
        let worn = crooked(&mut rng);
        let tilt = rng.random_range(0.0..30.0);
        let turn = tilted(&mut rng, tilt, 30.0);
        let pose = solve::<f64>(&worn, &worn.lengths_mm(&turn)).expect("a pose short of the singularity");
        let (off, turned) = errors(&worn, &turn, &pose);
        assert!(off < 1e-6, "end-points off by {off} mm: {worn:?} {turn}");
        assert!(turned < 1e-8, "rotation off by {turned}: {worn:?} {turn}");
    }
}

#[test]
fn both_machines_and_their_mirror_images_are_recovered() {
    let mut rng = rng(2002);
    for (name, upright) in machines() {
        for worn in [upright, upright.mirrored()] {
            for turn in sweep(&mut rng, 500, 45.0, 30.0) {
                let pose = solve::<f64>(&worn, &worn.lengths_mm(&turn)).expect(name);
                let (off, turned) = errors(&worn, &turn, &pose);
                assert!(off < 1e-6 && turned < 1e-7, "{name}: {off} mm, {turned}");
                assert!((pose.rotation.determinant() - 1.0).abs() < 1e-9, "{name}: not a rotation");
            }
        }
    }
}

#[test]
fn single_precision_recovers_to_a_few_roundings() {
    // A length of 300 mm is rounded to 1.5e-5 mm. The nearer to the singularity, the more of it is seen.
    let mut rng = rng(2003);
    let mut largest: f64 = 0.0;
    let mut squares = 0.0;
    for _ in 0..4000 {
        let worn = Worn::random(&mut rng, 20.0);
        let turn = arm(&mut rng, 30.0);
        let pose = solve::<f32>(&worn, &worn.lengths_mm(&turn)).expect("a pose short of the singularity");
        let (off, _) = errors(&worn, &turn, &pose);
        largest = largest.max(off);
        squares += off * off;
    }
    let typical = (squares / 4000.0).sqrt();
    assert!(largest < 1e-3 && typical < 1e-4, "largest {largest} mm, typical {typical} mm");
}

#[test]
fn the_platform_is_placed_on_its_side_of_the_base() {
    // Mirrored at the base plane the platform has the very same cable lengths.
    let mut rng = rng(2004);
    for (name, worn) in machines() {
        for turn in sweep(&mut rng, 200, 45.0, 30.0) {
            let pose = solve::<f64>(&worn, &worn.lengths_mm(&turn)).expect(name);
            let platform = rig::<f64>(&worn).platform_mm();
            assert!(platform.iter().all(|s| (pose.origin_mm + pose.rotation * s).z > 0.0), "{name}: below the base");
        }
    }
}

#[test]
fn lengths_between_which_the_platform_does_not_fit_are_refused() {
    let mut rng = rng(2005);
    for (name, worn) in machines() {
        let shoulder = rig::<f64>(&worn);
        // The same lengths for a platform of half or twice the size.
        for scale in [0.5, 2.0] {
            let edges = shoulder.edges_mm().map(|edge| edge * scale);
            let other = Rig::new(*shoulder.base_mm(), edges, *shoulder.drum(), 0.06, *shoulder.nominal());
            let kinematics = ForwardKinematics::new(&other.expect("a rig"));
            for turn in sweep(&mut rng, 100, 20.0, 20.0) {
                let lengths = worn.lengths_mm(&turn);
                match kinematics.solve(&as_cables(&lengths)) {
                    Err(PlatformError::DoesNotClose) => {}
                    // A platform of half the size may fit in elsewhere. Then it must fit exactly.
                    Ok(pose) => {
                        let points =
                            other.as_ref().expect("a rig").platform_mm().map(|s| pose.origin_mm + pose.rotation * s);
                        assert_fits(&worn, &points, &lengths, 1e-5);
                    }
                    Err(error) => panic!("{name}: {error:?}"),
                }
            }
        }
    }
}

/// These end-points have these lengths.
fn assert_fits(worn: &Worn, end_points: &[Vector3<f64>; 3], lengths: &Lengths<f64>, tolerance_mm: f64) {
    let [b1, b2, b3] = worn.base_mm;
    let [p1, p2, p3] = *end_points;
    let computed = [p1 - b1, p1 - b2, p2 - b2, p2 - b3, p3 - b3, p3 - b1].map(|cable| cable.norm());
    for (mine, given) in computed.iter().zip(lengths) {
        assert!((mine - given).abs() < tolerance_mm, "{computed:?} instead of {lengths:?}");
    }
}

#[test]
fn a_broken_triangle_is_named_by_its_first_cable() {
    for (name, worn) in machines() {
        let sound = worn.lengths_mm(&Rotation3::identity());
        let span = (worn.base_mm[0] - worn.base_mm[1]).norm();
        for cable in 0..6 {
            // Shorter than any point of the other cable's circle allows; then longer.
            for broken in [sound[cable ^ 1] - span - 1.0, sound[cable ^ 1] + span + 1.0, 1e30] {
                let mut lengths = sound;
                lengths[cable] = broken.max(0.1);
                if broken < 0.1 && (lengths[cable ^ 1] - span).abs() < 0.1 {
                    continue;
                }
                let expected = LengthError { cable: (cable & !1) as u8 + 1, fault: LengthFault::BreaksTriangle };
                assert_eq!(solve::<f64>(&worn, &lengths), Err(PlatformError::Length(expected)), "{name} {lengths:?}");
            }
        }
    }
}

#[test]
fn beyond_the_singularity_another_exact_assembly_mode_or_nothing_is_returned() {
    let mut rng = rng(2006);
    let (mut beyond, mut twins, mut short, mut nearest_mm) = (0, 0, 0, f64::INFINITY);
    for _ in 0..40_000 {
        let worn = Worn::random(&mut rng, 20.0);
        let tilt = rng.random_range(45.0..75.0);
        let turn = tilted(&mut rng, tilt, 60.0);
        let home = side(&worn, &end_points(&worn, &Rotation3::identity()));
        let truth = end_points(&worn, &turn);
        let lengths = worn.lengths_mm(&turn);
        let is_beyond = side(&worn, &truth) != home;
        beyond += usize::from(is_beyond);
        let Ok(pose) = solve::<f64>(&worn, &lengths) else { continue };
        let points = rig::<f64>(&worn).platform_mm().map(|s| pose.origin_mm + pose.rotation * s);
        // Whatever is returned fits the lengths, on the home side of the singularity.
        assert_fits(&worn, &points, &lengths, 1e-4);
        assert_eq!(side(&worn, &points), home, "not the home-side assembly mode: {worn:?} {turn}");
        let off = (0..3).map(|i| (points[i] - truth[i]).norm()).fold(0.0, f64::max);
        if off > 0.1 {
            twins += 1;
            // The home side has more than one assembly mode: the way from home may cross the singularity twice.
            short += usize::from(!is_beyond);
            // The signature: with the centre of the other poses the other mode misses it.
            let in_platform = axes(&worn, &worn.home_mm).transpose() * -worn.home_mm[0];
            nearest_mm = nearest_mm.min((pose.origin_mm + pose.rotation * in_platform - worn.centre_mm).norm());
        }
    }
    assert!(beyond > 1500 && twins > 1000, "only {beyond} beyond the singularity, {twins} in another mode");
    assert!(short < 30, "{short} poses short of the singularity got another assembly mode");
    assert!(nearest_mm > 0.1, "another mode only {nearest_mm} mm from the common centre");
}

#[test]
fn garbage_is_refused_or_fits() {
    let mut rng = rng(2007);
    for (_, worn) in machines() {
        for _ in 0..5000 {
            let scale = 10_f64.powf(rng.random_range(-20.0..18.0));
            let lengths: [f64; 6] = core::array::from_fn(|_| scale * rng.random_range(0.1..1.0));
            assert!(solve::<f32>(&worn, &lengths).is_err() || (10.0..2000.0).contains(&scale));
            if let Ok(pose) = solve::<f64>(&worn, &lengths) {
                let points = rig::<f64>(&worn).platform_mm().map(|s| pose.origin_mm + pose.rotation * s);
                assert_fits(&worn, &points, &lengths, 1e-4);
            }
        }
    }
    assert!(CableLengths::new([f64::NAN; 6]).is_err());
}
