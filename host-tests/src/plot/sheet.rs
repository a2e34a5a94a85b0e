//! What a figure can be painted on.

use super::palette::Colour;

/// A surface that takes outlines and text, in CSS pixels, x to the right and y downwards.
pub trait Sheet {
    /// A path through `points`: filled, stroked, or both. `closed` joins the last point to the first.
    fn path(&mut self, points: &[(f32, f32)], closed: bool, fill: Option<Colour>, stroke: Option<Stroke>);

    /// A circle of `radius` about `centre`.
    fn circle(&mut self, centre: (f32, f32), radius: f32, fill: Option<Colour>, stroke: Option<Stroke>);

    /// One line of text. `at` is its anchor, on the line midway between the baseline and the top of the capitals.
    fn text(&mut self, at: (f32, f32), text: &str, lettering: Lettering);
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    /// Colour of the line.
    pub colour: Colour,
    /// Width, CSS pixels.
    pub width: f32,
    /// Lengths of stroke and gap in turn, CSS pixels; empty for a solid line.
    pub dash: &'static [f32],
}

impl Stroke {
    /// A solid line.
    pub const fn solid(colour: Colour, width: f32) -> Self {
        Self { colour, width, dash: &[] }
    }
}

/// Which end of a text its anchor is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// The text begins at the anchor.
    Start,
    /// The text is centred on the anchor.
    Middle,
    /// The text ends at the anchor.
    End,
}

/// How a text is set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lettering {
    /// Size of the em, CSS pixels.
    pub size: f32,
    /// Bold instead of regular.
    pub bold: bool,
    /// Colour of the letters.
    pub colour: Colour,
    /// Where the anchor lies along the text.
    pub anchor: Anchor,
    /// Reads from bottom to top instead of from left to right.
    pub upwards: bool,
}

impl Lettering {
    /// Regular letters of `size` CSS pixels in the ink colour.
    pub const fn regular(size: f32, anchor: Anchor) -> Self {
        Self { size, bold: false, colour: Colour::INK, anchor, upwards: false }
    }

    /// The same, bold.
    pub const fn bold(self) -> Self {
        Self { bold: true, ..self }
    }

    /// The same in another colour.
    pub const fn coloured(self, colour: Colour) -> Self {
        Self { colour, ..self }
    }

    /// The same, read from bottom to top.
    pub const fn upwards(self) -> Self {
        Self { upwards: true, ..self }
    }
}
