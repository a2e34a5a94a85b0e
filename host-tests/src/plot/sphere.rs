//! Directions on a half sphere, such as where an arm pointed.

use super::frame::{self, Entry, MARGIN};
use super::marker::draw_marker;
use super::palette::Colour;
use super::sheet::{Anchor, Lettering, Sheet, Stroke};
use super::{Figure, PlotError};

/// A named set of directions. The vectors need not be unit vectors, but must have z > 0 (the half sphere that is shown).
#[derive(Debug, Clone, PartialEq)]
pub struct Directions {
    label: String,
    vectors: Vec<[f64; 3]>,
}

impl Directions {
    /// Directions in a frame whose z axis becomes the middle of the map.
    pub fn new(label: &str, vectors: Vec<[f64; 3]>) -> Self {
        Self { label: label.to_string(), vectors }
    }
}

/// Directions about the z axis in Lambert's azimuthal equal-area projection: equal areas of the map are equal solid
/// angles, so evenly spread dots are evenly spread poses. x points right and y points up.
#[derive(Debug, Clone, PartialEq)]
pub struct Sphere {
    title: String,
    subtitle: String,
    rim_deg: f64,
    sets: Vec<Directions>,
}

impl Sphere {
    /// A map out to an angle of `rim_deg` from the z axis (degrees, 0 to 90 exclusive of 0).
    pub fn new(title: &str, rim_deg: f64) -> Self {
        Self { title: title.to_string(), subtitle: String::new(), rim_deg: rim_deg.clamp(1.0, 90.0), sets: Vec::new() }
    }

    /// Adds a line of smaller text below the title.
    #[must_use]
    pub fn subtitled(mut self, text: &str) -> Self {
        self.subtitle = text.to_string();
        self
    }

    /// Adds a set of directions. Its place in the order decides its colour and marker.
    #[must_use]
    pub fn with(mut self, directions: Directions) -> Self {
        self.sets.push(directions);
        self
    }

    /// Distance from the middle for an angle from the z axis, as a share of the rim's (Lambert: r = 2 sin(angle / 2)).
    fn share(&self, angle_rad: f64) -> f64 {
        libm::sin(angle_rad / 2.0) / libm::sin(self.rim_deg.to_radians() / 2.0)
    }

    /// The place of a direction, x right and y up, in shares of the rim. None when it lies beyond the rim or is no
    /// direction.
    fn project(&self, [x, y, z]: [f64; 3]) -> Option<(f64, f64)> {
        let across = libm::hypot(x, y);
        let angle = libm::atan2(across, z);
        let on_map = angle.is_finite() && (across > 0.0 || z > 0.0) && angle.to_degrees() <= self.rim_deg + 1e-9;
        let share = self.share(angle);
        on_map.then_some(if across > 0.0 { (share * x / across, share * y / across) } else { (0.0, 0.0) })
    }

    fn draw_graticule(&self, sheet: &mut dyn Sheet, (x, y): (f32, f32), radius: f32) {
        let ring = |angle_deg: f64| radius * self.share(angle_deg.to_radians()) as f32;
        let step = if self.rim_deg > 45.0 { 15.0 } else { 10.0 };
        let mut angles: Vec<f64> = (1..).map(|k| f64::from(k) * step).take_while(|a| *a < self.rim_deg - 1.0).collect();
        for spoke in 0..12 {
            let azimuth = f64::from(spoke) * std::f64::consts::PI / 6.0;
            let (dx, dy) = ((libm::cos(azimuth) as f32) * radius, (-libm::sin(azimuth) as f32) * radius);
            sheet.path(&[(x, y), (x + dx, y + dy)], false, None, Some(Stroke::solid(Colour::GRID, 1.0)));
            let label = format!("{}°", spoke * 30);
            let lettering = Lettering::regular(12.0, Anchor::Middle).coloured(Colour::GREY);
            sheet.text((x + dx * 1.09, y + dy * 1.07), &label, lettering);
        }
        for &angle in &angles {
            sheet.circle((x, y), ring(angle), None, Some(Stroke::solid(Colour::GRID, 1.0)));
        }
        sheet.circle((x, y), radius, None, Some(Stroke::solid(Colour::INK, 1.0)));
        angles.push(self.rim_deg);
        for angle in angles {
            let lettering = Lettering::regular(11.0, Anchor::Middle).coloured(Colour::GREY);
            // Just inside its ring, along 75 degrees of azimuth, between two spokes.
            let distance = ring(angle) - 10.0;
            sheet.text((x + distance * 0.259, y - distance * 0.966), &format!("{angle}°"), lettering);
        }
    }
}

impl Figure for Sphere {
    fn size(&self) -> (f32, f32) {
        (620.0, 680.0)
    }

    fn paint(&self, sheet: &mut dyn Sheet) -> Result<(), PlotError> {
        if self.sets.iter().all(|set| set.vectors.is_empty()) {
            return Err(PlotError::NoData);
        }
        let (width, height) = self.size();
        let below_title = frame::draw_title(sheet, &self.title, &self.subtitle);
        let samples: Vec<_> = (0..self.sets.len())
            .map(|index| move |sheet: &mut dyn Sheet, at: (f32, f32), _: f32| draw_marker(sheet, index, at, 4.0))
            .collect();
        let mut entries: Vec<Entry<'_>> = Vec::new();
        for (set, draw) in self.sets.iter().zip(&samples) {
            entries.push(Entry { label: &set.label, draw });
        }
        let top = frame::draw_legend(sheet, width, below_title, &entries);
        let radius = ((height - top - MARGIN) / 2.0 - 34.0).min(width / 2.0 - MARGIN - 38.0);
        let middle = (width / 2.0, (top + height - MARGIN) / 2.0);
        self.draw_graticule(sheet, middle, radius);
        for (number, set) in self.sets.iter().enumerate() {
            for (index, &vector) in set.vectors.iter().enumerate() {
                let Some((right, up)) = self.project(vector) else {
                    return Err(PlotError::OffScale { label: set.label.clone(), index });
                };
                let at = (middle.0 + radius * right as f32, middle.1 - radius * up as f32);
                draw_marker(sheet, number, at, 4.0);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::Sphere;

    #[test]
    fn equal_areas_of_the_map_are_equal_solid_angles() {
        // The cap within 60 degrees is half of the half sphere (1 - cos 60 = 1/2), so half of the map's area.
        let (x, y) = Sphere::new("", 90.0).project([0.0, (60f64).to_radians().sin(), 0.5]).unwrap();
        assert!((x * x + y * y - 0.5).abs() < 1e-12, "{x} {y}");
    }

    #[test]
    fn a_direction_beyond_the_rim_is_refused() {
        assert!(Sphere::new("", 45.0).project([1.0, 0.0, 0.9]).is_none());
        assert!(Sphere::new("", 45.0).project([1.0, 0.0, 1.1]).is_some());
        assert!(Sphere::new("", 90.0).project([0.0, 0.0, 0.0]).is_none());
    }
}
