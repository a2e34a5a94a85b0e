//! A controller's side of the bus: takes the centre in use from `LiveSet`, and rejects stale, repeated, lost and mixed
//! frames.
//!
//! It reads what `candump -l` or `python -m glenoid record run.log` writes from its input, and says whenever a controller
//! would go by another centre than before. Try it: `cargo run --example live_consumer < run.log`.

use glenoid::can::live_set::{LIVE_SET_ID, LIVE_SET_LEN};
use glenoid::can::set::{Received, Receiver};
use glenoid::can::{BaseId, LiveSet, Standing};
use std::io::BufRead;

/// After so long without a good set the centre is not used any more, ms: five periods.
const STALE_MS: u64 = 500;
/// Offset of the identifier of `LiveSet` from the base.
const LIVE_SET: u16 = 26;

struct Consumer {
    receiver: Receiver<LIVE_SET_LEN>,
    /// The last good set, and when it was complete.
    live: Option<(LiveSet, u64)>,
}

impl Consumer {
    fn take(&mut self, now_ms: u64, piece: [u8; 8]) {
        match self.receiver.take(piece) {
            // incomplete: what was good stays, until it is stale
            Received::Nothing => {}
            Received::Repeated => println!("{now_ms}: repeated or older, ignored"),
            Received::Refused(error) => println!("{now_ms}: refused, {error:?}"),
            Received::Set { data, ahead } => {
                if let Some(lost) = ahead.map(|ahead| ahead - 1).filter(|lost| *lost != 0) {
                    println!("{now_ms}: {lost} sets lost");
                }
                self.live = LiveSet::unpack(&data).map(|live| (live, now_ms));
            }
        }
    }

    /// The centre that may be used now, mm; None: stop, or hold.
    fn centre(&mut self, now_ms: u64) -> Option<[f32; 3]> {
        let (live, at_ms) = self.live?;
        if now_ms.saturating_sub(at_ms) > STALE_MS {
            // the sender may have started anew, and counts from elsewhere then
            self.receiver.restart();
            self.live = None;
            return None;
        }
        let [x, y, z, ..] = live.parameters;
        (live.standing == Standing::Confirmed).then_some([x.value_mm, y.value_mm, z.value_mm])
    }
}

/// Time (ms), identifier and data of a line `(seconds) can0 identifier#data`.
fn frame(line: &str) -> Option<(u64, &str, &str)> {
    let (seconds, rest) = line.strip_prefix('(')?.split_once(')')?;
    let (id, data) = rest.split_whitespace().nth(1)?.split_once('#')?;
    Some(((seconds.parse::<f64>().ok()? * 1e3) as u64, id, data))
}

fn main() {
    let mut consumer = Consumer { receiver: Receiver::new(LIVE_SET_ID), live: None };
    let id = format!("{:03X}", BaseId::DEFAULT.raw() + LIVE_SET);
    let mut said = None;
    for line in std::io::stdin().lock().lines().map_while(Result::ok) {
        let Some((now_ms, of, data)) = frame(&line) else { continue };
        if let Ok(piece) = u64::from_str_radix(data, 16).map(u64::to_be_bytes)
            && of == id
        {
            consumer.take(now_ms, piece);
        }
        let centre = consumer.centre(now_ms);
        if said.replace(centre) != Some(centre) {
            println!("{now_ms}: {}", centre.map_or("no centre".to_owned(), |mm| format!("centre {mm:?}")));
        }
    }
}
