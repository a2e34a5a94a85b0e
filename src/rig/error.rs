//! Why a set of constants is not a rig.

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
    /// The noise of a cable length is not positive, or that of a sample negative.
    NoiseNotPositive = 6,
    /// A nominal radius is not positive.
    RadiusNotPositive = 7,
    /// A tolerance is negative, or so large that nothing would be known of the machine (a length beyond 100 mm, a drum
    /// beyond 20 %).
    ToleranceImpossible = 8,
    /// The radius of a pulley is negative, or its axis no direction.
    PulleyImpossible = 9,
    /// The two ends of a cable coincide at home, or both cables of a pair share both ends.
    EndsCoincide = 10,
    /// An offset found by commissioning is not finite, or a drum's scale is off by more than 20 %.
    CorrectionImpossible = 11,
    /// So few cables do not determine a hinge, and no drawing says how well it is known beforehand.
    DrawingMissing = 12,
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
            Self::NoiseNotPositive => "the cable noise is not positive, or that of a sample negative",
            Self::RadiusNotPositive => "a nominal radius is not positive",
            Self::ToleranceImpossible => "a tolerance is negative or absurd (beyond 100 mm, or 20 % of a drum)",
            Self::PulleyImpossible => "a pulley's radius is negative or its axis is no direction",
            Self::EndsCoincide => "both ends of two cables of an end-point coincide",
            Self::CorrectionImpossible => "an offset is not finite or a drum's scale is off by more than 20 %",
            Self::DrawingMissing => "fewer than four cables about a hinge need a drawing with its standard deviations",
        }
    }
}
