//! A module of the arm as its board has it: where it is on the bus, and what it is told.

use crate::rehearse::machine::KnownMachine;
use glenoid::can::BaseId;
use glenoid::device::fingerprint;
use glenoid::identification::arm::Module;
use glenoid::parameters::{Key, ParameterSet, TABLE};
use serde::{Serialize, Serializer};

/// Sets of telemetry a second of each board, and time between two sets of what a controller acts on, ms. Every board gets the
/// frames of both others, and an emulated UART takes 800 of them a second at most; a new board alone sends 500.
const TELEMETRY_HZ: u32 = 5;
const LIVE_PERIOD_MS: u32 = 1_000;

/// One of the three, and its board.
#[derive(Debug, Clone)]
pub struct ArmModule {
    /// Which.
    pub which: Module,
    /// Where its board is on the bus. A new board is at the default: that place stays free.
    pub base: BaseId,
    /// Serial number of its board.
    pub serial: u32,
    /// Its machine.
    pub machine: KnownMachine,
}

impl ArmModule {
    /// A module with its own identifiers.
    ///
    /// # Errors
    /// None in practice.
    pub fn new(which: Module, machine: KnownMachine) -> Result<Self, String> {
        let (base, serial) = match which {
            Module::Shoulder => (0x6C0, 101),
            Module::Elbow => (0x700, 102),
            Module::Wrist => (0x740, 103),
        };
        let base = BaseId::new(base).ok_or("not a multiple of 64")?;
        Ok(Self { which, base, serial, machine })
    }

    /// What a board is told to become this module, with a machine that should be its own.
    ///
    /// # Errors
    /// None in practice.
    pub fn parameters(&self, machine: &KnownMachine) -> Result<ParameterSet, String> {
        let mut set = machine.told.unwrap_or_default();
        let base = u32::from(self.base.raw());
        for (key, value) in
            [(Key::BaseId, base), (Key::TelemetryRate, TELEMETRY_HZ), (Key::LivePeriod, LIVE_PERIOD_MS)]
        {
            put(&mut set, key, value)?;
        }
        Ok(set)
    }

    /// By what a board that has this module's machine is known.
    pub fn fingerprint(&self) -> u16 {
        let all = fingerprint(&self.machine.single);
        (all >> 16) as u16 ^ all as u16
    }
}

/// Sets a parameter.
pub(super) fn put(set: &mut ParameterSet, key: Key, bits: u32) -> Result<(), String> {
    let index = TABLE[key as usize].index;
    set.set_bits(index, bits).map_err(|reason| format!("parameter {index}: {}", reason.text()))
}

/// What people call it.
pub const fn name(which: Module) -> &'static str {
    match which {
        Module::Shoulder => "shoulder",
        Module::Elbow => "elbow",
        Module::Wrist => "wrist",
    }
}

/// The name, in JSON.
pub(super) fn serialize_name<S: Serializer>(which: &Module, serializer: S) -> Result<S::Ok, S::Error> {
    name(*which).serialize(serializer)
}
