//! Two clients on one bus. Each forms the checksum of a new centre from the frames that it heard itself, and each may have
//! been away, asks twice, or asks late.

use glenoid::can::identity::{Naming, checksum};
use glenoid::can::{BaseId, Frame, Message, Opcode, Request};
use rand::Rng;

/// Frames that show a value: centre, radii, offsets.
const FRAMES: usize = 12;

/// A new centre as it was shown: what names it, and x, y, z, p1, p2, p3.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shown {
    pub naming: Naming,
    pub value_mm: [f32; 6],
}

/// Puts together what the frames show.
#[derive(Debug, Clone, Copy, Default)]
pub struct Listener {
    frames: [[u8; 8]; FRAMES],
    value_mm: [f32; 6],
    /// The last value whose checksum was that of the frames heard.
    pub shown: Option<Shown>,
}

impl Listener {
    pub fn hear(&mut self, frame: &Frame) {
        let Ok(message) = Message::unpack(frame, BaseId::DEFAULT) else { return };
        let place = match message {
            Message::CandidateCentre(p) => (usize::from(p.index), Some(p.value_mm)),
            Message::CandidateRadius(p) => (usize::from(p.index) + 3, Some(p.value_mm)),
            // cables count from 1
            Message::CandidateZero(z) => (usize::from(z.cable) + 5, None),
            Message::CandidateNaming(naming) => {
                let formed = checksum(naming.boot, naming.wearer, self.frames.iter().copied());
                if formed == naming.checksum {
                    self.shown = Some(Shown { naming, value_mm: self.value_mm });
                }
                return;
            }
            _ => return,
        };
        let (place, value_mm) = place;
        if let Ok(data) = frame.data().try_into() {
            self.frames[place] = data;
        }
        if let Some(value_mm) = value_mm {
            self.value_mm[place] = value_mm;
        }
    }
}

/// One of the clients.
#[derive(Debug, Clone, Copy, Default)]
pub struct Client {
    listener: Listener,
    /// It hears nothing for a while.
    away: bool,
    nonce: u16,
    /// The last accept that it sent, and what it meant by it.
    last: Option<(Frame, Option<Shown>)>,
}

impl Client {
    pub fn hear(&mut self, frame: &Frame) {
        if !self.away {
            self.listener.hear(frame);
        }
    }

    /// Comes or goes by chance.
    pub fn wander(&mut self, random: &mut impl Rng) {
        self.away = random.random_ratio(1, 4);
    }

    /// An accept, and the value that the client means: the one it was shown last, now and then the same frame once more,
    /// now and then something that nobody showed.
    pub fn accept(&mut self, random: &mut impl Rng) -> (Frame, Option<Shown>) {
        match (random.random_range(0..4), self.last) {
            (0, Some(last)) => return last,
            (1, _) => return (request(random.random_range(0..4), &invented(random)), None),
            _ => {}
        }
        self.nonce = self.nonce % 4 + 1;
        let meant = self.listener.shown;
        let naming = meant.map_or_else(|| invented(random), |shown| shown.naming);
        let accept = (request(self.nonce, &naming), meant);
        self.last = Some(accept);
        accept
    }
}

/// Near enough to something real to be dangerous: small runs and boots.
fn invented(random: &mut impl Rng) -> Naming {
    Naming { run_id: random.random_range(0..4), boot: random.random_range(0..4), wearer: 0, checksum: random.random() }
}

fn request(nonce: u16, naming: &Naming) -> Frame {
    Request::naming(Opcode::Accept, nonce, naming).pack(BaseId::DEFAULT.command())
}
