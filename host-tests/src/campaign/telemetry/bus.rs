//! A classic CAN bus at 500 kbit/s with three senders: the device, a client, and a crowd of others.

use glenoid::can::Frame;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use std::collections::VecDeque;

/// A frame of eight bytes at its longest: 111 bits and 24 stuffed ones (ISO 11898-1), 2 µs each.
const FRAME_US: u64 = 135 * 2;
/// Frames that the device's queue and its controller hold (`boards/nucleo_g474re/can.rs`).
const DEVICE_QUEUE: usize = 63 + 3;
/// Mean time between two frames of the crowd, µs: 2 000 a second.
const CROWD_GAP_US: f64 = 500.0;

/// A frame that the bus has carried.
#[derive(Debug, Clone, Copy)]
pub enum Carried {
    /// From the device.
    Device(Frame),
    /// From the client.
    Client(Frame),
    /// From somebody else.
    Foreign,
}

/// The bus.
#[derive(Debug)]
pub struct Bus {
    /// When it is free again, µs.
    free_at_us: u64,
    device: VecDeque<Frame>,
    client: VecDeque<Frame>,
    /// Identifiers of the crowd's frames that wait, and when the next one comes.
    crowd: Vec<u16>,
    next_of_crowd_us: u64,
    /// Frames of the device that found no room.
    pub dropped: u16,
    /// Time that it was busy, µs.
    pub busy_us: u64,
}

impl Bus {
    /// A silent bus.
    pub const fn new() -> Self {
        Self {
            free_at_us: 0,
            device: VecDeque::new(),
            client: VecDeque::new(),
            crowd: Vec::new(),
            next_of_crowd_us: 0,
            dropped: 0,
            busy_us: 0,
        }
    }

    /// The device hands a frame to its controller.
    pub fn send_by_device(&mut self, frame: Frame) {
        if self.device.len() < DEVICE_QUEUE {
            self.device.push_back(frame);
        } else {
            self.dropped = self.dropped.saturating_add(1);
        }
    }

    /// The client hands a frame to its controller.
    pub fn send_by_client(&mut self, frame: Frame) {
        self.client.push_back(frame);
    }

    /// The device starts anew: what it had to send is gone.
    pub fn forget_device(&mut self) {
        self.device.clear();
    }

    /// The next frame that is through before `until_us`, and when it is. Whoever has the lowest identifier goes first.
    pub fn next(&mut self, until_us: u64, random: &mut ChaCha8Rng) -> Option<(u64, Carried)> {
        loop {
            self.gather_crowd(random);
            let begins_us = self.free_at_us;
            if begins_us >= until_us {
                return None;
            }
            if let Some(carried) = self.arbitrate() {
                self.free_at_us = begins_us + FRAME_US;
                self.busy_us += FRAME_US;
                return Some((self.free_at_us, carried));
            }
            self.free_at_us = self.next_of_crowd_us.min(until_us);
        }
    }

    /// Frames of the crowd that have come up to now.
    fn gather_crowd(&mut self, random: &mut ChaCha8Rng) {
        while self.next_of_crowd_us <= self.free_at_us {
            // more and less urgent ones than those of the device
            self.crowd.push(random.random_range(0x100..0x7FF));
            // as if independent senders had sent them: exponential gaps
            let gap_us = -libm::log(1.0 - random.random::<f64>()) * CROWD_GAP_US;
            self.next_of_crowd_us += gap_us as u64 + 1;
        }
    }

    fn arbitrate(&mut self) -> Option<Carried> {
        let urgency = |queue: &VecDeque<Frame>| queue.front().map_or(u16::MAX, Frame::raw_id);
        let (device, client) = (urgency(&self.device), urgency(&self.client));
        let crowd = self.crowd.iter().enumerate().min_by_key(|(_, id)| **id).map(|(place, id)| (place, *id));
        match crowd {
            Some((place, id)) if id < device.min(client) => {
                self.crowd.swap_remove(place);
                Some(Carried::Foreign)
            }
            _ if client < device => self.client.pop_front().map(Carried::Client),
            _ => self.device.pop_front().map(Carried::Device),
        }
    }
}
