//! `cargo identify` from the outside: the real binary on files, its output and its exit code.

mod accepted;
mod any_bytes;
mod bad_logs;
mod bad_rigs;
mod bus_logs;
mod causes;
pub mod command;
mod hinge;
mod log_shapes;
mod recorded;
mod refused;
mod two_phases;
