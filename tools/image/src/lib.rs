//! What the ELF file of a firmware image says.

pub mod drive_board_image;
pub mod elf;
pub mod hot_code;
pub mod stack_bound;
