//! What every image in a page has: a magic, a version, a sequence number, and a CRC at its end.
//!
//! They keep their places in every version and in every kind of image, so that an image of another version can be named
//! as such.
//!
//! | from | bytes | content |
//! |---|---|---|
//! | 0 | 4 | magic: the kind of the image |
//! | 4 | 2 | version |
//! | 6 | 2 | the kind's own |
//! | 8 | 4 | sequence number: the larger one is the newer image, modulo 2³² |
//! | 12 | | the kind's own |
//! | last 4 | 4 | CRC-32 of a constant and all bytes before |

use crc::{CRC_32_ISO_HDLC, Crc, Digest, Table};

/// Length of the CRC, bytes.
pub(super) const CRC_LEN: usize = 4;

/// Goes into the CRC before the image, so that no run of equal bytes is ever an image, and no other program's CRC-32.
const SALT: [u8; 4] = *b"\xA5gle";

/// What every version has, found in an image whose CRC is right.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Header {
    /// Version of the kind's table.
    pub version: u16,
    /// The larger one is the newer image, modulo 2³².
    pub sequence: u32,
}

/// No image: the magic or the CRC is wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Broken;

/// Looks whether an image is whole, and what it says of itself.
///
/// # Errors
/// [`Broken`].
pub fn header<const LEN: usize>(image: &[u8; LEN], magic: [u8; 4]) -> Result<Header, Broken> {
    let Some((head, _)) = image.split_first_chunk::<12>() else { return Err(Broken) };
    let [m0, m1, m2, m3, v0, v1, _, _, s0, s1, s2, s3] = *head;
    if [m0, m1, m2, m3] == magic && stated_checksum(image) == checksum(image) {
        Ok(Header { version: u16::from_le_bytes([v0, v1]), sequence: u32::from_le_bytes([s0, s1, s2, s3]) })
    } else {
        Err(Broken)
    }
}

/// Writes the CRC at the end of an image.
pub fn seal<const LEN: usize>(image: &mut [u8; LEN]) {
    let sum = checksum(image).to_le_bytes();
    if let Some(place) = image.last_chunk_mut() {
        *place = sum;
    }
}

/// CRC-32 (ISO-HDLC, as in zip) of the salt and the image without its last four bytes.
pub fn checksum(image: &[u8]) -> u32 {
    let mut seal = Seal::new();
    seal.add(image.get(..image.len().saturating_sub(CRC_LEN)).unwrap_or_default());
    seal.sum()
}

/// The CRC that stands at the end of an image, whether it is right or not.
pub fn stated_checksum(image: &[u8]) -> u32 {
    image.last_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes))
}

// By table, a kilobyte of flash: it is formed with every heartbeat.
pub(super) static CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// The CRC of an image that is given piece by piece.
#[derive(Clone)]
pub(super) struct Seal(Digest<'static, u32, Table<1>>);

impl Seal {
    /// Nothing was given yet.
    pub fn new() -> Self {
        let mut digest = CRC.digest();
        digest.update(&SALT);
        Self(digest)
    }

    /// The next bytes.
    pub fn add(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    /// The CRC of all bytes so far.
    pub fn sum(&self) -> u32 {
        self.0.clone().finalize()
    }
}

impl core::fmt::Debug for Seal {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "Seal({:#010x})", self.sum())
    }
}
