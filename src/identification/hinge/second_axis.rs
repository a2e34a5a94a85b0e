//! A joint that is no hinge: does a second axis explain it, and how far does it turn about that?
//!
//! The second axis stands at a right angle to the first, next to it, and is fixed in the platform (the forearm's own axis,
//! or the one about which a carrying angle changes). From each of some directions the hinge is fitted anew together with
//! the second axis' direction and place, two angles eliminated in every pose; the best is taken.

use super::fit::{Equations, Fit};
use super::joint::{ALONG, FOOT_IN_PLATFORM, HINGE_UNKNOWNS, Hinge, about, across};
use super::pose::{HingePose, MAX_UNKNOWNS, PoseAt, PoseRows};
use super::rig::MAX_CABLES;
use crate::linear_algebra::{non_negative_root, packed_index, unit};
use crate::scalar::Real;
use nalgebra::Vector3;

/// Directions that are begun from, over half a turn.
const DIRECTIONS: usize = 8;
/// Gauss-Newton rounds for each.
const ROUNDS: usize = 15;
/// Rounds for the two angles of a pose in each.
const TURNS: usize = 3;
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
#[derive(Clone, Copy, Debug)]
pub(super) struct SecondAxis<T> {
    pub axis_in_platform: Vector3<T>,
    /// Standard deviation of the angle about it, less what noise makes, rad.
    pub size_rad: T,
    /// Squares that are left, mm².
    pub squares_mm2: T,
}

/// A hinge with a second axis.
#[derive(Clone, Debug)]
struct TwoAxes<T: Real> {
    hinge: Hinge<T>,
    second: Vector3<T>,
    /// A point of the second axis in the platform, mm: it crosses the first there at first.
    point_mm: Vector3<T>,
}

/// The search for a second axis in poses that refuse a hinge, under way.
#[derive(Clone, Debug)]
pub(super) struct SecondAxisSearch<T: Real> {
    /// The direction that it is begun from, the round there, and the pose in that.
    direction: usize,
    round: usize,
    pose: usize,
    /// Rounds for that pose's angles so far.
    turns: usize,
    model: TwoAxes<T>,
    /// Of the round, mm².
    squares_mm2: T,
    /// Variances of the poses' second angles for a noise of 1 mm, summed.
    angle_noise: T,
    best: Option<SecondAxis<T>>,
}

impl<T: Real> SecondAxisSearch<T> {
    /// Beside the present hinge.
    pub fn new(fit: &Fit<T>) -> Self {
        Self {
            direction: 0,
            round: 0,
            pose: 0,
            turns: 0,
            model: TwoAxes::beside(fit, 0),
            squares_mm2: T::zero(),
            angle_noise: T::zero(),
            best: None,
        }
    }

    /// One slice: a round for the angles of a pose, or a step; the best axis at the end.
    pub fn advance(
        &mut self,
        fit: &Fit<T>,
        equations: &mut Equations<T>,
        poses: &mut [HingePose<T>],
    ) -> Option<Option<SecondAxis<T>>> {
        if let Some(pose) = poses.get_mut(self.pose) {
            if self.turns < TURNS {
                if self.turns == 0 && self.round == 0 {
                    (pose.trial_rad, pose.second_rad) = (pose.angle_rad, T::zero());
                }
                self.model.turn(fit, pose);
                self.turns += 1;
            } else {
                if self.pose == 0 {
                    equations.clear(ALL_UNKNOWNS);
                    (self.squares_mm2, self.angle_noise) = (T::zero(), T::zero());
                }
                self.add(fit, equations, pose);
                (self.pose, self.turns) = (self.pose + 1, 0);
            }
            return None;
        }
        (self.pose, self.turns) = (0, 0);
        if self.round < ROUNDS && self.model.step(equations) {
            self.round += 1;
            return None;
        }
        self.keep(fit, poses);
        (self.round, self.direction) = (0, self.direction + 1);
        self.model = TwoAxes::beside(fit, self.direction);
        (self.direction >= DIRECTIONS).then(|| self.best.take())
    }

    /// Adds a pose's equations, both angles eliminated.
    fn add(&mut self, fit: &Fit<T>, equations: &mut Equations<T>, pose: &HingePose<T>) {
        let (mut rows, _, across) = self.model.rows(fit, pose);
        let by_angle = rows.by_angle;
        rows.eliminate(&by_angle, ALL_UNKNOWNS);
        rows.eliminate(&across, ALL_UNKNOWNS);
        for (row, residual) in rows.jacobian.iter().zip(&rows.residual_mm) {
            equations.add_row(row, *residual);
            self.squares_mm2 += *residual * *residual;
        }
        let information = across.iter().fold(T::zero(), |sum, d| sum + *d * *d);
        self.angle_noise += T::one() / information.max(T::of(1e-9));
    }

    /// Keeps what this direction led to, if it is the best so far.
    fn keep(&mut self, fit: &Fit<T>, poses: &[HingePose<T>]) {
        let squares_mm2 = self.squares_mm2;
        let is_better = self.best.as_ref().is_none_or(|best| squares_mm2 < best.squares_mm2);
        if !(squares_mm2.is_a_number() && is_better) {
            return;
        }
        let count = T::of_integer(poses.len().max(1) as i32);
        let mean = poses.iter().fold(T::zero(), |sum, pose| sum + pose.second_rad) / count;
        let square = |pose: &HingePose<T>| (pose.second_rad - mean) * (pose.second_rad - mean);
        let variance = poses.iter().fold(T::zero(), |sum, pose| sum + square(pose)) / count;
        let noise = self.angle_noise / count * fit.noise_mm * fit.noise_mm;
        let size_rad = non_negative_root(variance - noise);
        self.best = Some(SecondAxis { axis_in_platform: self.model.second, size_rad, squares_mm2 });
    }
}

impl<T: Real> TwoAxes<T> {
    /// The second axis across the hinge's, in one of the directions.
    fn beside(fit: &Fit<T>, direction: usize) -> Self {
        let ends = fit.machine.end_mm().get(..fit.machine.cables()).unwrap_or(&[]);
        let middle = ends.iter().fold(Vector3::zeros(), |sum, end| sum + end) / T::of_integer(ends.len().max(1) as i32);
        let d = fit.hinge.axis_in_platform();
        let point_mm = fit.hinge.foot_in_platform_mm() + d * d.dot(&middle);
        let [f1, f2] = across(&d);
        let (sin, cos) =
            (T::pi() * T::of_integer(direction as i32) / T::of_integer(DIRECTIONS as i32)).sine_and_cosine();
        Self { hinge: fit.hinge, second: f1 * cos + f2 * sin, point_mm }
    }

    /// One damped Gauss-Newton step; false where the equations have no solution.
    fn step(&mut self, equations: &mut Equations<T>) -> bool {
        for k in 0..ALL_UNKNOWNS {
            let diagonal = equations.matrix().get(packed_index(k, k)).copied();
            equations.add_to_entry(k, k, diagonal.unwrap_or_else(T::one) * T::of(DAMPING) + T::of(1e-9));
        }
        let is_solved = equations.factor().is_ok();
        if is_solved {
            self.take(&equations.step());
        }
        is_solved
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

    /// Moves both angles of a pose towards their best.
    fn turn(&self, fit: &Fit<T>, pose: &mut HingePose<T>) {
        let limited = |step: T| step.max(-T::of(MAX_STEP)).min(T::of(MAX_STEP));
        let dot =
            |a: &[T; MAX_CABLES], b: &[T; MAX_CABLES]| a.iter().zip(b).fold(T::zero(), |sum, (a, b)| sum + *a * *b);
        let least = T::of(1e-9);
        let (rows, second, across) = self.rows(fit, pose);
        let second_step = dot(&across, &rows.residual_mm) / dot(&across, &across).max(least);
        let left = dot(&rows.by_angle, &rows.residual_mm) - dot(&rows.by_angle, &second) * second_step;
        pose.second_rad += limited(second_step);
        pose.trial_rad += limited(left / dot(&rows.by_angle, &rows.by_angle).max(least));
    }

    /// The equations of a pose, the derivative with the second angle, and what of that the first angle leaves.
    fn rows(&self, fit: &Fit<T>, pose: &HingePose<T>) -> (PoseRows<T>, [T; MAX_CABLES], [T; MAX_CABLES]) {
        let turn = about(&self.second, pose.second_rad);
        let end_mm = fit.machine.end_mm().map(|end| self.point_mm + turn * (end - self.point_mm));
        let at = PoseAt { end_mm: &end_mm, ..PoseAt::new(&self.hinge, &fit.machine) };
        let mut rows = at.rows(&pose.lengths_mm, pose.trial_rad, false);
        let d = self.hinge.axis_in_platform();
        let [f1, f2] = across(&d);
        let mut second = [T::zero(); MAX_CABLES];
        let third = d.cross(&self.second);
        let stated = fit.machine.end_mm();
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
