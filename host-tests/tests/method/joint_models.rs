//! The joint that moves: features and their gradients, their independence of the axes, columns of the Jacobian, and the
//! scatter's elimination, against differences and dense algebra.

use crate::common::dense::derivative;
use crate::common::sets::sweep;
use crate::common::{arm, rng};
use glenoid::identification::Machine;
use glenoid::identification::estimator::Model;
use glenoid::identification::excitation::MeanRotation;
use glenoid::identification::joint::{ArmFrame, FEATURES, Joint, MAX_JOINT, MovingCentre, persistence};
use glenoid::identification::machine::MachineEstimate;
use glenoid::identification::marginal_information::MarginalInformation;
use glenoid::identification::parameters::{Column, Equations, ParameterBlock, PoseAt};
use glenoid::identification::pose_in_work::{add_pose, with_all_columns};
use glenoid::kinematics::{CableLengths, JointCentre, LengthJacobian};
use glenoid::linear_algebra::packed_index;
use glenoid::rig::{Rig, Tolerance};
use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, SMatrix, Vector3};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

fn frame_of(rotations: &[Rotation3<f64>]) -> ArmFrame<f64> {
    let mut mean = MeanRotation::default();
    rotations.iter().for_each(|rotation| mean.add(rotation.matrix()));
    ArmFrame::new(&mean)
}

fn frame(rng: &mut ChaCha8Rng) -> ArmFrame<f64> {
    frame_of(&sweep(rng, 40, 60.0, 40.0))
}

fn features(frame: &ArmFrame<f64>, rotation: &Rotation3<f64>) -> SMatrix<f64, FEATURES, 1> {
    SMatrix::from(frame.features(rotation.matrix()))
}

#[test]
fn the_mean_rotation_is_the_nearest_to_all() {
    let mut rng = rng(4601);
    for _ in 0..50 {
        let first = arm(&mut rng, 170.0);
        let rotations: Vec<_> = sweep(&mut rng, 30, 60.0, 60.0).iter().map(|turn| turn * first).collect();
        let mean = *frame_of(&rotations).mean();
        assert!((mean.tr_mul(&mean) - Matrix3::identity()).amax() < 1e-12 && mean.determinant() > 0.0);
        let apart = |other: &Matrix3<f64>| -> f64 {
            rotations.iter().map(|rotation| (rotation.matrix() - other).norm_squared()).sum()
        };
        let least = apart(&mean);
        for _ in 0..20 {
            let nearby = arm(&mut rng, 2.0).matrix() * mean;
            assert!(apart(&nearby) > least, "{} is no minimum", least);
        }
    }
}

#[test]
fn features_have_their_gradients() {
    let mut rng = rng(4602);
    for _ in 0..200 {
        let frame = frame(&mut rng);
        let rotation = sweep(&mut rng, 1, 80.0, 80.0)[0];
        let expected = derivative::<FEATURES, 3>(|turn| frame.features((Rotation3::new(*turn) * rotation).matrix()));
        for (feature, gradient) in frame.gradients(rotation.matrix()).iter().enumerate() {
            let off = (expected.row(feature).transpose() - gradient).amax();
            assert!(off < 1e-7, "feature {feature}: off by {off}");
        }
    }
}

#[test]
fn features_vanish_at_the_mean_and_know_tilt_from_torsion() {
    let mut rng = rng(4603);
    let frame = frame(&mut rng);
    let mean = Rotation3::from_matrix_unchecked(*frame.mean());
    assert!(features(&frame, &mean).amax() < 1e-12);
    let home = nalgebra::Unit::new_normalize(*frame.home());
    for angle in [-1.2, -0.3, 0.4, 1.5] {
        // About the arm itself: torsion alone.
        let twisted = features(&frame, &(Rotation3::from_axis_angle(&home, angle) * mean));
        assert!(twisted.fixed_rows::<5>(0).amax() < 1e-12 && (twisted[5] - angle).abs() < 1e-12, "{twisted}");
        // Across the arm: no torsion; the direction moves by the chord.
        let across = nalgebra::Unit::new_normalize(home.cross(&Vector3::new(0.3, 0.5, -0.2)));
        let tilted = features(&frame, &(Rotation3::from_axis_angle(&across, angle) * mean));
        assert!(tilted[5].abs() < 1e-12, "{tilted}");
        assert!((tilted.fixed_rows::<3>(0).norm() - 2.0 * (angle / 2.0).sin().abs()).abs() < 1e-12);
        // x² - y² and 2 x y: the squared sine of the tilt, whatever the axis.
        assert!((tilted.fixed_rows::<2>(3).norm() - angle.sin().powi(2)).abs() < 1e-12, "{tilted}");
    }
}

#[test]
fn features_do_not_depend_on_how_the_platforms_axes_are_laid() {
    let mut rng = rng(4604);
    for _ in 0..50 {
        let rotations = sweep(&mut rng, 30, 50.0, 40.0);
        let before = frame_of(&rotations);
        // {P} turned about its own z axis, the arm's.
        let turned = Rotation3::new(Vector3::z() * rng.random_range(-3.0..3.0));
        let renamed: Vec<_> = rotations.iter().map(|rotation| rotation * turned).collect();
        let after = frame_of(&renamed);
        for (one, other) in rotations.iter().zip(&renamed) {
            assert!((features(&before, one) - features(&after, other)).amax() < 1e-9);
        }
    }
}

#[test]
fn a_motion_is_the_same_motion_in_any_base_frame() {
    // {B} turned: the direction turns along, torsion stays, and the quadratic part mixes within itself, so that every
    // motion A φ of the one frame is one of the other.
    let mut rng = rng(4605);
    for _ in 0..20 {
        let rotations = sweep(&mut rng, 60, 50.0, 40.0);
        let turn = arm(&mut rng, 60.0);
        let turned: Vec<_> = rotations.iter().map(|rotation| turn * rotation).collect();
        let (before, after) = (frame_of(&rotations), frame_of(&turned));
        let rows = |frame: &ArmFrame<f64>, set: &[Rotation3<f64>]| {
            DMatrix::from_fn(set.len(), FEATURES, |i, k| features(frame, &set[i])[k])
        };
        let (one, other) = (rows(&before, &rotations), rows(&after, &turned));
        for (i, _) in rotations.iter().enumerate() {
            let direction = |m: &DMatrix<f64>| Vector3::new(m[(i, 0)], m[(i, 1)], m[(i, 2)]);
            assert!((turn * direction(&one) - direction(&other)).amax() < 1e-9);
            assert!((one[(i, 5)] - other[(i, 5)]).abs() < 1e-9);
            let quadratic = |m: &DMatrix<f64>| m[(i, 3)].hypot(m[(i, 4)]);
            assert!((quadratic(&one) - quadratic(&other)).abs() < 1e-9);
        }
        // The features of the new frame are a linear combination of the old ones.
        let mixing = one.clone().svd(true, true).solve(&other, 1e-12).expect("a solution");
        assert!((one * mixing - other).amax() < 1e-8);
    }
}

/// A moving centre with any gains.
fn moving(rng: &mut ChaCha8Rng) -> MovingCentre<f64> {
    let mut moving = MovingCentre::new(frame(rng));
    moving.gains = core::array::from_fn(|_| Vector3::from_fn(|_, _| rng.random_range(-8.0..8.0)));
    moving
}

#[test]
fn the_centre_moves_with_the_rotation_as_its_turning_says() {
    let mut rng = rng(4606);
    for _ in 0..100 {
        let moving = moving(&mut rng);
        let rotation = sweep(&mut rng, 1, 70.0, 60.0)[0];
        let expected =
            derivative::<3, 3>(|turn| moving.displacement_mm((Rotation3::new(*turn) * rotation).matrix()).into());
        let turning = moving.turning(rotation.matrix());
        assert!((turning - expected).amax() < 1e-6, "{turning} instead of {expected}");
    }
}

#[test]
fn features_of_the_joint_are_the_derivatives_of_the_centre() {
    let mut rng = rng(4607);
    let moving = moving(&mut rng);
    let rotation = *sweep(&mut rng, 1, 60.0, 50.0)[0].matrix();
    let joint = Joint::Moving(moving);
    assert_eq!((joint.count(), Joint::<f64>::Ball.count()), (MAX_JOINT, 0));
    let features = joint.features(&rotation);
    assert_eq!((features.len(), Joint::Ball.features(&rotation).len()), (FEATURES, 0));
    let centre = JointCentre::from_array(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    for index in 0..MAX_JOINT {
        let expected = derivative::<3, 1>(|by| {
            let mut step = [0.0; MAX_JOINT];
            step[index] = by[0];
            let mut moved = joint.clone();
            moved.apply(&step);
            moved.centre_at(&centre, &rotation).in_base_mm.into()
        });
        let mine = Vector3::ith(index % 3, features[index / 3]);
        assert!((mine - expected).amax() < 1e-9, "parameter {index}: {mine} instead of {expected}");
    }
}

/// A pose of a machine with everything unknown and a joint that moves.
struct Scene {
    machine: Machine<f64>,
    estimate: MachineEstimate<f64>,
    joint: Joint<f64>,
    rotation: Matrix3<f64>,
    lengths: CableLengths<f64>,
    jacobian: LengthJacobian<f64>,
}

impl Scene {
    fn new(rng: &mut ChaCha8Rng) -> Self {
        let tolerance = Tolerance { base_mm: 0.5, edges_mm: 0.5, offset_mm: 0.3, drum: 1e-3 };
        let rig = Rig::<f64>::shoulder(150.0).expect("a rig").with_tolerance(tolerance).expect("a tolerance");
        let machine = Machine::new(&rig);
        let joint = Joint::Moving(moving(rng));
        let rotation = *arm(rng, 35.0).matrix();
        let lengths = CableLengths::new(core::array::from_fn(|_| rng.random_range(220.0..330.0))).expect("lengths");
        let centre = JointCentre::from_parameters(rig.nominal(), machine.geometry());
        let jacobian = LengthJacobian::new(machine.geometry(), &centre, &rotation, &lengths);
        let estimate = MachineEstimate::new(&machine);
        Self { machine, estimate, joint, rotation, lengths, jacobian }
    }

    /// The six rows of the pose by all unknowns (block, O, C), then by the scatter and the rotation.
    fn rows(&self) -> (DMatrix<f64>, SMatrix<f64, 6, 3>, SMatrix<f64, 6, 3>, DVector<f64>) {
        let at = self.at();
        let model = self.model();
        let (constants, features) = (model.constants(), model.features(&self.rotation));
        let count = constants + 3 * features.len();
        let u = SMatrix::<f64, 6, 3>::from_fn(|k, j| self.jacobian.rows[k].translation[j]);
        let g = SMatrix::<f64, 6, 3>::from_fn(|k, j| self.jacobian.rows[k].rotation_mm[j]);
        let mut rows = DMatrix::zeros(6, count + 6);
        for x in 0..constants {
            let column = match model.column(x, &at) {
                Column::OneCable(cable, change) => DVector::from_fn(6, |k, _| if k == cable { change } else { 0.0 }),
                Column::AllCables(changes) => DVector::from_row_slice(&changes),
            };
            rows.set_column(x, &column);
        }
        for (j, feature) in features.iter().enumerate() {
            rows.view_mut((0, constants + 3 * j), (6, 3)).copy_from(&(u * *feature));
        }
        rows.view_mut((0, count), (6, 3)).copy_from(&u);
        rows.view_mut((0, count + 3), (6, 3)).copy_from(&-(u * self.rotation));
        let residuals = DVector::from_fn(6, |k, _| self.jacobian.rows[k].residual_mm);
        (rows, u, g, residuals)
    }

    fn at(&self) -> PoseAt<'_, f64> {
        PoseAt { rotation: &self.rotation, lengths: &self.lengths, jacobian: &self.jacobian }
    }

    fn model(&self) -> Model<'_, f64> {
        Model { machine: &self.machine, estimate: &self.estimate, joint: &self.joint }
    }
}

#[test]
fn scatter_and_rotation_are_eliminated_as_in_the_dense_problem() {
    let mut rng = rng(4608);
    for scatter in [0.0, 0.3, 40.0] {
        for _ in 0..30 {
            let scene = Scene::new(&mut rng);
            let (rows, u, g, residuals) = scene.rows();
            // A length varies by its noise and by the scatter of the centre seen along its cable: V = 1 + scatter U Uᵀ.
            let weight =
                (SMatrix::<f64, 6, 6>::identity() + u * u.transpose() * scatter).try_inverse().expect("regular");
            let turned = (g.transpose() * weight * g).try_inverse().expect("a pose has a rotation");
            let projected = weight - weight * g * turned * g.transpose() * weight;
            let projected = DMatrix::from_fn(6, 6, |i, j| projected[(i, j)]);
            let expected = rows.transpose() * &projected * &rows;
            let expected_gradient = rows.transpose() * &projected * &residuals;
            let expected_squares = residuals.dot(&(&projected * &residuals));

            let at = scene.at();
            let information = MarginalInformation::new(&scene.jacobian).expect("a pose has a rotation");
            let mut scattered = information;
            scattered.add_scatter(scatter);
            let unknowns = rows.ncols();
            let mut equations = Equations::<f64>::new(unknowns);
            let model = scene.model();
            add_pose(&mut equations, &model, &at, &scattered, 1.0);
            let close = 1e-9 * expected.amax();
            for i in 0..unknowns {
                for j in 0..=i {
                    let entry = equations.matrix()[glenoid::linear_algebra::packed_index(i, j)];
                    assert!((entry - expected[(i, j)]).abs() < close, "scatter {scatter}: {i}, {j}: {entry}");
                }
                let off = (equations.gradient()[i] - expected_gradient[i]).abs();
                assert!(off < 1e-9 * expected_gradient.amax(), "scatter {scatter}: gradient {i} off by {off}");
            }
            assert!((equations.squares() - expected_squares).abs() < 1e-9 * residuals.norm_squared());

            // How S δ̂ changes with the unknowns: the rows of O of the normal matrix.
            let first = unknowns - 6;
            let in_work = with_all_columns(&model, &at, &scattered);
            for (axis, row) in in_work.sensitivity().iter().enumerate() {
                for j in 0..unknowns {
                    assert!((row[j] - expected[(first + axis, j)]).abs() < close, "sensitivity {axis}, {j}");
                }
            }
            // Without the centre's path, which gains and O move: that makes the rest, times S.
            let of_path = first - MAX_JOINT..first + 3;
            let s = expected.view((first, first), (3, 3));
            assert!((in_work.information() - s).amax() < close);
            for (axis, row) in in_work.sensitivity_beside_path().iter().enumerate() {
                for j in 0..unknowns {
                    let other = if of_path.contains(&j) { 0.0 } else { expected[(first + axis, j)] };
                    assert!((row[j] - other).abs() < close, "beside the path {axis}, {j}");
                }
            }
        }
    }
}

/// The variance of the mean of an autoregression, by many of them, over that of white noise. What chance makes of a
/// correlation, up to 0.15, widens nothing.
#[test]
fn a_scatter_that_persists_widens_the_variance_of_a_mean_as_simulated() {
    let mut random = rng(3);
    let mut normal = || (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
    for rho in [0.0, 0.3, 0.6] {
        let length = 400;
        let means: Vec<f64> = (0..4_000)
            .map(|_| {
                let mut value = normal();
                let mut next = || {
                    value = rho * value + (1.0_f64 - rho * rho).sqrt() * normal();
                    value
                };
                (0..length).map(|_| next()).sum::<f64>() / f64::from(length)
            })
            .collect();
        let variance = means.iter().map(|mean| mean * mean).sum::<f64>() / means.len() as f64;
        let (found, expected) = (variance * f64::from(length), persistence(rho + 0.15));
        assert!((found / expected - 1.0).abs() < 0.08, "{rho}: {found} {expected}");
    }
    assert_eq!((persistence(0.1), persistence(-0.9)), (1.0, 1.0));
    assert!(persistence(f64::NAN) <= 9.01 && persistence(5.0) <= 9.01);
}

/// The columns of torsion and trefoils: the gradient is half the fall of the squares, the matrix its change.
#[test]
fn the_prior_of_the_last_columns_is_a_parabola() {
    let mut rng = rng(4617);
    let mut moving = MovingCentre::new(frame(&mut rng));
    moving.gains = std::array::from_fn(|_| Vector3::from_fn(|_, _| rng.random_range(-6.0..6.0)));
    let prior = |moving: &MovingCentre<f64>| {
        let mut equations = Equations::new(MAX_JOINT);
        moving.add_prior(&mut equations, 0, 0.01);
        equations
    };
    let at = prior(&moving);
    for unknown in 15..MAX_JOINT {
        let moved = |by: f64| {
            let mut moved = moving;
            moved.gains[unknown / 3][unknown % 3] += by;
            prior(&moved).squares()
        };
        let (above, below) = (moved(0.1), moved(-0.1));
        let gradient = at.gradient()[unknown];
        assert!((gradient + (above - below) / 0.4).abs() < 1e-9, "{unknown}: {gradient}");
        assert_ne!(gradient, 0.0);
        let curvature = (above + below - 2.0 * at.squares()) / 0.02;
        let diagonal = at.matrix()[packed_index(unknown, unknown)];
        assert!((diagonal - curvature).abs() < 1e-9, "{unknown}: {diagonal}, {curvature}");
    }
}
