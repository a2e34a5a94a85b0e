//! The example of a control loop, ten times a millisecond in an interrupt beside the device: on the model, through a whole
//! calibration and its store. Prints its jitter and latency, in cycles of the model: each instruction takes one there, and the
//! entry of an exception twelve. They settle what holds the loop up, not how long its steps take on the chip.

use board_model::board::Board;
use board_model::image::Image;
use board_model::machine::Longest;
use glenoid::rig::{ASSUMED_BASE_RADIUS_MM, Rig};
use host_tests::firmware;
use host_tests::packages::Consent;
use host_tests::rehearse::{Bench, Display, Session};
use host_tests::wearer::{Wearer, WearerSettings};
use std::rc::Rc;

/// Cycles from step to step: 170 MHz, 10 kHz. The core's timer counts them, on the model as on the chip.
const PERIOD: u32 = 17_000;
/// What may hold a step up: another part that masks the interrupts for a moment, and the exception's entry.
const MOST_JITTER: u32 = 200;

/// What the firmware says of a second: steps, steps with a rotation, shortest and longest interval, longest step.
fn told(line: &str) -> Option<[u32; 5]> {
    let numbers = line.split_once("control: ")?.1.split(|letter: char| !letter.is_ascii_digit());
    let numbers: Vec<u32> = numbers.filter_map(|number| number.parse().ok()).collect();
    numbers.try_into().ok()
}

#[test]
fn a_control_loop_keeps_its_time() {
    let toolchain = firmware::choose_toolchain(Consent::Given).unwrap();
    let log = [("DEFMT_LOG", Some("warn"))];
    let path = firmware::build_with_environment(toolchain, firmware::Image::CONTROL_LOOP, &log).unwrap();
    let image = Rc::new(Image::read(&path).unwrap());
    let mut board = Board::new(Rc::clone(&image), 7);
    board.pass(50).unwrap();
    // the first painting of the stack holds everything up, before anything is measured
    board.machine.state_mut().longest_masked = Longest::default();
    let rig = Rig::shoulder(ASSUMED_BASE_RADIUS_MM).unwrap();
    let mut wearer = Wearer::new(rig, WearerSettings { seed: 3, noise_mm: 0.1, ..WearerSettings::default() });
    let mut session = Session::new(&mut board, &mut wearer, rig.drum().fastest_mm_per_s, &Display::Silent);
    session.calibrate(12, 5, 0).unwrap();
    // with a centre in use the loop has a rotation in every step
    board.pass(2_500).unwrap();
    // the first second is the start's
    let seconds: Vec<[u32; 5]> = board.log.lines.iter().filter_map(|line| told(line)).skip(1).collect();
    assert!(seconds.len() >= 10, "{} seconds, {:?}", seconds.len(), board.last_words());
    let of = |index: usize| seconds.iter().map(move |second| second[index]);
    let (shortest, longest, step) = (of(2).min().unwrap(), of(3).max().unwrap(), of(4).max().unwrap());
    let masked = board.machine.state().longest_masked;
    println!("in cycles of the model, which are instructions:");
    println!("{} seconds with 10 000 steps each: {shortest} to {longest} from step to step,", seconds.len());
    println!(
        "a step takes {step} instructions at most; interrupts masked for {} instructions at most, from {}",
        masked.cycles,
        image.name_of(masked.pc)
    );
    assert!(of(0).all(|steps| steps == 10_000), "{seconds:?}");
    assert_eq!(seconds.last().unwrap()[1], 10_000, "without a rotation in some step");
    assert!(PERIOD - shortest < MOST_JITTER && longest - PERIOD < MOST_JITTER);
    assert!(step < PERIOD / 2);
    assert_eq!(board.complaints(), [""; 0]);
    assert_eq!(board.machine.resets, []);
}
