//! A rig whose cables have ends of their own: six `[[cable]]` tables.

use super::default_rig;
use super::source::Source;
use crate::identify::input_error::InputError;
use crate::wearer::{Cables, FittedArm};
use glenoid::rig::{CABLES, CableEnds, Drum, Pulley, Rig, RigError};
use nalgebra::Vector3;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// No pulley of a rehabilitator is this large, mm.
const MOST_RADIUS_MM: f64 = 1000.0;

impl<'a> Source<'a> {
    /// The rig of six `[[cable]]` tables.
    pub(super) fn cables(
        &self,
        file: &DeTable<'a>,
        tables: &Spanned<DeValue<'a>>,
        drum: Drum<f64>,
    ) -> Result<Rig<f64>, InputError> {
        for other in ["base", "edges"] {
            if let Some(value) = file.get(other) {
                return Err(
                    self.error(value.span(), format!("{other} and [[cable]] contradict each other: one or the other"))
                );
            }
        }
        let mut ends = Vec::new();
        for cable in self.items::<CABLES>(tables, "cable", "tables [[cable]]")? {
            ends.push(self.cable(cable)?);
        }
        let ends: [CableEnds<f64>; CABLES] =
            ends.try_into().map_err(|_| self.error(tables.span(), "six [[cable]] tables are wanted"))?;
        let shoulder = default_rig()?;
        let rig = Rig::with_cables(ends, drum, shoulder.length_noise_mm(), *shoulder.nominal())
            .map_err(|error| self.error(tables.span(), which(&error, &ends)))?;
        match unreached(&rig) {
            Some(cable) => {
                let radius_mm = ends[cable].pulley.radius_mm;
                let message =
                    format!("cable {}: a pulley of {radius_mm} mm cannot be reached by its cable at home", cable + 1);
                Err(self.error(tables.span(), message))
            }
            None => Ok(rig),
        }
    }

    pub(super) fn cable(&self, value: &Spanned<DeValue<'a>>) -> Result<CableEnds<f64>, InputError> {
        let Some(table) = value.get_ref().as_table() else {
            return Err(self.error(value.span(), "cable: a table [[cable]] is wanted"));
        };
        let point = |key: &str| {
            let value = self.value_at(value.span(), table, key, "[x, y, z], in mm,")?;
            Ok(Vector3::from(self.numbers::<3>(value, key)?))
        };
        let (base_mm, end_mm) = (point("base")?, point("end")?);
        let mut pulley = Pulley::none();
        if let Some(radius) = table.get("pulley_radius") {
            pulley.radius_mm = self.number(radius, "pulley_radius")?;
            if !(0.0..MOST_RADIUS_MM).contains(&pulley.radius_mm) {
                let message = format!("pulley_radius: a radius is not negative, and below {MOST_RADIUS_MM} mm");
                return Err(self.error(radius.span(), message));
            }
            let axis = self.value_at(value.span(), table, "pulley_axis", "[x, y, z]")?;
            let direction = Vector3::from(self.numbers::<3>(axis, "pulley_axis")?);
            pulley.axis = direction
                .try_normalize(1e-9)
                .ok_or_else(|| self.error(axis.span(), "pulley_axis: the direction has no length"))?;
        } else if let Some(axis) = table.get("pulley_axis") {
            return Err(self.error(axis.span(), "pulley_axis without pulley_radius"));
        }
        Ok(CableEnds { base_mm, end_mm, pulley })
    }
}

/// The first cable, from 0, whose end lies within its pulley's wheel when the platform is at home.
fn unreached(rig: &Rig<f64>) -> Option<usize> {
    let home = FittedArm::new(rig, Vector3::zeros(), Vector3::zeros());
    let cables = Cables::new(rig);
    let ends_mm = home.ends_mm().map(|end| home.centre_mm() + end);
    // A platform without a home by the drawing has none to compare with.
    if !ends_mm.iter().all(|end| end.norm().is_finite()) {
        return None;
    }
    cables.lengths_mm(&ends_mm).iter().position(|length| !length.is_finite())
}

/// Names the cables that a complaint is about.
pub(super) fn which(error: &RigError, ends: &[CableEnds<f64>]) -> String {
    if *error == RigError::EndsCoincide {
        for i in 0..ends.len() {
            for j in i + 1..ends.len() {
                let same = (ends[i].base_mm - ends[j].base_mm).norm() < 1e-3
                    && (ends[i].end_mm - ends[j].end_mm).norm() < 1e-3;
                if same {
                    return format!("cables {} and {}: {}", i + 1, j + 1, error.text());
                }
            }
        }
    }
    error.text().to_owned()
}
