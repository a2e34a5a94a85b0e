//! Heat maps: one share for each pair of two parameters.

use super::frame::{self, Area, MARGIN};
use super::palette::{Colour, shade};
use super::sheet::{Anchor, Lettering, Sheet, Stroke};
use super::{Figure, PlotError};

/// A table of shares (0 to 1) over two parameters, each cell coloured and labelled in percent.
#[derive(Debug, Clone, PartialEq)]
pub struct HeatMap {
    title: String,
    subtitle: String,
    x_title: String,
    x_labels: Vec<String>,
    y_title: String,
    y_labels: Vec<String>,
    bar_title: String,
    rows: Vec<Vec<f64>>,
}

impl HeatMap {
    /// A map whose columns are `x_labels` (left to right) and whose rows are `y_labels` (bottom to top).
    ///
    /// `rows[j][i]` is the share, 0 to 1, for the `j`-th y label and the `i`-th x label; `bar_title` says of what.
    pub fn new(title: &str, x: (&str, &[f64]), y: (&str, &[f64]), bar_title: &str, rows: Vec<Vec<f64>>) -> Self {
        let labels = |values: &[f64]| values.iter().map(f64::to_string).collect();
        Self {
            title: title.to_string(),
            subtitle: String::new(),
            x_title: x.0.to_string(),
            x_labels: labels(x.1),
            y_title: y.0.to_string(),
            y_labels: labels(y.1),
            bar_title: bar_title.to_string(),
            rows,
        }
    }

    /// Adds a line of smaller text below the title: seed, conditions, counts.
    #[must_use]
    pub fn subtitled(mut self, text: &str) -> Self {
        self.subtitle = text.to_string();
        self
    }

    fn check(&self) -> Result<(), PlotError> {
        if self.x_labels.is_empty() || self.y_labels.is_empty() {
            return Err(PlotError::NoData);
        }
        if self.rows.len() != self.y_labels.len() || self.rows.iter().any(|row| row.len() != self.x_labels.len()) {
            return Err(PlotError::Ragged);
        }
        match self.rows.iter().flatten().position(|share| !(0.0..=1.0).contains(share)) {
            Some(index) => Err(PlotError::OffScale { label: self.bar_title.clone(), index }),
            None => Ok(()),
        }
    }

    /// The scale of shades at the right, in percent.
    fn draw_bar(&self, sheet: &mut dyn Sheet, area: Area) {
        const STEPS: usize = 100;
        let left = area.right + 24.0;
        let height = (area.bottom - area.top) / STEPS as f32;
        for step in 0..STEPS {
            let bottom = area.bottom - step as f32 * height;
            // Half a pixel of overlap hides the seams between the steps.
            let top = (bottom - height - 0.5).max(area.top);
            let colour = shade((step as f64 + 0.5) / STEPS as f64);
            sheet.path(&rectangle(left, top, left + 16.0, bottom), true, Some(colour), None);
        }
        for percent in [0, 25, 50, 75, 100] {
            let y = area.bottom - (area.bottom - area.top) * percent as f32 / 100.0;
            sheet.text((left + 22.0, y), &format!("{percent} %"), Lettering::regular(12.0, Anchor::Start));
        }
        let middle = (area.top + area.bottom) / 2.0;
        let lettering = Lettering::regular(13.0, Anchor::Middle).upwards();
        sheet.text((left + 80.0, middle), &self.bar_title, lettering);
    }
}

/// Room for the scale of shades and its title.
const BAR_WIDTH: f32 = 104.0;

fn rectangle(left: f32, top: f32, right: f32, bottom: f32) -> [(f32, f32); 4] {
    [(left, top), (right, top), (right, bottom), (left, bottom)]
}

impl Figure for HeatMap {
    fn size(&self) -> (f32, f32) {
        let (columns, rows) = (self.x_labels.len() as f32, self.y_labels.len() as f32);
        (220.0 + 60.0 * columns.max(7.0) + BAR_WIDTH, 150.0 + 40.0 * rows.max(6.0))
    }

    fn paint(&self, sheet: &mut dyn Sheet) -> Result<(), PlotError> {
        self.check()?;
        let size = self.size();
        let top = frame::draw_title(sheet, &self.title, &self.subtitle);
        let whole = frame::area(size, top, self.y_labels.iter().map(String::as_str));
        let area = Area { right: size.0 - MARGIN - BAR_WIDTH, ..whole };
        let width = (area.right - area.left) / self.x_labels.len() as f32;
        let height = (area.bottom - area.top) / self.y_labels.len() as f32;
        for (j, row) in self.rows.iter().enumerate() {
            let bottom = area.bottom - j as f32 * height;
            for (i, &share) in row.iter().enumerate() {
                let left = area.left + i as f32 * width;
                let colour = shade(share);
                let seam = Some(Stroke::solid(Colour::WHITE, 1.0));
                sheet.path(&rectangle(left, bottom - height, left + width, bottom), true, Some(colour), seam);
                let centre = (left + width / 2.0, bottom - height / 2.0);
                let lettering = Lettering::regular(12.0, Anchor::Middle).coloured(colour.readable_on_it());
                sheet.text(centre, &percent(share), lettering);
            }
            frame::draw_y_label(sheet, area, bottom - height / 2.0, &self.y_labels[j]);
        }
        for (i, label) in self.x_labels.iter().enumerate() {
            frame::draw_x_label(sheet, area, area.left + (i as f32 + 0.5) * width, label);
        }
        frame::draw_axis_titles(sheet, area, size.1, &self.x_title, &self.y_title);
        self.draw_bar(sheet, area);
        Ok(())
    }
}

/// In percent. Only a share of exactly 0 or 1 is written as 0 or 100: nearly always is not always.
fn percent(share: f64) -> String {
    let rounded = (share * 100.0).round();
    if (rounded == 100.0 && share < 1.0) || (rounded == 0.0 && share > 0.0) {
        return if share < 0.5 { "<1".to_string() } else { ">99".to_string() };
    }
    format!("{rounded}")
}

#[cfg(test)]
mod tests {
    use super::percent;

    #[test]
    fn nearly_always_is_not_written_as_always() {
        assert_eq!(percent(1.0), "100");
        assert_eq!(percent(0.999), ">99");
        assert_eq!(percent(0.001), "<1");
        assert_eq!(percent(0.0), "0");
        assert_eq!(percent(0.741), "74");
    }
}
