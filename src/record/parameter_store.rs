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
use super::sealed::seal;
use super::two_pages::TwoPages;
use crate::parameters::{COUNT, ParameterSet, TABLE};
use embedded_storage::nor_flash::NorFlash;

/// Length of the image, bytes: room for 250 parameters.
pub const PARAMETER_IMAGE_LEN: usize = 1_520;
const MAGIC: [u8; 4] = *b"GLNP";
const VERSION: u16 = 1;
const HEAD_LEN: usize = 12;
const _: () = assert!(HEAD_LEN + 6 * COUNT + 4 <= PARAMETER_IMAGE_LEN);

/// The parameters in two pages of a flash.
#[derive(Debug)]
pub struct ParameterStore<F> {
    flash: F,
    pages: TwoPages<PARAMETER_IMAGE_LEN>,
}

impl<F: NorFlash> ParameterStore<F> {
    /// A store in the two pages from the byte `from` of the flash on, a multiple of the page size.
    pub const fn new(flash: F, from: u32) -> Self {
        Self { flash, pages: TwoPages::new::<F>(from, MAGIC) }
    }

    /// The stored set. Finishes what a power cut left unfinished.
    ///
    /// # Errors
    /// [`LoadError`].
    pub fn load(&mut self) -> Result<ParameterSet, LoadError> {
        let (header, image) = self.pages.load(&mut self.flash)?;
        match header.version {
            0..VERSION => Err(LoadError::OlderVersion),
            VERSION => decode(&image).ok_or(LoadError::Unfit),
            _ => Err(LoadError::FromTheFuture),
        }
    }

    /// Replaces the stored set.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn store(&mut self, set: &ParameterSet) -> Result<(), StoreError> {
        self.pages.store(&mut self.flash, |sequence| encode(set, sequence))
    }
}

fn encode(set: &ParameterSet, sequence: u32) -> [u8; PARAMETER_IMAGE_LEN] {
    let mut image = [0; PARAMETER_IMAGE_LEN];
    let [v0, v1] = VERSION.to_le_bytes();
    let [n0, n1] = (COUNT as u16).to_le_bytes();
    let [s0, s1, s2, s3] = sequence.to_le_bytes();
    if let Some((head, list)) = image.split_first_chunk_mut::<HEAD_LEN>() {
        let [m0, m1, m2, m3] = MAGIC;
        *head = [m0, m1, m2, m3, v0, v1, n0, n1, s0, s1, s2, s3];
        for (place, entry) in list.as_chunks_mut::<6>().0.iter_mut().zip(TABLE) {
            let [i0, i1] = entry.index.to_le_bytes();
            let [b0, b1, b2, b3] = set.bits(entry.index).unwrap_or(entry.default).to_le_bytes();
            *place = [i0, i1, b0, b1, b2, b3];
        }
    }
    seal(&mut image);
    image
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
