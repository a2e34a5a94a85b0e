//! The method, from six lengths to an accepted centre and its standard deviation: each part against an oracle of its own.
//!
//! One binary for all of it: the generic code of the library is compiled once, not once a file.

mod common;

mod attitude;
mod bad_input;
mod bad_rig;
mod encoder_offsets;
mod estimator;
mod estimator_garbage;
mod estimator_outliers;
mod estimator_refusals;
mod estimator_sigma;
mod excitation;
mod further_poses;
mod geometry;
mod held_noise;
mod hinge;
mod hinge_direction;
mod hinge_slices;
mod hinge_watch;
mod joint_models;
mod length_jacobian;
mod linear_algebra;
mod machine;
mod machine_as_built;
mod marginal_information;
mod moving_centre;
mod oracle;
mod paper;
mod paper_against_oracle;
mod predicted_accuracy;
mod slip_detection;
mod stewart_gough;
mod uncertainty;
