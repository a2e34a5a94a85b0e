//! The rig of a hinge: `joint = "hinge"`, two to four `[[cable]]` tables, and the drawing in `[hinge]`.

use super::cables::which;
use super::source::Source;
use crate::identify::input_error::{self, InputError};
use crate::identify::units;
use glenoid::identification::hinge::{Drawing, Hinge, HingeRig, MAX_CABLES};
use glenoid::rig::{CableEnds, Rig, Tolerance};
use nalgebra::Vector3;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;
use toml::de::DeTable;

/// The range of an elbow about a drawing that does not say it, degrees: bending is negative about an axis that points to
/// the arm's right.
const RANGE_DEG: [f64; 2] = [-150.0, 150.0];

/// No joint is drawn further from the origin of its frames than a board can be told, mm.
const FARTHEST_MM: f64 = 2000.0;

/// A turn in radians: no hinge bends by so few degrees only.
const TURN_RAD: f64 = core::f64::consts::TAU;

/// What refines `sigma_deg` and `sigma_mm`.
const FINER: [&str; 3] = ["sigma_in_platform_deg", "sigma_in_platform_mm", "sigma_along_mm"];

/// What the file of a hinge's rig says.
#[derive(Clone, Debug, PartialEq)]
pub struct HingeRigFile {
    /// The rig.
    pub rig: HingeRig<f64>,
    /// 1σ of a length in a row of a log, mm, where the section `[noise]` states it.
    pub noise_mm: Option<f64>,
}

/// The rig of a hinge; `None` where the file does not say `joint = "hinge"`.
///
/// # Errors
/// [`InputError`] names the place that cannot be read, or the constant that cannot be.
pub fn read_hinge(path: &Path) -> Result<Option<HingeRigFile>, InputError> {
    let (file, bytes) = input_error::read(path)?;
    let source = Source::of(&file, &bytes)?;
    let table = &source.table()?;
    let Some(joint) = table.get("joint") else { return Ok(None) };
    match joint.get_ref().as_str() {
        Some("hinge") => source.hinge_rig(table).map(Some),
        Some("ball") => Ok(None),
        _ => Err(source.error(joint.span(), "joint: \"ball\" or \"hinge\" is wanted")),
    }
}

impl<'a> Source<'a> {
    /// Refuses a hinge, and its drawing or its cables in a file that does not say that it is one.
    pub(super) fn is_no_hinge(&self, table: &DeTable<'a>) -> Result<(), InputError> {
        const SAY: &str = "joint = \"hinge\" is wanted at the top of the file";
        if let Some(joint) = table.get("joint").filter(|joint| joint.get_ref().as_str() == Some("hinge")) {
            return Err(self.error(joint.span(), "joint: a hinge, where a ball is wanted"));
        }
        if let Some(section) = table.get("hinge") {
            return Err(self.error(section.span(), format!("hinge: a ball has no such section; for an elbow {SAY}")));
        }
        let Some(cables) = table.get("cable") else { return Ok(()) };
        match cables.get_ref().as_array().map_or(0, |cables| cables.len()) {
            count @ 2..=MAX_CABLES => {
                let message = format!("cable: a ball has six tables [[cable]], there are {count}; for an elbow {SAY}");
                Err(self.error(cables.span(), message))
            }
            _ => Ok(()),
        }
    }

    fn hinge_rig(&self, table: &DeTable<'a>) -> Result<HingeRigFile, InputError> {
        for other in ["base", "edges", "zeros", "drum", "covariance", "start"] {
            if let Some(value) = table.get(other) {
                return Err(self.error(value.span(), format!("{other} is not for a hinge")));
            }
        }
        let tables = self.value(table, "cable", "two to four tables [[cable]]")?;
        let items = tables.get_ref().as_array();
        let count = items.map_or(0, |items| items.len());
        let Some(items) = items.filter(|_| (2..=MAX_CABLES).contains(&count)) else {
            let message = format!("cable: a hinge has two to four tables [[cable]], there are {count}");
            return Err(self.error(tables.span(), message));
        };
        let cables = items.iter().map(|cable| self.cable(cable)).collect::<Result<Vec<_>, _>>()?;
        let noise_mm = self.noise(table)?.map(|noise| noise.of_a_row_mm());
        let expected_mm = noise_mm.unwrap_or_else(|| Rig::<f64>::wrist().map_or(0.1, |rig| rig.length_noise_mm()));
        let rig =
            HingeRig::new(&cables, expected_mm).map_err(|error| self.error(tables.span(), which(&error, &cables)))?;
        if let Some(complaint) = units::complaint_about_rig("distance between two ends on one ring", &apart_mm(&cables))
        {
            return Err(self.error(tables.span(), complaint));
        }
        let (place, tolerance) = match self.tolerance(table)? {
            None => (tables.span(), Tolerance::exact()),
            Some((section, tolerance)) => (section.span(), tolerance),
        };
        let home = self.home_of_hinge(table, place.clone(), &tolerance, count)?;
        let rig = rig.with_tolerance(tolerance, home).map_err(|error| self.error(place, error.text()))?;
        let rig = match self.drawing(table)? {
            None => rig,
            Some(drawing) => rig.with_drawing(drawing),
        };
        Ok(HingeRigFile { rig, noise_mm })
    }

    /// Lengths at count zero, about which a drum's scale acts.
    fn home_of_hinge(
        &self,
        table: &DeTable<'a>,
        tolerance_at: Range<usize>,
        tolerance: &Tolerance<f64>,
        count: usize,
    ) -> Result<[f64; MAX_CABLES], InputError> {
        let mut home_mm = [0.0; MAX_CABLES];
        let Some(home) = table.get("home") else {
            return if tolerance.drum > 0.0 {
                let message = format!("drum: home = [{count} lengths] is wanted, about which a drum's radius acts");
                Err(self.error(tolerance_at, message))
            } else {
                Ok(home_mm)
            };
        };
        let numbers = home.get_ref().as_array().filter(|numbers| numbers.len() == count);
        let Some(numbers) = numbers else {
            return Err(self.error(home.span(), format!("home: [{count} lengths] is wanted, one a cable")));
        };
        for (length, item) in home_mm.iter_mut().zip(numbers.iter()) {
            *length = self.number(item, "home")?;
            if *length <= 0.0 {
                return Err(self.error(item.span(), "home: a length is positive"));
            }
        }
        Ok(home_mm)
    }

    fn drawing(&self, table: &DeTable<'a>) -> Result<Option<Drawing<f64>>, InputError> {
        let Some(section) = table.get("hinge") else { return Ok(None) };
        let Some(keys) = section.get_ref().as_table() else {
            return Err(self.error(section.span(), "hinge: a section [hinge] is wanted"));
        };
        let vector = |key: &str, shape: &str| {
            let value = self.value_at(section.span(), keys, key, shape)?;
            Ok((Vector3::from(self.numbers::<3>(value, key)?), value.span()))
        };
        let point = |key: &str| match vector(key, "[x, y, z], in mm,")? {
            (point, _) if point.amax() <= FARTHEST_MM => Ok(point),
            (_, place) => Err(self.error(place, format!("{key}: coordinates within {FARTHEST_MM} mm are wanted"))),
        };
        let direction = |key: &str| {
            let (vector, place) = vector(key, "[x, y, z]")?;
            vector.try_normalize(1e-9).ok_or_else(|| self.error(place, format!("{key}: the direction has no length")))
        };
        let hinge = Hinge::through(
            &direction("axis")?,
            &point("point")?,
            &direction("axis_in_platform")?,
            &point("point_in_platform")?,
        );
        let range = match keys.get("range_deg") {
            None => RANGE_DEG,
            Some(value) => self.numbers::<2>(value, "range_deg")?,
        };
        let [low, high] = range;
        if !(low < high && high - low <= 360.0 && low >= -360.0 && high <= 360.0) {
            let place = keys.get("range_deg").map_or(section.span(), Spanned::span);
            let message = "range_deg: [smallest, largest] within one turn is wanted, each from -360 to 360";
            return Err(self.error(place, message));
        }
        if let Some(value) = keys.get("range_deg").filter(|_| high - low <= TURN_RAD) {
            let message = format!("range_deg: a range of {} looks like radians; degrees are wanted", high - low);
            return Err(self.error(value.span(), message));
        }
        let sigma = |key: &str| match keys.get(key) {
            None => Ok(None),
            Some(value) => match self.number(value, key)? {
                sigma if sigma > 0.0 => Ok(Some(sigma)),
                _ => Err(self.error(value.span(), format!("{key}: a standard deviation is positive"))),
            },
        };
        let sigma = match (sigma("sigma_deg")?, sigma("sigma_mm")?) {
            (None, None) => match FINER.iter().find_map(|key| Some((key, keys.get(*key)?))) {
                None => None,
                Some((key, value)) => {
                    return Err(self.error(value.span(), format!("{key} wants sigma_deg and sigma_mm beside it")));
                }
            },
            (Some(turn), Some(place)) => {
                let turn_in_platform = sigma("sigma_in_platform_deg")?.unwrap_or(turn).to_radians();
                let place_in_platform = sigma("sigma_in_platform_mm")?.unwrap_or(place);
                let along = sigma("sigma_along_mm")?.unwrap_or(place);
                let turn = turn.to_radians();
                let (d, q) = (turn_in_platform, place_in_platform);
                Some([turn, turn, place, place, d, d, q, q, along])
            }
            _ => return Err(self.error(section.span(), "hinge: sigma_deg and sigma_mm belong together")),
        };
        Ok(Some(Drawing { hinge, sigma, range_rad: (low.to_radians(), high.to_radians()) }))
    }
}

/// Distances between any two of the cables' ends on the base, and on the platform, mm.
fn apart_mm(cables: &[CableEnds<f64>]) -> Vec<f64> {
    let pairs =
        cables.iter().enumerate().flat_map(|(index, one)| cables[index + 1..].iter().map(move |other| (one, other)));
    pairs.flat_map(|(one, other)| [(one.base_mm - other.base_mm).norm(), (one.end_mm - other.end_mm).norm()]).collect()
}
