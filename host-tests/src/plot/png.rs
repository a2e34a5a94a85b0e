//! A sheet of pixels, anti-aliased, written as PNG.

use super::PlotError;
use super::letters::{self, CAPITAL_HEIGHT};
use super::palette::Colour;
use super::sheet::{Anchor, Lettering, Sheet, Stroke};
use ab_glyph::OutlineCurve;
use tiny_skia::{FillRule, LineJoin, Paint, Path, PathBuilder, Pixmap, StrokeDash, Transform};

/// Pixels for each CSS pixel: sharp on a high-density screen and in print.
const DENSITY: f32 = 2.0;

/// A white pixel map with a density of [`DENSITY`].
pub(super) struct PixelSheet {
    pixels: Pixmap,
}

impl PixelSheet {
    pub(super) fn new((width, height): (f32, f32)) -> Result<Self, PlotError> {
        let mut pixels = Pixmap::new((width * DENSITY) as u32, (height * DENSITY) as u32).ok_or(PlotError::Encoding)?;
        pixels.fill(tiny_skia::Color::WHITE);
        Ok(Self { pixels })
    }

    pub(super) fn finish(self) -> Result<Vec<u8>, PlotError> {
        self.pixels.encode_png().map_err(|_| PlotError::Encoding)
    }

    fn draw(&mut self, path: Option<Path>, fill: Option<Colour>, stroke: Option<Stroke>) {
        // A path without extent (a single point) is no path to the rasteriser; nothing of it would show.
        let Some(path) = path else { return };
        let to_pixels = Transform::from_scale(DENSITY, DENSITY);
        if let Some(colour) = fill {
            self.pixels.fill_path(&path, &paint(colour), FillRule::Winding, to_pixels, None);
        }
        if let Some(Stroke { colour, width, dash }) = stroke {
            let stroke = tiny_skia::Stroke {
                width,
                line_join: LineJoin::Round,
                // Dashes come in pairs; a pattern that is none is a solid line.
                dash: StrokeDash::new(dash.to_vec(), 0.0),
                ..Default::default()
            };
            self.pixels.stroke_path(&path, &paint(colour), &stroke, to_pixels, None);
        }
    }
}

fn paint(Colour { red, green, blue }: Colour) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(red, green, blue, 255);
    paint
}

impl Sheet for PixelSheet {
    fn path(&mut self, points: &[(f32, f32)], closed: bool, fill: Option<Colour>, stroke: Option<Stroke>) {
        let mut builder = PathBuilder::new();
        for (index, &(x, y)) in points.iter().enumerate() {
            if index == 0 {
                builder.move_to(x, y);
            } else {
                builder.line_to(x, y);
            }
        }
        if closed {
            builder.close();
        }
        self.draw(builder.finish(), fill, stroke);
    }

    fn circle(&mut self, (x, y): (f32, f32), radius: f32, fill: Option<Colour>, stroke: Option<Stroke>) {
        self.draw(PathBuilder::from_circle(x, y, radius), fill, stroke);
    }

    fn text(&mut self, (x, y): (f32, f32), text: &str, lettering: Lettering) {
        let Lettering { size, bold, colour, anchor, upwards } = lettering;
        let width = letters::width(text, size, bold);
        let start = match anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => -width / 2.0,
            Anchor::End => -width,
        };
        let drop = size * CAPITAL_HEIGHT / 2.0;
        // From (along the text, up from the baseline) to the sheet.
        let place = |along: f32, up: f32| {
            let (along, down) = (start + along, drop - up);
            if upwards { (x + down, y - along) } else { (x + along, y + down) }
        };
        let mut builder = PathBuilder::new();
        let unit = size / letters::units_per_em(bold);
        for (offset_em, curves) in letters::outlines(text, bold) {
            let at = |p: ab_glyph::Point| place(offset_em * size + p.x * unit, p.y * unit);
            add_contours(&mut builder, &curves, at);
        }
        self.draw(builder.finish(), Some(colour), None);
    }
}

/// Adds a glyph's curves to the path. A new contour begins wherever a curve does not start at the last one's end.
fn add_contours(builder: &mut PathBuilder, curves: &[OutlineCurve], at: impl Fn(ab_glyph::Point) -> (f32, f32)) {
    let mut pen = None;
    for curve in curves {
        let (from, to) = match *curve {
            OutlineCurve::Line(a, b) | OutlineCurve::Quad(a, _, b) | OutlineCurve::Cubic(a, _, _, b) => (a, b),
        };
        if pen != Some(from) {
            let (x, y) = at(from);
            builder.move_to(x, y);
        }
        let (x, y) = at(to);
        match *curve {
            OutlineCurve::Line(..) => builder.line_to(x, y),
            OutlineCurve::Quad(_, c, _) => {
                let (cx, cy) = at(c);
                builder.quad_to(cx, cy, x, y);
            }
            OutlineCurve::Cubic(_, c, d, _) => {
                let ((cx, cy), (dx, dy)) = (at(c), at(d));
                builder.cubic_to(cx, cy, dx, dy, x, y);
            }
        }
        pen = Some(to);
    }
}
