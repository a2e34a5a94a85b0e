//! What the board finds in its flash at power-up.

use super::content::Record;
use super::error::LoadError;
use super::hinge_content::JointRecord;
use super::journal_entry::JournalEntry;

/// Everything that was kept across power-down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Loaded {
    /// The centre in use, or why there is none.
    pub record: Result<JointRecord, LoadError>,
    /// The last entry of the journal; None on a new board.
    pub journal: Option<JournalEntry>,
    /// Why the stored parameters are not in use; None when they are, or when none were ever stored.
    pub parameters: Option<LoadError>,
}

impl From<Result<Record, LoadError>> for Loaded {
    /// A record without a journal and without stored parameters.
    fn from(record: Result<Record, LoadError>) -> Self {
        Self { record: record.map(JointRecord::Ball), journal: None, parameters: None }
    }
}
