//! The whole arm: is the hand where all cable lengths say it is, within what they say of it?

use super::built::{BuiltMachine, NOISE_SIGMA_MM, Worn};
use super::elbow::scene::{Elbow, NOISE_MM, drawn, flexions_rad};
use super::elbow::{ANYBODY, RANGE_RAD};
use super::findings::{Findings, Plan, Problem, Table, Target, percent, short};
use super::scene::{Reach, normal, symmetric, symmetric_vector};
use super::statistics::root_mean_square;
use super::{Study, trials};
use crate::estimation::{Estimation, estimate};
use crate::plot::{Axis, Chart, Series};
use glenoid::identification::arm::{Arm, ArmPose, Ball, Mount};
use glenoid::identification::hinge::{Drawing, HingeEstimator, HingePose, HingeSettings};
use glenoid::identification::{EstimatorSettings, Machine, Noise, Pose};
use glenoid::kinematics::CableLengths;
use glenoid::rig::{CABLES, Rig, Tolerance};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// Shoulder, elbow and wrist.
pub const STUDY: Study = Study {
    name: "arm",
    about: "shoulder, elbow and wrist as one chain: the hand's real error over its reported sigma, lengths of the limbs",
    trials: 1_000,
    run,
};

/// Poses that identify each module.
const POSES: usize = 30;
/// How far the arm and the hand move, beside the elbow's 0 to 120 degrees.
pub(super) const WRIST: Reach = Reach { tilt_deg: 30.0, torsion_deg: 20.0 };
/// The elbow's base in the shoulder's platform, and the wrist's in the elbow's, mm.
pub(crate) const UPPER_ARM_MM: Vector3<f64> = Vector3::new(77.0, 45.0, 60.0);
/// The latter.
pub(crate) const FOREARM_MM: Vector3<f64> = Vector3::new(0.0, 0.0, 110.0);
/// The hand in the wrist's platform, mm.
pub(crate) const HAND_MM: Vector3<f64> = Vector3::new(35.0, 20.0, 60.0);

/// What is known of the machines and of how they stand on the limbs.
pub(super) struct Case {
    pub name: &'static str,
    pub tolerance: Tolerance<f64>,
    /// The elbow's drawing is a prior.
    pub drawing: bool,
    pub mount_mm: f64,
    pub mount_rad: f64,
}

/// Machines as drawn, and machines that are not.
pub(super) const CASES: [Case; 2] = [
    Case { name: "exact", tolerance: tolerance(0.0, 0.0, 0.0, 0.0), drawing: false, mount_mm: 0.0, mount_rad: 0.0 },
    Case {
        name: ".5/.5/.3/.1 %, mounts .3 mm, 2 mrad",
        tolerance: tolerance(0.5, 0.5, 0.3, 0.001),
        drawing: true,
        mount_mm: 0.3,
        mount_rad: 0.002,
    },
];

const fn tolerance(base_mm: f64, edges_mm: f64, offset_mm: f64, drum: f64) -> Tolerance<f64> {
    Tolerance { base_mm, edges_mm, offset_mm, drum }
}

/// An arm that was identified.
struct Outcome {
    /// Squared errors of hand and wrist over their reported covariance, by degree of freedom.
    squares: [f64; 2],
    /// Errors of the hand and the wrist, mm.
    error_mm: [f64; 2],
    /// What shoulder, elbow, wrist and mounts add to the hand's σ, mm.
    by_module_mm: [f64; 4],
    /// Errors of both limbs' lengths, and their reported 1σ, mm.
    limbs: [(f64, f64); 2],
}

const METHOD: &str = "A trial is somebody's arm: a shoulder over the 150 mm base, an elbow in the default rig whose base stands on the shoulder's \
    platform, a wrist in the wrist rig that stands on the elbow's; each identified by itself from 30 random poses with noise within \
    ±0.1 mm. Then a random posture of all three: the hand's place from its sixteen lengths, against where it is. Frames are those \
    best fitted to the points as they are. An arm counts when all three are accepted.";

fn run(plan: &Plan) -> Result<Findings, Problem> {
    let columns = [
        "machines",
        "arms accepted",
        "hand: real / reported σ",
        "wrist: the same",
        "hand: rms error (mm)",
        "from shoulder",
        "elbow",
        "wrist",
        "mounts (mm)",
    ];
    let mut table = Table::new("arm", "The hand from all lengths of the arm", &columns);
    let columns =
        ["machines", "upper arm: rms error (mm)", "real / reported σ", "forearm: rms error (mm)", "real / reported σ"];
    let mut limbs = Table::new("arm-limbs", "Lengths of the limbs", &columns);
    let mut findings = Findings { method: METHOD.to_owned(), ..Findings::default() };
    let mut bars = [Vec::new(), Vec::new()];
    for (which, case) in CASES.iter().enumerate() {
        let outcomes =
            trials::run(plan.seed, &format!("arm {}", case.name), plan.trials, |_, random| trial(case, random));
        let accepted: Vec<_> = outcomes.into_iter().flatten().collect();
        let ratio = |point: usize| root_mean_square(accepted.iter().map(|arm| libm::sqrt(arm.squares[point] / 3.0)));
        let module = |k: usize| root_mean_square(accepted.iter().map(|arm| arm.by_module_mm[k]));
        table.push([
            case.name.to_owned(),
            percent(accepted.len(), plan.trials as usize),
            short(ratio(0)),
            short(ratio(1)),
            short(root_mean_square(accepted.iter().map(|arm| arm.error_mm[0]))),
            short(module(0)),
            short(module(1)),
            short(module(2)),
            short(module(3)),
        ]);
        let limb = |k: usize| {
            let error = root_mean_square(accepted.iter().map(|arm| arm.limbs[k].0));
            (error, root_mean_square(accepted.iter().map(|arm| arm.limbs[k].0 / arm.limbs[k].1)))
        };
        let ((upper_mm, upper), (fore_mm, fore)) = (limb(0), limb(1));
        limbs.push([case.name.to_owned(), short(upper_mm), short(upper), short(fore_mm), short(fore)]);
        for (what, ratio) in [("hand", ratio(0)), ("upper arm's length", upper), ("forearm's length", fore)] {
            let name = format!("{}: {what}, real / reported σ", case.name);
            findings.targets.push(Target::between(name, (0.95, 1.05), ratio));
        }
        bars[which] = (0..4).map(|k| (k as f64 + 1.0, module(k))).collect();
    }
    findings.tables.extend([table, limbs]);
    let mut chart = Chart::new(
        "What each module adds to the hand's σ",
        Axis::linear("1 shoulder, 2 elbow, 3 wrist, 4 mounts").including(0.0),
        Axis::linear("root of the summed variances (mm)").including(0.0),
    );
    for (case, points) in CASES.iter().zip(bars) {
        chart = chart.with(Series::line(case.name, points));
    }
    findings.figures.push(("arm", Box::new(chart)));
    Ok(findings)
}

/// A ball in its machine, identified.
struct Joint {
    built: BuiltMachine,
    worn: Worn,
    machine: Machine<f64>,
    estimation: Estimation<f64>,
}

impl Joint {
    fn new(random: &mut ChaCha8Rng, rig: Rig<f64>, case: &Case, off_mm: [f64; 2], reach: Reach) -> Option<Self> {
        let built = BuiltMachine::of(random, rig, &case.tolerance, case.tolerance).ok()?;
        let worn = built.worn_within(random, off_mm[0], off_mm[1]);
        let readings = built.readings(random, &worn, POSES, reach);
        let lengths: Vec<_> =
            readings.iter().map(|reading| CableLengths::new(*reading)).collect::<Result<_, _>>().ok()?;
        let rig = &built.stated;
        let machine = Machine::new(rig);
        let settings = EstimatorSettings { noise: Noise::Known(NOISE_SIGMA_MM), ..EstimatorSettings::for_rig(rig) };
        let estimation = estimate(&machine, rig, settings, &lengths);
        estimation.outcome.as_ref().ok()?;
        Some(Self { built, worn, machine, estimation })
    }

    fn ball(&self) -> Ball<'_, f64> {
        Ball { estimator: &self.estimation.estimator, machine: &self.machine }
    }
}

/// A mount as it is stated, known to `sigma_mm` and `sigma_rad`, and as it is.
pub(crate) fn mount(
    random: &mut ChaCha8Rng,
    sigma_mm: f64,
    sigma_rad: f64,
    origin_mm: Vector3<f64>,
) -> (Mount<f64>, Mount<f64>) {
    let rotation = UnitQuaternion::from_scaled_axis(symmetric_vector(random, 0.3)).to_rotation_matrix().into_inner();
    let stated = Mount { rotation, origin_mm, sigma_mm, sigma_rad };
    let vector = |random: &mut ChaCha8Rng, size: f64| Vector3::from_fn(|_, _| normal(random) * size);
    let turn: Matrix3<f64> =
        UnitQuaternion::from_scaled_axis(vector(random, sigma_rad)).to_rotation_matrix().into_inner();
    let origin_mm = origin_mm + vector(random, sigma_mm);
    (stated, Mount { rotation: turn * rotation, origin_mm, ..stated })
}

/// A point of the next module's base in the platform that it stands on.
pub(crate) fn through(mount: &Mount<f64>, point: &Vector3<f64>) -> Vector3<f64> {
    mount.rotation * point + mount.origin_mm
}

fn trial(case: &Case, mut random: ChaCha8Rng) -> Option<Outcome> {
    let random = &mut random;
    let shoulder = Joint::new(random, Rig::shoulder(150.0).ok()?, case, [20.0, 10.0], Reach::USUAL)?;
    let wrist = Joint::new(random, Rig::wrist().ok()?, case, [4.0, 3.0], WRIST)?;
    let (upper_arm, true_upper_arm) = mount(random, case.mount_mm, case.mount_rad, UPPER_ARM_MM);
    let (forearm, true_forearm) = mount(random, case.mount_mm, case.mount_rad, FOREARM_MM);

    let step: [f64; 9] = std::array::from_fn(|k| ANYBODY[k] * normal(random));
    let elbow = Elbow::of_hinge(random, 4, &drawn().moved(&step), &case.tolerance);
    let mut rig = elbow.rig(case.tolerance).ok()?;
    if case.drawing {
        rig = rig.with_drawing(Drawing { hinge: drawn(), sigma: Some(ANYBODY), range_rad: RANGE_RAD });
    }
    let flexions = flexions_rad(random, POSES, 120.0);
    let mut poses: Vec<_> = elbow.readings_mm(random, &flexions).into_iter().map(HingePose::new).collect();
    let mut hinge = HingeEstimator::new(&rig, HingeSettings::for_rig(&rig));
    hinge.run(&mut poses).ok()?;

    let arm = Arm { shoulder: shoulder.ball(), upper_arm, elbow: &hinge, forearm, wrist: wrist.ball() };
    let (turn, bent, turned) =
        (Reach::USUAL.rotation(random), -random.random_range(5.0_f64..115.0).to_radians(), WRIST.rotation(random));
    let six = |random: &mut ChaCha8Rng, joint: &Joint, rotation| -> Option<Pose<f64>> {
        let reading: [f64; CABLES] = joint.built.reading(random, &joint.worn, rotation);
        CableLengths::new(reading).ok().map(Pose::new)
    };
    let posture = ArmPose {
        shoulder: six(random, &shoulder, &turn)?,
        elbow_mm: elbow.reading_mm(bent, None).map(|length| length + symmetric(random, NOISE_MM)),
        wrist: six(random, &wrist, &turned)?,
    };
    let found = arm.position(&posture, &HAND_MM).ok()?;

    let in_base = |on_forearm: &Vector3<f64>| {
        let on_upper_arm = through(&true_upper_arm, &elbow.carried_mm(on_forearm, bent));
        shoulder.built.carried_mm(&shoulder.worn, &turn, &on_upper_arm)
    };
    let wrist_mm = through(&true_forearm, &wrist.built.centre_in_base_mm(&wrist.worn));
    let hand_mm = through(&true_forearm, &wrist.built.carried_mm(&wrist.worn, &turned, &HAND_MM));
    let errors = [found.hand.at_mm - in_base(&hand_mm), found.wrist.at_mm - in_base(&wrist_mm)];
    let square =
        |error: &Vector3<f64>, covariance: &Matrix3<f64>| Some(error.dot(&(covariance.try_inverse()? * error)));

    let truth = elbow.hinge();
    let distance = |from: Vector3<f64>, axis: &Vector3<f64>| from.cross(axis).norm();
    let back = true_upper_arm.rotation.transpose()
        * (shoulder.built.centre_in_platform_mm(&shoulder.worn) - true_upper_arm.origin_mm);
    let true_upper_mm = distance(back - truth.foot_mm(), truth.axis());
    let true_fore_mm = distance(wrist_mm - truth.foot_in_platform_mm(), &truth.axis_in_platform());
    let segments = arm.segments();
    Some(Outcome {
        squares: [square(&errors[0], &found.hand.covariance_mm2)?, square(&errors[1], &found.wrist.covariance_mm2)?],
        error_mm: errors.map(|error| error.norm()),
        by_module_mm: found.by_module_mm,
        limbs: [
            (segments.upper_arm_mm.0 - true_upper_mm, segments.upper_arm_mm.1),
            (segments.forearm_mm.0 - true_fore_mm, segments.forearm_mm.1),
        ],
    })
}
