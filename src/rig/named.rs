//! The rigs that are compiled in.

use super::{CABLES, Drum, POINTS, Parameters, Rig, RigError};
use crate::scalar::Real;
use nalgebra::Vector3;

/// Table I: distance from the joint centre to each end-point, mm.
const PAPER_RADIUS_MM: f64 = 140.8;
/// Table I: height of the platform's plane above the joint centre at home, mm.
const PAPER_PLATFORM_HEIGHT_MM: f64 = 96.0;
/// Table I: height of the joint centre above the base's plane, mm.
const PAPER_CENTRE_HEIGHT_MM: f64 = 148.0;
/// The base radius is missing from the stored Table I. 150 mm is an assumption: it is what can be worn, and it lies
/// in the range (120-350 mm) over which the method is studied.
pub const ASSUMED_BASE_RADIUS_MM: f64 = 150.0;

/// Standard deviation of the paper's cable noise, uniform within ±0.1 mm: 0.1 / sqrt(3), mm.
const PAPER_NOISE_MM: f64 = 0.057_735_026_918_962_58;

impl<T: Real> Rig<T> {
    /// The shoulder rehabilitator of Table I with an equilateral base of the given radius, mm, in the plane z = 0,
    /// turned by 60 degrees against the platform (at home all six cables have equal lengths).
    ///
    /// The edges are derived from the radii and the height, not taken from Table I: its 178.4 mm is rounded from
    /// 178.3982 mm, which alone would leave a deviation of 1.8e-3 mm, above the paper's tolerance.
    ///
    /// # Errors
    /// [`RigError`] when the radius is not a positive finite number.
    pub fn shoulder(base_radius_mm: T) -> Result<Self, RigError> {
        let (radius, height) = (T::of(PAPER_RADIUS_MM), T::of(PAPER_PLATFORM_HEIGHT_MM));
        Self::symmetric(base_radius_mm, T::of(PAPER_CENTRE_HEIGHT_MM), radius, height, T::of(15.0))
    }

    /// The wrist module of the 7-DOF arm: the same 3-3 arrangement at wrist size. The paper gives no dimensions for
    /// it; these are this project's assumption (a forearm cuff of 60 mm radius, a hand plate of 40 mm radius).
    ///
    /// # Errors
    /// None in practice; the constants are checked like any other rig's.
    pub fn wrist() -> Result<Self, RigError> {
        Self::symmetric(T::of(60.0), T::of(62.0), T::of(56.0), T::of(39.0), T::of(8.0))
    }

    /// Equilateral base and platform about the z axis, turned by 60 degrees against each other.
    fn symmetric(base_radius: T, centre_height: T, radius: T, height: T, drum_radius: T) -> Result<Self, RigError> {
        let half = T::of(0.5);
        let half_root_3 = T::of(3.0).root() * half;
        let base_mm = [
            Vector3::new(base_radius, T::zero(), T::zero()),
            Vector3::new(-base_radius * half, base_radius * half_root_3, T::zero()),
            Vector3::new(-base_radius * half, -base_radius * half_root_3, T::zero()),
        ];
        let circumradius = (radius * radius - height * height).root();
        let edge = circumradius * T::of(3.0).root();
        // At home P1 lies above the middle of B1 B2: the law of cosines at 60 degrees, and the height of the platform.
        let across = base_radius * base_radius + circumradius * circumradius - base_radius * circumradius;
        let rise = centre_height + height;
        let home = (across + rise * rise).root();
        let drum = Drum {
            radius_mm: drum_radius,
            // 1024 lines in quadrature.
            counts_per_turn: T::of(4096.0),
            home_length_mm: [home; CABLES],
            fastest_mm_per_s: T::of(1500.0),
        };
        let nominal =
            Parameters { centre_mm: Vector3::new(T::zero(), T::zero(), centre_height), radii_mm: [radius; POINTS] };
        Self::new(base_mm, [edge; POINTS], drum, T::of(PAPER_NOISE_MM), nominal)
    }
}
