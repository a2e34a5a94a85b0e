//! Title, legend, axes and grid around the data, and the rulers that place data inside them.

use super::axis::{Axis, Ruler, Ticks};
use super::letters;
use super::palette::Colour;
use super::sheet::{Anchor, Lettering, Sheet, Stroke};

const TITLE_SIZE: f32 = 16.0;
const TEXT_SIZE: f32 = 13.0;
const TICK_SIZE: f32 = 12.0;
/// White space at the sheet's edge, CSS pixels.
pub(super) const MARGIN: f32 = 16.0;
/// Distance of the outermost values from the frame, so that no marker is cut in half.
const INSET: f32 = 10.0;
/// Length of the sample line in the legend.
const SAMPLE: f32 = 34.0;
const LINE_HEIGHT: f32 = 21.0;

/// Draws one legend sample, centred at the given point, within [`SAMPLE`] pixels.
pub(super) type DrawSample<'a> = &'a dyn Fn(&mut dyn Sheet, (f32, f32), f32);

/// A legend entry: its label and how its sample is drawn.
pub(super) struct Entry<'a> {
    pub(super) label: &'a str,
    pub(super) draw: DrawSample<'a>,
}

/// Title and subtitle at the top left; returns the y below them.
pub(super) fn draw_title(sheet: &mut dyn Sheet, title: &str, subtitle: &str) -> f32 {
    sheet.text((MARGIN, MARGIN + 8.0), title, Lettering::regular(TITLE_SIZE, Anchor::Start).bold());
    let mut y = MARGIN + 24.0;
    for line in subtitle.lines() {
        sheet.text((MARGIN, y + 6.0), line, Lettering::regular(TICK_SIZE, Anchor::Start).coloured(Colour::GREY));
        y += 18.0;
    }
    y
}

/// The legend in rows above the data, never over it; returns the y below it.
pub(super) fn draw_legend(sheet: &mut dyn Sheet, width: f32, top: f32, entries: &[Entry<'_>]) -> f32 {
    if entries.is_empty() {
        return top;
    }
    let (mut x, mut y) = (MARGIN, top + LINE_HEIGHT / 2.0);
    for entry in entries {
        let needed = SAMPLE + 6.0 + letters::width(entry.label, TEXT_SIZE, false) + 22.0;
        if x > MARGIN && x + needed > width - MARGIN {
            (x, y) = (MARGIN, y + LINE_HEIGHT);
        }
        (entry.draw)(sheet, (x + SAMPLE / 2.0, y), SAMPLE);
        sheet.text((x + SAMPLE + 6.0, y), entry.label, Lettering::regular(TEXT_SIZE, Anchor::Start));
        x += needed;
    }
    y + LINE_HEIGHT / 2.0
}

/// The area for the data, CSS pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Area {
    pub(super) left: f32,
    pub(super) right: f32,
    pub(super) top: f32,
    pub(super) bottom: f32,
}

/// Room for the data on a sheet of `size`, below `top`, beside labels as wide as the widest of `y_labels`.
pub(super) fn area<'a>(size: (f32, f32), top: f32, y_labels: impl Iterator<Item = &'a str>) -> Area {
    let widest = y_labels.map(|label| letters::width(label, TICK_SIZE, false)).fold(0.0, f32::max);
    Area {
        left: MARGIN + TEXT_SIZE + 10.0 + widest + 8.0,
        right: size.0 - MARGIN - 12.0,
        top: top + 12.0,
        bottom: size.1 - MARGIN - TEXT_SIZE - TICK_SIZE - 16.0,
    }
}

/// Titles of the two axes, centred along them.
pub(super) fn draw_axis_titles(sheet: &mut dyn Sheet, area: Area, height: f32, x: &str, y: &str) {
    let middle = ((area.left + area.right) / 2.0, (area.top + area.bottom) / 2.0);
    let lettering = Lettering::regular(TEXT_SIZE, Anchor::Middle);
    sheet.text((middle.0, height - MARGIN - TEXT_SIZE / 2.0), x, lettering);
    sheet.text((MARGIN + TEXT_SIZE / 2.0, middle.1), y, lettering.upwards());
}

/// A label below the x axis.
pub(super) fn draw_x_label(sheet: &mut dyn Sheet, area: Area, x: f32, label: &str) {
    sheet.text((x, area.bottom + 8.0 + TICK_SIZE / 2.0), label, Lettering::regular(TICK_SIZE, Anchor::Middle));
}

/// A label left of the y axis.
pub(super) fn draw_y_label(sheet: &mut dyn Sheet, area: Area, y: f32, label: &str) {
    sheet.text((area.left - 8.0, y), label, Lettering::regular(TICK_SIZE, Anchor::End));
}

/// Grid, axes and their labels; returns the rulers (x, y) for the data.
pub(super) fn draw_axes(
    sheet: &mut dyn Sheet,
    area: Area,
    height: f32,
    (x, x_ticks): (&Axis, &Ticks),
    (y, y_ticks): (&Axis, &Ticks),
) -> (Ruler, Ruler) {
    let x_ruler = Ruler::new(x.scale, x_ticks, area.left + INSET, area.right - INSET);
    let y_ruler = Ruler::new(y.scale, y_ticks, area.bottom - INSET, area.top + INSET);
    let mut line = |from, to, colour, width| sheet.path(&[from, to], false, None, Some(Stroke::solid(colour, width)));
    for (ticks, width) in [(&x_ticks.minor, 0.5), (&x_ticks.major.iter().map(|t| t.0).collect(), 1.0)] {
        for &value in ticks {
            let at = x_ruler.at(value);
            line((at, area.top), (at, area.bottom), Colour::GRID, width);
        }
    }
    for (ticks, width) in [(&y_ticks.minor, 0.5), (&y_ticks.major.iter().map(|t| t.0).collect(), 1.0)] {
        for &value in ticks {
            let at = y_ruler.at(value);
            line((area.left, at), (area.right, at), Colour::GRID, width);
        }
    }
    line((area.left, area.bottom), (area.right, area.bottom), Colour::INK, 1.0);
    line((area.left, area.top), (area.left, area.bottom), Colour::INK, 1.0);
    for (value, label) in &x_ticks.major {
        draw_x_label(sheet, area, x_ruler.at(*value), label);
    }
    for (value, label) in &y_ticks.major {
        draw_y_label(sheet, area, y_ruler.at(*value), label);
    }
    draw_axis_titles(sheet, area, height, &x.title, &y.title);
    (x_ruler, y_ruler)
}
