//! What `cargo cycles`, `footprint`, `stack`, `panic-free` and `soup` have behind them.

pub mod cycles;
