//! A person whose joint is a ball, or a centre that moves with the arm: a shoulder or a wrist.

use super::person::{Person, PersonKind};
use super::sitter::{Now, Sample, Sitter, Truth};
use crate::wearer::{Wearer, WearerSettings};
use glenoid::rig::Rig;
use nalgebra::{Matrix3, Rotation3, Vector3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::io;

/// How far the centre of a living shoulder moves with the arm's rotation, mm for each radian about x, y and z: a few
/// millimetres up and forward in an elevation of 45 degrees, as in the cadavers of Meskers (1998) and later studies.
const MIGRATION_MM_PER_RAD: Matrix3<f64> = Matrix3::new(0.0, 6.0, 1.0, -6.0, 0.0, 1.0, 2.0, 2.0, 0.0);

/// While somebody holds the shoulder blade, the arm moves by this share of its usual angles: it stays within 30°.
const SHARE_WITH_BLADE_HELD: f64 = 0.5;

/// How far an attachment point of a machine as it is built may be off along each axis, mm.
const BUILT_WITHIN_MM: f64 = 0.5;

/// The person's own measures, in proportion to the machine: a wrist is smaller than a shoulder.
fn settings(person: &Person, drawn: &Rig<f64>) -> WearerSettings {
    const SHOULDER_RADIUS_MM: f64 = 140.8;
    let usual = WearerSettings::default();
    let [radius_mm, ..] = drawn.nominal().radii_mm;
    let size = radius_mm / SHOULDER_RADIUS_MM;
    WearerSettings {
        seed: person.seed,
        noise_mm: person.noise_mm,
        centre_offset_mm: usual.centre_offset_mm * size,
        cuff_offset_mm: usual.cuff_offset_mm * size,
        ..usual
    }
}

/// The machine that the person really sits in.
fn machine_of(person: &Person, drawn: Rig<f64>) -> io::Result<Rig<f64>> {
    match person.kind {
        PersonKind::Ball | PersonKind::Moving => return Ok(drawn),
        PersonKind::Straight => return Err(io::Error::other("--person straight is for an elbow's machine")),
        PersonKind::Built => {}
    }
    let mut random = ChaCha8Rng::seed_from_u64(person.seed);
    let mut off = || random.random_range(-BUILT_WITHIN_MM..=BUILT_WITHIN_MM);
    let base = drawn.base_mm().map(|point| point + Vector3::from_fn(|_, _| off()));
    let edges = drawn.edges_mm().map(|edge| edge + off());
    Rig::new(base, edges, *drawn.drum(), drawn.length_noise_mm(), *drawn.nominal())
        .map_err(|error| io::Error::other(error.text()))
}

/// The person in the machine.
pub(super) struct BallSitter {
    kind: PersonKind,
    wearer: Wearer,
    at: Rotation3<f64>,
}

impl BallSitter {
    /// A person with the arm at home, in a machine drawn like this.
    ///
    /// # Errors
    /// When such a person does not fit into it.
    pub(super) fn new(person: &Person, drawn: Rig<f64>) -> io::Result<Self> {
        let wearer = Wearer::new(machine_of(person, drawn)?, settings(person, &drawn));
        Ok(Self { kind: person.kind, wearer, at: Rotation3::identity() })
    }

    fn sample(&mut self, rotation: &Rotation3<f64>, blade_held: bool) -> Sample {
        let migration_mm = match self.kind {
            PersonKind::Moving if !blade_held => MIGRATION_MM_PER_RAD * rotation.scaled_axis(),
            _ => Vector3::zeros(),
        };
        let counts = self.wearer.sample(rotation, migration_mm, None);
        Sample { counts, now: Now::Centre((self.wearer.truth().centre_mm + migration_mm).into()) }
    }
}

impl Sitter for BallSitter {
    fn truth(&self) -> Truth {
        Truth::Centre(self.wearer.truth().centre_mm.into())
    }

    fn now(&self) -> Now {
        Now::Centre(self.wearer.truth().centre_mm.into())
    }

    fn rest(&mut self, blade_held: bool) -> Sample {
        let at = self.at;
        self.sample(&at, blade_held)
    }

    fn way(&mut self, blade_held: bool, duration_ms: u32, period_ms: u32) -> Vec<Sample> {
        let mut to = self.wearer.next_pose().rotation;
        if blade_held {
            to = to.powf(SHARE_WITH_BLADE_HELD);
        }
        let from = std::mem::replace(&mut self.at, to);
        Wearer::path(from, to, duration_ms, period_ms).map(|rotation| self.sample(&rotation, blade_held)).collect()
    }
}
