//! The machine that a person sits in, from a rig's file.

use crate::identify::input_error::InputError;
use crate::identify::rig_file::{self, RigFile};
use glenoid::identification::hinge::HingeRig;
use glenoid::rig::{Parameters, Rig};
use std::path::Path;

/// The machine that a person sits in.
// There is one of it.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone, PartialEq)]
pub enum Machine {
    /// A shoulder's or a wrist's.
    Ball(Rig<f64>),
    /// An elbow's.
    Hinge(HingeRig<f64>),
}

/// The machine of a rig's file, or the shoulder. The person's joint is about where `[start]` or `[hinge]` of the file says.
///
/// # Errors
/// [`InputError`] names the place that cannot be read, or the constant that cannot be.
pub fn machine(path: Option<&Path>) -> Result<Machine, InputError> {
    let Some(path) = path else { return rig_file::default_rig().map(Machine::Ball) };
    match rig_file::read_hinge(path)? {
        Some(file) => Ok(Machine::Hinge(file.rig)),
        None => ball(path).map(Machine::Ball),
    }
}

fn ball(path: &Path) -> Result<Rig<f64>, InputError> {
    let RigFile { rig, start_mm, .. } = RigFile::read(path)?;
    let Some(start_mm) = start_mm else { return Ok(rig) };
    let nominal = Parameters::from_array(start_mm);
    let (drum, noise_mm) = (*rig.drum(), rig.length_noise_mm());
    let about = match rig.cables() {
        Some(cables) => Rig::with_cables(*cables, drum, noise_mm, nominal),
        None => Rig::new(*rig.base_mm(), *rig.edges_mm(), drum, noise_mm, nominal),
    };
    about
        .and_then(|about| rig.correction().map_or(Ok(about), |found| about.with_correction(*found)))
        .map_err(|error| InputError::Request(format!("{}: {}", path.display(), error.text())))
}
