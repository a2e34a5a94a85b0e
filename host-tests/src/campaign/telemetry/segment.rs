//! One stretch of time on the bus.

use super::bus::{Bus, Carried};
use super::consumer::{Careless, Consumer};
use super::sent::{Sent, Taken};
use super::{ANSWER_LIMIT_US, Outcome};
use crate::power_cut;
use crate::wearer::{Wearer, WearerSettings};
use glenoid::can::{BaseId, Frame, Message, Opcode, Request};
use glenoid::device::{Action, Config, Device, Event, fingerprint};
use glenoid::record::Record;
use glenoid::rig::{ASSUMED_BASE_RADIUS_MM, Rig};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Time between two samples of the encoders, ms.
const SAMPLE_MS: u64 = 10;
/// The consumer misses one frame in so many, and hears one in so many twice: its controller saw an error in the last bit of
/// the frame, which the sender did not (ISO 11898-1).
const MISSED: u32 = 500;
const TWICE: u32 = 2_000;
/// One frame in so many reaches it with a bit that is wrong, past the bus's own check.
const WRONG: u32 = 100_000;
/// Mean time between two commands, ms, and between two restarts of the device.
const COMMAND_MS: u32 = 200;
const RESTART_MS: u32 = 20_000;
/// A restart takes so long, ms.
const OFF_MS: u64 = 150;

/// What every stretch begins with: a device, the centre in its record, and an arm that moves.
pub struct Scene {
    device: Device,
    record: Record,
    counts: Vec<[i32; 6]>,
}

impl Scene {
    pub fn new() -> Result<Self, String> {
        let rig = Rig::shoulder(ASSUMED_BASE_RADIUS_MM as f32).map_err(|error| error.text())?;
        // as the shoulder could have it
        let covariance_mm2 = std::array::from_fn(|k| 0.01 + k as f32 * 1e-4);
        let record =
            Record { rig: fingerprint(&rig), parameters: *rig.nominal(), covariance_mm2, ..power_cut::record(7) };
        // the wearer is the one of the record
        let settings = WearerSettings { centre_offset_mm: 0.0, cuff_offset_mm: 0.0, ..WearerSettings::default() };
        let machine = Rig::shoulder(ASSUMED_BASE_RADIUS_MM).map_err(|error| error.text())?;
        let mut wearer = Wearer::new(machine, settings);
        let poses: Vec<_> = (0..20).map(|_| wearer.next_pose()).collect();
        let ways = poses.iter().zip(poses.iter().cycle().skip(1));
        let counts = ways.flat_map(|(from, to)| wearer.motion(from, to, 1_000, SAMPLE_MS as u32)).collect();
        Ok(Self { device: Device::new(&Config::for_rig(rig)), record, counts })
    }

    /// Plays so many milliseconds.
    pub fn play(&self, seed: u64, length_ms: u64) -> Outcome {
        let mut play = Play {
            device: self.device.clone(),
            bus: Bus::new(),
            random: ChaCha8Rng::seed_from_u64(seed),
            consumer: Consumer::new(),
            careless: Careless::new(),
            sent: Sent::new(),
            last_taken: 0,
            asked: None,
            nonce: 0,
            outcome: Outcome::default(),
        };
        let mut off_until_ms = 0;
        play.event(0, Event::PowerUp(Ok(self.record).into()));
        for now_ms in 0..length_ms {
            if play.random.random_ratio(1, RESTART_MS) && play.asked.is_none() {
                off_until_ms = now_ms + OFF_MS;
                play.restart(&self.device);
                play.event(now_ms, Event::PowerUp(Ok(self.record).into()));
            }
            if now_ms >= off_until_ms {
                if now_ms.is_multiple_of(SAMPLE_MS) {
                    let counts = self.counts[(now_ms / SAMPLE_MS) as usize % self.counts.len()];
                    play.event(now_ms, Event::Counts(counts));
                }
                play.event(now_ms, Event::Tick);
                play.ask(now_ms);
            }
            play.carry(now_ms);
        }
        play.outcome.time_us = length_ms * 1_000;
        play.outcome.busy_us = play.bus.busy_us;
        play.outcome.sent = play.sent.number;
        play.outcome.lost = play.consumer.lost;
        play.outcome.refused = play.consumer.refused;
        play.outcome
    }
}

struct Play {
    device: Device,
    bus: Bus,
    random: ChaCha8Rng,
    consumer: Consumer,
    careless: Careless,
    sent: Sent,
    /// Number of the set that the consumer took last.
    last_taken: u64,
    /// The command that waits for its answer, and since when, µs.
    asked: Option<(u16, u64)>,
    nonce: u16,
    outcome: Outcome,
}

impl Play {
    fn event(&mut self, now_ms: u64, event: Event) {
        let Self { device, bus, sent, .. } = self;
        device.handle(now_ms as u32, event, &mut |action| {
            let Action::Send(frame) = action else { return };
            if let Ok(Message::Telemetry(piece)) = Message::unpack(&frame, BaseId::DEFAULT) {
                sent.piece(now_ms * 1_000, piece);
            }
            bus.send_by_device(frame);
        });
    }

    fn restart(&mut self, new: &Device) {
        self.outcome.restarts += 1;
        self.device = new.clone();
        self.bus.forget_device();
    }

    /// Gives a command now and then, one at a time.
    fn ask(&mut self, now_ms: u64) {
        if self.asked.is_some() || !self.random.random_ratio(1, COMMAND_MS) {
            return;
        }
        self.nonce = self.nonce % u16::MAX + 1;
        let opcodes = [Opcode::Query, Opcode::Capture, Opcode::SetZeroPrior, Opcode::Abort];
        let opcode = opcodes[self.random.random_range(0..opcodes.len())] as u8;
        let request = Request { opcode, boot: 0, nonce: self.nonce, run_id: 0, argument: 0 };
        self.bus.send_by_client(request.pack(BaseId::DEFAULT.command()));
        self.asked = Some((self.nonce, now_ms * 1_000));
        self.outcome.commands += 1;
    }

    /// The bus carries what it can in this millisecond.
    fn carry(&mut self, now_ms: u64) {
        while let Some((at_us, carried)) = self.bus.next((now_ms + 1) * 1_000, &mut self.random) {
            match carried {
                Carried::Foreign => self.outcome.foreign_frames += 1,
                Carried::Client(frame) => self.event(now_ms, Event::Can(frame)),
                Carried::Device(frame) => self.hear(at_us, &frame),
            }
        }
        if let Some((_, asked_us)) = self.asked
            && now_ms * 1_000 > asked_us + ANSWER_LIMIT_US
        {
            self.outcome.late_answers += 1;
            self.asked = None;
        }
    }

    fn hear(&mut self, at_us: u64, frame: &Frame) {
        match Message::unpack(frame, BaseId::DEFAULT) {
            Ok(Message::Answer(answer)) => {
                if let Some((nonce, asked_us)) = self.asked
                    && nonce == answer.nonce
                {
                    self.outcome.slowest_answer_us = self.outcome.slowest_answer_us.max(at_us - asked_us);
                    self.asked = None;
                }
            }
            Ok(Message::Telemetry(piece)) => self.telemetry(at_us, piece),
            _ => {}
        }
    }

    fn telemetry(&mut self, at_us: u64, mut piece: [u8; 8]) {
        if self.random.random_ratio(1, MISSED) {
            return;
        }
        if self.random.random_ratio(1, WRONG) {
            let bit = self.random.random_range(0..64);
            piece[bit / 8] ^= 1 << (bit % 8);
        }
        let times = if self.random.random_ratio(1, TWICE) { 2 } else { 1 };
        for _ in 0..times {
            if let Some(set) = self.consumer.take(at_us, piece) {
                self.outcome.taken += 1;
                match self.sent.judge(at_us, &set) {
                    Taken::Fresh(number, age_us) if number > self.last_taken => {
                        self.last_taken = number;
                        self.outcome.oldest_us = self.outcome.oldest_us.max(age_us);
                    }
                    Taken::Mixed => self.outcome.mixed += 1,
                    Taken::Fresh(..) | Taken::Stale => self.outcome.stale += 1,
                }
            }
            if let Some(set) = self.careless.take(piece) {
                self.outcome.mixed_for_the_careless += u64::from(self.sent.judge(at_us, &set) == Taken::Mixed);
            }
        }
    }
}
