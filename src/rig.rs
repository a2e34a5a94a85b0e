//! Every constant of the machine, in one place: a [`Rig`] is a value, and another machine is another value.
//!
//! Frames: {B} is fixed to the base, its z axis points from the base towards the moving platform. {P} is fixed to
//! the moving platform.

use crate::calls::root;
use crate::scalar::Real;
use nalgebra::Vector3;

/// Number of cables, of base attachment points and of platform end-points.
pub const CABLES: usize = 6;
/// Base attachment points B1..B3, platform end-points P1..P3, platform edges p12, p23, p31.
pub const POINTS: usize = 3;

/// For each end-point P1..P3 the two attachment points (from 0) that its two cables run to, in cable order:
/// L1 = P1 B1, L2 = P1 B2, L3 = P2 B2, L4 = P2 B3, L5 = P3 B3, L6 = P3 B1 (Eq. 2, 3, 5, 6, 8, 9).
pub const ATTACHMENTS: [[usize; 2]; POINTS] = [[0, 1], [1, 2], [2, 0]];

/// For each platform edge p12, p23, p31 its two end-points (from 0), Eq. 10-12.
pub const EDGE_ENDS: [[usize; 2]; POINTS] = [[0, 1], [1, 2], [2, 0]];

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

/// How a motor's encoder turns into a cable length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drum<T> {
    /// Radius at which the cable leaves the drum, mm, positive.
    pub radius_mm: T,
    /// Counts of one drum turn (quadrature counts times gear ratio), positive.
    pub counts_per_turn: T,
    /// Length of each cable at count zero, mm, positive. Counts rise as cable is paid out.
    pub home_length_mm: [T; CABLES],
    /// Fastest that the drive can move a cable, mm/s, positive. A faster change is a fault of the encoder.
    pub fastest_mm_per_s: T,
}

/// The machine: geometry, drive and limits. Made by [`Rig::new`] or one of the named rigs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rig<T> {
    base_mm: [Vector3<T>; POINTS],
    edges_mm: [T; POINTS],
    drum: Drum<T>,
    length_noise_mm: T,
    nominal: Parameters<T>,
}

/// What is identified: the joint centre in {B} and its distances to the three end-points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters<T> {
    /// Joint centre O in {B}, mm.
    pub centre_mm: Vector3<T>,
    /// Distances |OP1|, |OP2|, |OP3|, mm.
    pub radii_mm: [T; POINTS],
}

impl<T: Real> Parameters<T> {
    /// The six unknowns in the paper's order x, y, z, p1, p2, p3, mm.
    pub fn to_array(self) -> [T; 6] {
        let [x, y, z] = self.centre_mm.into();
        let [p1, p2, p3] = self.radii_mm;
        [x, y, z, p1, p2, p3]
    }

    /// From the six unknowns in the paper's order x, y, z, p1, p2, p3, mm.
    pub fn from_array([x, y, z, p1, p2, p3]: [T; 6]) -> Self {
        Self { centre_mm: Vector3::new(x, y, z), radii_mm: [p1, p2, p3] }
    }

    /// Eq. 16: these parameters moved by `step` (mm, order x, y, z, p1, p2, p3).
    #[must_use]
    pub fn moved_by(self, step: &[T; 6]) -> Self {
        let now = self.to_array();
        Self::from_array(core::array::from_fn(|k| now[k] + step[k]))
    }
}

/// Why a set of constants is not a rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum RigError {
    /// A constant is NaN or infinite.
    NotFinite = 1,
    /// Two attachment points coincide, or the three lie on one line.
    BaseCollapsed = 2,
    /// The plane of the attachment points is (nearly) parallel to the z axis of {B}, so that the side on which the
    /// platform lies is not defined.
    BaseOnEdge = 3,
    /// The three edges of the platform do not make a triangle.
    PlatformCollapsed = 4,
    /// Drum radius, counts per turn, home length or speed is not positive.
    DrumNotPositive = 5,
    /// The noise of a cable length is not positive.
    NoiseNotPositive = 6,
    /// A nominal radius is not positive.
    RadiusNotPositive = 7,
}

impl RigError {
    /// The reason in words.
    pub const fn text(self) -> &'static str {
        match self {
            Self::NotFinite => "a constant is not a finite number",
            Self::BaseCollapsed => "attachment points coincide or lie on one line",
            Self::BaseOnEdge => "the base plane is parallel to the z axis of {B}",
            Self::PlatformCollapsed => "the platform's edges do not make a triangle",
            Self::DrumNotPositive => "a drum constant is not positive",
            Self::NoiseNotPositive => "the cable noise is not positive",
            Self::RadiusNotPositive => "a nominal radius is not positive",
        }
    }
}

impl<T: Real> Rig<T> {
    /// A rig from its constants, checked.
    ///
    /// * `base_mm`: attachment points B1..B3 in {B}, mm. They need not be equilateral nor at z = 0; the platform lies
    ///   on their +z side.
    /// * `edges_mm`: platform edges p12, p23, p31, mm.
    /// * `length_noise_mm`: standard deviation of one cable length, mm.
    /// * `nominal`: where the centre is expected (the paper's skin-based start), mm.
    ///
    /// # Errors
    /// [`RigError`] names the first constant that cannot be.
    pub fn new(
        base_mm: [Vector3<T>; POINTS],
        edges_mm: [T; POINTS],
        drum: Drum<T>,
        length_noise_mm: T,
        nominal: Parameters<T>,
    ) -> Result<Self, RigError> {
        let rig = Self { base_mm, edges_mm, drum, length_noise_mm, nominal };
        rig.check()?;
        Ok(rig)
    }

    fn check(&self) -> Result<(), RigError> {
        let [b1, b2, b3] = self.base_mm;
        let [p12, p23, p31] = self.edges_mm;
        let drum = &self.drum;
        let all_finite = self.base_mm.iter().flat_map(|b| b.iter()).all(|x| x.is_a_number())
            && self.edges_mm.iter().chain(&drum.home_length_mm).all(|x| x.is_a_number())
            && self.nominal.to_array().iter().all(|x| x.is_a_number())
            && [drum.radius_mm, drum.counts_per_turn, drum.fastest_mm_per_s, self.length_noise_mm]
                .iter()
                .all(|x| x.is_a_number());
        if !all_finite {
            return Err(RigError::NotFinite);
        }
        let normal = (b2 - b1).cross(&(b3 - b1));
        let longest = (b2 - b1).norm_squared().max((b3 - b1).norm_squared()).max((b3 - b2).norm_squared());
        // Twice the triangle's area against its longest side squared: 0.87 when equilateral.
        if !(normal.norm() > longest * T::of(1e-3)) {
            return Err(RigError::BaseCollapsed);
        }
        if normal.z.abs() < normal.norm() * T::of(1e-2) {
            return Err(RigError::BaseOnEdge);
        }
        // 1e-3 of slack: a platform flatter than that has no well-defined plane.
        let slack = (p12 + p23 + p31) * T::of(1e-3);
        let triangle = |a: T, b: T, c: T| a > T::zero() && a + slack < b + c;
        if !(triangle(p12, p23, p31) && triangle(p23, p31, p12) && triangle(p31, p12, p23)) {
            return Err(RigError::PlatformCollapsed);
        }
        let positive = |x: &T| *x > T::zero();
        if !(positive(&drum.radius_mm)
            && positive(&drum.counts_per_turn)
            && positive(&drum.fastest_mm_per_s)
            && drum.home_length_mm.iter().all(positive))
        {
            return Err(RigError::DrumNotPositive);
        }
        if !positive(&self.length_noise_mm) {
            return Err(RigError::NoiseNotPositive);
        }
        if !self.nominal.radii_mm.iter().all(positive) {
            return Err(RigError::RadiusNotPositive);
        }
        Ok(())
    }

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

    /// Attachment points B1..B3 in {B}, mm.
    pub fn base_mm(&self) -> &[Vector3<T>; POINTS] {
        &self.base_mm
    }

    /// Platform edges p12, p23, p31, mm.
    pub fn edges_mm(&self) -> &[T; POINTS] {
        &self.edges_mm
    }

    /// The drive: counts to lengths.
    pub fn drum(&self) -> &Drum<T> {
        &self.drum
    }

    /// Standard deviation of one cable length, mm.
    pub fn length_noise_mm(&self) -> T {
        self.length_noise_mm
    }

    /// Where the centre is expected before anything is known, mm: the paper's skin-based start.
    pub fn nominal(&self) -> &Parameters<T> {
        &self.nominal
    }

    /// The attachment points are numbered counterclockwise as the platform sees them, from +z of {B}.
    fn is_counterclockwise(&self) -> bool {
        let [b1, b2, b3] = &self.base_mm;
        (b2.x - b1.x) * (b3.y - b1.y) > (b2.y - b1.y) * (b3.x - b1.x)
    }

    /// The end-points in {P}, mm: P1 at the origin, P2 on the x axis, P3 in the xy plane on the side that makes the
    /// z axis of {P} point away from the base at home.
    pub fn platform_mm(&self) -> [Vector3<T>; POINTS] {
        let [p12, p23, p31] = self.edges_mm;
        let x = (p12 * p12 + p31 * p31 - p23 * p23) / (p12 + p12);
        let y = root(p31 * p31 - x * x);
        let y = if self.is_counterclockwise() { y } else { -y };
        let zero = T::zero();
        [Vector3::zeros(), Vector3::new(p12, zero, zero), Vector3::new(x, y, zero)]
    }
}
