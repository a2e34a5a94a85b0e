//! The board's storage: six pages of flash, two each for the record, the journal and the parameters.

use super::content::Record;
use super::error::{LoadError, StoreError};
use super::journal::{Journal, JournalEntry};
use super::loaded::Loaded;
use super::parameter_store::ParameterStore;
use super::store::RecordStore;
use crate::parameters::Config;
use crate::parameters::ParameterSet;
use crate::restart::Restart;
use embedded_storage::nor_flash::NorFlash;

/// Pages of flash that the storage takes.
pub const STORAGE_PAGES: usize = 6;

/// The storage in six pages of a flash whose erased bytes read 0xFF.
#[derive(Debug)]
pub struct Storage<F> {
    flash: F,
    from: u32,
}

impl<F: NorFlash> Storage<F> {
    /// Bytes of flash that the storage takes.
    pub const LEN: usize = STORAGE_PAGES * F::ERASE_SIZE;

    /// The storage in the six pages from the byte `from` of the flash on, a multiple of the page size.
    pub const fn new(flash: F, from: u32) -> Self {
        Self { flash, from }
    }

    /// What is there for the rig with this fingerprint. `parameters`: what became of the stored parameters.
    pub fn load(&mut self, rig: u32, parameters: Option<LoadError>) -> Loaded {
        Loaded { record: self.record().load(rig), journal: self.journal().last(), parameters }
    }

    /// The stored parameters.
    ///
    /// # Errors
    /// [`LoadError`].
    pub fn load_parameters(&mut self) -> Result<ParameterSet, LoadError> {
        self.parameters().load()
    }

    /// Replaces the stored parameters.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn store_parameters(&mut self, set: &ParameterSet) -> Result<(), StoreError> {
        self.parameters().store(set)
    }

    /// Erases the record.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn erase_record(&mut self) -> Result<(), StoreError> {
        self.record().erase()
    }

    /// The machine that the stored parameters make, or the default one when they cannot be used, and why not. None if not
    /// even the default one can be made, which a test rules out.
    // A frame of its own: 6 KB that are free again when the device is built (`cargo stack --ways`).
    #[inline(never)]
    pub fn config(&mut self, restart: Restart, serial: u32) -> Option<(Config, Option<LoadError>)> {
        let (set, why_not) = match self.load_parameters() {
            Ok(set) => (set, None),
            Err(LoadError::Nothing) => (ParameterSet::new(), None),
            Err(error) => (ParameterSet::new(), Some(error)),
        };
        match set.config(restart, serial) {
            Ok(config) => Some((config, why_not)),
            Err(_) => Some((ParameterSet::new().config(restart, serial).ok()?, Some(LoadError::Unfit))),
        }
    }

    /// Replaces the record.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn store(&mut self, record: &Record) -> Result<(), StoreError> {
        self.record().store(record)
    }

    /// Appends to the journal.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn append(&mut self, entry: &JournalEntry) -> Result<(), StoreError> {
        self.journal().append(entry)
    }

    /// The flash, to look at.
    pub const fn flash(&self) -> &F {
        &self.flash
    }

    fn page(&self, index: usize) -> u32 {
        self.from + (index * F::ERASE_SIZE) as u32
    }

    fn record(&mut self) -> RecordStore<&mut F> {
        let from = self.page(0);
        RecordStore::new(&mut self.flash, from)
    }

    fn parameters(&mut self) -> ParameterStore<&mut F> {
        let from = self.page(4);
        ParameterStore::new(&mut self.flash, from)
    }

    fn journal(&mut self) -> Journal<&mut F> {
        let from = self.page(2);
        Journal::new(&mut self.flash, from)
    }
}
