//! An elbow's module: the hinge's machine and its drive.

use crate::identification::hinge::{Drawing, Hinge, HingeRig, MAX_CABLES};
use crate::rig::{CABLES, CableEnds, Drum, Pulley, RigError, Tolerance};
use crate::scalar::Real;
use nalgebra::Vector3;

/// The hinge's machine with the drums of its cables. A board has six encoders; those beyond the cables are not in use.
#[derive(Clone, Debug, PartialEq)]
pub struct ElbowRig {
    hinge: HingeRig<f32>,
    drum: Drum<f32>,
}

impl ElbowRig {
    /// A rig from its constants, checked. `length_noise_mm`: 1σ of one length, mm.
    ///
    /// # Errors
    /// [`RigError`] names the first constant that is impossible; [`RigError::DrawingMissing`] where there are fewer than four
    /// cables and no drawing that is a prior, for then the lengths do not determine a hinge.
    pub fn new(
        cables: &[CableEnds<f32>],
        drum: Drum<f32>,
        length_noise_mm: f32,
        tolerance: Tolerance<f32>,
        drawing: Option<Drawing<f32>>,
    ) -> Result<Self, RigError> {
        if !drum.is_possible() {
            return Err(RigError::DrumNotPositive);
        }
        let [l1, l2, l3, l4, ..] = drum.home_length_mm;
        let hinge = HingeRig::new(cables, length_noise_mm)?.with_tolerance(tolerance, [l1, l2, l3, l4])?;
        let is_prior = drawing.as_ref().is_some_and(|drawing| drawing.sigma.is_some());
        if cables.len() < MAX_CABLES && !is_prior {
            return Err(RigError::DrawingMissing);
        }
        let hinge = drawing.into_iter().fold(hinge, HingeRig::with_drawing);
        Ok(Self { hinge, drum })
    }

    /// Four cables between rings of 60 mm on the upper arm and 45 mm on the forearm, the ends turned by 25 degrees against the
    /// base's points, to either side alternately; the shoulder's drums; lengths known to 0.058 mm (±0.1 mm). The drawing, of an
    /// axis 160 mm beyond the one ring and 70 mm before the other, only tells two solutions apart.
    ///
    /// # Errors
    /// None: the constants are sound, and a test shows it.
    pub fn four_cables() -> Result<Self, RigError> {
        let point = |radius_mm: f32, degrees: f32| {
            let (sin, cos) = libm::sincosf(degrees.to_radians());
            Vector3::new(radius_mm * cos, radius_mm * sin, 0.0)
        };
        let cables = [(45.0, 70.0), (135.0, 110.0), (225.0, 250.0), (315.0, 290.0)].map(|(base, end)| CableEnds {
            base_mm: point(60.0, base),
            end_mm: point(45.0, end),
            pulley: Pulley::none(),
        });
        let drum = Drum {
            radius_mm: 15.0,
            counts_per_turn: 4096.0,
            home_length_mm: [230.0; CABLES],
            fastest_mm_per_s: 1500.0,
        };
        let (x, z) = (Vector3::x(), Vector3::z());
        let hinge = Hinge::through(&x, &(z * 160.0), &x, &(z * -70.0));
        // From 140 degrees of flexion to 15 beyond straight.
        let drawing = Drawing { hinge, sigma: None, range_rad: (-2.45, 0.27) };
        Self::new(&cables, drum, 0.057_735, Tolerance::exact(), Some(drawing))
    }

    /// The hinge's machine.
    pub const fn hinge(&self) -> &HingeRig<f32> {
        &self.hinge
    }

    /// The drums.
    pub const fn drum(&self) -> &Drum<f32> {
        &self.drum
    }

    /// Cables, which are also the encoders in use, from the first on.
    pub fn cables(&self) -> u8 {
        self.hinge.cables().len() as u8
    }

    /// The lengths where the counts stand `above` the counts `first`, mm; 0 for cables that the rig has not.
    ///
    /// # Errors
    /// The first cable, from 1, whose length would not be positive.
    pub fn lengths_mm(&self, first: &[i32], above: &[f32]) -> Result<[f32; MAX_CABLES], u8> {
        let mut lengths_mm = [0.0; MAX_CABLES];
        let counts = first.iter().zip(above).zip(&self.drum.home_length_mm).take(self.hinge.cables().len());
        for (cable, (length, ((first, above), home))) in (1..).zip(lengths_mm.iter_mut().zip(counts)) {
            *length = home + (*first as f32 + above) * self.drum.mm_per_count();
            if !(*length > 0.0 && length.is_finite()) {
                return Err(cable);
            }
        }
        Ok(lengths_mm)
    }

    /// Radius of the ring of the platform's ends, root mean square, mm: about how far a cable's length changes with a radian.
    pub fn ring_mm(&self) -> f32 {
        let cables = self.hinge.cables();
        let count = cables.len() as f32;
        let middle = cables.iter().fold(Vector3::zeros(), |sum, cable| sum + cable.end_mm) / count;
        let squares = cables.iter().fold(0.0, |sum, cable| sum + (cable.end_mm - middle).norm_squared());
        (squares / count).root()
    }
}
