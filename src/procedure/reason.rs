//! Reason codes: what the device says about a command, a pose, an encoder, a set of poses or the end of a run.
//!
//! The numbers are a contract with every client. They stand in bands of 16, are never renumbered, and a retired one
//! is never used again. `glenoid.dbc` and `docs/reasons.md` carry the same table; a test holds the three together.

/// The bands of codes, so that a client can react to a kind of reason that it does not know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Band {
    /// 0: nothing is wrong.
    Fine,
    /// 1-15: a command was not obeyed.
    Command,
    /// 16-31: a pose was not taken.
    Pose,
    /// 32-47: an encoder or its cable.
    Encoder,
    /// 48-79: the set of poses does not identify the centre.
    Identification,
    /// 80-95: the centre did not pass the second set of poses.
    Verification,
    /// 96-111: how a run ended by decision or by time.
    Ending,
    /// 112-127: the device itself.
    Device,
    /// 128-143: the watch over the centre in use.
    Watch,
    /// 144-159: a parameter.
    Parameter,
    /// 160-175: what the joint of this board has not.
    Joint,
    /// 176-255: not assigned.
    Unassigned,
}

impl Band {
    /// The band that a code stands in.
    pub const fn of(code: u8) -> Self {
        match code {
            0 => Self::Fine,
            1..=15 => Self::Command,
            16..=31 => Self::Pose,
            32..=47 => Self::Encoder,
            48..=79 => Self::Identification,
            80..=95 => Self::Verification,
            96..=111 => Self::Ending,
            112..=127 => Self::Device,
            128..=143 => Self::Watch,
            144..=159 => Self::Parameter,
            160..=175 => Self::Joint,
            176..=255 => Self::Unassigned,
        }
    }
}

/// Declares the enum, its list, its texts and its remedies from one table.
macro_rules! reasons {
    ($($(#[$doc:meta])* $name:ident = $code:literal, $text:literal, $remedy:literal;)+) => {
        /// Why something was not done, or how a run ended. See the table in `docs/reasons.md`.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        #[repr(u8)]
        pub enum Reason {
            $(#[doc = $text] $name = $code,)+
        }

        impl Reason {
            /// Every reason, in the order of the codes.
            pub const ALL: &'static [Reason] = &[$(Reason::$name,)+];

            /// The reason with this code, if one has it.
            pub const fn from_code(code: u8) -> Option<Self> {
                match code {
                    $($code => Some(Self::$name),)+
                    _ => None,
                }
            }

            /// The name that the DBC gives the code.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$name => stringify!($name),)+
                }
            }

            /// What happened, in words.
            pub const fn text(self) -> &'static str {
                match self {
                    $(Self::$name => $text,)+
                }
            }

            /// What to do about it, in words that a therapist or the client's programmer can act on.
            pub const fn remedy(self) -> &'static str {
                match self {
                    $(Self::$name => $remedy,)+
                }
            }
        }
    };
}

reasons! {
    Fine = 0, "nothing is wrong", "none";

    UnknownOpcode = 1, "no command has this opcode", "compare the client with the protocol number in Versions";
    WrongLength = 2, "a command frame has 8 bytes", "send all 8 bytes";
    ReservedNotZero = 3, "a reserved byte of the command is not zero", "send reserved bytes as zero";
    BadArgument = 4, "the command's argument or run id has no meaning here", "see the command's comment in the DBC";
    WrongState = 5, "the command has no meaning in the present state", "read the state in the heartbeat first";
    AlreadyRunning = 6, "a run is under way", "finish or abort it before another start";
    AcknowledgeFirst = 7, "the failure of the last run has not been acknowledged", "acknowledge it, then start";
    StaleRun = 8, "the run id is not that of the present run", "take the run id from the heartbeat";
    NoSuchPose = 9, "no pose has this index", "ask for an index below the pose count";
    Busy = 10, "the previous read-out is still being sent", "wait for its last frame";

    WrongValue = 11, "boot or checksum are not those of the value that was shown", "form them from the frames of the last report";
    ReportIncomplete = 12, "the report of the new centre has not been sent whole", "wait for its last frame, Outcome, then decide";
    TooManyCommands = 13, "too many commands within a second", "send fewer, and wait for each answer";
    Locked = 14, "the lock of the parameters is closed", "open it with the key, or ask who has it";
    NumberingUnchecked = 15, "nobody has seen yet that the cables are numbered as the rig says", "pull every cable for CheckCable (python -m glenoid numbering), then accept";

    ArmMoving = 16, "the arm is moving", "hold the arm still and try again";
    PoseTooNear = 17, "the pose is too near one that is already captured", "move the arm further before holding it";
    PosesFull = 18, "no room for another pose", "identify with the poses that are there";
    CableLoose = 19, "one cable moves although the others rest", "tighten the named cable and look at its drum";
    PlatformDoesNotClose = 20, "the six lengths do not fit the platform", "look for a slack or crossed cable, or hold the arm less far out";
    LengthImpossible = 21, "the named cable's length cannot be", "home the encoders again";

    EncoderSilent = 32, "no encoder counts arrive", "check the encoders' supply and wiring";
    EncoderFrozen = 33, "the named encoder rests while the other cables move", "check that encoder's wiring and coupling";
    EncoderJumped = 34, "the named encoder moved faster than its drum can turn", "check that encoder's shield, then home again";

    CableNotPulled = 35, "the named cable has not been pulled yet", "pull it by a finger's breadth while the arm and the other cables rest";
    WrongCable = 36, "another encoder moved than that of the cable that was to be pulled", "look at the labels of cables and attachment points, and which drum the cable runs to; the answer says which encoder moved";

    TooFewPoses = 48, "too few poses", "capture more poses";
    OneAxis = 49, "all poses turn about one axis", "move the arm in another plane as well";
    Weak = 50, "the poses leave the centre too uncertain in one direction", "follow the guidance: spread the poses wider";
    TooManyOutliers = 51, "too many readings contradict the others", "look for a slack cable, then start again";
    NotABall = 52, "the centre migrates more than the encoders' noise explains", "capture at least 18 poses, so that a moving centre is distinguished from a loose strap; tighten the strap";
    PoseDoesNotClose = 53, "the lengths of the named pose do not fit the platform", "look for a slack cable, then start again";
    NotConverged = 54, "the iteration did not settle", "capture more and wider poses";
    Singular = 55, "the equations have no single solution", "move the arm in another plane as well";
    NotFinite = 56, "the arithmetic left the range of numbers", "read out the poses and report them";
    TooAlike = 57, "all poses are alike", "move the arm further between the poses";
    ZeroNotDetermined = 58, "the centre hangs on the named encoder's zero, which the poses do not determine", "capture more and wider poses, or home the encoders";
    FewPosesForMovingCentre = 59, "the joint centre moves, and the poses are too few to say how", "capture at least 18 poses, wider and with the arm turned about its length";
    TiltMissing = 60, "the joint centre moves, and the arm is tilted too little to say how", "tilt the arm further from its middle in every direction";
    SecondPlaneMissing = 61, "the joint centre moves, and the arm is tilted in one plane only", "tilt the arm across the named direction as well";
    TorsionMissing = 62, "the joint centre moves, and the arm is not turned about its own length", "turn the arm about its length in some of the poses, by 30 degrees to both sides";
    BaseSlippedMidway = 63, "the base slipped on the body before the named pose", "tighten the strap, then start again";
    CuffSlippedMidway = 64, "the cuff slipped on the arm before the named pose", "tighten the cuff, then start again";
    JointNotExplained = 65, "neither a ball nor a centre that moves with the arm explains the poses", "look for a loose strap, cuff or cable; move slowly and hold each pose";
    BladeNotHeld = 66, "the shoulder blade was not held in the held poses", "let somebody hold the shoulder blade, keep the arm within 30 degrees, and repeat the held phase";
    HeldOfAnotherWearing = 67, "the held poses belong to another wearing", "repeat both phases without taking the cuff off between them";
    MachineNotAsStated = 68, "a machine that is not as stated explains the poses as well as a centre that moves", "commission the machine, or state its tolerances; home the encoders; then calibrate again";

    TwoAxesFit = 69, "two different axes fit the poses", "capture more poses over a wider range of flexion; state the drawing of the joint";
    SecondAxis = 70, "the joint turns about a second axis as well: it is no hinge", "look for play in the orthosis; keep the forearm from turning about its length";
    NotAHinge = 71, "no hinge explains the poses", "look for a loose strap, cuff or cable, then start again";

    CentreImplausible = 72, "the centre lies where no joint of this rig can be", "check cables, points and rig parameters, then calibrate again";
    RadiusImplausible = 73, "a distance from the centre to an end-point cannot be", "check the cuff and the rig parameters, then calibrate again";
    SigmaImplausible = 74, "the stated uncertainty is zero or too large", "capture more and wider poses";
    OffsetImplausible = 75, "the named encoder's offset is larger than homing can leave", "home the encoders, then calibrate again";
    MotionImplausible = 76, "the joint centre moves further with the arm than that of any joint", "look for a loose strap, cuff or cable, then calibrate again";

    VerificationFailed = 80, "the second set of poses deviates too much", "calibrate again; tighten strap and cables before";
    VerificationDoesNotClose = 81, "a pose of the second set does not fit the identified centre", "look for a slack cable, calibrate again";

    Accepted = 96, "the new centre was accepted and is in use", "none";
    Rejected = 97, "the new centre was rejected; the old one stays in use", "none";
    Aborted = 98, "the run was aborted; the old centre stays in use", "none";
    CollectingTimeout = 99, "no new pose for too long", "start again and keep the arm moving from pose to pose";
    VerifyingTimeout = 100, "no pose of the second set for too long", "start again, and go on to new poses after identification";
    ReviewTimeout = 101, "nobody accepted or rejected the new centre", "start again, and decide within the time";

    ButtonStuck = 112, "the button is held for too long", "release the button; if it is released, check its wiring";
    ReportOutOfRange = 113, "a value of the report does not fit its field", "read out the poses and report them";
    ReceiveOverrun = 114, "frames were lost before they were read", "send fewer frames at once, then ask again";
    RecordDamaged = 115, "the stored centre was damaged; there is none in use", "calibrate again; if it comes back, replace the board";
    RecordOfOtherRig = 116, "the stored centre belongs to another rig; there is none in use", "check the rig constants of this firmware, then calibrate";
    RecordOlder = 117, "the stored centre is of a firmware too old for this one; there is none in use", "calibrate again";
    RecordNewer = 118, "the stored centre is of a newer firmware; there is none in use", "install that firmware, or calibrate again";
    RecordUnfit = 119, "the stored centre is not one that a calibration can find; there is none in use", "read out the record and report it; calibrate again";
    RecordUnreadable = 120, "the flash cannot be read; there is no centre in use", "switch off and on; if it comes back, replace the board";
    StoreRefused = 121, "the flash refuses the new centre, which is lost at power-down", "take the flash's write protection away, then calibrate again";
    FlashWorn = 122, "the flash does not hold the new centre, which is lost at power-down", "replace the board";
    FlashLayout = 123, "the flash is divided otherwise than the firmware expects, so nothing is stored", "set the option byte that the first-power-up notes name";
    BusOff = 124, "the CAN controller had left the bus because of errors, and came back", "check wiring, termination and bit rate";
    Restarted = 125, "the firmware stopped and was restarted; a run under way is lost", "read Versions and LastStop for the cause, and report it";

    ParametersDamaged = 126, "the stored parameters were damaged or do not fit this firmware; the defaults are in use", "set and save the parameters again";
    JournalUnwritable = 127, "boot and run numbers cannot be stored", "replace the board";

    StrapSlipped = 128, "the joint centre has moved in the base: the strap slipped", "put the strap right, then calibrate again";
    CuffSlipped = 129, "the joint centre has moved in the platform: the cuff slipped on the arm", "put the cuff right, then calibrate again";
    CableSlipped = 130, "the named cable has slipped on its drum or stretched", "look at the cable and its drum, home it, then calibrate again";
    CentreDrifts = 131, "the joint centre moves with the arm's elevation: not a ball joint", "tighten the strap, keep the shoulder blade still";
    CentreMoved = 132, "the cables no longer fit the centre in use, and no single cause explains it", "look at strap, cuff and cables, then calibrate again";
    Unconfirmed = 133, "the centre comes from the record, and nothing has confirmed it since power-up", "move the arm through its range, or confirm the centre";

    UnknownParameter = 144, "no parameter has this index", "list the indices that are assigned";
    UnknownOperation = 145, "no operation on parameters has this number", "see the operations in the DBC";
    ParameterOutOfRange = 146, "the value is outside of the parameter's range, or no number", "read minimum and maximum";
    ParametersContradict = 147, "the prepared parameters do not fit each other; the value is the index of one of them", "correct it, then save again";
    WrongKey = 148, "the answer to the challenge is wrong", "ask for a challenge, and form the answer with the key";
    WriteOnly = 149, "the parameter cannot be read", "none: only its writer knows it";
    NoRecord = 150, "there is no record to erase", "none";

    NotOfHinge = 160, "the joint of this board is a hinge, which has no such thing", "leave it out: no phase with the shoulder blade held, no capture in motion, no stated offsets";
}

impl Reason {
    /// The number on the wire.
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// The band that this reason belongs to.
    pub const fn band(self) -> Band {
        Band::of(self.code())
    }
}

impl core::fmt::Display for Reason {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(self.text())
    }
}

impl core::error::Error for Reason {}
