//! A joint that is no hinge: does a second axis explain it, and how far does it turn about that?
//!
//! The second axis stands at a right angle to the first, next to it, and is fixed in the platform (the forearm's own axis,
//! or the one about which a carrying angle changes). From each of some directions the hinge is fitted anew together with
//! the second axis' direction and place, two angles eliminated in every pose; the best is taken.

use super::fit::{Equations, Fit};
use super::joint::{ALONG, FOOT_IN_PLATFORM, HINGE_UNKNOWNS, Hinge, about, across};
use super::pose::{HingePose, MAX_UNKNOWNS, PoseAt, PoseRows};
use super::rig::MAX_CABLES;
use crate::linear_algebra::{non_negative_root, unit};
use crate::scalar::Real;
use nalgebra::Vector3;

/// Directions that are begun from, over half a turn.
const DIRECTIONS: usize = 8;
/// Gauss-Newton rounds for each.
const ROUNDS: usize = 15;
/// Unknowns of the second axis beside the hinge's: its direction about the first (rad), its place along the first and
/// across both (mm).
pub(super) const SECOND_UNKNOWNS: usize = 3;
const ALL_UNKNOWNS: usize = HINGE_UNKNOWNS + SECOND_UNKNOWNS;
/// Largest step of the place, mm.
const MAX_MOVE_MM: f64 = 20.0;
/// Damping, relative: where the second angle's zero stands is not determined.
const DAMPING: f64 = 1e-3;
/// Largest step of an angle, rad.
const MAX_STEP: f64 = 0.2;

/// The second axis that explains the poses best.
pub(super) struct SecondAxis<T> {
    pub axis_in_platform: Vector3<T>,
    /// Standard deviation of the angle about it, less what noise makes, rad.
    pub size_rad: T,
    /// Squares that are left, mm².
    pub squares_mm2: T,
}

/// A hinge with a second axis.
struct TwoAxes<'a, T: Real> {
    fit: &'a Fit<T>,
    hinge: Hinge<T>,
    second: Vector3<T>,
    /// A point of the second axis in the platform, mm: it crosses the first there at first.
    point_mm: Vector3<T>,
}

/// Fits a second axis to poses that refuse a hinge.
pub(super) fn find<T: Real>(fit: &Fit<T>, poses: &mut [HingePose<T>]) -> Option<SecondAxis<T>> {
    let ends = fit.machine.end_mm().get(..fit.machine.cables())?;
    let middle = ends.iter().fold(Vector3::zeros(), |sum, end| sum + end) / T::of_integer(ends.len().max(1) as i32);
    let d = fit.hinge.axis_in_platform();
    let point_mm = fit.hinge.foot_in_platform_mm() + d * d.dot(&middle);
    let [f1, f2] = across(&d);
    let mut best: Option<SecondAxis<T>> = None;
    for k in 0..DIRECTIONS {
        let (sin, cos) = (T::pi() * T::of_integer(k as i32) / T::of_integer(DIRECTIONS as i32)).sin_cos();
        let mut model = TwoAxes { fit, hinge: fit.hinge, second: f1 * cos + f2 * sin, point_mm };
        let found = model.minimise(poses);
        let better = |best: &SecondAxis<T>| found.squares_mm2 < best.squares_mm2;
        if found.squares_mm2.is_a_number() && best.as_ref().is_none_or(better) {
            best = Some(found);
        }
    }
    best
}

impl<T: Real> TwoAxes<'_, T> {
    fn minimise(&mut self, poses: &mut [HingePose<T>]) -> SecondAxis<T> {
        for pose in poses.iter_mut() {
            (pose.trial_rad, pose.second_rad) = (pose.angle_rad, T::zero());
        }
        let (mut squares, mut angle_noise) = (T::zero(), T::zero());
        for round in 0..=ROUNDS {
            let mut equations = Equations::new(ALL_UNKNOWNS);
            (squares, angle_noise) = (T::zero(), T::zero());
            for pose in poses.iter_mut() {
                let (mut rows, across) = self.best_angles(pose);
                let by_angle = rows.by_angle;
                rows.eliminate(&by_angle, ALL_UNKNOWNS);
                rows.eliminate(&across, ALL_UNKNOWNS);
                for (row, residual) in rows.jacobian.iter().zip(&rows.residual_mm) {
                    equations.add_row(row, *residual);
                    squares += *residual * *residual;
                }
                let information = across.iter().fold(T::zero(), |sum, d| sum + *d * *d);
                angle_noise += T::one() / information.max(T::of(1e-9));
            }
            if round == ROUNDS {
                break;
            }
            for k in 0..ALL_UNKNOWNS {
                let diagonal = equations.matrix().get(crate::linear_algebra::packed_index(k, k)).copied();
                equations.add_to_entry(k, k, diagonal.unwrap_or_else(T::one) * T::of(DAMPING) + T::of(1e-9));
            }
            if equations.factor().is_err() {
                break;
            }
            self.take(&equations.step());
        }
        let count = T::of_integer(poses.len().max(1) as i32);
        let mean = poses.iter().fold(T::zero(), |sum, pose| sum + pose.second_rad) / count;
        let square = |pose: &HingePose<T>| (pose.second_rad - mean) * (pose.second_rad - mean);
        let variance = poses.iter().fold(T::zero(), |sum, pose| sum + square(pose)) / count;
        let noise = angle_noise / count * self.fit.noise_mm * self.fit.noise_mm;
        SecondAxis {
            axis_in_platform: self.second,
            size_rad: non_negative_root(variance - noise),
            squares_mm2: squares,
        }
    }

    fn take(&mut self, step: &[T; MAX_UNKNOWNS]) {
        self.hinge = self.hinge.moved(step);
        let [turn, along, across] = [0, 1, 2].map(|k| step.get(HINGE_UNKNOWNS + k).copied().unwrap_or_else(T::zero));
        let limited = |move_mm: T| move_mm.max(-T::of(MAX_MOVE_MM)).min(T::of(MAX_MOVE_MM));
        let d = self.hinge.axis_in_platform();
        // The direction goes with the hinge, at a right angle to it.
        let second = unit(&(self.second - d * d.dot(&self.second)));
        let third = d.cross(&second);
        self.second = unit(&(second + third * turn.max(-T::of(MAX_STEP)).min(T::of(MAX_STEP))));
        self.point_mm += d * limited(along) + third * limited(across);
    }

    /// Moves both angles of a pose to their best, and gives its equations there with the derivative of the second angle
    /// that the first leaves.
    fn best_angles(&self, pose: &mut HingePose<T>) -> (PoseRows<T>, [T; MAX_CABLES]) {
        let limited = |step: T| step.max(-T::of(MAX_STEP)).min(T::of(MAX_STEP));
        for _ in 0..3 {
            let (rows, second, across) = self.rows(pose);
            let dot =
                |a: &[T; MAX_CABLES], b: &[T; MAX_CABLES]| a.iter().zip(b).fold(T::zero(), |sum, (a, b)| sum + *a * *b);
            let least = T::of(1e-9);
            let second_step = dot(&across, &rows.residual_mm) / dot(&across, &across).max(least);
            let left = dot(&rows.by_angle, &rows.residual_mm) - dot(&rows.by_angle, &second) * second_step;
            pose.second_rad += limited(second_step);
            pose.trial_rad += limited(left / dot(&rows.by_angle, &rows.by_angle).max(least));
        }
        let (rows, _, across) = self.rows(pose);
        (rows, across)
    }

    /// The equations of a pose, the derivative with the second angle, and what of that the first angle leaves.
    fn rows(&self, pose: &HingePose<T>) -> (PoseRows<T>, [T; MAX_CABLES], [T; MAX_CABLES]) {
        let turn = about(&self.second, pose.second_rad);
        let end_mm = self.fit.machine.end_mm().map(|end| self.point_mm + turn * (end - self.point_mm));
        let at = PoseAt { end_mm: &end_mm, ..PoseAt::new(&self.hinge, &self.fit.machine) };
        let mut rows = at.rows(&pose.lengths_mm, pose.trial_rad, false);
        let d = self.hinge.axis_in_platform();
        let [f1, f2] = across(&d);
        let mut second = [T::zero(); MAX_CABLES];
        let third = d.cross(&self.second);
        let stated = self.fit.machine.end_mm();
        for (((by_second, row), end), stated) in second.iter_mut().zip(&mut rows.jacobian).zip(&end_mm).zip(stated) {
            let of = |k: usize| row.get(k).copied().unwrap_or_else(T::zero);
            // The cable's direction in the platform, from what a shift of its foot point does.
            let cable = d * of(ALONG) - f1 * of(FOOT_IN_PLATFORM) - f2 * of(FOOT_IN_PLATFORM + 1);
            let (arm, turned) = (stated - self.point_mm, end - self.point_mm);
            *by_second = cable.dot(&self.second.cross(&turned));
            // The axis turned about the hinge's, and moved.
            let motions = [d.cross(&turned) - turn * d.cross(&arm), d - turn * d, third - turn * third];
            for (entry, motion) in row.iter_mut().skip(HINGE_UNKNOWNS).zip(&motions) {
                *entry = cable.dot(motion);
            }
        }
        let own = rows.by_angle.iter().fold(T::zero(), |sum, d| sum + *d * *d).max(T::of(1e-9));
        let mixed = rows.by_angle.iter().zip(&second).fold(T::zero(), |sum, (a, b)| sum + *a * *b);
        let mut left = second;
        left.iter_mut().zip(&rows.by_angle).for_each(|(left, d)| *left -= *d * mixed / own);
        (rows, second, left)
    }
}
