//! What is known of the machine about a hinge: two to four cables, and the drawing.

use super::joint::{HINGE_UNKNOWNS, Hinge};
use crate::rig::{CableEnds, RigError, Tolerance};
use crate::scalar::Real;
use heapless::Vec;

/// Maximum number of cables about a hinge.
pub const MAX_CABLES: usize = 4;

/// Two ends nearer than this are one point, mm.
const MIN_APART_MM: f64 = 1e-3;

/// Where the drawing puts the hinge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drawing<T: Real> {
    /// The hinge as drawn. Angle zero is its own.
    pub hinge: Hinge<T>,
    /// How well each unknown is known beforehand, 1σ, in the order of [`HINGE_UNKNOWNS`], rad and mm; `None`: the drawing
    /// only tells two solutions apart.
    pub sigma: Option<[T; HINGE_UNKNOWNS]>,
    /// Smallest and largest angle of the joint from the drawing's zero, rad.
    pub range_rad: (T, T),
}

/// A hinge's machine.
#[derive(Clone, Debug, PartialEq)]
pub struct HingeRig<T: Real> {
    cables: Vec<CableEnds<T>, MAX_CABLES>,
    home_length_mm: [T; MAX_CABLES],
    length_noise_mm: T,
    tolerance: Tolerance<T>,
    drawing: Option<Drawing<T>>,
}

impl<T: Real> HingeRig<T> {
    /// A rig of two to four cables, exactly known, without a drawing. `length_noise_mm`: 1σ of one length, mm. The platform
    /// lies on the +z side of the base's frame.
    ///
    /// # Errors
    /// [`RigError`]: a number that is none, a pulley or noise that cannot be, ends that coincide; also for fewer than two
    /// cables, which have no length to spare for an angle.
    pub fn new(cables: &[CableEnds<T>], length_noise_mm: T) -> Result<Self, RigError> {
        let finite =
            |cable: &CableEnds<T>| cable.base_mm.iter().chain(cable.end_mm.iter()).all(|number| number.is_a_number());
        if !cables.iter().all(finite) {
            return Err(RigError::NotFinite);
        }
        let possible = |cable: &CableEnds<T>| {
            let is_direction = (cable.pulley.axis.norm_squared() - T::one()).abs() < T::of(1e-3);
            cable.pulley.radius_mm >= T::zero() && cable.pulley.radius_mm < T::of(1e3) && is_direction
        };
        if !cables.iter().all(possible) {
            return Err(RigError::PulleyImpossible);
        }
        let near = T::of(MIN_APART_MM * MIN_APART_MM);
        for (index, one) in cables.iter().enumerate() {
            let same = |other: &CableEnds<T>| {
                (one.base_mm - other.base_mm).norm_squared() < near && (one.end_mm - other.end_mm).norm_squared() < near
            };
            if cables.iter().skip(index + 1).any(same) {
                return Err(RigError::EndsCoincide);
            }
        }
        if !(length_noise_mm.is_a_number() && length_noise_mm > T::zero()) {
            return Err(RigError::NoiseNotPositive);
        }
        let cables = Vec::from_slice(cables).ok().filter(|cables| cables.len() >= 2).ok_or(RigError::NotFinite)?;
        Ok(Self {
            cables,
            home_length_mm: [T::zero(); MAX_CABLES],
            length_noise_mm,
            tolerance: Tolerance::exact(),
            drawing: None,
        })
    }

    /// The same rig, known with this tolerance: `base_mm` each coordinate of an attachment point, `edges_mm` of an end,
    /// `offset_mm` each encoder, `drum` each drum's radius. Drums act about the lengths at count zero: reading = home +
    /// scale (L − home) + offset.
    ///
    /// # Errors
    /// [`RigError::ToleranceImpossible`].
    pub fn with_tolerance(
        mut self,
        tolerance: Tolerance<T>,
        home_length_mm: [T; MAX_CABLES],
    ) -> Result<Self, RigError> {
        if !tolerance.is_possible() || !home_length_mm.iter().all(|length| length.is_a_number()) {
            return Err(RigError::ToleranceImpossible);
        }
        (self.tolerance, self.home_length_mm) = (tolerance, home_length_mm);
        Ok(self)
    }

    /// The same rig with a drawing.
    #[must_use]
    pub fn with_drawing(mut self, drawing: Drawing<T>) -> Self {
        self.drawing = Some(drawing);
        self
    }

    /// The same rig without its drawing.
    #[must_use]
    pub fn without_drawing(mut self) -> Self {
        self.drawing = None;
        self
    }

    /// The cables' ends: the base's in {B}, the platform's in {P}, mm.
    pub fn cables(&self) -> &[CableEnds<T>] {
        &self.cables
    }

    /// Length of each cable at count zero, mm.
    pub fn home_length_mm(&self) -> &[T; MAX_CABLES] {
        &self.home_length_mm
    }

    /// 1σ of one length, mm.
    pub fn length_noise_mm(&self) -> T {
        self.length_noise_mm
    }

    /// How well the machine is known, 1σ.
    pub fn tolerance(&self) -> &Tolerance<T> {
        &self.tolerance
    }

    /// The drawing.
    pub fn drawing(&self) -> Option<&Drawing<T>> {
        self.drawing.as_ref()
    }
}
