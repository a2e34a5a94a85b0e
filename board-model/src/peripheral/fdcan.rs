//! The first FDCAN controller (RM0440, "FD controller area network").

use super::Env;
use super::bus::{BIT_HZ, CanBus, Pins, TOLERANCE_PERMILLE, bits};
use super::message_ram::{BusFrame, MessageRam, Verdict};
use crate::breach::Rule;
use crate::register_file::RegisterFile;
use crate::time::PS_A_SECOND;
use std::collections::VecDeque;

/// Its two interrupt lines in the controller of the core (RM0440, "Interrupt and exception vectors").
const LINES: [usize; 2] = [21, 22];
/// Elements of a FIFO, and transmit buffers.
const ELEMENTS: u32 = 3;
/// Registers that are written only while CCCR.INIT and CCCR.CCE are set.
const CONFIGURATION: [&str; 8] = ["DBTP", "NBTP", "TSCC", "TOCC", "RXGFC", "XIDAM", "TXBC", "TEST"];
/// Sequences of eleven recessive bits that end a bus-off.
const RECOVERY_BITS: u64 = 128 * 11;
/// A line that stays dominant behind an error flag counts as an error more after so many bits (ISO 11898-1).
const DOMINANT_BITS: u64 = 8;

/// What is on the line.
#[derive(Debug, Clone, Copy)]
enum Line {
    /// A frame of another node.
    Theirs(BusFrame),
    /// A frame of the board, from this buffer.
    Ours(u32, BusFrame),
    /// The line stays dominant for another eight bits; the board was sending when that began.
    Dominant(bool),
    /// Whoever wants to send cannot.
    Blocked,
}

/// The peripheral.
#[derive(Debug, Clone)]
pub struct Fdcan {
    /// Its registers.
    pub file: RegisterFile,
    /// Its memory; a reset leaves it alone.
    pub ram: MessageRam,
    /// What it is connected to.
    pub bus: CanBus,
    /// Frames that passed the filters, whether there was room for them or not.
    pub accepted: u64,
    line: Option<(Line, u64)>,
    /// When a bus-off ends, ps: as many recessive bits must have been seen by then.
    recovers_ps: Option<u64>,
    /// Buffers in the order in which they were handed over.
    queue: VecDeque<u32>,
}

impl Fdcan {
    /// As the supply finds it.
    pub fn new(seed: u64) -> Self {
        let file = RegisterFile::new("FDCAN1");
        let (ram, bus) = (MessageRam::new(seed), CanBus::default());
        Self { file, ram, bus, accepted: 0, line: None, recovers_ps: None, queue: VecDeque::new() }
    }

    /// A reset: the memory stays.
    pub fn reset(&mut self) {
        self.file.reset();
        (self.line, self.recovers_ps) = (None, None);
        self.queue.clear();
    }

    /// Reads a register.
    pub fn read(&mut self, offset: u32) -> u32 {
        self.file.at(offset)
    }

    /// Writes a register.
    pub fn write(&mut self, offset: u32, value: u32, env: &mut Env) {
        let name = self.file.name_at(offset).unwrap_or_default();
        let configurable = self.file.is("CCCR", "INIT") && self.file.is("CCCR", "CCE");
        match name {
            _ if CONFIGURATION.contains(&name) && !configurable => {
                // rewriting what stands there changes nothing
                if self.file.at(offset) != value {
                    env.breaches.add(Rule::Protected, format!("FDCAN1.{name} while INIT and CCE are not both set"));
                }
            }
            "IR" => self.file.put_at(offset, self.file.at(offset) & !value),
            "CCCR" => self.control(offset, value, env),
            "TXBAR" => self.add_requests(value, env),
            "RXF0A" => self.release(value),
            "PSR" | "ECR" | "RXF0S" | "RXF1S" | "TXFQS" | "TXBRP" | "TXBTO" | "TXBCF" | "CREL" | "ENDN" => {
                env.breaches.add(Rule::ReadOnly, format!("FDCAN1.{name}"));
            }
            "TXBTIE" | "TXBCIE" => {
                // only three buffers: the driver writes all bits
                self.file.put_at(offset, value & 7);
            }
            _ => self.file.write(offset, value, env.breaches),
        }
        self.raise(env);
    }

    fn control(&mut self, offset: u32, value: u32, env: &mut Env) {
        let bit = |field| self.file.field_of(value, "CCCR", field) != 0;
        let sets_init = bit("INIT");
        if bit("CCE") && !(sets_init && self.file.is("CCCR", "INIT")) && !self.file.is("CCCR", "CCE") {
            env.breaches.add(Rule::Protected, "FDCAN1.CCCR.CCE while INIT is not set");
        }
        let protected = !(self.file.is("CCCR", "INIT") && self.file.is("CCCR", "CCE"));
        for field in ["TXP", "EFBI", "PXHD", "BRSE", "FDOE", "DAR", "NISO", "MON", "TEST", "ASM"] {
            let becomes = bit(field) && !self.file.is("CCCR", field);
            if becomes && protected {
                env.breaches.add(Rule::Protected, format!("FDCAN1.CCCR.{field} while INIT and CCE are not both set"));
            }
        }
        self.file.write(offset, value, env.breaches);
        let asked_to_stop = self.file.get("CCCR", "CSR");
        self.file.put("CCCR", "CSA", asked_to_stop);
        if !sets_init {
            self.file.put("CCCR", "CCE", 0);
            if self.file.is("PSR", "BO") {
                self.recovers_ps.get_or_insert(env.now_ps + RECOVERY_BITS * self.bit_ps(env));
            }
        } else {
            (self.line, self.recovers_ps) = (None, None);
        }
    }

    fn add_requests(&mut self, value: u32, env: &mut Env) {
        for buffer in (0..ELEMENTS).filter(|buffer| value >> buffer & 1 == 1) {
            if self.queue.contains(&buffer) {
                env.breaches.add(Rule::Protected, format!("FDCAN1.TXBAR: buffer {buffer} is still being sent"));
            } else {
                self.queue.push_back(buffer);
            }
        }
        self.show_queue();
    }

    fn show_queue(&mut self) {
        let pending = self.queue.iter().fold(0, |bits, buffer| bits | 1 << buffer);
        let free = ELEMENTS - self.queue.len() as u32;
        let next = self.queue.back().map_or(self.file.get("TXFQS", "TFQPI"), |buffer| (buffer + 1) % ELEMENTS);
        self.file.put("TXBRP", "TRP", pending);
        self.file.put("TXFQS", "TFFL", free);
        self.file.put("TXFQS", "TFQF", u32::from(free == 0));
        self.file.put("TXFQS", "TFQPI", next);
        self.file.put("TXFQS", "TFGI", self.queue.front().copied().unwrap_or(next));
    }

    fn release(&mut self, index: u32) {
        let level = self.file.get("RXF0S", "F0FL");
        if level != 0 {
            self.file.put("RXF0S", "F0FL", level - 1);
            self.file.put("RXF0S", "F0GI", (index + 1) % ELEMENTS);
            self.file.put("RXF0S", "F0F", 0);
        }
    }

    /// One bit, as the registers divide the clock, ps.
    pub fn bit_ps(&self, env: &Env) -> u64 {
        let get = |field| u64::from(self.file.get("NBTP", field));
        let quanta = (get("NBRP") + 1) * (get("NTSEG1") + get("NTSEG2") + 3);
        quanta * PS_A_SECOND / u64::from(env.clocks.fdcan)
    }

    /// Where the bit is sampled, permille.
    pub fn sample_permille(&self) -> u32 {
        let (one, two) = (self.file.get("NBTP", "NTSEG1") + 2, self.file.get("NBTP", "NTSEG2") + 1);
        one * 1_000 / (one + two)
    }

    fn keeps_time(&self, env: &Env) -> bool {
        (self.bit_ps(env) * BIT_HZ).abs_diff(PS_A_SECOND) * 1_000 <= PS_A_SECOND * TOLERANCE_PERMILLE
    }

    /// When something happens next on the line.
    pub fn next_ps(&self, now_ps: u64) -> Option<u64> {
        let on_bus = !self.file.is("CCCR", "INIT") && !self.file.is("PSR", "BO");
        let wants = !self.bus.waiting.is_empty() || on_bus && !self.queue.is_empty();
        let line = self.line.map(|(_, until)| until).or(wants.then_some(now_ps));
        line.into_iter().chain(self.recovers_ps).min()
    }

    /// Lets time pass on the line.
    pub fn advance(&mut self, pins: Pins, env: &mut Env) {
        if let Some((line, until)) = self.line
            && env.now_ps >= until
        {
            self.line = None;
            match line {
                Line::Theirs(frame) => self.hear(&frame, pins, env),
                Line::Ours(buffer, frame) => self.finish(buffer, frame, pins, env),
                Line::Dominant(was_sending) if pins.dominant() => self.bear(was_sending, pins, env),
                Line::Dominant(_) | Line::Blocked => {}
            }
            self.raise(env);
        }
        if self.recovers_ps.is_some_and(|at| env.now_ps >= at) {
            self.recover(pins, env);
        }
        if self.line.is_none() {
            self.begin(pins, env);
        }
    }

    fn recover(&mut self, pins: Pins, env: &mut Env) {
        if pins.dominant() {
            // no recessive bit has been seen
            self.recovers_ps = Some(env.now_ps + RECOVERY_BITS * self.bit_ps(env));
            return;
        }
        self.recovers_ps = None;
        self.file.put("PSR", "BO", 0);
        self.file.put("ECR", "TEC", 0);
        self.show_passive();
        self.file.put("IR", "BO", 1);
        self.raise(env);
    }

    /// Another eight dominant bits behind an error flag (ISO 11898-1, "Fault confinement"): eight errors more for whoever
    /// sent, and for whoever received.
    fn bear(&mut self, was_sending: bool, pins: Pins, env: &mut Env) {
        if was_sending {
            self.fail(self.file.get("ECR", "TEC") + 8, env);
        } else {
            self.note_receive_errors(8);
        }
        if pins.transmit != Some(false) {
            // only this board cannot see it: what others say meanwhile passes unheard
            self.bus.waiting.clear();
        }
        if !self.file.is("PSR", "BO") {
            self.line = Some((Line::Dominant(was_sending), env.now_ps + DOMINANT_BITS * self.bit_ps(env)));
        }
    }

    /// The most urgent frame takes the line: of two, the lower identifier.
    fn begin(&mut self, pins: Pins, env: &mut Env) {
        let on_bus = pins.connected && !self.file.is("CCCR", "INIT") && !self.file.is("PSR", "BO");
        if on_bus && pins.dominant() {
            // the first dominant bits begin a frame that breaks the rule of stuffing
            return self.bear(false, pins, env);
        }
        let first = self.queue.front().filter(|_| on_bus).copied();
        let ours = first.map(|buffer| (buffer, self.ram.to_send(buffer as usize, &mut *env.breaches)));
        let is_free = !self.bus.shorted && pins.transmit != Some(false);
        let theirs = self.bus.waiting.front().copied().filter(|_| is_free);
        let duration = |frame: &BusFrame| bits(frame) * PS_A_SECOND / BIT_HZ;
        // a frame of others has no eleven recessive bits in a row but at its end
        self.recovers_ps = self.recovers_ps.map(|at| at + theirs.as_ref().map_or(0, duration));
        self.line = match (ours, theirs) {
            (Some((_, ours)), Some(theirs)) if theirs.id < ours.id => {
                Some((Line::Theirs(theirs), env.now_ps + duration(&theirs)))
            }
            (Some((buffer, frame)), _) => Some((Line::Ours(buffer, frame), env.now_ps + duration(&frame))),
            (None, Some(theirs)) => Some((Line::Theirs(theirs), env.now_ps + duration(&theirs))),
            (None, None) => {
                (!self.bus.waiting.is_empty()).then_some((Line::Blocked, env.now_ps + PS_A_SECOND / BIT_HZ))
            }
        };
    }

    fn hear(&mut self, frame: &BusFrame, pins: Pins, env: &mut Env) {
        self.bus.waiting.pop_front();
        let is_off = !pins.connected || self.file.is("CCCR", "INIT") || self.file.is("PSR", "BO");
        if is_off || pins.receive.is_some() || pins.dominant() {
            return;
        }
        if !self.keeps_time(env) {
            self.note_receive_errors(1);
            return;
        }
        // beyond 127 a good frame brings the counter back to where it may count (ISO 11898-1)
        let errors = if self.file.is("ECR", "RP") { 127 } else { self.file.get("ECR", "REC").saturating_sub(1) };
        self.file.put("ECR", "REC", errors);
        self.file.put("ECR", "RP", 0);
        self.show_passive();
        let get = |field| self.file.get("RXGFC", field);
        let rejects_remote = if frame.extended { get("RRFE") } else { get("RRFS") };
        if frame.remote && rejects_remote != 0 {
            return;
        }
        let (verdict, others) = if frame.extended {
            let mask = self.file.get("XIDAM", "EIDM");
            (self.ram.judge_extended(get("LSE") as usize, frame.id, mask, env.breaches), get("ANFE"))
        } else {
            (self.ram.judge_standard(get("LSS") as usize, frame.id, env.breaches), get("ANFS"))
        };
        match (verdict, others) {
            (Verdict::Fifo(fifo), _) => self.store(fifo, frame),
            (Verdict::NoMatch, 0) => self.store(0, frame),
            (Verdict::NoMatch, 1) => self.store(1, frame),
            _ => {}
        }
    }

    fn note_receive_errors(&mut self, more: u32) {
        let errors = self.file.get("ECR", "REC") + more;
        self.file.put("ECR", "REC", errors.min(127));
        if errors > 127 {
            self.file.put("ECR", "RP", 1);
        }
        self.show_passive();
    }

    /// One of the counters is beyond 127.
    fn show_passive(&mut self) {
        let is_passive = self.file.is("ECR", "RP") || self.file.get("ECR", "TEC") > 127;
        self.file.put("PSR", "EP", is_passive.into());
    }

    fn store(&mut self, fifo: usize, frame: &BusFrame) {
        self.accepted += 1;
        let [status, level, get, put, full, lost] =
            [["RXF0S", "F0FL", "F0GI", "F0PI", "F0F", "RF0L"], ["RXF1S", "F1FL", "F1GI", "F1PI", "F1F", "RF1L"]][fifo];
        let filled = self.file.get(status, level);
        if filled == ELEMENTS {
            self.file.put("IR", lost, 1);
            return;
        }
        let index = self.file.get(status, put);
        self.ram.receive(fifo, index as usize, frame);
        self.file.put(status, put, (index + 1) % ELEMENTS);
        self.file.put(status, level, filled + 1);
        self.file.put(status, full, u32::from(filled + 1 == ELEMENTS));
        if filled == 0 {
            self.file.put(status, get, index);
        }
        self.file.put("IR", if fifo == 0 { "RF0N" } else { "RF1N" }, 1);
    }

    fn finish(&mut self, buffer: u32, frame: BusFrame, pins: Pins, env: &mut Env) {
        let errors = self.file.get("ECR", "TEC");
        if pins.dominant() {
            return self.bear(true, pins, env);
        }
        if self.bus.shorted || pins.garbles() || !self.keeps_time(env) {
            return self.fail(errors + 8, env);
        }
        if self.bus.lonely {
            // an error-passive node does not count what nobody acknowledges
            return self.fail(if self.file.is("PSR", "EP") { errors } else { errors + 8 }, env);
        }
        self.queue.pop_front();
        self.bus.sent.push((env.now_ps, frame));
        self.file.put("ECR", "TEC", errors.saturating_sub(1));
        self.show_passive();
        let done = self.file.get("TXBTO", "TO") | 1 << buffer;
        self.file.put("TXBTO", "TO", done);
        if self.file.get("TXBTIE", "TIE") >> buffer & 1 == 1 {
            self.file.put("IR", "TC", 1);
        }
        self.show_queue();
    }

    fn fail(&mut self, errors: u32, env: &mut Env) {
        self.file.put("ECR", "TEC", errors.min(255));
        self.show_passive();
        if errors > 255 {
            self.file.put("PSR", "BO", 1);
            self.file.put("CCCR", "INIT", 1);
            self.file.put("IR", "BO", 1);
        }
        self.raise(env);
    }

    /// Hands what is set, enabled and assigned to a line that is on to the core.
    fn raise(&mut self, env: &mut Env) {
        let at = |name| self.file.at(self.file.offset(name));
        let raised = at("IR") & at("IE");
        if raised == 0 {
            return;
        }
        // groups of flags by line; this image leaves all of them to the first one
        let line = usize::from(at("ILS") != 0);
        if self.file.is("ILE", ["EINT0", "EINT1"][line]) {
            env.nvic.pend_line(LINES[line]);
        }
    }
}
