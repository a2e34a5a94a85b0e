//! What a pose knows of the centre, against the dense problem in nine unknowns (O, C and the pose's own rotation).
//!
//! The rotation is eliminated here by a Schur complement of the 9x9 normal matrix, and once more by solving the whole
//! problem of several poses at once. The derivatives come from differences of lengths.

use crate::common::dense::{derivative, lengths_mm};
use crate::common::library::{as_cables, rig};
use crate::common::sets::{machines, normal};
use crate::common::{Worn, arm, rng};
use glenoid::identification::blocks::{BlockEquations, Blocks};
use glenoid::identification::pose_information::PoseInformation;
use glenoid::kinematics::{LengthEquations, Pivot, RigPoints};
use glenoid::scalar::Real;
use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, Rotation3, SMatrix, Vector3, Vector6};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

type Rows = SMatrix<f64, 6, 9>;

/// A pose at a wrong estimate, in the dense problem's terms and in the library's.
struct Case {
    /// Derivatives of the six lengths by O, C (in the axes of {P}) and ω.
    rows: Rows,
    /// Measured minus computed lengths, mm.
    residuals: Vector6<f64>,
    rotation: Matrix3<f64>,
    equations: LengthEquations<f64>,
}

fn case(rng: &mut ChaCha8Rng, worn: &Worn, centre_off: Vector3<f64>, platform_off: Vector3<f64>) -> Case {
    let turn = arm(rng, 35.0);
    let [p1, p2, p3] = worn.home_mm;
    let x = (p2 - p1).normalize();
    let z = (p2 - p1).cross(&(p3 - p1)).normalize();
    let z = z * z.z.signum();
    let axes = Matrix3::from_columns(&[x, z.cross(&x), z]);
    let lengths = |step: &SMatrix<f64, 9, 1>| {
        let part = |at: usize| Vector3::new(step[at], step[at + 1], step[at + 2]);
        let centre = worn.centre_mm + centre_off + part(0);
        lengths_mm(worn, &centre, &(platform_off + axes * part(3)), &(Rotation3::new(part(6)) * turn))
    };
    let measured = lengths_mm(worn, &worn.centre_mm, &Vector3::zeros(), &turn).map(|length| length + normal(rng));
    let computed = lengths(&SMatrix::zeros());
    let pivot = Pivot {
        in_base_mm: worn.centre_mm + centre_off,
        in_platform_mm: axes.transpose() * (platform_off - worn.home_mm[0]),
    };
    let rotation = turn.matrix() * axes;
    let points = RigPoints::new(&rig::<f64>(worn));
    Case {
        rows: derivative::<6, 9>(lengths),
        residuals: Vector6::from_fn(|k, _| measured[k] - computed[k]),
        rotation,
        equations: LengthEquations::new(&points, &pivot, &rotation, &as_cables(&measured)),
    }
}

fn offset(rng: &mut ChaCha8Rng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| rng.random_range(-5.0..5.0))
}

/// The symmetric matrix in full.
fn unpacked<T: Real>(equations: &BlockEquations<T>) -> Matrix6<f64> {
    let Blocks { first, mixed, second } = &equations.matrix;
    let (first, second) = (first.to_matrix(), second.to_matrix());
    Matrix6::from_fn(|i, j| match (i < 3, j < 3) {
        (true, true) => first[(i, j)].to_f64(),
        (false, false) => second[(i - 3, j - 3)].to_f64(),
        (false, true) => mixed[(i - 3, j)].to_f64(),
        (true, false) => mixed[(j - 3, i)].to_f64(),
    })
}

/// Asserts that two matrices agree to `relative` of the largest entry.
fn assert_close<const R: usize, const C: usize>(mine: &SMatrix<f64, R, C>, other: &SMatrix<f64, R, C>, relative: f64) {
    let off = (mine - other).amax() / other.amax();
    assert!(off < relative, "off by {off}: {mine} instead of {other}");
}

#[test]
fn information_is_the_schur_complement_of_the_dense_normal_matrix() {
    let mut rng = rng(2201);
    for _ in 0..500 {
        let worn = Worn::random(&mut rng, 20.0);
        let (centre_off, platform_off) = (offset(&mut rng), offset(&mut rng));
        let Case { rows, residuals, rotation, equations } = case(&mut rng, &worn, centre_off, platform_off);
        let normal = rows.transpose() * rows;
        let right = rows.transpose() * residuals;
        let (known, mixed) = (normal.fixed_view::<6, 6>(0, 0), normal.fixed_view::<6, 3>(0, 6));
        let turning = normal.fixed_view::<3, 3>(6, 6).into_owned().try_inverse().expect("a pose has a rotation");
        let expected = known - mixed * turning * mixed.transpose();
        let expected_right = right.fixed_rows::<6>(0) - mixed * turning * right.fixed_rows::<3>(6);

        let pose = PoseInformation::of(&equations).expect("a pose has a rotation");
        // In the first three unknowns J is the identity.
        assert_close(&pose.information.to_matrix(), &expected.fixed_view::<3, 3>(0, 0).into_owned(), 1e-8);
        assert_close(&pose.gradient_mm, &expected_right.fixed_rows::<3>(0).into_owned(), 1e-8);
        let mut summed = BlockEquations::new();
        summed.add_pose(&rotation, &pose.information, &pose.gradient_mm, 1.0);
        assert_close(&unpacked(&summed), &expected, 1e-8);

        // With O and C held, the best rotation and what it leaves.
        let turn = turning * right.fixed_rows::<3>(6);
        assert_close(&pose.turn, &turn, 1e-8);
        let left = (residuals - rows.fixed_columns::<3>(6) * turn).norm_squared();
        assert!((pose.squares_mm2 - left).abs() < 1e-8 * residuals.norm_squared(), "{} or {left}", pose.squares_mm2);
    }
}

#[test]
fn several_poses_give_the_step_of_the_whole_problem() {
    let mut rng = rng(2202);
    for (name, worn) in machines() {
        for count in [3, 5, 12] {
            let (centre_off, platform_off) = (offset(&mut rng), offset(&mut rng));
            let mut dense = DMatrix::zeros(6 * count, 6 + 3 * count);
            let mut right = DVector::zeros(6 * count);
            let mut summed = BlockEquations::new();
            for pose in 0..count {
                let Case { rows, residuals, rotation, equations } = case(&mut rng, &worn, centre_off, platform_off);
                dense.view_mut((6 * pose, 0), (6, 6)).copy_from(&rows.fixed_columns::<6>(0));
                dense.view_mut((6 * pose, 6 + 3 * pose), (6, 3)).copy_from(&rows.fixed_columns::<3>(6));
                right.rows_mut(6 * pose, 6).copy_from(&residuals);
                let known = PoseInformation::of(&equations).expect("a pose has a rotation");
                summed.add_pose(&rotation, &known.information, &known.gradient_mm, 1.0);
            }
            let expected = dense.svd(true, true).solve(&right, 1e-14).expect("a solution");
            let step = summed.solve().expect("poses about many axes");
            for unknown in 0..6 {
                let (mine, other) = (step[unknown], expected[unknown]);
                assert!((mine - other).abs() < 1e-6, "{name}, {count} poses, unknown {unknown}: {mine} or {other}");
            }
        }
    }
}

#[test]
fn information_of_a_pose_is_never_negative() {
    let mut rng = rng(2203);
    for _ in 0..500 {
        let worn = Worn::random(&mut rng, 20.0);
        let Case { equations, .. } = case(&mut rng, &worn, Vector3::zeros(), Vector3::zeros());
        let pose = PoseInformation::of(&equations).expect("a pose has a rotation");
        let information = pose.information.to_matrix();
        assert!(information.symmetric_eigenvalues().min() > -1e-12, "{information}");
        // A length knows at most itself.
        assert!(information.trace() < 6.0, "{information}");
        assert!(pose.squares_mm2 >= 0.0);
    }
}

#[test]
fn cables_without_a_moment_have_no_rotation() {
    let mut rng = rng(2204);
    let (_, worn) = machines()[0];
    let Case { mut equations, .. } = case(&mut rng, &worn, Vector3::zeros(), Vector3::zeros());
    equations.cables.iter_mut().for_each(|cable| cable.moment_mm = Vector3::zeros());
    assert_eq!(PoseInformation::of(&equations), None);
    equations.cables.iter_mut().for_each(|cable| cable.moment_mm = Vector3::new(f64::NAN, 1.0, 1.0));
    assert_eq!(PoseInformation::of(&equations), None);
}
