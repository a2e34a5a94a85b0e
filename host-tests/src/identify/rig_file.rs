//! A rig from a file in TOML, mm: `base = [[x, y, z], ..]` and `edges = [p12, p23, p31]`, or six `[[cable]]` tables; with
//! `home`, `[noise]`, `[tolerance]`, `[zeros]`, `[drum]` and `[covariance]` where they are known.

mod cables;
mod for_board;
mod hinge;
mod machine;
mod noise;
pub mod source;

pub use self::hinge::{HingeRigFile, read_hinge};
use self::source::Source;
use super::input_error::{self, InputError};
use super::{known_keys, units};
use glenoid::identification::Machine;
use glenoid::linear_algebra::packed_index;
use glenoid::rig::{
    ASSUMED_BASE_RADIUS_MM, CableEnds, Correction, Drum, POINTS, Parameters, Pulley, Rig, RigError, Tolerance,
};
use glenoid::scalar::Real;
use nalgebra::{DMatrix, Vector3};
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A rig, and what its file says beyond it.
#[derive(Clone, Debug, PartialEq)]
pub struct RigFile {
    /// The rig. What the file does not say (drum, noise, nominal centre) is the shoulder's.
    pub rig: Rig<f64>,
    /// Packed covariance that commissioning has left, in the order and units of [`Machine::parameter`].
    pub covariance: Option<Vec<f64>>,
    /// `values` of the section `[start]`: x, y, z, p1, p2, p3, mm.
    pub start_mm: Option<[f64; 6]>,
    /// How many samples each row of a log is the mean of, where the section `[noise]` states how noisy lengths are.
    pub samples_a_row: Option<u16>,
}

/// The rig that is meant when none is given: the shoulder over its assumed base, as well known as a hand-built one.
///
/// # Errors
/// None in practice; the constants are checked like any other rig's.
pub fn default_rig() -> Result<Rig<f64>, InputError> {
    Rig::shoulder(ASSUMED_BASE_RADIUS_MM)
        .and_then(|rig| rig.with_tolerance(Tolerance::hand_built()))
        .map_err(|error| InputError::Request(error.text().to_owned()))
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
    let noise_mm = T::of(rig.length_noise_mm());
    let point = |point: &Vector3<f64>| point.map(T::of);
    let cast = match rig.cables() {
        Some(cables) => {
            let ends = |cable: &CableEnds<f64>| CableEnds {
                base_mm: point(&cable.base_mm),
                end_mm: point(&cable.end_mm),
                pulley: Pulley { radius_mm: T::of(cable.pulley.radius_mm), axis: point(&cable.pulley.axis) },
            };
            Rig::with_cables(cables.each_ref().map(ends), drum, noise_mm, nominal)?
        }
        None => Rig::new(rig.base_mm().each_ref().map(point), rig.edges_mm().map(T::of), drum, noise_mm, nominal)?,
    };
    let tolerance = rig.tolerance();
    let cast = cast.with_noise(noise_mm, T::of(rig.sample_noise_mm()))?.with_tolerance(Tolerance {
        base_mm: T::of(tolerance.base_mm),
        edges_mm: T::of(tolerance.edges_mm),
        offset_mm: T::of(tolerance.offset_mm),
        drum: T::of(tolerance.drum),
    })?;
    match rig.correction() {
        Some(Correction { offset_mm, scale }) => {
            cast.with_correction(Correction { offset_mm: offset_mm.map(T::of), scale: scale.map(T::of) })
        }
        None => Ok(cast),
    }
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

    /// A rig that is in no file.
    pub fn of(rig: Rig<f64>) -> Self {
        Self { rig, covariance: None, start_mm: None, samples_a_row: None }
    }

    /// Standard deviation of a length in a row of a log, mm.
    pub fn row_noise_mm(&self) -> f64 {
        let (length, sample) = (self.rig.length_noise_mm(), self.rig.sample_noise_mm());
        (length * length + sample * sample / f64::from(self.samples_a_row.unwrap_or(1))).sqrt()
    }

    /// The machine in a precision: its tolerances, or what commissioning has left of them.
    pub fn machine<T: Real>(&self, rig: &Rig<T>) -> Machine<T> {
        let machine = Machine::new(rig);
        let Some(triangle) = &self.covariance else { return machine };
        let count = machine.parameters();
        let covariance = DMatrix::from_fn(count, count, |i, j| triangle[packed_index(i.max(j), i.min(j))]);
        match covariance.try_inverse() {
            Some(precision) => {
                let entries = (0..count).flat_map(|i| (0..=i).map(move |j| (i, j)));
                machine.with_precision(&entries.map(|place| T::of(precision[place])).collect::<Vec<_>>())
            }
            None => machine,
        }
    }

    /// Reads a rig from the bytes of its file. `file` is its name for messages.
    ///
    /// # Errors
    /// [`InputError`] names the place that cannot be read, or the constant that cannot be.
    pub fn parse(file: &str, bytes: &[u8]) -> Result<Self, InputError> {
        Source::of(file, bytes)?.rig_file()
    }
}

impl<'a> Source<'a> {
    /// The file's table, with no key in it that is not known.
    fn table(&self) -> Result<DeTable<'a>, InputError> {
        let table = self.any_table()?;
        match known_keys::unknown(&table) {
            Some((place, complaint)) => Err(self.error(place, complaint)),
            None => Ok(table),
        }
    }

    fn rig_file(&self) -> Result<RigFile, InputError> {
        let table = &self.table()?;
        self.is_no_hinge(table)?;
        let drum = self.drum(table)?;
        let rig = match table.get("cable") {
            Some(cables) => self.cables(table, cables, drum)?,
            None => self.triangles(table, drum)?,
        };
        let rig = self.known_machine(table, rig)?;
        let covariance = self.covariance(table, &Machine::new(&rig))?;
        let samples_a_row = self.noise(table)?.map(|noise| noise.samples_a_row);
        Ok(RigFile { rig, covariance, start_mm: self.start(table)?, samples_a_row })
    }

    /// The 3-3 machine.
    fn triangles(&self, table: &DeTable<'a>, drum: Drum<f64>) -> Result<Rig<f64>, InputError> {
        let base = self.value(table, "base", "[[x, y, z], [x, y, z], [x, y, z]], in mm,")?;
        let edges = self.value(table, "edges", "[p12, p23, p31], in mm,")?;
        let mut base_mm = [Vector3::zeros(); POINTS];
        for (point, value) in base_mm.iter_mut().zip(self.items::<POINTS>(base, "base", "points")?) {
            *point = Vector3::from(self.numbers(value, "a point of base")?);
        }
        let edges_mm = self.numbers(edges, "edges")?;
        self.rig(base, base_mm, edges, edges_mm, drum)
    }

    /// The checked rig; errors point at the invalid constant.
    fn rig(
        &self,
        base: &Spanned<DeValue<'a>>,
        base_mm: [Vector3<f64>; POINTS],
        edges: &Spanned<DeValue<'a>>,
        edges_mm: [f64; POINTS],
        drum: Drum<f64>,
    ) -> Result<Rig<f64>, InputError> {
        let shoulder = default_rig()?;
        let rig =
            Rig::new(base_mm, edges_mm, drum, shoulder.length_noise_mm(), *shoulder.nominal()).map_err(|error| {
                match error {
                    RigError::PlatformCollapsed => self.error(edges.span(), format!("{}: {edges_mm:?}", error.text())),
                    RigError::BaseCollapsed => {
                        self.error(base.span(), coinciding(&base_mm).unwrap_or(error.text().to_owned()))
                    }
                    _ => self.error(base.span(), error.text()),
                }
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
}

/// Names attachment points that coincide.
fn coinciding(base_mm: &[Vector3<f64>; POINTS]) -> Option<String> {
    let pairs = [(0, 1), (1, 2), (2, 0)];
    let (i, j) = pairs.into_iter().find(|&(i, j)| base_mm[i] == base_mm[j])?;
    Some(format!("the attachment points B{} and B{} coincide", i + 1, j + 1))
}
