//! Codes are a contract: unique, in their bands, never renumbered, the same in code, DBC and documentation.

use super::dbc::Database;
use glenoid::procedure::{Band, Guidance, Reason, StateName};
use glenoid::restart::ResetCause;
use std::collections::BTreeMap;

#[test]
fn reasons_in_the_dbc() {
    let expected: BTreeMap<u8, String> = Reason::ALL.iter().map(|r| (r.code(), r.name().to_owned())).collect();
    assert_eq!(expected.len(), Reason::ALL.len(), "a code is used twice");
    let database = Database::load();
    for (id, signal) in [
        (0x681, "code"),
        (0x682, "reason"),
        (0x683, "code"),
        (0x684, "reason"),
        (0x685, "reason"),
        (0x697, "cause"),
        (0x699, "code"),
        (0x69A, "reason"),
    ] {
        assert_eq!(database.values[&(id, signal.to_owned())], expected, "{id:x}.{signal}");
    }
}

/// `docs/reasons.md` has one row a reason: code, name, text, remedy.
#[test]
fn reasons_in_the_documentation() {
    let documented: Vec<Vec<&str>> = include_str!("../../../../docs/reasons.md")
        .lines()
        .filter(|line| line.starts_with("| ") && line.contains(" | `"))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    let expected: Vec<Vec<String>> = Reason::ALL
        .iter()
        .map(|r| vec![r.code().to_string(), format!("`{}`", r.name()), r.text().to_owned(), r.remedy().to_owned()])
        .collect();
    assert_eq!(documented, expected);
}

#[test]
fn reasons_stand_in_their_bands() {
    let mut last = None;
    for reason in Reason::ALL {
        assert_eq!(Reason::from_code(reason.code()), Some(*reason));
        assert!(Some(reason.code()) > last, "{reason:?} is out of order");
        last = Some(reason.code());
        assert_ne!(reason.band(), Band::Unassigned);
        assert!(!reason.text().is_empty() && !reason.remedy().is_empty());
        // one row of a table, one line of a display
        assert!(!reason.text().contains('|') && !reason.remedy().contains('|'));
    }
    assert_eq!(Reason::from_code(200), None);
}

/// The numbers as they were first released. A new reason is added to this list; no line of it ever changes.
#[test]
fn reasons_are_never_renumbered() {
    let released = [
        (0, "Fine"),
        (1, "UnknownOpcode"),
        (2, "WrongLength"),
        (3, "ReservedNotZero"),
        (4, "BadArgument"),
        (5, "WrongState"),
        (6, "AlreadyRunning"),
        (7, "AcknowledgeFirst"),
        (8, "StaleRun"),
        (9, "NoSuchPose"),
        (10, "Busy"),
        (11, "WrongValue"),
        (12, "ReportIncomplete"),
        (13, "TooManyCommands"),
        (14, "Locked"),
        (15, "NumberingUnchecked"),
        (16, "ArmMoving"),
        (17, "PoseTooNear"),
        (18, "PosesFull"),
        (19, "CableLoose"),
        (20, "PlatformDoesNotClose"),
        (21, "LengthImpossible"),
        (32, "EncoderSilent"),
        (33, "EncoderFrozen"),
        (34, "EncoderJumped"),
        (35, "CableNotPulled"),
        (36, "WrongCable"),
        (48, "TooFewPoses"),
        (49, "OneAxis"),
        (50, "Weak"),
        (51, "TooManyOutliers"),
        (52, "NotABall"),
        (53, "PoseDoesNotClose"),
        (54, "NotConverged"),
        (55, "Singular"),
        (56, "NotFinite"),
        (57, "TooAlike"),
        (58, "ZeroNotDetermined"),
        (59, "FewPosesForMovingCentre"),
        (60, "TiltMissing"),
        (61, "SecondPlaneMissing"),
        (62, "TorsionMissing"),
        (63, "BaseSlippedMidway"),
        (64, "CuffSlippedMidway"),
        (65, "JointNotExplained"),
        (66, "BladeNotHeld"),
        (67, "HeldOfAnotherWearing"),
        (68, "MachineNotAsStated"),
        (69, "TwoAxesFit"),
        (70, "SecondAxis"),
        (71, "NotAHinge"),
        (72, "CentreImplausible"),
        (73, "RadiusImplausible"),
        (74, "SigmaImplausible"),
        (75, "OffsetImplausible"),
        (76, "MotionImplausible"),
        (80, "VerificationFailed"),
        (81, "VerificationDoesNotClose"),
        (96, "Accepted"),
        (97, "Rejected"),
        (98, "Aborted"),
        (99, "CollectingTimeout"),
        (100, "VerifyingTimeout"),
        (101, "ReviewTimeout"),
        (112, "ButtonStuck"),
        (113, "ReportOutOfRange"),
        (114, "ReceiveOverrun"),
        (115, "RecordDamaged"),
        (116, "RecordOfOtherRig"),
        (117, "RecordOlder"),
        (118, "RecordNewer"),
        (119, "RecordUnfit"),
        (120, "RecordUnreadable"),
        (121, "StoreRefused"),
        (122, "FlashWorn"),
        (123, "FlashLayout"),
        (124, "BusOff"),
        (125, "Restarted"),
        (126, "ParametersDamaged"),
        (127, "JournalUnwritable"),
        (128, "StrapSlipped"),
        (129, "CuffSlipped"),
        (130, "CableSlipped"),
        (131, "CentreDrifts"),
        (132, "CentreMoved"),
        (133, "Unconfirmed"),
        (144, "UnknownParameter"),
        (145, "UnknownOperation"),
        (146, "ParameterOutOfRange"),
        (147, "ParametersContradict"),
        (148, "WrongKey"),
        (149, "WriteOnly"),
        (150, "NoRecord"),
        (160, "NotOfHinge"),
    ];
    let now: Vec<(u8, &str)> = Reason::ALL.iter().map(|reason| (reason.code(), reason.name())).collect();
    assert_eq!(now, released);
}

/// The causes are held against their list of releases where they are defined.
#[test]
fn reset_causes_in_the_dbc() {
    let expected: BTreeMap<u8, String> = ResetCause::ALL.iter().map(|c| (c.code(), c.name().to_owned())).collect();
    let database = Database::load();
    for (id, signal) in [(0x690, "reset_cause"), (0x693, "reset_cause")] {
        assert_eq!(database.values[&(id, signal.to_owned())], expected, "{id:x}.{signal}");
    }
}

#[test]
fn states_and_guidance_in_the_dbc() {
    let database = Database::load();
    let states: BTreeMap<u8, String> = StateName::ALL.iter().map(|s| (s.code(), format!("{s:?}"))).collect();
    assert_eq!(database.values[&(0x682, "state".to_owned())], states);
    let guidance: BTreeMap<u8, String> = Guidance::ALL.iter().map(|g| (g.code(), format!("{g:?}"))).collect();
    for id in [0x682, 0x684] {
        assert_eq!(database.values[&(id, "guidance".to_owned())], guidance);
    }
}

/// What is made from the table of the parameters is current: `cargo run -p vocabulary` writes it.
#[test]
fn parameters_in_the_dbc_and_in_the_documentation() {
    use host_tests::vocabulary::parameters;
    let dbc = include_str!("../../../../glenoid.dbc");
    assert!(parameters::dbc(dbc) == dbc, "glenoid.dbc is not what `cargo run -p vocabulary` writes");
    let page = include_str!("../../../../docs/parameters.md");
    assert!(parameters::document() == page, "docs/parameters.md is not what `cargo run -p vocabulary` writes");
}
