//! What a result says of the machine's constants, each with its standard deviation.

use glenoid::identification::{Estimator, Machine};
use glenoid::kinematics::Geometry;
use glenoid::rig::CABLES;
use glenoid::scalar::Real;
use nalgebra::DMatrix;
use serde::Serialize;

/// The constants that were not known exactly, as they were estimated.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MachineReport {
    /// Distances B1B2, B2B3, B3B1 (of the nearest triangle), mm.
    pub base_edges_mm: [f64; 3],
    /// 1σ of the same, mm.
    pub base_edges_sigma_mm: [f64; 3],
    /// Platform edges p12, p23, p31 (of the nearest triangle), mm.
    pub edges_mm: [f64; 3],
    /// 1σ of the same, mm.
    pub edges_sigma_mm: [f64; 3],
    /// What each reading is too much, mm.
    pub zeros_mm: [f64; CABLES],
    /// 1σ of the same, mm.
    pub zeros_sigma_mm: [f64; CABLES],
    /// How much cable each drum pays out for 1 mm stated.
    pub drum_scale: [f64; CABLES],
    /// 1σ of the same.
    pub drum_scale_sigma: [f64; CABLES],
}

impl MachineReport {
    /// Of an estimator at its end; `None` for a machine that is exactly known.
    pub fn of<T: Real>(estimator: &Estimator<T>, machine: &Machine<T>, noise_mm: T) -> Option<Self> {
        let count = machine.parameters();
        if count == 0 {
            return None;
        }
        let estimate = estimator.machine_estimate();
        let columns: Vec<_> = (0..count).map(|index| estimator.covariance_column(index)).collect();
        let variance = noise_mm.to_f64() * noise_mm.to_f64();
        let covariance = DMatrix::from_fn(count, count, |i, j| columns[j][i].to_f64() * variance);
        let sigma_of = |derivative: &dyn Fn(usize) -> f64| {
            let row = nalgebra::DVector::from_fn(count, |i, _| derivative(i));
            row.dot(&(&covariance * &row)).max(0.0).sqrt()
        };
        // A step of one parameter moves the edges; linear enough over a tenth of a millimetre.
        let moved = |index: usize| {
            let mut other = estimate.clone();
            let mut step = [T::zero(); glenoid::identification::machine::MAX_MACHINE];
            step[index] = T::of(0.1);
            other.apply(machine, &step);
            *other.geometry()
        };
        let edges = |edges_of: &dyn Fn(&Geometry<T>) -> [f64; 3]| {
            let now = edges_of(estimate.geometry());
            let change: Vec<[f64; 3]> = (0..count).map(|index| edges_of(&moved(index))).collect();
            let sigma = std::array::from_fn(|edge| sigma_of(&|i| (change[i][edge] - now[edge]) / 0.1));
            (now, sigma)
        };
        let (base_edges_mm, base_edges_sigma_mm) = edges(&|geometry| sides(&base_points(geometry)));
        let (edges_mm, edges_sigma_mm) = edges(&|geometry| sides(&geometry.end_points_mm().map(|p| p.map(T::to_f64))));
        let six = |first: Option<usize>, unit: f64| {
            std::array::from_fn(|k| {
                first.map_or(0.0, |first| unit * covariance[(first + k, first + k)].max(0.0).sqrt())
            })
        };
        Some(Self {
            base_edges_mm,
            base_edges_sigma_mm,
            edges_mm,
            edges_sigma_mm,
            zeros_mm: estimate.offsets_mm().map(T::to_f64),
            zeros_sigma_mm: six(machine.first_offset(), 1.0),
            drum_scale: estimate.scales().map(|scale| 1.0 + scale.to_f64()),
            drum_scale_sigma: six(machine.first_scale(), glenoid::identification::machine::SCALE_UNIT),
        })
    }
}

fn base_points<T: Real>(geometry: &Geometry<T>) -> [nalgebra::Vector3<f64>; 3] {
    let base = geometry.base_mm.map(|point| point.map(T::to_f64));
    [(base[5] + base[0]) / 2.0, (base[1] + base[2]) / 2.0, (base[3] + base[4]) / 2.0]
}

fn sides(points: &[nalgebra::Vector3<f64>; 3]) -> [f64; 3] {
    let [a, b, c] = points;
    [(b - a).norm(), (c - b).norm(), (a - c).norm()]
}
