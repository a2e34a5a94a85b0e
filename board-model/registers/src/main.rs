//! The two descriptions of every register that the image touches, held against each other. Exits with 1 for a difference
//! that `differences.txt` does not have, and for a line there that is no difference any more.

use registers::{PERIPHERALS, compare, driver, known, touched, vendor};
use std::io;
use std::process::ExitCode;

fn main() -> ExitCode {
    match compare_all() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("registers: {error}");
            ExitCode::FAILURE
        }
    }
}

/// True when every difference is known, and every line of both lists is used.
fn compare_all() -> io::Result<bool> {
    let folder = vendor::folder()?;
    let mut unused = known::list()?;
    let mut touched = touched::list()?;
    let (mut alike, mut listed, mut unlisted) = (0, 0, 0);
    for peripheral in PERIPHERALS {
        if driver::address(peripheral.name).is_some_and(|address| address != peripheral.from) {
            println!("{}: the driver has it at another address", peripheral.name);
            unlisted += 1;
        }
        let Some(by_driver) = driver::block(peripheral.name) else {
            println!("{}: the driver has no description of it", peripheral.name);
            unlisted += 1;
            continue;
        };
        let mut by_vendor = vendor::block(&folder, peripheral.block)?;
        // what only the driver describes is no register that the image can have touched by the vendor's name
        by_vendor.retain(|_, register| touched.remove(&format!("{}.{}", peripheral.name, register.name)).is_some());
        let (differences, same) = compare::compare(peripheral.name, &by_vendor, &by_driver);
        alike += same;
        for difference in differences {
            let line = difference.to_string();
            if unused.remove(&line).is_some() {
                listed += 1;
            } else {
                println!("{line}");
                unlisted += 1;
            }
        }
    }
    for (name, number) in &touched {
        println!("touched.txt, line {number}: the vendor has no register {name}");
    }
    for (line, number) in &unused {
        println!("differences.txt, line {number}: no difference any more: {line}");
    }
    println!("{alike} fields alike, {listed} differences with a reason, {unlisted} without");
    Ok(unlisted == 0 && unused.is_empty() && touched.is_empty())
}
