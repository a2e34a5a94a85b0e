//! Three emulated boards on one bus.

use clap::Parser;
use glenoid::can::{BaseId, Message, Opcode, Request};
use host_tests::rehearse::arm::{ArmReport, Bus, EmulatedBus, rehearse_arm};
use host_tests::rehearse::{Display, Options, Status};
use libtest_mimic::Failed;
use std::path::Path;

fn rehearsed(bus: &mut EmulatedBus, arguments: &str) -> Result<ArmReport, Failed> {
    let options = Options::try_parse_from(format!("rehearse --arm {arguments}").split_whitespace())?;
    let report = rehearse_arm(bus, &options, &Display::Silent);
    if report.status == Status::Failed && options.arm_fault.is_none() {
        return Err(format!("{report}; {:?}", bus.logs()).into());
    }
    Ok(report)
}

/// A shoulder, an elbow and a wrist, one after the other, each restarted; then the hand through all three. As few poses as
/// each module takes.
pub fn an_arm_is_calibrated_on_three_boards(image: &Path) -> Result<(), Failed> {
    let mut bus = EmulatedBus::new(image.to_owned());
    let report = rehearsed(&mut bus, "--poses 8 --seed 2")?;
    assert_eq!(report.status, Status::Right, "{report}");
    let elbow = report.elbow.as_ref().ok_or("no elbow")?;
    assert!(elbow.host_agrees && elbow.survives_restart, "{report}");
    for ball in &report.balls {
        let found = ball.rehearsal.found.as_ref().ok_or("no centre")?;
        assert_eq!(found.host.difference_mm, 0.0, "{report}");
        assert_eq!(found.centre_mm, found.centre_after_restart_mm, "{report}");
    }
    assert_eq!((report.balls.len(), report.hand.len()), (2, 3));
    let foreign = foreign(&mut bus)?;
    // The elbow's board was started anew after its calibration; since then the wrist's has sent all that it had to say.
    assert!(foreign > 1_000, "the elbow's board has got {foreign} frames of the others");
    Ok(())
}

/// Frames of others that the elbow's board has counted since it was started.
fn foreign(bus: &mut EmulatedBus) -> Result<u32, Failed> {
    let base = BaseId::new(0x700).ok_or("no base")?;
    let query = Request { opcode: Opcode::Query as u8, boot: 0, nonce: 60_001, run_id: 0, argument: 0 };
    bus.send(&query.pack(base.command()))?;
    for _ in 0..1_000 {
        for frame in bus.pass(10)? {
            if let Ok(Message::Counters(counters)) = Message::unpack(&frame, base) {
                return Ok(counters.foreign);
            }
        }
    }
    Err("no counters".into())
}

/// A spare board answers where the wrist's does.
pub fn two_boards_at_one_place_are_named_on_the_bus(image: &Path) -> Result<(), Failed> {
    let report = rehearsed(&mut EmulatedBus::new(image.to_owned()), "--arm-fault twice")?;
    let [reason] = &report.reasons[..] else { return Err(report.to_string().into()) };
    assert!(reason.starts_with("more than one board at 0x740"), "{reason}");
    assert!(reason.contains("serial numbers 103 and 999"), "{reason}");
    Ok(())
}
