//! A fit of all poses alike, none weighted down or left out: the ground on which explanations are compared.
//!
//! Of each pose's six lengths three combinations are kept that its own rotation does not change (an orthonormal basis of
//! the complement of the rotation's columns). In these rows the model is linear in O, C, the machine's constants and
//! whatever is tried beside them, and everything is in units of the noise.

use glenoid::identification::joint::{ArmFrame, SHOWN_FEATURES};
use glenoid::identification::machine::{MAX_MACHINE, MachineEstimate};
use glenoid::identification::parameters::{Column, Equations, PoseAt};
use glenoid::identification::pivot_calibration::PivotCalibration;
use glenoid::identification::{Machine, Pose};
use glenoid::kinematics::rotation::rotation_of;
use glenoid::kinematics::{AttitudeSolver, CableLengths, CableSet, JointCentre, LengthJacobian};
use glenoid::linear_algebra::packed_index;
use nalgebra::{DMatrix, DVector, Matrix3, Matrix3x6, Matrix6, Matrix6x3, UnitQuaternion, Vector3, Vector6};

/// Share of the poses that must have a place by themselves.
const MIN_PLACED: f64 = 0.7;
const MAX_STEPS: usize = 15;
/// Largest step at which the fit has settled, mm.
const SETTLED_MM: f64 = 1e-6;
/// A joint centre moves by less than this, 1σ, mm/rad: bounds the one combination that no length shows.
const MOTION_PRIOR_MM: f64 = 10.0;
/// Variance of the scatter at the start, and its least, mm².
const FIRST_SCATTER_MM2: f64 = 0.09;
const LEAST_SCATTER_MM2: f64 = 1e-4;

/// What the joint centre may do beside standing still.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Freedom {
    /// It scatters from pose to pose.
    pub scatters: bool,
    /// It moves with the arm.
    pub moves: bool,
}

/// One pose in the fit.
#[derive(Clone, Debug)]
pub struct FittedPose {
    /// Rotation from {P} to {B}.
    pub rotation: Matrix3<f64>,
    /// Derivatives of the lengths with a translation of the platform.
    pub translation: Matrix6x3<f64>,
    /// Modelled lengths, mm.
    pub modelled_mm: Vector6<f64>,
    /// From six lengths to the three rows, over the noise.
    pub rows: Matrix3x6<f64>,
    /// Derivative of the rows with the unknowns: machine, motion, O, C.
    pub jacobian: DMatrix<f64>,
    /// The rows' residuals.
    pub residual: Vector3<f64>,
}

/// The fit.
#[derive(Clone, Debug)]
pub struct AllPosesFit {
    /// The poses.
    pub poses: Vec<FittedPose>,
    /// Covariance of the unknowns.
    pub covariance: DMatrix<f64>,
    /// χ² of the poses and of the priors.
    pub chi_square: f64,
    /// Minus twice the logarithm of the likelihood, but for a constant.
    pub likelihood: f64,
    /// Degrees of freedom.
    pub freedom: f64,
    /// Scatter of the joint centre, 1σ an axis, mm.
    pub scatter_mm: f64,
    /// The joint centre.
    pub centre: JointCentre<f64>,
    /// The machine.
    pub estimate: MachineEstimate<f64>,
}

struct Work<'a> {
    machine: &'a Machine<f64>,
    noise_mm: f64,
    frame: Option<ArmFrame<f64>>,
    estimate: MachineEstimate<f64>,
    centre: JointCentre<f64>,
    motion: [Vector3<f64>; SHOWN_FEATURES],
    scatter_mm2: f64,
    log_determinants: f64,
}

impl AllPosesFit {
    /// Fits all poses. `None` when they have no place, or determine no centre.
    pub fn new(machine: &Machine<f64>, lengths: &[CableLengths<f64>], noise_mm: f64, freedom: Freedom) -> Option<Self> {
        let poses: Vec<_> = lengths.iter().map(|lengths| Pose::placed(machine.platform(), *lengths).ok()).collect();
        let mut pivot = PivotCalibration::default();
        poses.iter().flatten().for_each(|pose| pivot.add(&pose.platform()));
        if (poses.iter().flatten().count() as f64) < MIN_PLACED * lengths.len() as f64 {
            return None;
        }
        let mut work = Work {
            machine,
            noise_mm,
            frame: freedom.moves.then(|| ArmFrame::new(pivot.rotations())),
            estimate: MachineEstimate::new(machine),
            centre: pivot.solve().ok()?,
            motion: [Vector3::zeros(); SHOWN_FEATURES],
            scatter_mm2: if freedom.scatters { FIRST_SCATTER_MM2 } else { 0.0 },
            log_determinants: 0.0,
        };
        let solver = AttitudeSolver { geometry: machine.geometry(), centre: &work.centre };
        let attitude = |(pose, lengths): (&Option<Pose<f64>>, &CableLengths<f64>)| match pose {
            Some(pose) => Some(*pose.attitude()),
            None => Some(solver.solve(lengths, CableSet::ALL)?.attitude),
        };
        let mut attitudes: Vec<_> = poses.iter().zip(lengths).map(attitude).collect::<Option<_>>()?;
        for _ in 0..MAX_STEPS {
            work.turn(lengths, &mut attitudes);
            let (equations, gradient, fitted, chi_square) = work.linearise(lengths, &attitudes)?;
            let step = equations.cholesky()?.solve(&gradient);
            work.apply(&step);
            let scatter_before = work.scatter_mm2;
            if freedom.scatters {
                work.improve_scatter(&fitted, chi_square, lengths.len());
            }
            if step.amax() < SETTLED_MM && (work.scatter_mm2 - scatter_before).abs() < 1e-4 * scatter_before.max(1e-6) {
                break;
            }
        }
        work.turn(lengths, &mut attitudes);
        let (equations, _, poses, chi_square) = work.linearise(lengths, &attitudes)?;
        Some(Self {
            poses,
            covariance: equations.cholesky()?.inverse(),
            chi_square,
            likelihood: chi_square + work.log_determinants,
            freedom: work.freedom(lengths.len()),
            scatter_mm: work.scatter_mm2.sqrt(),
            centre: work.centre,
            estimate: work.estimate,
        })
    }
}

impl Work<'_> {
    fn motion_unknowns(&self) -> usize {
        if self.frame.is_some() { 3 * SHOWN_FEATURES } else { 0 }
    }

    fn freedom(&self, poses: usize) -> f64 {
        (3 * poses) as f64 - 6.0 - self.motion_unknowns() as f64
    }

    fn centre_at(&self, rotation: &Matrix3<f64>) -> JointCentre<f64> {
        let moved: Vector3<f64> = match &self.frame {
            Some(frame) => frame.features(rotation).iter().zip(&self.motion).map(|(phi, a)| a * *phi).sum(),
            None => Vector3::zeros(),
        };
        JointCentre { in_base_mm: self.centre.in_base_mm + moved, ..self.centre }
    }

    /// Each pose's own rotation at its best.
    fn turn(&self, lengths: &[CableLengths<f64>], attitudes: &mut [UnitQuaternion<f64>]) {
        for (attitude, lengths) in attitudes.iter_mut().zip(lengths) {
            let centre = self.centre_at(&rotation_of(attitude));
            let solver = AttitudeSolver { geometry: self.estimate.geometry(), centre: &centre };
            let lengths = self.estimate.corrected(self.machine, lengths);
            if let Some(fit) = solver.track(*attitude, &lengths, CableSet::ALL) {
                *attitude = fit.attitude;
            }
        }
    }

    /// Normal matrix, gradient, the poses, and χ².
    #[allow(clippy::type_complexity)]
    fn linearise(
        &mut self,
        lengths: &[CableLengths<f64>],
        attitudes: &[UnitQuaternion<f64>],
    ) -> Option<(DMatrix<f64>, DVector<f64>, Vec<FittedPose>, f64)> {
        let parameters = self.machine.parameters();
        let count = parameters + self.motion_unknowns() + 6;
        let (mut matrix, mut gradient) = (DMatrix::zeros(count, count), DVector::zeros(count));
        let mut chi_square = self.add_priors(&mut matrix, &mut gradient);
        self.log_determinants = 0.0;
        let mut fitted = Vec::with_capacity(lengths.len());
        for (lengths, attitude) in lengths.iter().zip(attitudes) {
            let pose = self.pose(lengths, attitude, count)?;
            matrix += pose.jacobian.tr_mul(&pose.jacobian);
            gradient += pose.jacobian.tr_mul(&pose.residual);
            chi_square += pose.residual.norm_squared();
            fitted.push(pose);
        }
        Some((matrix, gradient, fitted, chi_square))
    }

    fn add_priors(&self, matrix: &mut DMatrix<f64>, gradient: &mut DVector<f64>) -> f64 {
        let parameters = self.machine.parameters();
        let mut priors = Box::new(Equations::new(parameters));
        self.estimate.add_prior(self.machine, &mut priors, 0, 1.0);
        for i in 0..parameters {
            gradient[i] += priors.gradient()[i];
            for j in 0..parameters {
                matrix[(i, j)] += priors.matrix()[packed_index(i.max(j), i.min(j))];
            }
        }
        let precision = MOTION_PRIOR_MM.powi(-2);
        for index in 0..self.motion_unknowns() {
            let value = self.motion[index / 3][index % 3];
            matrix[(parameters + index, parameters + index)] += precision;
            gradient[parameters + index] -= value * precision;
        }
        let values = DVector::from_fn(parameters, |i, _| self.estimate.values()[i]);
        let of_machine = values.dot(&(matrix.view((0, 0), (parameters, parameters)) * &values));
        of_machine + precision * self.motion.iter().map(Vector3::norm_squared).sum::<f64>()
    }

    fn pose(
        &mut self,
        lengths: &CableLengths<f64>,
        attitude: &UnitQuaternion<f64>,
        count: usize,
    ) -> Option<FittedPose> {
        let lengths = self.estimate.corrected(self.machine, lengths);
        let rotation = rotation_of(attitude);
        let centre = self.centre_at(&rotation);
        let jacobian = LengthJacobian::new(self.estimate.geometry(), &centre, &rotation, &lengths);
        let translation = Matrix6x3::from_fn(|k, axis| jacobian.rows[k].translation[axis]);
        let residual_mm = Vector6::from_fn(|k, _| jacobian.rows[k].residual_mm);
        let turning = Matrix6x3::from_fn(|k, axis| jacobian.rows[k].rotation_mm[axis]);
        let mut rows = complement(&turning)? / self.noise_mm;
        // Scatter of the centre is noise along the translations.
        let seen = rows * translation;
        let covariance = Matrix3::identity() + seen * seen.transpose() * self.scatter_mm2;
        let factor = covariance.cholesky()?;
        self.log_determinants += 2.0 * factor.l().diagonal().map(f64::ln).sum();
        rows = factor.l().try_inverse()? * rows;

        let parameters = self.machine.parameters();
        let mut whole = DMatrix::zeros(6, count);
        let at = PoseAt { rotation: &rotation, lengths: &lengths, jacobian: &jacobian };
        for index in 0..parameters {
            let column = by_cable(self.estimate.column(self.machine, index, &at));
            whole.set_column(index, &column);
        }
        if let Some(frame) = &self.frame {
            for (feature, phi) in frame.features(&rotation).into_iter().take(SHOWN_FEATURES).enumerate() {
                whole.view_mut((0, parameters + 3 * feature), (6, 3)).copy_from(&(translation * phi));
            }
        }
        whole.view_mut((0, count - 6), (6, 3)).copy_from(&translation);
        whole.view_mut((0, count - 3), (6, 3)).copy_from(&(-translation * rotation));
        Some(FittedPose {
            jacobian: DMatrix::from_column_slice(3, count, (rows * whole).as_slice()),
            residual: rows * residual_mm,
            modelled_mm: Vector6::from_fn(|k, _| lengths.as_mm()[k]) - residual_mm,
            rotation,
            translation,
            rows,
        })
    }

    fn apply(&mut self, step: &DVector<f64>) {
        let parameters = self.machine.parameters();
        let mut of_machine = [0.0; MAX_MACHINE];
        of_machine[..parameters].copy_from_slice(&step.as_slice()[..parameters]);
        self.estimate.apply(self.machine, &of_machine);
        for index in 0..self.motion_unknowns() {
            self.motion[index / 3][index % 3] += step[parameters + index];
        }
        let centre = &step.as_slice()[step.len() - 6..];
        self.centre.in_base_mm += Vector3::from_column_slice(&centre[..3]);
        self.centre.in_platform_mm += Vector3::from_column_slice(&centre[3..]);
    }

    /// Newton on χ² = its degrees of freedom.
    fn improve_scatter(&mut self, poses: &[FittedPose], chi_square: f64, count: usize) {
        let falls = |pose: &FittedPose| (pose.rows * pose.translation).tr_mul(&pose.residual).norm_squared();
        let sensitivity: f64 = poses.iter().map(falls).sum();
        let improved = self.scatter_mm2 + (chi_square - self.freedom(count)) / sensitivity.max(1e-9);
        self.scatter_mm2 = improved.max(self.scatter_mm2 / 10.0).max(LEAST_SCATTER_MM2);
    }
}

/// A column of the machine's, cable by cable.
pub fn by_cable(column: Column<f64>) -> Vector6<f64> {
    match column {
        Column::AllCables(values) => Vector6::from(values),
        Column::OneCable(cable, value) => Vector6::ith(cable, value),
    }
}

/// Three orthonormal rows that are orthogonal to the three columns.
fn complement(columns: &Matrix6x3<f64>) -> Option<Matrix3x6<f64>> {
    let eigen = (columns * columns.transpose()).symmetric_eigen();
    let mut order: Vec<usize> = (0..6).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
    let vectors: &Matrix6<f64> = &eigen.eigenvectors;
    let is_turning = eigen.eigenvalues[order[3]] > 1e-9 * eigen.eigenvalues[order[5]];
    is_turning.then(|| Matrix3x6::from_fn(|row, cable| vectors[(cable, order[row])]))
}
