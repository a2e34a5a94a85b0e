//! The machine's constants by name: as stated, as found, and how well each is known before and after.

use glenoid::identification::Machine;
use glenoid::identification::machine::{MAX_MACHINE, MachineEstimate, SCALE_UNIT};
use glenoid::kinematics::Geometry;
use glenoid::linear_algebra::packed_index;
use glenoid::rig::CABLES;
use nalgebra::{DMatrix, DVector, Vector3};
use serde::Serialize;

/// One constant.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Constant {
    /// Its name.
    pub name: String,
    /// "mm", or "" for a ratio.
    pub unit: &'static str,
    /// As stated.
    pub stated: f64,
    /// As found.
    pub found: f64,
    /// 1σ as stated.
    pub stated_sigma: f64,
    /// 1σ as found.
    pub sigma: f64,
}

impl Constant {
    /// What is left of the standard deviation.
    pub fn share_left(&self) -> f64 {
        self.sigma / self.stated_sigma
    }

    /// How far it is from what was stated, in stated standard deviations.
    pub fn times_off(&self) -> f64 {
        ((self.found - self.stated) / self.stated_sigma).abs()
    }
}

/// Covariance of the priors, in the order and units of [`Machine::parameter`].
pub fn prior_covariance(precision: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    precision.clone().cholesky().map(|factor| factor.inverse())
}

/// The lower triangle of a symmetric matrix, row by row.
pub fn packed(matrix: &DMatrix<f64>) -> Vec<f64> {
    let mut triangle = vec![0.0; packed_index(matrix.nrows(), 0)];
    for i in 0..matrix.nrows() {
        for j in 0..=i {
            triangle[packed_index(i, j)] = matrix[(i, j)];
        }
    }
    triangle
}

/// The geometry with one parameter further by one unit: linear in each.
pub fn moved(machine: &Machine<f64>, estimate: &MachineEstimate<f64>, index: usize, by: f64) -> Geometry<f64> {
    let mut other = estimate.clone();
    let mut step = [0.0; MAX_MACHINE];
    step[index] = by;
    other.apply(machine, &step);
    *other.geometry()
}

/// The constants that have a tolerance.
pub fn named(
    machine: &Machine<f64>,
    estimate: &MachineEstimate<f64>,
    before: &DMatrix<f64>,
    after: &DMatrix<f64>,
) -> Vec<Constant> {
    let count = machine.parameters();
    let sigma = |covariance: &DMatrix<f64>, row: &DVector<f64>| row.dot(&(covariance * row)).max(0.0).sqrt();
    let mut constants = Vec::new();
    let mut push = |name: String, unit, stated, found, row: DVector<f64>| {
        let (stated_sigma, sigma) = (sigma(before, &row), sigma(after, &row));
        // What no parameter moves has no tolerance.
        if stated_sigma > 0.0 {
            constants.push(Constant { name, unit, stated, found, stated_sigma, sigma });
        }
    };
    // A step of a tenth of a millimetre is linear enough.
    let step = 0.1;
    type Sides = fn(&Geometry<f64>) -> [f64; 3];
    for (letter, sides) in [("B", base_sides as Sides), ("P", platform_edges)] {
        let (stated, found) = (sides(machine.geometry()), sides(estimate.geometry()));
        for (side, (i, j)) in [(1, 2), (2, 3), (3, 1)].into_iter().enumerate() {
            let change = |index: usize| (sides(&moved(machine, estimate, index, step))[side] - found[side]) / step;
            let row = DVector::from_fn(count, |index, _| change(index));
            push(format!("{letter}{i}{letter}{j}"), "mm", stated[side], found[side], row);
        }
    }
    let unit_vector = |index: usize, unit: f64| {
        let mut row = DVector::zeros(count);
        row[index] = unit;
        row
    };
    if let Some(first) = machine.first_offset() {
        let offsets = estimate.offsets_mm();
        for cable in 0..CABLES {
            push(format!("zero {}", cable + 1), "mm", 0.0, offsets[cable], unit_vector(first + cable, 1.0));
        }
    }
    if let Some(first) = machine.first_scale() {
        let scales = estimate.scales();
        for cable in 0..CABLES {
            push(format!("drum {}", cable + 1), "", 1.0, 1.0 + scales[cable], unit_vector(first + cable, SCALE_UNIT));
        }
    }
    constants
}

fn base_sides(geometry: &Geometry<f64>) -> [f64; 3] {
    let base = &geometry.base_mm;
    sides(&[(base[5] + base[0]) / 2.0, (base[1] + base[2]) / 2.0, (base[3] + base[4]) / 2.0])
}

fn platform_edges(geometry: &Geometry<f64>) -> [f64; 3] {
    sides(&geometry.end_points_mm())
}

fn sides([a, b, c]: &[Vector3<f64>; 3]) -> [f64; 3] {
    [(b - a).norm(), (c - b).norm(), (a - c).norm()]
}
