//! A rig from a file: `base = [[x, y, z], ..]` and `edges = [p12, p23, p31]`, mm, in TOML.

use super::input_error::{self, InputError, quoted};
use super::{known_keys, units};
use glenoid::rig::{ASSUMED_BASE_RADIUS_MM, Drum, POINTS, Parameters, Rig, RigError};
use glenoid::scalar::Real;
use nalgebra::Vector3;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A rig, and what its file says beyond it.
#[derive(Clone, Debug, PartialEq)]
pub struct RigFile {
    /// The rig. What the file does not say (drum, noise, nominal centre) is the shoulder's.
    pub rig: Rig<f64>,
    /// `values` of the section `[start]`: x, y, z, p1, p2, p3, mm.
    pub start_mm: Option<[f64; 6]>,
}

/// The rig that is meant when none is given: the shoulder over its assumed base.
///
/// # Errors
/// None in practice; the constants are checked like any other rig's.
pub fn default_rig() -> Result<Rig<f64>, InputError> {
    Rig::shoulder(ASSUMED_BASE_RADIUS_MM).map_err(|error| InputError::Request(error.text().to_owned()))
}

/// A rig in another precision.
///
/// # Errors
/// [`RigError`] for a constant that precision `T` cannot hold.
pub fn in_precision<T: Real>(rig: &Rig<f64>) -> Result<Rig<T>, RigError> {
    let drum = rig.drum();
    let drum = Drum {
        radius_mm: T::of(drum.radius_mm),
        counts_per_turn: T::of(drum.counts_per_turn),
        home_length_mm: drum.home_length_mm.map(T::of),
        fastest_mm_per_s: T::of(drum.fastest_mm_per_s),
    };
    let nominal = Parameters::from_array(rig.nominal().to_array().map(T::of));
    let base_mm = rig.base_mm().map(|point| point.map(T::of));
    Rig::new(base_mm, rig.edges_mm().map(T::of), drum, T::of(rig.length_noise_mm()), nominal)
}

impl RigFile {
    /// Reads a rig.
    ///
    /// # Errors
    /// [`InputError`] names the place that cannot be read, or the constant that cannot be.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let (file, bytes) = input_error::read(path)?;
        Self::parse(&file, &bytes)
    }

    /// Reads a rig from the bytes of its file. `file` is its name for messages.
    ///
    /// # Errors
    /// [`InputError`] names the place that cannot be read, or the constant that cannot be.
    pub fn parse(file: &str, bytes: &[u8]) -> Result<Self, InputError> {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let text = std::str::from_utf8(bytes).map_err(|error| {
            let before = String::from_utf8_lossy(&bytes[..error.valid_up_to()]).into_owned();
            Source { file, text: &before }.error(before.len()..before.len(), "not UTF-8 text")
        })?;
        Source { file, text }.rig_file()
    }
}

/// The text of a rig file, for places in it.
struct Source<'a> {
    file: &'a str,
    text: &'a str,
}

impl<'a> Source<'a> {
    fn rig_file(&self) -> Result<RigFile, InputError> {
        let table = DeTable::parse(self.text).map_err(|error| {
            let end = self.text.len();
            self.error(error.span().unwrap_or(end..end), error.message())
        })?;
        let table = table.get_ref();
        if let Some((place, complaint)) = known_keys::unknown(table) {
            return Err(self.error(place, complaint));
        }
        let base = self.value(table, "base", "[[x, y, z], [x, y, z], [x, y, z]]")?;
        let edges = self.value(table, "edges", "[p12, p23, p31]")?;
        let mut base_mm = [Vector3::zeros(); POINTS];
        for (point, value) in base_mm.iter_mut().zip(self.items::<POINTS>(base, "base", "points")?) {
            *point = Vector3::from(self.numbers(value, "a point of base")?);
        }
        let edges_mm = self.numbers(edges, "edges")?;
        let start_mm = self.start(table)?;
        Ok(RigFile { rig: self.rig(base, base_mm, edges, edges_mm)?, start_mm })
    }

    /// The checked rig; complaints point at the constant that is to blame.
    fn rig(
        &self,
        base: &Spanned<DeValue<'a>>,
        base_mm: [Vector3<f64>; POINTS],
        edges: &Spanned<DeValue<'a>>,
        edges_mm: [f64; POINTS],
    ) -> Result<Rig<f64>, InputError> {
        let shoulder = default_rig()?;
        let rig = Rig::new(base_mm, edges_mm, *shoulder.drum(), shoulder.length_noise_mm(), *shoulder.nominal())
            .map_err(|error| match error {
                RigError::PlatformCollapsed => self.error(edges.span(), format!("{}: {edges_mm:?}", error.text())),
                RigError::BaseCollapsed => {
                    self.error(base.span(), coinciding(&base_mm).unwrap_or(error.text().to_owned()))
                }
                _ => self.error(base.span(), error.text()),
            })?;
        if let Some(complaint) = units::complaint_about_rig("side of the base", &units::sides(&base_mm)) {
            return Err(self.error(base.span(), complaint));
        }
        if let Some(complaint) = units::complaint_about_rig("edge of the platform", &edges_mm) {
            return Err(self.error(edges.span(), complaint));
        }
        Ok(rig)
    }

    fn start(&self, table: &DeTable<'a>) -> Result<Option<[f64; 6]>, InputError> {
        let Some(section) = table.get("start") else { return Ok(None) };
        let values = section.get_ref().as_table().and_then(|section| section.get("values"));
        let Some(values) = values else {
            return Err(self.error(section.span(), "start: a section with values = [x, y, z, p1, p2, p3] is wanted"));
        };
        let numbers = self.numbers(values, "values of start")?;
        match super::start_complaint(&numbers) {
            Some(complaint) => Err(self.error(values.span(), complaint)),
            None => Ok(Some(numbers)),
        }
    }

    fn value<'t>(
        &self,
        table: &'t DeTable<'a>,
        key: &str,
        shape: &str,
    ) -> Result<&'t Spanned<DeValue<'a>>, InputError> {
        let end = self.text.len();
        table.get(key).ok_or_else(|| self.error(end..end, format!("{key} = {shape}, in mm, is missing")))
    }

    /// The `N` items of an array.
    fn items<'t, const N: usize>(
        &self,
        value: &'t Spanned<DeValue<'a>>,
        name: &str,
        what: &str,
    ) -> Result<&'t [Spanned<DeValue<'a>>; N], InputError> {
        let Some(array) = value.get_ref().as_array() else {
            let found = value.get_ref().type_str();
            return Err(self.error(value.span(), format!("{name}: {N} {what} are wanted, not {found}")));
        };
        let items: &[_] = array;
        items
            .try_into()
            .map_err(|_| self.error(value.span(), format!("{name}: {N} {what} are wanted, there are {}", items.len())))
    }

    /// An array of `N` finite numbers.
    fn numbers<const N: usize>(&self, value: &Spanned<DeValue<'a>>, name: &str) -> Result<[f64; N], InputError> {
        let mut numbers = [0.0; N];
        for (number, item) in numbers.iter_mut().zip(self.items::<N>(value, name, "numbers")?) {
            let parsed = match item.get_ref() {
                DeValue::Float(float) => float.as_str().parse().ok(),
                DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse().ok(),
                DeValue::Integer(integer) => {
                    i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|integer| integer as f64)
                }
                _ => None,
            };
            *number = match parsed {
                Some(number) if f64::is_finite(number) => number,
                _ => {
                    let found = quoted(self.text.get(item.span()).unwrap_or(""));
                    return Err(self.error(item.span(), format!("{name}: {found} is not a finite number")));
                }
            };
        }
        Ok(numbers)
    }

    /// An error where `span` begins.
    fn error(&self, span: Range<usize>, message: impl Into<String>) -> InputError {
        let before = self.text.get(..span.start).unwrap_or(self.text);
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
        InputError::at(self.file, line, column, message)
    }
}

/// Names attachment points that coincide.
fn coinciding(base_mm: &[Vector3<f64>; POINTS]) -> Option<String> {
    let pairs = [(0, 1), (1, 2), (2, 0)];
    let (i, j) = pairs.into_iter().find(|&(i, j)| base_mm[i] == base_mm[j])?;
    Some(format!("the attachment points B{} and B{} coincide", i + 1, j + 1))
}
