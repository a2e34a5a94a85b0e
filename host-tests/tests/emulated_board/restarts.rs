//! The record across restarts of the board, and resets in the middle of everything.

use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use embedded_storage::nor_flash::ReadNorFlash;
use firmware_image::elf::Elf;
use glenoid::can::result::Parameter;
use glenoid::can::{Message, Opcode};
use glenoid::device::fingerprint;
use glenoid::procedure::{Reason, StateName};
use glenoid::record::STORAGE_PAGES;
use glenoid::record::{Record, RecordStore, image};
use glenoid::restart::ResetCause;
use host_tests::debugger::Debugger;
use host_tests::emulator::{Emulator, Options};
use host_tests::flash::{MockFlash, PAGE_LEN, TornWord};
use host_tests::power_cut;
use host_tests::rehearse::KnownMachine;
use libtest_mimic::Failed;

use crate::PATIENCE;
use crate::scene::{Scene, last_report};

/// A file for a record, removed at the end.
pub struct RecordFile(PathBuf);

impl RecordFile {
    pub fn new(name: &str) -> Self {
        // a comma, because the emulator's command line has its own use for it
        let path = std::env::temp_dir().join(format!("glenoid test, {name}, {}", std::process::id()));
        let _ = std::fs::remove_file(&path);
        Self(path)
    }

    /// A file with the record of run 7, as the board would have stored it.
    pub fn filled(name: &str) -> Result<Self, Failed> {
        let rig = KnownMachine::compiled_in()?.single;
        // as the shoulder could have it
        let (parameters, covariance_mm2) = (*rig.nominal(), std::array::from_fn(|k| 0.01 + k as f32 * 1e-4));
        let record = Record { rig: fingerprint(&rig), parameters, covariance_mm2, ..power_cut::record(7) };
        let mut store = RecordStore::new(MockFlash::new(2, TornWord::Zeros, 1), 0);
        store.store(&record)?;
        // the other pages of the storage are erased
        let mut pages = [0xFF; STORAGE_PAGES * PAGE_LEN];
        let (of_record, _) = pages.split_at_mut(2 * PAGE_LEN);
        store.release().read(0, of_record).map_err(|error| format!("{error:?}"))?;
        let file = Self::new(name);
        std::fs::write(&file.0, pages)?;
        Ok(file)
    }

    pub fn options(&self) -> Options {
        Options { record: Some(self.0.clone()), ..Options::default() }
    }
}

impl Drop for RecordFile {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// The centre in use as the board tells it on query; empty when it tells none.
pub fn live(scene: &mut Scene) -> Result<Vec<Parameter>, Failed> {
    scene.ask(Opcode::Query, 0, 0)?;
    // the report follows the answer, two frames a millisecond
    scene.hold(300)?;
    let is_live = scene.wait("heartbeat", |m| if let Message::Heartbeat(h) = m { Some(h.flags.live) } else { None })?;
    let heard = |scene: &Scene| -> Vec<Parameter> {
        let parameters = last_report(&scene.heard).iter().filter_map(|message| match message {
            Message::LiveCentre(p) | Message::LiveRadius(p) => Some(*p),
            _ => None,
        });
        parameters.take(6).collect()
    };
    for _ in 0..PATIENCE.as_millis() / 100 {
        if !is_live || heard(scene).len() == 6 {
            break;
        }
        scene.hold(100)?;
    }
    Ok(heard(scene))
}

/// Why the board started, and whether it told that it had to be restarted.
pub fn reset_cause(scene: &mut Scene) -> Result<ResetCause, Failed> {
    scene.ask(Opcode::Query, 0, 0)?;
    scene.wait("versions", |message| if let Message::Versions(v) = message { Some(v.reset_cause) } else { None })
}

/// A calibration that is accepted; gives the centre in use.
pub fn calibrate(scene: &mut Scene) -> Result<Vec<Parameter>, Failed> {
    let run_id = scene.run_to_review(6)?;
    assert_eq!(scene.accept(run_id)?.code, Reason::Fine);
    assert_eq!(scene.ask(Opcode::Acknowledge, run_id, 0)?.code, Reason::Fine);
    let live = live(scene)?;
    assert_eq!(live.len(), 6, "{live:?}");
    Ok(live)
}

/// The emulator is ended and started again: to the board, the supply goes off and on.
pub fn a_restart_finds_the_record(image: &Path) -> Result<(), Failed> {
    let file = RecordFile::new("restart");
    let mut scene = Scene::on(Emulator::start(image, &file.options())?, 31)?;
    assert_eq!(live(&mut scene)?, []);
    let before = calibrate(&mut scene)?;
    drop(scene);
    let mut scene = Scene::on(Emulator::start(image, &file.options())?, 32)?;
    assert_eq!(live(&mut scene)?, before);
    assert_eq!(reset_cause(&mut scene)?, ResetCause::PowerOn);
    // and the next calibration replaces it
    let after = calibrate(&mut scene)?;
    assert_eq!(after[0].run_id, before[0].run_id + 1);
    drop(scene);
    let mut scene = Scene::on(Emulator::start(image, &file.options())?, 33)?;
    assert_eq!(live(&mut scene)?, after);
    Ok(())
}

/// What other boards, other firmware, wear and a broken supply may leave in the flash: each named, none in use.
pub fn a_bad_record_is_refused_by_name(image: &Path) -> Result<(), Failed> {
    let file = RecordFile::filled("refused")?;
    let good = std::fs::read(&file.0)?;
    let begin = good.chunks(2048).position(|page| page[0] != 0xFF).ok_or("no record was stored")? * 2048;
    let spoilt = |spoil: &dyn Fn(&mut image::Image)| {
        let mut bytes = good.clone();
        if let Some(image) = bytes[begin..].first_chunk_mut() {
            spoil(image);
        }
        bytes
    };
    // with a checksum that is right again
    let sealed = |change: &dyn Fn(&mut image::Image)| {
        spoilt(&|image| {
            change(image);
            let sum = image::checksum(image);
            image[image::IMAGE_LEN - 4..].copy_from_slice(&sum.to_le_bytes());
        })
    };
    let cases = [
        (spoilt(&|image| image[40] ^= 1), Reason::RecordDamaged),
        (sealed(&|image| image[12] ^= 1), Reason::RecordOfOtherRig),
        (sealed(&|image| image[4..6].fill(0)), Reason::RecordOlder),
        (sealed(&|image| image[4..6].fill(0xFF)), Reason::RecordNewer),
        // x is NaN
        (sealed(&|image| image[28..32].fill(0xFF)), Reason::RecordUnfit),
    ];
    for (bytes, reason) in cases {
        std::fs::write(&file.0, bytes)?;
        let mut scene = Scene::on(Emulator::start(image, &file.options())?, 34)?;
        scene.heard.clear();
        scene.wait("fault", |m| matches!(m, Message::Fault(f) if f.code == reason && f.active).then_some(()))?;
        assert_eq!(live(&mut scene)?, [], "{reason:?}");
    }
    // a flash that refuses everything: nothing is kept, and that is said
    std::fs::remove_file(&file.0)?;
    std::fs::create_dir(&file.0)?;
    let mut scene = Scene::on(Emulator::start(image, &file.options())?, 34)?;
    scene.heard.clear();
    let fault = |code| move |m: &Message| matches!(m, Message::Fault(f) if f.code == code && f.active).then_some(());
    let unreadable = scene.wait("fault", fault(Reason::RecordUnreadable));
    let kept = unreadable.and_then(|()| calibrate(&mut scene));
    let refused = kept.and_then(|_| scene.wait("fault", fault(Reason::StoreRefused)));
    std::fs::remove_dir(&file.0)?;
    refused
}

/// The reset pin in the middle of every state: the run is gone, the centre in use is the old one.
pub fn a_reset_in_any_state_keeps_the_old_centre(image: &Path) -> Result<(), Failed> {
    let file = RecordFile::filled("resets")?;
    let options = Options { monitor: true, debugger: true, ..file.options() };
    let symbols = Elf::read(image)?.symbols()?;
    // every pass of the solver comes by here, unless the compiler has dissolved it in its caller
    let in_a_pass = |name: &str| name.contains("fit::Fit<") && name.ends_with("::add_placed");
    let solving = symbols.iter().find(|symbol| in_a_pass(&symbol.name));
    let solving = u32::try_from(solving.ok_or("the solver has no such function")?.address)?;
    let mut scene = Scene::on(Emulator::start(image, &options)?, 35)?;
    let old = live(&mut scene)?;
    assert_eq!(old.len(), 6, "{old:?}");
    for (number, state) in StateName::ALL.into_iter().enumerate() {
        lead_to(&mut scene, state)?;
        // the log is written when there is nothing else to do, which is not so while the solver works
        let logged = if state == StateName::Identifying { StateName::Collecting } else { state };
        wait_for_logged_state(&scene.board, logged)?;
        if state == StateName::Identifying {
            // over in milliseconds, so the board is halted in the middle of it
            let mut debugger = Debugger::halt(scene.board.debugger_address().ok_or("no debugger")?)?;
            let mut told = Ok(());
            debugger.run_to(solving, || told = scene.tell(Opcode::Identify))?;
            told?;
            scene.board.reset()?;
            debugger.resume()?;
        } else {
            scene.board.reset()?;
        }
        scene.board.wait_for_log_times("board: ready", number + 2, PATIENCE)?;
        assert_eq!(last_state_before_the_reset(&scene.board.log()), format!("{logged:?}"));
        scene = scene.with_a_new_client()?;
        scene.hold(600)?;
        assert_eq!(live(&mut scene)?, old, "after a reset in {state:?}");
        assert_eq!(reset_cause(&mut scene)?, ResetCause::Pin);
        let heartbeat = scene.wait("heartbeat", |m| if let Message::Heartbeat(h) = m { Some(*h) } else { None })?;
        assert_eq!((heartbeat.state, heartbeat.poses, heartbeat.flags.live), (StateName::Idle, 0, true));
    }
    Ok(())
}

/// The log comes when the board and its reader have time for it.
fn wait_for_logged_state(board: &Emulator, state: StateName) -> Result<(), Failed> {
    let end = Instant::now() + PATIENCE;
    while last_state(board.log().iter().rev()) != format!("{state:?}") {
        if Instant::now() >= end {
            return Err(format!("{state:?} is not in the log, which ends with {:?}", board.log().last()).into());
        }
        thread::sleep(Duration::from_millis(20));
    }
    Ok(())
}

/// The state that the board logged last before it started for the last time.
fn last_state_before_the_reset(log: &[String]) -> String {
    last_state(log.iter().rev().skip_while(|line| !line.contains("board: started")).skip(1))
}

/// The state that was logged last since the board started; these lines begin with the latest.
fn last_state<'a>(lines: impl Iterator<Item = &'a String>) -> String {
    let mut lines = lines.take_while(|line| !line.contains("board: started"));
    let state = lines.find_map(|line| line.split_once(" to: ")?.1.split_once(',').map(|(state, _)| state.to_owned()));
    state.unwrap_or_else(|| "Idle".to_owned())
}

/// Leads a run to a state; to `Identifying` up to the command that leads into it.
fn lead_to(scene: &mut Scene, state: StateName) -> Result<(), Failed> {
    match state {
        StateName::Idle => return Ok(()),
        StateName::Review => {
            scene.run_to_review(6)?;
            return Ok(());
        }
        _ => {}
    }
    assert_eq!(scene.ask_when_still(Opcode::Start, 1)?.code, Reason::Fine);
    match state {
        StateName::Collecting => {}
        StateName::Failed => {
            scene.lose_a_count()?;
            scene.wait_for_state(StateName::Failed)?;
        }
        _ => {
            scene.capture(6)?;
            if state == StateName::Verifying {
                assert_eq!(scene.ask(Opcode::Identify, 0, 0)?.code, Reason::Fine);
                scene.wait_for_state(state)?;
            }
        }
    }
    Ok(())
}
