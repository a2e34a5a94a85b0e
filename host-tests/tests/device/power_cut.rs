//! The record store with the power cut in every flash operation. `cargo power-cut` does the same over far more histories.

use embedded_storage::nor_flash::ReadNorFlash;
use glenoid::record::{LoadError, RecordStore, StoreError, image};
use host_tests::flash::{Defect, MockFlash, PAGE_LEN, TornWord};
use host_tests::power_cut::{
    Entries, OnePage, PAGES, ParameterPages, RIG, STORE_FROM, Scheme, Tally, TwoPages, WithoutCommit, cut_everywhere,
    random_life, record,
};

fn store(flash: &mut MockFlash) -> RecordStore<&mut MockFlash> {
    RecordStore::new(flash, STORE_FROM)
}

fn new_flash() -> MockFlash {
    MockFlash::new(PAGES, TornWord::Zeros, 1)
}

fn cut<S: Scheme>(torn: TornWord) -> Tally {
    let mut tally = Tally::default();
    (1..=4).for_each(|seed| tally += cut_everywhere::<S>(torn, seed));
    tally += random_life::<S>(torn, 1, 300);
    tally
}

#[test]
fn no_cut_loses_a_record_or_makes_a_wrong_one() {
    for torn in TornWord::ALL {
        let tally = cut::<TwoPages>(torn);
        assert_eq!(tally.failures(), 0, "{torn:?}: {tally}");
        assert!(tally.cuts() > 4_000, "{torn:?}: {tally}");
    }
}

#[test]
fn no_cut_loses_parameters_or_mixes_two_sets() {
    for torn in TornWord::ALL {
        let tally = cut::<ParameterPages>(torn);
        assert_eq!(tally.failures(), 0, "{torn:?}: {tally}");
        assert!(tally.cuts() > 4_000, "{torn:?}: {tally}");
    }
}

/// Boots and runs are counted on, whatever is cut: no number that was noted is ever forgotten.
#[test]
fn no_cut_makes_the_journal_go_back() {
    for torn in TornWord::ALL {
        let mut tally = cut::<Entries>(torn);
        // an entry has two words: many histories see every order of cuts, and pages that fill up
        (5..=400).for_each(|seed| tally += cut_everywhere::<Entries>(torn, seed));
        (2..=20).for_each(|seed| tally += random_life::<Entries>(torn, seed, 300));
        assert_eq!(tally.failures(), 0, "{torn:?}: {tally}");
        assert!(tally.cuts() > 4_000, "{torn:?}: {tally}");
    }
}

#[test]
fn the_harness_finds_that_one_page_is_not_enough() {
    for torn in TornWord::ALL {
        let tally = cut::<OnePage>(torn);
        assert!(tally.lost > tally.cuts() / 2, "{torn:?}: {tally}");
    }
}

#[test]
fn the_harness_finds_that_the_commit_word_is_needed() {
    assert!((1..=40).any(|seed| cut_everywhere::<WithoutCommit>(TornWord::Unsteady, seed).lost > 0));
}

#[test]
fn a_new_board_has_no_record() {
    assert_eq!(store(&mut new_flash()).load(RIG), Err(LoadError::Nothing));
}

#[test]
fn the_newest_record_counts_and_stands_alone() {
    let mut flash = new_flash();
    for number in 1..=7 {
        store(&mut flash).store(&record(number)).unwrap();
        assert_eq!(store(&mut flash).load(RIG), Ok(record(number)));
    }
    let mut first_page = [0; PAGE_LEN];
    flash.read(0, &mut first_page).unwrap();
    assert_eq!(first_page, [0xFF; PAGE_LEN], "the pages of others are untouched");
    let mut pages = [[0; PAGE_LEN]; 2];
    flash.read(STORE_FROM, pages.as_flattened_mut()).unwrap();
    let blank = pages.iter().filter(|page| **page == [0xFF; PAGE_LEN]).count();
    assert_eq!(blank, 1, "no older record is kept");
}

/// The sequence number wraps after 2³² stores; here it begins just before.
#[test]
fn the_sequence_may_wrap() {
    use embedded_storage::nor_flash::NorFlash;
    let mut flash = new_flash();
    flash.write(STORE_FROM, &image::encode(&record(1), u32::MAX)).unwrap();
    for number in 2..6 {
        store(&mut flash).store(&record(number)).unwrap();
        assert_eq!(store(&mut flash).load(RIG), Ok(record(number)));
    }
}

#[test]
fn another_rig_is_refused_by_name() {
    let mut flash = new_flash();
    store(&mut flash).store(&record(1)).unwrap();
    assert_eq!(store(&mut flash).load(RIG + 1), Err(LoadError::OtherRig));
    assert_eq!(store(&mut flash).load(RIG), Ok(record(1)), "a refusal destroys nothing");
}

/// An image of another version with a CRC that is right, as other firmware would leave it.
fn of_version(version: u16) -> image::Image {
    let mut image = image::encode(&record(1), 1);
    image[4..6].copy_from_slice(&version.to_le_bytes());
    let mut crc = crc32fast::Hasher::new();
    crc.update(b"\xA5gle");
    let end = image.len() - 4;
    crc.update(&image[..end]);
    image[end..].copy_from_slice(&crc.finalize().to_le_bytes());
    image
}

#[test]
fn other_versions_are_refused_by_name() {
    use embedded_storage::nor_flash::NorFlash;
    for (version, expected) in [
        (0, Err(LoadError::OlderVersion)),
        (2, Err(LoadError::OlderVersion)),
        (3, Ok(record(1))),
        // an elbow's, which these numbers are not
        (4, Err(LoadError::Unfit)),
        (5, Err(LoadError::FromTheFuture)),
        (u16::MAX, Err(LoadError::FromTheFuture)),
    ] {
        let mut flash = new_flash();
        flash.write(STORE_FROM, &of_version(version)).unwrap();
        assert_eq!(store(&mut flash).load(RIG), expected, "version {version}");
        // the next calibration replaces it all the same
        store(&mut flash).store(&record(2)).unwrap();
        assert_eq!(store(&mut flash).load(RIG), Ok(record(2)));
    }
}

/// A record that rots is refused, wherever it rots; the one before it is never found in its stead.
#[test]
fn a_rotten_record_is_refused_by_name() {
    for at in 0..image::encode(&record(1), 1).len() {
        let mut flash = new_flash();
        store(&mut flash).store(&record(1)).unwrap();
        store(&mut flash).store(&record(2)).unwrap();
        let page = (1..PAGES)
            .map(|page| page * PAGE_LEN)
            .find(|from| {
                let mut byte = [0];
                flash.read(*from as u32, &mut byte).unwrap();
                byte != [0xFF]
            })
            .unwrap();
        flash.flip(page + at, 0x10);
        assert_eq!(store(&mut flash).load(RIG), Err(LoadError::Damaged), "byte {at}");
        store(&mut flash).store(&record(3)).unwrap();
        assert_eq!(store(&mut flash).load(RIG), Ok(record(3)));
    }
}

#[test]
fn worn_and_protected_flash_is_named_and_the_old_record_stays() {
    for (defect, expected) in [
        (Defect::Protected, StoreError::EraseRefused),
        (Defect::NotErasing, StoreError::EraseIncomplete),
        (Defect::RefusingWrites, StoreError::WriteRefused),
        (Defect::NotWriting, StoreError::ReadBackDiffers),
    ] {
        for page in [1, 2] {
            let mut flash = new_flash();
            flash.spoil(page, defect);
            // of two stores one is bound to need the page
            let results: Vec<_> = [1, 2].map(|number| store(&mut flash).store(&record(number))).into();
            assert!(results.contains(&Err(expected)), "{defect:?} on page {page}: {results:?}");
            let last = results.iter().rposition(Result::is_ok);
            let expected = last.map(|index| record(index as u16 + 1)).ok_or(match defect {
                // what the worn page holds is neither erased nor a record
                Defect::NotErasing | Defect::NotWriting => LoadError::Damaged,
                _ => LoadError::Nothing,
            });
            assert_eq!(store(&mut flash).load(RIG), expected, "{defect:?} on page {page}: {results:?}");
        }
    }
}

#[test]
fn a_record_without_sense_is_neither_stored_nor_loaded() {
    use embedded_storage::nor_flash::NorFlash;
    let mut spoilt = record(1);
    spoilt.parameters.centre_mm.x = f32::NAN;
    let mut flash = new_flash();
    assert_eq!(store(&mut flash).store(&spoilt), Err(StoreError::Unfit));
    flash.write(STORE_FROM, &image::encode(&spoilt, 1)).unwrap();
    assert_eq!(store(&mut flash).load(RIG), Err(LoadError::Unfit));
}

#[test]
fn codes_never_change() {
    use {LoadError as L, StoreError as S};
    let load = [
        L::Nothing,
        L::Unreadable,
        L::Damaged,
        L::OlderVersion,
        L::FromTheFuture,
        L::OtherRig,
        L::Unfit,
        L::FlashLayout,
    ];
    let store = [S::Unfit, S::EraseRefused, S::EraseIncomplete, S::WriteRefused, S::ReadBackDiffers, S::FlashLayout];
    assert_eq!(load.map(L::code), [1, 2, 3, 4, 5, 6, 7, 8]);
    assert_eq!(store.map(S::code), [16, 17, 18, 19, 20, 21]);
}
