//! `cargo rehearse --arm`: a shoulder's, an elbow's and a wrist's board on one bus, and a person with a whole arm.
//!
//! The modules are calibrated from the thorax outwards. What a module's cables show depends on its own joint alone, so that any
//! order gives the same figures; but each module stands on the limb that the one before moves. From the thorax outwards, what
//! is found is at every moment a chain that begins at the base and has no gap: where its last joint is, and how well that is
//! known, can be said at once, and a session that is broken off leaves an arm that is known up to there. The other way round
//! everything found would hang on a limb of which nothing is known until the shoulder is done.

mod ball;
mod bus;
mod chain;
mod elbow;
mod elbow_report;
mod emulated_bus;
mod hinge;
mod lengths;
mod module;
mod person;
mod report;
mod roll_call;

pub use bus::{Bus, InProcessBus};
pub use chain::{Hand, Limb};
pub use elbow::{ElbowWearer, somebodys_elbow};
pub use elbow_report::ElbowReport;
pub use emulated_bus::EmulatedBus;
pub use report::{ArmReport, BallReport};
pub use roll_call::BusFault;

use super::client::{Client, PERIOD_MS};
use super::display::Display;
use super::machine::KnownMachine;
use super::options::{ArmFault, Options};
use super::parameters::become_machine;
use super::report::Status;
use super::session::SETTLE_MS;
use crate::identify::hinge::in_precision;
use crate::study::elbow::scene::{Elbow, HOME_MM, NOISE_MM, NOISE_SIGMA_MM, cables, drawn};
use crate::study::elbow::{ANYBODY, RANGE_RAD};
use crate::wearer::WearerSettings;
use ball::{BallModule, CalibratedBall};
use chain::Chain;
use glenoid::device::Config;
use glenoid::identification::Pose;
use glenoid::identification::arm::{ArmPose, Module};
use glenoid::identification::hinge::{Drawing, HingeRig};
use glenoid::kinematics::CableLengths;
use glenoid::procedure::elbow::ElbowRig;
use glenoid::rig::{ASSUMED_BASE_RADIUS_MM, CABLES, Drum, Rig, RigError, Tolerance};
use hinge::HingeModule;
use module::{ArmModule, name};
use person::Limbs;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use roll_call::roll_call;

/// Postures of the whole arm in which the hand is looked for.
const POSTURES: usize = 3;
/// How long the arm takes from one to the next, ms.
const MOVE_MS: u32 = 1_000;
/// Serial number of a board that does not belong to the arm.
const SPARE: u32 = 999;

/// The whole arm on a bus.
struct Rehearsal<'a> {
    bus: &'a mut dyn Bus,
    shoulder: BallModule,
    elbow: HingeModule,
    wrist: BallModule,
    limbs: Limbs,
    options: &'a Options,
    display: &'a Display,
}

/// Rehearses an arm on a bus that has no boards yet.
pub fn rehearse_arm(bus: &mut dyn Bus, options: &Options, display: &Display) -> ArmReport {
    let mut report = ArmReport::empty(options);
    let rehearsed = Rehearsal::new(bus, options, display).and_then(|mut rehearsal| rehearsal.go_through(&mut report));
    match rehearsed {
        Err(reason) => report.failed(reason),
        Ok(()) => {
            report.status = if report.reasons.is_empty() { Status::Right } else { Status::Wrong };
            report
        }
    }
}

impl<'a> Rehearsal<'a> {
    /// The arm of somebody, on boards that are made its modules.
    fn new(bus: &'a mut dyn Bus, options: &'a Options, display: &'a Display) -> Result<Self, String> {
        let seeded = |stream: u64| {
            let mut random = ChaCha8Rng::seed_from_u64(options.seed);
            random.set_stream(stream);
            random
        };
        let text = |error: RigError| error.text().to_owned();
        let tolerance = if options.machine_tolerance { Tolerance::hand_built() } else { Tolerance::exact() };
        let told = |rig: Rig<f64>| rig.with_tolerance(tolerance).map_err(text).and_then(KnownMachine::told);
        let shoulder = told(Rig::shoulder(ASSUMED_BASE_RADIUS_MM).map_err(text)?)?;
        let wrist = told(Rig::wrist().map_err(text)?)?;
        let drum = Drum { home_length_mm: [HOME_MM[0]; CABLES], ..*shoulder.double.drum() };
        let (elbow, rig) = elbow_and_rig(&mut seeded(1), shoulder.single.drum(), tolerance)?;
        let is_straight = options.arm_fault == Some(ArmFault::Straight);
        let elbow = ElbowWearer::new(elbow, &drum, NOISE_MM, is_straight, seeded(2));
        let module = ArmModule::new(Module::Elbow, Config::for_rig(rig).parameters)?;
        let rehearsal = Self {
            bus,
            shoulder: BallModule::new(Module::Shoulder, shoulder, 0, options.wearer(), options)?,
            elbow: HingeModule::new(module, 1, elbow, options)?,
            wrist: BallModule::new(Module::Wrist, wrist, 2, wrist_of(options), options)?,
            limbs: Limbs::new(&mut seeded(3)),
            options,
            display,
        };
        rehearsal.plugged_in()
    }

    /// Plugs the boards in, each alone at the identifiers of a new board, and makes it its module.
    fn plugged_in(self) -> Result<Self, String> {
        let modules = &[&self.shoulder.module, &self.elbow.module, &self.wrist.module].map(ArmModule::clone);
        let counts = [self.shoulder.counts(), self.elbow.counts(), self.wrist.counts()];
        for (module, counts) in modules.iter().zip(counts) {
            let machine = its_machine(module, modules, self.options);
            furnish(self.bus, module, machine, module.serial, counts, self.display)?;
        }
        let [shoulder, _, wrist] = modules;
        match self.options.arm_fault {
            Some(ArmFault::Missing) => self.bus.unplug(2),
            Some(ArmFault::Twice) => {
                furnish(self.bus, wrist, shoulder, SPARE, counts[2], self.display)?;
            }
            _ => {}
        }
        let stage = self.display.stage("roll call");
        roll_call(self.bus, modules).map_err(|fault| fault.to_string())?;
        stage.done("three boards, each with its module's rig");
        Ok(self)
    }

    fn go_through(&mut self, report: &mut ArmReport) -> Result<(), String> {
        let shoulder = self.ball(Module::Shoulder, report)?;
        self.display.stage(name(Module::Elbow)).done("");
        let elbow = self.elbow.calibrate(self.bus, self.display).map_err(|reason| format!("the elbow: {reason}"))?;
        report.reasons.extend(elbow.report.objections());
        report.elbow = Some(elbow.report.clone());
        let wrist = self.ball(Module::Wrist, report)?;
        let chain = Chain::new(&shoulder, &elbow, &wrist, self.limbs.stated());
        let limbs = chain.limbs(self.limbs.lengths_mm(&self.shoulder, &self.elbow, &self.wrist));
        let titles = ["upper arm", "forearm"];
        report.reasons.extend(titles.iter().zip(&limbs).filter_map(|(title, limb)| limb.objection(title)));
        report.limbs = Some(limbs);
        let stage = self.display.counted("postures of the arm", POSTURES as u64);
        for done in 1..=POSTURES {
            let posture = self.take_a_posture()?;
            let hand = chain.hand(&posture, &self.limbs.hand_mm(&self.shoulder, &self.elbow, &self.wrist))?;
            report.reasons.extend(hand.objection());
            report.hand.push(hand);
            stage.reached(done as u64, "");
        }
        stage.done("the hand through all three modules");
        Ok(())
    }

    fn ball(&mut self, which: Module, report: &mut ArmReport) -> Result<CalibratedBall, String> {
        self.display.stage(name(which)).done("");
        let ball = if which == Module::Shoulder { &mut self.shoulder } else { &mut self.wrist };
        let of_module = |reason: String| format!("the {}: {reason}", name(which));
        let calibrated = ball.calibrate(self.bus, self.display).map_err(of_module)?;
        report.reasons.extend(calibrated.report.reasons.iter().cloned().map(of_module));
        report.balls.push(BallReport {
            module: which,
            base_id: ball.module.base.raw(),
            serial: ball.module.serial,
            rehearsal: calibrated.report.clone(),
        });
        Ok(calibrated)
    }

    /// Moves all joints at once, and reads the lengths of all boards.
    fn take_a_posture(&mut self) -> Result<ArmPose<f32>, String> {
        let ways = [
            self.shoulder.move_on(MOVE_MS, PERIOD_MS),
            self.elbow.move_on(MOVE_MS, PERIOD_MS),
            self.wrist.move_on(MOVE_MS, PERIOD_MS),
        ];
        let steps = (MOVE_MS + SETTLE_MS) / PERIOD_MS;
        for step in 0..steps as usize {
            for (board, way) in ways.iter().enumerate() {
                if let Some(counts) = way.get(step).or(way.last()) {
                    self.bus.set_counts(board, counts);
                }
            }
            self.bus.pass(PERIOD_MS).map_err(|error| error.to_string())?;
        }
        let [l1, l2, l3, l4, ..] = lengths::lengths_mm(self.bus, &self.elbow.module)?;
        Ok(ArmPose {
            shoulder: six(lengths::lengths_mm(self.bus, &self.shoulder.module)?)?,
            elbow_mm: [l1, l2, l3, l4],
            wrist: six(lengths::lengths_mm(self.bus, &self.wrist.module)?)?,
        })
    }
}

fn six(lengths_mm: [f32; CABLES]) -> Result<Pose<f32>, String> {
    CableLengths::new(lengths_mm).map(Pose::new).map_err(|error| error.fault.text().to_owned())
}

/// Whose machine a module's board is told: its own, unless elbow and wrist are exchanged.
fn its_machine<'m>(module: &'m ArmModule, all: &'m [ArmModule; 3], options: &Options) -> &'m ArmModule {
    let [_, elbow, wrist] = all;
    match (options.arm_fault, module.which) {
        (Some(ArmFault::Swapped), Module::Elbow) => wrist,
        (Some(ArmFault::Swapped), Module::Wrist) => elbow,
        _ => module,
    }
}

/// Plugs a new board in and makes it a module, with the machine of `machine`. Boards are numbered in the order of their coming.
fn furnish(
    bus: &mut dyn Bus,
    module: &ArmModule,
    machine: &ArmModule,
    serial: u32,
    counts: [i32; CABLES],
    display: &Display,
) -> Result<(), String> {
    let of_module = |error: &dyn std::error::Error| format!("the {}: {error}", name(module.which));
    let board = bus.join(serial).map_err(|error| of_module(&error))?;
    let mut place = bus::Place::new(bus, board);
    let mut client = Client::new(&mut place, counts);
    become_machine(&mut client, &module.parameters(machine)?, display).map_err(|error| of_module(&error))?;
    Ok(())
}

/// Somebody's elbow in the default rig, which is off by its tolerance, and the rig with what a drawing for anybody says.
fn elbow_and_rig(
    random: &mut ChaCha8Rng,
    drums: &Drum<f32>,
    tolerance: Tolerance<f64>,
) -> Result<(Elbow, ElbowRig), String> {
    let text = |error: RigError| error.text().to_owned();
    let rig = HingeRig::new(&cables(), NOISE_SIGMA_MM).and_then(|rig| rig.with_tolerance(tolerance, HOME_MM));
    let drawing = Drawing { hinge: drawn(), sigma: Some(ANYBODY), range_rad: RANGE_RAD };
    let rig = rig.map_err(text)?.with_drawing(drawing);
    let elbow = somebodys_elbow(random, &rig, &tolerance).ok_or("the elbow's rig has no drawing")?;
    let single = in_precision::<f32>(&rig).map_err(text)?;
    let rig = ElbowRig::new(
        single.cables(),
        Drum { home_length_mm: [HOME_MM[0] as f32; CABLES], ..*drums },
        single.length_noise_mm(),
        *single.tolerance(),
        single.drawing().copied(),
    );
    Ok((elbow, rig.map_err(text)?))
}

/// The wrist of the same person: it is smaller, and turns less.
fn wrist_of(options: &Options) -> WearerSettings {
    WearerSettings {
        seed: options.seed.wrapping_add(1 << 32),
        tilt_rad: 30f64.to_radians(),
        torsion_rad: 20f64.to_radians(),
        centre_offset_mm: 4.0,
        cuff_offset_mm: 3.0,
        ..options.wearer()
    }
}
