//! `cargo commission`: what it finds, what it refuses by name, and that nothing is half-written.

use glenoid::rig::{ATTACHMENTS, CABLES, Rig};
use host_tests::commission::{self, Finding, Request};
use host_tests::identify::input_error::InputError;
use host_tests::identify::rig_file::RigFile;
use nalgebra::{Rotation3, Vector3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::fmt::Write as _;
use std::path::PathBuf;

/// What is wrong with the machine.
const OFFSETS_MM: [f64; CABLES] = [4.0, -3.0, 2.0, 6.0, -5.0, 1.0];
const FIRST_POINT_OFF_MM: [f64; 3] = [1.2, -0.8, 0.6];
const NOISE_MM: f64 = 0.1;

struct Bench {
    folder: PathBuf,
    random: ChaCha8Rng,
    rig: Rig<f64>,
}

impl Bench {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("glenoid-commission-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let rig = Rig::shoulder(150.0).unwrap();
        let bench = Self { folder, random: ChaCha8Rng::seed_from_u64(11), rig };
        let base: Vec<[f64; 3]> = bench.rig.base_mm().iter().map(|point| (*point).into()).collect();
        bench.file(
            "rig.toml",
            &format!(
                "home = {:?}\nbase = {base:?}\nedges = {:?}\n[tolerance]\nbase = 1.0\nedges = 1.0\nzero = 10.0\ndrum = 0.005\n",
                bench.rig.drum().home_length_mm,
                bench.rig.edges_mm()
            ),
        );
        bench
    }

    fn file(&self, name: &str, text: &str) {
        std::fs::write(self.folder.join(name), text).unwrap();
    }

    /// A log about `centre`, tilted and turned by up to `reach` degrees.
    fn log(&mut self, name: &str, centre: [f64; 3], poses: usize, reach: [f64; 2]) {
        let centre = Vector3::from(centre);
        let platform = self.rig.platform_mm();
        let middle = platform.iter().sum::<Vector3<f64>>() / 3.0;
        let mut base = *self.rig.base_mm();
        base[0] += Vector3::from(FIRST_POINT_OFF_MM);
        // At home P1 stands above the middle of B1 B2: the platform's axes are turned about z by this.
        let first = platform[0] - middle;
        let home = Rotation3::from_axis_angle(&Vector3::z_axis(), 60_f64.to_radians() - first.y.atan2(first.x));
        let mut text = "l1,l2,l3,l4,l5,l6\n".to_owned();
        for _ in 0..poses {
            let azimuth = self.random.random_range(0.0..std::f64::consts::TAU);
            let tilt = self.random.random_range(0.0..=reach[0]).to_radians();
            let torsion = self.random.random_range(-reach[1]..=reach[1]).to_radians();
            let tilted = Rotation3::new(Vector3::new(azimuth.cos(), azimuth.sin(), 0.0) * tilt);
            let rotation = tilted * Rotation3::new(Vector3::z() * torsion);
            let row: Vec<String> = (0..CABLES)
                .map(|cable| {
                    let arm = home * (platform[cable / 2] - middle) + Vector3::new(0.0, 0.0, 96.0);
                    let span = centre + rotation * arm - base[ATTACHMENTS[cable / 2][cable % 2]];
                    let noise = self.random.random_range(-NOISE_MM..NOISE_MM);
                    format!("{:.6}", span.norm() + OFFSETS_MM[cable] + noise)
                })
                .collect();
            let _ = writeln!(text, "{}", row.join(","));
        }
        self.file(name, &text);
    }

    fn run(&self, request: &str) -> Result<Finding, InputError> {
        self.file("commission.toml", request);
        commission::run(&self.request()?)
    }

    fn request(&self) -> Result<Request, InputError> {
        Request::read(&self.folder.join("commission.toml"))
    }

    fn refusal(&self, request: &str) -> String {
        let found = self.run(request).unwrap();
        assert_eq!(found.rig_text, None);
        found.report.reason.unwrap()
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// Tilt and torsion of a ball on a bench, degrees.
const WIDE: [f64; 2] = [55.0, 55.0];

#[test]
fn finds_offsets_and_the_shape_of_the_base() {
    let mut bench = Bench::new("finds");
    for (name, centre) in
        [("a.csv", [10.0, 0.0, 150.0]), ("b.csv", [-15.0, 10.0, 140.0]), ("c.csv", [5.0, -15.0, 160.0])]
    {
        bench.log(name, centre, 300, WIDE);
    }
    let found = bench
        .run("rig = \"rig.toml\"\n[[log]]\nfile = \"a.csv\"\n[[log]]\nfile = \"b.csv\"\n[[log]]\nfile = \"c.csv\"\n");
    let found = found.unwrap();
    assert_eq!(found.report.reason, None);
    let mut base = *bench.rig.base_mm();
    base[0] += Vector3::from(FIRST_POINT_OFF_MM);
    let truth = |name: &str| match name {
        "B1B2" => (base[1] - base[0]).norm(),
        "B2B3" => (base[2] - base[1]).norm(),
        "B3B1" => (base[0] - base[2]).norm(),
        name => match name.strip_prefix("zero ") {
            Some(cable) => OFFSETS_MM[cable.parse::<usize>().unwrap() - 1],
            None if name.starts_with("drum") => 1.0,
            None => bench.rig.edges_mm()[0],
        },
    };
    assert_eq!(found.report.constants.len(), 18);
    for constant in &found.report.constants {
        let off = (constant.found - truth(&constant.name)).abs();
        assert!(off < 4.5 * constant.sigma, "{}: off by {off}, sigma {}", constant.name, constant.sigma);
        assert!(constant.sigma < constant.stated_sigma);
    }
    // Without a ball at a known place a shift of everything stays open, and that is said.
    assert!(
        found.report.next.iter().any(|advice| advice.contains("ball joint at a known place")),
        "{:?}",
        found.report.next
    );
    let written = RigFile::parse("found", found.rig_text.unwrap().as_bytes()).unwrap();
    assert_eq!(written.covariance.map(|triangle| triangle.len()), Some(171));
}

#[test]
fn a_bad_pose_is_left_out_by_its_line() {
    let mut bench = Bench::new("pose");
    bench.log("a.csv", [10.0, 0.0, 150.0], 100, WIDE);
    let path = bench.folder.join("a.csv");
    let text = std::fs::read_to_string(&path).unwrap();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let mut lengths: Vec<f64> = lines[41].split(',').map(|length| length.parse().unwrap()).collect();
    lengths[2] += 5.0;
    lines[41] = lengths.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
    std::fs::write(&path, lines.join("\n")).unwrap();
    let found = bench.run("rig = \"rig.toml\"\n[[log]]\nfile = \"a.csv\"\n").unwrap();
    assert_eq!(found.report.logs[0].left_out_lines, [42]);
}

#[test]
fn logs_that_determine_nothing_are_refused_by_name() {
    let mut bench = Bench::new("nothing");
    bench.log("a.csv", [10.0, 0.0, 150.0], 60, WIDE);
    bench.log("axis.csv", [10.0, 0.0, 150.0], 60, [0.01, 55.0]);
    bench.log("few.csv", [10.0, 0.0, 150.0], 4, WIDE);
    for (log, complaint) in [("axis.csv", "turn about one axis"), ("few.csv", "4 different poses")] {
        let reason =
            bench.refusal(&format!("rig = \"rig.toml\"\n[[log]]\nfile = \"a.csv\"\n[[log]]\nfile = \"{log}\"\n"));
        assert!(
            reason.contains("commission.toml, line 5: ") && reason.contains(log) && reason.contains(complaint),
            "{reason}"
        );
    }
}

/// Three logs; the second is of a machine whose home lengths are others.
#[test]
fn a_log_of_another_rig_is_refused_by_its_line() {
    let mut bench = Bench::new("mixed");
    for (name, centre) in
        [("a.csv", [10.0, 0.0, 150.0]), ("b.csv", [-15.0, 10.0, 140.0]), ("c.csv", [5.0, -15.0, 160.0])]
    {
        bench.log(name, centre, 100, WIDE);
    }
    let path = bench.folder.join("b.csv");
    let mut other = String::new();
    for (index, line) in std::fs::read_to_string(&path).unwrap().lines().enumerate() {
        let off = [9.0, -7.0, 0.0, 12.0, -8.0, 5.0];
        let lengths = line.split(',').zip(off).map(|(length, off)| match length.parse::<f64>() {
            Ok(length) if index > 0 => (length + off).to_string(),
            _ => length.to_owned(),
        });
        let _ = writeln!(other, "{}", lengths.collect::<Vec<_>>().join(","));
    }
    std::fs::write(&path, other).unwrap();
    let logs = ["a.csv", "b.csv", "c.csv"].map(|log| format!("[[log]]\nfile = \"{log}\"\n")).concat();
    let reason = bench.refusal(&format!("rig = \"rig.toml\"\n{logs}"));
    assert!(
        reason.contains("commission.toml, line 5: ")
            && reason.contains("b.csv: ")
            && reason.contains("another rig or another homing"),
        "{reason}"
    );
}

#[test]
fn a_place_in_another_frame_is_refused_by_its_line() {
    let mut bench = Bench::new("frame");
    bench.log("a.csv", [10.0, 0.0, 150.0], 100, WIDE);
    let reason = bench.refusal("rig = \"rig.toml\"\n[[log]]\nfile = \"a.csv\"\ncentre = [60.0, 0.0, 150.0]\n");
    assert!(reason.contains("commission.toml, line 4: ") && reason.contains("frame {B}"), "{reason}");
}

#[test]
fn what_cannot_be_meant_is_refused_with_its_line() {
    let bench = Bench::new("request");
    for (request, complaint) in [
        ("rig = \"rig.toml\"\n", "[[log]] with file"),
        ("rig = \"rig.toml\"\n[[log]]\nfil = \"a.csv\"\n", "line 3, column 1: unknown key \"fil\""),
        ("rig = \"rig.toml\"\n[[log]]\nfile = \"a.csv\"\n[[log]]\nfile = \"a.csv\"\n", "is the log of line 3 again"),
        ("rig = \"rig.toml\"\n[[log]]\nfile = \"a.csv\"\ncentre_sigma = 0.1\n", "centre_sigma without centre"),
        ("rig = \"rig.toml\"\n[[log]]\nfile = \"a.csv\"\ncentre = [1, 2]\n", "3 numbers are wanted, there are 2"),
        ("rig = \"rig.toml\"\nhoming = -1\n[[log]]\nfile = \"a.csv\"\n", "line 2, column 10: homing: -1 mm"),
    ] {
        bench.file("commission.toml", request);
        let error = bench.request().unwrap_err().to_string();
        assert!(error.contains(complaint), "{error}");
    }
    bench.file("a.csv", "l1,l2,l3,l4,l5,l6\n278,278,278,278,278,278\n");
    bench.file("copy.csv", "l1,l2,l3,l4,l5,l6\n278,278,278,278,278,278\n");
    for again in ["./a.csv", "copy.csv"] {
        let request = format!("rig = \"rig.toml\"\n[[log]]\nfile = \"a.csv\"\n[[log]]\nfile = \"{again}\"\n");
        bench.file("commission.toml", &request);
        let error = bench.request().unwrap_err().to_string();
        assert!(error.contains("line 5, column 8: ") && error.contains("is the log of line 3 again"), "{error}");
    }
    bench.file("elbow.toml", include_str!("../../../examples/elbow.toml"));
    bench.file("commission.toml", "rig = \"elbow.toml\"\n[[log]]\nfile = \"a.csv\"\n");
    let error = bench.request().unwrap_err().to_string();
    assert!(error.contains("elbow.toml, line 4, column 9: joint: a hinge, where a ball is wanted"), "{error}");
    // the first byte that is no UTF-8, not the first line
    std::fs::write(bench.folder.join("commission.toml"), b"rig = \"rig.toml\"\n# \xe4\n").unwrap();
    let error = bench.request().unwrap_err().to_string();
    assert!(error.contains("commission.toml, line 2, column 3: not UTF-8 text"), "{error}");
}

#[test]
fn the_rig_that_it_comes_from_is_never_replaced() {
    let mut bench = Bench::new("replace");
    bench.log("a.csv", [10.0, 0.0, 150.0], 100, WIDE);
    let found = bench.run("rig = \"rig.toml\"\n[[log]]\nfile = \"a.csv\"\n").unwrap();
    let (request, text) = (bench.request().unwrap(), found.rig_text.unwrap());
    let before = std::fs::read(bench.folder.join("rig.toml")).unwrap();
    assert!(commission::write(&request, &bench.folder.join("rig.toml"), &text).is_err());
    assert_eq!(std::fs::read(bench.folder.join("rig.toml")).unwrap(), before);
    let output = bench.folder.join("found.toml");
    commission::write(&request, &output, &text).unwrap();
    assert_eq!(std::fs::read_to_string(&output).unwrap(), text);
    let left: Vec<_> = std::fs::read_dir(&bench.folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert!(left.iter().all(|name| !name.to_string_lossy().ends_with(".tmp")), "{left:?}");
}
