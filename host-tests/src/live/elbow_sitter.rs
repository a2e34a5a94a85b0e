//! A person whose joint is a hinge: an elbow.

use super::person::{Person, PersonKind};
use super::sitter::{Now, Sample, Sitter, Truth};
use crate::identify::rig_file::default_rig;
use crate::rehearse::Person as _;
use crate::rehearse::arm::{ElbowWearer, somebodys_elbow};
use crate::wearer::{Pose, motion};
use glenoid::identification::hinge::HingeRig;
use glenoid::rig::{Drum, Tolerance};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::io;

/// The person in the machine.
pub(super) struct ElbowSitter {
    wearer: ElbowWearer,
    at: Pose,
}

impl ElbowSitter {
    /// A person with the arm straight, in a machine drawn like this.
    ///
    /// # Errors
    /// When such a person does not fit into it.
    pub(super) fn new(person: &Person, drawn: &HingeRig<f64>) -> io::Result<Self> {
        if matches!(person.kind, PersonKind::Moving | PersonKind::Built) {
            return Err(io::Error::other("--person moving and built are for a shoulder's machine"));
        }
        let seeded = |stream: u64| {
            let mut random = ChaCha8Rng::seed_from_u64(person.seed);
            random.set_stream(stream);
            random
        };
        let elbow = somebodys_elbow(&mut seeded(1), drawn, &Tolerance::exact());
        let elbow = elbow.ok_or_else(|| io::Error::other("the elbow's rig has no [hinge], about which to bend"))?;
        let mut drum: Drum<f64> = *default_rig().map_err(|error| io::Error::other(error.to_string()))?.drum();
        for (home_mm, stated_mm) in drum.home_length_mm.iter_mut().zip(drawn.home_length_mm()) {
            // 0: the file does not say it
            if *stated_mm > 0.0 {
                *home_mm = *stated_mm;
            }
        }
        let is_straight = person.kind == PersonKind::Straight;
        let wearer = ElbowWearer::new(elbow, &drum, person.noise_mm, is_straight, seeded(2));
        Ok(Self { at: wearer.home(), wearer })
    }
}

impl Sitter for ElbowSitter {
    fn truth(&self) -> Truth {
        let hinge = self.wearer.elbow().hinge();
        Truth::Hinge([
            [(*hinge.axis()).into(), (*hinge.foot_mm()).into()],
            [hinge.axis_in_platform().into(), (*hinge.foot_in_platform_mm()).into()],
        ])
    }

    fn now(&self) -> Now {
        Now::Bent(self.wearer.flexion_rad(&self.at).to_degrees())
    }

    fn rest(&mut self, _blade_held: bool) -> Sample {
        Sample { counts: self.at.counts, now: self.now() }
    }

    fn way(&mut self, _blade_held: bool, duration_ms: u32, period_ms: u32) -> Vec<Sample> {
        let to = self.wearer.next_pose();
        let from = std::mem::replace(&mut self.at, to);
        let [begin, end] = [&from, &to].map(|pose| self.wearer.flexion_rad(pose).to_degrees());
        let counts = self.wearer.motion(&from, &to, duration_ms, period_ms);
        let bent = motion::samples(duration_ms, period_ms).map(|share| Now::Bent(begin + (end - begin) * share));
        counts.into_iter().zip(bent).map(|(counts, now)| Sample { counts, now }).collect()
    }
}
