//! `board-model/run run`: the real image, built and switched on, goes through a calibration over CAN and through one by the
//! button, keeps the centre, and is restarted. Exits with 0 only when all of it was right and the chip had no complaint.

use board_model::arguments;
use board_model::board::Board;
use board_model::by_button::ByButton;
use board_model::image::Image;
use board_model::machine::Longest;
use glenoid::rig::{ASSUMED_BASE_RADIUS_MM, Rig};
use host_tests::command_line;
use host_tests::firmware;
use host_tests::packages::Consent;
use host_tests::rehearse::{self, Display, KnownMachine, Options, Status};
use host_tests::wearer::{Wearer, WearerSettings};
use std::process::ExitCode;
use std::rc::Rc;
use std::time::Instant;
use std::{error, io};

fn main() -> Result<ExitCode, Box<dyn error::Error>> {
    let options = arguments::or_exit(arguments::rehearsal(command_line::arguments()));
    let path = firmware::build(firmware::Image::NUCLEO_G474RE, Consent::Given)?;
    let image = Rc::new(Image::read(&path)?);
    let known = KnownMachine::compiled_in()?;
    let mut wearer = Wearer::new(known.double, options.wearer());
    let mut board = Board::new(image, 1);
    let began = Instant::now();
    let report = rehearse::rehearse(&mut board, &mut wearer, &known, &options, &Display::Lines, None);
    println!("{report}");
    let by_button = press_through(&mut board, &options);
    match &by_button {
        Ok((off_mm, found, kept)) => {
            println!("by the button: {off_mm:.4} mm off the true centre, at {found:.4?}, after a restart {kept:.4?}");
        }
        Err(error) => println!("by the button: {error}"),
    }
    let state = board.machine.state();
    println!("{} instructions since the last power-up in {:.1} s", state.instructions, began.elapsed().as_secs_f64());
    for line in &board.log.lines {
        println!("  log {line}");
    }
    for complaint in board.complaints() {
        println!("breach {complaint}");
    }
    let is_same = by_button.is_ok_and(|(off_mm, found, kept)| found == kept && off_mm <= LIMIT_MM);
    let ok = report.status == Status::Right && is_same && board.breaches().is_empty();
    Ok(if ok { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// A centre further off is wrong, mm: five times what a dozen poses with the usual noise leave.
const LIMIT_MM: f64 = 0.5;

/// How far off, and the centres before and after a restart, mm.
type Pressed = (f64, [f32; 3], [f32; 3]);

/// A second wearer is calibrated by the button alone.
fn press_through(board: &mut Board, options: &Options) -> Result<Pressed, Box<dyn error::Error>> {
    let rig = Rig::shoulder(ASSUMED_BASE_RADIUS_MM).map_err(|error| io::Error::other(error.text()))?;
    let mut wearer = Wearer::new(rig, WearerSettings { seed: options.seed + 1, ..options.wearer() });
    // the first painting of the stack holds everything up, before anything is measured
    board.machine.state_mut().longest_masked = Longest::default();
    let found = ByButton::new(board).calibrate(&mut wearer)?;
    let longest = board.machine.state().longest_masked;
    println!("interrupts masked for {} instructions at most, from {}", longest.cycles, board.image.name_of(longest.pc));
    let truth = wearer.truth().to_array();
    let off = found.iter().zip(truth).map(|(found, truth)| (f64::from(*found) - truth).powi(2)).sum::<f64>().sqrt();
    board.power_cycle();
    board.go_on(50)?;
    let kept = ByButton::new(board).live()?;
    Ok((off, found, kept))
}
