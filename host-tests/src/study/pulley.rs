//! Cables over guide pulleys and with ends of their own: does the machine as it is modelled reach the bound?

use super::built::{Accepted, Figures, NOISE_MM, NOISE_SIGMA_MM, identify};
use super::findings::{Findings, Plan, Problem, Table, Target, percent, short};
use super::scene::{Reach, symmetric, symmetric_vector};
use super::statistics::root_mean_square;
use super::{Study, trials};
use crate::identify::rig_file::{self, RigFile};
use crate::plot::{Axis, Chart, Series};
use crate::rehearse::{Expected, KnownMachine};
use crate::wearer::{Cables, FittedArm};
use glenoid::rig::{CABLES, CableEnds, Pulley, Rig, RigError, Tolerance};
use nalgebra::Vector3;
use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// Modelled pulleys and ends.
pub const STUDY: Study = Study {
    name: "pulley",
    about: "cables over guide pulleys and with ends of their own: accepted, error of the centre against the bound",
    trials: 500,
    run,
};

/// What the cables run over, how far apart two ends of a point are, and how well that is known.
struct Case {
    name: &'static str,
    pulley_mm: f64,
    apart_mm: f64,
    tolerance: Option<Tolerance<f64>>,
}

const CASES: [Case; 5] = [
    Case { name: "pulleys of 5 mm", pulley_mm: 5.0, apart_mm: 0.0, tolerance: None },
    Case { name: "pulleys of 10 mm", pulley_mm: 10.0, apart_mm: 0.0, tolerance: None },
    Case { name: "ends 5 mm apart", pulley_mm: 0.0, apart_mm: 5.0, tolerance: None },
    Case { name: "pulleys of 10 mm, ends 5 mm apart", pulley_mm: 10.0, apart_mm: 5.0, tolerance: None },
    Case {
        name: "the same, off by .5 .5 .3 .1 % as stated",
        pulley_mm: 10.0,
        apart_mm: 5.0,
        tolerance: Some(Tolerance { base_mm: 0.5, edges_mm: 0.5, offset_mm: 0.3, drum: 0.001 }),
    },
];

const POSES: [usize; 2] = [30, 100];

fn run(plan: &Plan) -> Result<Findings, Problem> {
    let columns = ["machine", "poses", "accepted", "rms centre error (mm)", "bound (mm)", "real / reported σ", "wrong"];
    let mut table = Table::new("pulley", "Guide pulleys and ends of their own, modelled", &columns);
    let mut targets = Vec::new();
    let mut lines = [Vec::new(), Vec::new()];
    for (index, case) in CASES.iter().enumerate() {
        let known = case.machine()?;
        for (which, poses) in POSES.into_iter().enumerate() {
            let name = format!("{}, {poses} poses", case.name);
            let outcomes = trials::run(plan.seed, &format!("pulley {name}"), plan.trials, |_, mut random| {
                trial(&mut random, case, &known, poses)
            });
            let bound = root_mean_square(outcomes.iter().flatten().map(|(_, bound)| *bound));
            let found: Vec<_> = outcomes.into_iter().map(|outcome| outcome.and_then(|(found, _)| found)).collect();
            let figures = Figures::of(&found);
            targets.push(Target::at_least(format!("{name}: share accepted"), 0.99, figures.accepted));
            targets.push(Target::at_most(format!("{name}: rms over bound"), 1.05, figures.rms_mm / bound));
            targets.push(Target::between(format!("{name}: real / reported"), (0.95, 1.05), figures.ratio));
            targets.push(Target::at_most(format!("{name}: wrong"), 0.0, figures.wrong as f64));
            lines[which].push((index as f64 + 1.0, figures.rms_mm / bound));
            table.push([
                case.name.to_owned(),
                poses.to_string(),
                percent(found.iter().flatten().count(), found.len()),
                short(figures.rms_mm),
                short(bound),
                short(figures.ratio),
                figures.wrong.to_string(),
            ]);
        }
    }
    let mut chart = Chart::new(
        "Guide pulleys and ends of their own",
        Axis::linear("machine of the table"),
        Axis::linear("rms error of the centre over its bound").including(0.0),
    );
    for (points, poses) in lines.into_iter().zip(POSES) {
        chart = chart.with(Series::line(&format!("{poses} poses"), points));
    }
    Ok(Findings {
        method: METHOD.to_owned(),
        tables: vec![table],
        targets,
        figures: vec![("pulley", Box::new(chart))],
        ..Findings::default()
    })
}

const METHOD: &str = "A trial is a wearer in a machine on the 150 mm base whose cables run over swivelling guide pulleys, or \
    whose two cables of each point have ends 5 mm apart, and poses to 45° of tilt and ±30° of torsion, noise within \
    ±0.1 mm. The lengths come from the virtual wearer's own cables, the bound from differences of those (Cramér-Rao, with \
    tolerances as priors); the identification knows pulleys and ends. Wrong is beyond 5 σ + 0.05 mm.";

/// Whether the centre was accepted, and its bound, mm.
fn trial(random: &mut ChaCha8Rng, case: &Case, known: &KnownMachine, poses: usize) -> Option<(Option<Accepted>, f64)> {
    let stated = &known.double;
    let error_mm = case.tolerance.map(|tolerance| tolerance.base_mm);
    let built = known.as_built(error_mm, random.random()).ok()?;
    let arm = FittedArm::new(&built, symmetric_vector(random, 20.0), symmetric_vector(random, 10.0));
    let cables = Cables::new(&built);
    let rotations: Vec<_> = (0..poses).map(|_| Reach::USUAL.rotation(random)).collect();
    let home_mm = stated.drum().home_length_mm;
    let readings: Vec<[f64; CABLES]> = rotations
        .iter()
        .map(|rotation| {
            let lengths = cables.lengths_mm(&arm.ends_mm().map(|end| arm.centre_mm() + rotation * end));
            let read = |k: usize| match built.correction() {
                Some(truth) => home_mm[k] + truth.scale[k] * (lengths[k] - home_mm[k]) + truth.offset_mm[k],
                None => lengths[k],
            };
            std::array::from_fn(|k| read(k) + symmetric(random, NOISE_MM))
        })
        .collect();
    let expected = Expected::new(stated, &arm, &rotations, NOISE_SIGMA_MM, stated.tolerance())?;
    let [x, y, z, ..] = expected.parameters;
    let rig = RigFile::of(*stated);
    Some((identify(&rig, &readings, arm.centre_mm()), Vector3::new(x, y, z).norm()))
}

impl Case {
    /// The machine as it is stated.
    fn machine(&self) -> Result<KnownMachine, RigError> {
        let drawn = Rig::shoulder(150.0)?;
        let home = FittedArm::new(&drawn, Vector3::zeros(), Vector3::zeros());
        let base = *Cables::new(&drawn).base_mm();
        let platform = drawn.platform_mm();
        let middle = (platform[0] + platform[1] + platform[2]) / 3.0;
        let half = self.apart_mm / 2.0;
        let cable = |k: usize| {
            // Each end moves along its ring, towards where the cable goes.
            let end = platform[k / 2];
            let to_end = home.ends_mm()[k] + home.centre_mm() - base[k];
            let along_base = tangent(&base[k], &to_end);
            // {P} has its z axis away from the base as {B} has: what is left in the one is left in the other.
            let turn = if k.is_multiple_of(2) { -1.0 } else { 1.0 };
            let along_platform = Vector3::z().cross(&(end - middle)).normalize() * turn;
            CableEnds {
                base_mm: base[k] + along_base * half,
                end_mm: end + along_platform * half,
                pulley: Pulley { radius_mm: self.pulley_mm, axis: Vector3::z() },
            }
        };
        let rig = Rig::with_cables(std::array::from_fn(cable), *drawn.drum(), NOISE_SIGMA_MM, *drawn.nominal())?;
        let rig = rig.with_tolerance(self.tolerance.unwrap_or(Tolerance::exact()))?;
        let single = rig_file::in_precision::<f32>(&rig)?;
        Ok(KnownMachine::built_in(rig, single))
    }
}

/// The unit vector along the ring through `point` about the z axis, on the side of `towards`.
fn tangent(point: &Vector3<f64>, towards: &Vector3<f64>) -> Vector3<f64> {
    let along = Vector3::z().cross(point).normalize();
    along * along.dot(towards).signum()
}
