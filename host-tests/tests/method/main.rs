//! The method, from six lengths to an accepted centre and its standard deviation: each part against an oracle of its own.
//!
//! One binary for all of it: the generic code of the library is compiled once, not once a file.

mod common;

mod arm;
mod bad_input;
mod bad_rig;
mod literal;
mod observability;
mod octahedron;
mod paper;
mod paper_against_literal;
mod pivot;
mod pose_information;
mod solver;
mod solver_garbage;
mod solver_outliers;
mod solver_refusals;
mod solver_sigma;
mod symmetric;
mod watch;
mod zeros;
