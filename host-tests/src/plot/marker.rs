//! Markers that stay apart for every kind of colour vision and in black and white.

use super::palette::{Colour, series_colour};
use super::sheet::{Sheet, Stroke};

/// Draws the marker of the `index`-th series. Every other one is hollow, which doubles the number of shapes.
pub(super) fn draw_marker(sheet: &mut dyn Sheet, index: usize, (x, y): (f32, f32), size: f32) {
    let colour = series_colour(index);
    let stroke = Some(Stroke::solid(colour, 1.5));
    let fill = Some(if index.is_multiple_of(2) { colour } else { Colour::WHITE });
    let at = |points: &[(f32, f32)]| points.iter().map(|(u, v)| (x + u * size, y + v * size)).collect::<Vec<_>>();
    match index % 5 {
        0 => sheet.circle((x, y), size, fill, stroke),
        1 => sheet.path(&at(&[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)]), true, fill, stroke),
        2 => sheet.path(&at(&[(0.0, -1.2), (1.1, 0.8), (-1.1, 0.8)]), true, fill, stroke),
        3 => sheet.path(&at(&[(0.0, -1.3), (1.3, 0.0), (0.0, 1.3), (-1.3, 0.0)]), true, fill, stroke),
        _ => sheet.path(&at(&[(0.0, 1.2), (1.1, -0.8), (-1.1, -0.8)]), true, fill, stroke),
    }
}
