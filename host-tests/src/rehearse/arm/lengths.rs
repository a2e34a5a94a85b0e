//! The cable lengths of a posture, from the telemetry of a module's board.

use super::bus::Bus;
use super::module::{ArmModule, name};
use glenoid::can::set::{Received, Receiver};
use glenoid::can::telemetry::{TELEMETRY_ID, TELEMETRY_LEN};
use glenoid::can::{Message, Telemetry};
use glenoid::rig::CABLES;

/// Longest wait for a set, ms.
const LIMIT_MS: u32 = 2_000;
const PERIOD_MS: u32 = 10;

/// The lengths in the next whole set with the joint at rest, mm.
///
/// # Errors
/// When none comes, or a board is gone.
pub fn lengths_mm(bus: &mut dyn Bus, module: &ArmModule) -> Result<[f32; CABLES], String> {
    let mut receiver = Receiver::<TELEMETRY_LEN>::new(TELEMETRY_ID);
    for _ in 0..LIMIT_MS / PERIOD_MS {
        for frame in bus.pass(PERIOD_MS).map_err(|error| error.to_string())? {
            let Ok(Message::Telemetry(piece)) = Message::unpack(&frame, module.base) else { continue };
            let Received::Set { data, .. } = receiver.take(piece) else { continue };
            if let Some(telemetry) = Telemetry::unpack(&data).filter(|set| set.still && set.encoders) {
                return Ok(telemetry.lengths_mm);
            }
        }
    }
    Err(format!("the {}'s board sends no lengths of an arm at rest", name(module.which)))
}
