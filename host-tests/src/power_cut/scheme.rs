//! The store under test, and two that must fail: a harness that lets everything pass proves nothing.

use super::STORE_FROM;
use crate::flash::{MockFlash, PAGE_LEN};
use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use glenoid::parameters::{Key, ParameterSet, TABLE};
use glenoid::record::image::{self, Header, Image};
use glenoid::record::{IMAGE_LEN, Journal, JournalEntry, ParameterStore, Record, RecordStore};

/// A way to keep a record in flash.
pub trait Scheme: Clone + Default {
    /// Cuts in the recovery from each cut of a store: all of them, unless a store has so many words that all pairs would
    /// take hours; then so many, by chance.
    const SECOND_CUTS: usize = usize::MAX;
    /// The record, if there is one.
    fn load(&mut self, flash: &mut MockFlash, rig: u32) -> Option<Record>;
    /// Replaces the record; true when that worked.
    fn store(&mut self, flash: &mut MockFlash, record: &Record) -> bool;
}

/// The firmware's.
#[derive(Debug, Clone, Copy, Default)]
pub struct TwoPages;

impl Scheme for TwoPages {
    fn load(&mut self, flash: &mut MockFlash, rig: u32) -> Option<Record> {
        RecordStore::new(flash, STORE_FROM).load(rig).ok()
    }

    fn store(&mut self, flash: &mut MockFlash, record: &Record) -> bool {
        RecordStore::new(flash, STORE_FROM).store(record).is_ok()
    }
}

/// The firmware's store of the parameters: a set whose values follow from the record's number stands for the record.
#[derive(Debug, Clone, Copy, Default)]
pub struct ParameterPages;

impl ParameterPages {
    /// The set with this number: every value that may be any integer is it.
    fn set(number: u16) -> ParameterSet {
        let mut set = ParameterSet::new();
        for entry in TABLE.iter().filter(|entry| entry.maximum == u32::MAX) {
            set.set_bits(entry.index, number.into()).expect("any integer is in range");
        }
        set
    }
}

impl Scheme for ParameterPages {
    const SECOND_CUTS: usize = 8;

    fn load(&mut self, flash: &mut MockFlash, _: u32) -> Option<Record> {
        let set = ParameterStore::new(flash, STORE_FROM).load().ok()?;
        let number = set.integer(Key::LockKey1) as u16;
        // a mixture of two sets is none of them; number 0 was never stored
        Some(super::record(if set == Self::set(number) { number } else { 0 }))
    }

    fn store(&mut self, flash: &mut MockFlash, record: &Record) -> bool {
        ParameterStore::new(flash, STORE_FROM).store(&Self::set(record.run_id)).is_ok()
    }
}

/// The firmware's journal. The run is the record's number; the boot counts the power-ups, each of which is noted before
/// anybody learns of it, as the device does.
#[derive(Debug, Clone, Copy, Default)]
pub struct Entries {
    /// The last boot that was noted, whole.
    noted: u32,
}

impl Scheme for Entries {
    fn load(&mut self, flash: &mut MockFlash, _: u32) -> Option<Record> {
        let mut journal = Journal::new(flash, STORE_FROM);
        let entry = journal.last()?;
        let boot = entry.boot + 1;
        journal.append(&JournalEntry { boot, ..entry }).ok()?;
        // a boot that was there before is wrong: run 0 was never stored
        let run_id = if boot > self.noted { entry.run_id } else { 0 };
        self.noted = boot;
        Some(super::record(run_id))
    }

    fn store(&mut self, flash: &mut MockFlash, record: &Record) -> bool {
        let entry = JournalEntry { boot: self.noted, run_id: record.run_id, distrust: 0 };
        Journal::new(flash, STORE_FROM).append(&entry).is_ok()
    }
}

/// One page, erased and written in place.
#[derive(Debug, Clone, Copy, Default)]
pub struct OnePage;

impl Scheme for OnePage {
    fn load(&mut self, flash: &mut MockFlash, _: u32) -> Option<Record> {
        read(flash, 0).map(|(image, _)| image::decode(&image))
    }

    fn store(&mut self, flash: &mut MockFlash, record: &Record) -> bool {
        write(flash, 0, &image::encode(record, 1))
    }
}

/// Two pages in turn, the newer sound one counts, the older one is erased: everything but the commit word.
#[derive(Debug, Clone, Copy, Default)]
pub struct WithoutCommit;

impl Scheme for WithoutCommit {
    fn load(&mut self, flash: &mut MockFlash, _: u32) -> Option<Record> {
        let (page, image, _) = newest(flash)?;
        let _ = erase(flash, 1 - page);
        Some(image::decode(&image))
    }

    fn store(&mut self, flash: &mut MockFlash, record: &Record) -> bool {
        let (page, sequence) = newest(flash).map_or((1, 0), |(page, _, header)| (page, header.sequence));
        write(flash, 1 - page, &image::encode(record, sequence + 1)) && erase(flash, page)
    }
}

fn newest(flash: &mut MockFlash) -> Option<(u32, Image, Header)> {
    [0, 1]
        .into_iter()
        .filter_map(|page| read(flash, page).map(|(image, header)| (page, image, header)))
        .max_by_key(|(_, _, header)| header.sequence)
}

fn read(flash: &mut MockFlash, page: u32) -> Option<(Image, Header)> {
    let mut image = [0; IMAGE_LEN];
    flash.read(from(page), &mut image).ok()?;
    image::header(&image).ok().map(|header| (image, header))
}

fn write(flash: &mut MockFlash, page: u32, image: &Image) -> bool {
    erase(flash, page) && flash.write(from(page), image).is_ok()
}

fn erase(flash: &mut MockFlash, page: u32) -> bool {
    flash.erase(from(page), from(page + 1)).is_ok()
}

fn from(page: u32) -> u32 {
    STORE_FROM + page * PAGE_LEN as u32
}
