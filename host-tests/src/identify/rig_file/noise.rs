//! What a rig file says of how noisy lengths are: the section `[noise]`.
//!
//! ```text
//! [noise]
//! pose = 0.02      # 1σ of what does not average over the samples of a held pose: friction, hysteresis, mm
//! sample = 0.058   # 1σ of what each sample has beyond that: white noise, encoder quantisation, mm; 0 by default
//! samples = 40     # of how many samples a row of a log is the mean; 1 by default
//! ```

use super::source::Source;
use crate::identify::input_error::InputError;
use glenoid::rig::Rig;
use toml::Spanned;
use toml::de::DeTable;

/// Standard deviations that can be meant, mm: what a board can be told.
const POSSIBLE_MM: (f64, f64) = (1e-4, 10.0);

/// What `[noise]` says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Noise {
    pose_mm: f64,
    sample_mm: f64,
    pub(super) samples_a_row: u16,
}

impl Noise {
    /// Of a row of a log, mm.
    pub(super) fn of_a_row_mm(&self) -> f64 {
        self.pose_mm.hypot(self.sample_mm / f64::from(self.samples_a_row).sqrt())
    }
}

impl<'a> Source<'a> {
    /// The section `[noise]`, if there is one.
    pub(super) fn noise(&self, table: &DeTable<'a>) -> Result<Option<Noise>, InputError> {
        let Some(section) = table.get("noise") else { return Ok(None) };
        let Some(keys) = section.get_ref().as_table() else {
            return Err(self.error(section.span(), "noise: a section [noise] is wanted"));
        };
        let (low, high) = POSSIBLE_MM;
        let pose = self.value_at(section.span(), keys, "pose", "1σ of a length of a held pose, in mm,")?;
        let pose_mm = self.number(pose, "pose")?;
        if !(low..=high).contains(&pose_mm) {
            return Err(
                self.error(pose.span(), format!("pose: a noise of {pose_mm} mm is not within {low} to {high} mm"))
            );
        }
        let mut noise = Noise { pose_mm, sample_mm: 0.0, samples_a_row: 1 };
        if let Some(sample) = keys.get("sample") {
            noise.sample_mm = self.number(sample, "sample")?;
            if !(0.0..=high).contains(&noise.sample_mm) {
                let message = format!("sample: a noise of {} mm is not within 0 to {high} mm", noise.sample_mm);
                return Err(self.error(sample.span(), message));
            }
        }
        if let Some(samples) = keys.get("samples") {
            let number = self.number(samples, "samples")?;
            if number.fract() != 0.0 || !(1.0..=f64::from(u16::MAX)).contains(&number) {
                let message = format!("samples: a whole number of 1 to {} is wanted, not {number}", u16::MAX);
                return Err(self.error(samples.span(), message));
            }
            noise.samples_a_row = number as u16;
        }
        Ok(Some(noise))
    }

    /// The rig with the noise that the file states.
    pub(super) fn with_noise(&self, table: &DeTable<'a>, rig: Rig<f64>) -> Result<Rig<f64>, InputError> {
        let Some(noise) = self.noise(table)? else { return Ok(rig) };
        let place = table.get("noise").map_or(0..0, Spanned::span);
        rig.with_noise(noise.pose_mm, noise.sample_mm).map_err(|error| self.error(place, error.text()))
    }
}
