//! What the ELF file of a firmware image says.

pub mod ccm_code;
pub mod drive_board_image;
pub mod elf;
pub mod memory;
pub mod stack_bound;
