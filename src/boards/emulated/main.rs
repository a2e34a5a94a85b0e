//! The emulated drive board.
#![no_std]
#![no_main]
