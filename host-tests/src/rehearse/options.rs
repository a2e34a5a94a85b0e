//! The command line of `cargo rehearse`.

use crate::wearer::WearerSettings;
use clap::{Parser, ValueEnum};
use glenoid::can::command::ZERO_PRIOR_STEP_MM;
use std::path::PathBuf;

/// Rehearse a calibration: a virtual wearer, the real firmware in an emulator, CAN in between.
///
/// Builds the firmware, boots it in QEMU, moves a virtual arm from pose to pose over the rig link, drives the
/// calibration over CAN (SLCAN over TCP), and prints the identified joint centre beside the true one. Writes plots under
/// target/rehearse/. Exits 0 only when the centre is right.
#[derive(Debug, Clone, PartialEq, Parser)]
#[command(name = "cargo rehearse", bin_name = "cargo rehearse", version)]
pub struct Options {
    /// Install what is missing (emulator, compiler target) without asking.
    #[arg(long)]
    pub yes: bool,

    /// Seed of the wearer's joint centre, of the poses and of the noise.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,

    /// Poses to identify with. A third as many more (3 to 30) verify the centre.
    #[arg(long, value_name = "M", default_value_t = 30, value_parser = clap::value_parser!(u8).range(3..=120))]
    pub poses: u8,

    /// Every cable length is wrong by up to this much, uniformly, mm (the paper's noise by default).
    #[arg(long, value_name = "MM", default_value_t = 0.1, allow_negative_numbers = true, value_parser = length)]
    pub noise: f64,

    /// Poses tilt the arm by up to this angle, degrees.
    #[arg(long, value_name = "DEG", default_value_t = 45.0, allow_negative_numbers = true, value_parser = tilt)]
    pub tilt: f64,

    /// Every cable's home length is wrong by up to this much, uniformly, the same in all poses, mm. The board is told
    /// that the zeros are known to no better than that, and finds them.
    #[arg(long, value_name = "MM", default_value_t = 0.0, allow_negative_numbers = true, value_parser = length)]
    pub zero_error: f64,

    /// The machine is not as drawn: each coordinate of an attachment point and each edge is off by this much, 1σ, mm, and
    /// encoders and drums by their stated tolerances. The board is told that much as tolerance, unless --rig states one.
    #[arg(long, value_name = "MM", allow_negative_numbers = true, value_parser = rig_error)]
    pub rig_error: Option<f64>,

    /// The cables run over swivelling guide pulleys of this radius, mm, and the board is told of them.
    #[arg(long, value_name = "MM", allow_negative_numbers = true, value_parser = pulley)]
    pub pulley: Option<f64>,

    /// The board becomes the machine of this file, by parameters over CAN.
    #[arg(long, value_name = "RIG.toml")]
    pub rig: Option<PathBuf>,

    /// After the acceptance something slips by this much, mm: the strap, in a random direction, or the cable of
    /// --cable. The board must say what.
    #[arg(long, value_name = "MM", value_parser = slip)]
    pub slip: Option<f64>,

    /// The arm exercises for so long before that, seconds.
    #[arg(long, value_name = "SECONDS", default_value_t = 3.0, requires = "slip", value_parser = seconds)]
    pub at: f64,

    /// The cable that slips, 1 to 6; without it the strap does.
    #[arg(long, value_name = "N", requires = "slip", value_parser = clap::value_parser!(u8).range(1..=6))]
    pub cable: Option<u8>,

    /// The wearer's joint centre moves with the arm, as that of the person with this number does (regressions of de Groot
    /// and Brand 2001). Prints how far off the path is that the board has found.
    #[arg(long, value_name = "PERSON", conflicts_with = "zero_error", value_parser = person)]
    pub shoulder: Option<u64>,

    /// How much of the shoulder blade's motion the base makes: 0 worn on the thorax, 1 on the shoulder blade.
    #[arg(long, value_name = "F", default_value_t = 0.0, requires = "shoulder", value_parser = share)]
    pub follow: f64,

    /// First some poses with the shoulder blade held, then free ones.
    #[arg(long, requires = "shoulder")]
    pub two_phase: bool,

    /// The arm moves slowly and freely, and the board captures its poses on the way. All of it must be done within a minute.
    #[arg(long, requires = "shoulder")]
    pub free_motion: bool,
    /// With --free-motion: the head slides in its socket to and fro in 3 to 7 seconds, not in one
    #[arg(long, requires = "free_motion")]
    pub slow_slides: bool,

    /// A whole arm: a shoulder's, an elbow's and a wrist's board on one bus, calibrated from the thorax outwards; then the hand's
    /// place through all three.
    #[arg(long, conflicts_with_all = ["zero_error", "rig_error", "pulley", "rig", "slip", "shoulder"])]
    pub arm: bool,

    /// What is wrong with that arm or its bus.
    #[arg(long, value_name = "WHAT", requires = "arm", value_enum)]
    pub arm_fault: Option<ArmFault>,

    /// The three machines are not as drawn: each is off by the tolerances of one that is built by hand (.5 mm, .5 mm, .3 mm, .1 %,
    /// 1σ). Their boards are told those.
    #[arg(long, requires = "arm")]
    pub machine_tolerance: bool,

    /// Print one JSON object on stdout and nothing else there.
    #[arg(long)]
    pub json: bool,
}

/// What can be wrong with an arm or its bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ArmFault {
    /// The wrist's board is not plugged in.
    Missing,
    /// A spare board has the wrist's identifiers as well.
    Twice,
    /// Elbow and wrist have each other's rig.
    Swapped,
    /// The elbow never bends.
    Straight,
}

impl Options {
    /// How well the encoder zeros are known, as set on the board, 1σ, in steps of its command: generous for errors
    /// that are uniform within the limit.
    pub fn zero_prior_steps(&self) -> u16 {
        // The cast saturates at 64 mm.
        (self.zero_error / f64::from(ZERO_PRIOR_STEP_MM)).ceil() as u16
    }

    /// The same in mm.
    pub fn zero_prior_mm(&self) -> f64 {
        f64::from(self.zero_prior_steps()) * f64::from(ZERO_PRIOR_STEP_MM)
    }

    /// The wearer that these options ask for.
    pub fn wearer(&self) -> WearerSettings {
        WearerSettings {
            seed: self.seed,
            tilt_rad: self.tilt.to_radians(),
            noise_mm: self.noise,
            zero_error_mm: self.zero_error,
            slow_slides: self.slow_slides,
            ..WearerSettings::default()
        }
    }

    /// Poses of the second set, which verify the centre and never identify it.
    pub fn verification_poses(&self) -> u8 {
        self.poses.div_ceil(3).clamp(3, 30)
    }
}

/// A length in mm that a cable could be wrong by.
fn length(text: &str) -> Result<f64, String> {
    number(text, 0.0, 100.0, "mm")
}

/// An error that leaves the machine recognisable, mm.
fn rig_error(text: &str) -> Result<f64, String> {
    number(text, 0.01, 5.0, "mm")
}

/// A guide pulley that a cable of the shoulder can run over, mm.
fn pulley(text: &str) -> Result<f64, String> {
    number(text, 0.5, 50.0, "mm")
}

/// A slip in mm that is one.
fn slip(text: &str) -> Result<f64, String> {
    number(text, 0.1, 20.0, "mm")
}

fn seconds(text: &str) -> Result<f64, String> {
    number(text, 0.5, 3600.0, "seconds")
}

fn share(text: &str) -> Result<f64, String> {
    number(text, 0.0, 1.0, "of the motion")
}

fn person(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| "a person is a whole number, as 3: every number is another one".into())
}

/// A tilt in degrees that the cables could follow.
fn tilt(text: &str) -> Result<f64, String> {
    number(text, 0.0, 75.0, "degrees")
}

fn number(text: &str, least: f64, most: f64, unit: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "not a number".to_string())?;
    if (least..=most).contains(&value) { Ok(value) } else { Err(format!("not within {least} to {most} {unit}")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(arguments: &[&str]) -> Result<Options, clap::Error> {
        Options::try_parse_from([&["rehearse"], arguments].concat())
    }

    #[test]
    fn the_flags_reach_the_wearer() {
        let all =
            ["--yes", "--seed", "9", "--poses", "12", "--noise", "0.2", "--tilt", "36", "--zero-error", "1", "--json"];
        let options = parse(&all).unwrap();
        assert!(options.yes && options.json);
        let wearer = options.wearer();
        assert_eq!((wearer.seed, wearer.noise_mm, wearer.zero_error_mm), (9, 0.2, 1.0));
        assert!((wearer.tilt_rad - std::f64::consts::PI / 5.0).abs() < 1e-12);
        assert_eq!((options.poses, options.verification_poses()), (12, 4));
        assert_eq!(options.zero_prior_steps(), 1024);
        assert_eq!(parse(&["--poses", "4"]).unwrap().verification_poses(), 3);
    }

    #[test]
    fn time_and_cable_of_a_slip_need_one() {
        let options = parse(&["--slip", "2", "--at", "1.5", "--cable", "6"]).unwrap();
        assert_eq!((options.slip, options.at, options.cable), (Some(2.0), 1.5, Some(6)));
        assert_eq!(parse(&["--slip", "3"]).unwrap().cable, None);
        for bad in [&["--cable", "1"][..], &["--at", "4"], &["--slip", "2", "--cable", "7"]] {
            assert!(parse(bad).is_err(), "{bad:?}");
        }
    }

    #[test]
    fn impossible_values_are_refused_by_name() {
        for bad in [
            ["--poses", "2"],
            ["--noise", "-1"],
            ["--noise", "nan"],
            ["--tilt", "90"],
            ["--slip", "0"],
            ["--rig-error", "0"],
            ["--rig-error", "1000"],
            ["--pulley", "-5"],
            ["--seed", "x"],
            ["--shoulder", "Anna"],
        ] {
            let message = parse(&bad).unwrap_err().to_string();
            assert!(message.contains(bad[0]), "{message}");
        }
        let nobody = parse(&["--shoulder", "2.5"]).unwrap_err().to_string();
        assert!(nobody.contains("a person is a whole number"), "{nobody}");
    }
}
