//! The board's parameters: what there is, requests about them, and the machine that they make.

use super::json;
use glenoid::can::{BaseId, Operation, ParameterRequest};
use glenoid::parameters::{Kind, ParameterSet, TABLE, find};
use glenoid::procedure::ModuleRig;
use glenoid::restart::Restart;
use glenoid::slcan;
use vocabulary::parameters::signal_name;

/// The table as a JSON list.
pub fn table() -> String {
    json::join(TABLE.iter().map(|entry| {
        let described = entry.description();
        let value = |bits| match entry.kind {
            // its own shortest digits
            Kind::Single => f32::from_bits(bits).to_string(),
            Kind::Integer => bits.to_string(),
        };
        format!(
            "[{},{},{},{},{},{},{},{},{}]",
            entry.index,
            json::text(&signal_name(described.name)),
            json::text(described.unit),
            u8::from(entry.kind == Kind::Single),
            value(entry.default),
            value(entry.minimum),
            value(entry.maximum),
            u8::from(entry.guarded),
            json::text(described.text)
        )
    }))
}

/// A request as a line of SLCAN.
pub fn request(operation: u32, index: u32, nonce: u32, value: u32) -> Option<Vec<u8>> {
    let operation = Operation::from_code(u8::try_from(operation).ok()?)? as u8;
    let (index, nonce) = (u16::try_from(index).ok()?, u8::try_from(nonce).ok()?);
    let request = ParameterRequest { operation, index, nonce, value };
    Some(slcan::encode(&request.pack(BaseId::DEFAULT.parameters()), None).to_vec())
}

/// The machine of the defaults with these values instead: index and bits of each.
pub fn rig_of(bytes: &[u8]) -> Result<ModuleRig, String> {
    let mut set = ParameterSet::new();
    for [a, b, c, d, e, f, g, h] in bytes.as_chunks::<8>().0 {
        let (index, bits) = (u32::from_le_bytes([*a, *b, *c, *d]), u32::from_le_bytes([*e, *f, *g, *h]));
        // What another version of the board has beside these is not for this machine.
        if let Ok(index) = u16::try_from(index) {
            let _ = set.set_bits(index, bits);
        }
    }
    match set.config(Restart::default(), 0) {
        Ok(config) => Ok(config.rig),
        Err(contradiction) => Err(find(contradiction.index)
            .map_or_else(|| contradiction.index.to_string(), |(_, entry)| signal_name(entry.description().name))),
    }
}
