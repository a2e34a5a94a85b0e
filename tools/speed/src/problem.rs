//! The problem that everything is measured on: 100 noise-free poses of a rig with a base radius of 160 mm, rotations
//! within ±30 degrees about each axis, and a start from which the paper's iteration takes four steps.

use glenoid::identification::{Machine, Pose};
use glenoid::kinematics::CableLengths;
use glenoid::rig::{CABLES, Drum, Parameters, Rig, RigError};
use glenoid::scalar::Real;
use heapless::Vec;
use nalgebra::Vector3;

mod constants {
    //! `host-tests/data/speed-problem.csv` and `.toml`, by `build.rs`.
    include!(concat!(env!("OUT_DIR"), "/speed_problem.rs"));
}

pub use constants::POSES;

/// Noise of a length that the estimator is given, mm. The lengths have none; the figure only sets the gates.
pub const NOISE_MM: f64 = 0.057_735;

/// What is wrong with the lengths of the harder problems.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Spoilt {
    /// Nothing.
    No,
    /// Noise, uniform within ±0.1 mm.
    Noise,
    /// The same, and one cable of this many poses off by [`OUTLIER_MM`].
    Outliers(usize),
}

/// Half the width of the noise, mm.
const NOISE_LIMIT_MM: f64 = 0.1;
/// Poses of the shoulder, how far its centre moves with the arm's direction, mm/rad, and half the width of its slides, mm.
const SHOULDER_POSES: usize = 60;
const MOVES_MM_PER_RAD: f64 = 12.0;
const SLIDE_LIMIT_MM: f64 = 0.6;
/// By how much the cable of an outlier is off, mm.
const OUTLIER_MM: f64 = 8.0;

/// The problem in one precision.
pub struct Problem<T> {
    pub rig: Rig<T>,
    pub start: Parameters<T>,
    pub truth: Parameters<T>,
    pub poses: Vec<CableLengths<T>, POSES>,
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
        let mut poses = Vec::new();
        for row in &constants::LENGTHS_MM {
            if let Ok(lengths) = CableLengths::new(row.map(T::of)) {
                // there is room for as many as there are
                let _ = poses.push(lengths);
            }
        }
        Ok(Self { rig, start: parameters(&constants::START_MM), truth, poses })
    }

    /// The lengths with something wrong with them, always the same. `None` when one of them would be none.
    pub fn spoilt(&self, spoilt: Spoilt) -> Option<Vec<CableLengths<T>, POSES>> {
        let mut poses = self.poses.clone();
        let mut random = 0x2545_F491_u32;
        let outliers = if let Spoilt::Outliers(count) = spoilt { count } else { 0 };
        for (index, pose) in poses.iter_mut().enumerate() {
            if spoilt == Spoilt::No {
                continue;
            }
            let mut lengths = *pose.as_mm();
            for length in &mut lengths {
                *length += uniform::<T>(&mut random) * T::of(NOISE_LIMIT_MM);
            }
            // Spread over the whole set: the first pose of every so many.
            if outliers > 0 && index.is_multiple_of(POSES / outliers) {
                let cable = lengths.get_mut(index / (POSES / outliers) % CABLES)?;
                *cable += T::of(OUTLIER_MM);
            }
            *pose = CableLengths::new(lengths).ok()?;
        }
        Some(poses)
    }
}

/// The first poses of a shoulder whose centre moves with the arm and slides beside it, with noise. `None` when one of them
/// would have no place.
pub fn of_shoulder<T: Real>(problem: &Problem<T>, machine: &Machine<T>) -> Option<Vec<CableLengths<T>, POSES>> {
    let mut poses = Vec::new();
    let mut random = 0x1234_5678_u32;
    let geometry = machine.geometry();
    for lengths in problem.poses.iter().take(SHOULDER_POSES) {
        let mut pose = Pose::new(*lengths);
        pose.place(machine.platform());
        let platform = pose.is_placed().then(|| pose.platform())?;
        // As shoulders do it moves along the arm most, as the arm tilts.
        let (x, y) = (platform.rotation.m13, platform.rotation.m23);
        let along = x * T::of(0.8) + y * T::of(0.4);
        let mut moved = Vector3::new(x * T::of(0.4), y * T::of(0.3), along) * T::of(MOVES_MM_PER_RAD);
        for axis in moved.iter_mut() {
            *axis += uniform::<T>(&mut random) * T::of(SLIDE_LIMIT_MM);
        }
        let mut lengths = [T::zero(); CABLES];
        for (cable, (length, end)) in lengths.iter_mut().zip(&geometry.end_mm).enumerate() {
            let there = platform.origin_mm + platform.rotation * end + moved;
            *length = geometry.span(cable, &there).length_mm + uniform::<T>(&mut random) * T::of(NOISE_LIMIT_MM);
        }
        poses.push(CableLengths::new(lengths).ok()?).ok()?;
    }
    Some(poses)
}

/// Noise of a length, mm.
pub fn uniform_noise_mm<T: Real>(random: &mut u32) -> T {
    uniform::<T>(random) * T::of(NOISE_LIMIT_MM)
}

/// Uniform within ±1 (Marsaglia's xorshift).
fn uniform<T: Real>(random: &mut u32) -> T {
    *random ^= *random << 13;
    *random ^= *random >> 17;
    *random ^= *random << 5;
    T::of_integer((*random >> 8) as i32) * T::of(2.0 / 16_777_216.0) - T::one()
}

fn parameters<T: Real>(values_mm: &[f64; 6]) -> Parameters<T> {
    Parameters::from_array(values_mm.map(T::of))
}
