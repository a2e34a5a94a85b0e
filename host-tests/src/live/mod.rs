//! A board to look at: the emulated board, its CAN bus for any number of clients, and a person at its arm.
//!
//! [`SharedBus`] stands between the board's one serial line and everybody who wants to listen: SLCAN clients over TCP
//! ([`serve_slcan`]) and pages over WebSocket. [`Patient`] plays the person, who follows the guidance that the board
//! gives.

mod patient;
mod port;
mod shared_bus;

pub use patient::{Order, Patient, Person, PersonKind};
pub use port::{Line, serve_line, serve_slcan};
pub use shared_bus::{Port, SharedBus};
