//! The numbering of the cables: a shifted one fits a symmetric machine, so it is looked for before the first accept.

use super::bench::Bench;
use glenoid::can::{Message, Opcode};
use glenoid::device::{Config, Device, Event};
use glenoid::procedure::{Reason, StateName};
use glenoid::record::Loaded;
use glenoid::rig::Rig;
use host_tests::wearer::WearerSettings;

const STRAIGHT: [usize; 6] = [0, 1, 2, 3, 4, 5];
/// Every attachment point taken for the next one.
const SHIFTED: [usize; 6] = [2, 3, 4, 5, 0, 1];

fn config(numbering_check: bool) -> Config {
    Config { numbering_check, ..Config::for_rig(Rig::shoulder(150.0).unwrap()) }
}

fn bench(numbering_check: bool, wiring: [usize; 6]) -> Bench {
    let mut bench =
        Bench::of(config(numbering_check), WearerSettings { seed: 9, noise_mm: 0.1, ..WearerSettings::default() });
    bench.wiring = wiring;
    // the encoders leap to their new places; then they are believed
    bench.pass(1_000);
    bench
}

/// Pulls a cable by 10 mm in 100 ms, and lets go.
fn pull(bench: &mut Bench, cable: usize) {
    let rest = bench.at.counts;
    for step in (0..=10).chain((0..10).rev()) {
        let mut counts = rest;
        counts[cable - 1] += 43 * step;
        bench.set_counts(counts);
        bench.pass(10);
    }
}

fn check(bench: &mut Bench, cable: u16) -> (Reason, u16) {
    let answer = bench.request(Opcode::CheckCable as u8, 0, cable);
    (answer.code, answer.detail)
}

/// How far the new centre is from the true one, mm.
fn error_mm(bench: &Bench) -> f64 {
    let found = bench.procedure().candidate().unwrap().identified.parameters.centre_mm;
    (found.cast() - bench.wearer.truth().centre_mm).norm()
}

#[test]
fn the_first_accept_waits_for_every_cable() {
    let mut bench = bench(true, STRAIGHT);
    bench.lead_to(StateName::Review);
    assert_eq!(bench.accept().code, Reason::NumberingUnchecked);
    // the button is told as well: it has no other way
    let blinks = u32::from(bench.naming().unwrap().checksum % 3 + 2);
    (0..blinks).for_each(|_| bench.press(200));
    bench.press(1_500);
    bench.pass(100);
    assert_eq!((bench.state(), bench.heartbeat().reason), (StateName::Review, Reason::NumberingUnchecked));
    for cable in 1..=6u16 {
        let before = (1 << (cable - 1)) - 1;
        assert_eq!(check(&mut bench, cable), (Reason::CableNotPulled, before));
        assert_eq!(check(&mut bench, cable), (Reason::CableNotPulled, before), "nobody has pulled yet");
        if cable == 6 {
            assert_eq!(bench.accept().code, Reason::NumberingUnchecked);
        }
        pull(&mut bench, cable.into());
        assert_eq!(check(&mut bench, cable), (Reason::Fine, before << 1 | 1));
    }
    assert_eq!(bench.accept().code, Reason::Fine);
    // the machine stays what it is: neither another accept nor a restart asks again
    bench.pass(100);
    let (record, journal) = (*bench.records.last().unwrap(), bench.journal.last().copied());
    bench.device = Device::new(&config(true));
    bench.event(Event::PowerUp(Loaded { journal, ..Ok(record).into() }));
    bench.pass(600);
    bench.lead_to(StateName::Review);
    assert_eq!(bench.accept().code, Reason::Fine);
}

/// What the check is for: without it the centre of a shifted numbering is accepted, centimetres off.
#[test]
fn a_shifted_numbering_fits_and_is_found_by_pulling_the_first_cable() {
    let mut unchecked = bench(false, SHIFTED);
    unchecked.lead_to(StateName::Review);
    assert!(error_mm(&unchecked) > 10.0, "{}", error_mm(&unchecked));
    assert_eq!(unchecked.accept().code, Reason::Fine);

    let mut checked = bench(true, SHIFTED);
    check(&mut checked, 1);
    pull(&mut checked, 1);
    // the lengths of cable 1 come from the encoder that the board takes for the fifth
    assert_eq!(check(&mut checked, 1), (Reason::WrongCable, 5));
    checked.pass(600);
    checked.lead_to(StateName::Review);
    assert_eq!(checked.accept().code, Reason::NumberingUnchecked);
}

#[test]
fn what_cannot_be_checked_says_so() {
    let mut bench = bench(true, STRAIGHT);
    assert_eq!(check(&mut bench, 0).0, Reason::BadArgument);
    assert_eq!(check(&mut bench, 7).0, Reason::BadArgument);
    assert_eq!(bench.request(Opcode::CheckCable as u8, 1, 1).code, Reason::BadArgument);
    // an arm that moves is no cable that is pulled
    check(&mut bench, 2);
    bench.next_pose();
    assert_eq!(check(&mut bench, 2).0, Reason::CableNotPulled);
    bench.silent = true;
    bench.pass(600);
    assert_eq!(check(&mut bench, 2).0, Reason::EncoderSilent);
    bench.silent = false;
    bench.pass(600);
    bench.lead_to(StateName::Collecting);
    assert_eq!(check(&mut bench, 2).0, Reason::WrongState);
    assert!(!bench.take_messages().iter().any(|m| matches!(m, Message::Outcome(_))));
}
