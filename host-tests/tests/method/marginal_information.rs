//! What a pose knows of the centre, against the dense problem in nine unknowns (O, C and the pose's own rotation).
//!
//! The rotation is eliminated here by a Schur complement of the 9x9 normal matrix, and once more by solving the whole
//! problem of several poses at once. The derivatives come from differences of lengths.

use crate::common::dense::{derivative, lengths_mm};
use crate::common::library::{as_cables, rig};
use crate::common::sets::{machines, normal};
use crate::common::{Worn, arm, rng};
use glenoid::identification::marginal_information::MarginalInformation;
use glenoid::identification::parameters::{CentreFeatures, Column, Equations, ParameterBlock, PoseAt};
use glenoid::identification::pose_in_work::add_pose;
use glenoid::kinematics::{CableLengths, Geometry, JointCentre, LengthJacobian};
use glenoid::linear_algebra::Singular;
use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, SMatrix, Vector3, Vector6};
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
    lengths: CableLengths<f64>,
    jacobian: LengthJacobian<f64>,
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
    let centre = JointCentre {
        in_base_mm: worn.centre_mm + centre_off,
        in_platform_mm: axes.transpose() * (platform_off - worn.home_mm[0]),
    };
    let rotation = turn.matrix() * axes;
    let (geometry, lengths_mm) = (Geometry::new(&rig::<f64>(worn)), as_cables(&measured));
    Case {
        rows: derivative::<6, 9>(lengths),
        residuals: Vector6::from_fn(|k, _| measured[k] - computed[k]),
        rotation,
        lengths: lengths_mm,
        jacobian: LengthJacobian::new(&geometry, &centre, &rotation, &lengths_mm),
    }
}

fn offset(rng: &mut ChaCha8Rng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| rng.random_range(-5.0..5.0))
}

impl Case {
    fn information(&self) -> MarginalInformation<f64> {
        MarginalInformation::new(&self.jacobian).expect("a pose has a rotation")
    }

    /// Adds the pose to the normal equations of O and C.
    fn add_to(&self, equations: &mut Equations<f64>) {
        let at = PoseAt { rotation: &self.rotation, lengths: &self.lengths, jacobian: &self.jacobian };
        add_pose(equations, &CentreOnly, &at, &self.information(), 1.0);
    }
}

/// No parameters beside O and C.
struct CentreOnly;

impl ParameterBlock<f64> for CentreOnly {
    fn constants(&self) -> usize {
        0
    }

    fn column(&self, index: usize, _: &PoseAt<'_, f64>) -> Column<f64> {
        panic!("there is no parameter {index}")
    }

    fn features(&self, _: &Matrix3<f64>) -> CentreFeatures<f64> {
        CentreFeatures::new()
    }

    fn add_prior(&self, _: &mut Equations<f64>, _: usize, _: f64) {}
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
        let case = case(&mut rng, &worn, centre_off, platform_off);
        let (rows, residuals) = (&case.rows, &case.residuals);
        let normal = rows.transpose() * rows;
        let right = rows.transpose() * residuals;
        let (known, mixed) = (normal.fixed_view::<6, 6>(0, 0), normal.fixed_view::<6, 3>(0, 6));
        let turning = normal.fixed_view::<3, 3>(6, 6).into_owned().try_inverse().expect("a pose has a rotation");
        let expected = known - mixed * turning * mixed.transpose();
        let expected_right = right.fixed_rows::<6>(0) - mixed * turning * right.fixed_rows::<3>(6);

        let pose = case.information();
        // In the first three unknowns J is the identity.
        assert_close(&pose.information(), &expected.fixed_view::<3, 3>(0, 0).into_owned(), 1e-8);
        assert_close(&pose.gradient_mm(), &expected_right.fixed_rows::<3>(0).into_owned(), 1e-8);
        // Three independent combinations of the six lengths in which no rotation is left.
        let projector = SMatrix::<f64, 3, 6>::from_columns(&pose.projector());
        assert_close(&(projector * projector.transpose()), &Matrix3::identity(), 1e-12);
        assert!((projector * rows.fixed_columns::<3>(6)).amax() < 1e-9 * rows.amax());
        assert_close(&(projector * rows.fixed_columns::<3>(0)), &pose.translation, 1e-8);
        assert_close(&(projector * residuals), &pose.residuals_mm, 1e-8);
        let mut summed = Equations::new(6);
        case.add_to(&mut summed);
        assert_close(&summed.trailing_matrix::<6>(), &expected, 1e-8);
        let gradient = Vector6::from_fn(|k, _| summed.gradient()[k]);
        assert_close(&gradient, &expected_right, 1e-8);

        // With O and C held, the best rotation and what it leaves.
        let turn = turning * right.fixed_rows::<3>(6);
        assert_close(&pose.turn, &turn, 1e-8);
        let left = (residuals - rows.fixed_columns::<3>(6) * turn).norm_squared();
        assert!((pose.squares_mm2() - left).abs() < 1e-8 * residuals.norm_squared(), "{pose:?} or {left}");
        assert!((summed.squares() - left).abs() < 1e-8 * residuals.norm_squared());
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
            let mut summed = Equations::new(6);
            for pose in 0..count {
                let case = case(&mut rng, &worn, centre_off, platform_off);
                dense.view_mut((6 * pose, 0), (6, 6)).copy_from(&case.rows.fixed_columns::<6>(0));
                dense.view_mut((6 * pose, 6 + 3 * pose), (6, 3)).copy_from(&case.rows.fixed_columns::<3>(6));
                right.rows_mut(6 * pose, 6).copy_from(&case.residuals);
                case.add_to(&mut summed);
            }
            let expected = dense.svd(true, true).solve(&right, 1e-14).expect("a solution");
            summed.factor().expect("poses about many axes");
            let step = summed.step();
            for unknown in 0..6 {
                let (mine, other) = (step[unknown], expected[unknown]);
                assert!((mine - other).abs() < 1e-6, "{name}, {count} poses, unknown {unknown}: {mine} or {other}");
            }
        }
    }
}

#[test]
fn a_pose_that_stands_for_its_own_centre_gives_where_that_is() {
    let mut rng = rng(2205);
    for _ in 0..300 {
        let worn = Worn::random(&mut rng, 20.0);
        let (centre_off, platform_off) = (offset(&mut rng), offset(&mut rng));
        let pose = case(&mut rng, &worn, centre_off, platform_off).information();
        for ridge in [0.0, 0.02] {
            let mut own = pose;
            own.become_own_centre(ridge);
            let expected = (pose.information() + Matrix3::identity() * ridge).lu().solve(&pose.gradient_mm());
            let expected = expected.expect("information in every direction");
            assert!((own.gradient_mm() - expected).norm() < 1e-6 * expected.norm(), "{own:?} instead of {expected}");
            assert!((own.squares_mm2() - expected.norm_squared()).abs() < 1e-6 * expected.norm_squared());
            assert_eq!(own.information(), Matrix3::identity());
        }
    }
}

#[test]
fn information_of_a_pose_is_never_negative() {
    let mut rng = rng(2203);
    for _ in 0..500 {
        let worn = Worn::random(&mut rng, 20.0);
        let pose = case(&mut rng, &worn, Vector3::zeros(), Vector3::zeros()).information();
        let information = pose.information();
        assert!(information.symmetric_eigenvalues().min() > -1e-12, "{information}");
        // A length knows at most itself.
        assert!(information.trace() < 6.0, "{information}");
        assert!(pose.squares_mm2() >= 0.0);
    }
}

#[test]
fn cables_that_do_not_turn_the_platform_give_no_rotation() {
    let mut rng = rng(2204);
    let (_, worn) = machines()[0];
    let Case { mut jacobian, .. } = case(&mut rng, &worn, Vector3::zeros(), Vector3::zeros());
    jacobian.rows.iter_mut().for_each(|row| row.rotation_mm = Vector3::zeros());
    assert_eq!(MarginalInformation::new(&jacobian), Err(Singular));
    jacobian.rows.iter_mut().for_each(|row| row.rotation_mm = Vector3::new(f64::NAN, 1.0, 1.0));
    assert_eq!(MarginalInformation::new(&jacobian), Err(Singular));
}
