//! Finding the joint centre from cable lengths.
