//! The centre in use, kept across power-down: one record, two pages of flash, never a wrong one.
//!
//! ```text
//! page, 2 KiB on the drive board
//! ┌──────────────────────────────────────┬───────────────────┬─────────────┐
//! │ image of the record, CRC at its end  │ erased            │ commit word │
//! └──────────────────────────────────────┴───────────────────┴─────────────┘
//! ```
//!
//! To store: erase the page that does not hold the record, write the image, read it back, write the commit word, erase
//! the page that did hold it. So at every instant one page holds a record that nothing is being done to, and at rest
//! there is exactly one. What a power cut can leave, and why it is read rightly:
//!
//! | cut while | the page at work | the other page | read at power-up |
//! |---|---|---|---|
//! | erasing | anything | the old record | the old record |
//! | writing the image | no commit word | the old record | the old record |
//! | writing the commit word | image whole, commit word anything | the old record | one of the two |
//! | erasing the old record | anything | the new record, committed | the new record |
//!
//! The commit word is what makes this hold for words that read differently each time: an image whose last word is torn
//! may pass its CRC once and not again, but it has no commit word, and gives way to one that has. At power-up whatever
//! was interrupted is finished: what does not count is erased, and a record that counts without a commit word is
//! written anew.
//!
//! The old record is erased, and not kept in reserve, on purpose: should the new one rot, the device starts without a
//! centre, not with that of somebody who was calibrated before.
//!
//! Nobody waits for the flash: [`Storage::go_on`] starts an erase or the writing of one word, or looks at a piece of what
//! was written, and returns. An erase takes 22 ms, in which the board samples, answers and sends its heartbeat.
//!
//! [`Record`] is what is kept of a ball, [`HingeRecord`] of a hinge, [`image`] its bytes, [`RecordStore`] the two pages, [`Storage`] all that a board keeps.

mod bytes;
mod content;
mod erasure;
mod error;
mod flash;
mod hinge_content;
mod hinge_image;
pub mod image;
mod journal;
mod journal_entry;
mod journal_pages;
mod loaded;
mod page;
mod parameter_store;
mod replacement;
mod sealed;
mod storage;
mod store;
mod stored;
mod two_pages;

pub use content::{Record, Unfit};
pub use error::{LoadError, StoreError};
pub use flash::PageFlash;
pub use hinge_content::{HINGE_PACKED, HingeRecord, JointRecord};
pub use image::IMAGE_LEN;
pub use journal::Journal;
pub use journal_entry::JournalEntry;
pub use loaded::Loaded;
pub use parameter_store::ParameterStore;
pub use storage::{STORAGE_PAGES, Storage};
pub use store::RecordStore;
pub use stored::Stored;
