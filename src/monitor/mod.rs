//! Slip detection: does the joint in use still hold? Three of the six lengths are redundant at every instant.
//!
//! Once the centre is known, three angles explain six lengths; a residual beyond the noise says that something has
//! moved. Each sample sees the displacement δ = δO - R δC of the centre (see
//! [`marginal_information`](crate::identification::marginal_information)), and over a motion the causes look different:
//!
//! | cause | what it leaves |
//! |---|---|
//! | the base strap slipped | the same δO in every sample |
//! | the arm's cuff slipped | the same δC in every sample, turning with the arm |
//! | a cable slipped or stretched | the same error of one length |
//! | not a ball joint, or the centre moves otherwise than it did | δO that grows with the arm's elevation |
//!
//! ```text
//! quiet ──► suspicious ──► warned ──► quiet (rearmed)
//!   ▲            │
//!   └────────────┘  the evidence has gone again
//! ```
//!
//! A sample counts only when the arm has moved since the last one that did: encoder noise and quantisation are fresh
//! then, and a still arm cannot raise an alarm. Nothing is ever corrected here: the centre in use stays.

mod evidence;
mod hinge;
mod hinge_evidence;
mod suspicion;
mod warning;

pub use self::hinge::HingeSlipDetector;
pub use self::warning::{Cause, Warning};

use self::evidence::Evidence;
use self::suspicion::{Change, SUSPICIOUS, Suspicion};
use self::warning::Explanation;
use crate::identification::joint::Joint;
use crate::identification::machine::{Machine, MachineDeviation};
use crate::identification::marginal_information::MarginalInformation;
use crate::kinematics::rotation::{rotation_of, scaled_axis, turned};
use crate::kinematics::{AttitudeSearch, AttitudeSolver, AttitudeTrack, CableLengths, CableSet, Geometry, JointCentre};
use crate::rig::{CABLES, Correction, Parameters};
use crate::scalar::Real;
use nalgebra::{UnitQuaternion, Vector3};

/// A sample counts when a cable has moved by this much since the last one that did, mm: 0.25 degrees of the arm, twenty
/// counts of the encoder, and more than ±0.1 mm of noise in both samples.
const MOVED_MM: f64 = 0.5;

/// Gauss-Newton steps with the motion of the centre included, after those about a fixed one.
const TURNS: u8 = 2;

/// Samples that a decision takes, and how far the arm must have turned among them, rad (16 degrees).
const SAMPLES: u16 = 32;
const SPAN_RAD: f64 = 0.28;

/// What the detector is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DetectorState {
    /// All is well.
    Quiet,
    /// Something has moved; evidence is being gathered.
    Suspicious,
    /// A warning stands.
    Warned,
}

/// What is being made of a sample, a slice at a time.
#[derive(Clone, Copy, Debug)]
enum Look<T: Real> {
    /// Nothing.
    No,
    /// Its rotation is searched for, one assembly mode a slice, while none is known: from its lengths, corrected.
    Search(CableLengths<T>, AttitudeSearch<T>),
    /// Its rotation is looked for, from that of the sample before. A moving centre is taken where that has it.
    Track(JointCentre<T>, AttitudeTrack<T>),
    /// The centre moves with the rotation: so many Gauss-Newton steps more, with that included.
    Turn(UnitQuaternion<T>, u8),
    /// What it says of the centre.
    See(UnitQuaternion<T>),
    /// It is added to the evidence.
    Add(UnitQuaternion<T>),
    /// So is what it says of single cables.
    AddCables(UnitQuaternion<T>),
    /// A drift is looked for in the evidence.
    Drift,
    /// The evidence is judged, with that.
    Judge(Explanation<T>),
}

/// The slip detector of one accepted centre.
#[derive(Clone, Debug)]
pub struct SlipDetector<T: Real> {
    geometry: Geometry<T>,
    joint: Joint<T>,
    centre: JointCentre<T>,
    home_mm: [T; CABLES],
    /// What was found with the centre: reading = home + scale (L - home) + offset.
    found: Correction<T>,
    variance_mm2: T,
    attitude: Option<UnitQuaternion<T>>,
    /// The last sample that counted.
    counted: Option<CableLengths<T>>,
    look: Look<T>,
    suspicion: Suspicion<T>,
    first: Vector3<T>,
    span: T,
    evidence: Evidence<T>,
}

impl<T: Real> SlipDetector<T> {
    /// A detector for the centre `parameters`, mm, on the machine as it was found with it: what is not as drawn is no
    /// slip.
    ///
    /// * `offsets_mm`: encoder offsets found, mm; 0 when they are known.
    /// * `noise_mm`: standard deviation of a length, mm, but for what averages over the samples of a held pose: that of a
    ///   single sample is added here.
    /// * `joint`: a ball, or how the centre moves with the arm; what it predicts is no alarm, and its scatter is none
    ///   either.
    pub fn new(
        machine: &Machine<T>,
        deviation: &MachineDeviation<T>,
        parameters: &Parameters<T>,
        offsets_mm: &[T; CABLES],
        noise_mm: T,
        joint: Joint<T>,
    ) -> Self {
        let geometry = machine.geometry_with(deviation);
        Self {
            centre: JointCentre::from_parameters(parameters, &geometry),
            geometry,
            joint,
            home_mm: *machine.home_mm(),
            found: Correction { offset_mm: *offsets_mm, scale: deviation.scale.map(|scale| T::one() + scale) },
            variance_mm2: machine.sample_variance_mm2(noise_mm),
            attitude: None,
            counted: None,
            look: Look::No,
            suspicion: Suspicion::none(),
            first: Vector3::zeros(),
            span: T::zero(),
            evidence: Evidence::new(),
        }
    }

    /// What the detector is doing.
    pub fn state(&self) -> DetectorState {
        self.suspicion.state()
    }

    /// Running mean of χ² per degree of freedom; 1 when all is well.
    pub fn chi_square(&self) -> T {
        self.suspicion.chi_square()
    }

    /// The arm's rotation ({P} to {B}) in the last sample that counted.
    pub fn attitude(&self) -> Option<UnitQuaternion<T>> {
        self.attitude
    }

    /// Goes back to quiet after a warning.
    pub fn rearm(&mut self) {
        self.suspicion.rearm();
        self.evidence = Evidence::new();
    }

    /// Nothing was seen for a while: the arm may be anywhere now. A suspicion is dropped; a warning stays.
    pub fn interrupted(&mut self) {
        (self.attitude, self.counted, self.look) = (None, None, Look::No);
        if self.state() == DetectorState::Suspicious {
            self.rearm();
        }
    }

    /// Takes in a sample of raw lengths. Returns a warning once, when a decision falls for one.
    ///
    /// Cost: comparing six lengths while the arm is still; else one rotation fit from the sample before and one
    /// elimination. A sample that fits no rotation is not counted; that of the next one is searched for.
    pub fn sample(&mut self, lengths: &CableLengths<T>) -> Option<Warning<T>> {
        self.begin(lengths);
        loop {
            let is_searching = matches!(self.look, Look::Search(..));
            let warning = self.advance();
            // Searched for one assembly mode a sample.
            if is_searching {
                return None;
            }
            if warning.is_some() || !self.is_looking() {
                return warning;
            }
        }
    }

    /// The same a slice at a time: begins with a sample. One that is still being looked at is given up, unless it is in the
    /// evidence by half.
    pub fn begin(&mut self, lengths: &CableLengths<T>) {
        if let Look::AddCables(..) = self.look {
            return;
        }
        let Some(before) = self.attitude else { return self.begin_search(lengths) };
        self.look = Look::No;
        if !self.has_moved(lengths) {
            return;
        }
        self.counted = Some(*lengths);
        if self.corrected(lengths).is_some() {
            let centre = self.joint.centre_at(&self.centre, &rotation_of(&before));
            self.look = Look::Track(centre, AttitudeTrack::new(before));
        }
    }

    /// There is more to be made of the sample.
    pub fn is_looking(&self) -> bool {
        !matches!(self.look, Look::No)
    }

    /// The next slice. Returns a warning once, when a decision falls for one.
    #[cfg_attr(feature = "ccm", inline(never), unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    pub fn advance(&mut self) -> Option<Warning<T>> {
        if let Look::Search(..) = self.look {
            self.search();
            return None;
        }
        let lengths = self.corrected(self.counted.as_ref()?)?;
        match core::mem::replace(&mut self.look, Look::No) {
            Look::No | Look::Search(..) => {}
            Look::Track(centre, mut track) => {
                let solver = AttitudeSolver { geometry: &self.geometry, centre: &centre };
                match track.advance(&solver, &lengths, CableSet::ALL) {
                    None => self.look = Look::Track(centre, track),
                    Some(None) => self.attitude = None,
                    Some(Some(fit)) => {
                        let turns = if let Joint::Moving(_) = self.joint { TURNS } else { 0 };
                        self.look = if turns > 0 { Look::Turn(fit.attitude, turns) } else { Look::See(fit.attitude) };
                    }
                }
            }
            Look::Turn(attitude, left) => {
                self.look = match self.information(&attitude, &lengths) {
                    None => {
                        self.attitude = None;
                        Look::No
                    }
                    Some(pose) if left > 1 => Look::Turn(turned(&attitude, &pose.turn), left - 1),
                    Some(pose) => Look::See(turned(&attitude, &pose.turn)),
                };
            }
            Look::See(attitude) => {
                self.attitude = Some(attitude);
                let pose = self.scattered(&attitude, &lengths)?;
                self.see(&attitude, &pose);
            }
            Look::Add(attitude) => {
                let pose = self.scattered(&attitude, &lengths)?;
                self.evidence.add(&rotation_of(&attitude), &pose);
                self.look = Look::AddCables(attitude);
            }
            // All at once would be the longest tick of the board.
            Look::AddCables(attitude) => {
                let pose = self.scattered(&attitude, &lengths)?;
                self.evidence.add_cables(&pose);
                if self.evidence.samples() >= SAMPLES && self.span >= T::of(SPAN_RAD) {
                    self.look = Look::Drift;
                }
            }
            Look::Drift => self.look = Look::Judge(self.evidence.drift()),
            Look::Judge(drift) => return self.judge(drift),
        }
        None
    }

    /// What a sample says of the centre, its rotation eliminated.
    fn information(&self, attitude: &UnitQuaternion<T>, lengths: &CableLengths<T>) -> Option<MarginalInformation<T>> {
        let rotation = rotation_of(attitude);
        MarginalInformation::new(&self.joint.jacobian(&self.geometry, &self.centre, &rotation, lengths)).ok()
    }

    /// The same, the joint's scatter eliminated too.
    #[cfg_attr(feature = "ccm", unsafe(link_section = ".ccm_code"), allow(unsafe_code))]
    fn scattered(&self, attitude: &UnitQuaternion<T>, lengths: &CableLengths<T>) -> Option<MarginalInformation<T>> {
        // Changed where it stays: a copy takes 200 cycles.
        let mut pose = self.information(attitude, lengths);
        if let Some(pose) = &mut pose {
            pose.add_scatter(self.joint.scatter_mm2() / self.variance_mm2);
        }
        pose
    }

    /// The lengths without what was found with the centre.
    fn corrected(&self, lengths: &CableLengths<T>) -> Option<CableLengths<T>> {
        lengths.corrected_by(&self.found, &self.home_mm).ok()
    }

    /// Takes in χ² of a sample; suspicion begins, or goes on.
    fn see(&mut self, attitude: &UnitQuaternion<T>, pose: &MarginalInformation<T>) {
        let chi_square = pose.squares_mm2() / (self.variance_mm2 * T::of(3.0));
        match self.suspicion.see(chi_square) {
            Change::None => {}
            Change::Begins => {
                self.evidence = Evidence::new();
                self.first = scaled_axis(attitude);
                self.span = T::zero();
            }
            Change::GoesOn => {
                let turned = (scaled_axis(attitude) - self.first).norm_squared().root();
                self.span = self.span.max(turned);
                self.look = Look::Add(*attitude);
            }
        }
    }

    /// Begins the search for the rotation of a sample; one that is under way goes on.
    fn begin_search(&mut self, lengths: &CableLengths<T>) {
        if let Look::Search(..) = self.look {
            return;
        }
        if let Some(lengths) = self.corrected(lengths) {
            self.look = Look::Search(lengths, AttitudeSearch::new());
        }
    }

    /// Tries the next assembly mode. After the last one the best counts, and the next samples are tracked from it: the arm has
    /// moved by a few degrees meanwhile at most.
    fn search(&mut self) {
        let Look::Search(lengths, search) = &mut self.look else { return };
        // About a fixed centre: a moving one is included when the next samples are tracked.
        let solver = AttitudeSolver { geometry: &self.geometry, centre: &self.centre };
        if search.advance(&solver, lengths, CableSet::ALL) {
            self.attitude = search.best().map(|fit| fit.attitude);
            self.look = Look::No;
        }
    }

    fn has_moved(&self, lengths: &CableLengths<T>) -> bool {
        self.counted.is_none_or(|before| {
            before.as_mm().iter().zip(lengths.as_mm()).any(|(b, l)| (*l - *b).abs() >= T::of(MOVED_MM))
        })
    }

    fn judge(&mut self, drift: Explanation<T>) -> Option<Warning<T>> {
        let usual = self.suspicion.usual();
        let warning = self.evidence.judge(self.variance_mm2, T::of(SUSPICIOUS), usual, drift);
        self.suspicion.judged(warning.is_some());
        warning
    }
}
