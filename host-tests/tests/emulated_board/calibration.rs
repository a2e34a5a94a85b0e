//! A whole calibration on the board.

use std::path::Path;

use clap::Parser;
use firmware_image::elf::Elf;
use firmware_image::stack_bound::StackUse;
use glenoid::rig::{ASSUMED_BASE_RADIUS_MM, Rig};
use host_tests::rehearse::{Display, EmulatedBoard, KnownMachine, Options, Session, Status, rehearse};
use host_tests::wearer::{Wearer, WearerSettings};
use libtest_mimic::Failed;

use crate::{PATIENCE, boot};

/// A whole calibration over both lines, then the stack that it took, which the board measures by itself.
pub fn a_calibration_finds_the_centre(image: &Path) -> Result<(), Failed> {
    let rig = Rig::shoulder(ASSUMED_BASE_RADIUS_MM).map_err(|error| error.text())?;
    // without noise and with the cables' counts alone, seven poses fix the centre to a few hundredths of a millimetre
    let mut wearer = Wearer::new(rig, WearerSettings { seed: 3, ..WearerSettings::default() });
    let truth = wearer.truth();
    let mut board = EmulatedBoard::connect(boot(image)?)?;
    let mut session = Session::new(&mut board, &mut wearer, rig.drum().fastest_mm_per_s, &Display::Silent);
    let found = session.calibrate(7, 3, 0)?;
    for (axis, live_mm) in found.live_centre_mm.into_iter().enumerate() {
        assert!((f64::from(live_mm) - truth.centre_mm[axis]).abs() < 0.1, "{:?}, {truth:?}", found.live_centre_mm);
    }
    let line = board.wait_for_log("stack: ", PATIENCE)?;
    let numbers: Vec<u32> = line.split(' ').filter_map(|word| word.parse().ok()).collect();
    let [.., used, size] = numbers[..] else { return Err(line.into()) };
    // the solver alone needs more than the one, and an overflow would have ended the board at the other
    assert!(1_000 < used && used < size, "{line}");
    // what was read off the instructions must not be less than what is seen
    let foretold = StackUse::of(&Elf::read(image)?)?.most_bytes();
    assert!(u64::from(used) < foretold, "{line}, at most {foretold} foretold");
    Ok(())
}

/// Encoders off by up to 2 mm, of which the board is told; then, with the record after a restart, a cable slips.
pub fn zeros_are_found_and_a_slip_is_named(image: &Path) -> Result<(), Failed> {
    let known = KnownMachine::compiled_in()?;
    let arguments = "rehearse --poses 15 --zero-error 2 --slip 2 --cable 5 --at 1";
    let options = Options::try_parse_from(arguments.split(' '))?;
    let mut wearer = Wearer::new(known.double, options.wearer());
    let mut board = EmulatedBoard::connect(boot(image)?)?;
    let report = rehearse(&mut board, &mut wearer, &known, &options, &Display::Silent, None);
    assert_eq!(report.status, Status::Right, "{report}");
    Ok(())
}

/// The same image on a machine with guide pulleys that is not as drawn: the board is told of both over CAN.
pub fn a_machine_that_is_not_as_drawn_is_calibrated(image: &Path) -> Result<(), Failed> {
    let options = Options::try_parse_from("rehearse --poses 15 --rig-error 0.5 --pulley 5 --seed 2".split(' '))?;
    let known = KnownMachine::of(&options)?;
    let mut wearer = Wearer::new(known.as_built(options.rig_error, options.seed)?, options.wearer());
    let mut board = EmulatedBoard::connect(boot(image)?)?;
    let report = rehearse(&mut board, &mut wearer, &known, &options, &Display::Silent, None);
    assert_eq!(report.status, Status::Right, "{report}");
    Ok(())
}
