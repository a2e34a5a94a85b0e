//! Boards that are not what they were, that miss their samples, or say nothing.

use super::*;

#[test]
fn a_board_that_forgets_its_centre_or_has_another_is_never_right() {
    struct Exchanged(InProcess, Option<InProcess>);
    impl Bench for Exchanged {
        fn set_counts(&mut self, counts: &[i32; 6]) -> Result<(), BenchError> {
            self.0.set_counts(counts)
        }
        fn send(&mut self, frame: &Frame) -> Result<(), BenchError> {
            self.0.send(frame)
        }
        fn pass(&mut self, ms: u32) -> Result<Vec<Frame>, BenchError> {
            self.0.pass(ms)
        }
        fn restart(&mut self) -> Result<(), BenchError> {
            self.0 = self.1.take().unwrap();
            self.0.restart()
        }
    }
    let config = Config::for_rig(Rig::<f32>::shoulder(150.0).unwrap());
    let (options, rig) = (options(&["--seed", "3", "--poses", "12"]), rig());
    let rehearse_with = |bench: &mut dyn Bench, seed| {
        let mut wearer = Wearer::new(rig, WearerSettings { seed, ..options.wearer() });
        rehearse(bench, &mut wearer, &known(), &options, &Display::Silent, None)
    };
    let empty = InProcess::new(config.clone());
    let report = rehearse_with(&mut Exchanged(InProcess::new(config.clone()), Some(empty)), 3);
    assert_eq!(report.reasons, ["after a restart the board has no centre in use"]);

    let mut other = InProcess::new(config.clone());
    assert_eq!(rehearse_with(&mut other, 4).status, Status::Right);
    let report = rehearse_with(&mut Exchanged(InProcess::new(config.clone()), Some(other)), 3);
    assert_eq!(report.status, Status::Wrong);
    assert_eq!(report.reasons, ["the centre in use after a restart is not the one that was accepted"]);
    assert!(report.to_string().contains("ANOTHER"), "{report}");
}

/// A host with too much to do sends no counts for a while, and then a command: once the counts come again, it is obeyed.
#[test]
fn counts_that_pause_before_a_command_are_waited_for() {
    struct Pausing {
        inner: InProcess,
        heard: Vec<Frame>,
        sent: u32,
    }
    impl Bench for Pausing {
        fn set_counts(&mut self, counts: &[i32; 6]) -> Result<(), BenchError> {
            self.inner.set_counts(counts)
        }
        fn send(&mut self, frame: &Frame) -> Result<(), BenchError> {
            self.sent += 1;
            if self.sent.is_multiple_of(2) {
                self.heard.extend(self.inner.pass(2_000)?);
            }
            self.inner.send(frame)
        }
        fn pass(&mut self, ms: u32) -> Result<Vec<Frame>, BenchError> {
            let mut heard = std::mem::take(&mut self.heard);
            heard.extend(self.inner.pass(ms)?);
            Ok(heard)
        }
        fn restart(&mut self) -> Result<(), BenchError> {
            self.inner.restart()
        }
    }
    let config = Config::for_rig(Rig::<f32>::shoulder(150.0).unwrap());
    let mut bench = Pausing { inner: InProcess::new(config.clone()), heard: Vec::new(), sent: 0 };
    let options = options(&["--poses", "12"]);
    let mut wearer = Wearer::new(rig(), options.wearer());
    let report = rehearse(&mut bench, &mut wearer, &known(), &options, &Display::Silent, None);
    assert_eq!(report.status, Status::Right, "{report}");
}

#[test]
fn a_board_that_says_nothing_is_reported() {
    struct Dead;
    impl Bench for Dead {
        fn set_counts(&mut self, _: &[i32; 6]) -> Result<(), BenchError> {
            Ok(())
        }
        fn send(&mut self, _: &Frame) -> Result<(), BenchError> {
            Ok(())
        }
        fn pass(&mut self, _: u32) -> Result<Vec<Frame>, BenchError> {
            Ok(Vec::new())
        }
        fn restart(&mut self) -> Result<(), BenchError> {
            Ok(())
        }
    }
    let options = options(&[]);
    let mut wearer = Wearer::new(rig(), options.wearer());
    let report = rehearse(&mut Dead, &mut wearer, &known(), &options, &Display::Silent, None);
    assert_eq!(report.reasons, ["the board sent no heartbeat in time"]);
}
