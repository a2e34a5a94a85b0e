//! Line charts and scatter charts.

use super::axis::Axis;
use super::frame::{self, Entry};
use super::marker::draw_marker;
use super::palette::{Colour, series_colour, series_dash};
use super::sheet::{Sheet, Stroke};
use super::{Figure, PlotError};

/// How a series is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Look {
    /// A line with a marker at each point: few points.
    Line,
    /// A line alone: many points.
    Curve,
    /// Markers alone: points without an order.
    Scatter,
}

/// A named set of points.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    label: String,
    points: Vec<(f64, f64)>,
    look: Look,
}

impl Series {
    /// A line with a marker at each point (x, y), in the units of the axes.
    pub fn line(label: &str, points: Vec<(f64, f64)>) -> Self {
        Self { label: label.to_string(), points, look: Look::Line }
    }

    /// A line without markers.
    pub fn curve(label: &str, points: Vec<(f64, f64)>) -> Self {
        Self { look: Look::Curve, ..Self::line(label, points) }
    }

    /// Markers without a line.
    pub fn scatter(label: &str, points: Vec<(f64, f64)>) -> Self {
        Self { look: Look::Scatter, ..Self::line(label, points) }
    }

    /// The points (x, y), in the units of the axes.
    pub fn points(&self) -> &[(f64, f64)] {
        &self.points
    }
}

/// A horizontal line at a value that the data is to be compared with, such as a tolerance.
#[derive(Debug, Clone, PartialEq)]
pub struct Level {
    label: String,
    value: f64,
}

/// Several series over two axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    title: String,
    subtitle: String,
    x: Axis,
    y: Axis,
    series: Vec<Series>,
    levels: Vec<Level>,
    size: (f32, f32),
}

impl Chart {
    /// An empty chart, 800 by 500 CSS pixels.
    pub fn new(title: &str, x: Axis, y: Axis) -> Self {
        let (title, subtitle) = (title.to_string(), String::new());
        Self { title, subtitle, x, y, series: Vec::new(), levels: Vec::new(), size: (800.0, 500.0) }
    }

    /// Adds a line of smaller text below the title: seed, conditions, counts.
    #[must_use]
    pub fn subtitled(mut self, text: &str) -> Self {
        self.subtitle = text.to_string();
        self
    }

    /// Adds a series. Its place in the order decides its colour, marker and dash.
    #[must_use]
    pub fn with(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }

    /// Adds a horizontal line at `value`, in the unit of the y axis. The axis is extended to show it.
    #[must_use]
    pub fn with_level(mut self, label: &str, value: f64) -> Self {
        self.levels.push(Level { label: label.to_string(), value });
        self
    }

    /// Least and most of the data, x then y.
    fn extent(&self) -> Result<[(f64, f64); 2], PlotError> {
        let mut extent = [(f64::INFINITY, f64::NEG_INFINITY); 2];
        for series in &self.series {
            for (index, &(x, y)) in series.points.iter().enumerate() {
                if !self.x.holds(x) || !self.y.holds(y) {
                    return Err(PlotError::OffScale { label: series.label.clone(), index });
                }
                extent = [(extent[0].0.min(x), extent[0].1.max(x)), (extent[1].0.min(y), extent[1].1.max(y))];
            }
        }
        if extent[0].0 > extent[0].1 {
            return Err(PlotError::NoData);
        }
        for level in &self.levels {
            if !self.y.holds(level.value) {
                return Err(PlotError::OffScale { label: level.label.clone(), index: 0 });
            }
            extent[1] = (extent[1].0.min(level.value), extent[1].1.max(level.value));
        }
        Ok(extent)
    }
}

/// A series of more points gets small markers.
const MANY_POINTS: usize = 200;

/// The line of a [`Level`].
const LEVEL: Stroke = Stroke { colour: Colour::GREY, width: 1.5, dash: &[3.0, 3.0] };

/// Draws the line of a series through points that are already on the sheet.
fn draw_line(sheet: &mut dyn Sheet, index: usize, points: &[(f32, f32)]) {
    let stroke = Stroke { colour: series_colour(index), width: 2.0, dash: series_dash(index) };
    sheet.path(points, false, None, Some(stroke));
}

impl Figure for Chart {
    fn size(&self) -> (f32, f32) {
        self.size
    }

    fn paint(&self, sheet: &mut dyn Sheet) -> Result<(), PlotError> {
        let [x_extent, y_extent] = self.extent()?;
        let off_axis = |axis: &Axis| PlotError::OffScale { label: axis.title.clone(), index: 0 };
        let x_ticks = self.x.ticks(x_extent.0, x_extent.1).ok_or_else(|| off_axis(&self.x))?;
        let y_ticks = self.y.ticks(y_extent.0, y_extent.1).ok_or_else(|| off_axis(&self.y))?;

        let below_title = frame::draw_title(sheet, &self.title, &self.subtitle);
        let samples: Vec<_> = (self.series.iter().enumerate())
            .map(|(index, series)| {
                move |sheet: &mut dyn Sheet, (x, y): (f32, f32), length: f32| {
                    if series.look != Look::Scatter {
                        draw_line(sheet, index, &[(x - length / 2.0, y), (x + length / 2.0, y)]);
                    }
                    if series.look != Look::Curve {
                        draw_marker(sheet, index, (x, y), 4.0);
                    }
                }
            })
            .collect();
        let level_sample = |sheet: &mut dyn Sheet, (x, y): (f32, f32), length: f32| {
            sheet.path(&[(x - length / 2.0, y), (x + length / 2.0, y)], false, None, Some(LEVEL));
        };
        let mut entries: Vec<Entry<'_>> = Vec::new();
        for (series, draw) in self.series.iter().zip(&samples) {
            entries.push(Entry { label: &series.label, draw });
        }
        for level in &self.levels {
            entries.push(Entry { label: &level.label, draw: &level_sample });
        }
        let below_legend = frame::draw_legend(sheet, self.size.0, below_title, &entries);

        let area = frame::area(self.size, below_legend, y_ticks.major.iter().map(|(_, label)| label.as_str()));
        let (x, y) = frame::draw_axes(sheet, area, self.size.1, (&self.x, &x_ticks), (&self.y, &y_ticks));
        for level in &self.levels {
            let at = y.at(level.value);
            sheet.path(&[(area.left, at), (area.right, at)], false, None, Some(LEVEL));
        }
        let place = |series: &Series| series.points.iter().map(|&(u, v)| (x.at(u), y.at(v))).collect::<Vec<_>>();
        // Lines in order, so that the dashes of later ones show on earlier ones where they run together; then markers
        // in reverse, so that the filled ones of earlier series show on the hollow ones of later ones.
        for (index, series) in self.series.iter().enumerate().filter(|(_, series)| series.look != Look::Scatter) {
            draw_line(sheet, index, &place(series));
        }
        for (index, series) in self.series.iter().enumerate().rev().filter(|(_, series)| series.look != Look::Curve) {
            let size = if series.points.len() > MANY_POINTS { 2.0 } else { 4.0 };
            for point in place(series) {
                draw_marker(sheet, index, point, size);
            }
        }
        Ok(())
    }
}
