//! What the image prints, by semihosting.

use core::fmt::{Arguments, Write};

use cortex_m_semihosting::hio;
use heapless::String;

use super::measure::Figures;

/// Longest line.
const LINE_LEN: usize = 200;

/// A path's figures.
pub fn path(name: &str, precision: &str, figures: &Figures) {
    let Figures { counts, ticks, worst, state_bytes, stack_bytes, steps, error_nm } = figures;
    line(format_args!(
        "path {name} {precision} counts={counts} ticks={ticks} worst={worst} state={state_bytes} stack={stack_bytes} \
         steps={steps} error={error_nm}"
    ));
}

/// A path that did not end as it should.
pub fn failed(name: &str, precision: &str) {
    line(format_args!("failed {name} {precision}"));
}

/// The ticks of something known.
pub fn calibration(name: &str, ticks: u32) {
    line(format_args!("calibration {name} ticks={ticks}"));
}

/// All paths are through.
pub fn end() {
    line(format_args!("end"));
}

/// The last words of a panic.
pub fn panic(info: &core::panic::PanicInfo) {
    line(format_args!("{info}"));
}

fn line(text: Arguments) {
    let mut buffer = String::<LINE_LEN>::new();
    // a line that is cut is not understood at the other end, and told as such
    let _ = buffer.write_fmt(text);
    if let Ok(mut stream) = hio::hstdout() {
        let _ = stream.write_all(buffer.as_bytes());
        let _ = stream.write_all(b"\n");
    }
}
