//! Numbers and lists as JSON.

use std::fmt::{Display, Write};

/// A number; what is none becomes null.
pub fn number(number: f64) -> String {
    if number.is_finite() { number.to_string() } else { "null".to_owned() }
}

/// A list of numbers. Singles keep their own shortest digits: read as a single again they are the same to the bit.
pub fn list<'a>(numbers: impl IntoIterator<Item = &'a f32>) -> String {
    join(numbers.into_iter().map(|number| if number.is_finite() { number.to_string() } else { "null".to_owned() }))
}

/// A list of what is JSON already.
pub fn join<T: Display>(items: impl IntoIterator<Item = T>) -> String {
    let mut text = String::from("[");
    for (index, item) in items.into_iter().enumerate() {
        let comma = if index == 0 { "" } else { "," };
        let _ = write!(text, "{comma}{item}");
    }
    text + "]"
}

/// A text between quotation marks. The library's texts hold neither quotation marks nor backslashes.
pub fn text(text: &str) -> String {
    format!("\"{}\"", text.replace(['"', '\\'], "'"))
}
