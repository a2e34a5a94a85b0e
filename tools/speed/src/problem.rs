//! The problem that everything is measured on: 100 noise-free poses of a rig with a base radius of 160 mm, rotations
//! within ±30 degrees about each axis, and a start from which the paper's iteration takes four steps.

use glenoid::identification::PoseBuffer;
use glenoid::kinematics::CableLengths;
use glenoid::rig::{CABLES, Drum, Parameters, Rig, RigError};
use glenoid::scalar::Real;
use nalgebra::Vector3;

mod constants {
    //! `host-tests/data/speed-problem.csv` and `.toml`, by `build.rs`.
    include!(concat!(env!("OUT_DIR"), "/speed_problem.rs"));
}

pub use constants::POSES;

/// Noise that the start-free solver is told of, mm. The lengths have none; the figure only sets the gates.
const NOISE_MM: f64 = 0.057_735;

/// The problem in one precision.
pub struct Problem<T> {
    pub rig: Rig<T>,
    pub start: Parameters<T>,
    pub truth: Parameters<T>,
    pub poses: PoseBuffer<T, POSES>,
    /// The same lengths as the literal form takes them.
    pub lengths_mm: [[T; CABLES]; POSES],
}

impl<T: Real> Problem<T> {
    pub fn new() -> Result<Self, RigError> {
        let truth = parameters(&constants::TRUTH_MM);
        let drum = Drum {
            radius_mm: T::of(15.0),
            counts_per_turn: T::of(4096.0),
            home_length_mm: [T::of(270.0); CABLES],
            fastest_mm_per_s: T::of(1500.0),
        };
        let base = constants::BASE_MM.map(|point| Vector3::from(point.map(T::of)));
        let rig = Rig::new(base, constants::EDGES_MM.map(T::of), drum, T::of(NOISE_MM), truth)?;
        let mut poses = PoseBuffer::new();
        let lengths_mm = constants::LENGTHS_MM.map(|row| row.map(T::of));
        for row in lengths_mm {
            if let Ok(lengths) = CableLengths::new(row) {
                // there is room for as many as there are
                let _ = poses.push(lengths);
            }
        }
        Ok(Self { rig, start: parameters(&constants::START_MM), truth, poses, lengths_mm })
    }
}

fn parameters<T: Real>(values_mm: &[f64; 6]) -> Parameters<T> {
    Parameters::from_array(values_mm.map(T::of))
}
