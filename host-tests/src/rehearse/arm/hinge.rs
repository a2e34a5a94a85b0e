//! The elbow: its board sends what its encoders show, and the host finds the hinge from these lengths.

use super::bus::Bus;
use super::lengths::lengths_mm;
use super::module::ArmModule;
use crate::identify::hinge::{in_precision, remedy_of};
use crate::rehearse::display::Display;
use crate::study::elbow::scene::{Elbow, NOISE_MM};
use crate::wearer::{Encoder, motion};
use glenoid::identification::hinge::{
    HingeEstimator, HingePose, HingeRig, HingeSettings, IdentifiedHinge, MAX_CABLES,
};
use glenoid::rig::CABLES;
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// Time between two samples, ms.
const PERIOD_MS: u32 = 10;
/// How long a movement takes, and how long the elbow is held still before its lengths are taken, ms.
const MOVE_MS: u32 = 400;
const SETTLE_MS: u32 = 400;
/// An elbow bends to one side, up to this angle, degrees.
const MOST_DEG: f64 = 120.0;

/// The elbow and its board.
pub struct HingeModule {
    /// Its board.
    pub module: ArmModule,
    board: usize,
    elbow: Elbow,
    rig: HingeRig<f64>,
    encoder: Encoder,
    most_rad: f64,
    flexion_rad: f64,
    random: ChaCha8Rng,
}

/// What the host has found from the lengths that its board sent.
pub struct CalibratedHinge {
    /// The hinge.
    pub found: IdentifiedHinge<f32>,
    /// The estimator at its end.
    pub estimator: HingeEstimator<f32>,
}

impl HingeModule {
    /// An elbow on a board; `is_straight`: one that never bends.
    pub fn new(
        module: ArmModule,
        board: usize,
        elbow: Elbow,
        rig: HingeRig<f64>,
        is_straight: bool,
        random: ChaCha8Rng,
    ) -> Self {
        let encoder = Encoder::new(module.machine.double.drum(), [0.0; CABLES]);
        let most_rad = if is_straight { 0.0 } else { MOST_DEG.to_radians() };
        Self { module, board, elbow, rig, encoder, most_rad, flexion_rad: 0.0, random }
    }

    /// What the board's encoders show, without noise.
    pub fn counts(&self) -> [i32; CABLES] {
        self.counts_at(self.flexion_rad, &[0.0; MAX_CABLES])
    }

    /// Bends the elbow to so many angles and takes the lengths that its board sends in each.
    ///
    /// # Errors
    /// Why there is no hinge.
    pub fn calibrate(
        &mut self,
        bus: &mut dyn Bus,
        poses: u8,
        display: &Display,
    ) -> Result<CalibratedHinge, String> {
        let stage = display.counted("angles of the elbow", poses.into());
        let mut taken = Vec::new();
        for done in 1..=poses {
            self.move_on(bus)?;
            taken.push(HingePose::new(self.lengths_mm(bus)?));
            stage.reached(done.into(), "");
        }
        stage.done("lengths taken");
        let rig = in_precision::<f32>(&self.rig).map_err(|error| error.text().to_owned())?;
        let mut estimator = HingeEstimator::new(&rig, HingeSettings::for_rig(&rig));
        let found = estimator
            .run(&mut taken)
            .map_err(|refusal| format!("{}. What to do: {}", refusal.text(), remedy_of(&refusal)))?;
        Ok(CalibratedHinge { found, estimator })
    }

    /// Moves the elbow to another angle, with fresh noise.
    ///
    /// # Errors
    /// When a board is gone.
    pub fn move_on(&mut self, bus: &mut dyn Bus) -> Result<(), String> {
        let to = -self.random.random_range(0.0..=1.0) * self.most_rad;
        let noise: [f64; MAX_CABLES] = std::array::from_fn(|_| self.random.random_range(-NOISE_MM..=NOISE_MM));
        let from = std::mem::replace(&mut self.flexion_rad, to);
        for share in motion::samples(MOVE_MS, PERIOD_MS).chain(std::iter::repeat_n(1.0, (SETTLE_MS / PERIOD_MS) as usize)) {
            bus.set_counts(self.board, &self.counts_at(from + (to - from) * share, &noise));
            bus.pass(PERIOD_MS).map_err(|error| error.to_string())?;
        }
        Ok(())
    }

    /// The lengths that its board sends.
    ///
    /// # Errors
    /// When it sends none.
    pub fn lengths_mm(&self, bus: &mut dyn Bus) -> Result<[f32; MAX_CABLES], String> {
        let [l1, l2, l3, l4, ..] = lengths_mm(bus, &self.module)?;
        Ok([l1, l2, l3, l4])
    }

    /// The true elbow, and its angle.
    pub fn truth(&self) -> (&Elbow, f64) {
        (&self.elbow, self.flexion_rad)
    }

    /// Counts with so much noise. Its board has six encoders; two of them have no cable and rest.
    fn counts_at(&self, flexion_rad: f64, noise_mm: &[f64; MAX_CABLES]) -> [i32; CABLES] {
        let spans = self.elbow.reading_mm(flexion_rad, None);
        let home = self.module.machine.double.drum().home_length_mm;
        let with_noise = |k: usize| spans[k] + noise_mm[k];
        self.encoder.counts(std::array::from_fn(|k| if k < MAX_CABLES { with_noise(k) } else { home[k] }))
    }
}
