//! The bench list of docs/nucleo-g474re.md, as far as a register model can ask it, against the real image; and what
//! docs/safe-states.md promises of this board.

mod bus;
mod bus_pins;
mod button;
mod defects;
mod encoders;
mod flash;
mod interrupts;
mod registers_touched;
mod resets;
mod scene;
mod stops;
