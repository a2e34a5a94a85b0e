//! `cargo arm` from the outside: three logs, three rigs and one posture, against an arm that is written out here.

use super::identify::command::{Desk, Ran, numbers};
use glenoid::rig::Tolerance;
use host_tests::study::elbow::scene::{Elbow, drawn, flexions_rad};
use nalgebra::{Matrix3, Rotation3, Vector3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;
use std::fmt::Write as _;

/// Noise of every length, uniform within this to either side, mm.
const NOISE_MM: f64 = 0.1;
/// The hand in the wrist's platform, mm.
const HAND_MM: [f64; 3] = [35.0, 20.0, 60.0];
/// Where the elbow's base stands in the shoulder's platform, and the wrist's in the elbow's, mm.
const UPPER_ARM_MM: [f64; 3] = [77.0, 45.0, 60.0];
const FOREARM_MM: [f64; 3] = [0.0, 0.0, 110.0];

/// A ball between two equilateral triangles, turned by 60 degrees against each other.
pub struct Ball {
    base_radius_mm: f64,
    edge_mm: f64,
    /// In {B}.
    centre_mm: Vector3<f64>,
    /// In {P}: P1 at the origin, P2 on the x axis.
    centre_in_platform_mm: Vector3<f64>,
}

impl Ball {
    fn new(base_radius_mm: f64, edge_mm: f64, [above_base_mm, below_platform_mm]: [f64; 2], off: &[f64; 6]) -> Self {
        let middle = Vector3::new(edge_mm / 2.0, edge_mm / 12.0_f64.sqrt(), -below_platform_mm);
        let [x, y, z, p, q, r] = *off;
        Self {
            base_radius_mm,
            edge_mm,
            centre_mm: Vector3::new(x, y, above_base_mm + z),
            centre_in_platform_mm: middle + Vector3::new(p, q, r),
        }
    }

    fn base_mm(&self) -> [Vector3<f64>; 3] {
        [0.0, 120.0, 240.0].map(|degrees| about_z(degrees) * Vector3::new(self.base_radius_mm, 0.0, 0.0))
    }

    /// A point of {P} in {B}, the platform turned from home.
    fn at_mm(&self, turned: &Rotation3<f64>, point_mm: &Vector3<f64>) -> Vector3<f64> {
        // At home P1 stands above the middle of B1 B2.
        self.centre_mm + turned * about_z(-150.0) * (point_mm - self.centre_in_platform_mm)
    }

    /// L1 = P1 B1, L2 = P1 B2, L3 = P2 B2, L4 = P2 B3, L5 = P3 B3, L6 = P3 B1.
    pub fn exact_mm(&self, turned: &Rotation3<f64>) -> Vec<f64> {
        let [b1, b2, b3] = self.base_mm();
        let edge = self.edge_mm;
        let corners = [Vector3::zeros(), Vector3::new(edge, 0.0, 0.0), about_z(60.0) * Vector3::new(edge, 0.0, 0.0)];
        let [p1, p2, p3] = corners.map(|corner| self.at_mm(turned, &corner));
        let cables = [(p1, b1), (p1, b2), (p2, b2), (p2, b3), (p3, b3), (p3, b1)];
        cables.map(|(end, base)| (end - base).norm()).to_vec()
    }

    /// The same with noise.
    pub fn lengths_mm(&self, random: &mut ChaCha8Rng, turned: &Rotation3<f64>) -> Vec<f64> {
        let exact = self.exact_mm(turned);
        exact.iter().map(|length| length + random.random_range(-NOISE_MM..=NOISE_MM)).collect()
    }

    fn rig(&self) -> String {
        format!("base = {}\nedges = [{e}, {e}, {e}]\n", rows(&self.base_mm().map(Into::into)), e = self.edge_mm)
    }
}

fn about_z(degrees: f64) -> Rotation3<f64> {
    Rotation3::from_axis_angle(&Vector3::z_axis(), degrees.to_radians())
}

/// Up to so many degrees about each axis.
pub fn turned(random: &mut ChaCha8Rng, degrees: f64) -> Rotation3<f64> {
    let limit = degrees.to_radians();
    Rotation3::from_scaled_axis(Vector3::from_fn(|_, _| random.random_range(-limit..=limit)))
}

fn rows(points: &[[f64; 3]]) -> String {
    format!("{points:?}")
}

pub fn csv(poses: &[Vec<f64>]) -> String {
    let header: Vec<_> = (1..=poses[0].len()).map(|cable| format!("l{cable}")).collect();
    poses.iter().fold(header.join(",") + "\n", |mut text, lengths| {
        let cells: Vec<_> = lengths.iter().map(|length| format!("{length:.4}")).collect();
        writeln!(text, "{}", cells.join(",")).unwrap();
        text
    })
}

/// An arm with its files on a desk.
pub struct Scene {
    pub desk: Desk,
    pub arm: String,
    pub shoulder: Ball,
    pub elbow: Elbow,
    pub wrist: Ball,
    /// The rows of the logs of shoulder, elbow and wrist, mm.
    pub logs: [Vec<Vec<f64>>; 3],
    /// Where the hand and the wrist are, in the shoulder's base, mm.
    hand_mm: Vector3<f64>,
    wrist_mm: Vector3<f64>,
    upper_arm_mm: f64,
    forearm_mm: f64,
}

impl Scene {
    pub fn new(test: &str, seed: u64, bends_to_deg: f64) -> Self {
        let random = &mut ChaCha8Rng::seed_from_u64(seed);
        let shoulder = Ball::new(150.0, 178.398, [148.0, 96.0], &[9.0, -12.0, 7.0, 4.0, -6.0, 5.0]);
        let wrist = Ball::new(60.0, 69.607, [62.0, 39.0], &[2.0, 3.0, -2.0, -1.0, 2.0, 1.0]);
        let step = [0.03, -0.05, 4.0, -3.0, 0.04, 0.02, 2.0, 3.0, -2.0];
        let elbow = Elbow::of_hinge(random, 4, &drawn().moved(&step), &Tolerance::exact());

        let desk = Desk::new(test);
        let log = |random: &mut ChaCha8Rng, ball: &Ball, degrees: f64| {
            let one = |random: &mut ChaCha8Rng| {
                let rotation = turned(random, degrees);
                ball.lengths_mm(random, &rotation)
            };
            (0..30).map(|_| one(random)).collect::<Vec<_>>()
        };
        let raised = log(random, &shoulder, 35.0);
        desk.put("shoulder.csv", csv(&raised)).put("shoulder.toml", shoulder.rig());
        let waved = log(random, &wrist, 25.0);
        desk.put("wrist.csv", csv(&waved)).put("wrist.toml", wrist.rig());
        let flexions = flexions_rad(random, 30, bends_to_deg);
        let bent: Vec<_> = elbow.readings_mm(random, &flexions).iter().map(|four| four.to_vec()).collect();
        desk.put("elbow.csv", csv(&bent)).put("elbow.toml", include_str!("../../../examples/elbow.toml"));
        let logs = [raised, bent, waved];

        let (raised, flexion, waved) = (turned(random, 30.0), -1.1_f64, turned(random, 20.0));
        let posture = [shoulder.lengths_mm(random, &raised), wrist.lengths_mm(random, &waved)];
        let elbow_posture = elbow.readings_mm(random, &[flexion])[0];
        let mounts = [turned(random, 20.0), turned(random, 20.0)];
        let arm = text(&mounts, [&posture[0], &elbow_posture, &posture[1]]);

        let [upper_arm, forearm] = mounts;
        let on_base = |on_wrist_base: &Vector3<f64>| {
            let on_forearm = forearm * on_wrist_base + Vector3::from(FOREARM_MM);
            let on_upper_arm = elbow.at_mm(&on_forearm, flexion, None);
            shoulder.at_mm(&raised, &(upper_arm * on_upper_arm + Vector3::from(UPPER_ARM_MM)))
        };
        let hinge = elbow.hinge();
        let shoulder_on_upper_arm =
            upper_arm.inverse() * (shoulder.centre_in_platform_mm - Vector3::from(UPPER_ARM_MM));
        let wrist_on_forearm = forearm * wrist.centre_mm + Vector3::from(FOREARM_MM);
        let distance =
            |point: &Vector3<f64>, on_axis: &Vector3<f64>, axis: &Vector3<f64>| (point - on_axis).cross(axis).norm();
        Self {
            hand_mm: on_base(&wrist.at_mm(&waved, &Vector3::from(HAND_MM))),
            wrist_mm: on_base(&wrist.centre_mm),
            upper_arm_mm: distance(&shoulder_on_upper_arm, hinge.foot_mm(), hinge.axis()),
            forearm_mm: distance(&wrist_on_forearm, hinge.foot_in_platform_mm(), elbow.axis_in_platform()),
            desk,
            arm,
            shoulder,
            elbow,
            wrist,
            logs,
        }
    }

    /// Runs the command on the arm's file.
    pub fn run(&self, arm: &str, options: &str) -> Ran {
        self.desk.put("arm.toml", arm).arm(&format!("arm.toml {options}"))
    }
}

/// The arm's file.
fn text(mounts: &[Rotation3<f64>; 2], [shoulder, elbow, wrist]: [&[f64]; 3]) -> String {
    let matrix = |rotation: &Rotation3<f64>| {
        let m: &Matrix3<f64> = rotation.matrix();
        rows(&[0, 1, 2].map(|i| [m[(i, 0)], m[(i, 1)], m[(i, 2)]]))
    };
    format!(
        "hand = {HAND_MM:?}\n\n\
         [shoulder]\nlog = \"shoulder.csv\"\nrig = \"shoulder.toml\"\nposture = {shoulder:?}\n\n\
         [elbow]\nlog = \"elbow.csv\"\nrig = \"elbow.toml\"\nposture = {elbow:?}\n\n\
         [wrist]\nlog = \"wrist.csv\"\nrig = \"wrist.toml\"\nposture = {wrist:?}\n\n\
         [upper_arm]\nrotation = {}\norigin = {UPPER_ARM_MM:?}\n\n\
         [forearm]\nrotation = {}\norigin = {FOREARM_MM:?}\n",
        matrix(&mounts[0]),
        matrix(&mounts[1]),
    )
}

/// Error of a point over its covariance: χ² with three degrees of freedom.
fn chi_square(point: &Value, truth_mm: &Vector3<f64>) -> f64 {
    let error = Vector3::from_vec(numbers(point, "at_mm")) - truth_mm;
    let [xx, xy, xz, yy, yz, zz] = numbers(point, "covariance_mm2")[..] else { panic!("{point}") };
    let covariance = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    error.dot(&(covariance.try_inverse().unwrap() * error))
}

/// 24 points with three degrees of freedom each: their mean χ² over 3 is 1 ± 0.17.
#[test]
fn the_hand_is_where_three_logs_and_a_posture_say() {
    let mut sum = 0.0;
    let seeds = [1, 2, 3, 5, 6, 7, 8, 9, 10, 11, 12, 13];
    for seed in seeds {
        let scene = Scene::new("arm_accepted", seed, 120.0);
        let ran = scene.run(&scene.arm, "--json");
        assert_eq!(ran.code, Some(0), "{seed}: {ran:?}");
        let found = ran.json();
        for (name, truth_mm) in [("hand", &scene.hand_mm), ("wrist", &scene.wrist_mm)] {
            let squares = chi_square(&found[name], truth_mm);
            assert!(squares < 21.0, "{seed}: {name} {squares}");
            let sigma = numbers(&found[name], "sigma_mm");
            assert!(sigma.iter().all(|sigma| (0.02..5.0).contains(sigma)), "{seed}: {sigma:?}");
            sum += squares;
        }
        for (name, truth_mm) in [("upper_arm", scene.upper_arm_mm), ("forearm", scene.forearm_mm)] {
            let figure = |key: &str| found[name][key].as_f64().unwrap();
            assert!((figure("length_mm") - truth_mm).abs() < 4.5 * figure("sigma_mm"), "{seed}: {name} {truth_mm}");
        }
        let parts = numbers(&found, "hand_sigma_by_module_mm");
        let whole = numbers(&found["hand"], "sigma_mm");
        let squares = |numbers: &[f64]| numbers.iter().map(|x| x * x).sum::<f64>();
        assert!((squares(&parts) / squares(&whole) - 1.0).abs() < 1e-6, "{parts:?} {whole:?}");
        let shares = numbers(&found, "hand_share_by_module");
        assert!((shares[1] / (parts[1] * parts[1] / squares(&parts)) - 1.0).abs() < 1e-9, "{shares:?} {parts:?}");
        let further = numbers(&found["most_useful_pose"], "hand_sigma_mm");
        assert!((further[0] / squares(&whole).sqrt() - 1.0).abs() < 1e-6 && further[1] < further[0], "{further:?}");
        assert_eq!(numbers(&found["most_useful_pose"], "elbow_mm").len(), 4);
        assert!(parts[3] < 1e-6, "mounts without a standard deviation add nothing: {}", parts[3]);
    }
    let ratio = (sum / (6 * seeds.len()) as f64).sqrt();
    assert!((0.7..1.3).contains(&ratio), "{ratio}");
}

#[test]
fn how_the_modules_stand_on_the_limbs_counts() {
    let scene = Scene::new("arm_mounts", 1, 120.0);
    let mounted = scene.arm.clone() + "sigma_mm = 0.5\nsigma_deg = 0.5\n";
    let before = scene.run(&scene.arm, "--json").json();
    let after = scene.run(&mounted, "--json").json();
    assert_eq!(numbers(&before["hand"], "at_mm"), numbers(&after["hand"], "at_mm"));
    // Half a millimetre along each axis, and half a degree at the distance of the hand from the wrist's base.
    let mounts_mm = numbers(&after, "hand_sigma_by_module_mm")[3];
    let least_mm = 0.5 * 3.0_f64.sqrt();
    assert!((least_mm..least_mm + 3.0).contains(&mounts_mm), "{mounts_mm}");
    let words = scene.run(&mounted, "").words();
    assert!(words.starts_with("ACCEPTED: the whole arm, in the shoulder's base"), "{words}");
    assert!(words.contains("mm long (1 sigma"), "{words}");
}

#[test]
fn a_module_that_is_refused_is_named() {
    let stiff = Scene::new("arm_stiff", 1, 10.0);
    let ran = stiff.run(&stiff.arm, "--json");
    let report = ran.json();
    assert_eq!((ran.code, report["module"].as_str()), (Some(2), Some("elbow")), "{ran:?}");
    assert!(report["reason"].as_str().unwrap().starts_with("too little flexion"), "{ran:?}");
    assert!(report["hand"].is_null());
    let words = stiff.run(&stiff.arm, "").words();
    assert!(words.starts_with("REFUSED: the elbow: too little flexion"), "{words}");

    let scene = Scene::new("arm_out_of_order", 1, 120.0);
    let exchanged = scene
        .arm
        .replace("log = \"shoulder.csv\"", "log = \"other.csv\"")
        .replace("log = \"wrist.csv\"", "log = \"shoulder.csv\"")
        .replace("log = \"other.csv\"", "log = \"wrist.csv\"");
    let ran = scene.run(&exchanged, "--json");
    assert_eq!((ran.code, ran.json()["module"].as_str()), (Some(2), Some("shoulder")), "{ran:?}");
    let words = scene.run(&exchanged, "").words();
    assert!(words.starts_with("REFUSED: the shoulder: its log is that of the wrist"), "{words}");
    assert!(words.contains("Exchange log = ... of [shoulder] and [wrist] in arm.toml"), "{words}");
}

#[test]
fn what_cannot_be_read_is_named_with_its_place() {
    let scene = Scene::new("arm_bad_files", 1, 120.0);
    let arm = &scene.arm;
    let without_wrist = with_section(arm, "[wrist]", "[upper_arm]", "").replace("[wrist]", "");
    for (text, complaint) in [
        (without_wrist, "the section [wrist] is missing"),
        (
            arm.replace("[forearm]", "[lower_arm]"),
            "unknown key \"lower_arm\": the file may hold hand, shoulder, elbow, wrist, upper_arm, forearm",
        ),
        (
            arm.replace("origin", "place"),
            "unknown key \"place\": upper_arm may hold rotation, origin, sigma_mm, sigma_deg",
        ),
        (arm.replace("hand = ", "# hand = "), "hand = [x, y, z]"),
        (arm.replace("rig = \"wrist.toml\"\n", ""), "wrist: the rig is missing"),
        (arm.replace("rig = \"elbow.toml\"", "rig = \"wrist.toml\""), "elbow: the rig is no hinge"),
        (arm.replace("rig = \"shoulder.toml\"", "rig = \"elbow.toml\""), "shoulder: the rig is a hinge"),
        (arm.replace("log = \"elbow.csv\"\n", ""), "elbow: log = \"FILE.csv\" is missing"),
        (arm.replace("elbow.csv", "nowhere.csv"), "nowhere.csv"),
        (arm.replace("log = \"shoulder.csv\"", "log = \"elbow.csv\""), "elbow: the log is that of the shoulder"),
        (
            with_section(
                arm,
                "[upper_arm]",
                "[forearm]",
                "rotation = [[1, 0, 0], [0, 1, 0], [0, 0, -1]]\norigin = [0, 0, 0]",
            ),
            "rotation: the rows are no rotation",
        ),
        (
            with_section(
                arm,
                "[elbow]",
                "[wrist]",
                "log = \"elbow.csv\"\nrig = \"elbow.toml\"\nposture = [230.0, 230.0]",
            ),
            "posture: 4 lengths are wanted, one a cable",
        ),
        (
            arm.replace("hand = [", "hand = [1e300, 0.0, 0.0] # "),
            "hand: a point within 2000 mm of the origin is wanted",
        ),
        (arm.replace("hand = [", "hand = [0.035, 0.02, 0.06] # "), "line 1, column 8: hand: 0.072284161474004"),
        (
            with_section(
                arm,
                "[upper_arm]",
                "[forearm]",
                "rotation = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\norigin = [0.077, 0.045, 0.06]",
            ),
            "from the origin looks like metres; millimetres are wanted",
        ),
        (
            with_section(arm, "[upper_arm]", "[forearm]", "rotation = [10, 20, 30]\norigin = [0, 0, 0]"),
            "a row of rotation: 3 numbers are wanted, not integer",
        ),
        (arm.clone() + "sigma_mm = -1.0\n", "sigma_mm: a standard deviation of 0 to 100 is wanted"),
    ] {
        let ran = scene.run(&text, "");
        assert_eq!(ran.code, Some(1), "{complaint}: {ran:?}");
        assert!(ran.stderr.contains(complaint), "{complaint}: {}", ran.stderr);
        assert!(ran.stdout.is_empty());
    }
    let ran = scene.desk.arm("nothing.toml");
    assert_eq!(ran.code, Some(1));
    assert!(ran.stderr.contains("nothing.toml"), "{}", ran.stderr);
}

/// The arm's file with a section replaced, the one before `next`.
fn with_section(arm: &str, section: &str, next: &str, content: &str) -> String {
    let (before, rest) = arm.split_once(section).unwrap();
    let (_, after) = rest.split_once(next).unwrap();
    format!("{before}{section}\n{content}\n\n{next}{after}")
}
