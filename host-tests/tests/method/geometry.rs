//! Cables with ends of their own and over pulleys: lengths against a numeric minimum, gradients against differences, and
//! the platform's pose found from them.

use crate::common::dense::derivative;
use crate::common::library::rig;
use crate::common::sets::{machines, shoulder, sweep};
use crate::common::{Worn, rng};
use glenoid::kinematics::geometry::{Span, over_pulley, straight};
use glenoid::kinematics::{CableLengths, Geometry, PlatformError, PlatformSolver};
use glenoid::rig::{CABLES, CableEnds, Pulley, Rig};
use glenoid::scalar::Real;
use nalgebra::{Matrix3, Rotation3, Vector3};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

fn any_direction(rng: &mut ChaCha8Rng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| crate::common::sets::normal(rng)).normalize()
}

/// A vector across another.
fn across(axis: &Vector3<f64>) -> Vector3<f64> {
    let other = if axis.x.abs() < 0.5 { Vector3::x() } else { Vector3::y() };
    (other - axis * axis.dot(&other)).normalize()
}

/// The length of a taut cable over a pulley the long way: the cable touches the rim from where it enters to an angle at
/// which it leaves for its end; the taut one leaves on the tangent, where the rim's direction is the free part's.
///
/// In the plane of the swivel axis and the end, the rim is (r - r cos a, r sin a) after an arc of r a.
fn taut_length(radius: f64, x: f64, z: f64) -> f64 {
    let leaves = |a: f64| (radius - radius * a.cos(), radius * a.sin());
    // Free part across the rim's tangent (sin a, cos a): zero on the tangent. The largest angle at which it still is.
    let beside = |a: f64| {
        let (px, pz) = leaves(a);
        (x - px) * a.cos() - (z - pz) * a.sin()
    };
    // Bisection from an angle before the tangent to one beyond it.
    let steps = 20_000;
    let step = 2.0 * core::f64::consts::PI / f64::from(steps);
    let mut best = f64::INFINITY;
    for k in 0..steps {
        let (mut low, mut high) = (f64::from(k) * step, f64::from(k + 1) * step);
        if beside(low) * beside(high) > 0.0 {
            continue;
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if beside(low) * beside(middle) <= 0.0 { high = middle } else { low = middle }
        }
        let (px, pz) = leaves(low);
        // Onwards, not backwards.
        if (x - px) * low.sin() + (z - pz) * low.cos() > 0.0 {
            best = best.min(radius * low + ((x - px).powi(2) + (z - pz).powi(2)).sqrt());
        }
    }
    best
}

#[test]
fn a_cable_over_a_pulley_is_taut() {
    let mut rng = rng(4101);
    for _ in 0..60 {
        let axis = any_direction(&mut rng);
        let radius_mm = rng.random_range(0.5..40.0);
        let (x, z) = (rng.random_range(2.5..8.0) * radius_mm, rng.random_range(-2.0..8.0) * radius_mm);
        let away = Rotation3::from_axis_angle(&nalgebra::Unit::new_unchecked(axis), rng.random_range(0.0..6.2))
            * across(&axis);
        let span = over_pulley(&Pulley { radius_mm, axis }, &(axis * z + away * x));
        let expected = taut_length(radius_mm, x, z);
        assert!((span.length_mm - expected).abs() < 1e-9 * expected, "{} instead of {expected}", span.length_mm);
    }
}

/// The gradient by differences of the length.
fn gradient(length: impl Fn(&Vector3<f64>) -> f64) -> Vector3<f64> {
    derivative::<1, 3>(|step| [length(step)]).transpose()
}

#[test]
fn the_gradient_of_a_length_is_along_the_free_cable() {
    let mut rng = rng(4102);
    for _ in 0..500 {
        let axis = any_direction(&mut rng);
        let pulley = Pulley { radius_mm: rng.random_range(1.0..40.0), axis };
        let end = axis * rng.random_range(100.0..300.0) + across(&axis) * rng.random_range(90.0..200.0);
        let Span { direction, .. } = over_pulley(&pulley, &end);
        let expected = gradient(|step| over_pulley(&pulley, &(end + step)).length_mm);
        assert!((direction - expected).amax() < 1e-8, "{direction} instead of {expected}");
        assert!((direction.norm() - 1.0).abs() < 1e-12, "no unit vector: {direction}");
        let Span { length_mm, direction } = straight(&end);
        assert!((length_mm - end.norm()).abs() < 1e-12);
        assert!((direction - gradient(|step| (end + step).norm())).amax() < 1e-9);
    }
}

#[test]
fn a_pulley_that_shrinks_becomes_a_point() {
    let axis = Vector3::new(0.1, -0.2, 1.0).normalize();
    let end = Vector3::new(120.0, -40.0, 210.0);
    let point = straight(&end);
    for radius_mm in [1e-3_f64, 1e-6] {
        let span = over_pulley(&Pulley { radius_mm, axis }, &end);
        assert!((span.length_mm - point.length_mm).abs() < 2.0 * radius_mm);
        assert!((span.direction - point.direction).norm() < 0.02 * radius_mm);
    }
    // Inside the pulley there is no cable.
    let inside = over_pulley(&Pulley { radius_mm: 50.0_f64, axis: Vector3::z() }, &Vector3::new(50.0, 0.0, 3.0));
    assert!(!inside.length_mm.is_finite());
}

/// A machine whose cables have ends of their own.
struct General {
    rig: Rig<f64>,
    worn: Worn,
    /// Ends of the cables at home, from the joint centre, mm.
    home_mm: [Vector3<f64>; CABLES],
}

impl General {
    /// The ends of a worn machine, each moved by up to `apart_mm` along each axis; over pulleys of this radius.
    fn new(worn: Worn, rng: &mut ChaCha8Rng, apart_mm: f64, pulley_mm: f64) -> Self {
        let mut jitter = || Vector3::from_fn(|_, _| rng.random_range(-apart_mm..=apart_mm));
        let ends: [Vector3<f64>; CABLES] = core::array::from_fn(|k| worn.home_mm[k / 2] + jitter());
        let base: [Vector3<f64>; CABLES] = core::array::from_fn(|k| worn.base_mm[(k / 2 + k % 2) % 3] + jitter());
        // The cables come up from below the base.
        let pulley = Pulley { radius_mm: pulley_mm, axis: Vector3::z() };
        // The platform's ends in axes of their own: any will do.
        let turn = Rotation3::new(Vector3::new(0.4, -1.1, 0.6));
        let cables = core::array::from_fn(|k| CableEnds {
            base_mm: base[k],
            end_mm: turn * ends[k] + Vector3::new(10.0, 20.0, -30.0),
            pulley,
        });
        let plain = rig::<f64>(&worn);
        let rig = Rig::with_cables(cables, *plain.drum(), 0.06, *plain.nominal()).expect("a rig that can be built");
        Self { rig, worn, home_mm: ends }
    }

    /// Ends in {B} at a rotation from home.
    fn ends_mm(&self, turn: &Rotation3<f64>) -> [Vector3<f64>; CABLES] {
        self.home_mm.map(|end| self.worn.centre_mm + turn * end)
    }

    fn lengths(&self, turn: &Rotation3<f64>) -> CableLengths<f64> {
        let cables = self.rig.cables().expect("ends of its own");
        let ends = self.ends_mm(turn);
        CableLengths::new(core::array::from_fn(|k| {
            let span = ends[k] - cables[k].base_mm;
            let Pulley { radius_mm, axis } = cables[k].pulley;
            let z = span.dot(&axis);
            if radius_mm > 0.0 { taut_length(radius_mm, (span - axis * z).norm(), z) } else { span.norm() }
        }))
        .expect("lengths")
    }
}

/// Largest error of an end, mm.
fn error<T: Real>(general: &General, solver: &PlatformSolver<T>, turn: &Rotation3<f64>) -> Result<f64, PlatformError> {
    let lengths = CableLengths::new(general.lengths(turn).as_mm().map(T::of)).expect("lengths");
    let pose = solver.solve(&lengths)?;
    let (rotation, origin) = (pose.rotation.map(Real::to_f64), pose.origin_mm.map(Real::to_f64));
    let truth = general.ends_mm(turn);
    let found = solver.geometry().end_mm.map(|end| origin + rotation * end.map(Real::to_f64));
    Ok(found.iter().zip(truth).map(|(mine, true_end)| (mine - true_end).norm()).fold(0.0, f64::max))
}

fn in_single_precision(general: &General) -> PlatformSolver<f32> {
    let cables = general.rig.cables().expect("ends of its own").map(|cable| CableEnds {
        base_mm: cable.base_mm.map(|x| x as f32),
        end_mm: cable.end_mm.map(|x| x as f32),
        pulley: Pulley { radius_mm: cable.pulley.radius_mm as f32, axis: cable.pulley.axis.map(|x| x as f32) },
    });
    let plain = rig::<f32>(&general.worn);
    PlatformSolver::new(&Rig::with_cables(cables, *plain.drum(), 0.06, *plain.nominal()).expect("a rig"))
}

#[test]
fn ends_of_their_own_give_the_true_pose() {
    let mut rng = rng(4103);
    let (mut lost, mut all) = (0, 0);
    for (name, worn) in machines() {
        let size = worn.base_mm[0].norm() / 150.0;
        for _ in 0..20 {
            for worn in [worn, worn.mirrored()] {
                let general = General::new(worn, &mut rng, 4.0 * size, 0.0);
                let (double, single) = (PlatformSolver::new(&general.rig), in_single_precision(&general));
                for turn in sweep(&mut rng, 50, 45.0, 30.0) {
                    all += 1;
                    // Close to the singularity of the nearest triangles a pose may be lost, never misplaced.
                    match error(&general, &double, &turn) {
                        Ok(off) => assert!(off < 1e-6, "{name}: {off} mm"),
                        Err(error) => {
                            assert_eq!(error, PlatformError::DoesNotClose);
                            lost += 1;
                        }
                    }
                    assert!(error(&general, &single, &turn).is_ok_and(|off| off < 2e-2) || lost > 0, "{name}: single");
                }
            }
        }
    }
    assert!(lost * 200 < all, "{lost} of {all} lost");
}

#[test]
fn pulleys_give_the_true_pose() {
    let mut rng = rng(4104);
    for radius_mm in [2.0, 5.0, 10.0] {
        let general = General::new(shoulder(), &mut rng, 2.0, radius_mm);
        let (double, single) = (PlatformSolver::new(&general.rig), in_single_precision(&general));
        for turn in sweep(&mut rng, 10, 35.0, 25.0) {
            let off = error(&general, &double, &turn).expect("a pose");
            assert!(off < 1e-6, "pulleys of {radius_mm} mm: {off} mm");
            let off = error(&general, &single, &turn).expect("a pose");
            assert!(off < 1e-2, "pulleys of {radius_mm} mm, single precision: {off} mm");
        }
    }
}

#[test]
fn six_ends_on_two_triangles_are_the_machine_of_the_paper() {
    let mut rng = rng(4105);
    for (name, worn) in machines() {
        let general = General::new(worn, &mut rng, 0.0, 0.0);
        let plain = rig::<f64>(&worn);
        let solver = PlatformSolver::new(&plain);
        assert!(Geometry::new(&plain).is_three_three && !Geometry::new(&general.rig).is_three_three);
        for (mine, edge) in general.rig.edges_mm().iter().zip(plain.edges_mm()) {
            assert!((mine - edge).abs() < 1e-9, "{name}");
        }
        for turn in sweep(&mut rng, 50, 45.0, 30.0) {
            let lengths = general.lengths(&turn);
            let (one, other) = (solver.solve(&lengths), PlatformSolver::new(&general.rig).solve(&lengths));
            let (one, other) = (one.expect(name), other.expect(name));
            assert!((one.rotation - other.rotation).amax() < 1e-9, "{name}");
            assert!((one.origin_mm - other.origin_mm).amax() < 1e-7, "{name}");
        }
    }
}

#[test]
fn spans_of_a_geometry_are_those_of_its_cables() {
    let mut rng = rng(4106);
    for (_, worn) in machines() {
        let geometry = Geometry::new(&rig::<f64>(&worn));
        let turn = sweep(&mut rng, 1, 30.0, 20.0)[0];
        let lengths = worn.lengths_mm(&turn);
        let axes = {
            let [p1, p2, p3] = worn.home_mm;
            let x = (p2 - p1).normalize();
            let z = (p2 - p1).cross(&(p3 - p1)).normalize();
            let z = z * z.z.signum();
            Matrix3::from_columns(&[x, z.cross(&x), z])
        };
        for cable in 0..CABLES {
            let end = worn.centre_mm + turn * (worn.home_mm[0] + axes * geometry.end_mm[cable]);
            assert!((geometry.span(cable, &end).length_mm - lengths[cable]).abs() < 1e-9, "cable {}", cable + 1);
        }
    }
}
