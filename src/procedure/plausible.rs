//! Can these numbers be a joint centre on this rig? Asked of every centre that is found, accepted, or loaded.
//!
//! A checksum says that a value is what was written; this says that it can be true.

use super::reason::Reason;
use super::solve::Detail;
use crate::rig::{Parameters, Rig};
use crate::scalar::Real;

/// What a centre may be on a rig.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Plausibility {
    /// Largest distance of the centre from where the rig expects it, mm.
    pub centre_mm: f32,
    /// Smallest distance from the centre to an end-point, mm.
    pub min_radius_mm: f32,
    /// Largest distance from the centre to an end-point, mm.
    pub max_radius_mm: f32,
    /// Largest σ of any of the six parameters, mm.
    pub sigma_mm: f32,
    /// Largest offset of an encoder, mm.
    pub offset_mm: f32,
}

impl Plausibility {
    /// The limits for the shoulder of Table I: those that [`Plausibility::for_rig`] gives for it.
    pub const SHOULDER: Self = Self {
        centre_mm: 140.8,
        min_radius_mm: 140.8 / 3.0,
        max_radius_mm: 140.8 * 3.0,
        sigma_mm: 7.9,
        offset_mm: 63.9,
    };

    /// Limits for a rig: the centre within one radius of where it is expected, an end-point
    /// within a third and three times of the expected radius.
    pub fn for_rig(rig: &Rig<f32>) -> Self {
        let Parameters { radii_mm, .. } = rig.nominal();
        let (smallest, largest) = radii_mm.iter().fold((f32::MAX, 0.0f32), |(s, l), r| (s.min(*r), l.max(*r)));
        Self {
            centre_mm: largest,
            min_radius_mm: smallest / 3.0,
            max_radius_mm: largest * 3.0,
            // what the fields of the bus hold
            sigma_mm: 7.9,
            offset_mm: 63.9,
        }
    }

    /// Are all limits positive numbers that leave room for a centre?
    pub fn is_sound(&self) -> bool {
        let all = [self.centre_mm, self.min_radius_mm, self.max_radius_mm, self.sigma_mm, self.offset_mm];
        all.iter().all(|limit| *limit > 0.0 && limit.is_finite()) && self.min_radius_mm < self.max_radius_mm
    }

    /// Looks whether a centre can be one.
    ///
    /// * `nominal`: where the rig expects it.
    /// * `sigma_mm`: σ of the six parameters.
    /// * `offsets_mm`: offsets of the encoders.
    ///
    /// # Errors
    /// The first thing that cannot be: [`Reason::CentreImplausible`], [`Reason::RadiusImplausible`],
    /// [`Reason::SigmaImplausible`], [`Reason::OffsetImplausible`].
    pub fn check(
        &self,
        nominal: &Parameters<f32>,
        parameters: &Parameters<f32>,
        sigma_mm: &[f32; 6],
        offsets_mm: &[f32],
    ) -> Result<(), Detail> {
        // each comparison is written so that NaN fails it
        let away_mm = (parameters.centre_mm - nominal.centre_mm).norm_squared().root();
        // on the platform's side of the base: {B}'s z axis points there
        let in_front = parameters.centre_mm.z > 0.0 || nominal.centre_mm.z <= 0.0;
        if !(away_mm <= self.centre_mm && in_front) {
            return Err(Detail { size_mm: Some(away_mm), ..Detail::of(Reason::CentreImplausible) });
        }
        if let Some(radius_mm) =
            parameters.radii_mm.iter().find(|r| !(**r >= self.min_radius_mm && **r <= self.max_radius_mm))
        {
            return Err(Detail { size_mm: Some(*radius_mm), ..Detail::of(Reason::RadiusImplausible) });
        }
        if let Some(sigma_mm) = sigma_mm.iter().find(|s| !(**s > 0.0 && **s <= self.sigma_mm)) {
            return Err(Detail { size_mm: Some(*sigma_mm), ..Detail::of(Reason::SigmaImplausible) });
        }
        if let Some((index, offset_mm)) =
            offsets_mm.iter().enumerate().find(|(_, offset)| !(offset.abs() <= self.offset_mm))
        {
            let cable = index as u8 + 1;
            return Err(Detail { cable, size_mm: Some(*offset_mm), ..Detail::of(Reason::OffsetImplausible) });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_constants_are_those_of_the_shoulder() {
        assert_eq!(Plausibility::for_rig(&Rig::shoulder(150.0).unwrap()), Plausibility::SHOULDER);
    }

    fn check(change: impl Fn(&mut Parameters<f32>, &mut [f32; 6], &mut [f32; 6])) -> Result<(), Reason> {
        let rig = Rig::shoulder(150.0).unwrap();
        let (mut parameters, mut sigma, mut offsets) = (*rig.nominal(), [0.05; 6], [0.0; 6]);
        change(&mut parameters, &mut sigma, &mut offsets);
        Plausibility::for_rig(&rig).check(rig.nominal(), &parameters, &sigma, &offsets).map_err(|detail| detail.reason)
    }

    #[test]
    fn what_cannot_be_is_named() {
        assert_eq!(check(|_, _, _| ()), Ok(()));
        // 60 mm along each axis: as far as the studies go
        assert_eq!(check(|p, _, _| p.centre_mm += nalgebra::Vector3::new(60.0, 60.0, 60.0)), Ok(()));
        assert_eq!(check(|p, _, _| p.centre_mm.x = 1e30), Err(Reason::CentreImplausible));
        assert_eq!(check(|p, _, _| p.centre_mm.x = f32::NAN), Err(Reason::CentreImplausible));
        assert_eq!(check(|p, _, _| p.centre_mm.z = -1.0), Err(Reason::CentreImplausible));
        assert_eq!(check(|p, _, _| p.radii_mm[1] = 20.0), Err(Reason::RadiusImplausible));
        assert_eq!(check(|p, _, _| p.radii_mm[2] = f32::INFINITY), Err(Reason::RadiusImplausible));
        assert_eq!(check(|_, s, _| s[0] = 0.0), Err(Reason::SigmaImplausible));
        assert_eq!(check(|_, s, _| s[5] = 9.0), Err(Reason::SigmaImplausible));
        assert_eq!(check(|_, s, _| s[5] = f32::NAN), Err(Reason::SigmaImplausible));
        assert_eq!(check(|_, _, o| o[3] = -64.0), Err(Reason::OffsetImplausible));
    }
}
