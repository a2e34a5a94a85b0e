//! The rehearsal on machines that are not as drawn, against the device in this process: what the board is told goes over
//! CAN as on the emulated board.

use clap::Parser;
use glenoid::device::Config;
use glenoid::parameters::ParameterSet;
use glenoid::restart::Restart;
use glenoid::rig::Rig;
use host_tests::rehearse::{Display, InProcess, KnownMachine, Options, Report, Status, rehearse};
use host_tests::wearer::Wearer;
use std::path::{Path, PathBuf};

/// What is compiled in.
fn config() -> Config {
    ParameterSet::new().config(Restart::default(), 0).unwrap()
}

fn run(arguments: &str) -> Report {
    let options = Options::try_parse_from(["rehearse"].into_iter().chain(arguments.split_whitespace())).unwrap();
    let known = KnownMachine::of(&options).unwrap_or_else(|reason| panic!("{reason}"));
    let mut wearer = Wearer::new(known.as_built(options.rig_error, options.seed).unwrap(), options.wearer());
    let mut bench = InProcess::new(config());
    rehearse(&mut bench, &mut wearer, &known, &options, &Display::Silent, None)
}

/// Errors over the board's own standard deviations, of x, y, z; root mean square over many machines.
fn real_over_reported(reports: &[Report]) -> f64 {
    let of = |report: &Report| {
        let found = report.found.as_ref().unwrap();
        (0..3).map(|k| (found.error_mm[k] / found.sigma_mm[k]).powi(2)).sum::<f64>()
    };
    (reports.iter().map(of).sum::<f64>() / (3 * reports.len()) as f64).sqrt()
}

fn rig_file(name: &str, text: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, text).unwrap();
    path
}

/// Twenty machines that are off as stated: every one is found, within the bar, and the bar is neither too wide nor too
/// narrow. 60 errors over σ: their root mean square is 1 ± 0.09.
#[test]
fn machines_off_by_their_tolerances_are_calibrated() {
    for arguments in ["--rig-error 0.5", "--rig-error 0.5 --pulley 5"] {
        let seeds = 0..20;
        let reports: Vec<_> = seeds.map(|seed| run(&format!("{arguments} --poses 15 --seed {seed}"))).collect();
        for (seed, report) in reports.iter().enumerate() {
            assert_eq!(report.status, Status::Right, "{arguments} --seed {seed}: {report}");
            assert_eq!(report.found.as_ref().unwrap().host.difference_mm, 0.0);
        }
        let ratio = real_over_reported(&reports);
        assert!((0.7..1.3).contains(&ratio), "{arguments}: {ratio}");
    }
}

/// The same machines, of which the board believes that they are as drawn: no wrong centre goes for right.
#[test]
fn machines_that_are_off_and_stated_exact_are_never_right() {
    let text = "base = [[150.0, 0.0, 0.0], [-75.0, 129.9038105676658, 0.0], [-75.0, -129.9038105676658, 0.0]]\n\
                edges = [178.3982062, 178.3982062, 178.3982062]\n";
    let exact = rig_file("exact-rig.toml", text);
    for seed in 0..5 {
        let report = run(&format!("--rig {} --rig-error 0.5 --poses 15 --seed {seed}", exact.display()));
        let off = report.found.as_ref().map_or(0.0, |found| found.centre_error_mm);
        assert!(report.status != Status::Right || off < 0.1, "{seed}: {report}");
    }
}

/// Told of its pulleys the board is right; one that takes them for points, and the machine for exact, is not.
#[test]
fn a_board_has_to_be_told_of_its_pulleys() {
    let told = run("--pulley 5 --poses 15");
    assert_eq!(told.status, Status::Right, "{told}");
    assert!(told.parameters_told.is_some_and(|count| count >= 13), "{:?}", told.parameters_told);

    let options = Options::try_parse_from(["rehearse", "--pulley", "5", "--poses", "15"]).unwrap();
    let truth = KnownMachine::of(&options).unwrap();
    let mut wearer = Wearer::new(truth.double, options.wearer());
    let exact = Rig::shoulder(150.0).unwrap();
    let untold = KnownMachine::built_in(exact, Rig::shoulder(150.0).unwrap());
    let mut bench = InProcess::new(Config::for_rig(untold.single));
    let report = rehearse(&mut bench, &mut wearer, &untold, &options, &Display::Silent, None);
    assert_ne!(report.status, Status::Right, "{report}");
}

/// A rig file makes the board another machine, with offsets and scales that commissioning found.
#[test]
fn a_rig_file_makes_another_machine_of_the_board() {
    let text = "home = [290.0, 291.0, 292.0, 293.0, 294.0, 295.0]\n\
                base = [[170.0, 0.0, 0.0], [-85.0, 147.2, 4.0], [-85.0, -147.2, -4.0]]\n\
                edges = [170.0, 180.0, 175.0]\n\
                [tolerance]\nbase = 0.3\nedges = 0.3\nzero = 0.1\ndrum = 0.001\n\
                [zeros]\nmm = [4.0, -3.0, 2.0, -1.0, 5.0, -6.0]\n\
                [drum]\nscale = [1.01, 0.99, 1.02, 1.0, 0.98, 1.005]\n";
    let path = rig_file("another-rig.toml", text);
    for seed in 0..5 {
        let report = run(&format!("--rig {} --rig-error 0.3 --poses 15 --seed {seed}", path.display()));
        assert_eq!(report.status, Status::Right, "{seed}: {report}");
    }
}

/// A commissioned rig: the board is told of tolerances that cover its covariance, which are a fifth of those before.
#[test]
fn a_commissioned_rig_is_told_to_the_board() {
    let before = "base = [[150.0, 0.0, 0.0], [-75.0, 129.9038105676658, 0.0], [-75.0, -129.9038105676658, 0.0]]\n\
                  edges = [178.3982062, 178.3982062, 178.3982062]\n[tolerance]\nbase = 0.5\nedges = 0.5\n";
    let variances = (0..6).flat_map(|i| (0..=i).map(move |j| if i == j { "0.01" } else { "0" }));
    let after = format!("{before}[covariance]\ntriangle = [{}]\n", variances.collect::<Vec<_>>().join(", "));
    let before = rig_file("before.toml", before);
    let after = rig_file("commissioned.toml", &after);
    let sigma =
        |report: &Report| report.found.as_ref().unwrap().sigma_mm[..3].iter().map(|s| s * s).sum::<f64>().sqrt();
    for seed in 0..5 {
        let options = |rig: &Path| format!("--rig {} --rig-error 0.1 --poses 15 --seed {seed}", rig.display());
        let (before, after) = (run(&options(&before)), run(&options(&after)));
        assert_eq!(after.status, Status::Right, "{seed}: {after}");
        assert_eq!(after.found.as_ref().unwrap().host.difference_mm, 0.0);
        assert!(sigma(&after) < 0.8 * sigma(&before), "{} {}", sigma(&after), sigma(&before));
    }
}

/// A board that is told of both parts of the noise, and says of how many samples each pose is the mean: the host's
/// calculation is the board's to the bit, which it is not when all poses count alike.
#[test]
fn a_board_is_told_of_the_noise_of_its_samples() {
    let text = "base = [[150.0, 0.0, 0.0], [-75.0, 129.9038105676658, 0.0], [-75.0, -129.9038105676658, 0.0]]\n\
                edges = [178.3982062, 178.3982062, 178.3982062]\n[noise]\npose = 0.0577\nsample = 0.2\n";
    let path = rig_file("noisy-rig.toml", text);
    for seed in 0..5 {
        let report = run(&format!("--rig {} --poses 15 --seed {seed}", path.display()));
        assert_eq!(report.status, Status::Right, "{seed}: {report}");
        assert_eq!(report.found.as_ref().unwrap().host.difference_mm, 0.0);
    }
}

/// A machine that is off as stated raises no alarm in use; what slips on it is named all the same.
#[test]
fn a_machine_that_is_not_as_drawn_is_no_slip() {
    for seed in 0..6 {
        let report = run(&format!("--rig-error 0.5 --poses 20 --seed {seed} --slip 3 --at 20"));
        assert_eq!(report.status, Status::Right, "{seed}: {report}");
    }
    for cable in 1..=6 {
        let report = run(&format!("--rig-error 0.5 --poses 20 --seed {cable} --slip 3 --at 5 --cable {cable}"));
        assert_eq!(report.status, Status::Right, "{cable}: {report}");
    }
}

#[test]
fn what_a_board_cannot_be_told_is_named() {
    let of = |arguments: &[&str]| {
        let options = Options::try_parse_from([&["rehearse"], arguments].concat()).unwrap();
        KnownMachine::of(&options).unwrap_err()
    };
    assert!(of(&["--rig", "no-such-rig.toml"]).contains("no-such-rig.toml"));
    let elbow = rig_file("elbow-rig.toml", include_str!("../../../examples/elbow.toml"));
    let said = of(&["--rig", &elbow.to_string_lossy()]);
    assert!(said.contains("elbow-rig.toml: an elbow is rehearsed by cargo rehearse --arm"), "{said}");
    let wrong = rig_file("wrong-rig.toml", "base = [[150, 0, 0], [-75, 130, 0]]\nedges = [178, 178, 178]\n");
    let said = of(&["--rig", &wrong.to_string_lossy()]);
    assert!(said.contains("wrong-rig.toml, line 1") && said.contains("3 points are wanted"), "{said}");
}
