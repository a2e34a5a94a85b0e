//! `board-model/run run --release --bin power-cut -- 10000`: cuts the power so often in the flash operations of the real image, on
//! all processors of the host.

use board_model::arguments::{self, PowerCuts};
use board_model::board::Board;
use board_model::by_button::ByButton;
use board_model::image::Image;
use board_model::power_cuts::{self, Tally};
use clap::Parser;
use glenoid::rig::{ASSUMED_BASE_RADIUS_MM, Rig};
use host_tests::command_line;
use host_tests::firmware;
use host_tests::packages::Consent;
use host_tests::wearer::{Wearer, WearerSettings};
use std::path::Path;
use std::process::ExitCode;
use std::rc::Rc;
use std::time::Instant;
use std::{error, io, thread};

fn main() -> Result<ExitCode, Box<dyn error::Error>> {
    let PowerCuts { cuts, seed } = arguments::or_exit(PowerCuts::try_parse_from(command_line::arguments()));
    let path = firmware::build(firmware::Image::NUCLEO_G474RE, Consent::Given)?;
    let began = Instant::now();
    let threads = thread::available_parallelism().map_or(1, |count| count.get() as u32);
    let tallies = thread::scope(|scope| {
        let path = path.as_path();
        let start =
            |thread: u32| scope.spawn(move || cut(path, cuts.div_ceil(threads), seed.wrapping_add(thread.into())));
        let started: Vec<_> = (0..threads).map(start).collect();
        started
            .into_iter()
            .map(|thread| thread.join().unwrap_or(Err("a thread panicked".to_owned())))
            .collect::<Vec<_>>()
    });
    let mut failures = 0;
    let mut cuts = 0;
    for tally in tallies {
        let tally = tally?;
        println!("{tally}");
        tally.complaints.iter().for_each(|complaint| println!("breach {complaint}"));
        failures += tally.failures();
        cuts += tally.cuts;
    }
    println!("{cuts} power cuts in {:.0} s, {failures} failures", began.elapsed().as_secs_f64());
    Ok(if failures == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// One thread's share.
fn cut(path: &Path, cuts: u32, seed: u64) -> Result<Tally, String> {
    let fails = |error: &dyn error::Error| error.to_string();
    let image = Rc::new(Image::read(path).map_err(|error| fails(&error))?);
    let rig = Rig::shoulder(ASSUMED_BASE_RADIUS_MM).map_err(|error| fails(&io::Error::other(error.text())))?;
    let mut board = Board::new(Rc::clone(&image), 1);
    board.go_on(50)?;
    ByButton::new(&mut board)
        .calibrate(&mut Wearer::new(rig, WearerSettings::default()))
        .map_err(|error| fails(&error))?;
    board.power_cycle();
    Ok(power_cuts::campaign(&image, &board.machine.chip().flash.cells, cuts, seed))
}
