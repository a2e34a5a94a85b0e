//! What a controller acts on, as one protected set: which centre is in use, whose, whether it may be used, and what
//! belongs to it.
//!
//! | piece | bytes 1 to 7 |
//! |---|---|
//! | 0, 1 | header of the protection ([`e2e`]); then in piece 1 standing and reason, a byte each |
//! | 2 | serial number of the board (4), wearer (2), joint (1): 0 ball, 1 moving centre, 2 hinge |
//! | 3 | boot (2), run (2), fingerprint of the rig (2), 0 |
//! | 4 to 6 | x, y, z of the centre in {B}: value (4, single), σ (3) |
//! | 7 to 9 | p1, p2, p3: value (4), σ (3) |
//! | 10 to 15 | encoder offsets L1 to L6: value (4), σ (3) |
//!
//! Of a hinge pieces 4 to 6 hold its axis in {B}, a unit vector, 7 to 9 a point of it in {B}, 10 to 12 the axis in {P} and 13 to
//! 15 the same point in {P}.
//!
//! Little-endian but for the header; a σ is an unsigned integer of 24 bits in steps of 2^-17 mm.

use super::e2e::{self, HEADER_LEN};
use super::payload::PackError;
use super::rounding::{Scale, from_raw, to_raw};
use super::set::PIECE_LEN;
use crate::procedure::Reason;
use crate::rig::CABLES;

/// Identifier of the data in the protection's header: "GL" and 1.
pub const LIVE_SET_ID: u32 = 0x474C_0001;
/// Frames of the set.
pub const LIVE_SET_FRAMES: usize = 16;
/// Length of the set, bytes.
pub const LIVE_SET_LEN: usize = LIVE_SET_FRAMES * PIECE_LEN;

/// A σ: up to 128 mm in steps of 2^-17 mm.
const SIGMA: Scale = Scale::unsigned(24, -17);

/// The joint: 0 for a ball.
const MOVING: u8 = 1;
const HINGE: u8 = 2;

/// May the centre in use be used? The numbers go over CAN and are never renumbered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Standing {
    /// There is no centre.
    #[default]
    NoCentre = 0,
    /// Accepted since power-up, or confirmed since: it may be used.
    Confirmed = 1,
    /// It came from the record at power-up, and neither motion nor a person has confirmed it yet.
    Unconfirmed = 2,
    /// Something has slipped or may have: it must not be used until somebody decides.
    NotToBeUsed = 3,
}

impl Standing {
    /// All of them, in the order of the numbers.
    pub const ALL: [Self; 4] = [Self::NoCentre, Self::Confirmed, Self::Unconfirmed, Self::NotToBeUsed];

    /// The number on the wire.
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// The standing with this number.
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|standing| standing.code() == code)
    }
}

/// A value with its standard deviation, mm.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Estimate {
    /// The value, mm.
    pub value_mm: f32,
    /// Its standard deviation, mm; 0 = taken as exact.
    pub sigma_mm: f32,
}

/// The centre in use with everything that belongs to it. All zero while there is none.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LiveSet {
    /// May it be used?
    pub standing: Standing,
    /// Why not; code of a [`Reason`], 0 when all is well.
    pub reason: u8,
    /// Serial number of the board; 0 when it has none.
    pub serial: u32,
    /// The centre moves with the arm: `parameters` hold it at the arm's mean direction, the motion is in `LiveMotion`,
    /// and where it is now in the telemetry.
    pub moves: bool,
    /// The joint is a hinge: `parameters` hold its axis and a point of it in {B}, `offsets` the same in {P}.
    pub hinge: bool,
    /// Wearer that the run was made for; 0 = not said.
    pub wearer: u16,
    /// Boot in which the centre was found.
    pub boot: u16,
    /// Run that found it.
    pub run_id: u16,
    /// Fingerprint of the rig.
    pub rig: u16,
    /// x, y, z of the centre in {B}, then p1, p2, p3.
    pub parameters: [Estimate; 6],
    /// Encoder offsets: what each length reads too much.
    pub offsets: [Estimate; CABLES],
}

impl LiveSet {
    /// The protected bytes, with this counter.
    ///
    /// # Errors
    /// [`PackError::OutOfRange`] when a value is no number, or a σ does not fit.
    pub fn pack(&self, counter: u16) -> Result<[u8; LIVE_SET_LEN], PackError> {
        let mut data = [0; LIVE_SET_LEN];
        let (pieces, _) = data.as_chunks_mut::<PIECE_LEN>();
        let [_, second, serial, identity, estimates @ ..] = pieces else { return Ok(data) };
        second[HEADER_LEN - PIECE_LEN] = self.standing.code();
        second[HEADER_LEN - PIECE_LEN + 1] = self.reason;
        let ([s0, s1, s2, s3], [w0, w1]) = (self.serial.to_le_bytes(), self.wearer.to_le_bytes());
        *serial = [s0, s1, s2, s3, w0, w1, self.joint()];
        let ([b0, b1], [r0, r1]) = (self.boot.to_le_bytes(), self.run_id.to_le_bytes());
        let [f0, f1] = self.rig.to_le_bytes();
        *identity = [b0, b1, r0, r1, f0, f1, 0];
        for (piece, estimate) in estimates.iter_mut().zip(self.parameters.iter().chain(&self.offsets)) {
            if !estimate.value_mm.is_finite() {
                return Err(PackError::OutOfRange);
            }
            let [v0, v1, v2, v3] = estimate.value_mm.to_le_bytes();
            let sigma = to_raw(estimate.sigma_mm, SIGMA).ok_or(PackError::OutOfRange)?;
            let [s0, s1, s2, _] = sigma.to_le_bytes();
            *piece = [v0, v1, v2, v3, s0, s1, s2];
        }
        e2e::protect(&mut data, LIVE_SET_ID, counter);
        Ok(data)
    }

    /// The set in bytes that were checked. None for a standing that this version does not know.
    pub fn unpack(data: &[u8; LIVE_SET_LEN]) -> Option<Self> {
        let (pieces, _) = data.as_chunks::<PIECE_LEN>();
        let [_, second, serial, identity, estimates @ ..] = pieces else { return None };
        let [_, _, _, _, _, standing, reason] = *second;
        let [s0, s1, s2, s3, w0, w1, joint] = *serial;
        let [b0, b1, r0, r1, f0, f1, _] = *identity;
        let estimate = |[v0, v1, v2, v3, s0, s1, s2]: [u8; PIECE_LEN]| Estimate {
            value_mm: f32::from_le_bytes([v0, v1, v2, v3]),
            sigma_mm: from_raw(u32::from_le_bytes([s0, s1, s2, 0]), SIGMA),
        };
        let mut all = estimates.iter().map(|piece| estimate(*piece));
        Some(Self {
            standing: Standing::from_code(standing)?,
            reason,
            serial: u32::from_le_bytes([s0, s1, s2, s3]),
            moves: joint == MOVING,
            hinge: joint == HINGE,
            wearer: u16::from_le_bytes([w0, w1]),
            boot: u16::from_le_bytes([b0, b1]),
            run_id: u16::from_le_bytes([r0, r1]),
            rig: u16::from_le_bytes([f0, f1]),
            parameters: core::array::from_fn(|_| all.next().unwrap_or_default()),
            offsets: core::array::from_fn(|_| all.next().unwrap_or_default()),
        })
    }

    /// The joint's number on the wire.
    const fn joint(&self) -> u8 {
        match (self.hinge, self.moves) {
            (true, _) => HINGE,
            (false, true) => MOVING,
            (false, false) => 0,
        }
    }

    /// The reason, if this version knows it.
    pub const fn reason(&self) -> Option<Reason> {
        Reason::from_code(self.reason)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_field_comes_back_from_its_own_place() {
        let estimate = |k: usize| Estimate { value_mm: -(k as f32) - 0.1, sigma_mm: k as f32 * 0.5 };
        let live = LiveSet {
            standing: Standing::Unconfirmed,
            reason: 130,
            serial: 0x0102_0304,
            moves: true,
            hinge: false,
            wearer: 0x0506,
            boot: 0x0708,
            run_id: 0x090A,
            rig: 0x0B0C,
            parameters: core::array::from_fn(estimate),
            offsets: core::array::from_fn(|k| estimate(k + 6)),
        };
        let data = live.pack(0x1234).unwrap();
        assert_eq!(e2e::check(&data, LIVE_SET_ID), Ok(0x1234));
        assert_eq!(LiveSet::unpack(&data), Some(live));
        let hinge = LiveSet { moves: false, hinge: true, ..live };
        assert_eq!(LiveSet::unpack(&hinge.pack(0).unwrap()), Some(hinge));
    }

    #[test]
    fn what_is_no_number_is_not_sent() {
        let mut live = LiveSet::default();
        live.parameters[2].value_mm = f32::NAN;
        assert_eq!(live.pack(0), Err(PackError::OutOfRange));
        let mut live = LiveSet::default();
        live.offsets[5].sigma_mm = 128.0;
        assert_eq!(live.pack(0), Err(PackError::OutOfRange));
    }
}
