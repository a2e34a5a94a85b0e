//! Who is on the bus? Each module's identifiers must be those of one board, and that board must have the module's machine.
//!
//! On a real bus two boards at the same identifiers disturb each other only where they send at once; most of their frames
//! get through, and a client that looks at the state alone sees one board with odd manners. Every heartbeat is followed by the
//! board's serial number, counts on from the one before, and both boards answer a query, each with the fingerprint of its rig.

use super::bus::Bus;
use super::module::{ArmModule, name};
use crate::rehearse::bench::BenchError;
use glenoid::can::{BaseId, Frame, Message, Opcode, Request};
use glenoid::identification::arm::Module;
use std::collections::BTreeSet;
use std::fmt;

/// So long is listened, ms: ten heartbeats of each board.
const LISTEN_MS: u32 = 1_000;
const PERIOD_MS: u32 = 10;
/// A run of heartbeats may begin anew once: a board that starts while it is listened to.
const BREAKS_GRANTED: u32 = 1;

/// What is wrong with the bus.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum BusFault {
    /// Nobody is at a module's identifiers.
    Missing(Module, BaseId),
    /// More than one board is there.
    Twice {
        /// The module.
        at: Module,
        /// Its identifiers.
        base: BaseId,
        /// The boards' serial numbers.
        serials: BTreeSet<u32>,
        /// Whose rigs they have, in words.
        rigs: Vec<String>,
    },
    /// The board there has another rig.
    WrongRig {
        /// The module.
        at: Module,
        /// Its identifiers.
        base: BaseId,
        /// Whose rig it has, in words.
        rig: String,
    },
    /// The bus itself.
    Bench(BenchError),
}

impl fmt::Display for BusFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing(which, base) => write!(
                f,
                "no board at {:#X}, where the {}'s should be. What to do: look at its supply and its plug, and whether its \
                 parameter base_id is {0:#X}",
                base.raw(),
                name(*which)
            ),
            Self::Twice { at, base, serials, rigs } => {
                let serials: Vec<_> = serials.iter().map(u32::to_string).collect();
                write!(
                    f,
                    "more than one board at {:#X}, where the {}'s should be: serial numbers {}, with {}. What to do: unplug the \
                     one that does not belong there, and give it a base_id of its own while it is alone on the bus",
                    base.raw(),
                    name(*at),
                    serials.join(" and "),
                    rigs.join(" and ")
                )
            }
            Self::WrongRig { at, base, rig } => write!(
                f,
                "the board at {:#X}, where the {}'s should be, has {rig}. What to do: plug the modules in where they belong, or \
                 load the {1}'s rig into that board",
                base.raw(),
                name(*at)
            ),
            Self::Bench(error) => write!(f, "{error}"),
        }
    }
}

impl From<BenchError> for BusFault {
    fn from(error: BenchError) -> Self {
        Self::Bench(error)
    }
}

/// What was heard at one module's identifiers.
#[derive(Default)]
struct Heard {
    serials: BTreeSet<u32>,
    rigs: BTreeSet<u16>,
    sequence: Option<u8>,
    breaks: u32,
}

impl Heard {
    fn at(base: BaseId, frames: &[Frame]) -> Self {
        let mut heard = Self::default();
        for message in frames.iter().filter_map(|frame| Message::unpack(frame, base).ok()) {
            match message {
                Message::Identity(identity) => drop(heard.serials.insert(identity.serial)),
                Message::Versions(versions) => drop(heard.rigs.insert(versions.rig)),
                Message::Heartbeat(heartbeat) => {
                    let follows = heard.sequence.is_none_or(|before| heartbeat.sequence == before.wrapping_add(1));
                    heard.breaks += u32::from(!follows);
                    heard.sequence = Some(heartbeat.sequence);
                }
                _ => {}
            }
        }
        heard
    }

    fn is_more_than_one(&self) -> bool {
        self.serials.len() > 1 || self.rigs.len() > 1 || self.breaks > BREAKS_GRANTED
    }
}

/// Listens to the bus, and asks each module's board what it is.
///
/// # Errors
/// [`BusFault`], of the module nearest to the thorax.
pub fn roll_call(bus: &mut dyn Bus, modules: &[ArmModule]) -> Result<(), BusFault> {
    for module in modules {
        let query = Request { opcode: Opcode::Query as u8, boot: 0, nonce: u16::MAX, run_id: 0, argument: 0 };
        bus.send(&query.pack(module.base.command()))?;
    }
    let mut frames = Vec::new();
    for _ in 0..LISTEN_MS / PERIOD_MS {
        frames.extend(bus.pass(PERIOD_MS)?);
    }
    let whose = |rig: u16| match modules.iter().find(|module| module.fingerprint() == rig) {
        Some(module) => format!("the {}'s rig", name(module.which)),
        None => format!("a rig of no module ({rig:#06X})"),
    };
    for module in modules {
        let (at, base) = (module.which, module.base);
        let heard = Heard::at(base, &frames);
        if heard.sequence.is_none() {
            return Err(BusFault::Missing(at, base));
        }
        if heard.is_more_than_one() {
            let rigs = heard.rigs.into_iter().map(whose).collect();
            return Err(BusFault::Twice { at, base, serials: heard.serials, rigs });
        }
        if let Some(rig) = heard.rigs.into_iter().find(|rig| *rig != module.fingerprint()) {
            return Err(BusFault::WrongRig { at, base, rig: whose(rig) });
        }
    }
    Ok(())
}
