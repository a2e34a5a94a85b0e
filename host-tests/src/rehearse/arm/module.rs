//! A module of the arm as its board has it: where it is on the bus, and what it is told.

use glenoid::can::BaseId;
use glenoid::device::module_fingerprint;
use glenoid::identification::arm::Module;
use glenoid::parameters::{Key, ParameterSet, TABLE};
use glenoid::procedure::ModuleRig;
use glenoid::restart::Restart;
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
    /// Its machine, as the board makes it from its parameters.
    pub rig: ModuleRig,
    parameters: ParameterSet,
}

impl ArmModule {
    /// A module with identifiers of its own and a machine that is told by these parameters.
    ///
    /// # Errors
    /// What the parameters contradict.
    pub fn new(which: Module, parameters: ParameterSet) -> Result<Self, String> {
        let (base, serial) = match which {
            Module::Shoulder => (0x6C0, 101),
            Module::Elbow => (0x700, 102),
            Module::Wrist => (0x740, 103),
        };
        let base = BaseId::new(base).ok_or("not a multiple of 64")?;
        let config = parameters.config(Restart::default(), serial);
        let config = config.map_err(|at| format!("the {}: index {} contradicts the others", name(which), at.index))?;
        Ok(Self { which, base, serial, rig: config.rig, parameters })
    }

    /// What a board is told to become this module, or to stand in its place with the machine of another one.
    ///
    /// # Errors
    /// None in practice.
    pub fn parameters(&self, machine: &Self) -> Result<ParameterSet, String> {
        let mut set = machine.parameters;
        let base = u32::from(self.base.raw());
        for (key, value) in [(Key::BaseId, base), (Key::TelemetryRate, TELEMETRY_HZ), (Key::LivePeriod, LIVE_PERIOD_MS)]
        {
            put(&mut set, key, value)?;
        }
        Ok(set)
    }

    /// By what a board that has this module's machine is known.
    pub fn fingerprint(&self) -> u16 {
        let all = module_fingerprint(&self.rig);
        (all >> 16) as u16 ^ all as u16
    }
}

/// Sets a parameter.
fn put(set: &mut ParameterSet, key: Key, bits: u32) -> Result<(), String> {
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
