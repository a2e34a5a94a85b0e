//! A timer as far as it counts the edges of an encoder (RM0440, "Encoder interface mode").

use super::Env;
use super::gpio::{Gpio, Mode};
use crate::register_file::RegisterFile;
use crate::time::PS_A_SECOND;

/// Ports A, B, C.
pub type Ports = [Gpio; 3];

/// A pin that a timer's channel can have: port (0 is A), number, alternate function (STM32G474 datasheet, "Alternate
/// function mapping").
pub type Channel = (usize, u32, u32);

/// Periods and samples of an input filter by its code: a level counts when it was seen so often in a row at every
/// so many-th clock (RM0440: TIMx_CCMR1.IC1F).
const FILTERS: [(u64, u64); 16] = [
    (1, 1),
    (1, 2),
    (1, 4),
    (1, 8),
    (2, 6),
    (2, 8),
    (4, 6),
    (4, 8),
    (8, 6),
    (8, 8),
    (16, 5),
    (16, 6),
    (16, 8),
    (32, 5),
    (32, 6),
    (32, 8),
];

/// The timer.
#[derive(Debug, Clone)]
pub struct Timer {
    /// Its registers.
    pub file: RegisterFile,
    /// The pins of channels 1 and 2, as the board is wired.
    pub wired: [Channel; 2],
    /// It is on the second peripheral bus.
    pub on_apb2: bool,
    /// Where the encoder stands, counts.
    position: i64,
    /// The levels behind the filters; None before the encoder has turned at all.
    seen: Option<[bool; 2]>,
}

impl Timer {
    /// As a reset leaves it.
    pub fn new(name: &'static str, wired: [Channel; 2], on_apb2: bool) -> Self {
        Self { file: RegisterFile::new(name), wired, on_apb2, position: 0, seen: None }
    }

    /// The timer has 32 bits.
    pub fn is_wide(&self) -> bool {
        matches!(self.file.name, "TIM2" | "TIM5")
    }

    /// Reads a register.
    pub fn read(&self, offset: u32) -> u32 {
        self.file.at(offset)
    }

    /// Writes a register.
    pub fn write(&mut self, offset: u32, value: u32, env: &mut Env) {
        let bits = if self.is_wide() { u32::MAX } else { 0xFFFF };
        match self.file.name_at(offset) {
            Some("CNT" | "ARR" | "CCR1" | "CCR2" | "CCR3" | "CCR4") => self.file.put_at(offset, value & bits),
            _ => self.file.write(offset, value, env.breaches),
        }
    }

    /// Why the timer does not count an encoder on its two wires; None when it does.
    pub fn objection(&self, ports: &Ports) -> Option<String> {
        let (file, name) = (&self.file, self.file.name);
        for (port, pin, function) in self.wired {
            if ports[port].mode(pin) != Mode::Alternate(function) {
                return Some(format!("{name}: pin {pin} of port {port} is {:?}", ports[port].mode(pin)));
            }
        }
        let is_encoder = file.get("SMCR", "SMS") == 3;
        let inputs = file.get("CCMR1_INPUT", "CC1S") == 1 && file.get("CCMR1_INPUT", "CC2S") == 1;
        let falls = file.is("CCER", "CC1P") || file.is("CCER", "CC2P");
        let ok = is_encoder && inputs && !falls && file.is("CR1", "CEN");
        (!ok).then(|| format!("{name}: not both edges of both channels are counted"))
    }

    /// How long a level must last to be seen, ps.
    pub fn filter_ps(&self, clock_hz: u32) -> u64 {
        let slowest = [self.file.get("CCMR1_INPUT", "IC1F"), self.file.get("CCMR1_INPUT", "IC2F")];
        let (divider, samples) = FILTERS[slowest[0].max(slowest[1]) as usize];
        let sampling = 1 << self.file.get("CR1", "CKD");
        divider * samples * sampling * PS_A_SECOND / u64::from(clock_hz)
    }

    /// The encoder turns by so many counts, each level of a channel (two counts long) lasting so long. A channel whose wire is at fault
    /// keeps its level meanwhile.
    pub fn turn(&mut self, counts: i32, level_ps: u64, clock_hz: u32, ports: &Ports) -> Result<(), String> {
        if let Some(objection) = self.objection(ports) {
            return Err(objection);
        }
        let held = self.wired.map(|(port, pin, _)| ports[port].held(pin));
        let levels = |position: i64| {
            let driven = channels(position);
            [0, 1].map(|channel| held[channel].unwrap_or(driven[channel]))
        };
        let before = self.position;
        self.position += i64::from(counts);
        self.seen.get_or_insert_with(|| levels(before));
        if level_ps < self.filter_ps(clock_hz) {
            return Ok(());
        }
        // first what has changed since, then step by step
        let mut counted = self.see(levels(before));
        for step in 1..=i64::from(counts.unsigned_abs()) {
            counted += self.see(levels(before + step * i64::from(counts.signum())));
        }
        let counter = self.file.offset("CNT");
        let top = i64::from(self.file.at(self.file.offset("ARR"))) + 1;
        let now = (i64::from(self.file.at(counter)) + counted).rem_euclid(top);
        self.file.put_at(counter, now as u32);
        Ok(())
    }

    /// What the edges to these levels count (RM0440, "Counting direction versus encoder signals", both inputs): channel 1
    /// counts upwards when it rises while the other is low or falls while the other is high, channel 2 the other way round.
    fn see(&mut self, levels: [bool; 2]) -> i64 {
        let seen = self.seen.get_or_insert(levels);
        let mut counted = 0;
        for channel in 0..2 {
            if levels[channel] != seen[channel] {
                seen[channel] = levels[channel];
                let is_up = (levels[channel] != seen[1 - channel]) == (channel == 0);
                counted += if is_up { 1 } else { -1 };
            }
        }
        counted
    }
}

/// The levels of an encoder's channels A and B: a quarter of a period apart, A first when it counts upwards.
fn channels(position: i64) -> [bool; 2] {
    let quarter = position.rem_euclid(4);
    [matches!(quarter, 1 | 2), matches!(quarter, 2 | 3)]
}
