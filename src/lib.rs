//! Joint-centre identification for a cable-driven shoulder rehabilitator, on the drive board itself.
//!
//! ```text
//! rig ── kinematics ── identification ──┬── procedure ──┐
//! data    lengths↔pose   estimator,     ├── monitor ────┤── device ── boards
//!                        joint, machine └── record ─────┘   events in, actions out
//! ```
//!
//! Data flows from left to right and nothing knows what stands to its right. `rig`, `kinematics` and
//! `identification` are pure functions of numbers, generic over `f32` and `f64`; `procedure` is the calibration's
//! state machine with time passed in; `device` is the whole board without hardware.
//!
//! # Example
//! Six cable lengths in each of nine poses, mm, and nothing else:
//! ```
//! use glenoid::identification::{Estimator, EstimatorSettings, Machine, Pose};
//! use glenoid::kinematics::CableLengths;
//! use glenoid::rig::Rig;
//!
//! let lengths_mm = [
//!     [279.65, 281.72, 319.81, 280.82, 286.53, 236.81],
//!     [227.43, 310.50, 308.36, 316.64, 243.78, 265.92],
//!     [248.38, 241.02, 311.79, 312.36, 307.53, 235.83],
//!     [306.98, 324.62, 253.53, 253.53, 224.67, 290.94],
//!     [236.60, 235.77, 305.09, 318.46, 309.10, 239.55],
//!     [268.39, 230.61, 247.05, 268.56, 321.66, 307.66],
//!     [279.49, 254.36, 283.13, 275.93, 309.12, 281.33],
//!     [303.92, 306.85, 285.06, 247.07, 259.34, 269.97],
//!     [243.54, 319.47, 327.07, 291.38, 222.12, 229.96],
//! ];
//! let rig = Rig::<f64>::shoulder(150.0).unwrap();
//! let machine = Machine::new(&rig);
//! let mut poses = lengths_mm.map(|lengths_mm| Pose::new(CableLengths::new(lengths_mm).unwrap()));
//! let mut estimator = Estimator::new(&machine, rig.nominal(), EstimatorSettings::for_rig(&rig));
//! let found = estimator.run(&machine, &mut poses).unwrap();
//! // the lengths were made from a centre at (6, -4, 152)
//! let centre_mm = found.parameters.centre_mm;
//! let error_mm = (centre_mm.x - 6.0).abs().max((centre_mm.y + 4.0).abs()).max((centre_mm.z - 152.0).abs());
//! assert!(error_mm < 0.2 && found.sigma_mm()[2] < 0.1);
//! ```
//!
//! Reference: S. K. Mustafa, G. Yang, S. H. Yeo, W. Lin, "Self-Identification of the Joint Centre of a
//! Cable-Driven Shoulder Rehabilitator", 2007. "Eq. n" in the documentation of this crate means that paper's.
#![no_std]
#![deny(unsafe_code)]

pub mod can;
pub mod device;
pub mod drive_board;
pub mod identification;
pub mod kinematics;
pub mod line;
pub mod linear_algebra;
pub mod monitor;
pub mod paper;
pub mod parameters;
pub mod procedure;
pub mod record;
pub mod restart;
pub mod rig;
pub mod rig_link;
pub mod scalar;
pub mod slcan;
