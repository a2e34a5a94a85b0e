//! The store under test, and two that must fail: a harness that lets everything pass proves nothing.

use super::STORE_FROM;
use crate::flash::{MockFlash, PAGE_LEN};
use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use glenoid::record::image::{self, Header, Image};
use glenoid::record::{IMAGE_LEN, Record, RecordStore};

/// A way to keep a record in flash.
pub trait Scheme: Clone + Default {
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
