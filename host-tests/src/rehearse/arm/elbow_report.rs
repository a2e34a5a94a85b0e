//! What the elbow's board has found, beside the truth.

use serde::Serialize;

/// The elbow.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ElbowReport {
    /// First identifier of its board.
    pub base_id: u16,
    /// Serial number of its board.
    pub serial: u32,
    /// Poses that identified it.
    pub poses: u8,
    /// Direction of the axis in the elbow's base.
    pub axis: [f64; 3],
    /// Angle between it and the true one, degrees.
    pub axis_error_deg: f64,
    /// 1σ of the direction in its worst direction, degrees.
    pub axis_sigma_deg: f64,
    /// The axis' point next to the middle of the base, mm.
    pub place_mm: [f64; 3],
    /// How far the true axis passes by it, mm.
    pub place_error_mm: f64,
    /// 1σ of the place in its worst direction, mm.
    pub place_sigma_mm: f64,
    /// The host finds the same from the lengths read out of the board, to the bit as it comes over CAN.
    pub host_agrees: bool,
    /// After a restart the same hinge is in use.
    pub survives_restart: bool,
}
