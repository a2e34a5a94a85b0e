//! The core's own registers: interrupt controller, system control, timer, memory protection, cycle counter.

pub mod mpu;
pub mod nvic;
pub mod scb;
pub mod systick;
