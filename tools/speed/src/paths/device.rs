//! What an event costs the whole device: calibrations with all poses of the problem, the last five held out, each centre
//! accepted and watched in use; on a machine that is known exactly, with outliers, and on a machine built by hand, with 18
//! unknown constants, of a ball and of a shoulder whose centre moves. Nothing else of the board can delay a control loop that
//! runs beside it by more than the worst of these.

use core::hint::black_box;

use glenoid::can::identity::Naming;
use glenoid::can::{BaseId, Frame, Message, Opcode, Request};
use glenoid::device::{Action, Config, Device, Event, LogEntry, MAX_FRAMES};
use glenoid::identification::Machine;
use glenoid::kinematics::CableLengths;
use glenoid::procedure::{Limits, Settings, StateName};
use glenoid::record::LoadError;
use glenoid::rig::{CABLES, Rig, Tolerance};
use heapless::Vec;

use crate::counter;
use crate::measure::Figures;
use crate::problem::{POSES, Problem, Spoilt, of_shoulder};
use crate::stack;

/// Time between two samples of the encoders, and between two ticks of a device that has nothing to compute, ms.
const SAMPLE_MS: u32 = 10;
/// Samples that the arm takes from pose to pose.
const MOVE_SAMPLES: i32 = 60;
/// How long it is held in a pose, ms.
const HOLD_MS: u32 = 600;
/// Of the problem's poses so many are held out.
const VERIFICATION_POSES: usize = 5;
/// Longer than a set takes to be solved, and its report to be sent, ms.
const SOLVING_MS: u32 = 2_000;
/// Most slices of the estimator between two samples: so many fit into the time.
const TICKS_A_SAMPLE: usize = 100;

/// What the paths are called.
const NAMES: [&str; 3] = ["device-tick", "device-sample", "device-frame"];

/// A device and what its events have cost.
struct Bench<'a> {
    device: &'a mut Device,
    counts: [i32; CABLES],
    now_ms: u32,
    figures: [Figures; NAMES.len()],
    identified: bool,
    nonce: u16,
    /// By what the value found is accepted.
    naming: Option<Naming>,
}

/// The costs by the kind of event; `None` when the centre was not accepted in the end.
#[inline(never)]
pub fn costs(problem: &Problem<f32>) -> Option<[(&'static str, Figures); NAMES.len()]> {
    let by_hand = problem.rig.with_tolerance(Tolerance::hand_built()).ok()?;
    let mut figures = [Figures::default(); NAMES.len()];
    let cases = [(problem.rig, Spoilt::No), (problem.rig, Spoilt::Outliers(10)), (by_hand, Spoilt::Noise)];
    for (rig, spoilt) in cases {
        add_costs(&rig, &problem.spoilt(spoilt)?, &mut figures)?;
    }
    add_costs(&by_hand, &of_shoulder(problem, &Machine::new(&by_hand))?, &mut figures)?;
    let named = |kind: usize| (NAMES[kind], figures[kind]);
    Some([named(0), named(1), named(2)])
}

/// Adds what a calibration costs.
#[inline(never)]
fn add_costs(
    rig: &Rig<f32>,
    poses: &Vec<CableLengths<f32>, POSES>,
    figures: &mut [Figures; NAMES.len()],
) -> Option<()> {
    let settings = Settings {
        enough_poses: (poses.len() - VERIFICATION_POSES) as u8,
        verification_poses: VERIFICATION_POSES as u8,
        // As far apart as the problem's poses happen to be.
        nearest_pose_rad: 0.003,
        collecting_timeout_ms: u32::MAX / 2,
        ..Settings::default()
    };
    let limits = Limits::new(rig, settings).ok()?;
    let mut device = Device::new(&Config { limits, ..Config::for_rig(*rig) });
    let device = black_box(&mut device);
    let mut added = None;
    // From the device's own depth on: its frame is not part of what it takes.
    let stack_bytes = stack::used_by(&mut || added = Bench::calibrate(device, rig, poses));
    for (figures, added) in figures.iter_mut().zip(added?) {
        figures.counts += added.counts;
        figures.ticks = figures.ticks.wrapping_add(added.ticks);
        figures.worst = figures.worst.max(added.worst);
        figures.stack_bytes = figures.stack_bytes.max(stack_bytes);
        figures.state_bytes = size_of::<Device>();
    }
    Some(())
}

impl Bench<'_> {
    #[inline(never)]
    fn calibrate(device: &mut Device, rig: &Rig<f32>, poses: &[CableLengths<f32>]) -> Option<[Figures; NAMES.len()]> {
        let counts = encoder_counts(rig, poses.first()?);
        let figures = [Figures::default(); NAMES.len()];
        let mut bench = Bench { device, counts, now_ms: 0, figures, identified: false, nonce: 0, naming: None };
        bench.event(Event::PowerUp(Err(LoadError::Nothing).into()));
        bench.hold(HOLD_MS);
        bench.command(Opcode::Start);
        for pose in poses {
            bench.move_to(encoder_counts(rig, pose));
            bench.hold(HOLD_MS);
            // Once more, by command: it is refused after the same search.
            if matches!(bench.state(), StateName::Collecting | StateName::Verifying) {
                bench.command(Opcode::Capture);
            }
            if bench.state() == StateName::Identifying {
                bench.hold(SOLVING_MS);
            }
        }
        // The report goes out.
        bench.hold(SOLVING_MS);
        bench.accept()?;
        let accepted = bench.identified && bench.device.procedure().live().is_some();
        // In use, and watched.
        for pose in poses.iter().take(5) {
            bench.move_to(encoder_counts(rig, pose));
        }
        accepted.then_some(bench.figures)
    }

    fn state(&self) -> StateName {
        self.device.procedure().state()
    }

    /// Time passes: a tick with every sample, and more while there is something to compute.
    fn hold(&mut self, ms: u32) {
        for _ in 0..ms / SAMPLE_MS {
            self.now_ms += SAMPLE_MS;
            self.event(Event::Counts(self.counts));
            self.event(Event::Tick);
            for _ in 0..TICKS_A_SAMPLE {
                if !self.device.is_busy() {
                    break;
                }
                self.event(Event::Tick);
            }
        }
    }

    fn move_to(&mut self, counts: [i32; CABLES]) {
        let from = self.counts;
        for step in 1..=MOVE_SAMPLES {
            for (cable, now) in self.counts.iter_mut().enumerate() {
                *now = from[cable] + (counts[cable] - from[cable]) * step / MOVE_SAMPLES;
            }
            self.hold(SAMPLE_MS);
        }
    }

    fn command(&mut self, opcode: Opcode) {
        self.nonce += 1;
        let run_id = if opcode == Opcode::Start { 0 } else { self.device.procedure().run_id() };
        let request = Request { opcode: opcode as u8, boot: 0, nonce: self.nonce, run_id, argument: 0 };
        self.event(Event::Can(request.pack(BaseId::DEFAULT.command())));
    }

    /// Accepts the value that was shown.
    fn accept(&mut self) -> Option<()> {
        self.nonce += 1;
        let request = Request::naming(Opcode::Accept, self.nonce, &self.naming?);
        self.event(Event::Can(request.pack(BaseId::DEFAULT.command())));
        Some(())
    }

    #[inline(never)]
    fn event(&mut self, event: Event) {
        let kind = match event {
            Event::Counts(_) => 1,
            Event::Can(_) => 2,
            _ => 0,
        };
        counter::KINDS[kind]();
        let Self { device, now_ms, identified, naming, .. } = self;
        // Looked at afterwards, so that it is not counted.
        let mut sent = Vec::<Frame, MAX_FRAMES>::new();
        let mut out = |action: Action| {
            *identified |= matches!(action, Action::Log(LogEntry::Identified { .. }));
            if let Action::Send(frame) = &action {
                // Never full.
                let _ = sent.push(*frame);
            }
            black_box(&action);
        };
        let (ticks, ()) = counter::ticks_of(|| device.handle(*now_ms, event, &mut out));
        for frame in &sent {
            if let Ok(Message::CandidateNaming(shown)) = Message::unpack(frame, BaseId::DEFAULT) {
                *naming = Some(shown);
            }
        }
        let figures = &mut self.figures[kind];
        figures.counts += 1;
        figures.ticks = figures.ticks.wrapping_add(ticks.into());
        figures.worst = figures.worst.max(ticks);
    }
}

/// What the encoders read with cables of these lengths.
fn encoder_counts(rig: &Rig<f32>, lengths: &CableLengths<f32>) -> [i32; CABLES] {
    let drum = rig.drum();
    let mut counts = [0; CABLES];
    for (cable, count) in counts.iter_mut().enumerate() {
        *count = ((lengths.as_mm()[cable] - drum.home_length_mm[cable]) / drum.mm_per_count()) as i32;
    }
    counts
}
