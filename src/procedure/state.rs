//! Names of the states and what goes with them.
