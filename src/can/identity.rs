//! Which board, which boot, whose arm; and what names a new centre that waits for its decision.

use super::payload::{Field, Payload, RUN};

/// Follows every heartbeat: nothing in it repeats over restarts but the board's serial number.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Identity {
    /// Serial number of the board; 0 when it has none.
    pub serial: u32,
    /// Counts the starts of this board, modulo 2^16.
    pub boot: u16,
    /// Wearer that the next run, or the one under way, is made for; 0 = not said.
    pub wearer: u16,
}

mod field {
    use super::Field;
    pub(super) const SERIAL: Field = Field::integer(0, 32);
    pub(super) const BOOT: Field = Field::integer(32, 16);
    pub(super) const WEARER: Field = Field::integer(48, 16);
}

impl Identity {
    pub(super) fn pack(&self) -> Payload {
        Payload::new().with(field::SERIAL, self.serial).with(field::BOOT, self.boot).with(field::WEARER, self.wearer)
    }

    pub(super) fn unpack(payload: Payload) -> Self {
        Self {
            serial: payload.get(field::SERIAL),
            boot: payload.get_u16(field::BOOT),
            wearer: payload.get_u16(field::WEARER),
        }
    }
}

/// What an accept, or the confirmation of a centre in use, must name. It follows the value's frames in every report.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Naming {
    /// The run that found the value.
    pub run_id: u16,
    /// The boot in which it ran.
    pub boot: u16,
    /// The wearer that it was made for; 0 = not said.
    pub wearer: u16,
    /// Checksum over the frames that showed the value (see [`checksum`]).
    pub checksum: u16,
}

mod naming {
    use super::Field;
    pub(super) const BOOT: Field = Field::integer(16, 16);
    pub(super) const WEARER: Field = Field::integer(32, 16);
    pub(super) const CHECKSUM: Field = Field::integer(48, 16);
}

impl Naming {
    pub(super) fn pack(&self) -> Payload {
        Payload::new()
            .with(RUN, self.run_id)
            .with(naming::BOOT, self.boot)
            .with(naming::WEARER, self.wearer)
            .with(naming::CHECKSUM, self.checksum)
    }

    pub(super) fn unpack(payload: Payload) -> Self {
        Self {
            run_id: payload.get_u16(RUN),
            boot: payload.get_u16(naming::BOOT),
            wearer: payload.get_u16(naming::WEARER),
            checksum: payload.get_u16(naming::CHECKSUM),
        }
    }
}

/// The checksum of a value as it was shown: CRC-16/IBM-3740 ("CCITT-FALSE") over boot and wearer (two bytes each,
/// little-endian), then the eight data bytes of its frames in order: centre x, y, z, radius p1, p2, p3, offsets L1 to L6,
/// and the eight parts of the motion of a centre that moves. A client forms it from the frames that it has received, so it cannot accept what it was not shown.
pub fn checksum(boot: u16, wearer: u16, frames: impl Iterator<Item = [u8; 8]>) -> u16 {
    const CRC: crc::Crc<u16, crc::Table<1>> = crc::Crc::<u16, crc::Table<1>>::new(&crc::CRC_16_IBM_3740);
    let mut digest = CRC.digest();
    digest.update(&boot.to_le_bytes());
    digest.update(&wearer.to_le_bytes());
    for frame in frames {
        digest.update(&frame);
    }
    digest.finalize()
}
