//! `board-model/run run --bin power-cut -- 10000`: cuts the power so often in the flash operations of the real image.

use board_model::board::Board;
use board_model::by_button::ByButton;
use board_model::image::Image;
use board_model::power_cuts;
use glenoid::rig::{ASSUMED_BASE_RADIUS_MM, Rig};
use host_tests::firmware;
use host_tests::packages::Consent;
use host_tests::wearer::{Wearer, WearerSettings};
use std::process::ExitCode;
use std::rc::Rc;
use std::{env, error, io};

fn main() -> Result<ExitCode, Box<dyn error::Error>> {
    let cuts = env::args().nth(1).map_or(Ok(1_000), |number| number.parse())?;
    let image = Rc::new(Image::read(&firmware::build(firmware::Image::NUCLEO_G474RE, Consent::Given)?)?);
    let rig = Rig::shoulder(ASSUMED_BASE_RADIUS_MM).map_err(|error| io::Error::other(error.text()))?;
    let mut board = Board::new(Rc::clone(&image), 1);
    board.go_on(50)?;
    ByButton::new(&mut board).calibrate(&mut Wearer::new(rig, WearerSettings::default()))?;
    board.power_cycle();
    let tally = power_cuts::campaign(&image, &board.machine.chip().flash.cells, cuts, 1);
    let power_cuts::Tally { cuts, lost, wrong, stuck, complaints } = &tally;
    println!("{cuts} power cuts: {lost} lost, {wrong} wrong, {stuck} not at rest afterwards");
    complaints.iter().for_each(|complaint| println!("breach {complaint}"));
    let ok = lost + wrong + stuck == 0 && complaints.is_empty();
    Ok(if ok { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
