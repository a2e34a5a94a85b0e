//! The two descriptions of every register that the image touches, held against each other. Exits with 1 for a difference
//! that `differences.txt` does not have, and for a line there that is no difference any more.

use registers::{PERIPHERALS, compare, driver, touched, vendor};
use std::collections::BTreeSet;
use std::process::ExitCode;
use std::{fs, io};

/// One difference a line, the reason for which it does not matter behind ` # `.
const KNOWN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/differences.txt");

fn main() -> io::Result<ExitCode> {
    let folder = vendor::folder()?;
    let known = fs::read_to_string(KNOWN)?;
    let mut unused = BTreeSet::new();
    for (number, line) in known.lines().enumerate().filter(|(_, line)| !line.is_empty() && !line.starts_with('#')) {
        match line.split_once(" # ") {
            Some((difference, reason)) if !reason.trim().is_empty() => unused.insert(difference.trim().to_owned()),
            _ => return Err(io::Error::other(format!("differences.txt, line {}: no reason", number + 1))),
        };
    }
    let mut touched = touched::names()?;
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
        by_vendor.retain(|_, register| touched.remove(&format!("{}.{}", peripheral.name, register.name)));
        let (differences, same) = compare::compare(peripheral.name, &by_vendor, &by_driver);
        alike += same;
        for difference in differences {
            let line = difference.to_string();
            if unused.remove(&line) {
                listed += 1;
            } else {
                println!("{line}");
                unlisted += 1;
            }
        }
    }
    for name in &touched {
        println!("touched.txt: the vendor has no register {name}");
    }
    for line in &unused {
        println!("differences.txt: no difference any more: {line}");
    }
    println!("{alike} fields alike, {listed} differences with a reason, {unlisted} without");
    Ok(if unlisted == 0 && unused.is_empty() && touched.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
