//! The watch over a hinge against elbows in which one known thing has slipped.

use glenoid::identification::hinge::{Drawing, HingeAngles, HingeEstimator, HingeSettings, MAX_CABLES, MAX_CONSTANTS};
use glenoid::monitor::{Cause, DetectorState, HingeSlipDetector, Warning};
use glenoid::rig::Tolerance;
use host_tests::study::elbow::RANGE_RAD;
use host_tests::study::elbow::scene::{Elbow, NOISE_MM, NOISE_SIGMA_MM, drawn};
use host_tests::study::scene::{normal, symmetric};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// An elbow in use, its hinge known exactly.
struct InUse {
    elbow: Elbow,
    angles: HingeAngles<f64>,
    watch: HingeSlipDetector<f64>,
    random: ChaCha8Rng,
    cables: usize,
}

impl InUse {
    fn new(seed: u64, cables: usize) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let sigma = [0.05, 0.05, 3.0, 3.0, 0.05, 0.05, 3.0, 3.0, 3.0];
        let step: [f64; 9] = std::array::from_fn(|k| sigma[k] * normal(&mut random));
        let elbow = Elbow::of_hinge(&mut random, cables, &drawn().moved(&step), &Tolerance::exact());
        let drawing = Drawing { hinge: drawn(), sigma: Some(sigma), range_rad: RANGE_RAD };
        let rig = elbow.rig(Tolerance::exact()).unwrap().with_drawing(drawing);
        let estimator = HingeEstimator::new(&rig, HingeSettings::for_rig(&rig));
        Self {
            angles: estimator.angles_of(&drawn().moved(&step), &[0.0; MAX_CONSTANTS]),
            watch: HingeSlipDetector::new(cables, NOISE_SIGMA_MM),
            elbow,
            random,
            cables,
        }
    }

    /// Bends and stretches for some seconds, a hundred samples a second, one cable reading too much by an error, mm. The first
    /// warning.
    fn exercise(&mut self, seconds: u32, error_mm: [f64; MAX_CABLES]) -> Option<Warning<f64>> {
        (0..seconds * 100).find_map(|sample| {
            let flexion = -1.0 + 0.9 * (f64::from(sample) / 100.0).sin();
            let mut lengths = self.elbow.reading_mm(flexion, None);
            for (length, error) in lengths.iter_mut().zip(error_mm).take(self.cables) {
                *length += error + symmetric(&mut self.random, NOISE_MM);
            }
            self.watch.sample(&lengths, &mut self.angles)
        })
    }
}

#[test]
fn an_elbow_to_which_nothing_happens_raises_no_alarm() {
    for seed in 0..20 {
        for cables in 2..=MAX_CABLES {
            let mut in_use = InUse::new(seed, cables);
            assert_eq!(in_use.exercise(30, [0.0; MAX_CABLES]), None);
            assert_eq!(in_use.watch.state(), DetectorState::Quiet);
            let turned = in_use.watch.attitude().unwrap().angle();
            assert!(turned.is_finite());
        }
    }
}

#[test]
fn what_slipped_is_named_with_its_movement() {
    let moved = Vector3::new(1.0, 2.0, 2.0);
    for seed in 0..6 {
        let mut strap = InUse::new(seed, MAX_CABLES);
        strap.elbow = strap.elbow.clone().with_axis_moved(&moved);
        match strap.exercise(20, [0.0; MAX_CABLES]).map(|warning| warning.cause) {
            Some(Cause::StrapSlipped(found)) => assert!((found - moved).norm() < 1.2, "{found}"),
            other => panic!("seed {seed}: {other:?}"),
        }
        assert_eq!(strap.watch.state(), DetectorState::Warned);
        let mut cuff = InUse::new(seed, MAX_CABLES);
        cuff.elbow = cuff.elbow.clone().with_cuff_moved(&moved);
        match cuff.exercise(20, [0.0; MAX_CABLES]).map(|warning| warning.cause) {
            Some(Cause::CuffSlipped(found)) => assert!((found - moved).norm() < 1.2, "{found}"),
            other => panic!("seed {seed}: {other:?}"),
        }
    }
}

#[test]
fn a_cable_that_slips_is_named_with_its_error() {
    for cable in 0..MAX_CABLES {
        let mut in_use = InUse::new(9, MAX_CABLES);
        let mut error_mm = [0.0; MAX_CABLES];
        error_mm[cable] = -2.0;
        match in_use.exercise(20, error_mm).map(|warning| warning.cause) {
            Some(Cause::CableSlipped { cable: named, error_mm }) => {
                assert_eq!(usize::from(named), cable + 1);
                assert!((error_mm + 2.0).abs() < 0.1, "{error_mm}");
            }
            other => panic!("cable {}: {other:?}", cable + 1),
        }
    }
}

#[test]
fn with_three_cables_no_cause_is_named() {
    let mut in_use = InUse::new(2, 3);
    in_use.elbow = in_use.elbow.clone().with_axis_moved(&Vector3::new(1.0, 2.0, 2.0));
    assert_eq!(in_use.exercise(20, [0.0; MAX_CABLES]).map(|warning| warning.cause), Some(Cause::Unknown));
}

#[test]
fn a_still_arm_a_wrong_number_and_an_interruption_raise_no_alarm() {
    let mut in_use = InUse::new(5, MAX_CABLES);
    assert_eq!(in_use.exercise(3, [0.0; MAX_CABLES]), None);
    let lengths = in_use.elbow.reading_mm(-0.4, None).map(|mm| mm + 3.0);
    for _ in 0..1_000 {
        assert_eq!(in_use.watch.sample(&lengths, &mut in_use.angles), None);
    }
    for _ in 0..1_000 {
        assert_eq!(in_use.watch.sample(&[f64::NAN; MAX_CABLES], &mut in_use.angles), None);
    }
    in_use.watch.interrupted();
    assert_eq!(in_use.watch.state(), DetectorState::Quiet);
    assert_eq!(in_use.exercise(10, [0.0; MAX_CABLES]), None);
}
