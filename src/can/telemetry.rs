//! What the cables show now, as one protected set: lengths, the arm's rotation, the centre with its σ, flags.
//!
//! | piece | bytes 1 to 7, bits from the lowest |
//! |---|---|
//! | 0, 1 | header of the protection ([`e2e`]); then in piece 1 flags and standing, a byte each |
//! | 2 to 4 | two cable lengths a piece: 28 bits each, steps of 2^-16 mm |
//! | 5 | rotation vector of the arm, {P} to {B}: 18 bits each, signed, steps of 2^-15 rad |
//! | 6 | x, y of the centre in {B}: 28 bits each, signed, steps of 2^-17 mm |
//! | 7 | z; σ of the centre in its worst direction: 12 bits, steps of 2^-9 mm; time: 16 bits, ms |

use super::e2e::{self, HEADER_LEN};
use super::live_set::Standing;
use super::payload::PackError;
use super::rounding::{Scale, from_raw, to_raw};
use super::set::PIECE_LEN;
use crate::rig::CABLES;

/// Identifier of the data in the protection's header: "GL" and 2.
pub const TELEMETRY_ID: u32 = 0x474C_0002;
/// Frames of the set.
pub const TELEMETRY_FRAMES: usize = 8;
/// Length of the set, bytes.
pub const TELEMETRY_LEN: usize = TELEMETRY_FRAMES * PIECE_LEN;

const LENGTH: Scale = Scale::unsigned(28, -16);
const ROTATION: Scale = Scale::signed(18, -15);
const CENTRE: Scale = Scale::signed(28, -17);
const SIGMA: Scale = Scale::unsigned(12, -9);
/// The largest σ that the field holds, mm; a larger one is sent as this.
const MAX_SIGMA_MM: f32 = 7.998;

/// What the cables show at one moment.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Telemetry {
    /// The board's clock, ms, modulo 2^16.
    pub time_ms: u16,
    /// The arm is held still.
    pub still: bool,
    /// The encoders are believable; without it nothing below is to be used.
    pub encoders: bool,
    /// The cable that is slack, 1 to 6; 0 for none.
    pub slack: u8,
    /// May the centre be used?
    pub standing: Standing,
    /// L1 to L6 as the encoders give them, offsets included, mm, 0 to 4096.
    pub lengths_mm: [f32; CABLES],
    /// Rotation vector (axis times angle) of the arm, {P} to {B}, rad; None when the lengths fit no rotation.
    pub rotation_rad: Option<[f32; 3]>,
    /// The joint centre in {B}, mm, and its σ in its worst direction; None while none is in use.
    pub centre: Option<([f32; 3], f32)>,
}

const STILL: u8 = 1;
const ENCODERS: u8 = 1 << 1;
const ROTATION_KNOWN: u8 = 1 << 2;
const CENTRE_KNOWN: u8 = 1 << 3;
const SLACK_AT: u8 = 4;

/// Fields of a piece from the lowest bit on.
struct Bits {
    bits: u64,
    at: u8,
}

impl Bits {
    fn put(&mut self, value: f32, scale: Scale) -> Result<(), PackError> {
        let raw = to_raw(value, scale).ok_or(PackError::OutOfRange)?;
        self.bits |= u64::from(raw) << self.at;
        self.at += scale.bits;
        Ok(())
    }

    fn take(&mut self, scale: Scale) -> f32 {
        // `from_raw` takes the low bits only
        let value = from_raw((self.bits >> self.at) as u32, scale);
        self.at += scale.bits;
        value
    }

    fn bytes(&self) -> [u8; PIECE_LEN] {
        let [b0, b1, b2, b3, b4, b5, b6, _] = self.bits.to_le_bytes();
        [b0, b1, b2, b3, b4, b5, b6]
    }

    const fn of([b0, b1, b2, b3, b4, b5, b6]: [u8; PIECE_LEN]) -> Self {
        Self { bits: u64::from_le_bytes([b0, b1, b2, b3, b4, b5, b6, 0]), at: 0 }
    }
}

/// A piece with nothing in it yet.
const EMPTY: Bits = Bits { bits: 0, at: 0 };
/// The time behind z and σ.
const TIME: Scale = Scale::unsigned(16, 0);

impl Telemetry {
    /// The protected bytes, with this counter.
    ///
    /// # Errors
    /// [`PackError::OutOfRange`] when a value is no number or does not fit.
    pub fn pack(&self, counter: u16) -> Result<[u8; TELEMETRY_LEN], PackError> {
        let mut data = [0; TELEMETRY_LEN];
        let (pieces, _) = data.as_chunks_mut::<PIECE_LEN>();
        let [_, second, l12, l34, l56, rotation, xy, z] = pieces else { return Ok(data) };
        second[HEADER_LEN - PIECE_LEN] = self.flags();
        second[HEADER_LEN - PIECE_LEN + 1] = self.standing.code();
        for (piece, pair) in [l12, l34, l56].into_iter().zip(self.lengths_mm.as_chunks::<2>().0) {
            let mut bits = EMPTY;
            for length_mm in pair {
                bits.put(*length_mm, LENGTH)?;
            }
            *piece = bits.bytes();
        }
        let mut bits = EMPTY;
        for component in self.rotation_rad.unwrap_or_default() {
            bits.put(component, ROTATION)?;
        }
        *rotation = bits.bytes();
        let ([x_mm, y_mm, z_mm], sigma_mm) = self.centre.unwrap_or_default();
        let mut bits = EMPTY;
        bits.put(x_mm, CENTRE)?;
        bits.put(y_mm, CENTRE)?;
        *xy = bits.bytes();
        let mut bits = EMPTY;
        bits.put(z_mm, CENTRE)?;
        bits.put(sigma_mm.min(MAX_SIGMA_MM), SIGMA)?;
        bits.put(f32::from(self.time_ms), TIME)?;
        *z = bits.bytes();
        e2e::protect(&mut data, TELEMETRY_ID, counter);
        Ok(data)
    }

    /// The set in bytes that were checked. None for a standing that this version does not know.
    pub fn unpack(data: &[u8; TELEMETRY_LEN]) -> Option<Self> {
        let (pieces, _) = data.as_chunks::<PIECE_LEN>();
        let [_, second, l12, l34, l56, rotation, xy, z] = pieces else { return None };
        let [_, _, _, _, _, flags, standing] = *second;
        let mut lengths = [*l12, *l34, *l56].map(Bits::of);
        let mut rotation = Bits::of(*rotation);
        let (mut xy, mut z) = (Bits::of(*xy), Bits::of(*z));
        let centre_mm = [xy.take(CENTRE), xy.take(CENTRE), z.take(CENTRE)];
        let sigma_mm = z.take(SIGMA);
        let rotation_rad = core::array::from_fn(|_| rotation.take(ROTATION));
        let [a, b, c] = &mut lengths;
        Some(Self {
            time_ms: z.take(TIME) as u16,
            still: flags & STILL != 0,
            encoders: flags & ENCODERS != 0,
            slack: flags >> SLACK_AT,
            standing: Standing::from_code(standing)?,
            lengths_mm: [
                a.take(LENGTH),
                a.take(LENGTH),
                b.take(LENGTH),
                b.take(LENGTH),
                c.take(LENGTH),
                c.take(LENGTH),
            ],
            rotation_rad: (flags & ROTATION_KNOWN != 0).then_some(rotation_rad),
            centre: (flags & CENTRE_KNOWN != 0).then_some((centre_mm, sigma_mm)),
        })
    }

    fn flags(&self) -> u8 {
        let flag = |set: bool, bit: u8| if set { bit } else { 0 };
        flag(self.still, STILL)
            | flag(self.encoders, ENCODERS)
            | flag(self.rotation_rad.is_some(), ROTATION_KNOWN)
            | flag(self.centre.is_some(), CENTRE_KNOWN)
            | (self.slack << SLACK_AT)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_field_comes_back_from_its_own_place() {
        let sent = Telemetry {
            time_ms: 65_535,
            still: true,
            encoders: true,
            slack: 6,
            standing: Standing::NotToBeUsed,
            lengths_mm: [1.0, 4_095.5, 300.25, 17.0, 280.125, 64.0],
            rotation_rad: Some([3.0, -3.5, 0.25]),
            centre: Some(([-1023.5, 1000.25, 148.0], 7.5)),
        };
        let data = sent.pack(7).unwrap();
        assert_eq!(e2e::check(&data, TELEMETRY_ID), Ok(7));
        assert_eq!(Telemetry::unpack(&data), Some(sent));
        let unknown = Telemetry { rotation_rad: None, centre: None, still: false, slack: 0, ..sent };
        assert_eq!(Telemetry::unpack(&unknown.pack(8).unwrap()), Some(unknown));
    }

    #[test]
    fn what_does_not_fit_is_not_sent() {
        let wrong = |change: fn(&mut Telemetry)| {
            let mut telemetry = Telemetry::default();
            change(&mut telemetry);
            assert_eq!(telemetry.pack(0), Err(PackError::OutOfRange));
        };
        wrong(|t| t.lengths_mm[3] = 4_096.0);
        wrong(|t| t.lengths_mm[0] = f32::NAN);
        wrong(|t| t.rotation_rad = Some([0.0, 0.0, 4.0]));
        wrong(|t| t.centre = Some(([0.0, 1024.0, 0.0], 0.0)));
    }
}
