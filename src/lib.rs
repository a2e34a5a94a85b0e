//! Joint-centre identification for a cable-driven shoulder rehabilitator, on the drive board itself.
//!
//! ```text
//! rig ── kinematics ── identification ── watch ── procedure ── device ── boards
//! ```
//!
//! Data flows from left to right and nothing knows what stands to its right. `rig`, `kinematics` and
//! `identification` are pure functions of numbers, generic over `f32` and `f64`; `procedure` is the calibration's
//! state machine with time passed in; `device` is the whole board without hardware.
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
pub mod paper;
pub mod parameters;
pub mod procedure;
pub mod record;
pub mod restart;
pub mod rig;
pub mod rig_link;
pub mod scalar;
pub mod slcan;


pub mod monitor;
