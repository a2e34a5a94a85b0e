//! The calibration procedure as a whole: the device with a virtual wearer at its encoders and a client on its bus.

mod bad_input;
mod bench;
mod by_button;
mod calibrations;
mod guidance;
mod persistence;
mod random_events;
mod slip_monitor;
mod table;
mod zeros;
