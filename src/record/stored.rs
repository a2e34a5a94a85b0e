//! How storing went.

use super::error::StoreError;

/// Something that was to be stored is done with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stored {
    /// The record was replaced, or why not.
    Record(Result<(), StoreError>),
    /// The record was erased, or why not.
    Erased(Result<(), StoreError>),
    /// The parameters were replaced, or why not.
    Parameters(Result<(), StoreError>),
    /// The journal was written, or why not.
    Journal(Result<(), StoreError>),
}
