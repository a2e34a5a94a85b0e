//! `cargo board-model`: the real image, built and switched on, goes through a calibration over CAN and through one by the
//! button, keeps the centre, and is restarted. Exits with 0 only when all of it was right and the chip had no complaint.

use board_model::board::Board;
use board_model::image::Image;
use clap::Parser;
use glenoid::rig::{ASSUMED_BASE_RADIUS_MM, Rig};
use host_tests::firmware;
use host_tests::packages::Consent;
use host_tests::rehearse::{self, Display, Options, Status};
use host_tests::wearer::Wearer;
use std::process::ExitCode;
use std::rc::Rc;
use std::time::Instant;
use std::{error, io};

fn main() -> Result<ExitCode, Box<dyn error::Error>> {
    let path = firmware::build(firmware::Image::NUCLEO_G474RE, Consent::Given)?;
    let image = Rc::new(Image::read(&path)?);
    let rig = Rig::shoulder(ASSUMED_BASE_RADIUS_MM).map_err(|error| io::Error::other(error.text()))?;
    let options = Options::parse();
    let mut wearer = Wearer::new(rig, options.wearer());
    let mut board = Board::new(image, 1);
    let began = Instant::now();
    let report = rehearse::rehearse(&mut board, &mut wearer, &rig, &options, &Display::Lines, None);
    println!("{report}");
    let state = board.machine.state();
    println!("{} instructions since the last power-up in {:.1} s", state.instructions, began.elapsed().as_secs_f64());
    for line in &board.log.lines {
        println!("  log {line}");
    }
    for complaint in board.complaints() {
        println!("breach {complaint}");
    }
    let ok = report.status == Status::Right && board.breaches().is_empty();
    Ok(if ok { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
