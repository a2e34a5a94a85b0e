//! A board to look at: the emulated board, its CAN bus for any number of clients, and a person at its arm.
//!
//! [`SharedBus`] stands between the board's one serial line and everybody who wants to listen: SLCAN clients over TCP
//! ([`serve_slcan`]) and pages over WebSocket ([`serve_page`]). [`Patient`] plays the person, who follows the guidance that the board
//! gives.

mod ball_sitter;
mod elbow_sitter;
mod link;
mod machine;
mod page_build;
mod page_server;
mod patient;
mod person;
mod port;
mod running;
mod shared_bus;
mod sitter;

pub use machine::{Machine, machine};
pub use page_build::{PageError, build as build_page};
pub use page_server::serve_page;
pub use patient::Patient;
pub use person::{Order, Person, PersonKind};
pub use port::{Line, serve_line, serve_slcan};
pub use running::Running;
pub use shared_bus::{Port, SharedBus};
pub use sitter::{Now, Truth};
