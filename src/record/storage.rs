//! The board's storage: six pages of flash, two each for the record, the journal and the parameters.
//!
//! What is to be stored is given to it and then happens a step at a time with each [`Storage::go_on`], one thing after the
//! other: first the journal, then the record, then the parameters.

use super::erasure::Erasure;
use super::error::{LoadError, StoreError};
use super::flash::PageFlash;
use super::hinge_content::JointRecord;
use super::image::{self, IMAGE_LEN, Image};
use super::journal_entry::JournalEntry;
use super::journal_pages::{Appending, JournalPages};
use super::loaded::Loaded;
use super::parameter_store::{self, PARAMETER_IMAGE_LEN, ParameterImage, ParameterPages};
use super::replacement::Replacement;
use super::store::{self, RecordPages};
use super::stored::Stored;
use super::two_pages::TwoPages;
use crate::parameters::{Config, ParameterSet};
use crate::restart::Restart;

/// Pages of flash that the storage takes.
pub const STORAGE_PAGES: usize = 6;

/// The storage in six pages of a flash whose erased bytes read 0xFF.
#[derive(Debug)]
pub struct Storage<F> {
    flash: F,
    record_pages: RecordPages,
    journal_pages: JournalPages,
    parameter_pages: ParameterPages,
    /// What is to be done with the record.
    record: Option<RecordWork>,
    parameters: Option<Replacement<ParameterImage, PARAMETER_IMAGE_LEN>>,
    /// The newest entry: one that has not been begun yet has nothing to say beside it.
    entry: Option<JournalEntry>,
    /// An entry that was given while a record waits, which it may be about: it goes behind.
    entry_behind_record: Option<JournalEntry>,
    under_way: UnderWay,
}

/// What may happen to the record's pages.
#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "there is no heap to put the image on, and there is one of it")]
enum RecordWork {
    Replace(Replacement<Image, IMAGE_LEN>),
    Erase(Erasure<IMAGE_LEN>),
}

/// Whose turn it is.
#[derive(Debug)]
enum UnderWay {
    Nothing,
    Journal(Appending),
    Record,
    Parameters,
}

impl<F: PageFlash> Storage<F> {
    /// Bytes of flash that the storage takes.
    pub const LEN: usize = STORAGE_PAGES * F::ERASE_SIZE;

    /// The storage in the six pages from the byte `from` of the flash on, a multiple of the page size.
    pub const fn new(flash: F, from: u32) -> Self {
        let page = F::ERASE_SIZE as u32;
        Self {
            flash,
            record_pages: TwoPages::new::<F>(from, image::MAGIC),
            journal_pages: JournalPages::new::<F>(from + 2 * page),
            parameter_pages: parameter_store::pages::<F>(from + 4 * page),
            record: None,
            parameters: None,
            entry: None,
            entry_behind_record: None,
            under_way: UnderWay::Nothing,
        }
    }

    /// What is there for the rig with this fingerprint, at power-up: what a power cut left unfinished is finished first.
    /// `parameters`: what became of the stored parameters.
    pub fn load(&mut self, rig: u32, parameters: Option<LoadError>) -> Loaded {
        let record = store::load(&mut self.record_pages, &mut self.flash, rig);
        Loaded { record, journal: self.journal_pages.last(&mut self.flash), parameters }
    }

    /// The stored parameters, at power-up.
    ///
    /// # Errors
    /// [`LoadError`].
    pub fn load_parameters(&mut self) -> Result<ParameterSet, LoadError> {
        parameter_store::load(&mut self.parameter_pages, &mut self.flash)
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

    /// Has the record replaced. One that was on its way is given up.
    ///
    /// # Errors
    /// [`StoreError::Unfit`]: then nothing is done.
    pub fn store(&mut self, record: impl Into<JointRecord>) -> Result<(), StoreError> {
        let record = record.into();
        record.check().map_err(|_| StoreError::Unfit)?;
        let replacement = self.record_pages.begin(&mut self.flash, |sequence| store::image_of(&record, sequence));
        self.record = Some(RecordWork::Replace(replacement));
        Ok(())
    }

    /// Has the record erased. One that was on its way is given up.
    pub fn erase_record(&mut self) {
        self.record = Some(RecordWork::Erase(self.record_pages.begin_erasure(&mut self.flash)));
    }

    /// Has the stored parameters replaced. Others that were on their way are given up.
    pub fn store_parameters(&mut self, set: &ParameterSet) {
        let image = |sequence| ParameterImage { set: *set, sequence };
        self.parameters = Some(self.parameter_pages.begin(&mut self.flash, image));
    }

    /// Has the journal go on with this entry.
    pub fn append(&mut self, entry: &JournalEntry) {
        let place = if self.record.is_some() { &mut self.entry_behind_record } else { &mut self.entry };
        *place = Some(*entry);
    }

    /// Does the next step of what is to be stored: starts an erase or the writing of one word, or looks how it went. Says
    /// what is done with.
    pub fn go_on(&mut self) -> Option<Stored> {
        let Self { flash, record_pages, journal_pages, parameter_pages, record, parameters, .. } = self;
        let outcome = match (&mut self.under_way, record, parameters) {
            (UnderWay::Journal(appending), _, _) => done(journal_pages.go_on(flash, appending)).map(Stored::Journal),
            (UnderWay::Record, Some(RecordWork::Replace(replacement)), _) => {
                done(record_pages.go_on(flash, replacement)).map(Stored::Record)
            }
            (UnderWay::Record, Some(RecordWork::Erase(erasure)), _) => {
                done(record_pages.go_on_erasing(flash, erasure)).map(Stored::Erased)
            }
            (UnderWay::Parameters, _, Some(replacement)) => {
                done(parameter_pages.go_on(flash, replacement)).map(Stored::Parameters)
            }
            (UnderWay::Nothing | UnderWay::Record | UnderWay::Parameters, _, _) => {
                self.begin_next();
                None
            }
        };
        if let Some(outcome) = outcome {
            self.under_way = UnderWay::Nothing;
            match outcome {
                Stored::Record(_) | Stored::Erased(_) => {
                    self.record = None;
                    self.entry = self.entry_behind_record.take();
                }
                Stored::Parameters(_) => self.parameters = None,
                Stored::Journal(_) => {}
            }
        }
        outcome
    }

    fn begin_next(&mut self) {
        self.under_way = if let Some(entry) = self.entry.take() {
            UnderWay::Journal(self.journal_pages.begin(&mut self.flash, &entry))
        } else if self.record.is_some() {
            UnderWay::Record
        } else if self.parameters.is_some() {
            UnderWay::Parameters
        } else {
            UnderWay::Nothing
        };
    }

    /// Record or parameters are on their way, and not safe yet. Whoever waits with the next command until they are can rely
    /// on them when it is answered.
    pub const fn is_storing(&self) -> bool {
        self.record.is_some() || self.parameters.is_some()
    }

    /// There is something to be done at once, and not only when an erase is over: [`go_on`](Self::go_on) as soon as there is
    /// time.
    pub fn is_quick(&self) -> bool {
        match (&self.under_way, &self.record, &self.parameters) {
            (UnderWay::Nothing, record, parameters) => self.entry.is_some() || record.is_some() || parameters.is_some(),
            (UnderWay::Journal(appending), _, _) => appending.is_quick(),
            (UnderWay::Record, Some(RecordWork::Replace(replacement)), _) => replacement.is_quick(),
            (UnderWay::Parameters, _, Some(replacement)) => replacement.is_quick(),
            (UnderWay::Record | UnderWay::Parameters, _, _) => false,
        }
    }

    /// Something is on its way, or waits.
    pub fn is_working(&self) -> bool {
        !matches!(self.under_way, UnderWay::Nothing) || self.is_quick()
    }

    /// Goes on until everything is stored; the first thing that went wrong. A board does not wait so long.
    ///
    /// # Errors
    /// [`StoreError`].
    pub fn finish(&mut self) -> Result<(), StoreError> {
        let mut result = Ok(());
        while self.is_working() {
            if let Some(
                Stored::Record(this) | Stored::Erased(this) | Stored::Parameters(this) | Stored::Journal(this),
            ) = self.go_on()
            {
                result = result.and(this);
            }
        }
        result
    }

    /// The flash, to look at.
    pub const fn flash(&self) -> &F {
        &self.flash
    }
}

/// Whether it is over, and how it went.
fn done<E: Into<StoreError>>(progress: Result<bool, E>) -> Option<Result<(), StoreError>> {
    match progress {
        Ok(false) => None,
        Ok(true) => Some(Ok(())),
        Err(error) => Some(Err(error.into())),
    }
}
