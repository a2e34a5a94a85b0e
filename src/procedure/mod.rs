//! The calibration procedure: a state machine with time passed in.
