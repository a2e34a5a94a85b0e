//! Three emulated boards on one bus.

use clap::Parser;
use host_tests::rehearse::arm::{ArmReport, EmulatedBus, rehearse_arm};
use host_tests::rehearse::{Display, Options, Status};
use libtest_mimic::Failed;
use std::path::Path;

fn rehearsed(image: &Path, arguments: &str) -> Result<ArmReport, Failed> {
    let options = Options::try_parse_from(format!("rehearse --arm {arguments}").split_whitespace())?;
    let mut bus = EmulatedBus::new(image.to_owned());
    let report = rehearse_arm(&mut bus, &options, &Display::Silent);
    if report.status == Status::Failed && options.arm_fault.is_none() {
        return Err(format!("{report}; {:?}", bus.logs()).into());
    }
    Ok(report)
}

/// A shoulder, an elbow and a wrist, one after the other, each restarted; then the hand through all three. As few poses as
/// each module takes.
pub fn an_arm_is_calibrated_on_three_boards(image: &Path) -> Result<(), Failed> {
    let report = rehearsed(image, "--poses 8 --seed 2")?;
    assert_eq!(report.status, Status::Right, "{report}");
    let elbow = report.elbow.as_ref().ok_or("no elbow")?;
    assert!(elbow.host_agrees && elbow.survives_restart, "{report}");
    for ball in &report.balls {
        let found = ball.rehearsal.found.as_ref().ok_or("no centre")?;
        assert_eq!(found.host.difference_mm, 0.0, "{report}");
        assert_eq!(found.centre_mm, found.centre_after_restart_mm, "{report}");
    }
    assert_eq!((report.balls.len(), report.hand.len()), (2, 3));
    Ok(())
}

/// A spare board answers where the wrist's does.
pub fn two_boards_at_one_place_are_named_on_the_bus(image: &Path) -> Result<(), Failed> {
    let report = rehearsed(image, "--arm-fault twice")?;
    let [reason] = &report.reasons[..] else { return Err(report.to_string().into()) };
    assert!(reason.starts_with("more than one board at 0x740"), "{reason}");
    assert!(reason.contains("serial numbers 103 and 999"), "{reason}");
    Ok(())
}
