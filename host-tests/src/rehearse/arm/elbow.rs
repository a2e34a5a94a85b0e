//! The elbow of the virtual person, with the encoders of its module.

use crate::rehearse::session::Person;
use crate::study::elbow::ANYBODY;
use crate::study::elbow::scene::Elbow;
use crate::study::scene::normal;
use crate::wearer::{Encoder, Pose, motion};
use glenoid::identification::hinge::{HingeRig, MAX_CABLES};
use glenoid::rig::{CABLES, Drum, Tolerance};
use nalgebra::Vector3;
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// An elbow bends to one side, up to this angle, degrees; a straight one hardly.
const MOST_DEG: f64 = 120.0;
const STRAIGHT_DEG: f64 = 2.0;
/// From one angle to the next: however many there are, they are spread over the whole range, none near to another.
const GOLDEN_RATIO: f64 = 0.618_033_988_749_895;

/// Somebody's elbow in the machine of a rig: as far from the drawn one as the drawing says, or as anybody's is. `None` where
/// the rig has no drawing.
pub fn somebodys_elbow(random: &mut ChaCha8Rng, rig: &HingeRig<f64>, tolerance: &Tolerance<f64>) -> Option<Elbow> {
    let drawing = rig.drawing()?;
    let step = drawing.sigma.unwrap_or(ANYBODY).map(|sigma| sigma * normal(random));
    Some(Elbow::of_rig(random, rig.cables().to_vec(), &drawing.hinge.moved(&step), tolerance))
}

/// Somebody's elbow in the module's machine.
pub struct ElbowWearer {
    elbow: Elbow,
    encoder: Encoder,
    home_mm: [f64; CABLES],
    most_rad: f64,
    noise_mm: f64,
    /// Where the next angle lies within the range, 0 to 1.
    share: f64,
    random: ChaCha8Rng,
}

impl ElbowWearer {
    /// An elbow; each length of each pose is wrong by up to `noise_mm`. `is_straight`: one that never bends.
    pub fn new(elbow: Elbow, drum: &Drum<f64>, noise_mm: f64, is_straight: bool, mut random: ChaCha8Rng) -> Self {
        let most: f64 = if is_straight { STRAIGHT_DEG } else { MOST_DEG };
        let encoder = Encoder::new(drum, [0.0; CABLES]);
        let (home_mm, share) = (drum.home_length_mm, random.random());
        Self { elbow, encoder, home_mm, most_rad: most.to_radians(), noise_mm, share, random }
    }

    /// The elbow.
    pub fn elbow(&self) -> &Elbow {
        &self.elbow
    }

    /// The angle of a pose, rad.
    pub fn flexion_rad(&self, pose: &Pose) -> f64 {
        let turned = pose.rotation * self.elbow.rotation(0.0).inverse();
        let turned = turned.scaled_axis();
        turned.norm() * turned.dot(self.elbow.hinge().axis()).signum()
    }

    /// The pose at an angle. Two of the six encoders have no cable and rest.
    fn pose(&self, flexion_rad: f64, errors_mm: [f64; CABLES]) -> Pose {
        let four = self.elbow.reading_mm(flexion_rad, None);
        let spans_mm = std::array::from_fn(|k| if k < MAX_CABLES { four[k] } else { self.home_mm[k] });
        let counts = self.encoder.counts(std::array::from_fn(|k| spans_mm[k] + errors_mm[k]));
        let (rotation, zero) = (self.elbow.rotation(flexion_rad), Vector3::zeros());
        Pose { rotation, centre_mm: zero, slide_mm: zero, spans_mm, errors_mm, counts }
    }
}

impl Person for ElbowWearer {
    fn home(&self) -> Pose {
        self.pose(0.0, [0.0; CABLES])
    }

    fn next_pose(&mut self) -> Pose {
        self.share = (self.share + GOLDEN_RATIO).fract();
        let noise = std::array::from_fn(|_| self.random.random_range(-self.noise_mm..=self.noise_mm));
        self.pose(-self.share * self.most_rad, noise)
    }

    fn motion(&self, from: &Pose, to: &Pose, duration_ms: u32, period_ms: u32) -> Vec<[i32; CABLES]> {
        let (begin, end) = (self.flexion_rad(from), self.flexion_rad(to));
        let between = |share: f64| {
            let errors = std::array::from_fn(|k| from.errors_mm[k] + (to.errors_mm[k] - from.errors_mm[k]) * share);
            self.pose(begin + (end - begin) * share, errors).counts
        };
        let shares = motion::samples(duration_ms, period_ms);
        shares.map(|share| if share == 1.0 { to.counts } else { between(share) }).collect()
    }

    fn mm_per_count(&self) -> f64 {
        self.encoder.mm_per_count()
    }

    fn cables(&self) -> usize {
        self.elbow.stated.len()
    }
}
