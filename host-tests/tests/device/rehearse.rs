//! The rehearsal against the device in this process: the same script that plays against the emulated board.

use clap::Parser;
use glenoid::can::Frame;
use glenoid::device::Config;
use glenoid::identification::{Estimator, EstimatorSettings, Machine, Pose};
use glenoid::kinematics::CableLengths;
use glenoid::rig::{Rig, Tolerance};
use host_tests::rehearse::{
    Bench, BenchError, Display, Expected, InProcess, KnownMachine, Options, Report, Status, length_sigma_mm, rehearse,
};
use host_tests::wearer::{Wearer, WearerSettings};
use std::path::Path;

mod arm;
mod other_boards;

fn rig() -> Rig<f64> {
    Rig::shoulder(150.0).unwrap()
}

/// The machine that [`Config::for_rig`] of the shoulder makes: known exactly.
fn known() -> KnownMachine {
    KnownMachine::built_in(rig(), Rig::shoulder(150.0).unwrap())
}

/// The bound with offsets known to `prior_mm`, of a machine that is known exactly otherwise.
fn expected(wearer: &Wearer, rotations: &[nalgebra::Rotation3<f64>], sigma_mm: f64, prior_mm: f64) -> Option<Expected> {
    let tolerance = Tolerance { offset_mm: prior_mm, ..Tolerance::exact() };
    Expected::new(&rig(), wearer.arm(), rotations, sigma_mm, &tolerance)
}

/// The bound is derived from the geometry alone; the solver knows nothing of it. Over many draws of the noise the
/// spread of the solver's results must come out as the bound says.
#[test]
fn the_expected_error_is_the_spread_of_many_identifications() {
    let (rig, runs, noise_mm) = (rig(), 400, 0.1);
    let machine = Machine::new(&rig);
    let settings = |seed| WearerSettings { seed, noise_mm, ..Default::default() };
    let mut wearer = Wearer::new(rig, settings(4));
    let poses: Vec<_> = (0..30).map(|_| wearer.next_pose()).collect();
    let rotations: Vec<_> = poses.iter().map(|pose| pose.rotation).collect();
    let expected = expected(&wearer, &rotations, length_sigma_mm(noise_mm, 0.0), 0.0).unwrap().parameters;

    let truth = wearer.truth().to_array();
    let mut squares = [0.0; 6];
    for run in 0..runs {
        // Another wearer's noise on this wearer's poses.
        let mut noise = Wearer::new(rig, settings(1000 + run));
        let mut poses: Vec<_> = poses
            .iter()
            .map(|pose| {
                let errors = noise.next_pose().errors_mm;
                Pose::new(CableLengths::new(std::array::from_fn(|k| pose.spans_mm[k] + errors[k])).unwrap())
            })
            .collect();
        let mut estimator = Estimator::new(&machine, rig.nominal(), EstimatorSettings::for_rig(&rig));
        let found = estimator.run(&machine, &mut poses).unwrap();
        for (square, (value, truth)) in squares.iter_mut().zip(found.parameters.to_array().into_iter().zip(truth)) {
            *square += (value - truth).powi(2);
        }
    }
    for (square, expected) in squares.into_iter().zip(expected) {
        let ratio = (square / runs as f64).sqrt() / expected;
        // The spread of 400 draws is itself known to 1 / sqrt(800) = 3.5 %: four of those.
        assert!((0.86..1.14).contains(&ratio), "{ratio}");
    }
}

#[test]
fn poses_that_determine_nothing_have_no_expected_error() {
    let wearer = Wearer::new(rig(), WearerSettings::default());
    assert_eq!(expected(&wearer, &[], 0.1, 0.0), None);
}

#[test]
fn noise_and_rounding_add_up_in_squares() {
    // A uniform distribution within ±w has the standard deviation w / sqrt 3.
    assert!((length_sigma_mm(0.1, 0.0) - 0.1 / 3f64.sqrt()).abs() < 1e-15);
    assert!((length_sigma_mm(0.0, 0.2) - 0.1 / 3f64.sqrt()).abs() < 1e-15);
    assert!((length_sigma_mm(0.3, 0.8) - (0.3f64 * 0.3 + 0.4 * 0.4).sqrt() / 3f64.sqrt()).abs() < 1e-15);
}

/// A device in this process, and the wearer of `options`.
fn rehearse_with_plots(
    options: &Options,
    plots: Option<&Path>,
    tamper: impl Fn(usize, [i32; 6]) -> [i32; 6],
) -> Report {
    let config = Config::for_rig(Rig::<f32>::shoulder(150.0).unwrap());
    let mut bench = Tampering { inner: InProcess::new(config), tamper, samples: 0 };
    let mut wearer = Wearer::new(rig(), options.wearer());
    rehearse(&mut bench, &mut wearer, &known(), options, &Display::Silent, plots)
}

fn rehearse_in_process(options: &Options, tamper: impl Fn(usize, [i32; 6]) -> [i32; 6]) -> Report {
    rehearse_with_plots(options, None, tamper)
}

/// A bench that may change the encoder counts on their way.
struct Tampering<F> {
    inner: InProcess,
    tamper: F,
    samples: usize,
}

impl<F: Fn(usize, [i32; 6]) -> [i32; 6]> Bench for Tampering<F> {
    fn set_counts(&mut self, counts: &[i32; 6]) -> Result<(), BenchError> {
        self.samples += 1;
        self.inner.set_counts(&(self.tamper)(self.samples, *counts))
    }
    fn send(&mut self, frame: &Frame) -> Result<(), BenchError> {
        self.inner.send(frame)
    }
    fn pass(&mut self, ms: u32) -> Result<Vec<Frame>, BenchError> {
        self.inner.pass(ms)
    }
    fn restart(&mut self) -> Result<(), BenchError> {
        self.inner.restart()
    }
}

fn options(arguments: &[&str]) -> Options {
    Options::try_parse_from([&["rehearse"], arguments].concat()).unwrap()
}

fn honest(_: usize, counts: [i32; 6]) -> [i32; 6] {
    counts
}

#[test]
fn every_wearer_is_found() {
    for seed in 0..20 {
        let report = rehearse_in_process(&options(&["--seed", &seed.to_string(), "--poses", "12"]), honest);
        assert_eq!(report.status, Status::Right, "seed {seed}: {report}");
    }
}

#[test]
fn the_report_is_complete_and_the_same_every_time() {
    let plots = Path::new(env!("CARGO_TARGET_TMPDIR")).join("rehearse/complete");
    let run = || rehearse_with_plots(&options(&["--seed", "3"]), Some(&plots), honest);
    let report = run();
    assert_eq!(report.status, Status::Right, "{report}");
    let found = report.found.as_ref().unwrap();
    assert_eq!(found.host.difference_mm, 0.0, "the same code over the same lengths");
    assert!(found.centre_error_mm < 0.2 && found.sigma_mm.iter().all(|sigma| (0.005..0.2).contains(sigma)));
    assert!(found.host.deviations_mm.len() >= 2 && found.iterations >= 2);
    for name in ["convergence.svg", "convergence.png", "coverage.svg", "prediction.png"] {
        let file = report.plots.iter().find(|path| path.ends_with(name)).unwrap();
        assert!(std::fs::metadata(file).unwrap().len() > 1000);
    }
    assert_eq!(serde_json::to_string(&report).unwrap(), serde_json::to_string(&run()).unwrap());
    let json: serde_json::Value = serde_json::to_value(&report).unwrap();
    for key in [
        "status",
        "true_centre_mm",
        "centre_mm",
        "radii_mm",
        "sigma_mm",
        "error_mm",
        "tolerance_mm",
        "plots",
        "centre_after_restart_mm",
    ] {
        assert!(json.get(key).is_some(), "{key} in {json}");
    }
    let text = report.to_string();
    assert!(text.contains("agree to the bit") && text.contains("right:"), "{text}");
}

#[test]
fn a_cable_that_reads_too_long_makes_the_centre_wrong() {
    // One encoder reads 3 % too much: nothing that the wearer's noise explains.
    let report = rehearse_in_process(&options(&["--seed", "5", "--poses", "12"]), |_, mut counts| {
        counts[2] += counts[2] / 33;
        counts
    });
    assert_ne!(report.status, Status::Right, "{report}");
    assert!(!report.reasons.is_empty() && report.reasons.iter().all(|reason| !reason.is_empty()));
}

/// Encoders that wake elsewhere than their settings say, and nobody tells the board.
#[test]
fn concealed_zero_errors_are_not_passed_off_as_right() {
    let report = rehearse_in_process(&options(&["--seed", "5"]), |_, counts| {
        std::array::from_fn(|k| counts[k] + [22, -9, 14, 20, -17, 5][k])
    });
    assert_ne!(report.status, Status::Right, "{report}");
}

#[test]
fn zero_errors_that_the_board_is_told_to_look_for_are_found() {
    for seed in 0..5 {
        let report = rehearse_in_process(&options(&["--seed", &seed.to_string(), "--zero-error", "10"]), honest);
        assert_eq!(report.status, Status::Right, "seed {seed}: {report}");
        let found = report.found.as_ref().unwrap();
        assert_eq!(found.host.difference_mm, 0.0);
        let zeros = found.zeros.unwrap();
        assert!(zeros.true_zeros_mm.iter().any(|zero| zero.abs() > 3.0), "there was something to find");
        let deviation_mm = found.host.deviation_mm.unwrap();
        assert!(deviation_mm < 0.2, "the lengths are corrected: {deviation_mm}");
        let json = serde_json::to_value(&report).unwrap();
        assert_eq!(json["zeros_mm"].as_array().unwrap().len(), 6);
        assert!(report.to_string().contains("encoder zeros"));
    }
}

#[test]
fn with_zeros_that_are_nearly_known_the_expected_error_is_that_of_known_ones() {
    let mut wearer = Wearer::new(rig(), WearerSettings::default());
    let rotations: Vec<_> = (0..30).map(|_| wearer.next_pose().rotation).collect();
    let known = expected(&wearer, &rotations, 0.06, 0.0).unwrap().parameters;
    let with = |prior_mm| {
        let expected = expected(&wearer, &rotations, 0.06, prior_mm).unwrap();
        (expected.parameters, expected.offsets)
    };
    let (nearly, zeros) = with(1e-4);
    assert!(known.iter().zip(nearly).all(|(known, nearly)| (nearly / known - 1.0).abs() < 1e-3));
    assert!(zeros.iter().all(|zero| (zero / 1e-4 - 1.0).abs() < 1e-3));
    let (unknown, zeros) = with(10.0);
    assert!(known.iter().zip(unknown).all(|(known, unknown)| unknown > 2.0 * known));
    assert!(zeros.iter().all(|zero| (0.1..1.0).contains(zero)), "{zeros:?}");
}

#[test]
fn what_slips_is_named() {
    let plots = Path::new(env!("CARGO_TARGET_TMPDIR")).join("rehearse/slip");
    let strap = rehearse_with_plots(&options(&["--slip", "3", "--at", "1.5"]), Some(&plots), honest);
    assert_eq!(strap.status, Status::Right, "{strap}");
    assert_eq!(strap.slip.as_ref().unwrap().reported, Some("StrapSlipped"));
    for name in ["slip-centre.svg", "slip-residual.png"] {
        assert!(strap.plots.iter().any(|file| file.ends_with(name)), "{name}");
    }
    assert!(strap.to_string().contains("the board said"));
    for cable in 1..=6 {
        let cable_text = cable.to_string();
        let arguments = ["--slip", "2", "--cable", &cable_text, "--zero-error", "10", "--seed", &cable_text];
        let report = rehearse_in_process(&options(&arguments), honest);
        assert_eq!(report.status, Status::Right, "cable {cable}: {report}");
        assert_eq!(report.slip.unwrap().reported_cable, cable);
    }
}

#[test]
fn a_slip_that_the_board_does_not_see_is_not_right() {
    let report = rehearse_in_process(&options(&["--slip", "0.1"]), honest);
    assert_eq!(report.status, Status::Wrong, "{report}");
    assert_eq!(report.reasons, ["the board said nothing of the slip"]);
}

#[test]
fn an_encoder_that_falls_silent_is_named() {
    struct Cut(InProcess, u32);
    impl Bench for Cut {
        fn set_counts(&mut self, counts: &[i32; 6]) -> Result<(), BenchError> {
            self.1 += 1;
            if self.1 > 500 { Ok(()) } else { self.0.set_counts(counts) }
        }
        fn send(&mut self, frame: &Frame) -> Result<(), BenchError> {
            self.0.send(frame)
        }
        fn pass(&mut self, ms: u32) -> Result<Vec<Frame>, BenchError> {
            self.0.pass(ms)
        }
        fn restart(&mut self) -> Result<(), BenchError> {
            self.0.restart()
        }
    }
    let config = Config::for_rig(Rig::<f32>::shoulder(150.0).unwrap());
    let mut bench = Cut(InProcess::new(config), 0);
    let options = options(&[]);
    let mut wearer = Wearer::new(rig(), options.wearer());
    let plots = Path::new(env!("CARGO_TARGET_TMPDIR")).join("rehearse/silent");
    let report = rehearse(&mut bench, &mut wearer, &known(), &options, &Display::Silent, Some(&plots));
    assert_eq!(report.status, Status::Failed);
    assert!(report.reasons[0].contains("no encoder counts arrive"), "{report}");
    assert!(report.plots.is_empty() && !plots.exists());
}

/// Lines A and B exchanged: it counts down where the others count up.
#[test]
fn an_encoder_that_counts_the_wrong_way_gives_no_centre() {
    for cable in 0..6 {
        let report = rehearse_in_process(&options(&["--seed", "6", "--poses", "12"]), |_, mut counts| {
            counts[cable] = -counts[cable];
            counts
        });
        assert_eq!(report.status, Status::Failed, "cable {}: {report}", cable + 1);
        assert!(report.reasons[0].contains("What to do: "), "{report}");
    }
}

/// A line that picks up noise: from counts that jitter within the noise of the others to leaps of centimetres. A centre
/// that is accepted is the right one.
#[test]
fn a_noisy_encoder_gives_no_wrong_centre() {
    for (seed, most) in [(1_u64, 3), (2, 10), (3, 40), (4, 200), (5, 1_000), (6, 20_000)] {
        let report = rehearse_in_process(&options(&["--seed", "6", "--poses", "12"]), |sample, mut counts| {
            let noise = (sample as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15 ^ seed) >> 40;
            counts[1] += noise as i32 % (2 * most + 1) - most;
            counts
        });
        assert_ne!(report.status, Status::Wrong, "{most}: {report}");
    }
}

/// The board itself is sound, but after the restart another one stands in its place.
#[test]
fn poses_that_do_not_suffice_are_told_with_the_remedy() {
    // Three random poses leave the centre uncertain, or turn about nearly one axis, more often than not.
    let reports: Vec<_> = (0..20)
        .map(|seed| rehearse_in_process(&options(&["--seed", &seed.to_string(), "--poses", "3"]), honest))
        .collect();
    let wants_more = |report: &&Report| report.reasons.iter().any(|r| r.starts_with("the board wants more poses: "));
    assert!(reports.iter().any(|report| wants_more(&report)));
    for report in &reports {
        let refused = report.status == Status::Failed && report.reasons[0].contains("What to do: ");
        assert!(refused || report.status == Status::Right, "{report}");
    }
}
