//! The whole board without hardware: events in, actions out. The boards and the host tests drive this very type.
//!
//! A board calls [`Device::handle`] with
//! * [`Event::PowerUp`] once, before anything else: what became of the record;
//! * [`Event::Tick`] about every millisecond, and again as soon as it has time while [`Device::is_busy`];
//! * [`Event::Counts`] with every sample of the six encoders, also when nothing moves: silence is a fault;
//! * [`Event::Button`] with the contact's level at every change (bounces are welcome) or at every sample;
//! * [`Event::Can`] with every frame received, [`Event::ReceiveOverrun`] when it lost some;
//! * [`Event::Stored`] after every [`Action::Store`], [`Event::ParametersStored`] after every [`Action::StoreParameters`]
//!   and [`Action::EraseRecord`], [`Event::JournalFailed`] after an [`Action::Journal`] that failed;
//! * [`Event::Bus`] when the CAN controller's counters have changed;
//!
//! and carries out the actions in order; what is to be stored may take its time ([`Storage`](crate::record::Storage)), and
//! frames wait meanwhile, so that whoever gets the next answer can rely on what was stored. One event never causes more than
//! [`MAX_FRAMES`] frames.

mod answered;
pub mod button;
mod button_commands;
mod commands;
mod control_set;
mod faults;
mod fingerprint;
mod kept;
mod left_out;
mod live;
mod live_joint;
mod lock;
mod log_entry;
mod numbering;
mod outgoing;
mod parameters;
mod persistence;
mod report;
mod requests;
mod seal;
mod sets;
mod shown;
mod slip_monitor;
pub mod snapshot;
mod status;
pub mod status_led;
mod turns;

pub use crate::parameters::Config;
pub use button::{Held, Press};
pub use control_set::{CONTROL_WORDS, ControlSet, PublishedControlSet};
pub use fingerprint::{fingerprint, module_fingerprint};
pub use log_entry::LogEntry;
pub use status_led::BlinkPattern;

use crate::can::command::Request;
use crate::can::health::BusHealth;
use crate::can::hinge::HingeAngle;
use crate::can::status::{Answer, Counters, Versions};
use crate::can::{BaseId, Frame, ParameterAnswer, ParameterRequest};
use crate::kinematics::PlatformSolver;
use crate::parameters::ParameterSet;
use crate::procedure::elbow::{ElbowProcedure, ElbowRig};
use crate::procedure::{ModuleProcedure, ModuleRig, Procedure, Reason, StateName};
use crate::record::{JointRecord, JournalEntry, Loaded, StoreError, Stored};
use crate::restart::{CrashRecord, ResetCause};
use crate::rig::{CABLES, Rig};
use answered::Answered;
use button::Button;
use button_commands::ConfirmingPresses;
use commands::Asked;
use faults::FaultReporter;
use lock::Lock;
use numbering::Numbering;
use parameters::Saving;
use persistence::Persistence;
use report::Reporter;
use seal::seal_of_rig;
use sets::{OutgoingLive, OutgoingTelemetry, TelemetryInWork};
use slip_monitor::SlipMonitor;
use status::Pace;

/// Most frames that one event causes, all at once: the answer to a capture; two poses (held and asked for by the button), or a
/// heartbeat with the identity, or two frames of a report; a pose that the button asked for in vain; a fault with what the slip
/// monitor says of it; one of each set. Usually none or one.
pub const MAX_FRAMES: usize = 8;

/// What happens to the board.
// A record is ten times the size of the rest. It comes once, by value: there is no heap to box it on.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// The board has looked into its flash.
    PowerUp(Loaded),
    /// Time has passed.
    Tick,
    /// A sample of the six encoder counts, extended to 32 bits.
    Counts([i32; CABLES]),
    /// The level of the button's contact.
    Button {
        /// It is pressed.
        down: bool,
    },
    /// A frame came in, from whomever and for whomever.
    Can(Frame),
    /// The board could not keep up and lost this many frames.
    ReceiveOverrun {
        /// Frames lost; 1 when the board cannot tell.
        lost: u16,
    },
    /// The record was stored, or why not.
    Stored(Result<(), StoreError>),
    /// The parameters were stored or the record was erased, or why not.
    ParametersStored(Result<(), StoreError>),
    /// The journal could not be written.
    JournalFailed(StoreError),
    /// How the CAN controller fares.
    Bus(BusHealth),
}

impl Event {
    /// What the device is to hear of something that was stored; None if nothing.
    pub fn of(stored: Stored) -> Option<Self> {
        match stored {
            Stored::Record(result) => Some(Self::Stored(result)),
            Stored::Parameters(result) | Stored::Erased(result) => Some(Self::ParametersStored(result)),
            Stored::Journal(result) => result.err().map(Self::JournalFailed),
        }
    }
}

/// What the board shall do.
// As with the events.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Action {
    /// Send a frame.
    Send(Frame),
    /// Show a pattern on the status LED from now on.
    StatusLed(BlinkPattern),
    /// Replace the record by this one, then say how that went. It is of the rig that the device was made for.
    Store(JointRecord),
    /// Append this to the journal; say so only if that fails.
    Journal(JournalEntry),
    /// Replace the stored parameters by these, then say how that went.
    StoreParameters(ParameterSet),
    /// Erase the record, then say how that went, as after a store of the parameters.
    EraseRecord,
    /// Start anew, and say this cause then: the parameters have changed, or memory cannot be trusted any more.
    Stop(ResetCause),
    /// Note something in the log.
    Log(LogEntry),
}

/// The drive board's calibration, whole.
#[derive(Debug, Clone)]
pub struct Device {
    base: BaseId,
    /// Fingerprint of the rig.
    fingerprint: u32,
    versions: Versions,
    crash_record: Option<CrashRecord>,
    bus: BusHealth,
    counters: Counters,
    procedure: ModuleProcedure,
    button: Button,
    reporter: Reporter,
    pace: Pace,
    encoder_fault: FaultReporter,
    button_fault: FaultReporter,
    overrun: FaultReporter,
    unsendable: FaultReporter,
    persistence: Persistence,
    record_fault: FaultReporter,
    bus_off: FaultReporter,
    restarted: FaultReporter,
    slip_monitor: SlipMonitor,
    /// The centre in use is to be stored.
    keep_is_due: bool,
    /// A slice of the computing waited in the last tick.
    computing_waited: bool,
    slip: FaultReporter,
    /// The firmware stopped before this start, and nobody has asked about it yet.
    restart_is_news: bool,
    /// A repeated command is answered again and not obeyed again.
    answered: Answered<Request, Answer, 40>,
    /// Who asked for the pose that is being captured, if somebody did.
    capture_asked: Option<Asked>,
    /// Starts of this board, this one included.
    boot: u32,
    serial: u32,
    /// Motion or a person has confirmed the centre in use since power-up.
    confirmed: bool,
    /// Why the centre in use is not to be used, for restarts too.
    distrust: Option<Reason>,
    journal_failed: bool,
    journal_fault: FaultReporter,
    /// The last sample of the encoders.
    counts: Option<[i32; CABLES]>,
    /// Of six cables.
    forward_kinematics: Option<PlatformSolver<f32>>,
    live_out: OutgoingLive,
    telemetry_out: OutgoingTelemetry,
    telemetry_in_work: Option<TelemetryInWork>,
    /// Goes out with the next frame of the telemetry.
    angle_out: Option<HingeAngle>,
    /// The state and run in which the press under way began.
    press_began: Option<(StateName, u16)>,
    confirming: ConfirmingPresses,
    /// Checksum of what the procedure goes by, to notice memory that changes.
    constants: u32,
    lock: Lock,
    numbering: Numbering,
    /// The parameters in use, those that are being prepared, and what saving them waits for.
    in_use: ParameterSet,
    prepared: ParameterSet,
    saving: Saving,
    parameters_answered: Answered<ParameterRequest, ParameterAnswer, 40>,
    parameters_wrong: bool,
    parameters_fault: FaultReporter,
}

impl Device {
    /// A device at power-up.
    pub fn new(config: &Config) -> Self {
        match &config.rig {
            ModuleRig::Ball(rig) => Self::of_ball(config, rig),
            ModuleRig::Hinge(rig) => Self::of_hinge(config, rig),
        }
    }

    /// A device at power-up whose joint is a ball. `rig`: that of the configuration.
    // Inlined, as the next two, so that it is built where it stays: 7 KB more of the stack otherwise (`cargo stack`).
    #[inline(always)]
    pub fn of_ball(config: &Config, rig: &Rig<f32>) -> Self {
        let procedure = || ModuleProcedure::Ball(Procedure::new(*rig, config.limits));
        Self::with(config, procedure, Some(PlatformSolver::new(rig)))
    }

    /// A device at power-up whose joint is a hinge. `rig`: that of the configuration.
    #[inline(always)]
    pub fn of_hinge(config: &Config, rig: &ElbowRig) -> Self {
        Self::with(config, || ModuleProcedure::Hinge(ElbowProcedure::with_limits(rig, config.limits)), None)
    }

    #[inline(always)]
    fn with(
        config: &Config,
        procedure: impl FnOnce() -> ModuleProcedure,
        forward_kinematics: Option<PlatformSolver<f32>>,
    ) -> Self {
        let fingerprint = module_fingerprint(&config.rig);
        Self {
            base: config.base,
            fingerprint,
            versions: status::versions(config.restart.cause, fingerprint, &config.rig),
            crash_record: config.restart.crash_record,
            bus: BusHealth::default(),
            counters: Counters::default(),
            procedure: procedure(),
            button: Button::new(),
            reporter: Reporter::at_power_up(),
            pace: Pace::at_power_up(),
            encoder_fault: FaultReporter::new(),
            button_fault: FaultReporter::new(),
            overrun: FaultReporter::new(),
            unsendable: FaultReporter::new(),
            persistence: Persistence::default(),
            record_fault: FaultReporter::new(),
            bus_off: FaultReporter::new(),
            restarted: FaultReporter::new(),
            slip_monitor: SlipMonitor::default(),
            keep_is_due: false,
            computing_waited: false,
            slip: FaultReporter::new(),
            restart_is_news: config.restart.cause.is_fault(),
            answered: Answered::new(),
            capture_asked: None,
            boot: 0,
            serial: config.serial,
            confirmed: false,
            distrust: None,
            journal_failed: false,
            journal_fault: FaultReporter::new(),
            counts: None,
            forward_kinematics,
            live_out: OutgoingLive::every(u32::from(config.live_period_ms)),
            telemetry_out: OutgoingTelemetry::every(sets::period_ms(config.telemetry_hz)),
            telemetry_in_work: None,
            angle_out: None,
            press_began: None,
            confirming: ConfirmingPresses::default(),
            constants: seal_of_rig(&config.rig, &config.limits),
            lock: Lock::new(config.lock_key),
            numbering: Numbering::new(config.numbering_check, config.rig.cables()),
            in_use: config.parameters,
            prepared: config.parameters,
            saving: Saving::Nothing,
            parameters_answered: Answered::new(),
            parameters_wrong: false,
            parameters_fault: FaultReporter::new(),
        }
    }

    /// Handles one event at the time `now_ms` (a clock in milliseconds that may wrap) and hands out what is to be
    /// done. Bounded work: at most one slice of the solver, at most [`MAX_FRAMES`] frames.
    pub fn handle(&mut self, now_ms: u32, event: Event, out: &mut impl FnMut(Action)) {
        let before = self.procedure.state();
        match event {
            Event::PowerUp(loaded) => self.power_up(loaded, out),
            Event::Tick => self.tick(now_ms, out),
            Event::Counts(counts) => {
                let counts = self.counts_in_use(counts);
                self.counts = Some(counts);
                self.numbering.sample(&counts, self.procedure.drum().mm_per_count());
                self.procedure.sample(now_ms, &counts);
                self.monitor_sample(now_ms, &counts, out);
            }
            Event::Button { down } => self.button.level(now_ms, down),
            Event::Can(frame) => self.receive(now_ms, &frame, out),
            Event::ReceiveOverrun { lost } => {
                self.counters.overruns = self.counters.overruns.saturating_add(lost);
                self.overrun.happened(lost);
            }
            Event::Stored(result) => self.stored(result, out),
            Event::ParametersStored(result) => self.parameters_stored(now_ms, result, out),
            Event::JournalFailed(_) => self.journal_failed = true,
            Event::Bus(health) => {
                if health.dropped != self.bus.dropped {
                    self.reporter.spoil();
                }
                self.bus_off.happened(health.bus_off.saturating_sub(self.bus.bus_off));
                self.bus = health;
            }
        }
        let after = self.procedure.state();
        if before != after {
            self.note_transition(now_ms, before, after, out);
        }
    }

    /// Encoders beyond the cables of the rig are not in use, whatever they read.
    fn counts_in_use(&self, mut counts: [i32; CABLES]) -> [i32; CABLES] {
        let unused = counts.iter_mut().skip(self.procedure.cables().into());
        unused.for_each(|count| *count = 0);
        counts
    }

    /// There is computing to do: tick again as soon as there is time.
    pub fn is_busy(&self) -> bool {
        self.procedure.is_busy() || self.slip_monitor.is_busy() || self.keep_is_due
    }

    /// The calibration procedure, to look at.
    pub fn procedure(&self) -> &ModuleProcedure {
        &self.procedure
    }
}
