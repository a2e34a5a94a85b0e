//! What the library costs on the Cortex-M4F: instructions, estimated cycles, flash, static memory and stack.
//!
//! ```text
//! image (built) ──► run (ticks by semihosting) ──┐
//!        │     └──► trace (blocks executed) ─────┼──► figures ──► record (CSV) ──► table (Markdown)
//!        └───────► flash (sizes of symbols) ─────┘
//! ```
//!
//! * [`run`] boots the speed image in QEMU, where an instruction takes a fixed virtual time, and reads its lines.
//! * [`trace`] runs it again, with every block of instructions logged, and counts each instruction by itself; [`timing`]
//!   knows what one costs on a Cortex-M4.
//! * [`flash`] compares images that hold more and less.
//! * [`record`] is the list of all figures, kept in the tree; [`table`] is what people read.

pub mod agreement;
pub mod emulation;
pub mod fetch;
pub mod figures;
pub mod flash;
pub mod pipeline;
pub mod profile;
pub mod record;
pub mod run;
pub mod table;
pub mod timing;
pub mod trace;
