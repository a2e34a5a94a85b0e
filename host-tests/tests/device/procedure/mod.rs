//! The calibration procedure as a whole: the device with a virtual wearer at its encoders and a client on its bus.

mod accepting;
mod bad_input;
pub mod bench;
mod by_button;
mod calibrations;
mod elbow;
mod elbow_board;
mod elbow_watch;
mod guidance;
mod moving_joint;
mod numbering;
mod parameters;
mod persistence;
mod random_events;
mod sets;
mod slip_monitor;
mod table;
mod zeros;
