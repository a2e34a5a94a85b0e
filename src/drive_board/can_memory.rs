//! Frames as they lie in the CAN controller's message RAM (RM0440, 44.3.7 and 44.3.8: FDCAN Rx FIFO element, Tx buffer
//! element).

use crate::can::Frame;

/// Words of one element: two of header, sixteen of data. A classic frame uses the first two of the data.
pub const ELEMENT_WORDS: usize = 18;
/// Elements of each receive FIFO, and transmit buffers.
pub const ELEMENTS: usize = 3;
/// Words that a classic frame takes.
pub const USED_WORDS: usize = 4;

/// First word, bit 30: the identifier has 29 bits.
const EXTENDED: u32 = 1 << 30;
/// First word, bit 29: a remote frame.
const REMOTE: u32 = 1 << 29;
/// First word: a standard identifier lies in the upper 11 of 29 bits.
const STANDARD_ID_SHIFT: u32 = 18;
/// Second word, bit 21: CAN FD format.
const FD_FORMAT: u32 = 1 << 21;
/// Second word: the data length code.
const LENGTH_SHIFT: u32 = 16;
/// All bits of a standard identifier.
const ID_BITS: u32 = 0x7FF;
/// All bits of a data length code.
const LENGTH_BITS: u32 = 0xF;

/// The words of a frame to be sent: classic format, no transmit event.
pub fn words_of(frame: &Frame) -> [u32; USED_WORDS] {
    let mut bytes = [0; 8];
    for (place, byte) in bytes.iter_mut().zip(frame.data()) {
        *place = *byte;
    }
    let [a, b, c, d, e, f, g, h] = bytes;
    [
        u32::from(frame.raw_id()) << STANDARD_ID_SHIFT,
        // a frame has at most eight bytes
        (frame.data().len() as u32) << LENGTH_SHIFT,
        u32::from_le_bytes([a, b, c, d]),
        u32::from_le_bytes([e, f, g, h]),
    ]
}

/// The frame in the words of a received element; None for what this device neither sends nor obeys: extended
/// identifiers, remote frames, CAN FD. The filters let none of these through.
pub fn frame_of(words: &[u32; USED_WORDS]) -> Option<Frame> {
    let [first, second, low, high] = *words;
    if first & (EXTENDED | REMOTE) != 0 || second & FD_FORMAT != 0 {
        return None;
    }
    let id = (first >> STANDARD_ID_SHIFT & ID_BITS) as u16;
    // a classic frame's code of 9 to 15 means eight bytes too (ISO 11898-1)
    let len = ((second >> LENGTH_SHIFT & LENGTH_BITS) as usize).min(8);
    let [a, b, c, d] = low.to_le_bytes();
    let [e, f, g, h] = high.to_le_bytes();
    Frame::new(id, [a, b, c, d, e, f, g, h].get(..len)?).ok()
}
