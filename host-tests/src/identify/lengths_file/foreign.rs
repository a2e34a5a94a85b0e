//! Files that hold no lengths as they are, but can be turned into ones that do.

/// A recording of the bus that another program reads, by its first bytes; None for anything else.
pub(super) fn kind(bytes: &[u8]) -> Option<&'static str> {
    let text_starts = |start: &str| bytes.get(..start.len()).is_some_and(|b| b.eq_ignore_ascii_case(start.as_bytes()));
    if bytes.starts_with(b"LOGG") {
        Some("a BLF recording")
    } else if text_starts(";$FILEVERSION") {
        Some("a TRC recording")
    } else if text_starts("date ") {
        Some("an ASC recording")
    } else if text_starts("timestamp,arbitration_id,") {
        Some("python-can's CSV recording")
    } else if bytes.starts_with(b"PK\x03\x04") {
        Some("a spreadsheet or an archive")
    } else if bytes.starts_with(b"SQLite format 3\0") {
        Some("a database")
    } else {
        None
    }
}

/// What to do about it.
pub(super) fn complaint(kind: &str, file: &str) -> String {
    match kind {
        "a spreadsheet or an archive" => format!("this is {kind}; save the table as CSV"),
        _ => format!("this is {kind}; `python -m glenoid poses {file}` makes a CSV of its poses"),
    }
}
