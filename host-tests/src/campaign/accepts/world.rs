//! The device in the middle of it, and what must hold after every event.

use super::clients::{Client, Listener, Shown};
use glenoid::device::{Action, Device, Event, MAX_FRAMES};
use glenoid::procedure::transition::next;
use glenoid::procedure::{StateName, Trigger};
use glenoid::record::{JournalEntry, LoadError, Loaded, Record, StoreError};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeSet;

/// By what the centre in use may change in the event at hand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Accepting {
    Nothing,
    /// A command of a client that means this value, if any.
    Command(Option<Shown>),
    Press,
}

/// The device, its bus, its flash, and what was chosen.
pub struct World {
    pub device: Device,
    pub random: ChaCha8Rng,
    pub now_ms: u32,
    pub clients: [Client; 2],
    pub accepting: Accepting,
    pub tally: Tally,
    /// A device at power-up, for restarts.
    new: Device,
    /// Where the arm is.
    pub counts: Option<[i32; 6]>,
    /// Hears everything.
    bus: Listener,
    /// The value that was accepted last, or that the record has kept.
    chosen: Option<[f32; 6]>,
    record: Option<Record>,
    journal: Option<JournalEntry>,
    stopped: bool,
}

/// What has happened in a sequence.
#[derive(Debug, Clone, Default)]
pub struct Tally {
    /// Changes of state that were seen.
    pub changes: BTreeSet<(StateName, StateName)>,
    /// Centres put in use by a command, and by the button.
    pub accepted_by_command: u64,
    pub accepted_by_button: u64,
    pub restarts: u64,
    /// Records and entries of the journal that the flash refused.
    pub stores_failed: u64,
}

impl World {
    pub fn new(device: &Device, number: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(number);
        // every fourth sequence sees the clock wrap
        let now_ms = if random.random_ratio(1, 4) { u32::MAX - random.random_range(0..5_000) } else { 0 };
        Self {
            device: device.clone(),
            random,
            now_ms,
            clients: [Client::default(); 2],
            accepting: Accepting::Nothing,
            tally: Tally::default(),
            new: device.clone(),
            counts: None,
            bus: Listener::default(),
            chosen: None,
            record: None,
            journal: None,
            stopped: false,
        }
    }

    pub fn state(&self) -> StateName {
        self.device.procedure().state()
    }

    pub fn event(&mut self, event: Event) {
        let mut next = Some(event);
        while let Some(event) = next {
            next = self.one_event(event);
        }
        if std::mem::take(&mut self.stopped) {
            self.restart();
        }
    }

    /// Handles one event; gives the one that the flash answers with.
    fn one_event(&mut self, event: Event) -> Option<Event> {
        let (before, live) = (self.state(), live_value(&self.device));
        let actions = self.handle(event);
        self.check_state(before, &event);
        self.check_value(before, live, &event);
        actions.iter().fold(None, |answer, action| self.carry_out(action).or(answer))
    }

    /// Lets the bus hear what the device sends; gives what the flash and the supply are asked for.
    fn handle(&mut self, event: Event) -> Vec<Action> {
        let Self { device, now_ms, bus, clients, .. } = self;
        let (mut frames, mut asked) = (0, Vec::new());
        device.handle(*now_ms, event, &mut |action| match action {
            Action::Send(frame) => {
                frames += 1;
                bus.hear(&frame);
                clients.iter_mut().for_each(|client| client.hear(&frame));
            }
            Action::StatusLed(_) | Action::Log(_) => {}
            action => asked.push(action),
        });
        assert!(frames <= MAX_FRAMES, "{frames} frames after {event:?}");
        asked
    }

    fn carry_out(&mut self, action: &Action) -> Option<Event> {
        match action {
            Action::Store(record) => {
                let result = self.flash();
                if result.is_ok() {
                    self.record = record.ball().copied();
                }
                return Some(Event::Stored(result));
            }
            Action::Journal(entry) => match self.flash() {
                Ok(()) => self.journal = Some(*entry),
                Err(error) => return Some(Event::JournalFailed(error)),
            },
            Action::StoreParameters(_) => return Some(Event::ParametersStored(self.flash())),
            Action::EraseRecord => {
                self.record = None;
                return Some(Event::ParametersStored(Ok(())));
            }
            Action::Stop(_) => self.stopped = true,
            Action::Send(_) | Action::StatusLed(_) | Action::Log(_) => {}
        }
        None
    }

    /// The flash refuses one in sixteen.
    fn flash(&mut self) -> Result<(), StoreError> {
        let refused = self.random.random_ratio(1, 16);
        self.tally.stores_failed += u64::from(refused);
        if refused { Err(StoreError::WriteRefused) } else { Ok(()) }
    }

    fn check_state(&mut self, before: StateName, event: &Event) {
        let after = self.state();
        let reachable = |from: StateName| Trigger::ALL.into_iter().filter_map(move |trigger| next(from, trigger));
        // one event may be a press and a slice of work in one
        let legal = before == after
            || reachable(before).any(|to| to == after)
            || reachable(before).flat_map(reachable).any(|to| to == after);
        assert!(legal, "{before:?} to {after:?} by {event:?}");
        if before != after {
            self.tally.changes.insert((before, after));
        }
    }

    /// The centre in use changes by an accept and by nothing else, and it is then the value that was meant.
    fn check_value(&mut self, before: StateName, live: Option<[f32; 6]>, event: &Event) {
        let live_now = live_value(&self.device);
        if live_now == live {
            assert_eq!(live_now, self.chosen, "{event:?}");
            return;
        }
        assert_eq!((before, self.state()), (StateName::Review, StateName::Idle), "{event:?}");
        let value = live_now.expect("a centre in use never vanishes");
        let meant = match self.accepting {
            Accepting::Nothing => panic!("{event:?} put a centre in use"),
            Accepting::Command(meant) => {
                self.tally.accepted_by_command += 1;
                meant
            }
            Accepting::Press => {
                self.tally.accepted_by_button += 1;
                self.bus.shown
            }
        };
        let meant = meant.expect("an accept of what was never shown was obeyed");
        // as it was shown: each field of the bus has its step
        let same = meant.value_mm.iter().zip(&value).all(|(shown, live)| (shown - live).abs() <= 1e-5);
        assert!(same, "{meant:?} was meant, {value:?} is in use");
        self.chosen = live_now;
    }

    /// The board is switched off and on. What is in use afterwards was accepted before.
    pub fn restart(&mut self) {
        self.tally.restarts += 1;
        self.stopped = false;
        self.device = self.new.clone();
        self.chosen = self.record.map(|record| record.parameters.to_array());
        let loaded = Loaded { journal: self.journal, ..self.record.ok_or(LoadError::Nothing).into() };
        let actions = self.handle(Event::PowerUp(loaded));
        assert_eq!(live_value(&self.device), self.chosen, "after a restart");
        if let Some(event) = actions.iter().fold(None, |answer, action| self.carry_out(action).or(answer)) {
            self.event(event);
        }
    }
}

fn live_value(device: &Device) -> Option<[f32; 6]> {
    device.procedure().ball()?.live().map(|live| live.identified.parameters.to_array())
}
