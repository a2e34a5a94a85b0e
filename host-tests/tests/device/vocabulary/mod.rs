//! The CAN vocabulary: the code against `glenoid.dbc`, and the reason codes against the DBC and the documentation.

mod codes;
mod dbc;
mod messages;
