//! What `cargo arm` prints: one object as JSON, or the same for people.

use super::posture::Contradiction;
use crate::identify::report::Status;
use crate::identify::summary::line;
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

/// What further poses of a module would do to the hand's σ.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModulePoses {
    /// The module: `shoulder`, `elbow`, `wrist`.
    pub module: &'static str,
    /// The hand's σ before and with all of them, root of the summed variances, mm.
    pub hand_sigma_mm: [f64; 2],
    /// The poses, each the best one after those before it.
    pub poses: Vec<ModulePose>,
}

/// A further pose of a module.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModulePose {
    /// What its encoders will read there, mm.
    pub lengths_mm: Vec<f64>,
    /// The hand's σ with it and those before it, mm.
    pub hand_sigma_mm: f64,
}

/// The pose of the elbow that would help most.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FurtherPose {
    /// The elbow's lengths in it, mm.
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
    /// What to do.
    pub remedy: Option<String>,
    /// How the lengths of the posture contradict the module, if they do.
    pub posture: Option<Contradiction>,
    /// The elbow's axis next to the middle of its base.
    pub elbow: Option<Point>,
    /// The wrist's centre.
    pub wrist: Option<Point>,
    /// The hand.
    pub hand: Option<Point>,
    /// What shoulder, elbow, wrist and the mounts add to the hand's σ, mm.
    pub hand_sigma_by_module_mm: Option<[f64; 4]>,
    /// The share of each of the four in the sum of the hand's variances, 0 to 1.
    pub hand_share_by_module: Option<[f64; 4]>,
    /// One more pose of the elbow that would make the hand's σ smallest.
    pub most_useful_pose: Option<FurtherPose>,
    /// The same for all modules, some poses each: the module first whose poses help most.
    pub further_poses: Vec<ModulePoses>,
    /// From the shoulder's centre to the elbow's axis.
    pub upper_arm: Option<Segment>,
    /// From the elbow's axis to the wrist's centre.
    pub forearm: Option<Segment>,
}

/// A module's name.
pub fn name(module: Module) -> &'static str {
    match module {
        Module::Shoulder => "shoulder",
        Module::Elbow => "elbow",
        Module::Wrist => "wrist",
    }
}

impl FurtherPose {
    fn of(further: &[ModulePoses]) -> Option<Self> {
        let elbow = further.iter().find(|poses| poses.module == name(Module::Elbow))?;
        let first = elbow.poses.first()?;
        Some(Self { elbow_mm: first.lengths_mm.clone(), hand_sigma_mm: [elbow.hand_sigma_mm[0], first.hand_sigma_mm] })
    }
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
        mut further_poses: Vec<ModulePoses>,
    ) -> Self {
        further_poses.sort_by(|one, other| one.hand_sigma_mm[1].total_cmp(&other.hand_sigma_mm[1]));
        let variances = position.by_module_mm.map(|mm| mm * mm);
        let all: f64 = variances.iter().sum();
        let segment = |(length_mm, sigma_mm)| Some(Segment { length_mm, sigma_mm });
        Self {
            status: Status::Accepted,
            module: None,
            reason: None,
            remedy: None,
            posture: None,
            elbow: Some(Point::of(&position.elbow)),
            wrist: Some(Point::of(&position.wrist)),
            hand: Some(Point::of(&position.hand)),
            hand_sigma_by_module_mm: Some(position.by_module_mm),
            hand_share_by_module: Some(variances.map(|variance| variance / all)),
            most_useful_pose: FurtherPose::of(&further_poses),
            further_poses,
            upper_arm: segment(segments.upper_arm_mm),
            forearm: segment(segments.forearm_mm),
        }
    }

    /// The lengths of the posture contradict a module.
    pub fn contradicted(module: Module, contradiction: Contradiction, remedy: String) -> Self {
        let reason = "the lengths of the posture contradict the joint that the log shows";
        Self { posture: Some(contradiction), ..Self::refused(module, reason, remedy) }
    }

    /// A module was refused.
    pub fn refused(module: Module, reason: &'static str, remedy: String) -> Self {
        Self {
            status: Status::Refused,
            module: Some(name(module)),
            reason: Some(reason),
            remedy: Some(remedy),
            posture: None,
            elbow: None,
            wrist: None,
            hand: None,
            hand_sigma_by_module_mm: None,
            hand_share_by_module: None,
            most_useful_pose: None,
            further_poses: Vec::new(),
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
            if let Some(posture) = &self.posture {
                let _ = line(&mut text, "seen", &posture.seen());
            }
            let _ = line(&mut text, "remedy", self.remedy.as_deref().unwrap_or_default());
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
        if let (Some(sigmas), Some(shares)) = (self.hand_sigma_by_module_mm, self.hand_share_by_module) {
            let parts = ["shoulder", "elbow", "wrist", "mounts"].iter().zip(sigmas.iter().zip(&shares));
            let parts: Vec<_> = parts
                .map(|(part, (sigma, share))| format!("{part} {} ({} %)", fixed(*sigma, 2), fixed(share * 100.0, 0)))
                .collect();
            let _ = writeln!(text, "  hand's sigma    {} mm (of its variance)", parts.join(", "));
        }
        for ModulePoses { module, hand_sigma_mm: [now, then], poses } in &self.further_poses {
            let (now, then) = (fixed(*now, 2), fixed(*then, 2));
            let _ = writeln!(
                text,
                "  {} more poses    of the {module}: hand's sigma {then} instead of {now} mm; its lengths, and the sigma then",
                poses.len()
            );
            for pose in poses {
                let lengths: Vec<_> = pose.lengths_mm.iter().map(|length| fixed(*length, 0)).collect();
                let _ = writeln!(text, "                  {}: {}", lengths.join(", "), fixed(pose.hand_sigma_mm, 2));
            }
        }
        text
    }
}
