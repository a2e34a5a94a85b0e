//! The parameters in their two pages.
//!
//! The image lists index and value of every parameter, so that another firmware with more of them reads it too: what the
//! image does not have keeps its default, and what this firmware does not know is a reason to refuse the whole.
//!
//! | from | bytes | content |
//! |---|---|---|
//! | 0 | 4 | `GLNP` |
//! | 4 | 2 | version of this table |
//! | 6 | 2 | number of parameters |
//! | 8 | 4 | sequence number |
//! | 12 | 6 each | index (2), bits of the value (4) |
//! | last 4 | 4 | CRC-32 |

use super::error::{LoadError, StoreError};
use super::flash::PageFlash;
use super::replacement::Source;
use super::two_pages::TwoPages;
use crate::parameters::{COUNT, ParameterSet, TABLE};

/// Length of the image, bytes: room for 250 parameters.
pub const PARAMETER_IMAGE_LEN: usize = 1_520;
const MAGIC: [u8; 4] = *b"GLNP";
const VERSION: u16 = 1;
const HEAD_LEN: usize = 12;
/// Bytes of an entry: index and value.
const ENTRY_LEN: usize = 6;
const _: () = assert!(HEAD_LEN + ENTRY_LEN * COUNT + 4 <= PARAMETER_IMAGE_LEN);

/// The pages of the parameters.
pub(super) type ParameterPages = TwoPages<PARAMETER_IMAGE_LEN>;

/// The stored set.
pub(super) fn load<F: PageFlash>(pages: &mut ParameterPages, flash: &mut F) -> Result<ParameterSet, LoadError> {
    let (header, image) = pages.load(flash)?;
    match header.version {
        0..VERSION => Err(LoadError::OlderVersion),
        VERSION => decode(&image).ok_or(LoadError::Unfit),
        _ => Err(LoadError::FromTheFuture),
    }
}

/// The parameters' two pages.
pub(super) const fn pages<F: PageFlash>(from: u32) -> ParameterPages {
    TwoPages::new::<F>(from, MAGIC)
}

/// The parameters in two pages of a flash. Everything is done when a call returns; a board, which must not wait, has a
/// [`Storage`](super::Storage).
#[derive(Debug)]
pub struct ParameterStore<F> {
    flash: F,
    pages: ParameterPages,
}

impl<F: PageFlash> ParameterStore<F> {
    /// A store in the two pages from the byte `from` of the flash on, a multiple of the page size.
    pub const fn new(flash: F, from: u32) -> Self {
        Self { flash, pages: pages::<F>(from) }
    }

    /// The stored set. Finishes what a power cut left unfinished.
    ///
    /// # Errors
    /// [`LoadError`].
    pub fn load(&mut self) -> Result<ParameterSet, LoadError> {
        load(&mut self.pages, &mut self.flash)
    }

    /// Replaces the stored set.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn store(&mut self, set: &ParameterSet) -> Result<(), StoreError> {
        self.pages.store(&mut self.flash, |sequence| ParameterImage { set: *set, sequence })
    }
}

/// The image of a set, whose bytes are made when they are asked for: it is four times as long as the set.
#[derive(Debug, Clone, Copy)]
pub(super) struct ParameterImage {
    pub set: ParameterSet,
    pub sequence: u32,
}

impl ParameterImage {
    fn head(&self) -> [u8; HEAD_LEN] {
        let [m0, m1, m2, m3] = MAGIC;
        let [v0, v1] = VERSION.to_le_bytes();
        let [n0, n1] = (COUNT as u16).to_le_bytes();
        let [s0, s1, s2, s3] = self.sequence.to_le_bytes();
        [m0, m1, m2, m3, v0, v1, n0, n1, s0, s1, s2, s3]
    }

    /// An entry of the list; zeros behind its end.
    fn entry(&self, number: usize) -> [u8; ENTRY_LEN] {
        let (Some(entry), Some(bits)) = (TABLE.get(number), self.set.all().get(number)) else { return [0; ENTRY_LEN] };
        let [i0, i1] = entry.index.to_le_bytes();
        let [b0, b1, b2, b3] = bits.to_le_bytes();
        [i0, i1, b0, b1, b2, b3]
    }
}

impl Source for ParameterImage {
    fn put(&self, at: usize, place: &mut [u8]) {
        let mut place = place.iter_mut();
        let mut at = at;
        if at < HEAD_LEN {
            for byte in self.head().into_iter().skip(at) {
                let Some(to) = place.next() else { return };
                *to = byte;
                at += 1;
            }
        }
        let (mut number, mut skipped) = ((at - HEAD_LEN) / ENTRY_LEN, (at - HEAD_LEN) % ENTRY_LEN);
        loop {
            for byte in self.entry(number).into_iter().skip(skipped) {
                let Some(to) = place.next() else { return };
                *to = byte;
            }
            (number, skipped) = (number + 1, 0);
        }
    }
}

/// The set in an image whose CRC is right; None when it holds a parameter that this firmware does not know, or a value
/// out of its range.
fn decode(image: &[u8; PARAMETER_IMAGE_LEN]) -> Option<ParameterSet> {
    let (head, list) = image.split_first_chunk::<HEAD_LEN>()?;
    let [_, _, _, _, _, _, n0, n1, ..] = *head;
    let count = usize::from(u16::from_le_bytes([n0, n1]));
    let mut set = ParameterSet::new();
    for [i0, i1, b0, b1, b2, b3] in list.as_chunks::<6>().0.get(..count)? {
        set.set_bits(u16::from_le_bytes([*i0, *i1]), u32::from_le_bytes([*b0, *b1, *b2, *b3])).ok()?;
    }
    Some(set)
}
