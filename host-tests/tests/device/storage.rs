//! The storage a step at a time: nobody waits for the flash, and whatever is cut, what was stored is whole and in order.

use glenoid::parameters::{Key, ParameterSet};
use glenoid::record::{Journal, JournalEntry, STORAGE_PAGES, Storage, StoreError, Stored};
use host_tests::flash::{Defect, MockFlash, PAGE_LEN, TornWord};
use host_tests::power_cut::{RIG, record};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn new_storage(torn: TornWord, seed: u64) -> Storage<MockFlash> {
    Storage::new(MockFlash::new(STORAGE_PAGES, torn, seed), 0)
}

fn entry(run_id: u16) -> JournalEntry {
    JournalEntry { boot: 1, run_id, distrust: 0 }
}

fn parameters(number: u32) -> ParameterSet {
    let mut set = ParameterSet::new();
    set.set_bits(200, number).unwrap();
    set
}

/// The power comes back: what is there of run numbers of the record, of the journal, and of the parameters.
fn found(storage: &Storage<MockFlash>) -> (Option<u16>, Option<u16>, Option<u32>) {
    let mut flash = storage.flash().clone();
    flash.power_up();
    let mut storage = Storage::new(flash, 0);
    let parameters = storage.load_parameters().ok().map(|set| set.integer(Key::LockKey1));
    let loaded = storage.load(RIG, None);
    let run_id = loaded.record.ok().map(|found| {
        assert_eq!(found, record(found.run_id()).into(), "a mixture of two records");
        found.run_id()
    });
    (run_id, loaded.journal.map(|entry| entry.run_id), parameters)
}

#[test]
fn a_step_starts_one_operation_and_returns() {
    let mut storage = new_storage(TornWord::Zeros, 1);
    storage.load(RIG, None);
    storage.append(&entry(1));
    storage.store(record(1)).unwrap();
    storage.store_parameters(&parameters(7));
    let (mut outcomes, mut steps) = (Vec::new(), 0);
    while storage.is_working() {
        let before = storage.flash().operations();
        outcomes.extend(storage.go_on());
        assert!(storage.flash().operations() <= before + 1);
        steps += 1;
    }
    assert_eq!(outcomes, [Stored::Journal(Ok(())), Stored::Record(Ok(())), Stored::Parameters(Ok(()))]);
    // 2 words of the journal; 80 words, a commit word and 2 pages; 190 words, a commit word and 2 pages
    assert_eq!(storage.flash().operations(), 2 + 83 + 193);
    assert!(steps > storage.flash().operations(), "{steps} steps");
    assert_eq!(found(&storage), (Some(1), Some(1), Some(7)));
}

/// An entry that was given behind a record says that its centre is trusted: it never comes before it.
#[test]
fn the_journal_never_runs_ahead_of_the_record() {
    for torn in TornWord::ALL {
        let mut before = new_storage(torn, 3);
        before.load(RIG, None);
        before.append(&entry(1));
        before.store(record(1)).unwrap();
        before.finish().unwrap();
        let operations = before.flash().operations();
        for cut in 0..85 {
            let mut flash = before.flash().fork(cut.into());
            flash.cut_after(cut);
            let mut storage = Storage::new(flash, 0);
            storage.store(record(2)).unwrap();
            storage.append(&entry(2));
            let finished = storage.finish();
            assert_eq!(storage.flash().operations() - operations, cut + 1, "{finished:?}");
            let (centre, journal, _) = found(&storage);
            assert!(centre.is_some(), "{torn:?}, cut {cut}");
            assert!(journal == Some(1) || (journal, centre) == (Some(2), Some(2)), "{torn:?}, cut {cut}");
        }
    }
}

/// Given before a record, it goes first.
#[test]
fn an_entry_goes_first_when_it_was_given_first() {
    let mut storage = new_storage(TornWord::Zeros, 1);
    storage.append(&entry(1));
    storage.store(record(1)).unwrap();
    while storage.flash().operations() < 2 {
        storage.go_on();
    }
    assert_eq!(found(&storage), (None, Some(1), None));
}

/// A second record comes before the first one is stored, at any moment: one of the three is there, whatever is cut.
#[test]
fn a_record_may_overtake_another() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut cuts = 0;
    for torn in TornWord::ALL {
        for _ in 0..400 {
            let mut before = new_storage(torn, random.random());
            before.store(record(1)).unwrap();
            before.finish().unwrap();
            let mut flash = before.flash().fork(random.random());
            flash.cut_after(random.random_range(0..90));
            let mut storage = Storage::new(flash, 0);
            storage.store(record(2)).unwrap();
            for _ in 0..random.random_range(0..110) {
                storage.go_on();
            }
            storage.store(record(3)).unwrap();
            let stored = storage.finish().is_ok() && !storage.flash().is_off();
            cuts += u32::from(storage.flash().is_off());
            let (centre, ..) = found(&storage);
            assert!(matches!(centre, Some(1..=3)), "{centre:?}");
            assert!(!stored || centre == Some(3), "{centre:?}");
        }
    }
    assert!(cuts > 400, "{cuts} cuts");
}

#[test]
fn erasing_the_record_leaves_the_rest() {
    let mut storage = new_storage(TornWord::Zeros, 1);
    storage.store(record(1)).unwrap();
    storage.append(&entry(1));
    storage.store_parameters(&parameters(7));
    storage.finish().unwrap();
    storage.erase_record();
    assert_eq!(storage.finish(), Ok(()));
    assert_eq!(found(&storage), (None, Some(1), Some(7)));
    storage.store(record(2)).unwrap();
    assert_eq!(storage.finish(), Ok(()));
    assert_eq!(found(&storage).0, Some(2));
}

/// However often writing fails, the last entry that was completed is never erased.
#[test]
fn a_page_that_refuses_costs_no_entry() {
    for (defect, error) in [
        (Defect::RefusingWrites, StoreError::WriteRefused),
        (Defect::Protected, StoreError::EraseRefused),
        (Defect::NotWriting, StoreError::ReadBackDiffers),
    ] {
        let mut flash = MockFlash::new(2, TornWord::Zeros, 1);
        // the first page holds 128 entries
        flash.spoil(1, defect);
        let mut journal = Journal::new(flash, 0);
        for run_id in 1..=128 {
            journal.append(&entry(run_id)).unwrap();
        }
        for _ in 0..(PAGE_LEN / 16 * 3) {
            assert_eq!(journal.append(&entry(129)), Err(error));
            assert_eq!(journal.last().map(|entry| entry.run_id), Some(128), "{defect:?}");
        }
    }
}
