//! Every parameter of the machine and of its procedure: one line each.
//!
//! An index is a contract with every client, as a reason's code is: never renumbered, and that of a retired parameter
//! is never used again. `docs/parameters.md` and the parameter messages of `glenoid.dbc` are made from this table by
//! `cargo run -p vocabulary`, and a test holds them against it.

/// How the four bytes of a value are to be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// An IEEE single.
    Single,
    /// An unsigned integer.
    Integer,
}

/// One parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// The number by which clients name it.
    pub index: u16,
    /// How its value is to be read.
    pub kind: Kind,
    /// Bits of the default.
    pub default: u32,
    /// Bits of the smallest value.
    pub minimum: u32,
    /// Bits of the largest value.
    pub maximum: u32,
    /// It may be written only while the lock is open.
    pub guarded: bool,
}

/// What people read of a parameter. Apart from [`Entry`], so that a device which never asks for it carries none of it: 10 KB
/// of flash.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Description {
    /// The name in the documentation and in the DBC.
    pub name: &'static str,
    /// Unit; empty for plain numbers.
    pub unit: &'static str,
    /// What it is.
    pub text: &'static str,
}

impl Entry {
    /// What people read of it.
    pub fn description(&self) -> &'static Description {
        const NONE: Description = Description { name: "", unit: "", text: "" };
        let place = TABLE.partition_point(|entry| entry.index < self.index);
        DESCRIPTIONS.get(place).unwrap_or(&NONE)
    }
}

/// Bits of a value of a kind.
macro_rules! bits {
    (single, $value:expr) => {
        f32::to_bits($value)
    };
    (integer, $value:expr) => {{
        const VALUE: u32 = $value;
        VALUE
    }};
}

macro_rules! kind {
    (single) => {
        Kind::Single
    };
    (integer) => {
        Kind::Integer
    };
}

macro_rules! guarded {
    (guarded) => {
        true
    };
    (open) => {
        false
    };
}

/// Declares the keys and the table from one list.
macro_rules! parameters {
    ($($key:ident = $index:literal, $kind:ident, $unit:literal, $default:expr, $minimum:expr, $maximum:expr, $guarded:ident, $text:literal;)+) => {
        /// A parameter by its place in the table.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[repr(u8)]
        pub enum Key {
            $(#[doc = $text] $key,)+
        }

        /// All parameters, in the order of their indices and of the keys.
        pub const TABLE: &[Entry] = &[$(Entry {
            index: $index,
            kind: kind!($kind),
            default: bits!($kind, $default),
            minimum: bits!($kind, $minimum),
            maximum: bits!($kind, $maximum),
            guarded: guarded!($guarded),
        },)+];

        /// What people read of them, in the same order.
        const DESCRIPTIONS: &[Description] =
            &[$(Description { name: stringify!($key), unit: $unit, text: $text },)+];
    };
}

/// Length of every cable at home on the shoulder of Table I, mm.
const HOME_MM: f32 = 277.83972;

parameters! {
    Geometry = 1, integer, "", 0, 0, 2, guarded, "0: attachment points and edges make two triangles; 1: every cable has its own ends; 2: an elbow, whose cables have their own ends about a hinge";

    Base1X = 10, single, "mm", 150.0, -2000.0, 2000.0, guarded, "x of attachment point B1 in the base frame";
    Base1Y = 11, single, "mm", 0.0, -2000.0, 2000.0, guarded, "y of attachment point B1 in the base frame";
    Base1Z = 12, single, "mm", 0.0, -2000.0, 2000.0, guarded, "z of attachment point B1 in the base frame";
    Base2X = 13, single, "mm", -75.0, -2000.0, 2000.0, guarded, "x of attachment point B2 in the base frame";
    Base2Y = 14, single, "mm", 129.90381, -2000.0, 2000.0, guarded, "y of attachment point B2 in the base frame";
    Base2Z = 15, single, "mm", 0.0, -2000.0, 2000.0, guarded, "z of attachment point B2 in the base frame";
    Base3X = 16, single, "mm", -75.0, -2000.0, 2000.0, guarded, "x of attachment point B3 in the base frame";
    Base3Y = 17, single, "mm", -129.90381, -2000.0, 2000.0, guarded, "y of attachment point B3 in the base frame";
    Base3Z = 18, single, "mm", 0.0, -2000.0, 2000.0, guarded, "z of attachment point B3 in the base frame";
    Edge12 = 19, single, "mm", 178.39821, 1.0, 2000.0, guarded, "platform edge from end-point P1 to P2";
    Edge23 = 20, single, "mm", 178.39821, 1.0, 2000.0, guarded, "platform edge from end-point P2 to P3";
    Edge31 = 21, single, "mm", 178.39821, 1.0, 2000.0, guarded, "platform edge from end-point P3 to P1";

    Cable1BaseX = 30, single, "mm", 150.0, -2000.0, 2000.0, guarded, "geometry 1: x of where cable 1 leaves the base, in the base frame; with a pulley, where it enters";
    Cable1BaseY = 31, single, "mm", 0.0, -2000.0, 2000.0, guarded, "geometry 1: y of where cable 1 leaves the base, in the base frame; with a pulley, where it enters";
    Cable1BaseZ = 32, single, "mm", 0.0, -2000.0, 2000.0, guarded, "geometry 1: z of where cable 1 leaves the base, in the base frame; with a pulley, where it enters";
    Cable1EndX = 33, single, "mm", 0.0, -2000.0, 2000.0, guarded, "geometry 1: x of where cable 1 ends, in any frame fixed to the platform";
    Cable1EndY = 34, single, "mm", 0.0, -2000.0, 2000.0, guarded, "geometry 1: y of where cable 1 ends, in any frame fixed to the platform";
    Cable1EndZ = 35, single, "mm", 0.0, -2000.0, 2000.0, guarded, "geometry 1: z of where cable 1 ends, in any frame fixed to the platform";
    Cable1PulleyRadius = 36, single, "mm", 0.0, 0.0, 500.0, guarded, "geometry 1: radius of the guide pulley of cable 1; 0 = none";
    Cable1PulleyAxisX = 37, single, "", 0.0, -1.0, 1.0, guarded, "geometry 1: x of the direction in which cable 1 comes up to its pulley, a unit vector";
    Cable1PulleyAxisY = 38, single, "", 0.0, -1.0, 1.0, guarded, "geometry 1: y of the direction in which cable 1 comes up to its pulley, a unit vector";
    Cable1PulleyAxisZ = 39, single, "", 1.0, -1.0, 1.0, guarded, "geometry 1: z of the direction in which cable 1 comes up to its pulley, a unit vector";

    Cable2BaseX = 40, single, "mm", -75.0, -2000.0, 2000.0, guarded, "geometry 1: x of where cable 2 leaves the base, in the base frame; with a pulley, where it enters";
    Cable2BaseY = 41, single, "mm", 129.90381, -2000.0, 2000.0, guarded, "geometry 1: y of where cable 2 leaves the base, in the base frame; with a pulley, where it enters";
    Cable2BaseZ = 42, single, "mm", 0.0, -2000.0, 2000.0, guarded, "geometry 1: z of where cable 2 leaves the base, in the base frame; with a pulley, where it enters";
    Cable2EndX = 43, single, "mm", 0.0, -2000.0, 2000.0, guarded, "geometry 1: x of where cable 2 ends, in any frame fixed to the platform";
    Cable2EndY = 44, single, "mm", 0.0, -2000.0, 2000.0, guarded, "geometry 1: y of where cable 2 ends, in any frame fixed to the platform";
    Cable2EndZ = 45, single, "mm", 0.0, -2000.0, 2000.0, guarded, "geometry 1: z of where cable 2 ends, in any frame fixed to the platform";
    Cable2PulleyRadius = 46, single, "mm", 0.0, 0.0, 500.0, guarded, "geometry 1: radius of the guide pulley of cable 2; 0 = none";
    Cable2PulleyAxisX = 47, single, "", 0.0, -1.0, 1.0, guarded, "geometry 1: x of the direction in which cable 2 comes up to its pulley, a unit vector";
    Cable2PulleyAxisY = 48, single, "", 0.0, -1.0, 1.0, guarded, "geometry 1: y of the direction in which cable 2 comes up to its pulley, a unit vector";
    Cable2PulleyAxisZ = 49, single, "", 1.0, -1.0, 1.0, guarded, "geometry 1: z of the direction in which cable 2 comes up to its pulley, a unit vector";

    Cable3BaseX = 50, single, "mm", -75.0, -2000.0, 2000.0, guarded, "geometry 1: x of where cable 3 leaves the base, in the base frame; with a pulley, where it enters";
    Cable3BaseY = 51, single, "mm", 129.90381, -2000.0, 2000.0, guarded, "geometry 1: y of where cable 3 leaves the base, in the base frame; with a pulley, where it enters";
    Cable3BaseZ = 52, single, "mm", 0.0, -2000.0, 2000.0, guarded, "geometry 1: z of where cable 3 leaves the base, in the base frame; with a pulley, where it enters";
    Cable3EndX = 53, single, "mm", 178.39821, -2000.0, 2000.0, guarded, "geometry 1: x of where cable 3 ends, in any frame fixed to the platform";
    Cable3EndY = 54, single, "mm", 0.0, -2000.0, 2000.0, guarded, "geometry 1: y of where cable 3 ends, in any frame fixed to the platform";
    Cable3EndZ = 55, single, "mm", 0.0, -2000.0, 2000.0, guarded, "geometry 1: z of where cable 3 ends, in any frame fixed to the platform";
    Cable3PulleyRadius = 56, single, "mm", 0.0, 0.0, 500.0, guarded, "geometry 1: radius of the guide pulley of cable 3; 0 = none";
    Cable3PulleyAxisX = 57, single, "", 0.0, -1.0, 1.0, guarded, "geometry 1: x of the direction in which cable 3 comes up to its pulley, a unit vector";
    Cable3PulleyAxisY = 58, single, "", 0.0, -1.0, 1.0, guarded, "geometry 1: y of the direction in which cable 3 comes up to its pulley, a unit vector";
    Cable3PulleyAxisZ = 59, single, "", 1.0, -1.0, 1.0, guarded, "geometry 1: z of the direction in which cable 3 comes up to its pulley, a unit vector";

    Cable4BaseX = 60, single, "mm", -75.0, -2000.0, 2000.0, guarded, "geometry 1: x of where cable 4 leaves the base, in the base frame; with a pulley, where it enters";
    Cable4BaseY = 61, single, "mm", -129.90381, -2000.0, 2000.0, guarded, "geometry 1: y of where cable 4 leaves the base, in the base frame; with a pulley, where it enters";
    Cable4BaseZ = 62, single, "mm", 0.0, -2000.0, 2000.0, guarded, "geometry 1: z of where cable 4 leaves the base, in the base frame; with a pulley, where it enters";
    Cable4EndX = 63, single, "mm", 178.39821, -2000.0, 2000.0, guarded, "geometry 1: x of where cable 4 ends, in any frame fixed to the platform";
    Cable4EndY = 64, single, "mm", 0.0, -2000.0, 2000.0, guarded, "geometry 1: y of where cable 4 ends, in any frame fixed to the platform";
    Cable4EndZ = 65, single, "mm", 0.0, -2000.0, 2000.0, guarded, "geometry 1: z of where cable 4 ends, in any frame fixed to the platform";
    Cable4PulleyRadius = 66, single, "mm", 0.0, 0.0, 500.0, guarded, "geometry 1: radius of the guide pulley of cable 4; 0 = none";
    Cable4PulleyAxisX = 67, single, "", 0.0, -1.0, 1.0, guarded, "geometry 1: x of the direction in which cable 4 comes up to its pulley, a unit vector";
    Cable4PulleyAxisY = 68, single, "", 0.0, -1.0, 1.0, guarded, "geometry 1: y of the direction in which cable 4 comes up to its pulley, a unit vector";
    Cable4PulleyAxisZ = 69, single, "", 1.0, -1.0, 1.0, guarded, "geometry 1: z of the direction in which cable 4 comes up to its pulley, a unit vector";

    Cable5BaseX = 70, single, "mm", -75.0, -2000.0, 2000.0, guarded, "geometry 1: x of where cable 5 leaves the base, in the base frame; with a pulley, where it enters";
    Cable5BaseY = 71, single, "mm", -129.90381, -2000.0, 2000.0, guarded, "geometry 1: y of where cable 5 leaves the base, in the base frame; with a pulley, where it enters";
    Cable5BaseZ = 72, single, "mm", 0.0, -2000.0, 2000.0, guarded, "geometry 1: z of where cable 5 leaves the base, in the base frame; with a pulley, where it enters";
    Cable5EndX = 73, single, "mm", 89.199104, -2000.0, 2000.0, guarded, "geometry 1: x of where cable 5 ends, in any frame fixed to the platform";
    Cable5EndY = 74, single, "mm", 154.49738, -2000.0, 2000.0, guarded, "geometry 1: y of where cable 5 ends, in any frame fixed to the platform";
    Cable5EndZ = 75, single, "mm", 0.0, -2000.0, 2000.0, guarded, "geometry 1: z of where cable 5 ends, in any frame fixed to the platform";
    Cable5PulleyRadius = 76, single, "mm", 0.0, 0.0, 500.0, guarded, "geometry 1: radius of the guide pulley of cable 5; 0 = none";
    Cable5PulleyAxisX = 77, single, "", 0.0, -1.0, 1.0, guarded, "geometry 1: x of the direction in which cable 5 comes up to its pulley, a unit vector";
    Cable5PulleyAxisY = 78, single, "", 0.0, -1.0, 1.0, guarded, "geometry 1: y of the direction in which cable 5 comes up to its pulley, a unit vector";
    Cable5PulleyAxisZ = 79, single, "", 1.0, -1.0, 1.0, guarded, "geometry 1: z of the direction in which cable 5 comes up to its pulley, a unit vector";

    Cable6BaseX = 80, single, "mm", 150.0, -2000.0, 2000.0, guarded, "geometry 1: x of where cable 6 leaves the base, in the base frame; with a pulley, where it enters";
    Cable6BaseY = 81, single, "mm", 0.0, -2000.0, 2000.0, guarded, "geometry 1: y of where cable 6 leaves the base, in the base frame; with a pulley, where it enters";
    Cable6BaseZ = 82, single, "mm", 0.0, -2000.0, 2000.0, guarded, "geometry 1: z of where cable 6 leaves the base, in the base frame; with a pulley, where it enters";
    Cable6EndX = 83, single, "mm", 89.199104, -2000.0, 2000.0, guarded, "geometry 1: x of where cable 6 ends, in any frame fixed to the platform";
    Cable6EndY = 84, single, "mm", 154.49738, -2000.0, 2000.0, guarded, "geometry 1: y of where cable 6 ends, in any frame fixed to the platform";
    Cable6EndZ = 85, single, "mm", 0.0, -2000.0, 2000.0, guarded, "geometry 1: z of where cable 6 ends, in any frame fixed to the platform";
    Cable6PulleyRadius = 86, single, "mm", 0.0, 0.0, 500.0, guarded, "geometry 1: radius of the guide pulley of cable 6; 0 = none";
    Cable6PulleyAxisX = 87, single, "", 0.0, -1.0, 1.0, guarded, "geometry 1: x of the direction in which cable 6 comes up to its pulley, a unit vector";
    Cable6PulleyAxisY = 88, single, "", 0.0, -1.0, 1.0, guarded, "geometry 1: y of the direction in which cable 6 comes up to its pulley, a unit vector";
    Cable6PulleyAxisZ = 89, single, "", 1.0, -1.0, 1.0, guarded, "geometry 1: z of the direction in which cable 6 comes up to its pulley, a unit vector";

    DrumRadius = 100, single, "mm", 15.0, 0.5, 500.0, guarded, "radius at which a cable leaves its drum";
    CountsPerTurn = 101, single, "", 4096.0, 1.0, 1.0E9, guarded, "encoder counts of one drum turn, gear ratio included";
    MaxSpeed = 102, single, "mm/s", 1500.0, 1.0, 100000.0, guarded, "fastest that the drive can move a cable; a faster change is a fault of the encoder";
    Home1 = 103, single, "mm", HOME_MM, 1.0, 4000.0, guarded, "length of cable 1 at count zero";
    Home2 = 104, single, "mm", HOME_MM, 1.0, 4000.0, guarded, "length of cable 2 at count zero";
    Home3 = 105, single, "mm", HOME_MM, 1.0, 4000.0, guarded, "length of cable 3 at count zero";
    Home4 = 106, single, "mm", HOME_MM, 1.0, 4000.0, guarded, "length of cable 4 at count zero";
    Home5 = 107, single, "mm", HOME_MM, 1.0, 4000.0, guarded, "length of cable 5 at count zero";
    Home6 = 108, single, "mm", HOME_MM, 1.0, 4000.0, guarded, "length of cable 6 at count zero";
    LengthNoise = 109, single, "mm", 0.057735026, 0.0001, 10.0, guarded, "standard deviation of one cable length: of what does not average over the samples of a held pose";
    NominalX = 110, single, "mm", 0.0, -2000.0, 2000.0, guarded, "x of the joint centre as the rig expects it";
    NominalY = 111, single, "mm", 0.0, -2000.0, 2000.0, guarded, "y of the joint centre as the rig expects it";
    NominalZ = 112, single, "mm", 148.0, -2000.0, 2000.0, guarded, "z of the joint centre as the rig expects it";
    NominalRadius1 = 113, single, "mm", 140.8, 1.0, 2000.0, guarded, "distance from the joint centre to end-point P1 as the rig expects it";
    NominalRadius2 = 114, single, "mm", 140.8, 1.0, 2000.0, guarded, "distance from the joint centre to end-point P2 as the rig expects it";
    NominalRadius3 = 115, single, "mm", 140.8, 1.0, 2000.0, guarded, "distance from the joint centre to end-point P3 as the rig expects it";
    SampleNoise = 116, single, "mm", 0.0, 0.0, 10.0, guarded, "standard deviation of what each sample of a cable length has beyond that, and what averages over the samples of a held pose; 0 = none";

    ToleranceBase = 120, single, "mm", 0.5, 0.0, 100.0, guarded, "one standard deviation of each coordinate of an attachment point; 0 = exact";
    ToleranceEdges = 121, single, "mm", 0.5, 0.0, 100.0, guarded, "one standard deviation of each platform edge, or with geometry 1 of each coordinate of an end; 0 = exact";
    ToleranceOffset = 122, single, "mm", 0.3, 0.0, 100.0, guarded, "one standard deviation of what homing leaves of each offset; 0 = exact";
    ToleranceDrum = 123, single, "", 0.001, 0.0, 0.2, guarded, "one standard deviation of the radius of each drum, relative; 0 = exact";
    Offset1 = 124, single, "mm", 0.0, -100.0, 100.0, guarded, "what the length of cable 1 reads too much, as commissioning found it";
    Offset2 = 125, single, "mm", 0.0, -100.0, 100.0, guarded, "what the length of cable 2 reads too much, as commissioning found it";
    Offset3 = 126, single, "mm", 0.0, -100.0, 100.0, guarded, "what the length of cable 3 reads too much, as commissioning found it";
    Offset4 = 127, single, "mm", 0.0, -100.0, 100.0, guarded, "what the length of cable 4 reads too much, as commissioning found it";
    Offset5 = 128, single, "mm", 0.0, -100.0, 100.0, guarded, "what the length of cable 5 reads too much, as commissioning found it";
    Offset6 = 129, single, "mm", 0.0, -100.0, 100.0, guarded, "what the length of cable 6 reads too much, as commissioning found it";
    Scale1 = 130, single, "", 1.0, 0.8, 1.2, guarded, "how much more than stated the drum of cable 1 pays out, as commissioning found it";
    Scale2 = 131, single, "", 1.0, 0.8, 1.2, guarded, "how much more than stated the drum of cable 2 pays out, as commissioning found it";
    Scale3 = 132, single, "", 1.0, 0.8, 1.2, guarded, "how much more than stated the drum of cable 3 pays out, as commissioning found it";
    Scale4 = 133, single, "", 1.0, 0.8, 1.2, guarded, "how much more than stated the drum of cable 4 pays out, as commissioning found it";
    Scale5 = 134, single, "", 1.0, 0.8, 1.2, guarded, "how much more than stated the drum of cable 5 pays out, as commissioning found it";
    Scale6 = 135, single, "", 1.0, 0.8, 1.2, guarded, "how much more than stated the drum of cable 6 pays out, as commissioning found it";

    PlausibleCentre = 140, single, "mm", 140.8, 1.0, 1000.0, guarded, "farthest that a joint centre may lie from where the rig expects it";
    PlausibleMinRadius = 141, single, "mm", 46.933334, 1.0, 2000.0, guarded, "smallest distance from the centre to an end-point that can be";
    PlausibleMaxRadius = 142, single, "mm", 422.40002, 1.0, 2000.0, guarded, "largest distance from the centre to an end-point that can be";
    PlausibleSigma = 143, single, "mm", 7.9, 0.001, 7.9, guarded, "largest standard deviation with which a centre is taken";
    PlausibleOffset = 144, single, "mm", 63.9, 0.01, 63.9, guarded, "largest offset of an encoder with which a centre is taken";

    StillBand = 160, single, "mm", 1.0, 0.01, 20.0, open, "largest peak-to-peak movement of a cable while the arm counts as still";
    HoldTime = 161, integer, "ms", 400, 50, 10000, open, "how long the arm must be held still";
    MinSamples = 162, integer, "", 8, 1, 1000, open, "least number of samples in that time";
    SilenceTime = 163, integer, "ms", 500, 10, 10000, guarded, "without a sample for this long the encoders are silent";
    SampleJitter = 164, integer, "ms", 20, 0, 1000, guarded, "how late a sample may reach the device; at most one mean period of the samples counts";
    FrozenDistance = 165, single, "mm", 20.0, 1.0, 500.0, guarded, "an encoder that rests while three other cables move this far is frozen";
    LostAfterSamples = 166, integer, "", 5, 1, 100, guarded, "so many samples at the new place after a jump, and the count is lost";
    NearestPose = 167, single, "rad", 0.1, 0.001, 1.0, open, "smallest angle between two captured poses";
    EnoughPoses = 168, integer, "", 12, 3, 128, open, "poses in the first set before it can be good enough";
    EnoughPosesOffsets = 169, integer, "", 30, 3, 128, open, "the same when the encoder offsets must be found from the same poses";
    OffsetPrior = 170, single, "mm", 0.0, 0.0, 63.9, guarded, "how well the encoder offsets are known, one standard deviation; 0 = exactly";
    TargetSigma = 171, single, "mm", 0.05, 0.001, 7.9, open, "predicted standard deviation of the centre at which the first set is good enough";
    VerificationPoses = 172, integer, "", 5, 1, 32, open, "poses in the second set";
    VerificationLimit = 173, single, "mm", 0.5, 0.001, 15.9, guarded, "largest root mean square of the second set";
    MaxAttempts = 174, integer, "", 5, 1, 100, open, "solver runs in one run of the procedure before it gives up";
    CollectingTimeout = 175, integer, "ms", 120000, 1000, 3600000, open, "longest time without a new pose of the first set";
    VerifyingTimeout = 176, integer, "ms", 120000, 1000, 3600000, open, "longest time without a new pose of the second set";
    ReviewTimeout = 177, integer, "ms", 300000, 1000, 3600000, open, "longest time for the decision";
    NumberingCheck = 178, integer, "", 0, 0, 1, guarded, "1: the first centre on this machine is accepted only after every cable was pulled and found at its encoder (CheckCable)";
    CaptureInMotion = 179, integer, "", 0, 0, 1, open, "1: poses are captured while the arm moves slowly as well, in every run";

    TelemetryRate = 190, integer, "Hz", 50, 0, 100, open, "sets of telemetry a second; 0 = off; acts at once";
    LivePeriod = 191, integer, "ms", 100, 0, 10000, guarded, "time between two sets of what a controller acts on; 0 = off";
    BaseId = 192, integer, "", 0x680, 0, 0x7C0, guarded, "first of the 64 CAN identifiers of the device, a multiple of 64";

    LockKey1 = 200, integer, "", 0, 0, u32::MAX, guarded, "word 1 of the key of the lock, which cannot be read; all four zero = no lock";
    LockKey2 = 201, integer, "", 0, 0, u32::MAX, guarded, "word 2 of the key of the lock, which cannot be read; all four zero = no lock";
    LockKey3 = 202, integer, "", 0, 0, u32::MAX, guarded, "word 3 of the key of the lock, which cannot be read; all four zero = no lock";
    LockKey4 = 203, integer, "", 0, 0, u32::MAX, guarded, "word 4 of the key of the lock, which cannot be read; all four zero = no lock";

    HingeCables = 210, integer, "", 4, 2, 4, guarded, "geometry 2: cables about the hinge, from cable 1 on; fewer than four need a drawing with its standard deviations";
    HingeDrawing = 211, integer, "", 0, 0, 2, guarded, "geometry 2: 0: no drawing; 1: the drawing tells two solutions apart; 2: it is a prior with the standard deviations below";
    HingeAxisX = 212, single, "", 1.0, -1.0, 1.0, guarded, "geometry 2: x of the direction of the axis as drawn, in the base frame";
    HingeAxisY = 213, single, "", 0.0, -1.0, 1.0, guarded, "geometry 2: y of the direction of the axis as drawn, in the base frame";
    HingeAxisZ = 214, single, "", 0.0, -1.0, 1.0, guarded, "geometry 2: z of the direction of the axis as drawn, in the base frame";
    HingePointX = 215, single, "mm", 0.0, -2000.0, 2000.0, guarded, "geometry 2: x of a point of the axis as drawn, in the base frame";
    HingePointY = 216, single, "mm", 0.0, -2000.0, 2000.0, guarded, "geometry 2: y of a point of the axis as drawn, in the base frame";
    HingePointZ = 217, single, "mm", 160.0, -2000.0, 2000.0, guarded, "geometry 2: z of a point of the axis as drawn, in the base frame";
    HingeEndAxisX = 218, single, "", 1.0, -1.0, 1.0, guarded, "geometry 2: x of the direction of the axis as drawn, in the frame of the cables' ends";
    HingeEndAxisY = 219, single, "", 0.0, -1.0, 1.0, guarded, "geometry 2: y of the direction of the axis as drawn, in the frame of the cables' ends";
    HingeEndAxisZ = 220, single, "", 0.0, -1.0, 1.0, guarded, "geometry 2: z of the direction of the axis as drawn, in the frame of the cables' ends";
    HingeEndPointX = 221, single, "mm", 0.0, -2000.0, 2000.0, guarded, "geometry 2: x of the same point of the axis, in the frame of the cables' ends";
    HingeEndPointY = 222, single, "mm", 0.0, -2000.0, 2000.0, guarded, "geometry 2: y of the same point of the axis, in the frame of the cables' ends";
    HingeEndPointZ = 223, single, "mm", -70.0, -2000.0, 2000.0, guarded, "geometry 2: z of the same point of the axis, in the frame of the cables' ends";
    HingeLowest = 224, single, "rad", -2.45, -6.3, 6.3, guarded, "geometry 2: smallest angle of the joint from where it is drawn";
    HingeHighest = 225, single, "rad", 0.27, -6.3, 6.3, guarded, "geometry 2: largest angle of the joint from where it is drawn";
    HingeSigmaAxis = 226, single, "rad", 0.05, 0.0001, 3.2, guarded, "drawing 2: one standard deviation of the direction of the axis in the base frame, across it";
    HingeSigmaPoint = 227, single, "mm", 3.0, 0.001, 1000.0, guarded, "drawing 2: one standard deviation of the place of the axis in the base frame, across it";
    HingeSigmaEndAxis = 228, single, "rad", 0.05, 0.0001, 3.2, guarded, "drawing 2: one standard deviation of the direction of the axis in the frame of the ends, across it";
    HingeSigmaEndPoint = 229, single, "mm", 3.0, 0.001, 1000.0, guarded, "drawing 2: one standard deviation of the place of the axis in the frame of the ends, across it";
    HingeSigmaAlong = 230, single, "mm", 3.0, 0.001, 1000.0, guarded, "drawing 2: one standard deviation of where the two frames stand along the axis";
}

/// Number of parameters.
pub const COUNT: usize = TABLE.len();
