//! The hinge's estimator in slices: what it gives, to the bit, is what it gave in one piece.

use glenoid::identification::Noise;
use glenoid::identification::hinge::{
    Drawing, HINGE_UNKNOWNS, Hinge, HingeEstimator, HingePose, HingeProgress, HingeRefusal, HingeRig, HingeSettings,
    IdentifiedHinge, MAX_CABLES,
};
use glenoid::rig::{CableEnds, Pulley, Tolerance};
use glenoid::scalar::Real;
use host_tests::study::elbow::scene::{Elbow, HOME_MM, drawn, flexions_rad};
use host_tests::study::scene::{normal, symmetric};
use nalgebra::Vector3;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

const RANGE_RAD: (f64, f64) = (-2.45, 0.27);
const BUILT: Tolerance<f64> = Tolerance { base_mm: 0.5, edges_mm: 0.5, offset_mm: 0.3, drum: 1e-3 };

type Outcome<T> = Result<IdentifiedHinge<T>, HingeRefusal>;

/// A set and the rig that it is judged by.
struct Case {
    name: &'static str,
    elbow: Elbow,
    tolerance: Tolerance<f64>,
    drawing: Option<Option<[f64; HINGE_UNKNOWNS]>>,
    noise: Option<f64>,
    readings: Vec<[f64; MAX_CABLES]>,
}

/// Every way through the estimator.
fn cases() -> Vec<Case> {
    let exact = Tolerance::exact();
    let vague = [0.05, 0.05, 3.0, 3.0, 0.05, 0.05, 3.0, 3.0, 3.0];
    let case = |name, seed: u64, cables: usize, tolerance: Tolerance<f64>, drawing, flexion_deg: f64, poses: usize| {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let elbow = match drawing {
            None => Elbow::random(&mut random, cables, &tolerance),
            Some(_) => {
                let step: [f64; HINGE_UNKNOWNS] = std::array::from_fn(|k| vague[k] * normal(&mut random));
                Elbow::of_hinge(&mut random, cables, &drawn().moved(&step), &tolerance)
            }
        };
        let flexions = flexions_rad(&mut random, poses, flexion_deg);
        let readings = elbow.readings_mm(&mut random, &flexions);
        Case { name, elbow, tolerance, drawing, noise: None, readings }
    };
    let mut cases = vec![
        case("four cables", 1, 4, exact, None, 120.0, 20),
        case("four cables", 2, 4, exact, None, 120.0, 12),
        case("built by hand", 3, 4, BUILT, None, 120.0, 20),
        case("built by hand", 4, 4, BUILT, Some(Some(vague)), 120.0, 20),
        case("three cables", 5, 3, exact, Some(Some(vague)), 120.0, 20),
        case("two cables", 6, 2, BUILT, Some(Some(vague)), 120.0, 20),
        case("two cables, no drawing", 7, 2, exact, None, 120.0, 20),
        case("few poses", 8, 4, exact, None, 120.0, 6),
        case("little flexion", 9, 4, exact, None, 20.0, 12),
        case("weak", 10, 4, exact, None, 40.0, 8),
        case("drawing that decides", 11, 4, exact, Some(None), 120.0, 10),
    ];
    for seed in 12..18 {
        cases.push(case("few, drawn", seed, 4, exact, Some(None), 90.0, 9));
    }
    let mut outliers = case("outliers", 20, 4, exact, None, 120.0, 24);
    (outliers.readings[4][1], outliers.readings[17][3]) =
        (outliers.readings[4][1] + 5.0, outliers.readings[17][3] - 8.0);
    cases.push(outliers);
    let mut many = case("many outliers", 21, 4, exact, None, 120.0, 20);
    many.readings.iter_mut().step_by(3).for_each(|reading| reading[2] += 9.0);
    cases.push(many);
    let mut wild = case("wild", 22, 4, exact, None, 120.0, 16);
    let mut random = ChaCha8Rng::seed_from_u64(23);
    wild.readings.iter_mut().flatten().for_each(|length| *length *= random.random_range(0.8..1.2));
    cases.push(wild);
    let mut second = case("second axis", 24, 4, exact, None, 120.0, 24);
    let axis = second.elbow.axis_in_platform().cross(&Vector3::new(0.3, -0.5, 0.8)).normalize();
    let flexions = flexions_rad(&mut random, 24, 120.0);
    second.readings = (flexions.iter().enumerate())
        .map(|(k, flexion)| second.elbow.reading_mm(*flexion, Some((axis, if k % 2 == 0 { 0.035 } else { -0.035 }))))
        .collect();
    cases.push(second);
    let mut noisy = case("unknown noise", 25, 4, exact, None, 120.0, 40);
    noisy.readings.iter_mut().flatten().for_each(|length| *length += symmetric(&mut random, 0.3));
    noisy.noise = Some(0.35);
    cases.push(noisy);
    cases
}

impl Case {
    fn rig<T: Real>(&self) -> HingeRig<T> {
        let point = |point: &Vector3<f64>| point.map(T::of);
        let cables: Vec<_> = (self.elbow.stated.iter())
            .map(|cable| CableEnds {
                base_mm: point(&cable.base_mm),
                end_mm: point(&cable.end_mm),
                pulley: Pulley::none(),
            })
            .collect();
        let tolerance = Tolerance {
            base_mm: T::of(self.tolerance.base_mm),
            edges_mm: T::of(self.tolerance.edges_mm),
            offset_mm: T::of(self.tolerance.offset_mm),
            drum: T::of(self.tolerance.drum),
        };
        let rig = HingeRig::new(&cables, T::of(0.057_735)).unwrap();
        let rig = rig.with_tolerance(tolerance, HOME_MM.map(T::of)).unwrap();
        let Some(sigma) = self.drawing else { return rig };
        let hinge = drawn();
        let hinge = Hinge::through(
            &point(hinge.axis()),
            &point(&hinge.platform_foot_mm()),
            &point(&hinge.axis_in_platform()),
            &point(hinge.foot_in_platform_mm()),
        );
        let range_rad = (T::of(RANGE_RAD.0), T::of(RANGE_RAD.1));
        rig.with_drawing(Drawing { hinge, sigma: sigma.map(|sigma| sigma.map(T::of)), range_rad })
    }

    fn estimator<T: Real>(&self) -> HingeEstimator<T> {
        let rig = self.rig();
        let settings = HingeSettings::for_rig(&rig);
        let noise = self.noise.map_or(settings.noise, |most| Noise::EstimatedUpTo(T::of(most)));
        HingeEstimator::new(&rig, HingeSettings { noise, ..settings })
    }

    fn poses<T: Real>(&self) -> Vec<HingePose<T>> {
        self.readings.iter().map(|reading| HingePose::new(reading.map(T::of))).collect()
    }
}

/// A checksum (FNV-1a) over the bits of all that a run leaves.
fn checksum<T: Real>(found: &Outcome<T>, poses: &[HingePose<T>]) -> u32 {
    let mut sum = 0x811c_9dc5_u32;
    let mut add = |bits: u32| {
        for byte in bits.to_le_bytes() {
            sum = (sum ^ u32::from(byte)).wrapping_mul(0x0100_0193);
        }
    };
    match found {
        Ok(found) => {
            let hinge = &found.hinge;
            let vectors = [*hinge.axis(), *hinge.foot_mm(), hinge.axis_in_platform(), *hinge.foot_in_platform_mm()];
            vectors.iter().flat_map(|vector| vector.iter()).for_each(|x| add(x.to_f32().to_bits()));
            found.covariance.iter().for_each(|x| add(x.to_f32().to_bits()));
            found.machine.values().iter().for_each(|x| add(x.to_f32().to_bits()));
            [found.noise_mm, found.rms_residual_mm, found.flexion_rad].iter().for_each(|x| add(x.to_f32().to_bits()));
            add(found.rejected);
            for pose in poses {
                [pose.angle_rad, pose.chi_square, pose.weight].iter().for_each(|x| add(x.to_f32().to_bits()));
                add(pose.suspect_cables.into());
            }
        }
        Err(refusal) => format!("{refusal:?}").bytes().for_each(|byte| add(byte.into())),
    }
    sum
}

/// Checksums of what the estimator gave before it worked in slices, kept since then but where sine and cosine became its own,
/// where axes were given one direction and where turning lost a product: the numbers were the same but for signs and rounding.
const IN_ONE_PIECE: [(&str, u32, u32); 22] = [
    ("four cables", 0x7adb77f8, 0x2ba25223),
    ("four cables", 0xe33cb08c, 0xf2dd99af),
    ("built by hand", 0xdcb5b029, 0x8585ed39),
    ("built by hand", 0x7968d435, 0xf000e3ab),
    ("three cables", 0x76e5a0c7, 0x8d9839a1),
    ("two cables", 0xfd71a492, 0xbfd87d77),
    ("two cables, no drawing", 0x075e7491, 0x075e7491),
    ("few poses", 0xf79995b1, 0x764b15bb),
    ("little flexion", 0xa9b9754d, 0x72f9b926),
    ("weak", 0xd6abcc2f, 0x8b5d4c70),
    ("drawing that decides", 0xda593747, 0xd524107a),
    ("few, drawn", 0xbc8e3bae, 0x6053428c),
    ("few, drawn", 0xcb33dca3, 0xa50870d7),
    ("few, drawn", 0xe824006a, 0xf8c65f61),
    ("few, drawn", 0xb849f246, 0xcef0c9de),
    ("few, drawn", 0x8f114375, 0xed95d4b5),
    ("few, drawn", 0xec457396, 0xfd473180),
    ("outliers", 0xbd3a5b4a, 0x5728bc4c),
    ("many outliers", 0xc1d409e6, 0x50118073),
    ("wild", 0x80458ded, 0x3575fec3),
    ("second axis", 0x998b773c, 0xc1408e41),
    ("unknown noise", 0x58cdfbb2, 0x7211aef7),
];

/// All slices of a run.
fn in_slices<T: Real>(estimator: &mut HingeEstimator<T>, poses: &mut [HingePose<T>]) -> Outcome<T> {
    loop {
        match estimator.advance(poses) {
            HingeProgress::Working => {}
            HingeProgress::Identified(found) => return Ok(found.clone()),
            HingeProgress::Refused(refusal) => return Err(refusal),
        }
    }
}

#[test]
fn the_slices_give_to_the_bit_what_one_piece_gave() {
    fn of<T: Real>(case: &Case) -> u32 {
        let mut poses = case.poses::<T>();
        let found = in_slices(&mut case.estimator::<T>(), &mut poses);
        checksum(&found, &poses)
    }
    let found: Vec<_> = cases().iter().map(|case| (case.name, of::<f64>(case), of::<f32>(case))).collect();
    assert_eq!(found, IN_ONE_PIECE);
}

/// What another set has left in it, finished or not, does not get into the next result.
#[test]
fn a_hinge_estimator_that_is_begun_anew_gives_the_same() {
    let cases = cases();
    for case in cases.iter().filter(|case| ["built by hand", "outliers", "second axis"].contains(&case.name)) {
        let mut estimator = case.estimator::<f32>();
        let first = in_slices(&mut estimator, &mut case.poses());
        let mut others = case.poses();
        others.truncate(8);
        estimator.restart();
        for slices in [3, 1_000, 20_000] {
            for _ in 0..slices {
                let _ = estimator.advance(&mut others);
            }
            assert_eq!(estimator.run(&mut case.poses()), first, "{} after {slices} slices", case.name);
        }
    }
}
