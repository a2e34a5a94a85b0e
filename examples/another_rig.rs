//! Another machine is another value: `cargo run --release --example another_rig`.

use glenoid::kinematics::{CableLengths, ForwardKinematics};
use glenoid::rig::{Drum, Parameters, Rig};
use nalgebra::Vector3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A base that is neither regular nor level, mm; what is measured on the machine goes here.
    let base_mm = [Vector3::new(180.0, 5.0, 0.0), Vector3::new(-85.0, 150.0, 10.0), Vector3::new(-90.0, -160.0, -5.0)];
    let edges_mm = [190.0, 175.0, 182.0];
    let drum = Drum { radius_mm: 12.5, counts_per_turn: 8192.0, home_length_mm: [285.0; 6], fastest_mm_per_s: 900.0 };
    let nominal = Parameters { centre_mm: Vector3::new(0.0, 0.0, 150.0), radii_mm: [145.0; 3] };
    let rig = Rig::new(base_mm, edges_mm, drum, 0.05, nominal).map_err(|error| error.text())?;

    let lengths = CableLengths::new([285.0, 281.0, 290.0, 287.0, 283.0, 288.0]).map_err(|error| error.fault.text())?;
    match ForwardKinematics::new(&rig).solve(&lengths) {
        Ok(pose) => println!("platform origin {:.2?} mm in the base's frame", pose.origin_mm.as_slice()),
        Err(error) => println!("no pose: {error:?}"),
    }

    // What cannot be is refused, and the constant named.
    let flat = Rig::new(base_mm, [190.0, 175.0, 400.0], drum, 0.05, nominal);
    println!("edges of 190, 175 and 400 mm: {}", flat.err().map_or("accepted", |error| error.text()));
    Ok(())
}
