//! The board's log, read out of its RAM as a debug probe does, and decoded.

use crate::image::Image;
use crate::machine::Machine;
use crate::memories::SRAM;
use defmt_decoder::{DecodeError, Table};

/// Distances in the control block (SEGGER RTT): the first up-channel, and its fields.
const CHANNEL: u32 = 24;
const BUFFER: u32 = CHANNEL + 4;
const SIZE: u32 = CHANNEL + 8;
const WRITTEN: u32 = CHANNEL + 12;
const READ: u32 = CHANNEL + 16;

/// The reader.
pub struct Log {
    table: Table,
    block: u32,
    pending: Vec<u8>,
    /// All lines so far.
    pub lines: Vec<String>,
}

impl Log {
    /// The reader of this image's log; None if it has none.
    pub fn new(image: &Image) -> Option<Self> {
        let table = Table::parse(&image.file).ok()??;
        let block = image.symbol("_SEGGER_RTT")?;
        Some(Self { table, block, pending: Vec::new(), lines: Vec::new() })
    }

    /// Takes what the firmware has written since, and makes room for more.
    pub fn drain(&mut self, machine: &mut Machine) {
        if !machine.bytes(self.block, 10).starts_with(b"SEGGER RTT") {
            // the firmware has not come so far
            return;
        }
        let [buffer, size, written, read] = [BUFFER, SIZE, WRITTEN, READ].map(|field| machine.word(self.block + field));
        let is_ram = buffer >= SRAM.0 && buffer.saturating_add(size) <= SRAM.0 + SRAM.1 as u32;
        if !is_ram || written >= size || read >= size || written == read {
            return;
        }
        let mut at = read;
        while at != written {
            let end = if at < written { written } else { size };
            self.pending.extend(machine.bytes(buffer + at, (end - at) as usize));
            at = end % size;
        }
        machine.set_word(self.block + READ, written);
        self.decode();
    }

    fn decode(&mut self) {
        let mut decoder = self.table.new_stream_decoder();
        decoder.received(&std::mem::take(&mut self.pending));
        loop {
            match decoder.decode() {
                Ok(frame) => {
                    let level = frame.level().map_or("-", |level| level.as_str());
                    self.lines.push(format!("{level}: {}", frame.display_message()));
                }
                Err(DecodeError::Malformed) => {}
                Err(DecodeError::UnexpectedEof) => return,
            }
        }
    }
}
