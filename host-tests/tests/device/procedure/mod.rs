//! The calibration procedure as a whole: the device with a virtual wearer at its encoders and a client on its bus.

mod bad_input;
mod bench;
mod by_button;
mod calibrations;
mod guard;
mod guidance;
mod keeping;
mod random_events;
mod table;
mod zeros;
