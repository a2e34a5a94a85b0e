//! The one font: widths for the layout of both sheets, outlines for the PNG.

use ab_glyph::{Font, FontRef, GlyphId, OutlineCurve, PxScale, ScaleFont};
use std::sync::LazyLock;

/// DejaVu Sans 2.37, regular and bold, from the binary itself.
static REGULAR: LazyLock<FontRef<'static>> = LazyLock::new(|| parse(dejavu::sans::regular()));
static BOLD: LazyLock<FontRef<'static>> = LazyLock::new(|| parse(dejavu::sans::bold()));

fn parse(bytes: &'static [u8]) -> FontRef<'static> {
    FontRef::try_from_slice(bytes).expect("the embedded font is well formed")
}

fn font(bold: bool) -> &'static FontRef<'static> {
    if bold { &BOLD } else { &REGULAR }
}

/// Height of a capital above the baseline as a share of the em (DejaVu Sans: 1493 of 2048 units).
pub(super) const CAPITAL_HEIGHT: f32 = 0.729;

/// A glyph's place in a line of text.
struct Placed {
    glyph: GlyphId,
    /// Distance from the start of the text to the glyph's origin, in ems.
    offset_em: f32,
}

/// Lays out one line. Returns the glyphs and the width of the whole, in ems.
fn layout(text: &str, bold: bool) -> (Vec<Placed>, f32) {
    let font = font(bold);
    let units_per_em = font.units_per_em().unwrap_or(2048.0);
    let scale = PxScale::from(font.height_unscaled());
    let font = font.as_scaled(scale);
    let mut glyphs = Vec::new();
    let mut width_units = 0.0;
    let mut previous = None;
    for character in text.chars() {
        let glyph = font.glyph_id(character);
        if let Some(previous) = previous {
            width_units += font.kern(previous, glyph);
        }
        glyphs.push(Placed { glyph, offset_em: width_units / units_per_em });
        width_units += font.h_advance(glyph);
        previous = Some(glyph);
    }
    (glyphs, width_units / units_per_em)
}

/// Width of `text` at an em of `size` CSS pixels, in CSS pixels.
///
/// The viewer of an SVG sets it in a font of its own; DejaVu Sans is wider than most, so what fits here fits there.
pub(super) fn width(text: &str, size: f32, bold: bool) -> f32 {
    layout(text, bold).1 * size
}

/// The outline curves of `text`, y upwards from the baseline, x from the start of the text, in ems.
pub(super) fn outlines(text: &str, bold: bool) -> Vec<(f32, Vec<OutlineCurve>)> {
    let font = font(bold);
    let (glyphs, _) = layout(text, bold);
    glyphs
        .into_iter()
        .filter_map(|placed| font.outline(placed.glyph).map(|outline| (placed.offset_em, outline.curves)))
        .collect()
}

/// Font units in one em, the unit of the curves' own coordinates.
pub(super) fn units_per_em(bold: bool) -> f32 {
    font(bold).units_per_em().unwrap_or(2048.0)
}
