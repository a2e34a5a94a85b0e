//! A coherent set of values in several frames: protected as a whole, so that no half of an old set is ever taken.
//!
//! The set is one unit of data after [`e2e`], cut into pieces of seven bytes. A frame carries one piece:
//! byte 0 holds the piece's index (bits 0 to 4) and the lowest three bits of the unit's counter (bits 5 to 7), bytes 1 to
//! 7 the piece. The sender packs the set once and then sends all of its frames in order. The receiver takes the pieces in
//! order, drops what has begun when one is missing, and believes the set when the unit's check passes.

use super::e2e::{self, E2eError};

/// Bytes of the set that one frame carries.
pub const PIECE_LEN: usize = 7;

/// Most frames of a set: the index has five bits.
pub const MAX_FRAMES: usize = 32;

/// One frame's bytes.
pub type Piece = [u8; 8];

/// The piece with this index of a packed set; None past its end.
pub fn piece(data: &[u8], index: usize, counter: u16) -> Option<Piece> {
    let bytes = data.as_chunks::<PIECE_LEN>().0.get(index)?;
    let [b1, b2, b3, b4, b5, b6, b7] = *bytes;
    // the index has five bits, the counter's lowest three follow
    let head = (index as u8 & 0x1F) | ((counter as u8) << 5);
    Some([head, b1, b2, b3, b4, b5, b6, b7])
}

/// What a frame brought about at the receiver.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Received<const LEN: usize> {
    /// The set is not complete yet, or this frame belongs to none that has begun.
    Nothing,
    /// A complete set whose check passed, and by how much its counter is ahead of the last one that did: 1 is the next,
    /// more says that sets were lost, None that this is the first.
    Set {
        /// The unit of data, header included.
        data: [u8; LEN],
        /// Distance from the set before.
        ahead: Option<u16>,
    },
    /// The same set again, or an older one: not to be used.
    Repeated,
    /// Complete, but its check failed.
    Refused(E2eError),
}

/// Gathers the frames of a set of `LEN` bytes.
#[derive(Debug, Clone, Copy)]
pub struct Receiver<const LEN: usize> {
    id: u32,
    data: [u8; LEN],
    /// The index that must come next, and the counter's bits that it must carry.
    expected: u8,
    counter_bits: u8,
    last: Option<u16>,
}

impl<const LEN: usize> Receiver<LEN> {
    /// A receiver of the sets with this data identifier.
    pub const fn new(id: u32) -> Self {
        Self { id, data: [0; LEN], expected: 0, counter_bits: 0, last: None }
    }

    /// Takes the bytes of one frame.
    pub fn take(&mut self, frame: Piece) -> Received<LEN> {
        let [head, bytes @ ..] = frame;
        let (index, counter_bits) = (head & 0x1F, head >> 5);
        if index == 0 {
            self.counter_bits = counter_bits;
        } else if index != self.expected || counter_bits != self.counter_bits {
            // a frame was lost, or belongs to another set: what has begun is worthless
            self.expected = 0;
            return Received::Nothing;
        }
        let Some(place) = self.data.as_chunks_mut::<PIECE_LEN>().0.get_mut(usize::from(index)) else {
            self.expected = 0;
            return Received::Nothing;
        };
        *place = bytes;
        self.expected = index + 1;
        if usize::from(self.expected) * PIECE_LEN < LEN {
            return Received::Nothing;
        }
        self.expected = 0;
        match e2e::check(&self.data, self.id) {
            Err(error) => Received::Refused(error),
            Ok(counter) => {
                let ahead = self.last.map(|last| counter.wrapping_sub(last));
                // half of the counter's range is the past
                if ahead.is_some_and(|ahead| ahead == 0 || ahead > u16::MAX / 2) {
                    return Received::Repeated;
                }
                self.last = Some(counter);
                Received::Set { data: self.data, ahead }
            }
        }
    }

    /// Forgets what came before: after a silence the sender may have started anew, and counts from elsewhere.
    pub fn restart(&mut self) {
        self.expected = 0;
        self.last = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    extern crate std;
    use std::vec::Vec;

    fn frames(counter: u16, fill: u8) -> Vec<Piece> {
        let mut data = [fill; 28];
        e2e::protect(&mut data, 9, counter);
        (0..4).map(|index| piece(&data, index, counter).unwrap()).collect()
    }

    fn taken(receiver: &mut Receiver<28>, frames: &[Piece]) -> Vec<Received<28>> {
        frames.iter().map(|frame| receiver.take(*frame)).filter(|r| *r != Received::Nothing).collect()
    }

    #[test]
    fn a_whole_set_is_taken_once() {
        let mut receiver = Receiver::new(9);
        let first = taken(&mut receiver, &frames(65_535, 1));
        assert!(matches!(first[..], [Received::Set { ahead: None, .. }]));
        assert_eq!(taken(&mut receiver, &frames(65_535, 1)), [Received::Repeated]);
        assert!(matches!(taken(&mut receiver, &frames(0, 2))[..], [Received::Set { ahead: Some(1), .. }]));
        assert!(matches!(taken(&mut receiver, &frames(5, 2))[..], [Received::Set { ahead: Some(5), .. }]));
        assert_eq!(taken(&mut receiver, &frames(4, 2)), [Received::Repeated]);
    }

    #[test]
    fn a_set_with_a_hole_or_a_foreign_piece_is_never_taken() {
        for missing in 0..4 {
            let mut some = frames(3, 1);
            some.remove(missing);
            assert_eq!(taken(&mut Receiver::new(9), &some), []);
            // the piece of another set in its place, first with other counter bits, then with the same
            let mut mixed = frames(3, 1);
            mixed[missing] = frames(4, 2)[missing];
            assert_eq!(taken(&mut Receiver::new(9), &mixed), [], "{missing}");
            mixed[missing] = frames(11, 2)[missing];
            assert_eq!(taken(&mut Receiver::new(9), &mixed), [Received::Refused(E2eError::WrongCrc)], "{missing}");
        }
    }
}
