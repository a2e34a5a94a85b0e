//! The whole drive board without hardware, as a board's main loop drives it: `cargo run --release --example device_loop`.
//!
//! A real board reads encoders, button and bus where this one makes them up. Of the frames that it would send, the first of each
//! message is shown, and every heartbeat with another state than the one before.

use glenoid::can::{BaseId, Message};
use glenoid::device::{Action, Config, Device, Event};
use glenoid::record::LoadError;
use glenoid::rig::Rig;

/// Encoders are sampled this often, ms.
const SAMPLE_MS: u32 = 10;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let rig = Rig::<f32>::shoulder(150.0).map_err(|error| error.text())?;
    let mut device = Device::new(&Config::for_rig(rig));
    let mut now_ms = 0;
    let mut shown = Vec::new();
    let mut frames = 0;
    let mut out = |action: Action| match action {
        Action::Send(frame) => {
            frames += 1;
            if let Ok(message) = Message::unpack(&frame, BaseId::DEFAULT) {
                let state = if let Message::Heartbeat(heartbeat) = message { Some(heartbeat.state) } else { None };
                if !shown.contains(&(frame.raw_id(), state)) {
                    shown.push((frame.raw_id(), state));
                    println!("send {message:?}");
                }
            }
        }
        Action::StatusLed(pattern) => println!("LED  {pattern:?}"),
        // a board answers a store with Event::Stored
        other => println!("{other:?}"),
    };
    device.handle(now_ms, Event::PowerUp(Err(LoadError::Nothing).into()), &mut out);
    // Half a second at rest, then a press of one second and a half: the calibration starts.
    for _ in 0..2_500 {
        now_ms += 1;
        if now_ms % SAMPLE_MS == 0 {
            device.handle(now_ms, Event::Counts([0; 6]), &mut out);
        }
        device.handle(now_ms, Event::Button { down: (500..2_000).contains(&now_ms) }, &mut out);
        device.handle(now_ms, Event::Tick, &mut out);
    }
    println!("state after {now_ms} ms and {frames} frames: {:?}", device.procedure().state());
    Ok(())
}
