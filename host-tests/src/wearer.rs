//! The virtual rehabilitator: an arm in the machine whose true joint centre is known.
//!
//! It stands for everything left of the encoders: a wearer whose shoulder is not where the drawing says, an arm that
//! is moved from pose to pose and held still, cables that are not ideal, drums and encoders that count. Its random
//! numbers come from one seed (ChaCha8), so the same settings give the same counts on every machine.
//!
//! ```
//! use glenoid::rig::Rig;
//! use host_tests::wearer::{Wearer, WearerSettings};
//!
//! let mut wearer = Wearer::new(Rig::shoulder(150.0)?, WearerSettings::default());
//! let home = wearer.home();
//! let pose = wearer.next_pose();
//! let on_the_way = wearer.motion(&home, &pose, 500, 10);
//! assert_eq!(on_the_way.last(), Some(&pose.counts));
//! # Ok::<(), glenoid::rig::RigError>(())
//! ```

mod arm;
mod cables;
mod encoder;
mod joint;
pub(crate) mod motion;
mod roaming;

use glenoid::rig::{CABLES, Parameters, Rig};
use nalgebra::{Rotation3, Unit, Vector3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub use arm::FittedArm;
pub use cables::Cables;
pub(crate) use cables::length_mm;
pub use encoder::Encoder;
use joint::MovingJoint;
pub use roaming::Roaming;

/// What is random about the wearer, and how much.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WearerSettings {
    /// Seed of every random number.
    pub seed: u64,
    /// Poses tilt the arm by up to this angle about a random horizontal axis, rad, 0 to π/2.
    pub tilt_rad: f64,
    /// Poses turn the arm about its own length by up to this angle to either side, rad, 0 to π.
    pub torsion_rad: f64,
    /// The joint centre is off its nominal place by up to this much along each axis of {B}, mm.
    pub centre_offset_mm: f64,
    /// The cuff sits on the arm up to this much off its nominal place along each axis of the platform, mm. This is
    /// what makes the three radii differ from the nominal.
    pub cuff_offset_mm: f64,
    /// Each cable length of each pose is wrong by up to this much, uniformly, mm.
    pub noise_mm: f64,
    /// Each cable's home length is wrong by up to this much, uniformly, the same in all poses, mm.
    pub zero_error_mm: f64,
    /// In a free movement the head slides slowly, to and fro in 3 to 7 s, not in one.
    pub slow_slides: bool,
}

impl Default for WearerSettings {
    /// Ideal cables, tilt to 45 degrees, torsion to ±30 degrees, a centre within ±20 mm and a cuff within ±10 mm.
    fn default() -> Self {
        Self {
            seed: 1,
            tilt_rad: 45f64.to_radians(),
            torsion_rad: 30f64.to_radians(),
            centre_offset_mm: 20.0,
            cuff_offset_mm: 10.0,
            noise_mm: 0.0,
            zero_error_mm: 0.0,
            slow_slides: false,
        }
    }
}

/// Something that goes wrong with one cable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mishap {
    /// The cable sags in one pose: more of it is paid out than the distance it spans.
    Slack {
        /// Pose in which it sags, from 0 in the order of [`Wearer::next_pose`].
        pose: usize,
        /// Cable, from 0.
        cable: usize,
        /// Length too much, mm.
        excess_mm: f64,
    },
    /// The cable slips on its drum on the way to a pose; all later lengths are off.
    Slip {
        /// First pose that is affected, from 0.
        pose: usize,
        /// Cable, from 0.
        cable: usize,
        /// Change of the length that the encoder shows, mm.
        by_mm: f64,
    },
}

/// A pose of the arm, held still.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Rotation of the arm from home.
    pub rotation: Rotation3<f64>,
    /// The joint centre in {B}, mm, but for the slide.
    pub centre_mm: Vector3<f64>,
    /// By how much the head has slid beside it, mm.
    pub slide_mm: Vector3<f64>,
    /// Distances that the six cables span, mm: what ideal cables would measure.
    pub spans_mm: [f64; CABLES],
    /// What the cables add to that, mm: noise and mishaps.
    pub errors_mm: [f64; CABLES],
    /// Encoder counts.
    pub counts: [i32; CABLES],
}

/// A wearer in the machine. See the [module](self).
#[derive(Debug, Clone)]
pub struct Wearer {
    cables: Cables,
    settings: WearerSettings,
    arm: FittedArm,
    encoder: Encoder,
    mishaps: Vec<Mishap>,
    joint: Option<MovingJoint>,
    random: ChaCha8Rng,
    poses: usize,
}

impl Wearer {
    /// A wearer with a random centre, cuff and zero errors. `rig` is the machine as it is; its correction is what its
    /// encoders truly read.
    pub fn new(rig: Rig<f64>, settings: WearerSettings) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(settings.seed);
        let mut offset = |limit_mm: f64| Vector3::from_fn(|_, _| symmetric(&mut random, limit_mm));
        let (centre_offset_mm, cuff_offset_mm) = (offset(settings.centre_offset_mm), offset(settings.cuff_offset_mm));
        let arm = FittedArm::new(&rig, centre_offset_mm, cuff_offset_mm);
        let zero_errors_mm = std::array::from_fn(|_| symmetric(&mut random, settings.zero_error_mm));
        let ideal = Encoder::new(rig.drum(), zero_errors_mm);
        let encoder = rig.correction().map_or(ideal, |correction| ideal.with(correction));
        let cables = Cables::new(&rig);
        Self { cables, settings, arm, encoder, mishaps: Vec::new(), joint: None, random, poses: 0 }
    }

    /// What an identification should find: the true centre in {B} and the true radii, mm.
    pub fn truth(&self) -> Parameters<f64> {
        self.arm.truth()
    }

    /// The arm in the machine.
    pub fn arm(&self) -> &FittedArm {
        &self.arm
    }

    /// The six encoders.
    pub fn encoder(&self) -> &Encoder {
        &self.encoder
    }

    /// Lets something go wrong with a cable from now on.
    pub fn suffer(&mut self, mishap: Mishap) {
        self.mishaps.push(mishap);
    }

    /// The arm at home (no rotation), with ideal cables.
    pub fn home(&self) -> Pose {
        self.pose(Rotation3::identity(), Vector3::zeros(), [0.0; CABLES])
    }

    /// The next random pose within the shoulder's range.
    ///
    /// First the arm turns about its own length (its long axis is z at home), then it tilts about a horizontal axis
    /// of random azimuth. Both angles are uniform within their limits.
    pub fn next_pose(&mut self) -> Pose {
        let rotation = loop {
            let torsion = symmetric(&mut self.random, self.settings.torsion_rad);
            let azimuth = self.random.random_range(0.0..std::f64::consts::TAU);
            let tilt = self.random.random_range(0.0..=self.tilt_limit_rad());
            let across = Vector3::new(libm::cos(azimuth), libm::sin(azimuth), 0.0);
            let rotation = rotation(across, tilt) * rotation(Vector3::z(), torsion);
            if self.reaches(&rotation) {
                break rotation;
            }
        };
        let errors_mm = std::array::from_fn(|_| symmetric(&mut self.random, self.settings.noise_mm));
        let slide_mm = self.next_slide();
        let pose = self.pose(rotation, slide_mm, self.with_mishaps(errors_mm));
        self.poses += 1;
        pose
    }

    /// Encoder counts on the way from one pose to another, one sample every `period_ms`, the last one at
    /// `duration_ms` in the new pose. The speed follows a minimum-jerk profile, as unhurried human movement does.
    pub fn motion(&self, from: &Pose, to: &Pose, duration_ms: u32, period_ms: u32) -> Vec<[i32; CABLES]> {
        motion::samples(duration_ms, period_ms)
            .map(|share| match share {
                1.0 => to.counts,
                _ => {
                    let errors_mm =
                        std::array::from_fn(|k| from.errors_mm[k] + (to.errors_mm[k] - from.errors_mm[k]) * share);
                    let slide_mm = from.slide_mm.lerp(&to.slide_mm, share);
                    self.pose(motion::between(&from.rotation, &to.rotation, share), slide_mm, errors_mm).counts
                }
            })
            .collect()
    }

    /// Rotations on the way from one to another, one every `period_ms`, at the speed of [`motion`](Self::motion).
    pub fn path(
        from: Rotation3<f64>,
        to: Rotation3<f64>,
        duration_ms: u32,
        period_ms: u32,
    ) -> impl Iterator<Item = Rotation3<f64>> {
        motion::samples(duration_ms, period_ms).map(move |share| match share {
            1.0 => to,
            _ => motion::between(&from, &to, share),
        })
    }

    /// One sample of the encoders with the arm at a rotation from home and fresh noise, in a machine where the joint
    /// centre is elsewhere by `strap_mm` (axes of {B}) and a cable (from 0) reads too much by so many mm.
    pub fn sample(
        &mut self,
        rotation: &Rotation3<f64>,
        strap_mm: Vector3<f64>,
        cable: Option<(usize, f64)>,
    ) -> [i32; CABLES] {
        let centre_mm = self.centre_at(rotation) + self.next_slide() + strap_mm;
        let mut lengths_mm = self.cables.lengths_mm(&self.arm.ends_mm().map(|end| centre_mm + rotation * end));
        for length in &mut lengths_mm {
            *length += symmetric(&mut self.random, self.settings.noise_mm);
        }
        if let Some((cable, by_mm)) = cable {
            lengths_mm[cable] += by_mm;
        }
        self.encoder.counts(lengths_mm)
    }

    /// A random direction.
    pub fn direction(&mut self) -> Unit<Vector3<f64>> {
        loop {
            let within = Vector3::from_fn(|_, _| symmetric(&mut self.random, 1.0));
            // From the ball, so that no direction is preferred.
            if (0.01..=1.0).contains(&within.norm_squared()) {
                return Unit::new_normalize(within);
            }
        }
    }

    fn pose(&self, rotation: Rotation3<f64>, slide_mm: Vector3<f64>, errors_mm: [f64; CABLES]) -> Pose {
        let centre_mm = self.centre_at(&rotation);
        let there = centre_mm + slide_mm;
        let spans_mm = self.cables.lengths_mm(&self.arm.ends_mm().map(|end| there + rotation * end));
        let counts = self.encoder.counts(std::array::from_fn(|k| spans_mm[k] + errors_mm[k]));
        Pose { rotation, centre_mm, slide_mm, spans_mm, errors_mm, counts }
    }

    fn with_mishaps(&self, mut errors_mm: [f64; CABLES]) -> [f64; CABLES] {
        for mishap in &self.mishaps {
            match *mishap {
                Mishap::Slack { pose, cable, excess_mm } if pose == self.poses => errors_mm[cable] += excess_mm,
                Mishap::Slip { pose, cable, by_mm } if pose <= self.poses => errors_mm[cable] += by_mm,
                _ => {}
            }
        }
        errors_mm
    }
}

/// A number uniform within `limit` to either side. Always draws, so that a limit of zero changes no other number.
fn symmetric(random: &mut ChaCha8Rng, limit: f64) -> f64 {
    random.random_range(-1.0..=1.0) * limit
}

/// The rotation by `angle` about the unit vector `axis`, by Rodrigues' formula with `libm`'s functions, which give
/// the same bits on every machine.
pub(crate) fn rotation(axis: Vector3<f64>, angle: f64) -> Rotation3<f64> {
    let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
    let [x, y, z]: [f64; 3] = Unit::new_normalize(axis).into_inner().into();
    let cross = nalgebra::Matrix3::new(0.0, -z, y, z, 0.0, -x, -y, x, 0.0);
    Rotation3::from_matrix_unchecked(nalgebra::Matrix3::identity() + cross * sine + cross * cross * (1.0 - cosine))
}
