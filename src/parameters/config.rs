//! What a device is made for.

use super::set::ParameterSet;
use crate::can::BaseId;
use crate::procedure::{Limits, ModuleRig};
use crate::restart::Restart;

/// Sets of telemetry a second: what a picture of the arm needs to look smooth.
pub const DEFAULT_TELEMETRY_HZ: u16 = 50;
/// Time between two sets of what a controller acts on, ms: it changes by decisions of people.
pub const DEFAULT_LIVE_PERIOD_MS: u16 = 100;

/// What a device is made for.
#[derive(Debug, Clone, PartialEq)]
pub struct Config {
    /// The machine, which says which joint it is about.
    pub rig: ModuleRig,
    /// The limits of a run.
    pub limits: Limits,
    /// The device's block of CAN identifiers.
    pub base: BaseId,
    /// Why the board last started.
    pub restart: Restart,
    /// Serial number of the board; 0 when it has none.
    pub serial: u32,
    /// Sets of [`Telemetry`](crate::can::Telemetry) a second, 0 to 100; 0 = off.
    pub telemetry_hz: u16,
    /// Time between two sets of what a controller acts on, ms; 0 = off.
    pub live_period_ms: u16,
    /// Key of the parameters' lock; all zero = there is no lock.
    pub lock_key: [u32; 4],
    /// The first centre on the machine is accepted only after every cable was pulled and found at its encoder.
    pub numbering_check: bool,
    /// The values of all parameters.
    pub parameters: ParameterSet,
}

impl Config {
    /// Default limits and identifiers for a rig.
    pub fn for_rig(rig: impl Into<ModuleRig>) -> Self {
        let rig = rig.into();
        let limits = rig.default_limits();
        let parameters = ParameterSet::of_module(&rig, &limits);
        Self {
            limits,
            rig,
            base: BaseId::DEFAULT,
            restart: Restart::default(),
            serial: 0,
            telemetry_hz: DEFAULT_TELEMETRY_HZ,
            live_period_ms: DEFAULT_LIVE_PERIOD_MS,
            lock_key: [0; 4],
            numbering_check: false,
            parameters,
        }
    }
}
