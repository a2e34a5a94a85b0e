//! The messages of `glenoid.dbc` by name and field, for tests against other codecs and for display.

pub mod parameters;
#[cfg(feature = "random")]
mod random;

#[cfg(feature = "random")]
pub use random::{KINDS, random_message};

use glenoid::can::health::{BusHealth, LastStop, StopText};
use glenoid::can::hinge::{HingeAngle, HingeAxis, HingePlace, Module};
use glenoid::can::identity::{Identity, Naming};
use glenoid::can::message::Message;
use glenoid::can::report::{LeftOut, OutcomeReport, PoseReport, PoseSamples, RawLength};
use glenoid::can::result::{Axis, MotionPart, Parameter, Quality, VerificationReport, WeakDirection, ZeroError};
use glenoid::can::status::{Answer, Counters, Fault, Heartbeat, Versions};
use glenoid::can::watch::WatchReport;
use glenoid::procedure::PoseSet;

/// A field of a message: its name in the DBC and its physical value. Flags are 0 and 1, codes their numbers; a value
/// that is missing is 0, and the flag beside it says so.
pub type Field = (&'static str, f64);

/// The message's name in the DBC, and its fields in the order of the DBC.
pub fn fields(message: &Message) -> (&'static str, Vec<Field>) {
    match message {
        Message::Answer(m) => ("Answer", answer(m)),
        Message::Heartbeat(m) => ("Heartbeat", heartbeat(m)),
        Message::Fault(m) => ("Fault", fault(m)),
        Message::Pose(m) => ("Pose", pose(m)),
        Message::Outcome(m) => ("Outcome", outcome(m)),
        Message::CandidateCentre(m) => ("CandidateCentre", parameter("axis", m)),
        Message::CandidateRadius(m) => ("CandidateRadius", parameter("end_point", m)),
        Message::Quality(m) => ("Quality", quality(m)),
        Message::Verification(m) => ("Verification", verification(m)),
        Message::WeakDirection(m) => ("WeakDirection", weak_direction(m)),
        Message::LeftOut(m) => ("LeftOut", left_out(m)),
        Message::Axis(m) => ("Axis", axis(m)),
        Message::LiveCentre(m) => ("LiveCentre", parameter("axis", m)),
        Message::LiveRadius(m) => ("LiveRadius", parameter("end_point", m)),
        Message::RawLength(m) => ("RawLength", raw_length(m)),
        Message::Versions(m) => ("Versions", versions(m)),
        Message::Counters(m) => ("Counters", counters(m)),
        Message::BusHealth(m) => ("BusHealth", bus_health(m)),
        Message::LastStop(m) => ("LastStop", last_stop(m)),
        Message::StopText(m) => ("StopText", stop_text(m)),
        Message::CandidateZero(m) => ("CandidateZero", zero(m)),
        Message::LiveZero(m) => ("LiveZero", zero(m)),
        Message::CandidateMotion(m) => ("CandidateMotion", motion(m)),
        Message::LiveMotion(m) => ("LiveMotion", motion(m)),
        Message::PoseSamples(m) => ("PoseSamples", pose_samples(m)),
        Message::Watch(m) => ("Watch", watch(m)),
        Message::Identity(m) => ("Identity", identity(m)),
        Message::CandidateNaming(m) => ("CandidateNaming", naming(m)),
        Message::LiveNaming(m) => ("LiveNaming", naming(m)),
        Message::Module(m) => ("Module", module(m)),
        Message::CandidateHingeAxis(m) => ("CandidateHingeAxis", hinge_axis(m)),
        Message::CandidateHingePlace(m) => ("CandidateHingePlace", hinge_place(m)),
        Message::LiveHingeAxis(m) => ("LiveHingeAxis", hinge_axis(m)),
        Message::LiveHingePlace(m) => ("LiveHingePlace", hinge_place(m)),
        Message::HingeAngle(m) => ("HingeAngle", hinge_angle(m)),
        // Multiplexed: what is in them depends on one of their fields, and their own tests look at it.
        Message::Parameter(_) => ("Parameter", Vec::new()),
        Message::LiveSet(_) => ("LiveSet", Vec::new()),
        Message::Telemetry(_) => ("Telemetry", Vec::new()),
    }
}

fn run_id(id: u16) -> Field {
    ("run_id", f64::from(id))
}

fn answer(m: &Answer) -> Vec<Field> {
    vec![
        ("opcode", m.opcode.into()),
        ("code", m.code.code().into()),
        ("nonce", m.nonce.into()),
        run_id(m.run_id),
        ("detail", m.detail.into()),
    ]
}

fn heartbeat(m: &Heartbeat) -> Vec<Field> {
    vec![
        run_id(m.run_id),
        ("state", m.state.code().into()),
        ("guidance", m.guidance.code().into()),
        ("poses", m.poses.into()),
        ("progress", m.progress_percent.into()),
        ("held_phase", m.flags.held_phase.into()),
        ("reason", m.reason.code().into()),
        ("live", m.flags.live.into()),
        ("still", m.flags.still.into()),
        ("encoders", m.flags.encoders.into()),
        ("button", m.flags.button.into()),
        ("unacknowledged", m.flags.unacknowledged.into()),
        ("by_command_only", m.flags.by_command_only.into()),
        ("standing", m.standing.code().into()),
        ("sequence", m.sequence.into()),
    ]
}

fn fault(m: &Fault) -> Vec<Field> {
    vec![
        run_id(m.run_id),
        ("code", m.code.code().into()),
        ("cable", m.cable.into()),
        ("active", m.active.into()),
        ("count", m.count.into()),
    ]
}

fn pose(m: &PoseReport) -> Vec<Field> {
    vec![
        run_id(m.run_id),
        ("index", m.index.into()),
        ("reason", m.reason.code().into()),
        ("guidance", m.guidance.code().into()),
        ("held_out", (m.set == PoseSet::HeldOut).into()),
        ("predicted_sigma_known", m.sigma_mm.is_some().into()),
        ("distance_known", m.distance_deg.is_some().into()),
        ("predicted_sigma", m.sigma_mm.unwrap_or(0.0).into()),
        ("distance", m.distance_deg.unwrap_or(0.0).into()),
    ]
}

fn outcome(m: &OutcomeReport) -> Vec<Field> {
    vec![
        run_id(m.run_id),
        ("reason", m.reason.code().into()),
        ("pose", m.pose.unwrap_or(0).into()),
        ("cable", m.cable.into()),
        ("live", m.live.into()),
        ("pose_known", m.pose.is_some().into()),
        ("size_known", m.size_mm.is_some().into()),
        ("poses", m.poses.into()),
        ("size", m.size_mm.unwrap_or(0.0).into()),
    ]
}

fn parameter(index: &'static str, m: &Parameter) -> Vec<Field> {
    vec![run_id(m.run_id), (index, m.index.into()), ("value", m.value_mm.into()), ("sigma", m.sigma_mm.into())]
}

fn quality(m: &Quality) -> Vec<Field> {
    vec![
        run_id(m.run_id),
        ("deviation", m.deviation_mm.into()),
        ("noise", m.noise_mm.into()),
        ("iterations", m.iterations.into()),
        ("left_out", m.left_out.into()),
    ]
}

fn verification(m: &VerificationReport) -> Vec<Field> {
    vec![
        run_id(m.run_id),
        ("deviation", m.deviation_mm.into()),
        ("limit", m.limit_mm.into()),
        ("poses", m.poses.into()),
    ]
}

fn weak_direction(m: &WeakDirection) -> Vec<Field> {
    let names = ["weak_x", "weak_y", "weak_z", "weak_p1", "weak_p2", "weak_p3"];
    std::iter::once(run_id(m.run_id)).chain(names.into_iter().zip(m.direction.map(f64::from))).collect()
}

fn left_out(m: &LeftOut) -> Vec<Field> {
    vec![
        run_id(m.run_id),
        ("index", m.index.into()),
        ("of", m.of.into()),
        ("pose", m.pose.into()),
        ("cables", m.cables.into()),
    ]
}

fn axis(m: &Axis) -> Vec<Field> {
    std::iter::once(run_id(m.run_id))
        .chain(["axis_x", "axis_y", "axis_z"].into_iter().zip(m.axis.map(f64::from)))
        .collect()
}

fn raw_length(m: &RawLength) -> Vec<Field> {
    vec![
        run_id(m.run_id),
        ("index", m.index.into()),
        ("cable", m.cable.into()),
        ("held_out", (m.set == PoseSet::HeldOut).into()),
        ("length", m.length_mm.into()),
    ]
}

fn pose_samples(m: &PoseSamples) -> Vec<Field> {
    vec![
        run_id(m.run_id),
        ("index", m.index.into()),
        ("held_out", (m.set == PoseSet::HeldOut).into()),
        ("samples", m.samples.into()),
    ]
}

fn versions(m: &Versions) -> Vec<Field> {
    let [major, minor, patch] = m.firmware;
    vec![
        ("protocol", m.protocol.into()),
        ("major", major.into()),
        ("minor", minor.into()),
        ("patch", patch.into()),
        ("reset_cause", m.reset_cause.code().into()),
        ("capacity", m.capacity.into()),
        ("rig", m.rig.into()),
    ]
}

fn counters(m: &Counters) -> Vec<Field> {
    vec![
        ("foreign", m.foreign.into()),
        ("malformed", m.malformed.into()),
        ("overruns", m.overruns.into()),
        ("unsendable", m.unsendable.into()),
    ]
}

fn bus_health(m: &BusHealth) -> Vec<Field> {
    vec![
        ("bus_off", m.bus_off.into()),
        ("dropped", m.dropped.into()),
        ("transmit_errors", m.transmit_errors.into()),
        ("receive_errors", m.receive_errors.into()),
        ("error_passive", m.error_passive.into()),
    ]
}

fn last_stop(m: &LastStop) -> Vec<Field> {
    vec![
        ("reset_cause", m.cause.code().into()),
        ("text_len", m.text_len.into()),
        ("line", m.line.into()),
        ("address", m.address.into()),
    ]
}

fn stop_text(m: &StopText) -> Vec<Field> {
    let names = ["c1", "c2", "c3", "c4", "c5", "c6", "c7"];
    let characters = names.into_iter().zip(m.text).map(|(name, character)| (name, f64::from(character)));
    [("index", m.index.into())].into_iter().chain(characters).collect()
}

fn zero(m: &ZeroError) -> Vec<Field> {
    vec![
        run_id(m.run_id),
        ("cable", m.cable.into()),
        ("offset", m.value_mm.into()),
        ("offset_sigma", m.sigma_mm.into()),
    ]
}

fn motion(m: &MotionPart) -> Vec<Field> {
    let values = ["motion_x", "motion_y", "motion_z"].into_iter().zip(m.values().map(f64::from));
    [run_id(m.run_id), ("part", m.part.into())].into_iter().chain(values).collect()
}

fn module(m: &Module) -> Vec<Field> {
    vec![
        ("joint", m.joint.code().into()),
        ("cables_in_use", m.cables.into()),
        ("capacity", m.capacity.into()),
        ("held_out_capacity", m.held_out_capacity.into()),
        ("rig_whole", m.rig.into()),
    ]
}

fn hinge_axis(m: &HingeAxis) -> Vec<Field> {
    vec![
        run_id(m.run_id),
        ("hinge_index", m.index.into()),
        ("direction", m.value.into()),
        ("direction_sigma", m.sigma.into()),
    ]
}

fn hinge_place(m: &HingePlace) -> Vec<Field> {
    vec![
        run_id(m.run_id),
        ("hinge_index", m.index.into()),
        ("place", m.value_mm.into()),
        ("place_sigma", m.sigma_mm.into()),
    ]
}

fn hinge_angle(m: &HingeAngle) -> Vec<Field> {
    vec![
        run_id(m.run_id),
        ("clock", m.time_ms.into()),
        ("angle", m.angle_rad.into()),
        ("angle_residual", m.residual_mm.into()),
    ]
}

fn identity(m: &Identity) -> Vec<Field> {
    vec![("serial", m.serial.into()), ("boot", m.boot.into()), ("wearer", m.wearer.into())]
}

fn naming(m: &Naming) -> Vec<Field> {
    vec![run_id(m.run_id), ("boot", m.boot.into()), ("wearer", m.wearer.into()), ("checksum", m.checksum.into())]
}

fn watch(m: &WatchReport) -> Vec<Field> {
    let moved = ["moved_x", "moved_y", "moved_z"].into_iter().zip(m.moved_mm.map(f64::from));
    [run_id(m.run_id), ("cause", m.cause.code().into()), ("cable", m.cable.into())].into_iter().chain(moved).collect()
}
