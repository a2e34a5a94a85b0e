//! Every constant of the machine.
