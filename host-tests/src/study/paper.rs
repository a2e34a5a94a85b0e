//! The paper's simulations (section III), and what they leave out.

mod convergence;
mod noise;
mod start;
mod success;
mod table2;

pub use convergence::FIG_5;
pub use noise::{FIG_6, FIG_7};
pub use success::SUCCESS;
pub use table2::TABLE_2;
