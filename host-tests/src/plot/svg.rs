//! A sheet that writes SVG text.

use super::letters::CAPITAL_HEIGHT;
use super::palette::Colour;
use super::sheet::{Anchor, Lettering, Sheet, Stroke};
use std::fmt::Write;

/// Collects elements; `finish` closes the document.
pub(super) struct SvgSheet {
    text: String,
}

impl SvgSheet {
    pub(super) fn new((width, height): (f32, f32)) -> Self {
        let text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"'DejaVu Sans', Verdana, Arial, sans-serif\">\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n"
        );
        Self { text }
    }

    pub(super) fn finish(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }

    fn put(&mut self, arguments: std::fmt::Arguments<'_>) {
        // Writing into a `String` cannot fail.
        let _ = self.text.write_fmt(arguments);
    }

    fn put_paint(&mut self, fill: Option<Colour>, stroke: Option<Stroke>) {
        match fill {
            Some(colour) => self.put(format_args!(" fill=\"{}\"", hex(colour))),
            None => self.text.push_str(" fill=\"none\""),
        }
        if let Some(Stroke { colour, width, dash }) = stroke {
            self.put(format_args!(" stroke=\"{}\" stroke-width=\"{width}\"", hex(colour)));
            if !dash.is_empty() {
                let lengths = dash.iter().map(f32::to_string).collect::<Vec<_>>().join(" ");
                self.put(format_args!(" stroke-dasharray=\"{lengths}\""));
            }
        }
    }
}

fn hex(Colour { red, green, blue }: Colour) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

impl Sheet for SvgSheet {
    fn path(&mut self, points: &[(f32, f32)], closed: bool, fill: Option<Colour>, stroke: Option<Stroke>) {
        let element = if closed { "polygon" } else { "polyline" };
        self.put(format_args!("<{element} points=\""));
        for (index, (x, y)) in points.iter().enumerate() {
            let separator = if index == 0 { "" } else { " " };
            self.put(format_args!("{separator}{x:.2},{y:.2}"));
        }
        self.text.push('"');
        self.put_paint(fill, stroke);
        self.text.push_str(" stroke-linejoin=\"round\"/>\n");
    }

    fn circle(&mut self, (x, y): (f32, f32), radius: f32, fill: Option<Colour>, stroke: Option<Stroke>) {
        self.put(format_args!("<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius:.2}\""));
        self.put_paint(fill, stroke);
        self.text.push_str("/>\n");
    }

    fn text(&mut self, (x, y): (f32, f32), text: &str, lettering: Lettering) {
        let anchor = match lettering.anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        // The baseline is half a capital below the anchor; a turned text is shifted before it is turned.
        let drop = lettering.size * CAPITAL_HEIGHT / 2.0;
        self.put(format_args!("<text x=\"{x:.2}\" y=\"{:.2}\"", y + drop));
        if lettering.upwards {
            self.put(format_args!(" transform=\"rotate(-90 {x:.2} {y:.2})\""));
        }
        if lettering.bold {
            self.text.push_str(" font-weight=\"bold\"");
        }
        let (size, colour) = (lettering.size, hex(lettering.colour));
        self.put(format_args!(
            " font-size=\"{size}\" text-anchor=\"{anchor}\" fill=\"{colour}\">{}</text>\n",
            escaped(text)
        ));
    }
}
