//! Shoulders whose centre moves, through the whole procedure: the device in this process, a client, a wearer.

use clap::Parser;
use glenoid::device::Config;
use glenoid::rig::Rig;
use host_tests::rehearse::{Bench, BenchError, Display, InProcess, KnownMachine, Options, Report, Status, rehearse};
use host_tests::wearer::Wearer;

/// Rehearses in this process, with the encoder counts changed on their way.
fn rehearsal(arguments: &[&str], tamper: impl Fn(&mut Samples, [i32; 6]) -> [i32; 6]) -> Report {
    let options = Options::try_parse_from([&["rehearse"], arguments].concat()).unwrap();
    let rig = Rig::<f64>::shoulder(150.0).unwrap();
    let config = Config::for_rig(Rig::<f32>::shoulder(150.0).unwrap());
    let mut bench = Tampering { inner: InProcess::new(config.clone()), tamper, samples: Samples::default() };
    let known = KnownMachine::built_in(rig, *config.rig.ball().unwrap());
    let mut wearer = Wearer::new(rig, options.wearer());
    rehearse(&mut bench, &mut wearer, &known, &options, &Display::Silent, None)
}

/// What went by so far.
#[derive(Default)]
struct Samples {
    /// Commands sent: one capture and one read-out a pose, about.
    commands: usize,
}

struct Tampering<F> {
    inner: InProcess,
    tamper: F,
    samples: Samples,
}

impl<F: Fn(&mut Samples, [i32; 6]) -> [i32; 6]> Bench for Tampering<F> {
    fn set_counts(&mut self, counts: &[i32; 6]) -> Result<(), BenchError> {
        self.inner.set_counts(&(self.tamper)(&mut self.samples, *counts))
    }
    fn send(&mut self, frame: &glenoid::can::Frame) -> Result<(), BenchError> {
        self.samples.commands += 1;
        self.inner.send(frame)
    }
    fn pass(&mut self, ms: u32) -> Result<Vec<glenoid::can::Frame>, BenchError> {
        self.inner.pass(ms)
    }
    fn restart(&mut self) -> Result<(), BenchError> {
        self.inner.restart()
    }
}

fn right(arguments: &[&str]) -> host_tests::rehearse::ShoulderReport {
    let report = rehearsal(arguments, |_, counts| counts);
    assert_eq!(report.status, Status::Right, "{arguments:?}: {:?} {:?}", report.reasons, report.shoulder);
    report.shoulder.unwrap()
}

#[test]
fn one_phase_finds_the_path() {
    for (person, follow) in [("1", "0"), ("2", "0.5"), ("3", "0")] {
        let shoulder = right(&["--shoulder", person, "--follow", follow, "--poses", "60", "--seed", person]);
        assert!(shoulder.path_error_mm < 2.0 * shoulder.path_sigma_mm, "{shoulder:?}");
        assert!(shoulder.across_error_mm < 2.5 * shoulder.across_sigma_mm, "{shoulder:?}");
        assert!(shoulder.path_error_mm < shoulder.travel_mm * 0.5, "{shoulder:?}");
        assert!((0.2..0.7).contains(&shoulder.scatter_mm), "{shoulder:?}");
    }
}

#[test]
fn two_phases_find_it_better_known() {
    let arguments = ["--shoulder", "1", "--poses", "60", "--seed", "4"];
    let one = right(&arguments);
    let two = right(&[&arguments[..], &["--two-phase"]].concat());
    assert!(two.path_sigma_mm < one.path_sigma_mm, "{one:?} {two:?}");
    assert!(two.path_error_mm < 2.0, "{two:?}");
}

/// The zero of one cable's encoder jumps by 5 mm midway through the free poses.
#[test]
fn a_count_that_slips_midway_is_never_taken_for_a_moving_joint() {
    let report = rehearsal(&["--shoulder", "1", "--poses", "60"], |samples, mut counts| {
        if samples.commands > 33 {
            counts[2] += 217;
        }
        counts
    });
    assert_eq!(report.status, Status::Failed, "{:?}", report.shoulder);
    let reason = report.reasons.join(" ");
    let names = ["slip", "neither a ball nor", "contradict", "wanders", "settle"];
    assert!(names.iter().any(|name| reason.contains(name)), "{reason}");
}

/// The arm is never held: the board captures on its way, and everything is done within a minute.
#[test]
fn a_free_movement_of_a_minute_is_enough() {
    let shoulder = right(&["--shoulder", "1", "--poses", "60", "--seed", "4", "--free-motion"]);
    assert!(shoulder.in_motion && shoulder.poses >= 60 && shoulder.wearer_s < 60.0, "{shoulder:?}");
    let held = right(&["--shoulder", "1", "--poses", "60", "--seed", "4"]);
    assert!(shoulder.path_sigma_mm < 1.3 * held.path_sigma_mm, "{held:?} {shoulder:?}");
    assert!(shoulder.across_error_mm < 2.5 * shoulder.across_sigma_mm, "{shoulder:?}");
    let two = right(&["--shoulder", "2", "--poses", "60", "--seed", "2", "--free-motion", "--two-phase"]);
    assert!(two.wearer_s < 60.0 && two.path_error_mm < 2.5, "{two:?}");
}
