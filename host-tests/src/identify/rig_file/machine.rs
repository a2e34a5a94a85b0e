//! What a rig file says of how well the machine is known: `home`, `[tolerance]`, `[zeros]`, `[drum]`, `[covariance]`.

use super::default_rig;
use super::source::Source;
use crate::identify::input_error::InputError;
use glenoid::identification::Machine;
use glenoid::rig::{CABLES, Correction, Drum, Rig, RigError, Tolerance};
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Puts the number of one key into a tolerance.
type SetTolerance = fn(&mut Tolerance<f64>, f64);

/// The keys of `[tolerance]`.
const TOLERANCES: [(&str, SetTolerance); 4] = [
    ("base", |tolerance, value| tolerance.base_mm = value),
    ("edges", |tolerance, value| tolerance.edges_mm = value),
    ("zero", |tolerance, value| tolerance.offset_mm = value),
    ("drum", |tolerance, value| tolerance.drum = value),
];

/// The section `[tolerance]` and what it says.
type ToleranceSection<'t, 'a> = (&'t Spanned<DeValue<'a>>, Tolerance<f64>);

/// A key of `[tolerance]`, its number, its place, and the tolerance with all keys so far.
type ToleranceKey = (&'static str, f64, Range<usize>, Tolerance<f64>);

impl<'a> Source<'a> {
    /// The shoulder's drive with the file's home lengths.
    pub(super) fn drum(&self, table: &DeTable<'a>) -> Result<Drum<f64>, InputError> {
        let drum = *default_rig()?.drum();
        let Some(home) = table.get("home") else { return Ok(drum) };
        let home_length_mm = self.numbers::<CABLES>(home, "home")?;
        match home_length_mm.iter().position(|length| *length <= 0.0) {
            Some(cable) => {
                Err(self.error(home.span(), format!("home: the length of cable {} is not positive", cable + 1)))
            }
            None => Ok(Drum { home_length_mm, ..drum }),
        }
    }

    /// The rig with its tolerances and what commissioning has found.
    pub(super) fn known_machine(&self, table: &DeTable<'a>, rig: Rig<f64>) -> Result<Rig<f64>, InputError> {
        let mut rig = self.with_noise(table, rig)?;
        // One key after the other, so that a complaint is about one of them.
        for (key, number, place, tolerance) in self.tolerances(table)? {
            let complaint = |error: RigError| self.error(place, format!("{key} = {number}: {}", error.text()));
            rig = rig.with_tolerance(tolerance).map_err(complaint)?;
        }
        let offsets = self.six(table, "zeros", "mm")?;
        let scales = self.six(table, "drum", "scale")?;
        if offsets.is_none() && scales.is_none() {
            return Ok(rig);
        }
        let place = table.get("zeros").or(table.get("drum")).map_or(0..0, Spanned::span);
        let correction =
            Correction { offset_mm: offsets.unwrap_or([0.0; CABLES]), scale: scales.unwrap_or([1.0; CABLES]) };
        rig.with_correction(correction).map_err(|error| self.error(place, error.text()))
    }

    /// The section `[tolerance]`, and what it says; what it leaves out is exact.
    pub(super) fn tolerance<'t>(&self, table: &'t DeTable<'a>) -> Result<Option<ToleranceSection<'t, 'a>>, InputError> {
        let Some(section) = table.get("tolerance") else { return Ok(None) };
        let mut known = Tolerance::exact();
        for (key, number, place, tolerance) in self.tolerances(table)? {
            // What a ball's machine cannot be known to, a hinge's cannot either.
            let complaint = |error: RigError| self.error(place, format!("{key} = {number}: {}", error.text()));
            known = *default_rig()?.with_tolerance(tolerance).map_err(complaint)?.tolerance();
        }
        Ok(Some((section, known)))
    }

    /// What `[tolerance]` says, key by key: the key, its number, its place, and the tolerance with all keys so far.
    fn tolerances(&self, table: &DeTable<'a>) -> Result<Vec<ToleranceKey>, InputError> {
        let section = table.get("tolerance").and_then(|section| section.get_ref().as_table());
        let mut tolerance = Tolerance::exact();
        let mut keys = Vec::new();
        for (key, set) in TOLERANCES {
            let Some(value) = section.and_then(|section| section.get(key)) else { continue };
            let number = self.number(value, key)?;
            set(&mut tolerance, number);
            keys.push((key, number, value.span(), tolerance));
        }
        Ok(keys)
    }

    fn six(&self, table: &DeTable<'a>, section: &str, key: &str) -> Result<Option<[f64; CABLES]>, InputError> {
        let Some(found) = table.get(section) else { return Ok(None) };
        let Some(values) = found.get_ref().as_table().and_then(|table| table.get(key)) else {
            return Err(self.error(found.span(), format!("{section}: {key} = [six numbers] is wanted")));
        };
        self.numbers::<CABLES>(values, key).map(Some)
    }

    /// The packed covariance of the machine's unknown constants.
    pub(super) fn covariance(
        &self,
        table: &DeTable<'a>,
        machine: &Machine<f64>,
    ) -> Result<Option<Vec<f64>>, InputError> {
        let Some(section) = table.get("covariance") else { return Ok(None) };
        let Some(triangle) = section.get_ref().as_table().and_then(|table| table.get("triangle")) else {
            return Err(self.error(section.span(), "covariance: triangle = [lower triangle, row by row] is wanted"));
        };
        let count = machine.parameters();
        let wanted = count * (count + 1) / 2;
        let Some(items) = triangle.get_ref().as_array() else {
            return Err(self.error(triangle.span(), "covariance: triangle is a list of numbers"));
        };
        let values = items.iter().map(|item| self.number(item, "triangle")).collect::<Result<Vec<f64>, _>>()?;
        if values.len() != wanted {
            let message = format!(
                "covariance: {count} constants of the machine have a tolerance, so {wanted} entries are wanted, there are {}",
                values.len()
            );
            return Err(self.error(triangle.span(), message));
        }
        Ok(Some(values))
    }
}
