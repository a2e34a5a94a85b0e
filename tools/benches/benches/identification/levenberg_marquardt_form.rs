//! The problem as the `levenberg-marquardt` crate wants it: residuals and Jacobian as dynamic matrices of its own nalgebra.

use glenoid::kinematics::BaseEdges;
use glenoid::paper::model::{EvaluatedPose, Model};
use glenoid::rig::Parameters;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra_of_levenberg_marquardt::{Dyn, OMatrix, OVector, U6, VecStorage, Vector6};

use crate::Problem;

/// δE at which the iteration ends, mm.
const TOLERANCE_MM: f64 = 1e-3;

pub struct Form<'a> {
    problem: &'a Problem<f64>,
    base: BaseEdges<f64>,
    parameters: Parameters<f64>,
    /// None where a tetrahedron does not close.
    evaluated: Option<Vec<EvaluatedPose<f64>>>,
    model: Model<f64>,
}

impl<'a> Form<'a> {
    pub fn new(problem: &'a Problem<f64>, start: Parameters<f64>) -> Self {
        let base = BaseEdges::new(&problem.rig);
        let model = Model::new(&base, problem.rig.edges_mm(), &start);
        let mut form = Self { problem, base, parameters: start, evaluated: None, model };
        form.evaluate();
        form
    }

    pub fn minimise(self) -> Parameters<f64> {
        // The residuals end it: see below.
        LevenbergMarquardt::new().minimize(self).0.parameters
    }

    fn evaluate(&mut self) {
        let Self { problem, base, model, .. } = self;
        self.evaluated = problem.poses.iter().map(|lengths| model.evaluate(base, lengths).ok()).collect();
    }
}

impl LeastSquaresProblem<f64, Dyn, U6> for Form<'_> {
    type ResidualStorage = VecStorage<f64, Dyn, nalgebra_of_levenberg_marquardt::U1>;
    type JacobianStorage = VecStorage<f64, Dyn, U6>;
    type ParameterStorage = nalgebra_of_levenberg_marquardt::ArrayStorage<f64, 6, 1>;

    fn set_params(&mut self, x: &Vector6<f64>) {
        self.parameters = Parameters::from_array((*x).into());
        self.model.move_to(&self.base, &self.parameters);
        self.evaluate();
    }

    fn params(&self) -> Vector6<f64> {
        self.parameters.to_array().into()
    }

    /// Computed minus actual edges; none once δE is below the tolerance, which the crate takes as an order to stop.
    fn residuals(&self) -> Option<OVector<f64, Dyn>> {
        let evaluated = self.evaluated.as_ref()?;
        let squares_mm2: f64 = evaluated.iter().map(EvaluatedPose::squares_mm2).sum();
        let rows = 3 * evaluated.len();
        if (squares_mm2 / rows as f64).sqrt() < TOLERANCE_MM {
            return None;
        }
        Some(OVector::<f64, Dyn>::from_iterator(rows, evaluated.iter().flat_map(|pose| pose.residuals_mm.map(|y| -y))))
    }

    fn jacobian(&self) -> Option<OMatrix<f64, Dyn, U6>> {
        let evaluated = self.evaluated.as_ref()?;
        let mut jacobian = OMatrix::<f64, Dyn, U6>::zeros(3 * evaluated.len());
        for (index, pose) in evaluated.iter().enumerate() {
            for (edge, row) in self.model.rows(&self.base, &self.parameters.radii_mm, pose).into_iter().enumerate() {
                for (column, entry) in row.into_iter().enumerate() {
                    jacobian[(3 * index + edge, column)] = entry;
                }
            }
        }
        Some(jacobian)
    }
}
