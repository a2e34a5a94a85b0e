//! The list of registers that the two descriptions are compared for is complete.

use crate::scene::{calibrate, kept_board};

#[test]
fn the_list_of_touched_registers_is_complete() {
    let mut board = kept_board();
    calibrate(&mut board, 5);
    let listed = registers::touched::names().unwrap();
    let missing: Vec<_> = board.machine.chip().touched.iter().filter(|name| !listed.contains(*name)).collect();
    assert!(missing.is_empty(), "not in registers/touched.txt: {missing:?}");
    let unused: Vec<_> = listed.iter().filter(|name| !board.machine.chip().touched.contains(*name)).collect();
    println!("listed and not touched in this run: {unused:?}");
}
