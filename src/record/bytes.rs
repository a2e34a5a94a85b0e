//! The fields of a record's image, one after the other, little-endian.

/// Length of an image, bytes: 80 flash words of the drive board.
pub const IMAGE_LEN: usize = 640;

/// The image of a record.
pub type Image = [u8; IMAGE_LEN];

/// Writes an image from its first byte on; what is left stays zero.
pub(super) struct Writer {
    pub image: Image,
    at: usize,
}

impl Writer {
    /// An image of zeros.
    pub const fn new() -> Self {
        Self { image: [0; IMAGE_LEN], at: 0 }
    }

    /// Appends a field.
    pub fn put<const N: usize>(&mut self, bytes: [u8; N]) {
        self.put_bytes(&bytes);
    }

    /// Appends bytes. A test counts that they all fit.
    fn put_bytes(&mut self, bytes: &[u8]) {
        for (place, byte) in self.image.iter_mut().skip(self.at).zip(bytes) {
            *place = *byte;
        }
        self.at += bytes.len();
    }

    /// Appends numbers in single precision, 4 bytes each.
    pub fn put_numbers(&mut self, numbers: &[f32]) {
        for number in numbers {
            self.put(number.to_le_bytes());
        }
    }
}

/// Reads an image from its first byte on.
pub(super) struct Reader<'a> {
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    /// From the first byte.
    pub const fn new(rest: &'a [u8]) -> Self {
        Self { rest }
    }

    /// The next field; zeros past the end.
    pub fn take<const N: usize>(&mut self) -> [u8; N] {
        let mut bytes = [0; N];
        self.take_bytes(&mut bytes);
        bytes
    }

    /// Takes the next bytes; zeros past the end, where no field of this version lies.
    fn take_bytes(&mut self, bytes: &mut [u8]) {
        for byte in bytes {
            let Some((first, rest)) = self.rest.split_first() else { return };
            (*byte, self.rest) = (*first, rest);
        }
    }

    /// The next numbers in single precision; zeros past the end.
    pub fn take_numbers<const N: usize>(&mut self) -> [f32; N] {
        let mut numbers = [0.0; N];
        self.fill(&mut numbers);
        numbers
    }

    fn fill(&mut self, numbers: &mut [f32]) {
        for number in numbers {
            *number = f32::from_le_bytes(self.take());
        }
    }
}
