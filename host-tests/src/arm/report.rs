//! What `cargo arm` prints: one object as JSON, or the same for people.

use crate::identify::report::Status;
use crate::identify::wording::fixed;
use glenoid::identification::arm::{ArmPosition, Module, Segments};
use glenoid::identification::carried_point::CarriedPoint;
use serde::Serialize;
use std::fmt::Write as _;

/// A point in the shoulder's base.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Point {
    /// Where, mm.
    pub at_mm: [f64; 3],
    /// 1σ along each axis, mm.
    pub sigma_mm: [f64; 3],
    /// Covariance xx, xy, xz, yy, yz, zz, mm².
    pub covariance_mm2: [f64; 6],
}

/// The length of a limb.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Segment {
    /// Length, mm.
    pub length_mm: f64,
    /// 1σ, mm.
    pub sigma_mm: f64,
}

/// The pose that would help most.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FurtherPose {
    /// The elbow's lengths in it, mm: those of a row of its log.
    pub elbow_mm: Vec<f64>,
    /// The hand's σ before and with it, root of the summed variances, mm.
    pub hand_sigma_mm: [f64; 2],
}

/// The outcome. What is not known is `null`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ArmReport {
    /// How it ended.
    pub status: Status,
    /// The module that was refused: `shoulder`, `elbow`, `wrist`.
    pub module: Option<&'static str>,
    /// Why.
    pub reason: Option<&'static str>,
    /// The elbow's axis next to the middle of its base.
    pub elbow: Option<Point>,
    /// The wrist's centre.
    pub wrist: Option<Point>,
    /// The hand.
    pub hand: Option<Point>,
    /// What shoulder, elbow, wrist and the mounts add to the hand's σ, mm.
    pub hand_sigma_by_module_mm: Option<[f64; 4]>,
    /// One more pose of the elbow that would make that smallest.
    pub most_useful_pose: Option<FurtherPose>,
    /// From the shoulder's centre to the elbow's axis.
    pub upper_arm: Option<Segment>,
    /// From the elbow's axis to the wrist's centre.
    pub forearm: Option<Segment>,
}

impl Point {
    fn of(point: &CarriedPoint<f64>) -> Self {
        let c = &point.covariance_mm2;
        Self {
            at_mm: point.at_mm.into(),
            sigma_mm: point.sigma_mm().into(),
            covariance_mm2: [c.m11, c.m12, c.m13, c.m22, c.m23, c.m33],
        }
    }
}

impl ArmReport {
    /// Of an arm that is identified.
    pub fn accepted(
        position: &ArmPosition<f64>,
        segments: &Segments<f64>,
        most_useful_pose: Option<FurtherPose>,
    ) -> Self {
        let segment = |(length_mm, sigma_mm)| Some(Segment { length_mm, sigma_mm });
        Self {
            status: Status::Accepted,
            module: None,
            reason: None,
            elbow: Some(Point::of(&position.elbow)),
            wrist: Some(Point::of(&position.wrist)),
            hand: Some(Point::of(&position.hand)),
            hand_sigma_by_module_mm: Some(position.by_module_mm),
            most_useful_pose,
            upper_arm: segment(segments.upper_arm_mm),
            forearm: segment(segments.forearm_mm),
        }
    }

    /// A module was refused.
    pub fn refused(module: Module, reason: &'static str) -> Self {
        let module = match module {
            Module::Shoulder => "shoulder",
            Module::Elbow => "elbow",
            Module::Wrist => "wrist",
        };
        Self {
            status: Status::Refused,
            module: Some(module),
            reason: Some(reason),
            elbow: None,
            wrist: None,
            hand: None,
            hand_sigma_by_module_mm: None,
            most_useful_pose: None,
            upper_arm: None,
            forearm: None,
        }
    }

    /// The same for people.
    pub fn text(&self) -> String {
        let mut text = String::new();
        if let (Some(module), Some(reason)) = (self.module, self.reason) {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "REFUSED: the {module}: {reason}");
            let _ =
                writeln!(text, "  remedy          cargo identify -- LOG --rig RIG.toml of this module says what to do");
            return text;
        }
        let _ = writeln!(text, "ACCEPTED: the whole arm, in the shoulder's base");
        for (name, point) in [("elbow", &self.elbow), ("wrist", &self.wrist), ("hand", &self.hand)] {
            let Some(point) = point else { continue };
            let list = |numbers: &[f64; 3]| numbers.map(|number| fixed(number, 2)).join(", ");
            let _ = writeln!(text, "  {name:16}{} mm (1 sigma {})", list(&point.at_mm), list(&point.sigma_mm));
        }
        for (name, segment) in [("upper arm", &self.upper_arm), ("forearm", &self.forearm)] {
            let Some(segment) = segment else { continue };
            let (length, sigma) = (fixed(segment.length_mm, 1), fixed(segment.sigma_mm, 2));
            let _ = writeln!(text, "  {name:16}{length} mm long (1 sigma {sigma})");
        }
        if let Some([shoulder, elbow, wrist, mounts]) =
            self.hand_sigma_by_module_mm.map(|all| all.map(|mm| fixed(mm, 2)))
        {
            let _ = writeln!(
                text,
                "  hand's sigma    shoulder {shoulder}, elbow {elbow}, wrist {wrist}, mounts {mounts} mm"
            );
        }
        if let Some(FurtherPose { elbow_mm, hand_sigma_mm: [now, then] }) = &self.most_useful_pose {
            let lengths: Vec<_> = elbow_mm.iter().map(|length| fixed(*length, 0)).collect();
            let (now, then) = (fixed(*now, 2), fixed(*then, 2));
            let _ = writeln!(
                text,
                "  one more pose   of the elbow with cables of {} mm: hand's sigma {then} instead of {now} mm",
                lengths.join(", ")
            );
        }
        text
    }
}
