//! From six cable lengths a pose to the joint centre: `cargo run --release --example identify`.

use glenoid::identification::{Estimator, EstimatorSettings, Machine, Pose};
use glenoid::kinematics::CableLengths;
use glenoid::rig::Rig;

/// L1 to L6 in twelve poses, mm. They were made from a centre at (6, -4, 152) mm with noise of ±0.1 mm.
const LENGTHS_MM: [[f64; 6]; 12] = [
    [279.65, 281.72, 319.81, 280.82, 286.53, 236.81],
    [227.43, 310.50, 308.36, 316.64, 243.78, 265.92],
    [248.38, 241.02, 311.79, 312.36, 307.53, 235.83],
    [306.98, 324.62, 253.53, 253.53, 224.67, 290.94],
    [236.60, 235.77, 305.09, 318.46, 309.10, 239.55],
    [268.39, 230.61, 247.05, 268.56, 321.66, 307.66],
    [279.49, 254.36, 283.13, 275.93, 309.12, 281.33],
    [303.92, 306.85, 285.06, 247.07, 259.34, 269.97],
    [243.54, 319.47, 327.07, 291.38, 222.12, 229.96],
    [336.03, 294.29, 277.82, 186.66, 272.78, 274.67],
    [287.81, 297.13, 257.43, 270.62, 268.77, 300.30],
    [210.14, 226.97, 289.24, 328.98, 313.18, 246.94],
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let rig = Rig::shoulder(150.0).map_err(|error| error.text())?;
    let machine = Machine::new(&rig);
    let mut poses = Vec::new();
    for lengths_mm in LENGTHS_MM {
        poses.push(Pose::new(CableLengths::new(lengths_mm).map_err(|error| error.fault.text())?));
    }
    let mut estimator = Estimator::new(&machine, rig.nominal(), EstimatorSettings::for_rig(&rig));
    match estimator.run(&machine, &mut poses) {
        Ok(found) => {
            let sigma_mm = found.sigma_mm();
            for (axis, (value, sigma)) in found.parameters.centre_mm.iter().zip(sigma_mm).enumerate() {
                println!("{} = {value:8.3} mm ± {sigma:.3}", ["x", "y", "z"][axis]);
            }
            Ok(())
        }
        Err(refusal) => Err(refusal.text().into()),
    }
}
