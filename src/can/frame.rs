//! A classic CAN data frame with an 11-bit identifier: the only kind that Glenoid sends or obeys.

use embedded_can::{Id, StandardId};

/// Most bytes that a classic CAN frame carries (ISO 11898-1: data length code 0 to 8).
pub const MAX_DATA_LEN: usize = 8;

/// Why bytes do not make a [`Frame`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum FrameError {
    /// The identifier needs more than 11 bits.
    IdTooLarge = 1,
    /// More than [`MAX_DATA_LEN`] data bytes.
    DataTooLong = 2,
}

impl FrameError {
    /// The number that stands for this error in logs. Never renumbered.
    pub const fn code(self) -> u8 {
        self as u8
    }
}

impl core::fmt::Display for FrameError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::IdTooLarge => "the CAN identifier needs more than 11 bits",
            Self::DataTooLong => "more than 8 data bytes in a classic CAN frame",
        })
    }
}

impl core::error::Error for FrameError {}

/// A classic CAN data frame: identifier `0..=0x7FF`, 0 to 8 data bytes.
///
/// Bytes past the length are kept at zero, so that equal frames compare equal. Remote and extended frames cannot
/// be represented: nothing in Glenoid uses them, and a board drops them at its edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Frame {
    id: u16,
    dlc: u8,
    data: [u8; MAX_DATA_LEN],
}

impl Frame {
    /// A frame of 0 to 8 bytes.
    ///
    /// # Errors
    /// [`FrameError::IdTooLarge`] above 0x7FF, [`FrameError::DataTooLong`] for more than 8 bytes.
    pub fn new(id: u16, data: &[u8]) -> Result<Self, FrameError> {
        let id = StandardId::new(id).ok_or(FrameError::IdTooLarge)?;
        let mut frame = Self::of_eight(id, [0; MAX_DATA_LEN]);
        let target = frame.data.get_mut(..data.len()).ok_or(FrameError::DataTooLong)?;
        target.copy_from_slice(data);
        // at most 8, as the line above has shown
        frame.dlc = data.len() as u8;
        Ok(frame)
    }

    /// A frame of exactly 8 bytes; nothing is left that could be wrong.
    pub fn of_eight(id: StandardId, data: [u8; MAX_DATA_LEN]) -> Self {
        Self { id: id.as_raw(), dlc: MAX_DATA_LEN as u8, data }
    }

    /// The identifier, `0..=0x7FF`.
    pub const fn raw_id(&self) -> u16 {
        self.id
    }

    /// The data bytes, 0 to 8 of them.
    pub fn data(&self) -> &[u8] {
        self.data.get(..usize::from(self.dlc)).unwrap_or(&self.data)
    }
}

impl embedded_can::Frame for Frame {
    /// None for an extended identifier or more than 8 bytes.
    fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        match id.into() {
            Id::Standard(id) => Self::new(id.as_raw(), data).ok(),
            Id::Extended(_) => None,
        }
    }

    /// Always None: remote frames are not used.
    fn new_remote(_id: impl Into<Id>, _dlc: usize) -> Option<Self> {
        None
    }

    fn is_extended(&self) -> bool {
        false
    }

    fn is_remote_frame(&self) -> bool {
        false
    }

    fn id(&self) -> Id {
        Id::Standard(StandardId::new(self.id).unwrap_or(StandardId::MAX))
    }

    fn dlc(&self) -> usize {
        usize::from(self.dlc)
    }

    fn data(&self) -> &[u8] {
        Frame::data(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_of_the_identifier() {
        assert_eq!(Frame::new(0x7FF, &[]).map(|f| f.raw_id()), Ok(0x7FF));
        assert_eq!(Frame::new(0x800, &[]), Err(FrameError::IdTooLarge));
    }

    #[test]
    fn limits_of_the_length() {
        let bytes = [1, 2, 3, 4, 5, 6, 7, 8, 9];
        for len in 0..=8 {
            let frame = Frame::new(0x120, &bytes[..len]).unwrap();
            assert_eq!(frame.data(), &bytes[..len]);
            assert_eq!(embedded_can::Frame::dlc(&frame), len);
        }
        assert_eq!(Frame::new(0x120, &bytes), Err(FrameError::DataTooLong));
    }

    #[test]
    fn the_embedded_can_view_agrees() {
        use embedded_can::{ExtendedId, Frame as _};
        let id = StandardId::new(0x123).unwrap();
        let frame = <Frame as embedded_can::Frame>::new(id, &[7, 8]).unwrap();
        assert_eq!(frame.id(), Id::Standard(id));
        assert_eq!(embedded_can::Frame::data(&frame), &[7, 8]);
        assert!(frame.is_data_frame() && frame.is_standard());
        assert!(<Frame as embedded_can::Frame>::new(ExtendedId::ZERO, &[]).is_none());
        assert!(Frame::new_remote(id, 0).is_none());
    }

    #[test]
    fn codes_never_change() {
        assert_eq!(FrameError::IdTooLarge.code(), 1);
        assert_eq!(FrameError::DataTooLong.code(), 2);
    }
}
